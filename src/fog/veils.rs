//! What dims a ray in places: surfaces that light partly passes, seen through or in the light's way. In
//! go intervals with a transmittance, out come the pieces of the ray on which their product is
//! constant. Invariant: the order in which veils are added does not show, to the last bit.

use crate::color::Rgb;
use crate::math::RunningProduct;

/// All veils of one ray and light.
#[derive(Clone, Debug, Default)]
pub(super) struct Veils {
    veils: Vec<Veil>,
    /// Where each piece begins, and what gets through there; before the first, everything.
    pieces: Vec<(f64, Rgb)>,
    /// Of those that cover a piece.
    product: RunningProduct,
}

#[derive(Clone, Copy, Debug)]
struct Veil {
    start: f64,
    end: f64,
    transmittance: Rgb,
}

impl Veils {
    /// Takes all veils away.
    pub(super) fn clear(&mut self) {
        self.veils.clear();
        self.pieces.clear();
    }

    /// Adds one between two places.
    pub(super) fn add(&mut self, start: f64, end: f64, transmittance: Rgb) {
        if transmittance != Rgb::ONE && start < end {
            self.veils.push(Veil { start, end, transmittance });
        }
    }

    /// From veils to pieces, once all are added.
    pub(super) fn resolve(&mut self) {
        let Self { veils, pieces, product } = self;
        let key = |veil: &Veil| {
            let [red, green, blue] = veil.transmittance.to_array();
            [veil.start, veil.end, red, green, blue]
        };
        // A fixed order of factors: rounding must not tell in which order the tree met them.
        veils.sort_unstable_by(|a, b| {
            let order = key(a).into_iter().zip(key(b)).map(|(a, b)| a.total_cmp(&b));
            order.fold(std::cmp::Ordering::Equal, std::cmp::Ordering::then)
        });
        let starts = veils.iter().zip(0..).map(|(veil, index)| (veil.start, index, veil.transmittance));
        let ends = veils.iter().zip(0..).map(|(veil, index)| (veil.end, index, Rgb::ONE));
        let mut changes: Vec<(f64, usize, Rgb)> = starts.chain(ends).collect();
        changes.sort_by(|a, b| a.0.total_cmp(&b.0));
        product.start(veils.len());
        for at_one_place in changes.chunk_by(|a, b| a.0 == b.0) {
            for &(_, veil, factor) in at_one_place {
                product.set(veil, factor);
            }
            pieces.extend(at_one_place.first().map(|(start, ..)| (*start, product.get())));
        }
    }

    /// Calls `piece(start, end, transmittance)` for the parts of an interval, in order.
    pub(super) fn for_each_piece(&self, start: f64, end: f64, mut piece: impl FnMut(f64, f64, Rgb)) {
        let mut next = self.pieces.partition_point(|(from, _)| *from <= start);
        let mut transmittance = if next == 0 { Rgb::ONE } else { self.pieces[next - 1].1 };
        let mut from = start;
        while let Some(&(to, then)) = self.pieces.get(next).filter(|(to, _)| *to < end) {
            piece(from, to, transmittance);
            (from, transmittance) = (to, then);
            next += 1;
        }
        piece(from, end, transmittance);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn overlapping_veils_multiply_in_any_order() {
        let list = [(1.0, 3.0, 0.3), (2.0, 5.0, 0.7), (2.0, f64::INFINITY, 0.9), (0.5, 0.5, 0.1)];
        let pieces = |order: &[usize]| {
            let mut veils = Veils::default();
            for &index in order {
                let (start, end, through) = list[index];
                veils.add(start, end, Rgb::splat(through));
            }
            veils.resolve();
            let mut pieces = Vec::new();
            veils.for_each_piece(0.0, 9.0, |start, end, through| pieces.push((start, end, through.x)));
            pieces
        };
        let found = pieces(&[0, 1, 2, 3]);
        let expected = [
            (0.0, 1.0, 1.0),
            (1.0, 2.0, 0.3),
            (2.0, 3.0, 0.3 * 0.7 * 0.9),
            (3.0, 5.0, 0.7 * 0.9),
            (5.0, 9.0, 0.9),
        ];
        assert_eq!(found.len(), expected.len());
        for (found, expected) in found.iter().zip(expected) {
            assert!((found.0, found.1) == (expected.0, expected.1) && (found.2 - expected.2).abs() < 1e-15);
        }
        assert_eq!(found, pieces(&[3, 2, 1, 0]));
        assert_eq!(found, pieces(&[1, 3, 0, 2]));
    }
}
