//! Layers around all grids: unbounded fog, or a wide slab, over plain ground. In go a snapshot, its fog and
//! its ground, out comes light by height alone. Invariant: regions far from all objects cost hardly any time,
//! however thin the layers are, and a grid gets its incident radiance from them.
//!
//! The spherical harmonics discrete ordinate method treats open boundaries in the same way (Evans 1998, "The
//! spherical harmonics discrete ordinate method for three-dimensional atmospheric radiative transfer",
//! section 2c).

use super::gathered::{Gathered, with_peaks};
use super::ground::Ground;
use super::lobe::Lobe;
use super::sky::{has_sky, sky_of};
use super::stack::{Between, Filled, Heights};
use super::towards::Towards;
use crate::canopy::clumps::Clump;
use crate::canopy::fluence::Peak;
use crate::color::Rgb;
use crate::fog::Medium;
use crate::math::{bounds, corners};
use crate::ordinates::angular_radiance::AngularRadiance;
use crate::ordinates::boundary::{IncidentRadiance, Surrounding, rim_places};
use crate::ordinates::grid::Grid;
use crate::ordinates::harmonics::{COUNT, basis, fourth_basis, product, third_basis};
use crate::ordinates::high_degrees::SEEN_DEGREES;
use crate::ordinates::quadrature::Quadrature;
use crate::ordinates::sky::is_isotropic;
use crate::ordinates::{Boundaries, HARMONICS, Harmonics, Part, PlaneParallel, harmonic_basis};
use crate::scene::Bounces;
use crate::snapshot::{FrozenSky, Snapshot};
use glam::{DQuat, DVec3};
use std::collections::HashMap;

/// Light that depends on height alone.
pub(super) struct Layers {
    /// Whether the ground emits, so that its emission is part of their light.
    pub(super) ground_emits: bool,
    pub(super) heights: Heights,
    /// Fog that is not theirs.
    pub(super) other_fog: Medium,
    light: PlaneParallel,
    levels: Vec<LevelLight>,
    /// Forward peak of each sun at each level.
    peaks: Vec<Vec<Peak>>,
}

/// Light at one level, by harmonics.
struct LevelLight {
    /// Downward irradiance, W/m^2.
    downward: Rgb,
    /// Moments for surfaces, in world space: up to degree 2, and of degrees 3 and 4.
    moments: [[f32; COUNT]; 3],
    third: [[f32; COUNT]; 3],
    fourth: [[f32; COUNT]; 3],
    in_fog: FogLight,
}

/// Radiance for fog, by harmonics and channel; fog thins out along +Y.
pub(super) struct FogLight([Harmonics; 3]);

impl FogLight {
    pub(super) const ZERO: Self = Self([[0.0; HARMONICS]; 3]);

    pub(super) fn add(&mut self, other: &Self, factor: f64) {
        let sums = self.0.as_flattened_mut().iter_mut().zip(other.0.as_flattened());
        sums.for_each(|(sum, value)| *sum += factor * value);
    }

    pub(super) fn scaled(&self, factor: f64) -> Self {
        Self(self.0.map(|channel| channel.map(|value| factor * value)))
    }

    /// Radiance that is scattered into a direction, given by its harmonics.
    pub(super) fn scattered(&self, towards: &Harmonics, scattering: &[Rgb; SEEN_DEGREES]) -> Rgb {
        let of_channel = |channel: usize| -> f64 {
            let of_degree = |degree: usize| {
                let harmonics = degree * degree..(degree + 1) * (degree + 1);
                let products = harmonics.map(|at| towards[at] * self.0[channel][at]);
                scattering[degree][channel] * products.sum::<f64>()
            };
            (0..SEEN_DEGREES).map(of_degree).sum()
        };
        Rgb::new(of_channel(0), of_channel(1), of_channel(2))
    }
}

impl Between {
    fn mean<const N: usize>(&self, of: impl Fn(usize) -> [[f32; N]; 3]) -> [[f32; N]; 3] {
        let (above, below) = (of(self.above), of(self.below));
        let share = self.share_below as f32;
        std::array::from_fn(|channel| {
            std::array::from_fn(|index| {
                above[channel][index] + share * (below[channel][index] - above[channel][index])
            })
        })
    }
}

/// Places around a grid: those at one height share an entry.
struct RimLevels {
    levels: Vec<Between>,
    /// Index of each place's entry.
    numbers: Vec<u32>,
}

impl RimLevels {
    fn of(places: impl Iterator<Item = Between>) -> Self {
        let (mut levels, mut known) = (Vec::new(), HashMap::new());
        let number = |place: Between| {
            *known.entry((place.above, place.below, place.share_below.to_bits())).or_insert_with(|| {
                levels.push(place);
                levels.len() as u32 - 1
            })
        };
        let numbers = places.map(number).collect();
        Self { levels, numbers }
    }
}

impl Layers {
    /// Layers of fog over a ground in a snapshot with other fog; `None` if they have no common direction.
    pub(super) fn new(
        snapshot: &Snapshot,
        (fog, other_fog): (Medium, Medium),
        ground: Option<&Ground>,
        bounces: Bounces,
    ) -> Option<Self> {
        let heights = Heights::of(fog, snapshot.view.eye, ground)?;
        let Filled { stack, beams, peaks } = heights.filled(snapshot, bounces);
        let sky = snapshot.sky.filter(FrozenSky::lights_surfaces);
        let world_from_layers = heights.layers_from_world.inverse();
        let of_sky = |travel: DVec3| sky.map_or(Rgb::ZERO, |sky| sky.around(world_from_layers * -travel));
        let beneath = || match bounces {
            Bounces::All => heights.reflectance_beneath(snapshot),
            // The number of scatterings below is unknown, so they are left out.
            Bounces::UpTo(_) => Rgb::ZERO,
        };
        let matte = ground.map(|ground| ground.optics);
        let boundaries = Boundaries {
            sky: &of_sky,
            sky_is_scattered: sky.is_some_and(|sky| sky.lights_fog()),
            beams: &beams,
            reflectance: matte.map_or_else(beneath, |matte| matte.reflectance),
            emission: matte.map_or(Rgb::ZERO, |matte| matte.emission),
        };
        let light = PlaneParallel::new(&stack, &boundaries, bounces.orders());
        let has_own_sky = has_sky(snapshot.sky);
        let seen = |level: usize| {
            LevelLight::of(
                &light,
                level,
                (has_own_sky, has_own_sky && boundaries.sky_is_scattered),
                world_from_layers,
            )
        };
        let levels = (0..stack.levels.len()).map(seen).collect();
        let ground_emits = boundaries.emission != Rgb::ZERO;
        Some(Self { ground_emits, heights, other_fog, light, levels, peaks })
    }

    /// Incident radiance on a grid within.
    pub(super) fn around(&self, grid: &Grid, sky: Option<FrozenSky>) -> Surrounding {
        let places = RimLevels::of(rim_places(grid).into_iter().map(|place| self.heights.between(place)));
        let quadrature = Quadrature::new();
        let fine = Quadrature::fine();
        let parts = self.light.scattered_parts();
        let scattered = parts.into_iter().map(|part| self.incident((grid, &places), &fine, part)).collect();
        let of_sky = sky_of(sky).map(|sky| {
            let is_even = is_isotropic(&sky.incident(&quadrature));
            self.incident((grid, &places), if is_even { &quadrature } else { &fine }, Part::OfSky)
        });
        Surrounding { scattered, of_sky, emitted: None }
    }

    /// Incident radiance of a part. Near the horizon layers are bright, in a band narrower than an ordinate's
    /// solid angle. Each ordinate gets the mean over the directions nearest to it on its side of the horizon,
    /// so upward radiance never turns downward.
    fn incident(
        &self,
        (grid, places): (&Grid, &RimLevels),
        quadrature: &Quadrature,
        part: Part,
    ) -> IncidentRadiance {
        let up = self.heights.up;
        let directions: Vec<DVec3> = quadrature.iter().map(|ordinate| ordinate.direction).collect();
        let nearest = |travel: DVec3| {
            let on_this_side = directions.iter().enumerate();
            let on_this_side =
                on_this_side.filter(|(_, other)| (other.dot(up) > 0.0) == (travel.dot(up) > 0.0));
            on_this_side
                .max_by(|a, b| a.1.dot(travel).total_cmp(&b.1.dot(travel)))
                .map_or(0, |(number, _)| number)
        };
        let world_from_layers = self.heights.layers_from_world.inverse();
        let numbers: Vec<usize> =
            self.light.radiances(0, part).map(|(travel, ..)| nearest(world_from_layers * travel)).collect();
        let mut means = vec![vec![Rgb::ZERO; directions.len()]; self.levels.len()];
        for (level, means) in means.iter_mut().enumerate() {
            let mut weights = vec![0.0; directions.len()];
            for ((_, weight, radiance), number) in self.light.radiances(level, part).zip(&numbers) {
                means[*number] += weight * radiance;
                weights[*number] += weight;
            }
            means
                .iter_mut()
                .zip(&weights)
                .filter(|(_, weight)| **weight > 0.0)
                .for_each(|(mean, weight)| *mean /= *weight);
        }
        let of_channel = |channel: usize| {
            let along = |number: usize| {
                let at = |place: &Between| {
                    let [above, below] =
                        [place.above, place.below].map(|level| means[level][number][channel]);
                    (above + place.share_below * (below - above)) as f32
                };
                places.levels.iter().map(at).collect::<Vec<f32>>()
            };
            (0..directions.len()).map(along).collect()
        };
        let radiances = AngularRadiance([0, 1, 2].map(of_channel));
        IncidentRadiance::of_alike(grid, places.numbers.iter().copied(), radiances)
    }

    /// Radiance from all sides at a place in world space.
    pub(super) fn gathered(&self, world: DVec3) -> Gathered {
        let between = self.heights.between(world);
        Gathered {
            moments: between.mean(|level| self.levels[level].moments),
            fourth: between.mean(|level| self.levels[level].fourth),
            peaks: self.peaks_at(between).collect(),
            clump: Clump::NONE,
        }
    }

    /// Light that a lobe gathers; for a cosine lobe, irradiance, W/m^2.
    pub(super) fn gathered_by(&self, world: DVec3, lobe: &Lobe) -> Rgb {
        let between = self.heights.between(world);
        let peaks = self.peaks_at(between).map(Peak::beam);
        if lobe.is_cosine_of(self.heights.up) {
            // Plain ground: truncated harmonics would err by a hundredth.
            let [above, below] = [between.above, between.below].map(|level| self.levels[level].downward);
            return with_peaks(above.lerp(below, between.share_below), peaks, lobe);
        }
        let mut sum = product(&lobe.of_travel(), &between.mean(|level| self.levels[level].moments));
        if let Some(factors) = lobe.of_third_of_travel() {
            sum += product(&factors, &between.mean(|level| self.levels[level].third));
        }
        if let Some(factors) = lobe.of_fourth_of_travel() {
            sum += product(&factors, &between.mean(|level| self.levels[level].fourth));
        }
        with_peaks(sum, peaks, lobe)
    }

    /// Forward peaks of suns at a place in world space.
    pub(super) fn peaks(&self, world: DVec3) -> impl Iterator<Item = Peak> {
        self.peaks_at(self.heights.between(world))
    }

    fn peaks_at(&self, Between { above, below, share_below }: Between) -> impl Iterator<Item = Peak> {
        self.peaks.iter().map(move |by_level| by_level[above].lerp(&by_level[below], share_below))
    }

    /// Radiance that fog scatters into a direction of travel: see [`super::Field::scattered`].
    pub(super) fn scattered(&self, world: DVec3, towards: &Towards, scattering: &[Rgb; SEEN_DEGREES]) -> Rgb {
        let Some(towards) = &towards.in_layers else { return Rgb::ZERO };
        let between = self.heights.between(world);
        let [above, below] = [between.above, between.below]
            .map(|level| self.levels[level].in_fog.scattered(towards, scattering));
        above.lerp(below, between.share_below).max(Rgb::ZERO)
    }

    /// Harmonics of a direction in world space.
    pub(super) fn harmonics_towards(&self, travel: DVec3) -> Harmonics {
        harmonic_basis(self.heights.layers_from_world * travel)
    }

    /// Radiance for fog at a place in world space.
    pub(super) fn fog_light(&self, world: DVec3) -> FogLight {
        let between = self.heights.between(world);
        let mut light = self.levels[between.above].in_fog.scaled(1.0 - between.share_below);
        light.add(&self.levels[between.below].in_fog, between.share_below);
        light
    }

    /// Whether fog thins out upwards.
    pub(super) fn are_level(&self) -> bool {
        self.heights.up.dot(DVec3::Y) > 1.0 - 1e-9
    }

    /// Whether nothing but level ground lies below them.
    pub(super) fn end_below(&self) -> bool {
        self.are_level() && self.heights.ground_m().is_some()
    }

    /// Height of a place in world space above the ground, if there is any, metres.
    pub(super) fn above_ground_m(&self, world: DVec3) -> f64 {
        self.heights.ground_m().map_or(0.0, |ground_m| (self.heights.height_m(world) - ground_m).max(0.0))
    }

    /// A box in world space, extended down to the ground if there is any.
    pub(super) fn down_to_ground(&self, (low, high): (DVec3, DVec3)) -> (DVec3, DVec3) {
        let Some(ground_m) = self.heights.ground_m() else { return (low, high) };
        let lowest = corners((low, high))
            .map(|place| place - (self.heights.height_m(place) - ground_m).max(0.0) * self.heights.up);
        bounds(lowest.into_iter().chain([low, high]))
    }
}

impl LevelLight {
    /// Light of a level. Two flags say whether surfaces and fog get light straight from the sky.
    fn of(
        light: &PlaneParallel,
        level: usize,
        (on_surfaces, in_fog): (bool, bool),
        world_from_layers: DQuat,
    ) -> Self {
        let mut sums = [[[0.0; COUNT]; 3]; 3];
        let mut downward = Rgb::ZERO;
        let of_sky = light.radiances(level, Part::OfSky);
        for ((travel, weight, scattered), (.., of_sky)) in light.radiances(level, Part::Scattered).zip(of_sky)
        {
            let world = world_from_layers * travel;
            let radiance = weight * if on_surfaces { scattered + of_sky } else { scattered };
            downward += (-travel.y).max(0.0) * radiance;
            for (sums, basis) in sums.iter_mut().zip([basis(world), third_basis(world), fourth_basis(world)])
            {
                for (channel, sums) in sums.iter_mut().enumerate() {
                    sums.iter_mut().zip(basis).for_each(|(sum, basis)| *sum += radiance[channel] * basis);
                }
            }
        }
        let [moments, third, fourth] = sums.map(|degree| degree.map(|sums| sums.map(|sum| sum as f32)));
        Self { downward, moments, third, fourth, in_fog: FogLight(light.harmonics(level, in_fog)) }
    }
}
