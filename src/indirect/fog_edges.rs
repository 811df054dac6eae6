//! Edges of dense fog in a box, within the cells of a grid. In go a place in fog, out comes the place that
//! nodes tell of. Invariant: where cells are clear, or far from edges, both are the same.
//!
//! Light changes fast within a mean free path of an edge. A node outside has the light at the edge, as
//! nothing changes it in clear air; and one whose cell the edge cuts has that of the middle of its fog.

use crate::ordinates::grid::Grid;
use crate::ordinates::slopes::share;
use crate::snapshot::Snapshot;
use glam::DVec3;

/// A box of dense fog in a grid.
pub(super) struct FogEdges {
    /// Corners of the box in world space, in cells from the grid's first node.
    low: DVec3,
    high: DVec3,
    /// How much the edges matter, `0..=1`.
    share: f64,
}

impl FogEdges {
    /// Edges of the fog in a snapshot; `None` unless it is one dense box along the axes.
    pub(super) fn of(grid: &Grid, snapshot: &Snapshot) -> Option<Self> {
        let [bank] = snapshot.medium.banks() else { return None };
        let (low, high) = bank.level_box()?;
        let in_cells =
            |corner: DVec3| (snapshot.world_from_relative(corner) - grid.position(0)) / grid.cell_m;
        let share = f64::from(share((bank.sigma_t.max_element() * grid.cell_m) as f32));
        (share > 0.0).then(|| Self { low: in_cells(low), high: in_cells(high), share })
    }

    /// The place between nodes whose light a place in fog has.
    pub(super) fn place(&self, grid: &Grid, world: DVec3) -> DVec3 {
        let first = grid.position(0);
        let at = (world - first) / grid.cell_m;
        let moved = DVec3::from_array([0, 1, 2].map(|axis| self.along(axis, at[axis])));
        first + grid.cell_m * at.lerp(moved, self.share)
    }

    fn along(&self, axis: usize, at: f64) -> f64 {
        // The middle of the fog of a row of cells.
        let middle = |cell: f64| {
            let within = |edge: f64| edge.clamp(self.low[axis], self.high[axis]);
            0.5 * (within(cell - 0.5) + within(cell + 0.5))
        };
        let mut cell = at.floor();
        if at < middle(cell) {
            cell -= 1.0;
        } else if at >= middle(cell + 1.0) {
            cell += 1.0;
        }
        let (before, after) = (middle(cell), middle(cell + 1.0));
        if after > before { cell + ((at - before) / (after - before)).clamp(0.0, 1.0) } else { at }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nodes_outside_have_the_light_at_the_edge() {
        let edges = FogEdges { low: DVec3::splat(1.2), high: DVec3::splat(6.0), share: 1.0 };
        // The fog of cell 1 is from 1.2 to 1.5, so its node stands for 1.35.
        for (place, expected) in [(1.2, 0.0), (1.275, 0.5), (1.35, 1.0), (2.0, 2.0), (3.7, 3.7)] {
            let found = edges.along(0, place);
            assert!((found - expected).abs() < 1e-12, "{place}: {found} {expected}");
        }
    }
}
