//! What comes into a grid from outside, as a sweep meets it. In go the sky or a larger grid, out come the
//! rims of planes. Invariant: without either all rims are black.

use super::halo::Halo;
use super::planes::Planes;
use crate::color::Rgb;

/// Radiance from outside.
#[derive(Clone, Copy)]
pub(super) enum Inflow<'a> {
    Nothing,
    /// Along each ordinate, the same on all sides.
    Even(&'a [Rgb]),
    /// Of a larger grid.
    Around(&'a Halo),
}

/// What comes from outside along one ordinate.
pub(super) struct Arriving<'a> {
    pub(super) inflow: Inflow<'a>,
    /// Its number.
    pub(super) ordinate: usize,
}

impl Arriving<'_> {
    /// The rim of a plane, and all of one before the first or past the last.
    pub(super) fn fill(&self, into: &mut [f32], planes: &Planes, channel: usize, plane: i32) {
        let halo = match self.inflow {
            Inflow::Nothing => return into.fill(0.0),
            Inflow::Even(radiances) => return into.fill(radiances[self.ordinate][channel] as f32),
            Inflow::Around(halo) => halo,
        };
        let [count, rows, columns] = planes.count.map(|count| count as i32);
        let is_outside = plane < 0 || plane == count;
        for row in -1..=rows {
            let is_rim = is_outside || row < 0 || row == rows;
            let step = if is_rim { 1 } else { columns as usize + 1 };
            for column in (-1..=columns).step_by(step) {
                let mut place = [0; 3];
                for (axis, index) in planes.axes.into_iter().zip([plane, row, column]) {
                    place[axis] = index;
                }
                let at = (row + 1) as usize * planes.row() + (column + 1) as usize;
                into[at] = halo.radiance(place, channel, self.ordinate);
            }
        }
    }
}
