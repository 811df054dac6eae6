//! Probability density over a rectangle, learned from points. In go points with weights, out come places as
//! dense as these. Invariant: the density is positive in all of the rectangle about the points.
//!
//! A k-d tree halves the points' weight again and again, across the longer side of what is left (Bentley
//! 1975, "Multidimensional binary search trees used for associative searching"). Each leaf has the same
//! probability.

use glam::DVec2;

/// Number of points for each leaf: fewer give the noise of the points for their density.
const POINTS_OF_A_LEAF: usize = 4;
/// Maximum number of cuts above a leaf.
const DEEPEST: u32 = 9;
/// Margin about the points, as a share of their extent.
const MARGIN: f64 = 0.02;
/// Minimum share of each part in the length that a cut divides.
const LEAST_PART: f64 = 1e-3;

/// A density that is even in each leaf of a k-d tree.
#[derive(Clone, Debug)]
pub struct KdDensity {
    all: Rectangle,
    /// Number of cuts above each leaf.
    depth: u32,
    /// Cuts by node. The parts of node `n` are the nodes `2 n + 1` and `2 n + 2`.
    cuts: Vec<f64>,
}

#[derive(Clone, Copy, Debug)]
struct Rectangle {
    low: DVec2,
    high: DVec2,
}

impl Rectangle {
    /// Axis of the longer side, which a cut divides.
    fn longer(self) -> usize {
        let size = self.high - self.low;
        usize::from(size.y > size.x)
    }

    fn parts(self, axis: usize, cut: f64) -> [Self; 2] {
        let [mut below, mut above] = [self; 2];
        (below.high[axis], above.low[axis]) = (cut, cut);
        [below, above]
    }

    fn area(self) -> f64 {
        (self.high - self.low).element_product()
    }
}

impl KdDensity {
    /// Density by weighted points; `None` without any two of them that differ.
    pub fn of(mut points: Vec<(DVec2, f64)>) -> Option<Self> {
        let (low, high) =
            points.iter().fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(low, high), (at, _)| {
                (low.min(*at), high.max(*at))
            });
        let extent = (high - low).max_element();
        if !(extent > 0.0 && extent.is_finite()) {
            return None;
        }
        let margin = DVec2::splat(MARGIN * extent);
        let all = Rectangle { low: low - margin, high: high + margin };
        let depth = (points.len() / POINTS_OF_A_LEAF).max(1).ilog2().min(DEEPEST);
        let mut density = Self { all, depth, cuts: vec![0.0; (1 << depth) - 1] };
        density.divide(&mut points, all, 0);
        Some(density)
    }

    /// Cuts a node and all nodes below.
    fn divide(&mut self, points: &mut [(DVec2, f64)], node: Rectangle, number: usize) {
        if number >= self.cuts.len() {
            return;
        }
        let axis = node.longer();
        points.sort_by(|(a, _), (b, _)| a[axis].total_cmp(&b[axis]));
        let half = 0.5 * points.iter().map(|(_, weight)| weight).sum::<f64>();
        let mut so_far = 0.0;
        let middle = points.iter().position(|(_, weight)| {
            so_far += weight;
            so_far >= half
        });
        let middle = middle.unwrap_or(0);
        let (low, high) = (node.low[axis], node.high[axis]);
        let wanted = match (points.get(middle), points.get(middle + 1)) {
            (Some((at, _)), Some((next, _))) => 0.5 * (at[axis] + next[axis]),
            (Some((at, _)), None) => at[axis],
            _ => 0.5 * (low + high),
        };
        let least = LEAST_PART * (high - low);
        let cut = wanted.clamp(low + least, high - least);
        self.cuts[number] = cut;
        let [below, above] = node.parts(axis, cut);
        let (of_below, of_above) = points.split_at_mut(points.partition_point(|(at, _)| at[axis] < cut));
        self.divide(of_below, below, 2 * number + 1);
        self.divide(of_above, above, 2 * number + 2);
    }

    /// Place that two uniform numbers sample.
    pub fn sample(&self, mut u: DVec2) -> DVec2 {
        let leaf = self.leaf(|axis, _| {
            let is_above = u[axis] >= 0.5;
            u[axis] = 2.0 * u[axis] - f64::from(u8::from(is_above));
            is_above
        });
        leaf.low + u * (leaf.high - leaf.low)
    }

    /// Probability density at a place.
    pub fn pdf(&self, at: DVec2) -> f64 {
        if at.cmplt(self.all.low).any() || at.cmpgt(self.all.high).any() || at.is_nan() {
            return 0.0;
        }
        let leaf = self.leaf(|axis, cut| at[axis] >= cut);
        0.5_f64.powi(self.depth as i32) / leaf.area()
    }

    /// Leaf that is found by going above or below each cut.
    fn leaf(&self, mut is_above: impl FnMut(usize, f64) -> bool) -> Rectangle {
        let (mut node, mut number) = (self.all, 0);
        while let Some(&cut) = self.cuts.get(number) {
            let axis = node.longer();
            let above = is_above(axis, cut);
            node = node.parts(axis, cut)[usize::from(above)];
            number = 2 * number + 1 + usize::from(above);
        }
        node
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Sampler;

    /// Samples lie where the points are, and the mean of the inverse density is the rectangle's area.
    #[test]
    fn places_are_as_dense_as_points() {
        let uniform = |sample| DVec2::from(Sampler::new(3, 1, 2, sample).next_2d());
        let point = |sample| {
            let at = uniform(sample);
            let at = if sample % 4 == 0 { at * DVec2::new(1.0, 4.0) } else { at * 0.1 };
            (at, 1.0)
        };
        let density = KdDensity::of((0..2048).map(point).collect()).expect("points that differ");
        let count = 1 << 12;
        let (mut inverse, mut in_corner) = (0.0, 0);
        for sample in 0..count {
            let at = density.sample(uniform(sample));
            inverse += 1.0 / density.pdf(at) / f64::from(count);
            in_corner += u32::from(at.max_element() < 0.1);
        }
        let area = density.all.area();
        assert!((inverse / area - 1.0).abs() < 1e-9, "{inverse} instead of {area}");
        let share = f64::from(in_corner) / f64::from(count);
        assert!((0.65..0.85).contains(&share), "{share}");
        assert_eq!(density.pdf(DVec2::splat(5.0)), 0.0);
    }
}
