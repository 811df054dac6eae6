//! Domain of light transport: a grid with its medium and walls, for sweeps. Invariant: it does not change
//! from order to order.

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
