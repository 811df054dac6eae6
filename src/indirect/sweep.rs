//! Light carried across the grid along every ordinate. In go matter, sources and what comes in from outside, out come moments of radiance. Invariant: sums have a
//! fixed order, so the same field comes from any number of threads.
//!
//! Planes of nodes across the ordinate's largest component follow one another; each node takes what leaves the four cells before it, half a cell
//! of matter, its own source, and half a cell again (a step scheme of second order; Lewis & Miller 1984, "Computational Methods of Neutron Transport", chapter 4).

use super::grid::Grid;
use super::harmonics::{COUNT, basis};
use super::matter::Matter;
use super::moments::Moments;
use super::ordinates::{Ordinate, Ordinates};
use super::walls::{Walls, link_of};
use crate::color::Rgb;
use glam::DVec3;
use rayon::prelude::*;

/// What is swept over.
pub(super) struct Sweeper<'a> {
    pub(super) grid: &'a Grid,
    pub(super) matter: &'a Matter,
    pub(super) walls: &'a Walls,
    pub(super) ordinates: &'a Ordinates,
    /// Whether nobody waits for the light any more.
    pub(super) cancelled: &'a (dyn Fn() -> bool + Sync),
}

/// Where light of a sweep comes from.
pub(super) struct Sources<'a> {
    /// Of matter, per metre and steradian.
    pub(super) of_matter: &'a Moments,
    /// Radiance that leaves each wall patch, by channel.
    pub(super) of_walls: &'a [Vec<f32>; 3],
    /// Radiance from outside along each ordinate.
    pub(super) inflow: &'a [Rgb],
}

impl Sweeper<'_> {
    /// The moments of radiance that sources give where they, and nothing else, are scattered no more.
    pub(super) fn sweep(&self, sources: &Sources) -> Moments {
        let groups: Vec<(usize, f64)> =
            [0, 1, 2].into_iter().flat_map(|axis| [(axis, 1.0), (axis, -1.0)]).collect();
        let partial: Vec<Moments> = groups
            .par_iter()
            .map(|&(axis, sign)| {
                let mut group = Group::new(self, sources, axis, sign);
                for (number, ordinate) in self.ordinates.iter().enumerate() {
                    if (self.cancelled)() {
                        break;
                    }
                    if main_axis(ordinate.direction) == axis && ordinate.direction[axis].signum() == sign {
                        group.carry(ordinate, sources.inflow[number]);
                    }
                }
                group.moments
            })
            .collect();
        let mut moments = Moments::zero(self.grid.count());
        for group in &partial {
            moments.add(group, [1.0; 3]);
        }
        moments
    }
}

/// The one along which a direction goes most.
fn main_axis(direction: DVec3) -> usize {
    let along = direction.abs();
    // Equal ones differ by rounding. The last of them: rows of its planes lie side by side in memory.
    let most = along.max_element() - 1e-9;
    (0..3).rev().find(|axis| along[*axis] >= most).expect("one is the largest")
}

/// Ordinates that cross the same planes in the same order.
struct Group<'a> {
    sweeper: &'a Sweeper<'a>,
    sources: &'a Sources<'a>,
    planes: Planes,
    moments: Moments,
    /// Of each node for one ordinate and channel: what half a cell lets through, what it adds, and the radiance in the middle.
    through: Vec<f32>,
    added: Vec<f32>,
    radiance: Vec<f32>,
    leaf_extinction: Vec<f32>,
    /// What leaves the cells of a plane, with a rim of what comes from outside.
    before: Vec<f32>,
    behind: Vec<f32>,
}

/// How planes lie in memory.
#[derive(Clone, Copy)]
struct Planes {
    axis: usize,
    is_forwards: bool,
    /// Across the planes, and along their rows and columns: how many nodes, and how far apart.
    count: [usize; 3],
    stride: [usize; 3],
    /// Which axes those are.
    axes: [usize; 3],
}

impl Planes {
    fn new(grid: &Grid, axis: usize, is_forwards: bool) -> Self {
        // Columns are neighbours in memory wherever that is possible.
        let axes = [axis, [2, 2, 1][axis], [1, 0, 0][axis]];
        Self {
            axis,
            is_forwards,
            count: axes.map(|axis| grid.size[axis]),
            stride: axes.map(|axis| grid.strides()[axis]),
            axes,
        }
    }

    /// The node at the start of a plane, which are counted the way that light goes.
    fn start(&self, plane: usize) -> usize {
        let plane = if self.is_forwards { plane } else { self.count[0] - 1 - plane };
        plane * self.stride[0]
    }

    /// Length of a row with its rim.
    fn row(&self) -> usize {
        self.count[2] + 2
    }
}

/// The four cells that light comes from: steps along rows and columns, and shares.
struct Taps {
    steps: [i32; 2],
    shares: [f32; 4],
}

impl Taps {
    fn of(ordinate: DVec3, planes: &Planes) -> Self {
        let along = ordinate[planes.axis].abs();
        let back = [1, 2].map(|which| -ordinate[planes.axes[which]] / along);
        let [row, column] = back.map(f64::abs);
        let shares = [(1.0 - row) * (1.0 - column), (1.0 - row) * column, row * (1.0 - column), row * column];
        Self { steps: back.map(|back| back.signum() as i32), shares: shares.map(|share| share as f32) }
    }
}

impl<'a> Group<'a> {
    fn new(sweeper: &'a Sweeper<'a>, sources: &'a Sources<'a>, axis: usize, sign: f64) -> Self {
        let planes = Planes::new(sweeper.grid, axis, sign > 0.0);
        let count = sweeper.grid.count();
        let plane = (planes.count[1] + 2) * planes.row();
        Self {
            sweeper,
            sources,
            planes,
            moments: Moments::zero(count),
            through: vec![0.0; count],
            added: vec![0.0; count],
            radiance: vec![0.0; count],
            leaf_extinction: vec![0.0; count],
            before: vec![0.0; plane],
            behind: vec![0.0; plane],
        }
    }

    fn carry(&mut self, ordinate: &Ordinate, inflow: Rgb) {
        let Sweeper { grid, matter, .. } = *self.sweeper;
        let basis = basis(ordinate.direction).map(|value| value as f32);
        for leaves in &matter.leaves {
            self.leaf_extinction[leaves.node] = leaves.extinction(ordinate.direction);
        }
        let half_way = (0.5 * grid.cell_m / ordinate.direction[self.planes.axis].abs()) as f32;
        let taps = Taps::of(ordinate.direction, &self.planes);
        for channel in 0..3 {
            self.prepare(channel, &basis, half_way);
            self.cross(channel, &taps, inflow[channel] as f32);
            let weight = ordinate.weight as f32;
            let moments = self.moments.of_channel_mut(channel);
            for (sums, value) in moments.chunks_exact_mut(grid.count()).zip(basis) {
                let factor = weight * value;
                for (sum, radiance) in sums.iter_mut().zip(&self.radiance) {
                    *sum += factor * radiance;
                }
            }
        }
    }

    /// What half a cell does to light of one channel along an ordinate.
    fn prepare(&mut self, channel: usize, basis: &[f32; COUNT], half_way: f32) {
        let Self { sweeper, sources, through, added, leaf_extinction, .. } = self;
        added.fill(0.0);
        for (index, value) in basis.iter().enumerate() {
            for (sum, source) in added.iter_mut().zip(sources.of_matter.channel(channel, index)) {
                *sum += value * source;
            }
        }
        let fog = &sweeper.matter.fog_extinction[channel];
        for (((through, added), fog), leaves) in through.iter_mut().zip(added).zip(fog).zip(&*leaf_extinction)
        {
            let depth = half_way * (fog + leaves);
            let (transmitted, mean) = exp_minus_and_mean(depth);
            *through = transmitted;
            // Harmonics cut short may be negative where they should be nearly nothing; sums over ordinates are right only if that stays.
            *added *= half_way * mean;
        }
    }

    /// Carries light from plane to plane.
    fn cross(&mut self, channel: usize, taps: &Taps, inflow: f32) {
        let planes = self.planes;
        let (row, [_, rows, columns]) = (planes.row(), planes.count);
        self.before.fill(inflow);
        self.behind.fill(inflow);
        for plane in 0..planes.count[0] {
            let start = planes.start(plane);
            for at in 0..rows {
                let here = (at + 1) * row + 1;
                let there = (here as i32 + taps.steps[0] * row as i32) as usize;
                let shifted = |place: usize| (place as i32 + taps.steps[1]) as usize;
                let sides = [here, shifted(here), there, shifted(there)]
                    .map(|from| &self.before[from..from + columns]);
                let out = &mut self.behind[here..here + columns];
                let node = start + at * planes.stride[1];
                if planes.stride[2] == 1 {
                    let nodes = node..node + columns;
                    let matter = (&self.through[nodes.clone()], &self.added[nodes.clone()]);
                    cross_row(&taps.shares, sides, matter, &mut self.radiance[nodes], out);
                    continue;
                }
                for column in 0..columns {
                    let entering = taps.shares[0] * sides[0][column]
                        + taps.shares[1] * sides[1][column]
                        + taps.shares[2] * sides[2][column]
                        + taps.shares[3] * sides[3][column];
                    let node = node + column * planes.stride[2];
                    let middle = entering * self.through[node] + self.added[node];
                    self.radiance[node] = middle;
                    out[column] = middle * self.through[node] + self.added[node];
                }
            }
            self.past_walls(channel, taps, plane);
            std::mem::swap(&mut self.before, &mut self.behind);
        }
    }

    /// The same for nodes some of whose neighbours are behind walls: from there comes what the walls send out.
    fn past_walls(&mut self, channel: usize, taps: &Taps, plane: usize) {
        let planes = self.planes;
        let cell = if planes.is_forwards { plane } else { planes.count[0] - 1 - plane };
        let backwards = if planes.is_forwards { -1 } else { 1 };
        for &number in self.sweeper.walls.of_plane(planes.axis, cell) {
            let walled = self.sweeper.walls.node(number);
            let place = self.sweeper.grid.cell_of(walled.node);
            let here = (place[planes.axes[1]] + 1) * planes.row() + place[planes.axes[2]] + 1;
            let mut entering = 0.0;
            for (tap, share) in taps.shares.iter().enumerate().filter(|(_, share)| **share > 0.0) {
                let mut step = [0; 3];
                step[planes.axes[0]] = backwards;
                step[planes.axes[1]] = if tap & 2 != 0 { taps.steps[0] } else { 0 };
                step[planes.axes[2]] = if tap & 1 != 0 { taps.steps[1] } else { 0 };
                let from = here as i32 + step[planes.axes[1]] * planes.row() as i32 + step[planes.axes[2]];
                entering += share
                    * match walled.wall_at(link_of(step)) {
                        Some(patch) => self.sources.of_walls[channel][patch],
                        None => self.before[from as usize],
                    };
            }
            let middle = entering * self.through[walled.node] + self.added[walled.node];
            self.radiance[walled.node] = middle;
            self.behind[here] = middle * self.through[walled.node] + self.added[walled.node];
        }
    }
}

/// A row whose nodes are neighbours in memory: the same sums in the same order, eight at once.
fn cross_row(
    shares: &[f32; 4],
    sides: [&[f32]; 4],
    (through, added): (&[f32], &[f32]),
    radiance: &mut [f32],
    out: &mut [f32],
) {
    let columns = out.len();
    let [a, b, c, d] = sides.map(|side| &side[..columns]);
    let (through, added, radiance) = (&through[..columns], &added[..columns], &mut radiance[..columns]);
    for column in 0..columns {
        let entering =
            shares[0] * a[column] + shares[1] * b[column] + shares[2] * c[column] + shares[3] * d[column];
        let middle = entering * through[column] + added[column];
        radiance[column] = middle;
        out[column] = middle * through[column] + added[column];
    }
}

/// `exp(-x)` and its mean over `0..x`, `x >= 0`, within 3e-6 of 1: no branch and no call, so that eight are found at once.
///
/// Padé's approximation of `exp(-x / 16)`, squared four times.
#[inline(always)]
fn exp_minus_and_mean(x: f32) -> (f32, f32) {
    /// Nothing is left of light beyond it.
    const MOST: f32 = 24.0;
    let bounded = x.min(MOST);
    let z = bounded * (1.0 / 16.0);
    let even = 1.0 + z * z * (1.0 / 12.0);
    let root = (even - 0.5 * z) / (even + 0.5 * z);
    let square = root * root;
    let fourth = square * square;
    let eighth = fourth * fourth;
    // 1 - r = z / (even + z / 2), and 1 - r^16 is that times (1 + r)(1 + r^2)(1 + r^4)(1 + r^8): no digits are lost where hardly any light is.
    let of_bounded =
        (1.0 / 16.0) / (even + 0.5 * z) * ((1.0 + root) * (1.0 + square)) * ((1.0 + fourth) * (1.0 + eighth));
    let beyond = if x > MOST { MOST / x } else { 1.0 };
    let (power, mean) = (eighth * eighth, of_bounded * beyond);
    (power, mean)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_exponential_is_one() {
        for step in 0..4000 {
            let x = 0.01 * f64::from(step);
            let (power, mean) = exp_minus_and_mean(x as f32);
            let expected = if x > 0.0 { -(-x).exp_m1() / x } else { 1.0 };
            assert!((f64::from(power) - (-x).exp()).abs() < 3e-6, "{x}: {power}");
            assert!((f64::from(mean) - expected).abs() < 3e-6, "{x}: {mean} {expected}");
        }
    }
}
