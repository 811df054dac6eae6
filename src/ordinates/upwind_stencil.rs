//! Upwind stencil of an ordinate: the four cells of the plane before from which light comes to a node. In go
//! a direction and how much room walls leave, out come shares. Invariant: shares add up to 1, so even light
//! stays even.

use super::planes::Planes;
use glam::DVec3;

/// Steps along rows and columns, and shares.
pub(super) struct UpwindStencil {
    /// Against the light's way along the planes.
    pub(super) backwards: i32,
    steps: [i32; 2],
    /// How far light goes along rows and columns from one plane to the next, in cells, `0..=1`.
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

    /// The step to one of the four, along planes, rows and columns.
    pub(super) fn step(&self, tap: usize) -> [i32; 3] {
        let [row, column] = self.steps;
        [self.backwards, if tap & 2 != 0 { row } else { 0 }, if tap & 1 != 0 { column } else { 0 }]
    }

    /// Shares where walls leave a node so much room along rows and columns, in cells: what comes in from one
    /// side fills less of it the sooner (cut cells; Ingram, Causon & Mingham 2003, "Developments in Cartesian
    /// cut cell methods").
    pub(super) fn shares_of_cut(&self, room: [f32; 2]) -> [f32; 4] {
        if room == [1.0; 2] {
            return self.shares;
        }
        shares([0, 1].map(|which| (self.across[which] / f64::from(room[which])).min(1.0)))
    }
}

fn shares([row, column]: [f64; 2]) -> [f32; 4] {
    let shares = [(1.0 - row) * (1.0 - column), (1.0 - row) * column, row * (1.0 - column), row * column];
    shares.map(|share| share as f32)
}
