//! Blackbody radiation. In goes a temperature in kelvin, out comes linear Rec. 709. Invariant: no channel is
//! negative, and luminance grows with temperature.

use super::{Primaries, Rgb, luminance};
use glam::{DMat3, DVec3};

/// Planck's second constant, m K.
const SECOND_CONSTANT: f64 = 1.438_776_877e-2;
/// Visible wavelengths and their step, nm.
const FIRST_NM: f64 = 380.0;
const LAST_NM: f64 = 780.0;
const STEP_NM: f64 = 10.0;

/// Colour of a black body by its temperature, relative to the luminance of one of a reference temperature.
#[derive(Clone, Copy, Debug)]
pub struct Blackbody {
    rec_709_from_xyz: DMat3,
    brightness: Brightness,
}

/// Luminance by temperature.
#[derive(Clone, Copy, Debug)]
enum Brightness {
    /// By Planck's law, times a factor.
    Planck(f64),
    /// By the Stefan-Boltzmann law, relative to the given temperature in kelvin.
    FourthPower(f64),
}

impl Blackbody {
    /// Blackbody with luminance 1 at a temperature in kelvin.
    pub fn of_luminance_1_at(kelvin: f64) -> Self {
        let raw =
            Self { rec_709_from_xyz: xyz_from_rec_709().inverse(), brightness: Brightness::Planck(1.0) };
        Self { brightness: Brightness::Planck(luminance(raw.at(kelvin)).recip()), ..raw }
    }

    /// Blackbody with luminance 1 at a temperature in kelvin, which grows with the fourth power, as in
    /// Blender's Principled Volume.
    pub fn by_fourth_power(kelvin: f64) -> Self {
        Self { brightness: Brightness::FourthPower(kelvin), ..Self::of_luminance_1_at(kelvin) }
    }

    /// Colour at a temperature. Negative channels, of colours outside Rec. 709, become 0.
    pub fn at(&self, kelvin: f64) -> Rgb {
        if kelvin <= 0.0 {
            return Rgb::ZERO;
        }
        let steps = ((LAST_NM - FIRST_NM) / STEP_NM) as usize;
        let xyz: DVec3 = (0..=steps)
            .map(|step| {
                let nm = FIRST_NM + step as f64 * STEP_NM;
                // Relative to 560 nm, to avoid underflow.
                let planck = (nm / 560.0).powi(-5) / (SECOND_CONSTANT / (nm * 1e-9 * kelvin)).exp_m1();
                planck * color_matching(nm)
            })
            .sum();
        let color = self.rec_709_from_xyz * xyz;
        let factor = match self.brightness {
            Brightness::Planck(per_luminance) => per_luminance,
            Brightness::FourthPower(of) => (kelvin / of).powi(4) / luminance(color),
        };
        let color = (factor * color).max(Rgb::ZERO);
        if color.is_finite() { color } else { Rgb::ZERO }
    }
}

fn xyz_from_rec_709() -> DMat3 {
    Primaries::REC_709.xyz_from_rgb().unwrap_or(DMat3::IDENTITY)
}

/// The CIE 1931 standard observer (Wyman, Sloan & Shirley 2013, "Simple analytic approximations to the CIE
/// XYZ color matching functions", eq. 4).
fn color_matching(nm: f64) -> DVec3 {
    let lobe = |height: f64, middle: f64, [below, above]: [f64; 2]| {
        let from = (nm - middle) * if nm < middle { below } else { above };
        height * (-0.5 * from * from).exp()
    };
    DVec3::new(
        lobe(0.362, 442.0, [0.0624, 0.0374])
            + lobe(1.056, 599.8, [0.0264, 0.0323])
            + lobe(-0.065, 501.1, [0.049, 0.0382]),
        lobe(0.821, 568.8, [0.0213, 0.0247]) + lobe(0.286, 530.9, [0.0613, 0.0322]),
        lobe(1.217, 437.0, [0.0845, 0.0278]) + lobe(0.681, 459.0, [0.0385, 0.0725]),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Chromaticities of Planck's locus (CIE 15:2004): 6500 K is (0.3135, 0.3237), 2856 K (illuminant A) is
    /// (0.4476, 0.4074).
    #[test]
    fn colours_are_those_of_the_locus() {
        let xyz_from_rec_709 = xyz_from_rec_709();
        for (kelvin, x, y) in [(6500.0, 0.3135, 0.3237), (2856.0, 0.4476, 0.4074)] {
            let blackbody = Blackbody::of_luminance_1_at(kelvin);
            let color = blackbody.at(kelvin);
            assert!((luminance(color) - 1.0).abs() < 1e-12, "{color}");
            let xyz = xyz_from_rec_709 * color;
            let found = [xyz.x, xyz.y].map(|value| value / xyz.element_sum());
            assert!((found[0] - x).abs() < 3e-3 && (found[1] - y).abs() < 3e-3, "{kelvin}: {found:?}");
        }
    }

    #[test]
    fn hotter_is_brighter_and_nothing_is_negative() {
        let blackbody = Blackbody::of_luminance_1_at(1500.0);
        let mut before = 0.0;
        for kelvin in (0..400).map(|step| 25.0 * f64::from(step)) {
            let color = blackbody.at(kelvin);
            assert!(color.min_element() >= 0.0 && luminance(color) >= before, "{kelvin}: {color}");
            before = luminance(color);
        }
        assert_eq!(blackbody.at(-1.0), Rgb::ZERO);
        // Red loses what would be negative of blue.
        let bright = luminance(Blackbody::by_fourth_power(3000.0).at(6000.0));
        assert!((bright - 16.0).abs() < 1e-9, "{bright}");
        assert_eq!(Blackbody::by_fourth_power(1000.0).at(1.0), Rgb::ZERO);
    }
}
