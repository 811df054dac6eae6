//! Angular radiance (in transport: angular flux) at places around a finer grid. In go sweeps, out comes the
//! incident radiance of that grid. Invariant: ordinates stay apart, so upward radiance of the ground never
//! turns downward. With harmonics up to l = 2, cut off at 0, a fourteenth would.

use super::quadrature::Quadrature;

/// Radiance by channel, then by ordinate, then by place.
pub(crate) struct AngularRadiance(pub(crate) [Vec<Vec<f32>>; 3]);

impl AngularRadiance {
    pub(crate) fn add(&mut self, other: &Self) {
        for (sums, values) in self.0.iter_mut().flatten().zip(other.0.iter().flatten()) {
            sums.iter_mut().zip(values).for_each(|(sum, value)| *sum += value);
        }
    }

    /// Radiance along fewer ordinates: for each the weighted mean of the fine ordinates nearest to it, or the
    /// nearest one if there are none.
    pub(crate) fn along(&self, fine: &Quadrature, coarse: &Quadrature) -> Self {
        let mut sharing: Vec<Vec<usize>> = vec![Vec::new(); coarse.as_slice().len()];
        for (number, ordinate) in fine.iter().enumerate() {
            sharing[coarse.nearest(ordinate.direction)].push(number);
        }
        for (numbers, ordinate) in sharing.iter_mut().zip(coarse.iter()) {
            if numbers.is_empty() {
                numbers.push(fine.nearest(ordinate.direction));
            }
        }
        let weight = |number: &usize| fine.as_slice()[*number].weight as f32;
        let mean = |of_fine: &[Vec<f32>], numbers: &[usize]| {
            let all: f32 = numbers.iter().map(weight).sum();
            let mut means = vec![0.0; of_fine[0].len()];
            for number in numbers {
                let share = weight(number) / all;
                means.iter_mut().zip(&of_fine[*number]).for_each(|(mean, value)| *mean += share * value);
            }
            means
        };
        Self(self.0.each_ref().map(|of_fine| sharing.iter().map(|numbers| mean(of_fine, numbers)).collect()))
    }
}
