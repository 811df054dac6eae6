//! All fog together: transmittance between two points, and a ray cut into stretches on which the
//! fog's parameters are constant and the light's way through it changes smoothly. Invariant: on a
//! stretch the optical depth to a distant light is linear in `t`, so its ends say everything.

use super::fog_box::LightPlace;
use super::{FogBox, henyey_greenstein};
use crate::color::Rgb;
use crate::math::Ray;
use crate::scene::MOST_FOGS;
use glam::DVec3;

/// Boxes of fog; where they overlap their coefficients add up.
#[derive(Clone, Debug, Default)]
pub struct Medium {
    boxes: Vec<FogBox>,
}

/// Where the light comes from that the fog scatters.
pub type Source = LightPlace;

/// A part of a ray on which everything is smooth.
#[derive(Clone, Copy, Debug)]
pub struct Stretch {
    /// Where it begins, metres.
    pub start: f64,
    /// Where it ends, metres.
    pub end: f64,
    /// Optical depth from the ray's origin to `start`, and growth per metre.
    tau_to_eye: (Rgb, Rgb),
    /// Bit `i` set: inside box `i`.
    inside: u64,
}

impl Medium {
    /// Fog of several boxes.
    pub fn new(boxes: Vec<FogBox>) -> Self {
        debug_assert!(boxes.len() <= MOST_FOGS, "a scene that exists has no more");
        Self { boxes }
    }

    /// The boxes.
    pub fn boxes(&self) -> &[FogBox] {
        &self.boxes
    }

    /// True if there is no fog at all.
    pub fn is_empty(&self) -> bool {
        self.boxes.is_empty()
    }

    /// Optical depth of `origin + t * direction`, `0 < t < t_max`, for a unit direction.
    pub fn optical_depth(&self, origin: DVec3, direction: DVec3, t_max: f64) -> Rgb {
        self.boxes.iter().map(|fog| fog.sigma_t * fog.length(origin, direction, t_max)).sum()
    }

    /// The share of light that gets through (Beer-Lambert).
    pub fn transmittance(&self, origin: DVec3, direction: DVec3, t_max: f64) -> Rgb {
        if self.is_empty() {
            return Rgb::ONE;
        }
        exp_minus(self.optical_depth(origin, direction, t_max))
    }

    /// Optical depth from a point to the light.
    pub fn optical_depth_to(&self, point: DVec3, source: Source) -> Rgb {
        match source {
            LightPlace::Towards(to_light) => self.optical_depth(point, to_light, f64::INFINITY),
            LightPlace::At(position) => {
                let way = position - point;
                let distance = way.length();
                if distance > 0.0 { self.optical_depth(point, way / distance, distance) } else { Rgb::ZERO }
            }
        }
    }

    /// First and last fog on the ray within `[0, t_max]`; `None` if there is none.
    pub fn range(&self, ray: &Ray, t_max: f64) -> Option<(f64, f64)> {
        let mut range: Option<(f64, f64)> = None;
        for fog in &self.boxes {
            let Some((enter, leave)) = fog.span(ray) else { continue };
            let (enter, leave) = (enter.max(0.0), leave.min(t_max));
            if enter < leave {
                range = Some(range.map_or((enter, leave), |(a, b)| (a.min(enter), b.max(leave))));
            }
        }
        range
    }

    /// Cuts the foggy parts of the ray within `[0, t_max]` into smooth stretches, in order.
    pub fn stretches(
        &self,
        ray: &Ray,
        t_max: f64,
        source: Source,
        scratch: &mut Vec<f64>,
        out: &mut Vec<Stretch>,
    ) {
        out.clear();
        let Some((first, last)) = self.range(ray, t_max) else { return };
        let cuts = scratch;
        cuts.clear();
        cuts.extend([first, last]);
        let mut cut = |t: f64| {
            if t > first && t < last {
                cuts.push(t);
            }
        };
        for fog in &self.boxes {
            if let Some((enter, leave)) = fog.span(ray) {
                cut(enter);
                cut(leave);
            }
            fog.for_each_kink(ray, source, &mut cut);
        }
        cuts.sort_unstable_by(f64::total_cmp);
        cuts.dedup();
        let mut tau = Rgb::ZERO;
        for pair in cuts.windows(2) {
            let (start, end) = (pair[0], pair[1]);
            let middle = 0.5 * (start + end);
            let mut inside = 0;
            let mut sigma_t = Rgb::ZERO;
            for (index, fog) in self.boxes.iter().enumerate() {
                if fog.span(ray).is_some_and(|(enter, leave)| enter < middle && middle < leave) {
                    inside |= 1 << index;
                    sigma_t += fog.sigma_t;
                }
            }
            if inside != 0 {
                out.push(Stretch { start, end, tau_to_eye: (tau, sigma_t), inside });
            }
            tau += sigma_t * (end - start);
        }
    }

    /// Light scattered per metre towards the ray's origin per unit of irradiance: `sum(sigma_s * phase)`, 1/(m sr).
    pub fn scattering(&self, stretch: &Stretch, cos_deflection: f64) -> Rgb {
        let mut sum = Rgb::ZERO;
        let mut rest = stretch.inside;
        while rest != 0 {
            let fog = &self.boxes[rest.trailing_zeros() as usize];
            sum += fog.sigma_s * henyey_greenstein(cos_deflection, fog.g);
            rest &= rest - 1;
        }
        sum
    }

    /// As [`Medium::scattering`], at a point that need not lie on a stretch.
    pub fn scattering_at(&self, point: DVec3, cos_deflection: f64) -> Rgb {
        self.boxes
            .iter()
            .filter(|fog| fog.contains(point))
            .map(|fog| fog.sigma_s * henyey_greenstein(cos_deflection, fog.g))
            .sum()
    }

    /// The narrowest phase function on a stretch: the largest `|g|`.
    pub fn sharpest_g(&self, stretch: &Stretch) -> f64 {
        let mut sharpest: f64 = 0.0;
        for (index, fog) in self.boxes.iter().enumerate() {
            if stretch.inside >> index & 1 == 1 {
                sharpest = sharpest.max(fog.g.abs());
            }
        }
        sharpest
    }
}

impl Stretch {
    /// Optical depth from the ray's origin to a `t` on this stretch.
    pub fn tau_to_eye(&self, t: f64) -> Rgb {
        let (at_start, per_m) = self.tau_to_eye;
        at_start + per_m * (t - self.start)
    }
}

/// `exp(-tau)` per channel, computed once where the channels are alike.
pub fn exp_minus(tau: Rgb) -> Rgb {
    if tau.x == tau.y && tau.y == tau.z {
        return Rgb::splat((-tau.x).exp());
    }
    Rgb::new((-tau.x).exp(), (-tau.y).exp(), (-tau.z).exp())
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DAffine3;

    fn fog_between(low: DVec3, high: DVec3, sigma_t: f64) -> FogBox {
        let relative_from_cube =
            DAffine3::from_translation(0.5 * (low + high)) * DAffine3::from_scale(0.5 * (high - low));
        FogBox::new(relative_from_cube, Rgb::splat(sigma_t), Rgb::splat(0.5), 0.3).expect("a real box")
    }

    #[test]
    fn beer_lambert_through_two_overlapping_boxes() {
        let medium = Medium::new(vec![
            fog_between(DVec3::splat(-1.0), DVec3::splat(1.0), 0.5),
            fog_between(DVec3::new(0.0, -1.0, -1.0), DVec3::new(3.0, 1.0, 1.0), 0.2),
        ]);
        let through = medium.transmittance(DVec3::new(-5.0, 0.0, 0.0), DVec3::X, f64::INFINITY);
        assert!((through.x - (-(2.0 * 0.5 + 3.0 * 0.2_f64)).exp()).abs() < 1e-15);
        let part = medium.transmittance(DVec3::ZERO, DVec3::X, 0.5);
        assert!((part.x - (-(0.5 * 0.7_f64)).exp()).abs() < 1e-15);
    }

    #[test]
    fn a_ray_in_a_face_counts_as_inside() {
        let fog = fog_between(DVec3::splat(-1.0), DVec3::splat(1.0), 1.0);
        assert_eq!(fog.length(DVec3::new(-2.0, 1.0, 0.0), DVec3::X, f64::INFINITY), 2.0);
        assert_eq!(fog.length(DVec3::new(-2.0, 1.0 + 1e-12, 0.0), DVec3::X, f64::INFINITY), 0.0);
    }

    /// Within a stretch the optical depth to the sun is linear: the middle is the mean of the ends.
    #[test]
    fn depth_to_a_distant_light_is_linear_on_each_stretch() {
        let medium = Medium::new(vec![
            fog_between(DVec3::splat(-1.0), DVec3::splat(1.0), 0.5),
            fog_between(DVec3::new(0.0, -1.0, -1.0), DVec3::new(3.0, 1.5, 1.0), 0.2),
        ]);
        let source = LightPlace::Towards(DVec3::new(0.3, 0.8, -0.4).normalize());
        let ray =
            Ray { origin: DVec3::new(-3.0, 0.2, 0.3), direction: DVec3::new(1.0, -0.1, -0.15).normalize() };
        let (mut scratch, mut stretches) = (Vec::new(), Vec::new());
        medium.stretches(&ray, 100.0, source, &mut scratch, &mut stretches);
        assert!(stretches.len() >= 4);
        for stretch in &stretches {
            let tau = |t: f64| medium.optical_depth_to(ray.at(t), source).x;
            let inset = 1e-9 * (stretch.end - stretch.start);
            let mean = 0.5 * (tau(stretch.start + inset) + tau(stretch.end - inset));
            let middle = tau(0.5 * (stretch.start + stretch.end));
            assert!((middle - mean).abs() < 1e-8, "{stretch:?}: {middle} {mean}");
        }
        let total = stretches.last().expect("fog").tau_to_eye(stretches.last().expect("fog").end);
        assert!((total - medium.optical_depth(ray.origin, ray.direction, 100.0)).length() < 1e-14);
    }
}
