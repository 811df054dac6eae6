//! Looks of AgX. In goes light on its way to the curve, out comes the same with another contrast. Invariant:
//! middle grey stays, and `None` changes no bit.

use glam::Vec3;
use serde::Deserialize;

/// Look of AgX, with Blender's names.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[cfg_attr(feature = "program", derive(clap::ValueEnum))]
#[non_exhaustive]
pub enum Look {
    /// The curve as it is.
    #[default]
    None,
    /// 1.57 times the contrast.
    VeryHighContrast,
    /// 1.4 times.
    HighContrast,
    /// 1.2 times.
    MediumHighContrast,
    /// 0.9 times.
    MediumLowContrast,
    /// 0.8 times.
    LowContrast,
    /// 0.7 times.
    VeryLowContrast,
    /// Darker, with deep shadows.
    Punchy,
    /// Black and white.
    Greyscale,
}

/// Weights of saturation in OpenColorIO's primary grading.
const LUMA: Vec3 = Vec3::new(0.2126, 0.7152, 0.0722);

/// Range of `AgX Log` in stops around middle grey.
const STOPS: [f32; 2] = [-10.0, 15.0];

/// Weights of `AgX - Greyscale`.
const GREY: Vec3 = Vec3::new(0.258_923_54, 0.610_498_55, 0.130_577_94);

/// Values of `AgX Log` where the shadows of `AgX - Punchy` begin and are deepest, and their slopes there: of
/// each channel, and of all.
const SHADOWS: [f32; 2] = [0.4, 0.1];
const SHADOW_SLOPES: [f32; 2] = [0.2, 0.35];
/// Power of `AgX - Punchy`, which darkens everything.
const POWER: f32 = 1.0912;

impl Look {
    /// All looks.
    pub const ALL: [Self; 9] = [
        Self::None,
        Self::VeryHighContrast,
        Self::HighContrast,
        Self::MediumHighContrast,
        Self::MediumLowContrast,
        Self::LowContrast,
        Self::VeryLowContrast,
        Self::Punchy,
        Self::Greyscale,
    ];

    /// Name on the command line and in scene files.
    pub fn name(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::VeryHighContrast => "very-high-contrast",
            Self::HighContrast => "high-contrast",
            Self::MediumHighContrast => "medium-high-contrast",
            Self::MediumLowContrast => "medium-low-contrast",
            Self::LowContrast => "low-contrast",
            Self::VeryLowContrast => "very-low-contrast",
            Self::Punchy => "punchy",
            Self::Greyscale => "greyscale",
        }
    }

    /// Applies the look to light that the inset has mixed.
    pub(super) fn graded(self, mixed: Vec3, middle_grey: f32) -> Vec3 {
        // Contrast and saturation as in `GradingPrimaryTransform` of Blender's `config.ocio`.
        let (contrast, saturation) = match self {
            Self::None => return mixed,
            Self::Greyscale => return Vec3::splat(GREY.dot(mixed)),
            Self::Punchy => return in_stops(mixed, middle_grey, punchy),
            Self::VeryHighContrast => (1.57, 0.9),
            Self::HighContrast => (1.4, 0.95),
            Self::MediumHighContrast => (1.2, 1.0),
            Self::MediumLowContrast => (0.9, 1.05),
            Self::LowContrast => (0.8, 1.1),
            Self::VeryLowContrast => (0.7, 1.15),
        };
        in_stops(mixed, middle_grey, |stops| {
            let stretched = contrast * stops;
            let luma = Vec3::splat(LUMA.dot(stretched));
            luma + saturation * (stretched - luma)
        })
    }
}

/// Changes light in `AgX Log`, which is linear in stops around middle grey.
fn in_stops(light: Vec3, middle_grey: f32, change: impl Fn(Vec3) -> Vec3) -> Vec3 {
    let [least, most] = STOPS;
    let stops = light.to_array().map(|light| (light / middle_grey).log2().clamp(least, most));
    middle_grey * Vec3::from(change(stops.into()).to_array().map(f32::exp2))
}

/// Deepens shadows, then applies a power, both in `AgX Log`, where the range of stops is 0 to 1.
fn punchy(stops: Vec3) -> Vec3 {
    let [least, most] = STOPS;
    let of_channel = |stops: f32| {
        let log = SHADOW_SLOPES.into_iter().fold((stops - least) / (most - least), deepened);
        least + (most - least) * log.powf(POWER)
    };
    Vec3::from(stops.to_array().map(of_channel))
}

/// Shadows of OpenColorIO's `GradingToneTransform`: two parabolas lead from a slope at the deepest to 1 where
/// shadows begin, and a line continues below.
fn deepened(log: f32, slope: f32) -> f32 {
    let [start, deepest] = SHADOWS;
    let half = 0.5 * (start - deepest);
    let steepest = 0.5 * (3.0 - slope);
    match log {
        log if log >= start => log,
        log if log >= start - half => log - (steepest - 1.0) / (2.0 * half) * (start - log).powi(2),
        log => {
            let above = log - deepest;
            deepest + slope * above + (steepest - slope) / (2.0 * half) * above.max(0.0).powi(2)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::color::{Display, Rgb};

    const COLORS: [[f64; 3]; 6] =
        [[0.0; 3], [1.0; 3], [0.02; 3], [0.4, 0.15, 0.02], [0.8, 0.5, 0.05], [0.0, 1.0, 0.0]];

    /// Colours as Blender 5.0.1 shows them: view AgX, display sRGB, saved with 16 bits.
    const BLENDER: [(Look, [[f64; 3]; 6]); 5] = [
        (
            Look::HighContrast,
            [
                [0.0; 3],
                [0.8511; 3],
                [0.06137; 3],
                [0.68215, 0.39464, 0.0],
                [0.84285, 0.69296, 0.35204],
                [0.41573, 0.85579, 0.28603],
            ],
        ),
        (
            Look::MediumHighContrast,
            [
                [0.0; 3],
                [0.81379; 3],
                [0.08974; 3],
                [0.67002, 0.39902, 0.00894],
                [0.80649, 0.66711, 0.3433],
                [0.40838, 0.81886, 0.2822],
            ],
        ),
        (
            Look::LowContrast,
            [
                [0.00165; 3],
                [0.72197; 3],
                [0.16835; 3],
                [0.62434, 0.41671, 0.18088],
                [0.71604, 0.60888, 0.35781],
                [0.41767, 0.72755, 0.31049],
            ],
        ),
        (
            Look::Punchy,
            [
                [0.00136; 3],
                [0.69235; 3],
                [0.03952; 3],
                [0.5104, 0.30698, 0.0],
                [0.66847, 0.53866, 0.2014],
                [0.27558, 0.68673, 0.11543],
            ],
        ),
        (Look::Greyscale, [[0.0; 3], [0.77098; 3], [0.12502; 3], [0.4686; 3], [0.66163; 3], [0.69035; 3]]),
    ];

    #[test]
    fn looks_are_blenders() {
        for (look, shown) in BLENDER {
            for (light, shown) in COLORS.into_iter().zip(shown) {
                let ours = Display { look, ..Display::default() }.encode(light.into());
                // Where a channel ends near black the nodes of Blender's table lie far apart.
                let is_near = (ours - Rgb::from(shown)).abs().max_element() < 4.0 / 255.0;
                assert!(is_near, "{look:?} {light:?}: {ours}, in Blender {shown:?}");
            }
        }
    }

    #[test]
    fn middle_grey_stays_and_no_look_changes_nothing() {
        for look in Look::ALL.into_iter().filter(|look| *look != Look::Punchy) {
            assert!(look.graded(Vec3::splat(0.18), 0.18).abs_diff_eq(Vec3::splat(0.18), 1e-6), "{look:?}");
        }
        let light = Vec3::new(0.1, 7.0, 1e-9);
        assert_eq!(Look::None.graded(light, 0.18), light);
    }
}
