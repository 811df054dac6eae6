//! Colour spaces by name. In go ids of the ASWF's Color Interop Forum, as `colorInteropID` of OpenEXR holds
//! them, out come colours in linear Rec. 709. Invariant: white of every space stays white.

use super::{Primaries, Rgb};
use glam::DMat3;

/// Largest difference of matrices of the same primaries, from rounded digits in files.
const SAME_PRIMARIES: f64 = 1e-3;

/// Meaning of a colour space's id.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum NamedSpace {
    /// Colours.
    Colors(ColorSpace),
    /// Numbers that are not colours (`data`).
    Data,
    /// Explicitly unknown (`unknown`).
    Unsaid,
    /// An id that is not supported.
    NotKnown,
}

/// Colour space that can be converted to linear Rec. 709.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ColorSpace {
    rec_709_from_linear: DMat3,
    curve: Curve,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Curve {
    Linear,
    /// IEC 61966-2-1.
    Srgb,
    /// Power of this exponent, from encoded to linear.
    Power(f64),
}

impl ColorSpace {
    /// Linear Rec. 709.
    pub const OURS: Self = Self { rec_709_from_linear: DMat3::IDENTITY, curve: Curve::Linear };

    /// Linear space of these primaries; `None` if they span no colours.
    pub fn linear(primaries: Primaries) -> Option<Self> {
        Some(Self { rec_709_from_linear: primaries.to_rec_709()?, curve: Curve::Linear })
    }

    /// Whether both spaces are the same, up to rounded digits in files.
    pub fn is_same(&self, other: &Self) -> bool {
        self.curve == other.curve && self.has_same_primaries(other)
    }

    /// Whether both have the same primaries.
    pub fn has_same_primaries(&self, other: &Self) -> bool {
        self.rec_709_from_linear.abs_diff_eq(other.rec_709_from_linear, SAME_PRIMARIES)
    }

    /// Luminance weights of this space's linear red, green and blue.
    pub fn luminances(&self) -> Rgb {
        self.rec_709_from_linear.transpose() * super::LUMINANCES
    }

    /// Converts a colour to linear Rec. 709. The curve is odd: negative values are decoded like positive
    /// ones.
    pub fn to_rec_709(self, color: Rgb) -> Rgb {
        let linear = |encoded: f64| match self.curve {
            Curve::Linear => encoded,
            Curve::Srgb => super::linear_from_srgb(encoded.abs()).copysign(encoded),
            Curve::Power(power) => encoded.abs().powf(power).copysign(encoded),
        };
        self.rec_709_from_linear * Rgb::new(linear(color.x), linear(color.y), linear(color.z))
    }
}

impl NamedSpace {
    /// Space of an id. `lin_ap1_scene`, for example, has a curve, primaries, and whether it is of a scene or
    /// a display.
    pub fn of(id: &str) -> Self {
        let known = id.strip_prefix("ocio:").unwrap_or(id);
        let mut words = known.split('_');
        match (known, words.next(), words.next(), words.next(), words.next()) {
            ("data", ..) => Self::Data,
            ("unknown" | "", ..) => Self::Unsaid,
            (_, Some(curve), Some(primaries), Some("scene" | "display"), None) => {
                match (curve_of(curve), matrix_of(primaries)) {
                    (Some(curve), Some(rec_709_from_linear)) => {
                        Self::Colors(ColorSpace { rec_709_from_linear, curve })
                    }
                    _ => Self::NotKnown,
                }
            }
            _ => Self::NotKnown,
        }
    }
}

fn curve_of(word: &str) -> Option<Curve> {
    Some(match word {
        "lin" => Curve::Linear,
        // The extended range (`srgbe`) continues below 0 and above 1.
        "srgb" | "srgbe" => Curve::Srgb,
        "g18" => Curve::Power(1.8),
        "g22" => Curve::Power(2.2),
        "g24" => Curve::Power(2.4),
        "g26" => Curve::Power(2.6),
        _ => return None,
    })
}

fn matrix_of(word: &str) -> Option<DMat3> {
    let primaries = match word {
        "rec709" => Primaries::REC_709,
        "ap0" => Primaries::AP0,
        "ap1" => Primaries::AP1,
        "rec2020" => Primaries::REC_2020,
        "p3d65" => Primaries::P3_D65,
        "adobergb" => Primaries::ADOBE_RGB,
        // CIE XYZ without scaling of white to 1, 1, 1.
        "ciexyzd65" => return Some(Primaries::REC_709.xyz_from_rgb()?.inverse()),
        _ => return None,
    };
    primaries.to_rec_709()
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    /// Values of (0.2, 0.5, 0.1), by OpenColorIO 2.6 with its built-in `studio-config-latest`.
    const BY_OPENCOLORIO: [(&str, [f64; 3]); 15] = [
        ("lin_rec709_scene", [0.20000, 0.50000, 0.10000]),
        ("lin_ap0_scene", [-0.10148, 0.62144, 0.03727]),
        ("lin_ap1_scene", [0.02179, 0.54330, 0.04601]),
        ("lin_rec2020_scene", [0.03099, 0.54070, 0.05795]),
        ("lin_p3d65_scene", [0.13252, 0.51262, 0.06658]),
        ("lin_adobergb_scene", [0.08049, 0.50000, 0.08283]),
        ("lin_ciexyzd65_scene", [-0.17036, 0.74829, 0.01483]),
        ("srgb_rec709_scene", [0.03310, 0.21404, 0.01002]),
        ("g18_rec709_scene", [0.05519, 0.28718, 0.01585]),
        ("g22_rec709_scene", [0.02899, 0.21764, 0.00631]),
        ("g24_rec709_scene", [0.02101, 0.18947, 0.00398]),
        ("srgb_p3d65_scene", [-0.00760, 0.22165, -0.00647]),
        ("srgb_ap1_scene", [-0.07748, 0.23976, -0.01684]),
        ("g22_ap1_scene", [-0.08642, 0.24444, -0.02149]),
        ("g22_adobergb_scene", [-0.04615, 0.21776, -0.00276]),
    ];

    #[test]
    fn colors_are_those_of_opencolorio() {
        for (id, expected) in BY_OPENCOLORIO {
            let NamedSpace::Colors(space) = NamedSpace::of(id) else { panic!("{id} is not known") };
            let found = space.to_rec_709(Rgb::new(0.2, 0.5, 0.1));
            assert!(found.abs_diff_eq(expected.into(), 2e-4), "{id}: {found} for {expected:?}");
        }
    }

    #[test]
    fn names_without_colors_are_told_apart() {
        for id in ["data", "ocio:data"] {
            assert_eq!(NamedSpace::of(id), NamedSpace::Data, "{id}");
        }
        for id in ["unknown", ""] {
            assert_eq!(NamedSpace::of(id), NamedSpace::Unsaid, "{id}");
        }
        for id in
            ["ocio:acescct_ap1_scene", "studio:lin_ap1_scene", "lin_ap1", "pq_rec2020_display", "ACEScg"]
        {
            assert_eq!(NamedSpace::of(id), NamedSpace::NotKnown, "{id}");
        }
    }

    #[test]
    fn digits_of_files_change_no_space() {
        let of_file = Primaries { white: glam::DVec2::new(0.31271, 0.32902), ..Primaries::REC_709 };
        assert!(ColorSpace::linear(of_file).unwrap().is_same(&ColorSpace::OURS));
        let NamedSpace::Colors(srgb) = NamedSpace::of("srgb_rec709_scene") else { panic!() };
        assert!(!srgb.is_same(&ColorSpace::OURS));
    }
}
