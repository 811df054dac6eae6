//! Mask of pixels to sample. In go a window and a predicate, out comes a set of pixels. Invariant: it holds
//! no pixel outside the window.

use super::BLOCK_SIDE;
use crate::scene::{Size, Window};

/// Pixels of a word.
const WORD: usize = u64::BITS as usize;

/// Set of pixels of the full picture.
#[derive(Clone, Debug)]
pub struct Mask {
    window: Window,
    /// A bit for each pixel, the lowest of a word first.
    wanted: Vec<u64>,
    /// Blocks that the window touches, in blocks from the picture's corner, and which of them contain pixels
    /// of the set.
    blocks: Window,
    is_inhabited: Vec<bool>,
}

impl Mask {
    /// All pixels of a window.
    pub fn all(window: Window) -> Self {
        Self::from_fn(window, |_, _| true)
    }

    /// Pixels `(x, y)` of a window for which `wanted` is true.
    pub fn from_fn(window: Window, mut wanted: impl FnMut(usize, usize) -> bool) -> Self {
        let span = |from: usize, count: usize| {
            let first = from / BLOCK_SIDE;
            (first, (from + count).div_ceil(BLOCK_SIDE) - first)
        };
        let ((x, width), (y, height)) = (span(window.x, window.width), span(window.y, window.height));
        let blocks = Window { x, y, width, height };
        let mut is_inhabited = vec![false; width * height];
        let mut bits = vec![0; (window.width * window.height).div_ceil(WORD)];
        for (pixel, (x, y)) in window.pixels().enumerate() {
            let is_wanted = wanted(x, y);
            bits[pixel / WORD] |= u64::from(is_wanted) << (pixel % WORD);
            if let Some(block) = blocks.index(x / BLOCK_SIDE, y / BLOCK_SIDE) {
                is_inhabited[block] |= is_wanted;
            }
        }
        Self { window, wanted: bits, blocks, is_inhabited }
    }

    /// Mask with the neighbours of its pixels, inside the picture.
    pub fn with_rim(&self, full: Size) -> Self {
        if self.window == Window::whole(full) && self.count() == full.width * full.height {
            return self.clone();
        }
        Self::from_fn(self.window.with_rim(full), |x, y| {
            Window::whole(full).around(x, y).any(|(x, y)| self.contains(x, y))
        })
    }

    /// Number of pixels.
    pub fn count(&self) -> usize {
        self.wanted.iter().map(|word| word.count_ones() as usize).sum()
    }

    /// Whether the mask contains a pixel of the full picture.
    pub fn contains(&self, x: usize, y: usize) -> bool {
        self.window.index(x, y).is_some_and(|pixel| self.wanted[pixel / WORD] >> (pixel % WORD) & 1 == 1)
    }

    /// Blocks of the picture that contain pixels of the mask.
    pub fn inhabited_blocks(&self) -> impl Iterator<Item = Window> {
        let inhabited =
            self.blocks.pixels().zip(&self.is_inhabited).filter(|(_, is_inhabited)| **is_inhabited);
        inhabited.map(|((column, row), _)| Window {
            x: column * BLOCK_SIDE,
            y: row * BLOCK_SIDE,
            width: BLOCK_SIDE,
            height: BLOCK_SIDE,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn holds_what_was_wanted_and_nothing_outside() {
        let window = Window { x: 2, y: 3, width: 4, height: 2 };
        let mask = Mask::from_fn(window, |x, _| x % 2 == 0);
        assert!(mask.contains(2, 3) && mask.contains(4, 4));
        assert!(!mask.contains(3, 3) && !mask.contains(0, 3) && !mask.contains(6, 3) && !mask.contains(2, 5));
        assert!(Mask::all(window).contains(5, 4) && !Mask::all(window).contains(6, 4));
        assert_eq!((mask.count(), Mask::all(window).count()), (4, 8));
    }

    #[test]
    fn a_rim_ends_at_the_picture() {
        let full = Size { width: 9, height: 5 };
        let two = Mask::from_fn(Window { x: 2, y: 0, width: 7, height: 3 }, |x, y| {
            (x, y) == (2, 2) || (x, y) == (8, 0)
        });
        let grown = two.with_rim(full);
        let is_near = |x: usize, y: usize| x.abs_diff(2) <= 1 && y.abs_diff(2) <= 1 || x >= 7 && y <= 1;
        for (x, y) in Window::whole(full).pixels() {
            assert_eq!(grown.contains(x, y), is_near(x, y), "{x}, {y}");
        }
        assert_eq!(grown.window, Window { x: 1, y: 0, width: 8, height: 4 });
    }

    #[test]
    fn inhabited_blocks_are_aligned_to_the_picture() {
        let mask = Mask::from_fn(Window { x: 5, y: 3, width: 20, height: 10 }, |x, y| x == 16 && y == 7);
        let blocks: Vec<Window> = mask.inhabited_blocks().collect();
        assert_eq!(blocks, [Window { x: 16, y: 0, width: 8, height: 8 }]);
    }
}
