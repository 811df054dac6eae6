//! What reaches the light's rays of a slice, summed up beforehand. In go the shadows as they grow,
//! out come integrals of an exponential over what is lit. Invariant: a cell knows its lit part exactly,
//! through its moments; no ray has to look at that part's many pieces again.
//!
//! Over a cell with the centre `c` the integral of `exp(-k (x - c))` over what is lit is
//! `sum((-k)^j m_j)` with the moments `m_j = integral of (x - c)^j / j!` over the same (a multipole
//! expansion: Greengard & Rokhlin 1987, section 2). The moments do not depend on the camera's ray.

use crate::math::{IntervalSet, fast_exp};

/// Moments of a cell. What is left out is `|k h|^8 / 8!` of the integral at most, `h` half the cell.
const ORDER: usize = 8;

/// The largest `|k h|` for which the moments serve: the error is then below 1e-7.
const LARGEST_HALF_CHANGE: f64 = 0.5;

/// However thick the fog, no more cells than this between two breaks.
const MOST_CELLS: f64 = 64.0;

/// A slice's range of reaches, cut into cells.
#[derive(Debug, Default)]
pub(super) struct LitCells {
    /// Where one cell ends and the next begins.
    edges: Vec<f64>,
    moments: Vec<[f64; ORDER]>,
}

/// The optical depth along a part of a ray: `at_start + per_reach * (reach - start)`.
#[derive(Clone, Copy, Debug)]
pub(super) struct DepthLine {
    pub(super) start: f64,
    pub(super) at_start: f64,
    pub(super) per_reach: f64,
}

impl LitCells {
    /// Starts over with everything lit, from 0 to the last of the breaks. Every break is an edge.
    pub(super) fn start(&mut self, breaks: &[f64], cells_per_reach: f64) {
        self.edges.clear();
        self.moments.clear();
        self.edges.push(0.0);
        let mut before = 0.0;
        for &at in breaks {
            let count = ((at - before) * cells_per_reach).ceil().clamp(1.0, MOST_CELLS);
            let half = 0.5 * (at - before) / count;
            self.edges.extend((1..count as u32).map(|cell| before + 2.0 * half * f64::from(cell)));
            self.edges.push(at);
            before = at;
        }
        self.moments.extend(self.edges.windows(2).map(|edges| {
            let half = 0.5 * (edges[1] - edges[0]);
            moments_between(-half, half)
        }));
    }

    /// What lies between two reaches, lit until now, is dark from now on.
    pub(super) fn darken(&mut self, start: f64, end: f64) {
        let first = self.edges.partition_point(|edge| *edge <= start).saturating_sub(1);
        for (edges, moments) in self.edges[first..].windows(2).zip(&mut self.moments[first..]) {
            if edges[0] >= end {
                break;
            }
            let centre = 0.5 * (edges[0] + edges[1]);
            let lost = moments_between(start.max(edges[0]) - centre, end.min(edges[1]) - centre);
            for (moment, lost) in moments.iter_mut().zip(lost) {
                *moment -= lost;
            }
        }
    }

    /// `integral of exp(-tau)` over what is lit between two reaches: where neither the `shadows` that
    /// the cells know of are nor the `more_shadows`, which must not overlap each other.
    pub(super) fn integral(
        &self,
        line: &DepthLine,
        end: f64,
        shadows: &IntervalSet,
        more_shadows: &IntervalSet,
    ) -> f64 {
        let start = line.start;
        let first = self.edges.partition_point(|edge| *edge < start);
        let last = first + self.edges[first..].iter().take_while(|edge| **edge <= end).count();
        // Cells that lie within as a whole.
        let mut cells = first..last.saturating_sub(1).max(first);
        let half = |cell: usize| 0.5 * (self.edges[cell + 1] - self.edges[cell]);
        if cells.is_empty() || line.per_reach.abs() * half(cells.start) > LARGEST_HALF_CHANGE {
            cells = first..first;
        }
        let (mut sum, mut from) = (0.0, start);
        if !cells.is_empty() {
            shadows.for_each_gap(start, self.edges[cells.start], |a, b| sum += line.integral(a, b));
            from = self.edges[cells.end];
            sum += cells.map(|cell| self.cell_integral(cell, line)).sum::<f64>();
        }
        shadows.for_each_gap(from, end, |a, b| sum += line.integral(a, b));
        for &(a, b) in more_shadows.as_slice() {
            shadows.for_each_gap(a.max(start), b.min(end), |a, b| sum -= line.integral(a, b));
        }
        sum
    }

    fn cell_integral(&self, cell: usize, line: &DepthLine) -> f64 {
        let (m, k) = (&self.moments[cell], -line.per_reach);
        let at_centre = fast_exp(-line.at(0.5 * (self.edges[cell] + self.edges[cell + 1])));
        let k2 = k * k;
        let low = (m[0] + k * m[1]) + k2 * (m[2] + k * m[3]);
        let high = (m[4] + k * m[5]) + k2 * (m[6] + k * m[7]);
        at_centre * (low + k2 * k2 * high)
    }
}

/// `integral of x^j / j!` over an interval, for all j.
fn moments_between(low: f64, high: f64) -> [f64; ORDER] {
    let (mut of_low, mut of_high) = (1.0, 1.0);
    std::array::from_fn(|j| {
        let divisor = 1.0 / (j + 1) as f64;
        of_low *= low * divisor;
        of_high *= high * divisor;
        of_high - of_low
    })
}

impl DepthLine {
    fn at(&self, reach: f64) -> f64 {
        self.at_start + self.per_reach * (reach - self.start)
    }

    /// `integral of exp(-tau)` from one reach to another.
    ///
    /// In thin fog and as the ray turns towards the sun nothing cancels.
    #[inline]
    fn integral(&self, from: f64, to: f64) -> f64 {
        let width = to - from;
        let x = 0.5 * self.per_reach * width;
        if x.abs() < 1.0 {
            return width * fast_exp(-self.at(0.5 * (from + to))) * sinhc(x);
        }
        let (a, b) = (self.at(from), self.at(to));
        let change = (b - a).abs();
        width * fast_exp(-a.min(b)) * -(-change).exp_m1() / change
    }
}

/// `sinh(x) / x` for `|x| <= 1`: the first term left out is `x^12 / 13!`, below 2e-10.
#[inline(always)]
fn sinhc(x: f64) -> f64 {
    let x2 = x * x;
    let x4 = x2 * x2;
    (1.0 + x2 * (1.0 / 6.0))
        + x4 * ((1.0 / 120.0 + x2 * (1.0 / 5040.0)) + x4 * (1.0 / 362_880.0 + x2 * (1.0 / 39_916_800.0)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// Against the sum over all lit pieces one by one, by the textbook's antiderivative.
        #[test]
        fn equals_the_sum_over_pieces(
            inserted in prop::collection::vec((0.0..20.0_f64, 0.0..2.0_f64), 0..40),
            more in (0.0..20.0_f64, 0.0..3.0_f64),
            range in (0.0..20.0_f64, 0.0..20.0_f64),
            per_reach in -1.5..1.5_f64,
        ) {
            let mut cells = LitCells::default();
            cells.start(&[3.0, 11.0, 20.0], 0.8);
            let (mut shadows, mut more_shadows) = <(IntervalSet, IntervalSet)>::default();
            for (start, width) in inserted {
                shadows.for_each_gap(start, start + width, |a, b| cells.darken(a, b));
                shadows.insert(start, start + width);
            }
            more_shadows.insert(more.0, more.0 + more.1);
            let (start, end) = (range.0.min(range.1), range.0.max(range.1));
            let line = DepthLine { start, at_start: 0.3, per_reach };
            let found = cells.integral(&line, end, &shadows, &more_shadows);

            let mut all = shadows.clone();
            all.insert(more.0, more.0 + more.1);
            let antiderivative = |x: f64| -(-line.at(x)).exp() / per_reach;
            let mut expected = 0.0;
            all.for_each_gap(start, end, |a, b| expected += antiderivative(b) - antiderivative(a));
            let scale = (end - start) * (-line.at(start)).exp().max((-line.at(end)).exp());
            prop_assert!((found - expected).abs() <= 1e-7 * scale + 1e-14 / per_reach.abs(), "{found} {expected}");
        }
    }
}
