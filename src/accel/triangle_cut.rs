//! Shadow of a triangle that the plane of a ray and a light cuts. In go the plane's functions at its
//! vertices, out comes an interval of the ray. Invariants: triangles that share an edge get the same bits
//! where it crosses the plane, so no light leaks between them. No result is NaN.

use super::simd::{Lanes, Mask};

/// Values at the three vertices of each triangle.
pub(super) type Corners<L> = [L; 3];

/// The part of the ray in shadow.
pub(super) struct Shadow<L: Lanes> {
    /// Lanes in which the interval is not empty.
    pub(super) exists: L::Mask,
    pub(super) start: L,
    pub(super) end: L,
}

/// Ends of a cut: for each the numerator and the denominator of its shadow's distance along the ray, and its
/// height above the ray.
pub(super) struct FanEnds<L> {
    n: [L; 2],
    d: [L; 2],
    y: [L; 2],
}

/// The two edges that cross the plane: those of the vertex that is alone on its side. Vertices in the plane
/// count as above it.
pub(super) struct Crossing<L: Lanes> {
    /// Triangles that cross the plane.
    pub(super) exists: L::Mask,
    first_is_alone: L::Mask,
    second_is_alone: L::Mask,
    heights: Corners<L>,
}

impl<L: Lanes> Crossing<L> {
    #[inline(always)]
    pub(super) fn new(zero: L, heights: Corners<L>) -> Self {
        let (a, b, c) = (zero.le(heights[0]), zero.le(heights[1]), zero.le(heights[2]));
        let crossing =
            Self { exists: (a ^ b) | (b ^ c), first_is_alone: !(b ^ c), second_is_alone: !(a ^ c), heights };
        Self { heights: crossing.alone_first(heights), ..crossing }
    }

    #[inline(always)]
    fn alone_first(&self, [a, b, c]: Corners<L>) -> Corners<L> {
        [self.sample(a, b, c), self.sample(b, c, a), self.sample(c, a, b)]
    }

    #[inline(always)]
    fn sample(&self, first: L, second: L, third: L) -> L {
        first.or_else(self.first_is_alone, second.or_else(self.second_is_alone, third))
    }

    /// Values of a function where the two edges cross the plane. Exchanging an edge's ends negates numerator
    /// and denominator exactly, as no operation is fused. The denominator is the difference of two numbers of
    /// different sign, never 0.
    #[inline(always)]
    pub(super) fn at_ends(&self, values: Corners<L>) -> [L; 2] {
        let [va, vb, vc] = self.alone_first(values);
        let [ha, hb, hc] = self.heights;
        [(va * hb - vb * ha) / (hb - ha), (va * hc - vc * ha) / (hc - ha)]
    }

    /// The shadow within `[t0, t1]` under a directional light.
    #[inline(always)]
    pub(super) fn strip_shadow(
        &self,
        zero: L,
        (t0, t1): (L, L),
        along: Corners<L>,
        towards_light: Corners<L>,
    ) -> Shadow<L> {
        let [ta, tb] = self.at_ends(along);
        let [ya, yb] = self.at_ends(towards_light);
        let swapped = tb.lt(ta);
        let (y_low, y_high) = (yb.or_else(swapped, ya), ya.or_else(swapped, yb));
        let (low, high) = (tb.or_else(swapped, ta), ta.or_else(swapped, tb));
        let (start, end) = (low.max(t0), high.min(t1));
        // Twice the height above the ray in the interval's middle, times the unclipped interval's length.
        let (to_low, to_high) = ((start - low) + (end - low), (high - start) + (high - end));
        let height = y_low * to_high + y_high * to_low;
        Shadow { exists: self.exists & start.lt(end) & zero.lt(height), start, end }
    }

    /// Ends of the cut, with the numbers for their shadows under a point light.
    #[inline(always)]
    pub(super) fn fan_ends(
        &self,
        along: Corners<L>,
        depth: Corners<L>,
        towards_light: Corners<L>,
    ) -> FanEnds<L> {
        FanEnds { n: self.at_ends(along), d: self.at_ends(depth), y: self.at_ends(towards_light) }
    }

    /// The shadow within `[t0, t1]` under a point light.
    #[inline(always)]
    pub(super) fn fan_shadow(
        &self,
        (zero, one): (L, L),
        (t0, t1): (L, L),
        FanEnds { n, d, y }: FanEnds<L>,
    ) -> Shadow<L> {
        let after = [n[0] - t0 * d[0], n[1] - t0 * d[1]];
        let before = [t1 * d[0] - n[0], t1 * d[1] - n[1]];
        // Parameters at which the cut crosses the two limits, from one end to the other.
        let after_at = after[0] / (after[0] - after[1]);
        let before_at = before[0] / (before[0] - before[1]);
        // The end itself, or the limit that clips it: the one that the cut crosses last on its way in.
        let a_before = before[0].lt(zero);
        let b_before = before[1].lt(zero);
        let a_after = after[0].lt(zero) & (!a_before | before_at.lt(after_at));
        let b_after = after[1].lt(zero) & (!b_before | after_at.lt(before_at));
        // An end at the light itself is 0 / 0, which the limits replace.
        let ta = t0.or_else(a_after, t1.or_else(a_before, (n[0] / d[0]).min(t1).max(t0)));
        let tb = t0.or_else(b_after, t1.or_else(b_before, (n[1] / d[1]).min(t1).max(t0)));
        let from = after_at.or_else(a_after, before_at.or_else(a_before, zero));
        let to = after_at.or_else(b_after, before_at.or_else(b_before, one));
        let middle = from + to;
        let height = y[0] * ((one - middle) + one) + y[1] * middle;
        let beyond = (after[0].lt(zero) & after[1].lt(zero)) | (before[0].lt(zero) & before[1].lt(zero));
        let exists = self.exists & !beyond & from.lt(to) & zero.lt(height);
        let swapped = tb.lt(ta);
        let (start, end) = (tb.or_else(swapped, ta), ta.or_else(swapped, tb));
        Shadow { exists: exists & start.lt(end), start, end }
    }
}

/// Relative accuracy of a cut's depths in double precision: a rounding, many times over where an edge of the
/// triangle nearly lies in the plane.
const LEAST_DEPTH: f64 = 1e-12;

impl FanEnds<f64> {
    /// The part before the light; `None` if all of it lies beyond. Where a cut passes through the light
    /// itself, rounding would decide on the side of its shadows.
    pub(super) fn before_light(mut self) -> Option<Self> {
        let least = LEAST_DEPTH * (self.d[0] - self.d[1]).abs();
        if self.d[0].max(self.d[1]) <= least {
            return None;
        }
        for end in 0..2 {
            let other = 1 - end;
            if self.d[end] < least {
                let share = (least - self.d[end]) / (self.d[other] - self.d[end]);
                for values in [&mut self.n, &mut self.y] {
                    values[end] += share * (values[other] - values[end]);
                }
                self.d[end] = least;
            }
        }
        Some(self)
    }
}

impl<L: Lanes> Shadow<L> {
    /// Lanes with a shadow, as bits.
    #[inline(always)]
    pub(super) fn bits(&self) -> u32 {
        self.exists.bits()
    }
}
