//! A line through voxels, cell by cell. In go a line, out come the cells that hold something, and integrals.
//! Invariant: along a line a trilinear cell is a cubic, which Simpson's rule integrates exactly.

use super::Ray;
use super::voxels::{Voxels, trilinear};
use glam::{DVec3, IVec3};

/// A cell that a line passes through.
pub struct Passed<'a> {
    line: &'a Ray,
    cell: IVec3,
    corners: [f32; 8],
    /// Where the line comes in and leaves.
    pub start: f64,
    pub end: f64,
}

impl Passed<'_> {
    fn value(&self, t: f64) -> f64 {
        trilinear(&self.corners, self.line.at(t) - self.cell.as_dvec3())
    }

    /// Of its part of the line.
    pub fn integral(&self) -> f64 {
        let ends = self.value(self.start) + self.value(self.end);
        (self.end - self.start) / 6.0 * (ends + 4.0 * self.value(0.5 * (self.start + self.end)))
    }
}

impl Voxels {
    /// Calls `passed` for the cells on a part of a line of the voxels' own space, in order; those of empty
    /// bricks are left out. The line's direction has any length.
    pub fn for_each_cell(&self, line: &Ray, (start, end): (f64, f64), mut passed: impl FnMut(Passed)) {
        let (low, high) = self.bounds();
        let Some((mut t, end)) = clipped(line, (low, high), (start, end)) else { return };
        let last = high.as_ivec3() - 1;
        let mut cell = line.at(t).floor().as_ivec3().clamp(low.as_ivec3(), last);
        let step = IVec3::from_array(line.direction.to_array().map(|along| if along < 0.0 { -1 } else { 1 }));
        while t < end {
            let holds = self.brick_of_cell_holds(cell);
            let (from, to) = if holds { (cell, cell + 1) } else { self.block_of(cell) };
            let (axis, leaves) = exit(line, from, to);
            let leaves = leaves.clamp(t, end);
            if holds && leaves > t {
                passed(Passed { line, cell, corners: self.corners(cell), start: t, end: leaves });
            }
            t = leaves;
            if !holds {
                // Rounding leaves no block by another side than that of its exit.
                cell = line.at(t).floor().as_ivec3().clamp(from, to - 1);
            }
            cell[axis] = if step[axis] > 0 { to[axis] } else { from[axis] - 1 };
            if cell[axis] < low[axis] as i32 || cell[axis] > last[axis] {
                return;
            }
        }
    }

    /// The integral over a part of a line, in units of `t`.
    pub fn integral(&self, line: &Ray, range: (f64, f64)) -> f64 {
        let mut sum = 0.0;
        self.for_each_cell(line, range, |cell| sum += cell.integral());
        sum
    }
}

/// Where a line leaves a box of cells, and by which axis.
fn exit(line: &Ray, low: IVec3, high: IVec3) -> (usize, f64) {
    let mut first = (0, f64::INFINITY);
    for axis in 0..3 {
        let along = line.direction[axis];
        if along == 0.0 {
            continue;
        }
        let side = if along > 0.0 { high[axis] } else { low[axis] };
        let t = (f64::from(side) - line.origin[axis]) / along;
        if t < first.1 {
            first = (axis, t);
        }
    }
    first
}

/// The part of a part of a line that lies in a box; `None` if none does.
fn clipped(line: &Ray, (low, high): (DVec3, DVec3), (start, end): (f64, f64)) -> Option<(f64, f64)> {
    let (mut start, mut end) = (start, end);
    for axis in 0..3 {
        let (origin, along) = (line.origin[axis], line.direction[axis]);
        if along == 0.0 {
            if origin < low[axis] || origin > high[axis] {
                return None;
            }
            continue;
        }
        let (a, b) = ((low[axis] - origin) / along, (high[axis] - origin) / along);
        start = start.max(a.min(b));
        end = end.min(a.max(b));
    }
    (start < end).then_some((start, end))
}

#[cfg(test)]
mod tests {
    use super::super::voxels::VoxelsBuilder;
    use super::*;

    /// Two bricks apart from one another, with values that follow no pattern.
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
                // Along an axis, in a face of cells every other time.
                direction = DVec3::AXES[index % 3];
            }
            let aim = if index % 10 == 0 { aim.round() } else { aim };
            Ray { origin: aim - 60.0 * direction, direction }
        })
    }

    /// Against a sum of many steps, for rays that pass both bricks, one or none.
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

    /// Parts add up, whichever way one goes.
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

    #[test]
    fn one_value_all_over_is_as_long_as_its_way() {
        let mut builder = VoxelsBuilder::default();
        builder.add_even(IVec3::new(0, 0, 0), 16, 2.0).expect("it is small");
        let voxels = builder.built().expect("it holds something");
        // From the first voxel to the last it is even, and one more to either side falls to nothing.
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
    }
}
