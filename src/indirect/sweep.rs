//! Light carried across the grid along every ordinate. In go matter, sources and what comes in from
//! outside, out come moments of radiance. Invariant: sums have a fixed order, so any number of threads
//! gives the same field.
//!
//! Planes of nodes across the ordinate's largest component follow one another. Each node takes what leaves
//! the four cells before it, half a cell of matter, its own source, and half a cell again. This is a step
//! scheme of second order (Lewis & Miller 1984, "Computational Methods of Neutron Transport", chapter 4).

use super::beam::Beam;
use super::carrier::{Carrier, Sources};
use super::grid::{Corners, Grid};
use super::harmonics::COUNT;
use super::high_degrees::HighSums;
use super::matter::Matter;
use super::moments::Moments;
use super::ordinates::Ordinates;
use super::planes::Layout;
use super::radiances::Radiances;
use super::walls::Walls;
use super::wanted::Wanted;
use rayon::prelude::*;

/// What light is found to be.
pub(super) struct Swept {
    /// By harmonics up to l = 2, of nodes, then of faces of walls; those of degree 3, if wanted, and 4.
    pub(super) moments: Moments,
    pub(super) third: Option<Moments>,
    pub(super) fourth: Moments,
    /// Those of degrees 5 and 6, of nodes alone, if wanted.
    pub(super) high: Option<HighSums>,
    /// Ordinate by ordinate.
    pub(super) radiances: Option<Radiances>,
}

impl Swept {
    /// Adds what the last scattering needs to what there is of it, without what orders go on with.
    pub(super) fn add_to(sum: &mut Option<Self>, other: Self) {
        match sum {
            Some(sum) => sum.add_last(&other),
            None => *sum = Some(Self { moments: Moments::zero(0), ..other }),
        }
    }

    /// Adds what the last scattering needs.
    pub(super) fn add_last(&mut self, other: &Self) {
        self.fourth.add(&other.fourth, [1.0; 3]);
        if let (Some(sums), Some(values)) = (&mut self.third, &other.third) {
            sums.add(values, [1.0; 3]);
        }
        if let (Some(sums), Some(values)) = (&mut self.high, &other.high) {
            for (sums, values) in sums.as_flattened_mut().iter_mut().zip(values.as_flattened()) {
                sums.iter_mut().zip(values).for_each(|(sum, value)| *sum += value);
            }
        }
        if let (Some(sums), Some(values)) = (&mut self.radiances, &other.radiances) {
            sums.add(values);
        }
    }
}

/// What is swept over, and the room that it takes.
pub(super) struct Sweeper<'a> {
    /// Nodes, and with faces of walls.
    count: usize,
    count_with_faces: usize,
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
        let count_with_faces = walls.faces.count_with_nodes();
        Self { count: grid.count(), count_with_faces, turned, carriers: carriers.collect() }
    }

    /// What sources give where they, and nothing else, are scattered no more. Once `cancelled` says true,
    /// what comes is of no use.
    pub(super) fn sweep(
        &mut self,
        sources: &Sources,
        wanted: &Wanted,
        cancelled: &(dyn Fn() -> bool + Sync),
    ) -> Swept {
        let turned = sources.of_matter.map(|values| self.turned.of_grid(values));
        let turned_beams = self.turned_beams(sources);
        let turned = Sources { of_matter: &turned, beams: &turned_beams, ..*sources };
        let turned_places: Option<Vec<Corners>> = wanted
            .radiances
            .map(|places| places.iter().map(|corners| self.turned.corners(corners)).collect());
        let turned_wanted = Wanted { radiances: turned_places.as_deref(), ..*wanted };
        self.carriers.par_iter_mut().for_each(|carrier| match carrier.axis {
            0 => carrier.carry(&turned, &turned_wanted, cancelled),
            _ => carrier.carry(sources, wanted, cancelled),
        });
        let swept = Swept {
            moments: self.sums(|carrier| (&carrier.moments, &carrier.towards_faces.moments)),
            third: wanted.third.then(|| self.sums(|carrier| (&carrier.third, &carrier.towards_faces.third))),
            fourth: self.sums(|carrier| (&carrier.fourth, &carrier.towards_faces.fourth)),
            high: wanted.high.then(|| self.high()),
            radiances: wanted.radiances.map(|_| self.radiances()),
        };
        self.carriers.iter_mut().for_each(Carrier::clear);
        swept
    }

    fn turned_beams(&self, sources: &Sources) -> Vec<Beam> {
        sources.beams.iter().map(|beam| beam.map(|values| self.turned.of_grid(values))).collect()
    }

    /// What carriers have found, all together.
    fn sums(&self, of: impl for<'c> Fn(&'c Carrier<'_>) -> (&'c [f32], &'c [[f32; COUNT]])) -> Moments {
        let mut moments = Moments::zero(self.count_with_faces);
        for carrier in &self.carriers {
            let (of_nodes, of_faces) = of(carrier);
            let sums = moments.of_channel_mut(carrier.channel).chunks_exact_mut(self.count_with_faces);
            self.add_up(sums, carrier, of_nodes);
            for index in 0..COUNT {
                let sums = &mut moments.channel_mut(carrier.channel, index)[self.count..];
                sums.iter_mut().zip(of_faces).for_each(|(sum, face)| *sum += face[index]);
            }
        }
        moments
    }

    fn high(&self) -> HighSums {
        let mut moments: HighSums = std::array::from_fn(|_| std::array::from_fn(|_| vec![0.0; self.count]));
        for carrier in &self.carriers {
            let sums = moments[carrier.channel].iter_mut().map(Vec::as_mut_slice);
            self.add_up(sums, carrier, &carrier.high);
        }
        moments
    }

    fn radiances(&mut self) -> Radiances {
        let mut of_channels = [const { Vec::new() }; 3];
        for carrier in &mut self.carriers {
            let of_ordinates: &mut Vec<Vec<f32>> = &mut of_channels[carrier.channel];
            for (number, values) in carrier.radiances.drain(..) {
                if of_ordinates.len() <= number {
                    of_ordinates.resize(number + 1, Vec::new());
                }
                of_ordinates[number] = values;
            }
        }
        Radiances(of_channels)
    }

    fn add_up<'s>(&self, sums: impl Iterator<Item = &'s mut [f32]>, carrier: &Carrier, values: &[f32]) {
        for (sums, values) in sums.zip(values.chunks_exact(self.count)) {
            let laid = (carrier.axis == 0).then(|| self.turned.to_grid(values));
            for (sum, value) in sums.iter_mut().zip(laid.as_deref().unwrap_or(values)) {
                *sum += value;
            }
        }
    }
}
