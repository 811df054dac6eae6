//! Light carried across the grid along every ordinate. In go matter, sources and what comes in from
//! outside, out come moments of radiance. Invariant: sums have a fixed order, so any number of threads
//! gives the same field.
//!
//! Planes of nodes across the ordinate's largest component follow one another. Each node takes what leaves
//! the four cells before it, half a cell of matter, its own source, and half a cell again. This is a step
//! scheme of second order (Lewis & Miller 1984, "Computational Methods of Neutron Transport", chapter 4).

use super::carrier::{Carrier, Sources};
use super::grid::Grid;
use super::matter::Matter;
use super::moments::Moments;
use super::ordinates::Ordinates;
use super::planes::Layout;
use super::walls::Walls;
use rayon::prelude::*;

/// What is swept over, and the room that it takes.
pub(super) struct Sweeper<'a> {
    /// Nodes.
    count: usize,
    turned: Layout,
    /// By axis, then by channel.
    carriers: Vec<Carrier<'a>>,
}

impl<'a> Sweeper<'a> {
    pub(super) fn new(
        grid: &'a Grid,
        matter: &'a Matter,
        walls: &'a Walls,
        ordinates: &'a Ordinates,
    ) -> Self {
        let turned = Layout { size: grid.size, is_turned: true };
        let carriers = (0..9).map(|number| {
            // Rows never run along the ordinates.
            let layout = Layout { is_turned: number / 3 == 0, ..turned };
            Carrier::new(grid, matter, (walls, ordinates), layout, [number / 3, number % 3])
        });
        Self { count: grid.count(), turned, carriers: carriers.collect() }
    }

    /// The moments of radiance that sources give where they, and nothing else, are scattered no more. Once
    /// `cancelled` says true, what comes is of no use.
    pub(super) fn sweep(&mut self, sources: &Sources, cancelled: &(dyn Fn() -> bool + Sync)) -> Moments {
        let turned = sources.of_matter.map(|values| self.turned.of_grid(values));
        let turned = Sources { of_matter: &turned, ..*sources };
        self.carriers.par_iter_mut().for_each(|carrier| {
            carrier.carry(if carrier.axis == 0 { &turned } else { sources }, cancelled);
        });
        let mut moments = Moments::zero(self.count);
        for carrier in &self.carriers {
            let sums = moments.of_channel_mut(carrier.channel).chunks_exact_mut(self.count);
            for (sums, values) in sums.zip(carrier.moments.chunks_exact(self.count)) {
                let laid = (carrier.axis == 0).then(|| self.turned.to_grid(values));
                for (sum, value) in sums.iter_mut().zip(laid.as_deref().unwrap_or(values)) {
                    *sum += value;
                }
            }
        }
        moments
    }
}
