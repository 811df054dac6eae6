//! Moments of the lit part of a slice, precomputed by cell. In go shadows as they grow. Out come the moments
//! of the lit part of any range of reaches, in a few pieces. Invariant: the moments of a cell are exact.
//! Single shadows are visited only in the cells at the ends of a range, once for all channels.
//!
//! Let `x` be the distance from a piece's centre in halves of its width. Let `m_j` be the integral of `x^j /
//! j!` over the lit part. The integral of any smooth `f` over the same is `sum(f_j m_j)`, where `f_j` are its
//! derivatives at the centre. This is a multipole expansion (Greengard & Rokhlin 1987, section 2). The
//! moments depend neither on the camera's ray nor on the integrand.

use crate::math::IntervalSet;
use std::ops::Range;

/// Number of moments of a piece.
pub(super) const ORDER: usize = 10;

/// Maximum number of cells between two breaks, however thick the fog.
const MOST_CELLS: f64 = 64.0;

/// Maximum number of pieces on one interval; rays with more are left to the per-ray method.
pub(super) const MOST_PIECES: f64 = 512.0;

/// `j!`
pub(super) const FACTORIALS: [f64; ORDER] =
    [1.0, 1.0, 2.0, 6.0, 24.0, 120.0, 720.0, 5040.0, 40_320.0, 362_880.0];

/// A slice's range of reaches, cut into cells.
#[derive(Debug, Default)]
pub(super) struct LitCells {
    edges: Vec<f64>,
    moments: Vec<Moments>,
}

/// Integrals of `x^j / j!` over the lit part.
pub(super) type Moments = [f64; ORDER];

/// A range of reaches.
#[derive(Clone, Copy, Debug)]
pub(super) struct Piece {
    pub(super) middle: f64,
    pub(super) half_width: f64,
}

impl LitCells {
    /// Starts anew with everything lit. Every break is an edge of cells. Beyond `last_reach` there will be no
    /// shadows, and so no cells.
    pub(super) fn start(&mut self, breaks: &[f64], last_reach: f64, cells_per_reach: f64) {
        self.edges.clear();
        self.moments.clear();
        self.edges.push(0.0);
        let mut before = 0.0;
        let last_break = breaks.last().copied().unwrap_or(0.0);
        for at in breaks.iter().copied().chain((last_reach > last_break).then_some(last_reach)) {
            let count = ((at - before) * cells_per_reach).ceil().clamp(1.0, MOST_CELLS);
            let width = (at - before) / count;
            self.edges.extend((1..count as u32).map(|cell| before + width * f64::from(cell)));
            self.edges.push(at);
            before = at;
        }
        let whole = |edges: &[f64]| Piece::new(edges[0], edges[1]).moments_between(edges[0], edges[1]);
        self.moments.extend(self.edges.windows(2).map(whole));
    }

    /// Darkens the range between two reaches, which must have been lit.
    pub(super) fn darken(&mut self, start: f64, end: f64) {
        let first = self.edges.partition_point(|edge| *edge <= start).saturating_sub(1);
        for (edges, moments) in self.edges[first..].windows(2).zip(&mut self.moments[first..]) {
            if edges[0] >= end {
                break;
            }
            let cell = Piece::new(edges[0], edges[1]);
            let lost = cell.moments_between(start.max(edges[0]), end.min(edges[1]));
            for (moment, lost) in moments.iter_mut().zip(lost) {
                *moment -= lost;
            }
        }
    }
}

/// Light that reaches a ray: the cells, and further shadows.
pub(super) struct Lit<'a> {
    pub(super) cells: &'a LitCells,
    pub(super) shadows: &'a IntervalSet,
    /// Further shadows, of this ray alone.
    pub(super) more_shadows: &'a IntervalSet,
}

impl Lit<'_> {
    /// Calls back with a range in pieces and with the moments of its lit parts. The ray's own shadows come as
    /// pieces with negative moments.
    ///
    /// The integrand uses the first N moments. `changes` bounds the integrand's relative change per reach;
    /// between two places it must not exceed the larger of their values. Over a piece the integrand changes
    /// by at most 1.
    #[inline(always)]
    pub(super) fn for_each_piece<const N: usize>(
        &self,
        range: Range<f64>,
        changes: impl Fn(f64) -> f64,
        mut each: impl FnMut(&Piece, &[f64; N]),
    ) {
        let Self { cells: LitCells { edges, moments }, shadows, more_shadows } = self;
        let mut from = range.start;
        let first_cell = edges.partition_point(|edge| *edge <= from).saturating_sub(1);
        for (edges, moments) in edges[first_cell..].windows(2).zip(&moments[first_cell..]) {
            let part = from..edges[1].min(range.end);
            if part.is_empty() {
                break;
            }
            from = part.end;
            if part == (edges[0]..edges[1]) && change_over(&part, &changes) <= 1.0 {
                each(&Piece::new(part.start, part.end), first(moments));
            } else {
                look_at(part, shadows, 1.0, &changes, &mut each);
            }
        }
        look_at(from..range.end, shadows, 1.0, &changes, &mut each);
        for &(start, end) in more_shadows.as_slice() {
            look_at(start.max(range.start)..end.min(range.end), shadows, -1.0, &changes, &mut each);
        }
    }
}

/// Pieces as in [`Lit::for_each_piece`], from the shadows themselves.
fn look_at<const N: usize>(
    range: Range<f64>,
    shadows: &IntervalSet,
    sign: f64,
    changes: &impl Fn(f64) -> f64,
    each: &mut impl FnMut(&Piece, &[f64; N]),
) {
    let mut start = range.start;
    while start < range.end {
        let mut end = range.end.min(start + changes(start).recip());
        let change = change_over(&(start..end), changes);
        if change > 1.0 {
            end = start + (end - start) / change;
        }
        // Rounding must not stop the loop.
        let end = if end > start { end } else { range.end };
        let piece = Piece::new(start, end);
        if let Some(moments) = piece.lit_moments(start, end, shadows, sign) {
            each(&piece, &moments);
        }
        start = end;
    }
}

fn first<const N: usize>(moments: &Moments) -> &[f64; N] {
    const { assert!(N <= ORDER) };
    moments.first_chunk().unwrap_or(&[0.0; N])
}

#[inline(always)]
fn change_over(range: &Range<f64>, changes: &impl Fn(f64) -> f64) -> f64 {
    (range.end - range.start) * changes(range.start).max(changes(range.end))
}

impl Piece {
    fn new(start: f64, end: f64) -> Self {
        Self { middle: 0.5 * (start + end), half_width: 0.5 * (end - start) }
    }

    /// Moments of the range between two reaches.
    fn moments_between(&self, start: f64, end: f64) -> Moments {
        let mut powers = [0.0; ORDER];
        self.add_powers(start, end, &mut powers);
        self.moments(&powers, 1.0)
    }

    /// Moments of the range between two reaches outside `shadows`, times `sign`; `None` if nothing is left.
    fn lit_moments<const N: usize>(
        &self,
        start: f64,
        end: f64,
        shadows: &IntervalSet,
        sign: f64,
    ) -> Option<[f64; N]> {
        let (mut sums, mut is_dark) = ([0.0; N], true);
        shadows.for_each_gap(start, end, |start, end| {
            self.add_powers(start, end, &mut sums);
            is_dark = false;
        });
        (!is_dark).then(|| self.moments(&sums, sign))
    }

    /// Adds the powers of `x` at the end and subtracts those at the start.
    #[inline(always)]
    fn add_powers<const N: usize>(&self, start: f64, end: f64, sums: &mut [f64; N]) {
        let per_reach = self.half_width.max(f64::MIN_POSITIVE).recip();
        let low = powers((start - self.middle) * per_reach);
        let high = powers((end - self.middle) * per_reach);
        for (j, sum) in sums.iter_mut().enumerate() {
            *sum += high[j] - low[j];
        }
    }

    fn moments<const N: usize>(&self, powers: &[f64; N], factor: f64) -> [f64; N] {
        let factor = factor * self.half_width;
        std::array::from_fn(|j| powers[j] * factor * (1.0 / (FACTORIALS[j] * (j + 1) as f64)))
    }
}

/// `x`, `x^2` and so on, with few dependent multiplications.
#[inline(always)]
fn powers(x: f64) -> [f64; ORDER] {
    let x2 = x * x;
    let (x3, x4) = (x * x2, x2 * x2);
    let x8 = x4 * x4;
    [x, x2, x3, x4, x * x4, x2 * x4, x3 * x4, x8, x * x8, x2 * x8]
}
