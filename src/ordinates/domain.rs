//! Domain that light is transported in. In go a grid and what fills it, out comes one thing to sweep over.
//! Invariant: nothing of it changes from order to order.

use super::cross_sections::CrossSections;
use super::grid::Grid;
use super::walls::Walls;

/// A grid with the medium and the walls in it.
#[derive(Clone, Copy)]
pub(crate) struct Domain<'a> {
    pub(crate) grid: &'a Grid,
    pub(crate) cross_sections: &'a CrossSections,
    pub(crate) walls: &'a Walls,
}
