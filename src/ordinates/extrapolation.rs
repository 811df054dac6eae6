//! Extrapolation of source iteration: orders of scattering end as a geometric series. In go totals of light,
//! out comes what all further orders add. Invariant: channels are told apart.

/// Rest after the last order, as a share of all light, when a geometric series tells it well; and by
/// how much an order more may change what it tells.
const REST: f64 = 0.01;
const SURPRISE: f64 = 2e-4;
/// Ratio of orders at most: a closed scene that absorbs nothing has no end.
const MOST_RATIO: f64 = 0.98;

/// A geometric series, by channel.
#[derive(Default)]
pub(super) struct Series {
    /// The last order's light.
    last: [f64; 3],
    /// Sum of the orders that follow it, in units of it.
    pub(super) rest: [f64; 3],
    /// All light with that.
    all: [f64; 3],
    /// The share of itself by which the last order went on, of the channel that went on most.
    pub(super) ratio: f64,
    /// Whether orders hardly grow darker.
    pub(super) is_endless: bool,
}

impl Series {
    /// Takes an order's light and the sum of all so far. Tells whether the rest is little, and as
    /// expected.
    pub(super) fn go_on(&mut self, order: [f64; 3], so_far: [f64; 3]) -> bool {
        let mut is_told = true;
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
            is_told &= left <= REST * all && (all - self.all[channel]).abs() <= SURPRISE * all;
            (self.last[channel], self.rest[channel], self.all[channel]) = (order[channel], rest, all);
        }
        is_told
    }
}
