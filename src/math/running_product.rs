//! Product of factors that change one at a time. In go factors with fixed places, out comes the product of
//! all, at any time. Invariant: a change takes as many multiplications as the number of places has binary
//! digits, and nothing is divided.

use crate::color::Rgb;

#[cfg(test)]
thread_local! {
    /// Number of multiplications by this thread.
    pub(crate) static MULTIPLICATIONS: std::cell::Cell<usize> = const { std::cell::Cell::new(0) };
}

/// Binary tree with the factors as leaves; each node is the product of the two below it.
#[derive(Clone, Debug, Default)]
pub struct RunningProduct {
    /// Nodes: the root at 1, the children of `i` at `2 i` and `2 i + 1`.
    nodes: Vec<Rgb>,
}

impl RunningProduct {
    /// Starts anew with so many places, each with a factor of 1.
    pub fn start(&mut self, places: usize) {
        self.nodes.clear();
        self.nodes.resize(2 * places.next_power_of_two(), Rgb::ONE);
    }

    /// Sets the factor of a place.
    pub fn set(&mut self, place: usize, factor: Rgb) {
        let nodes = &mut self.nodes;
        let mut node = nodes.len() / 2 + place;
        nodes[node] = factor;
        while node > 1 {
            node /= 2;
            nodes[node] = nodes[2 * node] * nodes[2 * node + 1];
            #[cfg(test)]
            MULTIPLICATIONS.set(MULTIPLICATIONS.get() + 1);
        }
    }

    /// Product of all factors.
    pub fn get(&self) -> Rgb {
        self.nodes[1]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn equals_the_product_of_all(
            count in 1_usize..20,
            changes in prop::collection::vec((0_usize..20, 0.0..1.0_f64), 0..60),
        ) {
            let mut product = RunningProduct::default();
            product.start(count);
            let mut factors = vec![1.0; count];
            for (place, factor) in changes.into_iter().filter(|(place, _)| *place < count) {
                product.set(place, Rgb::splat(factor));
                factors[place] = factor;
                let expected: f64 = factors.iter().product();
                prop_assert!((product.get().x - expected).abs() <= 1e-14 * expected);
            }
        }
    }
}
