//! Conversion of primaries. In go chromaticities, out comes a matrix to Rec. 709. Invariant: white stays
//! white.

use glam::{DMat3, DVec2, DVec3};

const D65: DVec2 = DVec2::new(0.3127, 0.329);
const ACES_WHITE: DVec2 = DVec2::new(0.32168, 0.33767);

/// Chromaticities of red, green, blue and white, as CIE 1931 x and y.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Primaries {
    /// Red.
    pub red: DVec2,
    /// Green.
    pub green: DVec2,
    /// Blue.
    pub blue: DVec2,
    /// R = G = B.
    pub white: DVec2,
}

impl Primaries {
    /// ITU-R BT.709 with its white D65.
    pub const REC_709: Self = Self::new([0.64, 0.33], [0.3, 0.6], [0.15, 0.06], D65);

    /// Academy primaries AP0 (SMPTE ST 2065-1).
    pub const AP0: Self = Self::new([0.7347, 0.2653], [0.0, 1.0], [0.0001, -0.077], ACES_WHITE);

    /// Academy primaries AP1, those of ACEScg (S-2014-004).
    pub const AP1: Self = Self::new([0.713, 0.293], [0.165, 0.83], [0.128, 0.044], ACES_WHITE);

    /// ITU-R BT.2020.
    pub const REC_2020: Self = Self::new([0.708, 0.292], [0.17, 0.797], [0.131, 0.046], D65);

    /// DCI-P3 with the white D65 (SMPTE EG 432-1).
    pub const P3_D65: Self = Self::new([0.68, 0.32], [0.265, 0.69], [0.15, 0.06], D65);

    /// Adobe RGB (1998).
    pub const ADOBE_RGB: Self = Self { green: DVec2::new(0.21, 0.71), ..Self::REC_709 };

    const fn new(red: [f64; 2], green: [f64; 2], blue: [f64; 2], white: DVec2) -> Self {
        let [red, green, blue] = [DVec2::from_array(red), DVec2::from_array(green), DVec2::from_array(blue)];
        Self { red, green, blue, white }
    }

    /// Matrix to linear Rec. 709 from linear colours of these primaries; `None` if they span no colours.
    /// White is adapted by Bradford's method (ICC.1:2022, annex E).
    pub fn to_rec_709(self) -> Option<DMat3> {
        let ours = Self::REC_709.xyz_from_rgb()?;
        let matrix = ours.inverse() * adaptation(self.white, Self::REC_709.white) * self.xyz_from_rgb()?;
        matrix.is_finite().then_some(matrix)
    }

    /// Matrix to CIE XYZ from linear colours, white with Y = 1 (SMPTE RP 177, section 3.3).
    pub(super) fn xyz_from_rgb(self) -> Option<DMat3> {
        // Not scaled to Y = 1: primaries of CIE XYZ themselves have Y = 0.
        let column = |xy: DVec2| DVec3::new(xy.x, xy.y, 1.0 - xy.x - xy.y);
        let columns = DMat3::from_cols(column(self.red), column(self.green), column(self.blue));
        (columns.determinant().abs() > 1e-9 && self.white.y > 0.0).then(|| {
            let amounts = columns.inverse() * xyz(self.white);
            columns * DMat3::from_diagonal(amounts)
        })
    }
}

/// X, Y and Z of a chromaticity, Y = 1.
fn xyz(xy: DVec2) -> DVec3 {
    DVec3::new(xy.x, xy.y, 1.0 - xy.x - xy.y) / xy.y
}

fn adaptation(from_white: DVec2, to_white: DVec2) -> DMat3 {
    let cone_from_xyz = DMat3::from_cols_array(&[
        0.8951, -0.7502, 0.0389, // X
        0.2664, 1.7135, -0.0685, // Y
        -0.1614, 0.0367, 1.0296, // Z
    ]);
    let (from, to) = (cone_from_xyz * xyz(from_white), cone_from_xyz * xyz(to_white));
    cone_from_xyz.inverse() * DMat3::from_diagonal(to / from) * cone_from_xyz
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    const AP0: Primaries = Primaries::AP0;

    #[test]
    fn white_stays_white_and_our_own_stay_what_they_are() {
        assert!((AP0.to_rec_709().unwrap() * DVec3::ONE).abs_diff_eq(DVec3::ONE, 1e-12));
        assert!(Primaries::REC_709.to_rec_709().unwrap().abs_diff_eq(DMat3::IDENTITY, 1e-12));
    }

    /// The matrix that ACES publishes for AP0 to linear Rec. 709 (Bradford), to its digits.
    #[test]
    fn aces_is_converted_as_aces_says() {
        let rows =
            [[2.52169, -1.13413, -0.38756], [-0.27648, 1.37272, -0.09624], [-0.01538, -0.15298, 1.16835]];
        let found = AP0.to_rec_709().unwrap().transpose().to_cols_array_2d();
        for (found, expected) in found.iter().flatten().zip(rows.iter().flatten()) {
            assert!((found - expected).abs() < 2e-4, "{found} for {expected}");
        }
    }

    #[test]
    fn what_spans_no_colours_is_refused() {
        let flat = Primaries { green: Primaries::REC_709.red, ..Primaries::REC_709 };
        let nowhere = Primaries { white: DVec2::ZERO, ..Primaries::REC_709 };
        assert!(flat.to_rec_709().is_none() && nowhere.to_rec_709().is_none());
    }

    /// Chromaticities of files that hold CIE XYZ: red is X, whose Y is 0.
    #[test]
    fn xyz_has_primaries() {
        let third = 1.0 / 3.0;
        let white = DVec2::new(third, third);
        let xyz = Primaries { red: DVec2::X, green: DVec2::Y, blue: DVec2::ZERO, white };
        assert!((xyz.to_rec_709().unwrap() * DVec3::ONE).abs_diff_eq(DVec3::ONE, 1e-12));
    }
}
