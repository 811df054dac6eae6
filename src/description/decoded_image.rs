//! Decoded image. In go texels, out comes an image in linear Rec. 709. Invariant: it has width times height
//! texels, in one colour space whatever the file's.

use crate::color::Texels;
use crate::diagnostic::Loss;

/// An RGBA image in linear Rec. 709, top row first.
#[derive(Clone, Debug, PartialEq)]
pub struct DecodedImage {
    /// Texels a row, at least 1.
    pub width: usize,
    /// Rows, at least 1.
    pub height: usize,
    /// Linear colour, alpha last, row by row from the top.
    pub texels: Texels,
    /// Loss of its colours, and the reason.
    pub doubt: Option<(Loss, String)>,
}

impl DecodedImage {
    /// Creates an image with certain colours.
    pub fn new(width: usize, height: usize, texels: Texels) -> Self {
        Self { width, height, texels, doubt: None }
    }
}
