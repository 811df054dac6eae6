//! Radiance from all sides at a place. In go harmonics of radiance, out comes the light that a lobe gathers.
//! Invariant: that light is never negative.

use super::lobe::Lobe;
use crate::canopy::clumps::Clump;
use crate::canopy::fluence::Peak;
use crate::color::Rgb;
use crate::ordinates::harmonics::COUNT;
use glam::DVec3;

/// Radiance on one side of a leaf, as moments.
pub(super) struct Gathered {
    pub(super) moments: [[f32; COUNT]; 3],
    /// Moments of degree 4.
    pub(super) fourth: [[f32; COUNT]; 3],
    /// Forward peak of each sun.
    pub(super) peaks: Vec<Peak>,
    pub(super) clump: Clump,
}

impl Gathered {
    pub(super) const NOTHING: Self =
        Self { moments: [[0.0; COUNT]; 3], fourth: [[0.0; COUNT]; 3], peaks: Vec::new(), clump: Clump::NONE };
}

/// Radiance on both sides of a leaf. A wood keeps it of a hundred thousand leaves, so it takes half of the
/// memory of two [`Gathered`].
pub(super) struct BothSides {
    sides: [Side; 2],
    peaks: Peaks,
}

/// Forward peaks of all suns. Most scenes have one sun, which needs no list.
enum Peaks {
    One(BothPeaks),
    Several(Box<[BothPeaks]>),
}

/// Moments of one side, by channel.
struct Side {
    channels: [Codes; 3],
    clump: Clump,
}

/// Moments of one channel in 16 bits: up to degree 2, and of degree 4. Rounding changes irradiance by some
/// 3e-5 of the radiance from all sides, a tenth of what half precision rounds away.
struct Codes {
    /// Moment of code 1.
    unit: f32,
    codes: [[i16; COUNT]; 2],
}

/// Forward peak of a sun at both sides.
struct BothPeaks {
    travel: [f32; 3],
    irradiances: [[f32; 3]; 2],
}

impl Codes {
    fn new(moments: [&[f32; COUNT]; 2]) -> Self {
        let largest = moments.iter().flat_map(|moments| moments.iter()).fold(0.0, |m: f32, v| m.max(v.abs()));
        let unit = largest / f32::from(i16::MAX);
        let code = |moment: f32| if unit > 0.0 { (moment / unit).round() as i16 } else { 0 };
        Self { unit, codes: moments.map(|moments| moments.map(code)) }
    }

    /// Sum of the products with a lobe's factors.
    fn product(&self, factors: &[[f32; COUNT]; 2]) -> f64 {
        let products = |(factors, codes): (&[f32; COUNT], &[i16; COUNT])| -> f32 {
            factors.iter().zip(codes).map(|(factor, code)| factor * f32::from(*code)).sum()
        };
        f64::from(self.unit * factors.iter().zip(&self.codes).map(products).sum::<f32>())
    }
}

impl BothSides {
    pub(super) fn new(sides: [Gathered; 2]) -> Self {
        let [front, back] = &sides;
        let single = |color: DVec3| color.as_vec3().to_array();
        let mut peaks = front.peaks.iter().zip(&back.peaks).map(|(front, back)| BothPeaks {
            travel: single(front.travel),
            irradiances: [front, back].map(|peak| single(peak.irradiance)),
        });
        let peaks = match (peaks.len(), peaks.next()) {
            (1, Some(one)) => Peaks::One(one),
            (_, first) => Peaks::Several(first.into_iter().chain(peaks).collect()),
        };
        let sides = sides.map(|side| {
            let Gathered { moments, fourth, clump, .. } = side;
            let channels = [0, 1, 2].map(|channel| Codes::new([&moments[channel], &fourth[channel]]));
            Side { channels, clump }
        });
        Self { sides, peaks }
    }

    /// Light that a lobe gathers on the first side or the other, and the clump there; for a cosine lobe,
    /// irradiance, W/m^2.
    pub(super) fn by(&self, number: usize, lobe: &Lobe) -> (Rgb, Clump) {
        // A leaf's specular lobe uses harmonics up to l = 2 alone.
        let lobe = &if lobe.has_third() { lobe.up_to_second() } else { *lobe };
        let Side { channels, clump } = &self.sides[number];
        let factors = [lobe.of_travel(), lobe.of_fourth_of_travel().unwrap_or([0.0; COUNT])];
        let factors = factors.map(|factors| factors.map(|factor| factor as f32));
        let irradiance = Rgb::from_array([0, 1, 2].map(|channel| channels[channel].product(&factors)));
        let double = |numbers: [f32; 3]| DVec3::from_array(numbers.map(f64::from));
        let peaks = match &self.peaks {
            Peaks::One(one) => std::slice::from_ref(one),
            Peaks::Several(all) => all,
        };
        let peaks = peaks.iter().map(|peak| (double(peak.travel), double(peak.irradiances[number])));
        (with_peaks(irradiance, peaks, lobe), *clump)
    }
}

/// Sum of the light that a lobe gathers by harmonics and from forward peaks, which are each a direction of
/// travel and an irradiance.
pub(super) fn with_peaks(by_harmonics: Rgb, peaks: impl Iterator<Item = (DVec3, Rgb)>, lobe: &Lobe) -> Rgb {
    peaks.fold(by_harmonics.max(Rgb::ZERO), |sum, (travel, irradiance)| {
        sum + lobe.of_peak(travel) * irradiance
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Sampler;

    /// Each code is off by half a unit at most, which is a 32,767th of the largest moment.
    #[test]
    fn codes_gather_what_moments_do() {
        let mut sampler = Sampler::new(1, 0, 0, 0);
        let mut numbers = || -> [f32; COUNT] { std::array::from_fn(|_| sampler.next_1d() as f32 - 0.5) };
        for scale in [1e-9, 1.0, 1e6] {
            let factors = [numbers(), numbers()];
            let moments = [numbers(), numbers()].map(|moments| moments.map(|moment| scale * moment));
            let found = Codes::new([&moments[0], &moments[1]]).product(&factors);
            let (mut exact, mut largest, mut weights) = (0.0, 0.0_f64, 0.0);
            for (moment, factor) in moments.as_flattened().iter().zip(factors.as_flattened()) {
                let [moment, factor] = [*moment, *factor].map(f64::from);
                exact += moment * factor;
                weights += factor.abs();
                largest = largest.max(moment.abs());
            }
            assert!((found - exact).abs() < 2e-5 * weights * largest, "{scale}: {found} {exact}");
        }
        assert_eq!(Codes::new([&[0.0; COUNT]; 2]).product(&[[1.0; COUNT]; 2]), 0.0);
    }
}
