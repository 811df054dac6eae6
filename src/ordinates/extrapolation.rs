//! Extrapolation of source iteration: orders of scattering end as a geometric series. In go totals of light,
//! out comes the sum of all further orders. Invariant: each channel has its own series.

/// Largest remainder, as a share of all light, that a geometric series may replace; and the largest relative
/// change of the estimated sum by one more order.
const REST: f64 = 0.01;
const SURPRISE: f64 = 2e-4;
/// Maximum ratio of orders: a closed scene without absorption would have an infinite sum.
const MOST_RATIO: f64 = 0.98;

/// A geometric series, by channel.
#[derive(Default)]
pub(super) struct Series {
    /// The last order's light.
    last: [f64; 3],
    /// Sum of the orders that follow it, relative to it.
    pub(super) rest: [f64; 3],
    /// Estimated sum of all orders.
    all: [f64; 3],
    /// Ratio of the last order to the one before, of the channel where it is largest.
    pub(super) ratio: f64,
    /// Whether the ratio of orders is at its maximum.
    pub(super) is_endless: bool,
}

impl Series {
    /// Adds an order's light and the sum of all orders so far. Returns whether the remainder is small and the
    /// estimated sum stable.
    pub(super) fn go_on(&mut self, order: [f64; 3], so_far: [f64; 3]) -> bool {
        let mut is_stable = true;
        (self.is_endless, self.ratio) = (false, 0.0);
        for channel in 0..3 {
            let ratio = match self.last[channel] {
                last if last > 0.0 => (order[channel] / last).clamp(0.0, MOST_RATIO),
                _ => 0.0,
            };
            self.is_endless |= ratio == MOST_RATIO;
            self.ratio = self.ratio.max(ratio);
            let rest = ratio / (1.0 - ratio);
            let left = rest * order[channel];
            let all = so_far[channel] + left;
            is_stable &= left <= REST * all && (all - self.all[channel]).abs() <= SURPRISE * all;
            (self.last[channel], self.rest[channel], self.all[channel]) = (order[channel], rest, all);
        }
        is_stable
    }
}
