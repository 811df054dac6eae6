//! Transport sweep: light transport across the grid along every ordinate. In go cross-sections, sources and
//! incident radiance, out come moments of radiance. Invariant: sums have a fixed order, so any number of
//! threads gives the same solution.
//!
//! Planes of nodes across the ordinate's largest component follow one another. Each cell's incoming radiance
//! is that which leaves the four cells upwind of it, and its source is uniform. A node has the mean of its
//! cell, so the loss within a cell is what is missing behind it: every order conserves energy (step
//! characteristics, Lewis & Miller 1984, chapter 4).

use super::angle_set::{AngleSet, SetMoments, SweepSource};
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
use super::workspace::Workspace;
use rayon::prelude::*;
use std::sync::{Mutex, PoisonError};

/// Moments and radiances from a sweep.
pub(crate) struct Swept {
    /// Moments up to l = 2, of nodes, then of faces of walls; those of degree 3, if wanted, and 4.
    pub(crate) moments: Moments,
    pub(crate) third: Option<Moments>,
    pub(crate) fourth: Moments,
    /// Moments of degrees 5 and 6, of nodes alone, if wanted.
    pub(crate) high: Option<HighSums>,
    /// Radiances by ordinate, if wanted.
    pub(crate) radiances: Option<AngularRadiance>,
}

impl Swept {
    /// Adds the parts that the last scattering needs to their sum, without the moments of the next order.
    pub(crate) fn add_to(sum: &mut Option<Self>, other: Self) {
        match sum {
            Some(sum) => sum.add_last(&other),
            None => *sum = Some(Self { moments: Moments::zero(0), ..other }),
        }
    }

    /// Adds the parts that the last scattering needs.
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

/// Sweeps over a domain, with their memory.
pub(crate) struct Sweeper<'a> {
    /// Number of nodes, and of nodes and faces of walls.
    count: usize,
    count_with_faces: usize,
    turned: Layout,
    /// Angle sets by axis, then by channel.
    angle_sets: Vec<AngleSet<'a>>,
    /// Memory for angle sets that are swept, as many as there are threads.
    workspaces: Mutex<Vec<Workspace>>,
}

impl<'a> Sweeper<'a> {
    pub(crate) fn new(domain: &Domain<'a>) -> Self {
        let grid = domain.grid;
        let turned = Layout { size: grid.size, is_turned: true };
        let angle_sets = (0..3).flat_map(|axis| {
            // Rows are never parallel to the ordinates.
            AngleSet::of_axis(domain, Layout { is_turned: axis == 0, ..turned }, axis)
        });
        let count_with_faces = domain.walls.faces.count_with_nodes();
        let (angle_sets, workspaces) = (angle_sets.collect(), Mutex::default());
        Self { count: grid.count(), count_with_faces, turned, angle_sets, workspaces }
    }

    /// Light of sources along a quadrature, without scattering. Once `cancelled` returns true, the result is
    /// incomplete.
    pub(crate) fn sweep(
        &mut self,
        quadrature: &Quadrature,
        sources: &SweepSource,
        wanted: &Wanted,
        cancelled: &(dyn Fn() -> bool + Sync),
    ) -> Swept {
        let turned = sources.volume.map(|values| self.turned.of_grid(values));
        let turned_beams = self.turned_beams(sources);
        let turned_bodies = sources.bodies.map(|bodies| bodies.laid(|node| self.turned.node(node)));
        let bodies = turned_bodies.as_ref();
        let turned = SweepSource { volume: &turned, beams: &turned_beams, bodies, ..*sources };
        let turned_places: Option<Vec<Corners>> = wanted
            .radiances
            .map(|places| places.iter().map(|corners| self.turned.corners(corners)).collect());
        let turned_wanted = Wanted { radiances: turned_places.as_deref(), ..*wanted };
        let sums = Mutex::new(Sums::new(self, wanted));
        let Self { count, angle_sets, workspaces, .. } = self;
        let (count, workspaces) = (*count, &*workspaces);
        let workspaces = || workspaces.lock().unwrap_or_else(PoisonError::into_inner);
        angle_sets.par_iter_mut().for_each(|set| {
            let known = workspaces().pop();
            let own = known.map_or_else(|| Workspace::new(count), Workspace::cleared);
            let own = match set.axis {
                0 => set.sweep(quadrature, &turned, &turned_wanted, (own, cancelled)),
                _ => set.sweep(quadrature, sources, wanted, (own, cancelled)),
            };
            workspaces().push(own);
            sums.lock().unwrap_or_else(PoisonError::into_inner).add(set.take());
        });
        let swept = sums.into_inner().unwrap_or_else(PoisonError::into_inner).swept;
        Swept { radiances: wanted.radiances.map(|_| self.radiances()), ..swept }
    }

    fn turned_beams(&self, sources: &SweepSource) -> Vec<BeamSource> {
        sources.beams.iter().map(|beam| beam.map(|values| self.turned.of_grid(values))).collect()
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
}

/// Sums over angle sets, added as these finish: nine at once take more memory than all else. Those of a
/// channel are added in the order of their axes, whichever finishes first.
struct Sums {
    count: usize,
    count_with_faces: usize,
    turned: Layout,
    swept: Swept,
    /// Axis to be added next, by channel.
    next: [usize; 3],
    waiting: Vec<SetMoments>,
}

impl Sums {
    fn new(&Sweeper { count, count_with_faces, turned, .. }: &Sweeper, wanted: &Wanted) -> Self {
        let zero = || Moments::zero(count_with_faces);
        let high = || std::array::from_fn(|_| std::array::from_fn(|_| vec![0.0; count]));
        let swept = Swept {
            moments: zero(),
            third: wanted.third.then(zero),
            fourth: zero(),
            high: wanted.high.then(high),
            radiances: None,
        };
        Self { count, count_with_faces, turned, swept, next: [0; 3], waiting: Vec::new() }
    }

    fn add(&mut self, set: SetMoments) {
        self.waiting.push(set);
        let is_next = |next: &[usize; 3], set: &SetMoments| set.axis == next[set.channel];
        while let Some(number) = self.waiting.iter().position(|set| is_next(&self.next, set)) {
            let set = self.waiting.swap_remove(number);
            self.next[set.channel] += 1;
            self.add_next(&set);
        }
    }

    fn add_next(&mut self, set: &SetMoments) {
        let &mut Self { count, count_with_faces, turned, ref mut swept, .. } = self;
        let add_nodes = |sums: &mut dyn Iterator<Item = &mut [f32]>, values: &[f32]| {
            for (sums, values) in sums.zip(values.chunks_exact(count)) {
                let laid = (set.axis == 0).then(|| turned.to_grid(values));
                let values = laid.as_deref().unwrap_or(values);
                sums.iter_mut().zip(values).for_each(|(sum, value)| *sum += value);
            }
        };
        let Swept { moments, third, fourth, high, .. } = swept;
        let of_degrees =
            [(Some(moments), &set.moments), (third.as_mut(), &set.third), (Some(fourth), &set.fourth)];
        for (sums, (of_nodes, of_faces)) in of_degrees {
            let Some(sums) = sums else { continue };
            add_nodes(&mut sums.of_channel_mut(set.channel).chunks_exact_mut(count_with_faces), of_nodes);
            for index in 0..COUNT {
                let sums = &mut sums.channel_mut(set.channel, index)[count..];
                sums.iter_mut().zip(of_faces).for_each(|(sum, face)| *sum += face[index]);
            }
        }
        if let Some(high) = high {
            add_nodes(&mut high[set.channel].iter_mut().map(Vec::as_mut_slice), &set.high);
        }
    }
}
