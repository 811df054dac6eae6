//! Memory of a sweep along one pair of ordinates. In goes a number of nodes, out come lists by node.
//! Invariant: nothing of one angle set reaches another through it, so a thread needs only one.

/// Values by node of a layout, for one channel, and along the ordinate and its opposite where there are two.
#[derive(Default)]
pub(super) struct Workspace {
    /// Extinction of leaves, 0 where there are none.
    pub(super) oriented_extinction: Vec<f32>,
    /// Transmittance of the cell, and its mean within.
    pub(super) through: Vec<f32>,
    pub(super) mean: Vec<f32>,
    /// Radiance that the source adds to the outgoing one, and to the mean within.
    pub(super) added: [Vec<f32>; 2],
    pub(super) added_within: [Vec<f32>; 2],
    /// Mean radiance in the cell.
    pub(super) radiance: [Vec<f32>; 2],
    /// Outgoing radiance of the cells next to walls: a wall's incident light has crossed the whole cell.
    /// Elsewhere it is of no use, and may be that of another set.
    pub(super) at_walls: [Vec<f32>; 2],
}

impl Workspace {
    /// Memory for so many nodes.
    pub(super) fn new(count: usize) -> Self {
        let nodes = || vec![0.0; count];
        Self {
            oriented_extinction: nodes(),
            through: nodes(),
            mean: nodes(),
            added: [nodes(), nodes()],
            added_within: [nodes(), nodes()],
            radiance: [nodes(), nodes()],
            at_walls: [nodes(), nodes()],
        }
    }

    /// Memory for another set, whose leaves are at other nodes.
    pub(super) fn cleared(mut self) -> Self {
        self.oriented_extinction.fill(0.0);
        self
    }
}
