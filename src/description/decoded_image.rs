//! An image, decoded. Invariant: it has width times height texels, in one colour space whatever the file's.

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
    /// Loss of its colours, and why.
    pub doubt: Option<(Loss, String)>,
}

impl DecodedImage {
    /// An image whose colours are beyond doubt.
    pub fn new(width: usize, height: usize, texels: Texels) -> Self {
        Self { width, height, texels, doubt: None }
    }
}
