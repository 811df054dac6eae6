//! Source iteration (Lewis & Miller 1984, chapter 3): sweep, scatter, sweep again. In go a first-collision
//! source and incident radiance, out comes the light of all orders. Invariant: an iteration adds one order of
//! scattering, and the remainder after the last is a geometric series.

use super::angle_set::SweepSource;
use super::angular_radiance::AngularRadiance;
use super::boundary::{BoundaryCondition, IncidentRadiance, Surrounding};
use super::chebyshev::{Chebyshev, Weights};
use super::domain::Domain;
use super::emissive_bodies::EmissiveBodies;
use super::extrapolation::Series;
use super::first_collision_source::{BeamSource, Emission, FirstCollisionSource, GlossySource};
use super::grid::Corners;
use super::harmonics::{by_lobe, irradiance_lobe};
use super::moments::Moments;
use super::quadrature::Quadrature;
use super::sky::{Sky, is_isotropic};
use super::sweep::{Sweeper, Swept};
use super::wanted::Wanted;
use crate::color::Rgb;
use std::mem::replace;

/// Maximum number of iterations for all orders, before acceleration.
const MOST_ITERATIONS: u32 = 24;
const FEWEST_ITERATIONS: u32 = 3;
/// Maximum number of accelerated iterations after that, and the remainder at which they stop, as a share of
/// all light.
const MOST_ACCELERATED: usize = 64;
const LEFT: f64 = 5e-4;

pub(crate) struct Problem<'a> {
    pub(crate) domain: Domain<'a>,
    /// Ordinates of all orders; and finer ones for the first order and for incident radiance, where these
    /// need them.
    pub(crate) quadrature: &'a Quadrature,
    pub(crate) fine: Option<&'a Quadrature>,
    pub(crate) sky: Option<&'a Sky>,
    pub(crate) surrounding: &'a Surrounding,
    /// Bodies whose emission is no part of the first source's.
    pub(crate) bodies: &'a EmissiveBodies,
    /// Number of orders; `None` for all.
    pub(crate) orders: Option<u32>,
    /// Corners of each place next to a finer grid within this one.
    pub(crate) next_to_inner: Option<&'a [Corners]>,
    /// Whether harmonics of degree 3 are needed, by glossy surfaces and fog that scatters forward; and those
    /// of degrees 5 and 6, by such fog alone.
    pub(crate) sees_third: bool,
    pub(crate) sees_high: bool,
    /// Whether the result is no longer needed.
    pub(crate) cancelled: &'a (dyn Fn() -> bool + Sync),
}

/// Solution: radiance of all orders.
pub(crate) struct Solution {
    pub(crate) all: Moments,
    /// Part of it that is straight from the sky, if that is swept apart.
    pub(crate) of_sky: Option<Moments>,
    /// Higher degrees, for the last scattering by surfaces and fog.
    pub(crate) last: Swept,
    /// Radiance for a finer grid within, in one sum or order by order, without light straight from the sky,
    /// which has its own.
    pub(crate) radiances: Vec<AngularRadiance>,
    pub(crate) sky_radiances: Option<AngularRadiance>,
    /// Light straight from emitters, if the rest does not include it; and its radiance for a finer grid, if
    /// it is swept by itself.
    pub(crate) emitted: Option<Swept>,
    /// Light of bright walls as swept, and the irradiance on each patch of wall by it as known.
    pub(crate) on_walls: Option<(Moments, Vec<Rgb>)>,
    pub(crate) emitted_radiances: Option<AngularRadiance>,
    /// Whether orders hardly grow darker, so that the series is cut short.
    pub(crate) is_endless: bool,
}

/// Emission density of the medium, per metre and steradian, and radiance of walls.
pub(super) struct Source {
    pub(super) volume: Moments,
    pub(super) walls: Vec<Rgb>,
    /// Whether it includes the first-collision source.
    pub(super) has_first: bool,
}

impl Source {
    /// `self += factor * other`, the factor by channel.
    pub(super) fn add(&mut self, other: &Self, factor: [f64; 3]) {
        self.volume.add(&other.volume, factor.map(|factor| factor as f32));
        self.has_first |= other.has_first;
        let factor = Rgb::from_array(factor);
        self.walls.iter_mut().zip(&other.walls).for_each(|(sum, added)| *sum += factor * *added);
    }

    fn scale(&mut self, factor: f64) {
        self.volume.scale(factor as f32);
        self.walls.iter_mut().for_each(|wall| *wall *= factor);
    }

    /// Sources of the same size, all zero.
    pub(super) fn emptied(&self) -> Self {
        let walls = vec![Rgb::ZERO; self.walls.len()];
        Self { volume: self.volume.emptied(), walls, has_first: false }
    }

    fn walls_by_channel(&self) -> [Vec<f32>; 3] {
        [0, 1, 2].map(|channel| self.walls.iter().map(|color| color[channel] as f32).collect())
    }
}

impl Problem<'_> {
    /// Solves the problem, order after order.
    pub(crate) fn solved(&self, first: FirstCollisionSource) -> Solution {
        let FirstCollisionSource { volume, beams, walls, glossy, not_again, emission, bright } = first;
        let mut sweeper = Sweeper::new(&self.domain);
        let mut source = Source { volume, walls, has_first: true };
        let (mut later, mut emitted, mut is_apart) = (source.emptied(), None, true);
        if let Some(Emission { volume, walls, has_lit_walls, is_part, not_again }) = emission {
            let emission = Source { volume, walls, has_first: false };
            if let Some(own) = not_again {
                let swept = self.sweep_emission(&mut sweeper, &emission);
                let mut scattered = self.scatter(&swept.moments, true);
                scattered.volume.add_nodes(&own, -1.0);
                if has_lit_walls {
                    scattered.walls.fill(Rgb::ZERO);
                }
                // As for lamps, emission counts as the first order once it is scattered.
                source.add(&scattered, [1.0; 3]);
                (emitted, is_apart) = (Some(swept), !is_part);
            } else {
                source.add(&emission, [1.0; 3]);
            }
        }
        not_again.iter().for_each(|own| later.volume.add_nodes(own, -1.0));
        let bright = bright.map(|bright| {
            let (swept, scattered) = self.sweep_bright(&mut sweeper, &bright, &source.emptied());
            later.add(&scattered, [1.0; 3]);
            (swept, bright)
        });
        let mut solution = SourceIteration { problem: self, sweeper, beams, glossy }.run(source, &later);
        let emitted_radiances = emitted.as_mut().and_then(|swept| swept.radiances.take());
        if let Some(swept) = emitted.as_ref().filter(|_| !is_apart) {
            solution.all.add(&swept.moments, [1.0; 3]);
            solution.last.add_last(swept);
        }
        bright.into_iter().for_each(|bright| solution.add_bright(bright));
        Solution { emitted: emitted.filter(|_| is_apart), emitted_radiances, ..solution }
    }

    /// Sweeps emission of the grid and of its surrounding. It has finer ordinates than all orders have, as
    /// emitters are small and bright.
    fn sweep_emission(&self, sweeper: &mut Sweeper, emission: &Source) -> Swept {
        let incident = self.surrounding.emitted.as_ref();
        let sources = SweepSource {
            volume: &emission.volume,
            beams: &[],
            walls: &emission.walls_by_channel(),
            glossy: None,
            bodies: Some(self.bodies),
            incident: incident.map_or(BoundaryCondition::Vacuum, BoundaryCondition::Incident),
        };
        let wanted = Wanted { moments: true, ..self.last(true) };
        sweeper.sweep(&Quadrature::fine(), &sources, &wanted, self.cancelled)
    }

    /// The scattering operator: sources from moments of radiance, by walls and by the medium, or by its
    /// oriented scatterers alone.
    pub(super) fn scatter(&self, light: &Moments, is_medium_lit: bool) -> Source {
        let Domain { cross_sections, walls, .. } = self.domain;
        let irradiances = walls.irradiances(|node, normal| {
            let face = walls.faces.of(node, normal);
            by_lobe(&irradiance_lobe(normal), &[0, 1, 2].map(|channel| light.at(channel, face)))
        });
        let volume = cross_sections.scatter(light, is_medium_lit);
        Source { volume, walls: walls.scattered(&irradiances), has_first: false }
    }

    /// Outputs for the last scattering of light that the whole medium scatters, or oriented scatterers alone.
    pub(super) fn last(&self, lights_medium: bool) -> Wanted<'_> {
        let (third, high) = (self.sees_third, self.sees_high && lights_medium);
        Wanted { moments: false, last: true, third, high, radiances: self.next_to_inner }
    }
}

/// A problem with the state of its iteration.
pub(super) struct SourceIteration<'a> {
    pub(super) problem: &'a Problem<'a>,
    sweeper: Sweeper<'a>,
    beams: Vec<BeamSource>,
    glossy: GlossySource,
}

impl<'a> SourceIteration<'a> {
    /// Runs all sweeps; `later` is added to the source of the second order.
    fn run(mut self, mut source: Source, later: &Source) -> Solution {
        let problem = self.problem;
        let mut light = Moments::zero(problem.domain.walls.faces.count_with_nodes());
        let (mut of_sky, mut sky_radiances) = (None, None);
        let nothing = source.emptied();
        let mut from_outside = None;
        let wanted = Wanted { moments: true, ..problem.last(true) };
        // Where orders are counted, each order has its own incident radiance.
        for incident in problem.surrounding.scattered.iter().filter(|_| problem.orders.is_none()) {
            let swept = self.sweep_incident(incident, &nothing, &wanted);
            source.add(&problem.scatter(&swept.moments, true), [1.0; 3]);
            light.add(&swept.moments, [1.0; 3]);
            Swept::add_to(&mut from_outside, swept);
        }
        if let Some(sky) = problem.sky {
            let wanted = Wanted { moments: true, ..problem.last(sky.lights_medium) };
            let mut swept = self.sweep_sky(sky, &nothing, &wanted);
            sky_radiances = swept.radiances.take();
            source.add(&problem.scatter(&swept.moments, sky.lights_medium), [1.0; 3]);
            if sky.is_part {
                light.add(&swept.moments, [1.0; 3]);
                of_sky = Some(swept.moments.clone());
                Swept::add_to(&mut from_outside, swept);
            }
        }
        drop(nothing);
        let mut first = self.sweep_finely(&source, &wanted);
        let (mut last, mut radiances, is_endless) = match problem.orders {
            Some(orders) => {
                let (last, radiances) = self.count(orders, (source, later), first, &mut light);
                (last, radiances, false)
            }
            None => {
                let first_light = first.as_mut().map(|swept| replace(&mut swept.moments, Moments::zero(0)));
                let (sent, is_endless) = self.iterate((source, later), first_light, &mut light);
                let mut last = self.sweep(&sent, BoundaryCondition::Vacuum, &problem.last(true));
                first.iter().for_each(|swept| last.add_last(swept));
                (last, Vec::new(), is_endless)
            }
        };
        from_outside.iter().for_each(|swept| last.add_last(swept));
        radiances.extend(last.radiances.take());
        Solution {
            all: light,
            of_sky,
            last,
            radiances,
            sky_radiances,
            emitted: None,
            on_walls: None,
            emitted_radiances: None,
            is_endless,
        }
    }

    /// Adds all orders, one after the other. Returns the sum of the sources that were not swept along fine
    /// ordinates, and whether the series was cut short.
    fn iterate(
        &mut self,
        (mut source, later): (Source, &Source),
        mut first: Option<Moments>,
        light: &mut Moments,
    ) -> (Source, bool) {
        let problem = self.problem;
        let mut series = Series::default();
        let mut sent = source.emptied();
        for iteration in 1..=MOST_ITERATIONS {
            if (problem.cancelled)() {
                break;
            }
            let next = first.take().unwrap_or_else(|| {
                sent.add(&source, [1.0; 3]);
                self.sweep(&source, BoundaryCondition::Vacuum, &Wanted::ORDERS).moments
            });
            light.add(&next, [1.0; 3]);
            let is_stable = series.go_on(next.total(), light.total());
            if iteration >= FEWEST_ITERATIONS && is_stable
                || iteration == MOST_ITERATIONS && series.is_endless
            {
                light.add(&next, series.rest.map(|rest| rest as f32));
                sent.add(&source, series.rest);
                break;
            }
            source = problem.scatter(&next, true);
            if iteration == MOST_ITERATIONS {
                self.accelerate(source, series.ratio, (&mut sent, light));
                break;
            }
            if iteration == 1 {
                source.add(later, [1.0; 3]);
            }
        }
        (sent, series.is_endless)
    }

    /// Adds the light of a remaining source whose orders hardly fall, and adds its sources to `sent`.
    fn accelerate(&mut self, mut left: Source, ratio: f64, (sent, light): (&mut Source, &mut Moments)) {
        // The ratio of orders still grows towards the largest eigenvalue.
        let mut chebyshev = Chebyshev::new(1.0 - 0.25 * (1.0 - ratio));
        let enough = LEFT * (1.0 - chebyshev.rate());
        let (mut step, mut light_of_step) = (left.emptied(), light.emptied());
        for Weights { left: of_left, before } in chebyshev.by_ref().take(MOST_ACCELERATED) {
            if (self.problem.cancelled)() {
                break;
            }
            let next = self.sweep(&left, BoundaryCondition::Vacuum, &Wanted::ORDERS).moments;
            step.scale(before);
            step.add(&left, [of_left; 3]);
            light_of_step.scale(before as f32);
            light_of_step.add(&next, [of_left as f32; 3]);
            sent.add(&step, [1.0; 3]);
            light.add(&light_of_step, [1.0; 3]);
            left.add(&self.problem.scatter(&light_of_step, true), [1.0; 3]);
            left.add(&step, [-1.0; 3]);
            if light_of_step.magnitude() <= enough * light.magnitude() {
                break;
            }
        }
    }

    /// Sweeps the first order along fine ordinates, where walls light each other: the ordinates of all orders
    /// have too many or too few in a quarter of the sphere, such as floor and wall share.
    fn sweep_finely(&mut self, source: &Source, wanted: &Wanted) -> Option<Swept> {
        let fine = self.problem.fine?;
        let sources = SweepSource {
            volume: &source.volume,
            beams: &self.beams,
            walls: &source.walls_by_channel(),
            glossy: Some(&self.glossy),
            bodies: None,
            incident: BoundaryCondition::Vacuum,
        };
        let swept = self.sweeper.sweep(fine, &sources, wanted, self.problem.cancelled);
        Some(self.to_orders(fine, swept))
    }

    /// Sweeps radiance that is incident on the grid.
    pub(super) fn sweep_incident(
        &mut self,
        incident: &IncidentRadiance,
        nothing: &Source,
        wanted: &Wanted,
    ) -> Swept {
        let condition = BoundaryCondition::Incident(incident);
        if !incident.is_fine {
            return self.sweep(nothing, condition, wanted);
        }
        let fine = Quadrature::fine();
        let swept = self.sweep_along(&fine, &dark(nothing, &nothing.walls_by_channel(), condition), wanted);
        self.to_orders(&fine, swept)
    }

    /// Sweeps light straight from the sky, or its remainder behind a larger grid. It has finer ordinates than
    /// all orders have: an uneven sky has edges, such as the horizon, and objects add more. An even sky has
    /// the ordinates of all orders, so that it stays isotropic to the last digit.
    fn sweep_sky(&mut self, sky: &Sky, nothing: &Source, wanted: &Wanted) -> Swept {
        let surrounding = self.problem.surrounding.of_sky.as_ref();
        let of_orders = sky.incident(self.problem.quadrature);
        if is_isotropic(&of_orders) {
            let uniform = BoundaryCondition::Uniform(&of_orders);
            let condition = surrounding.map_or(uniform, BoundaryCondition::Incident);
            return self.sweep(nothing, condition, wanted);
        }
        let fine = Quadrature::fine();
        let of_fine = sky.incident(&fine);
        let condition = surrounding.map_or(BoundaryCondition::Uniform(&of_fine), BoundaryCondition::Incident);
        self.sweep_along(&fine, &dark(nothing, &nothing.walls_by_channel(), condition), wanted)
    }

    /// Sweeps along the ordinates of all orders.
    pub(super) fn sweep(&mut self, source: &Source, incident: BoundaryCondition, wanted: &Wanted) -> Swept {
        let walls = source.walls_by_channel();
        let beams = if source.has_first { self.beams.as_slice() } else { &[] };
        let glossy = source.has_first.then_some(&self.glossy);
        let sources =
            SweepSource { volume: &source.volume, beams, walls: &walls, glossy, bodies: None, incident };
        self.sweeper.sweep(self.problem.quadrature, &sources, wanted, self.problem.cancelled)
    }

    /// Sweeps along other ordinates than those of all orders.
    fn sweep_along(&mut self, fine: &Quadrature, sources: &SweepSource, wanted: &Wanted) -> Swept {
        self.sweeper.sweep(fine, sources, wanted, self.problem.cancelled)
    }

    /// Reduces radiances to the ordinates of all orders; a cancelled sweep lacks some of them.
    fn to_orders(&self, fine: &Quadrature, mut swept: Swept) -> Swept {
        let all = swept.radiances.filter(|_| !(self.problem.cancelled)());
        swept.radiances = all.map(|radiances| radiances.along(fine, self.problem.quadrature));
        swept
    }
}

/// Sources of a sweep with incident radiance alone.
fn dark<'s>(
    nothing: &'s Source,
    walls: &'s [Vec<f32>; 3],
    incident: BoundaryCondition<'s>,
) -> SweepSource<'s> {
    SweepSource { volume: &nothing.volume, beams: &[], walls, glossy: None, bodies: None, incident }
}
