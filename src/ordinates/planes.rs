//! Planes of nodes that light crosses one after the other, and their layout in memory. In goes the size of a
//! grid, out come indices of nodes. Invariant: the nodes of a row of a plane are contiguous, for any axis.

use super::grid::Corners;
use super::walls::link_of;

/// Layout of nodes in memory: that of the grid, where neighbours along x are contiguous, or with x and y
/// exchanged.
#[derive(Clone, Copy)]
pub(crate) struct Layout {
    /// Nodes along each axis.
    pub(crate) size: [usize; 3],
    pub(crate) is_turned: bool,
}

impl Layout {
    fn strides(self) -> [usize; 3] {
        let [x, y, _] = self.size;
        if self.is_turned { [y, 1, x * y] } else { [1, x, x * y] }
    }

    /// Index in this layout of a node of the grid.
    pub(crate) fn node(self, node: usize) -> usize {
        let [x, y, _] = self.size;
        let place = [node % x, node / x % y, node / (x * y)];
        (0..3).map(|axis| place[axis] * self.strides()[axis]).sum()
    }

    /// Corners with indices in this layout.
    pub(crate) fn corners(self, corners: &Corners) -> Corners {
        Corners { nodes: corners.nodes.map(|node| self.node(node)), ..*corners }
    }

    /// Values in this layout, from the grid's order.
    pub(crate) fn of_grid(self, values: &[f32]) -> Vec<f32> {
        if self.is_turned { turned(values, [self.size[0], self.size[1]]) } else { values.to_vec() }
    }

    /// Values in the grid's order, from this layout.
    pub(crate) fn to_grid(self, values: &[f32]) -> Vec<f32> {
        if self.is_turned { turned(values, [self.size[1], self.size[0]]) } else { values.to_vec() }
    }
}

/// Transpose of rows and columns, layer by layer.
fn turned(values: &[f32], [columns, rows]: [usize; 2]) -> Vec<f32> {
    let mut turned = Vec::with_capacity(values.len());
    for layer in values.chunks_exact(columns * rows) {
        for column in 0..columns {
            turned.extend((0..rows).map(|row| layer[column + columns * row]));
        }
    }
    turned
}

/// The planes across an axis.
#[derive(Clone, Copy)]
pub(crate) struct Planes {
    pub(crate) axis: usize,
    /// Numbers of planes, of their rows and of their columns, and the strides between these.
    pub(crate) count: [usize; 3],
    pub(crate) stride: [usize; 3],
    /// Axes of the grid in the same order.
    pub(crate) axes: [usize; 3],
}

impl Planes {
    pub(crate) fn new(layout: Layout, axis: usize) -> Self {
        let axes = [axis, [2, 2, 1][axis], [1, 0, 0][axis]];
        let (count, stride) = (axes.map(|axis| layout.size[axis]), axes.map(|axis| layout.strides()[axis]));
        debug_assert_eq!(stride[2], 1, "rows are neighbours in memory");
        Self { axis, count, stride, axes }
    }

    /// Length of a row with its rim.
    pub(crate) fn row(&self) -> usize {
        self.count[2] + 2
    }

    /// Number of the link of a step along planes, rows and columns.
    pub(crate) fn link(&self, step: [i32; 3]) -> usize {
        let mut of_axes = [0; 3];
        self.axes.into_iter().zip(step).for_each(|(axis, step)| of_axes[axis] = step);
        link_of(of_axes)
    }

    /// Index in a plane with its rim, shifted by rows and columns.
    pub(crate) fn shifted(&self, here: usize, [_, rows, columns]: [i32; 3]) -> usize {
        (here as i32 + rows * self.row() as i32 + columns) as usize
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nodes_are_where_their_numbers_say() {
        let layout = Layout { size: [3, 4, 5], is_turned: true };
        let values: Vec<f32> = (0..60).map(|number| number as f32).collect();
        let turned = layout.of_grid(&values);
        for (node, value) in values.iter().enumerate() {
            assert_eq!(turned[layout.node(node)], *value);
        }
        assert_eq!(layout.to_grid(&turned), values);
    }
}
