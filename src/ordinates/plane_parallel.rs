//! Plane-parallel layers over ground, without horizontal bounds. In go cross-sections by height, the sky and
//! suns, out comes radiance of all orders. Invariant: light differs with height alone, so it is solved in one
//! dimension, in milliseconds, however thin layers are.
//!
//! The equation is that of transfer in plane-parallel media (Chandrasekhar 1950, chapter 1). Sources are
//! linear in optical depth within a layer (Kylling & Stamnes 1992, "Efficient yet accurate solution of the
//! linear transport equation"). It is solved by source iteration: an iteration is one more scattering.

use super::counted_orders::MOST_ORDERS;
use super::double_gauss::{DoubleGauss, ORDINATES, STEPS};
use super::moment_operators::{DEGREES, HARMONICS, Harmonics, MomentOperators, basis, by_degree};
use crate::color::Rgb;
use glam::DVec3;
use rayon::prelude::*;
use std::f64::consts::FRAC_1_PI;

/// Maximum number of iterations for all orders, and the remainder at which they stop, as a share of all
/// light.
const MOST_ITERATIONS: u32 = 400;
const REST: f64 = 1e-5;
/// Maximum ratio of orders, where hardly anything absorbs.
const MOST_RATIO: f64 = 0.999;

/// Phase function of a species, by degree.
#[derive(Clone, Debug)]
pub struct Species {
    /// Coefficient by degree for light that was scattered before, and for beams.
    pub orders: [f64; DEGREES],
    /// Coefficient by degree for other light that is scattered for the first time.
    pub first: [f64; DEGREES],
}

/// Level between two layers.
#[derive(Clone, Debug)]
pub struct Level {
    /// Single-scattering albedo of each species, as shares of extinction, `0..=1`.
    pub albedos: Vec<Rgb>,
    /// Optical depth of the layer below it, by channel.
    pub depth_beneath: Rgb,
}

/// Parallel light from above.
#[derive(Clone, Debug)]
pub struct Beam {
    /// Direction of travel, +Y up.
    pub travel: DVec3,
    /// Irradiance on a plane that faces it, by level, W/m^2.
    pub irradiances: Vec<Rgb>,
}

/// Cross-sections, from the top down.
#[derive(Clone, Debug)]
pub struct Stack {
    /// Scatterers of the layers.
    pub species: Vec<Species>,
    /// Levels between layers; the last lies on the ground.
    pub levels: Vec<Level>,
}

/// Boundary conditions.
pub struct Boundaries<'a> {
    /// Radiance of the sky by the direction of travel, W m^-2 sr^-1.
    pub sky: &'a (dyn Fn(DVec3) -> Rgb + Sync),
    /// Whether layers scatter its light, or it lights the ground alone.
    pub sky_is_scattered: bool,
    /// Light of suns.
    pub beams: &'a [Beam],
    /// Reflectance of the ground, as a Lambertian surface.
    pub reflectance: Rgb,
    /// Radiance of the ground.
    pub emission: Rgb,
}

/// Light of one channel at each level.
struct Channel {
    /// Radiance along each ordinate, except light straight from the sky, which has an array of its own.
    scattered: Vec<[f64; ORDINATES]>,
    /// Each order of `scattered`, where orders are counted.
    orders: Vec<Vec<[f64; ORDINATES]>>,
    of_sky: Vec<[f64; ORDINATES]>,
}

/// Part of the radiance between layers.
#[derive(Clone, Copy)]
pub enum Part {
    /// All radiance except that straight from the sky.
    Scattered,
    /// One order of that, by its number from 0, where orders are counted.
    Order(usize),
    /// Radiance straight from the sky.
    OfSky,
}

/// Radiance of all orders between layers.
pub struct PlaneParallel {
    ordinates: DoubleGauss,
    operator: MomentOperators,
    channels: [Channel; 3],
}

impl PlaneParallel {
    /// Solves `orders` orders of scattering, or all.
    pub fn new(stack: &Stack, boundaries: &Boundaries, orders: Option<u32>) -> Self {
        let ordinates = DoubleGauss::default();
        let operator = MomentOperators::new(&ordinates);
        let channel = |channel: usize| {
            let depths = stack.levels.iter().map(|level| level.depth_beneath[channel]).collect();
            Solver { stack, boundaries, ordinates: &ordinates, operator: &operator, depths, channel }
                .solved(orders)
        };
        let mut solved: Vec<Channel> = (0..3).into_par_iter().map(channel).collect();
        let channels = std::array::from_fn(|_| solved.remove(0));
        Self { ordinates, operator, channels }
    }

    /// Directions of travel, their weights, and along each of them a part of the radiance at a level.
    pub fn radiances(&self, level: usize, part: Part) -> impl Iterator<Item = (DVec3, f64, Rgb)> {
        let of_part = move |channel: &Channel| match part {
            Part::Scattered => channel.scattered[level],
            Part::Order(number) => channel.orders[number][level],
            Part::OfSky => channel.of_sky[level],
        };
        let of_channels = self.channels.each_ref().map(of_part);
        (0..ORDINATES).map(move |number| {
            let radiance = Rgb::from_array(of_channels.map(|radiances| radiances[number]));
            (self.ordinates.directions[number], self.ordinates.weight(number), radiance)
        })
    }

    /// Parts that add up to [`Part::Scattered`]: its orders where these are counted.
    pub fn scattered_parts(&self) -> Vec<Part> {
        match self.channels[0].orders.len() {
            0 => vec![Part::Scattered],
            orders => (0..orders).map(Part::Order).collect(),
        }
    }

    /// Harmonics of radiance at a level, by channel, with or without light straight from the sky.
    pub fn harmonics(&self, level: usize, with_sky: bool) -> [Harmonics; 3] {
        self.channels.each_ref().map(|channel| {
            let mut radiances = channel.scattered[level];
            if with_sky {
                radiances.iter_mut().zip(&channel.of_sky[level]).for_each(|(sum, sky)| *sum += sky);
            }
            self.operator.harmonics(&radiances)
        })
    }
}

/// Formal solution across a layer: transmittance, and the weights of the sources at its end and at its start.
/// Sources are linear in optical depth.
#[derive(Clone, Copy)]
struct Formal {
    through: f64,
    near: f64,
    far: f64,
}

/// Formal solution across a layer of an optical depth.
fn formal(depth: f64) -> Formal {
    const LITTLE: f64 = 1e-3;
    let through = (-depth).exp();
    let lost = -(-depth).exp_m1();
    // Difference of 1 and `lost / depth`, as a series where they are nearly equal.
    let near = if depth < LITTLE { depth * (0.5 - depth / 6.0) } else { 1.0 - lost / depth };
    Formal { through, near, far: lost - near }
}

struct Solver<'a> {
    stack: &'a Stack,
    boundaries: &'a Boundaries<'a>,
    ordinates: &'a DoubleGauss,
    operator: &'a MomentOperators,
    depths: Vec<f64>,
    channel: usize,
}

/// Sources of the next order.
struct LayerSource {
    sources: Vec<Harmonics>,
    ground: f64,
}

impl LayerSource {
    fn add(&mut self, other: &Self) {
        let sums = self.sources.as_flattened_mut().iter_mut();
        sums.zip(other.sources.as_flattened()).for_each(|(sum, value)| *sum += value);
        self.ground += other.ground;
    }
}

fn add(sums: &mut [[f64; ORDINATES]], values: &[[f64; ORDINATES]], factor: f64) {
    for (sum, value) in sums.as_flattened_mut().iter_mut().zip(values.as_flattened()) {
        *sum += factor * value;
    }
}

impl Solver<'_> {
    fn solved(&self, orders: Option<u32>) -> Channel {
        let levels = self.depths.len();
        let of_sky = self.of_sky();
        let mut source = self.first();
        let mut scattered_sky = self.scatter(&of_sky);
        if !self.boundaries.sky_is_scattered {
            scattered_sky.sources.iter_mut().for_each(|source| *source = [0.0; HARMONICS]);
        }
        source.add(&scattered_sky);
        let mut all = vec![[0.0; ORDINATES]; levels];
        let mut by_order: Vec<Vec<[f64; ORDINATES]>> = Vec::new();
        let mut last = 0.0;
        for iteration in 1..=orders.unwrap_or(MOST_ITERATIONS) {
            let light = self.sweep(&source);
            add(&mut all, &light, 1.0);
            let [here, so_far] = [&light, &all].map(|light| light.as_flattened().iter().sum::<f64>());
            let ratio = if last > 0.0 { (here / last).clamp(0.0, MOST_RATIO) } else { 0.0 };
            let rest = ratio / (1.0 - ratio);
            last = here;
            if orders.is_none() && iteration > 2 && rest * here <= REST * so_far {
                add(&mut all, &light, rest);
                break;
            }
            source = self.scatter(&light);
            match by_order.get_mut(MOST_ORDERS - 1) {
                _ if orders.is_none() => {}
                Some(of_last) => add(of_last, &light, 1.0),
                None => by_order.push(light),
            }
        }
        Channel { scattered: all, orders: by_order, of_sky }
    }

    /// First-collision source of beams, and emission of the ground.
    fn first(&self) -> LayerSource {
        let mut sources = vec![[0.0; HARMONICS]; self.depths.len()];
        let mut on_ground = 0.0;
        for beam in self.boundaries.beams {
            let basis = basis(beam.travel);
            for ((source, level), irradiance) in
                sources.iter_mut().zip(&self.stack.levels).zip(&beam.irradiances)
            {
                for (species, albedo) in self.stack.species.iter().zip(&level.albedos) {
                    let factor = albedo[self.channel] * irradiance[self.channel];
                    let scattered = by_degree(&basis, |degree| factor * species.first[degree]);
                    source.iter_mut().zip(scattered).for_each(|(sum, value)| *sum += value);
                }
            }
            let arriving = beam.irradiances.last().copied().unwrap_or_default();
            on_ground += arriving[self.channel] * (-beam.travel.y).max(0.0);
        }
        let ground = FRAC_1_PI * self.boundaries.reflectance[self.channel] * on_ground
            + self.boundaries.emission[self.channel];
        LayerSource { sources, ground }
    }

    /// Radiance straight from the sky.
    fn of_sky(&self) -> Vec<[f64; ORDINATES]> {
        let mut light = vec![[0.0; ORDINATES]; self.depths.len()];
        for number in DoubleGauss::downward() {
            let travel = self.ordinates.directions[number];
            let mean = |directions: &[DVec3]| {
                let sum: Rgb = directions.iter().map(|direction| (self.boundaries.sky)(*direction)).sum();
                sum / directions.len() as f64
            };
            light[0][number] = mean(&self.ordinates.spread(number).collect::<Vec<_>>())[self.channel];
            for level in 1..self.depths.len() {
                let depth = self.depths[level - 1] / -travel.y;
                light[level][number] = (-depth).exp() * light[level - 1][number];
            }
        }
        light
    }

    /// The scattering operator of layers and ground.
    fn scatter(&self, light: &[[f64; ORDINATES]]) -> LayerSource {
        let source = |(level, radiances): (&Level, &[f64; ORDINATES])| {
            let harmonics = self.operator.harmonics(radiances);
            let mut source = [0.0; HARMONICS];
            for (species, albedo) in self.stack.species.iter().zip(&level.albedos) {
                let scattered = by_degree(&harmonics, |degree| albedo[self.channel] * species.orders[degree]);
                source.iter_mut().zip(scattered).for_each(|(sum, value)| *sum += value);
            }
            source
        };
        let sources = self.stack.levels.iter().zip(light).map(source).collect();
        let on_ground: f64 = light.last().map_or(0.0, |lowest| {
            let flux = |number: usize| {
                -self.ordinates.directions[number].y * self.ordinates.weight(number) * lowest[number]
            };
            DoubleGauss::downward().map(flux).sum()
        });
        let ground = FRAC_1_PI * self.boundaries.reflectance[self.channel] * on_ground;
        LayerSource { sources, ground }
    }

    /// Radiance from sources of layers and ground, without further scattering.
    fn sweep(&self, source: &LayerSource) -> Vec<[f64; ORDINATES]> {
        let levels = self.depths.len();
        let sources: Vec<[f64; ORDINATES]> =
            source.sources.iter().map(|source| self.operator.radiances(source)).collect();
        let mut light = vec![[0.0; ORDINATES]; levels];
        let (up, down) = (0..DoubleGauss::downward().start, DoubleGauss::downward());
        light[levels - 1][up.clone()].fill(source.ground);
        // Ordinates of a ring have the same path through a layer.
        for ring in down.step_by(STEPS) {
            let way = -self.ordinates.directions[ring].y;
            for level in 1..levels {
                let formal = formal(self.depths[level - 1] / way);
                formal.cross(&mut light, &sources, (level - 1, level), ring..ring + STEPS);
            }
        }
        for ring in up.step_by(STEPS) {
            let way = self.ordinates.directions[ring].y;
            for level in (1..levels).rev() {
                let formal = formal(self.depths[level - 1] / way);
                formal.cross(&mut light, &sources, (level, level - 1), ring..ring + STEPS);
            }
        }
        light
    }
}

impl Formal {
    /// Sweeps from one level to the next, along some ordinates.
    fn cross(
        self,
        light: &mut [[f64; ORDINATES]],
        sources: &[[f64; ORDINATES]],
        (from, to): (usize, usize),
        numbers: std::ops::Range<usize>,
    ) {
        let Self { through, near, far } = self;
        for number in numbers {
            light[to][number] =
                through * light[from][number] + far * sources[from][number] + near * sources[to][number];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    fn isotropic() -> Species {
        let mut orders = [0.0; DEGREES];
        orders[0] = 1.0;
        Species { first: orders, orders }
    }

    fn stack(depth: f64, albedo: f64, count: usize) -> Stack {
        let level = |number: usize| Level {
            albedos: vec![Rgb::splat(albedo)],
            depth_beneath: Rgb::splat(if number < count { depth / count as f64 } else { 0.0 }),
        };
        Stack { species: vec![isotropic()], levels: (0..=count).map(level).collect() }
    }

    fn boundaries<'a>(
        sky: &'a (dyn Fn(DVec3) -> Rgb + Sync),
        beams: &'a [Beam],
        reflectance: f64,
    ) -> Boundaries<'a> {
        Boundaries {
            sky,
            sky_is_scattered: true,
            beams,
            reflectance: Rgb::splat(reflectance),
            emission: Rgb::ZERO,
        }
    }

    #[test]
    fn in_a_furnace_light_is_the_same_everywhere() {
        let solved = PlaneParallel::new(&stack(3.0, 1.0, 32), &boundaries(&|_| Rgb::ONE, &[], 1.0), None);
        for level in [0, 7, 32] {
            let of_sky = solved.radiances(level, Part::OfSky);
            for ((travel, _, scattered), (.., of_sky)) in solved.radiances(level, Part::Scattered).zip(of_sky)
            {
                let all = (scattered + of_sky).x;
                assert!((all - 1.0).abs() < 2e-4, "{level} {travel}: {all}");
            }
        }
    }

    /// Without absorption all of a beam leaves at the top or at the bottom.
    #[test]
    fn what_comes_in_goes_out() {
        let depth = 1.0;
        let count = 64;
        let transmitted = |level: usize| (-depth * level as f64 / f64::from(count)).exp();
        let irradiances = (0..=count as usize).map(|level| Rgb::splat(transmitted(level))).collect();
        let beams = [Beam { travel: -DVec3::Y, irradiances }];
        let solved = PlaneParallel::new(
            &stack(depth, 1.0, count as usize),
            &boundaries(&|_| Rgb::ZERO, &beams, 0.0),
            None,
        );
        let flux = |level: usize, sign: f64| -> f64 {
            solved
                .radiances(level, Part::Scattered)
                .map(|(travel, weight, light)| weight * (sign * travel.y).max(0.0) * light.x)
                .sum()
        };
        let (reflected, below) = (flux(0, 1.0), flux(count as usize, -1.0) + (-depth).exp());
        assert!((reflected + below - 1.0).abs() < 3e-4, "{reflected} {below}");
        // The two-stream approximation has depth / (2 + depth).
        assert!((0.3..0.4).contains(&reflected), "{reflected}");
    }

    /// A single scattering has a closed form.
    #[test]
    fn one_order_is_an_exponential() {
        let (depth, count) = (0.7, 64);
        let irradiances =
            (0..=count).map(|level| Rgb::splat((-depth * level as f64 / count as f64 / 0.8).exp())).collect();
        let beams = [Beam { travel: DVec3::new(0.6, -0.8, 0.0), irradiances }];
        let solved =
            PlaneParallel::new(&stack(depth, 0.9, count), &boundaries(&|_| Rgb::ZERO, &beams, 0.0), Some(1));
        for (travel, _, found) in solved.radiances(0, Part::Scattered).filter(|(travel, ..)| travel.y > 0.0) {
            let rate = 1.0 / 0.8 + 1.0 / travel.y;
            let expected = 0.9 / (4.0 * PI) / travel.y * (1.0 - (-depth * rate).exp()) / rate;
            assert!((found.x / expected - 1.0).abs() < 2e-4, "{travel}: {found} {expected}");
        }
    }
}
