//! Upwind stencil of an ordinate: the four cells of the plane before from which radiance enters a cell. In go
//! a direction and the room between walls, out come shares. Invariant: shares add up to 1, so uniform light
//! stays uniform.

use super::planes::Planes;
use glam::DVec3;

/// Steps along rows and columns, and shares.
pub(super) struct UpwindStencil {
    /// Step against the direction of light across planes: 1 or -1.
    pub(super) backwards: i32,
    steps: [i32; 2],
    /// Shift of the ordinate along rows and columns from one plane to the next, in cells, `0..=1`.
    across: [f64; 2],
    pub(super) shares: [f32; 4],
}

impl UpwindStencil {
    pub(super) fn of(direction: DVec3, planes: &Planes) -> Self {
        let along = direction[planes.axis].abs();
        let back = [1, 2].map(|which| -direction[planes.axes[which]] / along);
        let across = back.map(f64::abs);
        Self {
            backwards: -direction[planes.axis].signum() as i32,
            steps: back.map(|back| back.signum() as i32),
            across,
            shares: shares(across),
        }
    }

    /// Step to one of the four cells, across planes and along rows and columns.
    pub(super) fn step(&self, tap: usize) -> [i32; 3] {
        let [row, column] = self.steps;
        [self.backwards, if tap & 2 != 0 { row } else { 0 }, if tap & 1 != 0 { column } else { 0 }]
    }

    /// Shares for a cut cell with so much room along rows and columns, in cells: radiance from one side fills
    /// less room sooner (cut cells; Ingram, Causon & Mingham 2003, "Developments in Cartesian cut cell
    /// methods").
    pub(super) fn shares_of_cut(&self, room: [f32; 2]) -> [f32; 4] {
        if room == [1.0; 2] {
            return self.shares;
        }
        shares([0, 1].map(|which| (self.across[which] / f64::from(room[which])).min(1.0)))
    }
}

/// Bilinear weights of the four cells about the place where the ordinate through a node crosses the plane
/// before, from its shift along rows and columns.
fn shares([row, column]: [f64; 2]) -> [f32; 4] {
    let shares = [(1.0 - row) * (1.0 - column), (1.0 - row) * column, row * (1.0 - column), row * column];
    shares.map(|share| share as f32)
}
