//! Transport sweep: light carried across the grid along every ordinate. In go cross-sections, sources and
//! what is incident, out come moments of radiance. Invariant: sums have a fixed order, so any number of
//! threads gives the same field.
//!
//! Planes of nodes across the ordinate's largest component follow one another. Each node takes what leaves
//! the four cells upwind of it, half a cell of the medium, its own source, and half a cell again. This is a
//! step scheme of second order (Lewis & Miller 1984, chapter 4).

use super::angle_set::{AngleSet, SweepSource};
use super::angular_radiance::AngularRadiance;
use super::domain::Domain;
use super::first_collision_source::BeamSource;
use super::grid::Corners;
use super::harmonics::COUNT;
use super::high_degrees::HighSums;
use super::moments::Moments;
use super::planes::Layout;
use super::quadrature::Quadrature;
use super::wanted::Wanted;
use rayon::prelude::*;

/// Moments and radiances that a sweep finds.
pub(crate) struct Swept {
    /// Moments up to l = 2, of nodes, then of faces of walls; those of degree 3, if wanted, and 4.
    pub(crate) moments: Moments,
    pub(crate) third: Option<Moments>,
    pub(crate) fourth: Moments,
    /// Moments of degrees 5 and 6, of nodes alone, if wanted.
    pub(crate) high: Option<HighSums>,
    /// Ordinate by ordinate.
    pub(crate) radiances: Option<AngularRadiance>,
}

impl Swept {
    /// Adds the parts that the last scattering needs to their sum, without those that orders go on with.
    pub(crate) fn add_to(sum: &mut Option<Self>, other: Self) {
        match sum {
            Some(sum) => sum.add_last(&other),
            None => *sum = Some(Self { moments: Moments::zero(0), ..other }),
        }
    }

    /// Adds what the last scattering needs.
    pub(crate) fn add_last(&mut self, other: &Self) {
        self.fourth.add(&other.fourth, [1.0; 3]);
        if let (Some(sums), Some(values)) = (&mut self.third, &other.third) {
            sums.add(values, [1.0; 3]);
        }
        self.add_high(other);
        if let (Some(sums), Some(values)) = (&mut self.radiances, &other.radiances) {
            sums.add(values);
        }
    }

    /// Adds degrees 5 and 6.
    pub(crate) fn add_high(&mut self, other: &Self) {
        let (Some(sums), Some(values)) = (&mut self.high, &other.high) else { return };
        for (sums, values) in sums.as_flattened_mut().iter_mut().zip(values.as_flattened()) {
            sums.iter_mut().zip(values).for_each(|(sum, value)| *sum += value);
        }
    }
}

/// Sweeps over a domain, with the memory that they take.
pub(crate) struct Sweeper<'a> {
    /// Nodes, and with faces of walls.
    count: usize,
    count_with_faces: usize,
    turned: Layout,
    /// Angle sets by axis, then by channel.
    angle_sets: Vec<AngleSet<'a>>,
}

impl<'a> Sweeper<'a> {
    pub(crate) fn new(domain: &Domain<'a>, quadrature: &Quadrature) -> Self {
        let grid = domain.grid;
        let turned = Layout { size: grid.size, is_turned: true };
        let angle_sets = (0..9).map(|number| {
            // Rows never run along the ordinates.
            let layout = Layout { is_turned: number / 3 == 0, ..turned };
            AngleSet::new(domain, quadrature, layout, [number / 3, number % 3])
        });
        let count_with_faces = domain.walls.faces.count_with_nodes();
        Self { count: grid.count(), count_with_faces, turned, angle_sets: angle_sets.collect() }
    }

    /// Light of sources before anything scatters it. Once `cancelled` says true,
    /// what comes is of no use.
    pub(crate) fn sweep(
        &mut self,
        sources: &SweepSource,
        wanted: &Wanted,
        cancelled: &(dyn Fn() -> bool + Sync),
    ) -> Swept {
        let turned = sources.volume.map(|values| self.turned.of_grid(values));
        let turned_beams = self.turned_beams(sources);
        let turned = SweepSource { volume: &turned, beams: &turned_beams, ..*sources };
        let turned_places: Option<Vec<Corners>> = wanted
            .radiances
            .map(|places| places.iter().map(|corners| self.turned.corners(corners)).collect());
        let turned_wanted = Wanted { radiances: turned_places.as_deref(), ..*wanted };
        self.angle_sets.par_iter_mut().for_each(|set| match set.axis {
            0 => set.sweep(&turned, &turned_wanted, cancelled),
            _ => set.sweep(sources, wanted, cancelled),
        });
        let swept = Swept {
            moments: self.sums(|set| (&set.moments, &set.towards_faces.moments)),
            third: wanted.third.then(|| self.sums(|set| (&set.third, &set.towards_faces.third))),
            fourth: self.sums(|set| (&set.fourth, &set.towards_faces.fourth)),
            high: wanted.high.then(|| self.high()),
            radiances: wanted.radiances.map(|_| self.radiances()),
        };
        self.angle_sets.iter_mut().for_each(AngleSet::clear);
        swept
    }

    fn turned_beams(&self, sources: &SweepSource) -> Vec<BeamSource> {
        sources.beams.iter().map(|beam| beam.map(|values| self.turned.of_grid(values))).collect()
    }

    /// Sums over all angle sets.
    fn sums(&self, of: impl for<'c> Fn(&'c AngleSet<'_>) -> (&'c [f32], &'c [[f32; COUNT]])) -> Moments {
        let mut moments = Moments::zero(self.count_with_faces);
        for set in &self.angle_sets {
            let (of_nodes, of_faces) = of(set);
            let sums = moments.of_channel_mut(set.channel).chunks_exact_mut(self.count_with_faces);
            self.add_up(sums, set, of_nodes);
            for index in 0..COUNT {
                let sums = &mut moments.channel_mut(set.channel, index)[self.count..];
                sums.iter_mut().zip(of_faces).for_each(|(sum, face)| *sum += face[index]);
            }
        }
        moments
    }

    fn high(&self) -> HighSums {
        let mut moments: HighSums = std::array::from_fn(|_| std::array::from_fn(|_| vec![0.0; self.count]));
        for set in &self.angle_sets {
            let sums = moments[set.channel].iter_mut().map(Vec::as_mut_slice);
            self.add_up(sums, set, &set.high);
        }
        moments
    }

    fn radiances(&mut self) -> AngularRadiance {
        let mut of_channels = [const { Vec::new() }; 3];
        for set in &mut self.angle_sets {
            let of_ordinates: &mut Vec<Vec<f32>> = &mut of_channels[set.channel];
            for (number, values) in set.radiances.drain(..) {
                if of_ordinates.len() <= number {
                    of_ordinates.resize(number + 1, Vec::new());
                }
                of_ordinates[number] = values;
            }
        }
        AngularRadiance(of_channels)
    }

    fn add_up<'s>(&self, sums: impl Iterator<Item = &'s mut [f32]>, set: &AngleSet, values: &[f32]) {
        for (sums, values) in sums.zip(values.chunks_exact(self.count)) {
            let laid = (set.axis == 0).then(|| self.turned.to_grid(values));
            for (sum, value) in sums.iter_mut().zip(laid.as_deref().unwrap_or(values)) {
                *sum += value;
            }
        }
    }
}
