//! Other primaries to ours. In go chromaticities, out comes a matrix. Invariant: white stays white.

use glam::{DMat3, DVec2, DVec3};

/// The colours that R, G and B = 1 stand for, and their sum, as CIE 1931 x and y.
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
    pub const REC_709: Self = Self {
        red: DVec2::new(0.64, 0.33),
        green: DVec2::new(0.3, 0.6),
        blue: DVec2::new(0.15, 0.06),
        white: DVec2::new(0.3127, 0.329),
    };

    /// Linear Rec. 709 from linear colours of these primaries; `None` if they span no colours. White is
    /// adapted by Bradford's method (ICC.1:2022, annex E).
    pub fn to_rec_709(self) -> Option<DMat3> {
        let ours = Self::REC_709.xyz_from_rgb()?;
        let matrix = ours.inverse() * adaptation(self.white, Self::REC_709.white) * self.xyz_from_rgb()?;
        matrix.is_finite().then_some(matrix)
    }

    /// SMPTE RP 177, section 3.3.
    fn xyz_from_rgb(self) -> Option<DMat3> {
        let columns = DMat3::from_cols(xyz(self.red), xyz(self.green), xyz(self.blue));
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

    /// SMPTE ST 2065-1.
    const AP0: Primaries = Primaries {
        red: DVec2::new(0.7347, 0.2653),
        green: DVec2::new(0.0, 1.0),
        blue: DVec2::new(0.0001, -0.077),
        white: DVec2::new(0.32168, 0.33767),
    };

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
        let nowhere = Primaries { blue: DVec2::ZERO, ..Primaries::REC_709 };
        assert!(flat.to_rec_709().is_none() && nowhere.to_rec_709().is_none());
    }
}
