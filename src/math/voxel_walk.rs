//! Traversal of voxels along a line, cell by cell. In goes a line, out come the cells that are not empty, and
//! integrals. Invariant: along a line a trilinear cell is a cubic, so its integral is exact.

use super::voxels::{Corners, Neighbours, Voxels};
use super::{Cubic, Ray};
use glam::{DVec3, IVec3};
use std::ops::ControlFlow;

/// Values of a cell along the line's part in it.
pub struct Passed {
    /// Distances at which the line enters and leaves.
    pub start: f64,
    pub end: f64,
    /// Values by distance from `start`.
    pub values: Cubic,
}

impl Passed {
    /// Integral over the line's part in the cell.
    pub fn integral(&self) -> f64 {
        self.values.integral(self.end - self.start)
    }
}

impl Voxels {
    /// Calls `passed` for the cells on a range of a line in voxel space, in order, without empty ones. The
    /// line's direction may have any length.
    pub fn for_each_cell(&self, line: &Ray, range: (f64, f64), mut passed: impl FnMut(Passed)) {
        self.try_for_each_cell(line, range, |cell| {
            passed(cell);
            ControlFlow::Continue(())
        });
    }

    /// As [`Self::for_each_cell`], until `passed` breaks.
    fn try_for_each_cell(
        &self,
        line: &Ray,
        (start, end): (f64, f64),
        mut passed: impl FnMut(Passed) -> ControlFlow<()>,
    ) {
        let (low, high) = self.bounds();
        let way = Way::new(line);
        let Some((mut t, end)) = way.clipped((low, high), (start, end)) else { return };
        let (low, last) = (low.as_ivec3(), high.as_ivec3() - 1);
        let mut cell = line.at(t).floor().as_ivec3().clamp(low, last);
        let mut here = self.begin(&way, cell);
        while t < end {
            let axis;
            if let Some(Here { corners, exits, .. }) = &mut here {
                axis = nearest(exits);
                let leaves = exits[axis].clamp(t, end);
                if leaves > t && corners.values.iter().any(|value| *value > 0.0) {
                    let values = way.cubic(&corners.values, line.at(t) - cell.as_dvec3());
                    if passed(Passed { start: t, end: leaves, values }).is_break() {
                        return;
                    }
                }
                t = leaves;
                cell[axis] += way.step[axis];
                exits[axis] = way.exit(axis, cell[axis], cell[axis] + 1);
            } else {
                let (from, to) = self.block_of(cell);
                let exits = std::array::from_fn(|axis| way.exit(axis, from[axis], to[axis]));
                axis = nearest(&exits);
                t = exits[axis].clamp(t, end);
                // Rounding must not leave a block by another side than that of its exit.
                cell = line.at(t).floor().as_ivec3().clamp(from, to - 1);
                cell[axis] = if way.step[axis] > 0 { to[axis] } else { from[axis] - 1 };
            }
            if cell[axis] < low[axis] || cell[axis] > last[axis] {
                return;
            }
            match &mut here {
                Some(Here { bricks, corners, .. })
                    if self.is_in_the_brick_before(cell, axis, way.step[axis]) =>
                {
                    self.step_corners(bricks, corners, cell, (axis, way.step[axis] > 0));
                }
                _ => here = self.begin(&way, cell),
            }
        }
    }

    /// State of a line in a cell; `None` if its brick is empty.
    #[inline]
    fn begin(&self, way: &Way, cell: IVec3) -> Option<Here> {
        let bricks = self.bricks_about(cell)?;
        let exits = std::array::from_fn(|axis| way.exit(axis, cell[axis], cell[axis] + 1));
        Some(Here { corners: self.corners(&bricks, cell), bricks, exits })
    }

    /// Integral over a range of a line, in units of `t`.
    pub fn integral(&self, line: &Ray, range: (f64, f64)) -> f64 {
        let mut sum = 0.0;
        self.for_each_cell(line, range, |cell| sum += cell.integral());
        sum
    }

    /// As [`Self::integral`], or any number above `most` once the sum exceeds that.
    pub fn integral_up_to(&self, line: &Ray, range: (f64, f64), most: f64) -> f64 {
        let mut sum = 0.0;
        self.try_for_each_cell(line, range, |cell| {
            sum += cell.integral();
            if sum > most { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        });
        sum
    }

    /// Integrals from the first of some places on a line, in order, to each.
    pub fn integrals(&self, line: &Ray, places: &[f64]) -> Vec<f64> {
        let (mut sum, mut integrals) = (0.0, Vec::with_capacity(places.len()));
        let [Some(&first), Some(&last)] = [places.first(), places.last()] else { return integrals };
        self.for_each_cell(line, (first, last), |cell| {
            while let Some(place) = places.get(integrals.len()).filter(|place| **place < cell.end) {
                let within = (place - cell.start).max(0.0);
                integrals.push(sum + cell.values.integral(within));
            }
            sum += cell.integral();
        });
        integrals.resize(places.len(), sum);
        integrals
    }
}

/// The cell that a line has reached.
struct Here {
    bricks: Neighbours,
    corners: Corners,
    /// Distances at which the line leaves it along each axis.
    exits: [f64; 3],
}

/// A line, prepared for planes at right angles to the axes and for cells.
struct Way {
    origin: DVec3,
    direction: DVec3,
    /// Products of two coordinates of its direction: y z, x z, x y.
    products: DVec3,
    /// Change of `t` over a voxel along each axis.
    per_voxel: DVec3,
    step: [i32; 3],
}

impl Way {
    fn new(&Ray { origin, direction }: &Ray) -> Self {
        let step = direction.to_array().map(|along| if along < 0.0 { -1 } else { 1 });
        let products =
            DVec3::new(direction.y * direction.z, direction.x * direction.z, direction.x * direction.y);
        Self { origin, direction, products, per_voxel: direction.recip(), step }
    }

    /// Trilinear interpolation between corners, x fastest, along the line from a place within the cell, as a
    /// cubic.
    #[inline]
    fn cubic(&self, corners: &[f32; 8], at: DVec3) -> Cubic {
        let along = self.direction;
        let [c0, cx, cy, cxy, cz, cxz, cyz, cxyz] = corners.map(f64::from);
        // As a polynomial of the three coordinates.
        let (x, y, z) = (cx - c0, cy - c0, cz - c0);
        let (xy, xz, yz) = (cxy - cx - y, cxz - cx - z, cyz - cy - z);
        let xyz = cxyz - cxy - cxz + cx - yz;
        // Slopes at the line's start.
        let (by_yz, by_xz, by_xy) = (yz + xyz * at.x, xz + xyz * at.y, xy + xyz * at.z);
        let (by_x, by_y) = (x + xy * at.y + by_xz * at.z, y + yz * at.z);
        let value = c0 + by_x * at.x + by_y * at.y + z * at.z;
        let slope =
            by_x * along.x + (by_y + by_xy * at.x) * along.y + (z + yz * at.y + by_xz * at.x) * along.z;
        let bend = by_yz * self.products.x + by_xz * self.products.y + by_xy * self.products.z;
        Cubic([value, slope, bend, xyz * along.x * self.products.x])
    }

    /// Distance at which it leaves the slab between two planes at right angles to an axis.
    #[inline]
    fn exit(&self, axis: usize, low: i32, high: i32) -> f64 {
        let per_voxel = self.per_voxel[axis];
        let side = if self.step[axis] > 0 { high } else { low };
        if per_voxel.is_finite() { (f64::from(side) - self.origin[axis]) * per_voxel } else { f64::INFINITY }
    }

    /// Part of a range within a box; `None` if there is none.
    fn clipped(&self, (low, high): (DVec3, DVec3), (start, end): (f64, f64)) -> Option<(f64, f64)> {
        let (mut start, mut end) = (start, end);
        for axis in 0..3 {
            let (origin, per_voxel) = (self.origin[axis], self.per_voxel[axis]);
            if !per_voxel.is_finite() {
                if origin < low[axis] || origin > high[axis] {
                    return None;
                }
                continue;
            }
            let (a, b) = ((low[axis] - origin) * per_voxel, (high[axis] - origin) * per_voxel);
            start = start.max(a.min(b));
            end = end.min(a.max(b));
        }
        (start < end).then_some((start, end))
    }
}

/// The axis along which a line leaves first.
#[inline]
fn nearest(exits: &[f64; 3]) -> usize {
    let first = if exits[1] < exits[0] { 1 } else { 0 };
    if exits[2] < exits[first] { 2 } else { first }
}

#[cfg(test)]
mod tests {
    use super::super::voxels::VoxelsBuilder;
    use super::*;

    /// Two separate bricks with irregular values.
    fn apart() -> Voxels {
        let mut builder = VoxelsBuilder::default();
        let value = |place: usize, seed: usize| ((place * 7919 + seed) % 101) as f32 / 101.0;
        builder.add(IVec3::new(-8, 0, 8), (0..512).map(|place| value(place, 3)));
        builder.add(IVec3::new(16, 8, -16), (0..512).map(|place| value(place, 17)));
        builder.built().expect("it holds something")
    }

    fn lines() -> impl Iterator<Item = Ray> {
        let unit = |index: usize, of: usize| ((index * of) % 997) as f64 / 997.0 - 0.5;
        (1..400).map(move |index| {
            let middle =
                if index % 2 == 0 { DVec3::new(-4.0, 4.0, 12.0) } else { DVec3::new(20.0, 12.0, -12.0) };
            let aim = middle + 9.0 * DVec3::new(unit(index, 31), unit(index, 57), unit(index, 83));
            let mut direction = DVec3::new(unit(index, 13), unit(index, 29), unit(index, 41)).normalize();
            if index % 5 == 0 {
                // Sometimes along an axis, and every other time in a face of cells.
                direction = DVec3::AXES[index % 3];
            }
            let aim = if index % 10 == 0 { aim.round() } else { aim };
            Ray { origin: aim - 60.0 * direction, direction }
        })
    }

    /// Compared with a sum of many steps, for rays through both bricks, one or none.
    #[test]
    fn integrals_are_those_of_many_steps() {
        let voxels = apart();
        let mut most = 0.0_f64;
        for line in lines() {
            let found = voxels.integral(&line, (0.0, 120.0));
            let steps = 60_000;
            let width = 120.0 / f64::from(steps);
            let expected: f64 =
                (0..steps).map(|step| width * voxels.at(line.at((f64::from(step) + 0.5) * width))).sum();
            assert!((found - expected).abs() < 1e-6 * expected.max(1.0), "{line:?}: {found} {expected}");
            most = most.max(found);
        }
        assert!(most > 3.0, "{most}");
    }

    /// Parts add up, in both directions.
    #[test]
    fn parts_of_a_line_add_up() {
        let voxels = apart();
        for line in lines() {
            let all = voxels.integral(&line, (0.0, 120.0));
            let parts = voxels.integral(&line, (0.0, 58.3)) + voxels.integral(&line, (58.3, 120.0));
            let back = Ray { origin: line.at(120.0), direction: -line.direction };
            let back = voxels.integral(&back, (0.0, 120.0));
            assert!(
                (all - parts).abs() < 1e-9 && (all - back).abs() < 1e-9,
                "{line:?}: {all} {parts} {back}"
            );
        }
    }

    /// Within a cell as between its corners.
    #[test]
    fn a_cell_is_a_cubic_along_a_line() {
        let voxels = apart();
        let mut cells = 0;
        for line in lines() {
            voxels.for_each_cell(&line, (0.0, 120.0), |cell| {
                for share in [0.0, 0.3, 0.8, 1.0] {
                    let from_start = share * (cell.end - cell.start);
                    let expected = voxels.at(line.at(cell.start + from_start));
                    let found = cell.values.at(from_start);
                    assert!((found - expected).abs() < 1e-9, "{line:?}: {found} {expected}");
                }
                cells += 1;
            });
        }
        assert!(cells > 1000, "{cells}");
    }

    #[test]
    fn one_value_all_over_is_as_long_as_its_way() {
        let mut builder = VoxelsBuilder::default();
        builder.add_even(IVec3::new(0, 0, 0), 16, 2.0).expect("it is small");
        let voxels = builder.built().expect("it holds something");
        // It is uniform from the first voxel to the last, and falls to 0 within one more on either side.
        let line = Ray { origin: DVec3::new(-50.0, 7.25, 3.5), direction: DVec3::X };
        assert!((voxels.integral(&line, (0.0, 100.0)) - 2.0 * 16.0).abs() < 1e-12);
        assert_eq!(voxels.bounds(), (DVec3::splat(-1.0), DVec3::splat(16.0)));
    }

    #[test]
    fn nothing_and_too_much_are_refused() {
        use super::super::voxels::VoxelsError;
        let mut builder = VoxelsBuilder::default();
        builder.add(IVec3::ZERO, [0.0, -1.0]);
        assert_eq!(builder.built().expect_err("it holds nothing"), VoxelsError::Empty);
        let mut builder = VoxelsBuilder::default();
        assert!(builder.add_even(IVec3::ZERO, 4096, 1.0).is_err());
        builder.add(IVec3::ZERO, [1.0]);
        builder.add(IVec3::splat(1 << 20), [1.0]);
        assert!(matches!(builder.built(), Err(VoxelsError::TooWide(_))));
        for corner in [i32::MIN, i32::MAX - 7] {
            let mut builder = VoxelsBuilder::default();
            builder.add(IVec3::splat(corner), [1.0]);
            assert_eq!(builder.built().expect_err("it lies too far out"), VoxelsError::TooFar);
        }
    }

    /// With a limit, sums below it are complete, and larger ones exceed it.
    #[test]
    fn what_is_too_much_is_not_counted() {
        let voxels = apart();
        for line in lines() {
            let all = voxels.integral(&line, (0.0, 120.0));
            let some = voxels.integral_up_to(&line, (0.0, 120.0), 1.0);
            assert!(
                if all > 1.0 { 1.0 < some && some <= all } else { some == all },
                "{line:?}: {all} {some}"
            );
        }
    }
}
