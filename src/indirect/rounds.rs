//! From order to order: sweep, scatter, sweep again. In go first sources and the sky, out comes the light of
//! all orders that are wanted. Invariant: a round adds one order of scattering, and what is left after the
//! last is a geometric series.

use super::beam::Beam;
use super::carrier::Sources;
use super::grid::{Corners, Grid};
use super::halo::{Around, Halo};
use super::harmonics::{by_lobe, irradiance_lobe};
use super::highlights::Highlights;
use super::inflow::Inflow;
use super::matter::Matter;
use super::moments::{Moments, NodeMoments};
use super::ordinates::{Ordinate, Ordinates};
use super::radiances::Radiances;
use super::sweep::{Sweeper, Swept};
use super::walls::Walls;
use super::wanted::Wanted;
use crate::color::Rgb;
use crate::scene::Bounces;
use crate::snapshot::FrozenSky;
use glam::DVec3;

/// Rounds when all of them are wanted.
const MOST_ROUNDS: u32 = 24;
const FEWEST_ROUNDS: u32 = 3;
/// What is left after the last round, as a share of all light, when a geometric series tells it well; and by
/// how much a round more may change what it tells.
const REST: f64 = 0.01;
const SURPRISE: f64 = 2e-4;
/// Of light that goes on and on: a closed scene that absorbs nothing has no end.
const MOST_RATIO: f64 = 0.98;

/// By so little of the mean a sky differs that is the same on all sides.
const EVEN: f64 = 1e-6;

/// What is done from round to round.
pub(super) struct Rounds<'a> {
    pub(super) sweeper: Sweeper<'a>,
    pub(super) scatterers: Scatterers<'a>,
    pub(super) ordinates: &'a Ordinates,
    pub(super) grid: &'a Grid,
    pub(super) sky: Option<FrozenSky<'a>>,
    /// Whether the sky's own light is part of the field, or only what becomes of it.
    pub(super) has_sky: bool,
    /// What first sources have beyond harmonics.
    pub(super) beams: Vec<Beam>,
    /// Along which the first order is swept, where that needs finer ones.
    pub(super) fine: Option<&'a Ordinates>,
    /// What of lamps' and suns' light shines on walls, along those of the first order.
    pub(super) highlights: Highlights,
    /// Nodes about each place next to a finer grid within this one.
    pub(super) next_to_inner: Option<&'a [Corners]>,
    /// Whether what is seen makes something of degree 3: what shines, and fog that scatters ahead; and of
    /// degrees 5 and 6, which such fog alone does.
    pub(super) sees_third: bool,
    pub(super) sees_high: bool,
    /// Whether nobody waits for the light any more.
    pub(super) cancelled: &'a (dyn Fn() -> bool + Sync),
}

/// What rounds end with.
pub(super) struct Light {
    /// All of it.
    pub(super) all: Moments,
    /// That part of it that comes straight from the sky, if that can be told apart.
    pub(super) of_sky: Option<Moments>,
    /// What surfaces and fog that are seen make of it beyond that.
    pub(super) last: Swept,
    /// Of light that comes straight from the sky what a finer grid within gets; the rest is in `last`.
    pub(super) sky_radiances: Option<Radiances>,
    /// Whether it goes on and on, and is cut short.
    pub(super) is_endless: bool,
}

/// Where light goes on to.
#[derive(Clone, Copy)]
pub(super) struct Scatterers<'a> {
    pub(super) matter: &'a Matter,
    pub(super) walls: &'a Walls,
}

/// Light on its way to the next order: what matter sends out, per metre and steradian,
/// and walls, as radiance.
struct Leaving {
    matter: Moments,
    walls: Vec<Rgb>,
    /// Whether light of lamps and suns is in it that is scattered first.
    has_first: bool,
}

impl Leaving {
    /// `self += factor * other`, the factor by channel.
    fn add(&mut self, other: &Self, factor: [f64; 3]) {
        self.matter.add(&other.matter, factor.map(|factor| factor as f32));
        self.has_first |= other.has_first;
        let factor = Rgb::from_array(factor);
        self.walls.iter_mut().zip(&other.walls).for_each(|(sum, added)| *sum += factor * *added);
    }

    fn of_walls(&self) -> [Vec<f32>; 3] {
        [0, 1, 2].map(|channel| self.walls.iter().map(|color| color[channel] as f32).collect())
    }
}

impl<'a> Rounds<'a> {
    /// Order after order. `again` is what the second of them is to be without; `on_walls` is what lamps and
    /// suns shine on each patch, W/m^2.
    pub(super) fn run(
        mut self,
        bounces: Bounces,
        (first, again): (Moments, NodeMoments),
        on_walls: &[Rgb],
        around: &Around,
    ) -> Light {
        let dark = vec![Rgb::ZERO; on_walls.len()];
        let mut leaving = Leaving { matter: first, walls: dark.clone(), has_first: true };
        let mut light = Moments::zero(self.scatterers.walls.faces.count_with_nodes());
        let (mut of_sky, mut sky_radiances) = (None, None);
        self.scatterers.matter.emit(&mut leaving.matter);
        self.scatterers.add_first(on_walls, &mut leaving.walls);
        let nothing = Leaving { matter: leaving.matter.emptied(), walls: dark, has_first: false };
        let mut from_outside = None;
        if let Some(halo) = &around.scattered {
            let wanted = Wanted { moments: true, ..self.last(true) };
            let swept = self.sweep_around(halo, &nothing, &wanted);
            // Where orders are counted, nobody knows how many it has behind it.
            if bounces == Bounces::All {
                leaving.add(&self.scatterers.scatter(&swept.moments, true), [1.0; 3]);
            }
            light.add(&swept.moments, [1.0; 3]);
            Swept::add_to(&mut from_outside, swept);
        }
        let lights_fog = self.sky.is_some_and(|sky| sky.lights_fog());
        if let Some(sky) = self.sky.filter(FrozenSky::lights_surfaces) {
            let wanted = Wanted { moments: true, ..self.last(lights_fog) };
            let mut swept = self.sweep_sky((sky, around.of_sky.as_ref()), &nothing, &wanted);
            sky_radiances = swept.radiances.take();
            leaving.add(&self.scatterers.scatter(&swept.moments, lights_fog), [1.0; 3]);
            if self.has_sky {
                light.add(&swept.moments, [1.0; 3]);
                of_sky = Some(swept.moments.clone());
                Swept::add_to(&mut from_outside, swept);
            }
        }
        let wanted = self.last(true);
        let first = self.sweep_finely(&leaving, &Wanted { moments: true, ..wanted });
        let (sent, is_endless) = self.go_on(bounces, (leaving, first.as_ref(), again), &mut light);
        let mut last = self.sweep(&sent, Inflow::Nothing, &wanted);
        from_outside.iter().chain(&first).for_each(|swept| last.add_last(swept));
        Light { all: light, of_sky, last, sky_radiances, is_endless }
    }

    /// What is seen, of light that fog gets or does not.
    fn last(&self, lights_fog: bool) -> Wanted<'a> {
        let (third, high) = (self.sees_third, self.sees_high && lights_fog);
        Wanted { moments: false, last: true, third, high, radiances: self.next_to_inner }
    }

    /// Adds order after order; all that was sent out on the way and not swept finely, and whether there is no
    /// end to it.
    fn go_on(
        &mut self,
        bounces: Bounces,
        (mut leaving, mut first, again): (Leaving, Option<&Swept>, NodeMoments),
        light: &mut Moments,
    ) -> (Leaving, bool) {
        let rounds = match bounces {
            Bounces::UpTo(count) => count,
            Bounces::All => MOST_ROUNDS,
        };
        let mut series = Series::default();
        let dark = vec![Rgb::ZERO; leaving.walls.len()];
        let mut sent = Leaving { matter: leaving.matter.emptied(), walls: dark, has_first: false };
        for round in 1..=rounds {
            if (self.cancelled)() {
                break;
            }
            let next = if let Some(first) = first.take() {
                first.moments.clone()
            } else {
                sent.add(&leaving, [1.0; 3]);
                self.sweep(&leaving, Inflow::Nothing, &Wanted::ORDERS).moments
            };
            light.add(&next, [1.0; 3]);
            if bounces == Bounces::All {
                let told = series.go_on(next.total(), light.total());
                if round >= FEWEST_ROUNDS && told || round == rounds {
                    light.add(&next, series.rest.map(|rest| rest as f32));
                    sent.add(&leaving, series.rest);
                    break;
                }
            }
            leaving = self.scatterers.scatter(&next, true);
            if round == 1 {
                leaving.matter.take_nodes(&again);
            }
        }
        (sent, series.is_endless)
    }

    /// Light of the first order where walls stand in each other's light: of the ordinates of all orders a
    /// quarter of the sphere, such as floor and wall share, has too many or too few.
    fn sweep_finely(&self, leaving: &Leaving, wanted: &Wanted) -> Option<Swept> {
        let fine = self.fine?;
        let sources = Sources {
            of_matter: &leaving.matter,
            beams: &self.beams,
            of_walls: &leaving.of_walls(),
            highlights: Some(&self.highlights),
            inflow: Inflow::Nothing,
        };
        let mut swept = self.sweep_along(fine, &sources, wanted);
        // A sweep that was cut short has not all of them.
        let all = swept.radiances.filter(|_| !(self.cancelled)());
        swept.radiances = all.map(|radiances| radiances.along(fine, self.ordinates));
        Some(swept)
    }

    /// What comes in from outside.
    fn sweep_around(&mut self, halo: &Halo, nothing: &Leaving, wanted: &Wanted) -> Swept {
        if !halo.is_fine {
            return self.sweep(nothing, Inflow::Around(halo), wanted);
        }
        let fine = Ordinates::fine();
        let sources = Sources {
            of_matter: &nothing.matter,
            beams: &[],
            of_walls: &nothing.of_walls(),
            highlights: None,
            inflow: Inflow::Around(halo),
        };
        let mut swept = self.sweep_along(&fine, &sources, wanted);
        let all = swept.radiances.filter(|_| !(self.cancelled)());
        swept.radiances = all.map(|radiances| radiances.along(&fine, self.ordinates));
        swept
    }

    /// Along other ordinates than those of all orders.
    fn sweep_along(&self, fine: &Ordinates, sources: &Sources, wanted: &Wanted) -> Swept {
        let Scatterers { matter, walls } = self.scatterers;
        Sweeper::new(self.grid, matter, walls, fine).sweep(sources, wanted, self.cancelled)
    }

    fn sweep(&mut self, leaving: &Leaving, inflow: Inflow, wanted: &Wanted) -> Swept {
        let of_walls = leaving.of_walls();
        let beams = if leaving.has_first { self.beams.as_slice() } else { &[] };
        let highlights = leaving.has_first.then_some(&self.highlights);
        let sources = Sources { of_matter: &leaving.matter, beams, of_walls: &of_walls, highlights, inflow };
        self.sweeper.sweep(&sources, wanted, self.cancelled)
    }

    /// Light of the sky that nothing has scattered, of all of it or what a larger grid lets through: along
    /// finer ordinates than those of all orders. An uneven sky has edges, the horizon above all, and things
    /// cut more. An even one stays so to the last digit if one set of ordinates shares out all light.
    fn sweep_sky(
        &mut self,
        (sky, around): (FrozenSky, Option<&Halo>),
        nothing: &Leaving,
        wanted: &Wanted,
    ) -> Swept {
        let of_orders = inflow(sky, self.ordinates);
        if is_even(&of_orders) {
            let inflow = around.map_or(Inflow::Even(&of_orders), Inflow::Around);
            return self.sweep(nothing, inflow, wanted);
        }
        let fine = Ordinates::fine();
        let of_fine = inflow(sky, &fine);
        let inflow = around.map_or(Inflow::Even(&of_fine), Inflow::Around);
        let of_walls = nothing.of_walls();
        let sources =
            Sources { of_matter: &nothing.matter, beams: &[], of_walls: &of_walls, highlights: None, inflow };
        self.sweep_along(&fine, &sources, wanted)
    }
}

/// Whether the sky's own light is part of the field: not where a part of the sky is as bright as a sun, whose
/// shadows have borders.
pub(super) fn has_sky(sky: Option<FrozenSky>) -> bool {
    sky.is_some_and(|sky| !sky.has_sun())
}

/// Whether radiance is the same along all ordinates.
pub(super) fn is_even(radiances: &[Rgb]) -> bool {
    radiances.iter().all(|radiance| (*radiance - radiances[0]).abs().cmple(EVEN * radiances[0]).all())
}

/// The sky's radiance along each ordinate, on the mean of the directions that are nearest to it; where there
/// is none of the nearest.
pub(super) fn inflow(sky: FrozenSky, ordinates: &Ordinates) -> Vec<Rgb> {
    let mut sums = vec![(Rgb::ZERO, 0.0); ordinates.as_slice().len()];
    for (direction, radiance) in sky.means() {
        let (sum, count) = &mut sums[ordinates.nearest(-direction)];
        *sum += radiance;
        *count += 1.0;
    }
    let nearest = |travel: DVec3| {
        let closer = |a: &(DVec3, Rgb), b: &(DVec3, Rgb)| b.0.dot(travel).total_cmp(&a.0.dot(travel));
        sky.means().max_by(closer).map_or(Rgb::ZERO, |(_, radiance)| radiance)
    };
    let mean = |((sum, count), ordinate): ((Rgb, f64), &Ordinate)| {
        if count > 0.0 { sum / count } else { nearest(ordinate.direction) }
    };
    sums.into_iter().zip(ordinates.iter()).map(mean).collect()
}

impl Scatterers<'_> {
    /// Of light that fog is to see, or not.
    fn scatter(&self, light: &Moments, is_seen_by_fog: bool) -> Leaving {
        let irradiances = self.walls.irradiances(|node, normal| {
            let face = self.walls.faces.of(node, normal);
            by_lobe(&irradiance_lobe(normal), &[0, 1, 2].map(|channel| light.at(channel, face)))
        });
        let walls = self.walls.scattered(&irradiances);
        Leaving { matter: self.matter.scatter(light, is_seen_by_fog), walls, has_first: false }
    }

    /// What walls make of lamps and suns, and what they emit.
    fn add_first(&self, irradiances: &[Rgb], walls: &mut [Rgb]) {
        let scattered = self.walls.scattered(irradiances);
        for ((sum, patch), scattered) in walls.iter_mut().zip(&self.walls.patches).zip(scattered) {
            *sum += scattered + patch.scatters.emission;
        }
    }
}

/// A geometric series, by channel.
#[derive(Default)]
struct Series {
    /// The last round's light.
    last: [f64; 3],
    /// What follows it, in units of it.
    rest: [f64; 3],
    /// All light with that.
    all: [f64; 3],
    /// Whether rounds hardly grow darker.
    is_endless: bool,
}

impl Series {
    /// Takes a round's light and the sum of all so far; whether what follows is little, and as expected.
    fn go_on(&mut self, round: [f64; 3], so_far: [f64; 3]) -> bool {
        let mut is_told = true;
        self.is_endless = false;
        for channel in 0..3 {
            let ratio = match self.last[channel] {
                last if last > 0.0 => (round[channel] / last).clamp(0.0, MOST_RATIO),
                _ => 0.0,
            };
            self.is_endless |= ratio == MOST_RATIO;
            let rest = ratio / (1.0 - ratio);
            let left = rest * round[channel];
            let all = so_far[channel] + left;
            is_told &= left <= REST * all && (all - self.all[channel]).abs() <= SURPRISE * all;
            (self.last[channel], self.rest[channel], self.all[channel]) = (round[channel], rest, all);
        }
        is_told
    }
}
