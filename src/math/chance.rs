//! Counter-based random numbers, without state or order. In go a seed, an item and a draw, out comes a
//! number. Invariant: it is a pure function of these, for any other draws.

/// Random numbers of one item of many.
#[derive(Clone, Copy, Debug)]
pub struct Chance(u64);

impl Chance {
    /// Random numbers of item `item` under `seed`.
    pub fn of(seed: u32, item: u32) -> Self {
        Self(mix((u64::from(seed) << 32) | u64::from(item)))
    }

    /// Draw number `draw`, in `[0, 1)`.
    pub fn at(self, draw: u64) -> f64 {
        let bits = mix(self.0.wrapping_add(1 + draw));
        (bits >> 11) as f64 / (1_u64 << 53) as f64
    }
}

/// SplitMix64 (Steele, Lea and Flood 2014): a Weyl step and Stafford's 13th mix.
fn mix(counter: u64) -> u64 {
    let mut bits = counter.wrapping_add(1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    bits = (bits ^ (bits >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    bits = (bits ^ (bits >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    bits ^ (bits >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn uniform_in_every_draw_and_independent_between_draws() {
        let numbers = |draw| (0..20_000).map(move |item| Chance::of(7, item).at(draw));
        let mean = |values: &mut dyn Iterator<Item = f64>| values.sum::<f64>() / 20_000.0;
        assert!((mean(&mut numbers(0)) - 0.5).abs() < 0.01);
        assert!((mean(&mut numbers(16).map(|x| x * x)) - 1.0 / 3.0).abs() < 0.01);
        let mut product = numbers(0).zip(numbers(1)).map(|(x, y)| (x - 0.5) * (y - 0.5));
        assert!(mean(&mut product).abs() < 0.003);
    }
}
