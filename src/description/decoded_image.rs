//! An image, decoded. In goes nothing, nothing comes out. Invariant: width times height texels, in one colour
//! space whatever the file's.

use crate::color::Texels;

/// An RGBA image in linear Rec. 709, top row first.
#[derive(Clone, Debug, PartialEq)]
pub struct DecodedImage {
    /// Texels a row, at least 1.
    pub width: usize,
    /// Rows, at least 1.
    pub height: usize,
    /// Linear colour, alpha last, row by row from the top.
    pub texels: Texels,
}
