//! Square blocks of pixels, over which errors are estimated. In goes a part of a picture, out come
//! the blocks that cover it. Invariant: blocks are aligned to the full picture, so that a pixel
//! belongs to the same block whatever part of the picture is rendered.

use crate::scene::{Size, Window};
use std::ops::Range;

/// Pixels along a block's side: few enough to follow an edge, enough for a stable mean.
pub const BLOCK_SIDE: usize = 8;

/// The blocks that cover a part of a picture, row by row from the top.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Blocks {
    full: Size,
    /// Columns in blocks, from the picture's corner.
    columns: Range<usize>,
    rows: Range<usize>,
}

impl Blocks {
    /// The blocks that have pixels in a window.
    pub fn covering(window: Window, full: Size) -> Self {
        let blocks = |from: usize, count: usize| from / BLOCK_SIDE..(from + count).div_ceil(BLOCK_SIDE);
        Self { full, columns: blocks(window.x, window.width), rows: blocks(window.y, window.height) }
    }

    /// Blocks with their neighbours, inside the picture.
    pub fn with_neighbours(&self) -> Self {
        let grown = |blocks: &Range<usize>, pixels: usize| {
            blocks.start.saturating_sub(1)..(blocks.end + 1).min(pixels.div_ceil(BLOCK_SIDE))
        };
        let Self { full, columns, rows } = self;
        Self { full: *full, columns: grown(columns, full.width), rows: grown(rows, full.height) }
    }

    /// Number of blocks.
    pub fn count(&self) -> usize {
        self.columns.len() * self.rows.len()
    }

    /// Pixels of all blocks.
    pub fn window(&self) -> Window {
        self.pixels_of(self.columns.clone(), self.rows.clone())
    }

    /// Index of the block that contains a pixel of the full picture.
    pub fn index(&self, x: usize, y: usize) -> Option<usize> {
        let (column, row) = (x / BLOCK_SIDE, y / BLOCK_SIDE);
        let is_here = self.columns.contains(&column) && self.rows.contains(&row);
        is_here.then(|| (row - self.rows.start) * self.columns.len() + (column - self.columns.start))
    }

    /// The pixels of a block; fewer at the picture's far edges.
    pub fn pixels(&self, block: usize) -> Window {
        let (column, row) = self.place(block);
        self.pixels_of(column..column + 1, row..row + 1)
    }

    /// Block and its neighbours, up to eight.
    pub fn neighbourhood(&self, block: usize) -> impl Iterator<Item = usize> {
        let (column, row) = self.place(block);
        let (columns, rows) = (self.columns.clone(), self.rows.clone());
        let near = |at: usize, all: &Range<usize>| at.saturating_sub(1).max(all.start)..(at + 2).min(all.end);
        let near_columns = near(column, &columns);
        near(row, &rows).flat_map(move |row| {
            let (first_row, first_column, width) = (rows.start, columns.start, columns.len());
            near_columns.clone().map(move |column| (row - first_row) * width + (column - first_column))
        })
    }

    /// Column and row in blocks, from the picture's corner.
    fn place(&self, block: usize) -> (usize, usize) {
        let width = self.columns.len();
        (self.columns.start + block % width, self.rows.start + block / width)
    }

    fn pixels_of(&self, columns: Range<usize>, rows: Range<usize>) -> Window {
        let span = |blocks: Range<usize>, pixels: usize| {
            let from = blocks.start * BLOCK_SIDE;
            (from, (blocks.end * BLOCK_SIDE).min(pixels) - from)
        };
        let ((x, width), (y, height)) = (span(columns, self.full.width), span(rows, self.full.height));
        Window { x, y, width, height }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FULL: Size = Size { width: 37, height: 20 };

    #[test]
    fn every_pixel_of_the_window_lies_in_the_block_that_says_so() {
        for window in [Window::whole(FULL), Window { x: 9, y: 3, width: 20, height: 10 }] {
            let blocks = Blocks::covering(window, FULL);
            let mut pixels = 0;
            for block in 0..blocks.count() {
                for (x, y) in blocks.pixels(block).pixels() {
                    assert_eq!(blocks.index(x, y), Some(block));
                    pixels += 1;
                }
            }
            let covered = blocks.window();
            assert_eq!(pixels, covered.width * covered.height);
            assert!(window.pixels().all(|(x, y)| covered.index(x, y).is_some()));
        }
    }

    #[test]
    fn neighbours_end_at_the_picture() {
        let corner = Blocks::covering(Window { x: 0, y: 17, width: 1, height: 1 }, FULL);
        assert_eq!(corner.window(), Window { x: 0, y: 16, width: 8, height: 4 });
        assert_eq!(corner.with_neighbours().window(), Window { x: 0, y: 8, width: 16, height: 12 });
        let whole = Blocks::covering(Window::whole(FULL), FULL);
        assert_eq!(whole.with_neighbours(), whole);
    }

    #[test]
    fn a_neighbourhood_is_all_within_a_block() {
        let blocks = Blocks::covering(Window { x: 8, y: 0, width: 29, height: 20 }, FULL);
        for block in 0..blocks.count() {
            let (x, y) = {
                let at = blocks.pixels(block);
                (at.x / 8, at.y / 8)
            };
            let near: Vec<usize> = (0..blocks.count())
                .filter(|&other| {
                    let at = blocks.pixels(other);
                    (at.x / 8).abs_diff(x) <= 1 && (at.y / 8).abs_diff(y) <= 1
                })
                .collect();
            assert_eq!(blocks.neighbourhood(block).collect::<Vec<_>>(), near);
        }
    }
}
