//! Uniform fog along a range of a ray. In go an optical depth that is linear in the reach, and the lit parts,
//! out comes the integral of the transmittance. Invariant: nothing cancels, neither in thin fog nor as the
//! ray turns towards the sun.

use super::lit_cells::{Lit, MOST_PIECES, Piece};
use crate::color::Rgb;
use crate::fog::beer_lambert::NOTHING_LEFT;
use crate::math::fast_exp;
use std::ops::Range;

/// Optical depth, to the eye and to the light together: `at_start + per_reach * (reach - start)`.
#[derive(Clone, Copy, Debug)]
pub(super) struct DepthLine {
    pub(super) start: f64,
    pub(super) at_start: [f64; 3],
    pub(super) per_reach: [f64; 3],
}

impl DepthLine {
    #[inline(always)]
    pub(super) fn new(start: f64) -> Self {
        Self { start, at_start: [0.0; 3], per_reach: [0.0; 3] }
    }

    /// Adds a bank, by its metres at maximum density.
    #[inline(always)]
    pub(super) fn add(&mut self, sigma_t: Rgb, metres_at_start: f64, metres_per_reach: f64) {
        for lane in 0..3 {
            self.at_start[lane] += sigma_t[lane] * metres_at_start;
            self.per_reach[lane] += sigma_t[lane] * metres_per_reach;
        }
    }

    /// `integral of exp(-tau)` over the lit parts of a range: see [`Lit::for_each_piece`]. `None` if the fog
    /// changes too fast along it. The truncation error, relative to the integral, is at most the eighth power
    /// of half a piece's change over `8!`: 1e-7.
    #[inline(always)]
    pub(super) fn lit_integral(&self, range: Range<f64>, lit: &Lit) -> Option<Rgb> {
        let steepest = self.steepest();
        let is_thick = steepest * (range.end - range.start) > NOTHING_LEFT;
        let range = if is_thick { self.visible(range) } else { range };
        if steepest * (range.end - range.start) > MOST_PIECES {
            return None;
        }
        let mut sum = [0.0; 3];
        let add = |piece: &Piece, moments: &[f64; 8]| {
            let offset = piece.middle - self.start;
            for (lane, sum) in sum.iter_mut().enumerate() {
                *sum += self.integral(lane, offset, piece.half_width, moments);
            }
        };
        lit.for_each_piece(range, |_| steepest, add);
        Some(Rgb::from_array(sum))
    }

    /// Change of the depth per reach, in the channel where it is largest.
    #[inline(always)]
    pub(super) fn steepest(&self) -> f64 {
        self.per_reach.iter().fold(0.0, |most, k| most.max(k.abs()))
    }

    /// Part of a range where the transmittance of some channel is not negligible beside that at its brighter
    /// end.
    fn visible(&self, range: Range<f64>) -> Range<f64> {
        let (mut first, mut last) = (range.end, range.start);
        for per_reach in self.per_reach {
            let way = NOTHING_LEFT / per_reach.abs();
            first = first.min(if per_reach < 0.0 { range.end - way } else { range.start });
            last = last.max(if per_reach > 0.0 { range.start + way } else { range.end });
        }
        first.max(range.start)..last.min(range.end)
    }

    /// `integral of exp(-tau)` over the lit part of a piece, from eight moments. The derivatives of the
    /// integrand are powers of `k`.
    #[inline(always)]
    fn integral(&self, lane: usize, offset: f64, half_width: f64, m: &[f64; 8]) -> f64 {
        let k = -self.per_reach[lane] * half_width;
        let k2 = k * k;
        let low = (m[0] + k * m[1]) + k2 * (m[2] + k * m[3]);
        let high = (m[4] + k * m[5]) + k2 * (m[6] + k * m[7]);
        fast_exp(-(self.at_start[lane] + self.per_reach[lane] * offset)) * (low + k2 * k2 * high)
    }
}

#[cfg(test)]
mod tests {
    use super::super::lit_cells::LitCells;
    use super::*;
    use crate::math::IntervalSet;
    use proptest::prelude::*;

    proptest! {
        /// Compared with the sum over all lit pieces one by one, by the textbook's antiderivative.
        #[test]
        fn equals_the_sum_over_pieces(
            inserted in prop::collection::vec((0.0..20.0_f64, 0.0..2.0_f64), 0..40),
            more in (0.0..20.0_f64, 0.0..3.0_f64),
            range in (0.0..20.0_f64, 0.0..20.0_f64),
            per_reach in prop::array::uniform3(-1.5..1.5_f64),
            steep in prop::bool::weighted(0.2),
        ) {
            let mut cells = LitCells::default();
            cells.start(&[3.0, 11.0], 20.0, 0.8);
            let (mut shadows, mut more_shadows) = <(IntervalSet, IntervalSet)>::default();
            for (start, width) in inserted {
                shadows.for_each_gap(start, start + width, |a, b| cells.darken(a, b));
                shadows.insert(start, start + width);
            }
            more_shadows.insert(more.0, more.0 + more.1);
            let (start, end) = (range.0.min(range.1), range.0.max(range.1));
            let per_reach = per_reach.map(|k| if steep { 10.0 * k } else { k });
            let at_start = per_reach.map(|k| 0.3 + (-k * (end - start)).max(0.0));
            let line = DepthLine { start, at_start, per_reach };
            let lit = Lit { cells: &cells, shadows: &shadows, more_shadows: &more_shadows };
            let found = line.lit_integral(start..end, &lit).expect("few pieces");

            let mut all = shadows.clone();
            all.insert(more.0, more.0 + more.1);
            for channel in 0..3 {
                let k = per_reach[channel];
                let tau = |x: f64| at_start[channel] + k * (x - start);
                let antiderivative = |x: f64| -(-tau(x)).exp() / k;
                let mut expected = 0.0;
                all.for_each_gap(start, end, |a, b| expected += antiderivative(b) - antiderivative(a));
                let scale = (end - start) * (-tau(start).min(tau(end))).exp();
                let found = found[channel];
                prop_assert!((found - expected).abs() <= 1e-7 * scale + 1e-14 / k.abs(), "{found} {expected}");
            }
        }
    }

    /// The visible part decides, however thick the fog; `None` where even that is long.
    #[test]
    fn thick_fog() {
        let (mut cells, none) = <(LitCells, IntervalSet)>::default();
        cells.start(&[1.0], 0.0, 1e4);
        let integral = |at_start: [f64; 3], per_reach: [f64; 3]| {
            let lit = Lit { cells: &cells, shadows: &none, more_shadows: &none };
            DepthLine { start: 0.0, at_start, per_reach }.lit_integral(0.0..1.0, &lit)
        };
        let found = integral([0.0; 3], [1e4, 2e4, 3e4]).expect("few pieces");
        let expected = Rgb::new(1e-4, 0.5e-4, 1e-4 / 3.0);
        assert!((found / expected - 1.0).abs().max_element() < 1e-7, "{found}");
        let towards_light = integral([1e4, 2e4, 3e4], [-1e4, -2e4, -3e4]).expect("few pieces");
        assert!((towards_light / expected - 1.0).abs().max_element() < 1e-7, "{towards_light}");
        assert!(integral([0.0; 3], [1e4, 1.0, 1.0]).is_none());
        let faint = integral([600.0; 3], [1e4; 3]).expect("few pieces");
        assert!((faint * 600_f64.exp() / 1e-4 - 1.0).abs().max_element() < 1e-7, "{faint}");
    }
}
