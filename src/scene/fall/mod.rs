//! Falling leaves. In goes a fall, resolved and in SI units; out come keys. Invariant: until it lands, leaf
//! `i` is a pure function of `i` and of the fall's values other than its count. It does not depend on frames,
//! other leaves or the machine. Its pose at rest also depends on the leaves that landed before it.
//!
//! docs/decisions/falling.md lists what is modelled, what is chosen for looks, and the comparisons.

mod at_rest;
mod emitter;
mod flight;
mod flown;
mod ground;
mod heap;
mod kept;
mod keys;
mod landing;
mod lanes;
mod leaf;
mod lean;
mod manner;
mod obstacles;
mod outline;
mod pile;
mod plate;
mod together;
mod wind;

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests;

use crate::description::ron::FallMotion;
use crate::math::Chance;
use crate::scene::{Baking, Track};
use flown::Flown;
use glam::{DQuat, DVec3};
use keys::Tolerance;
use leaf::{Leaf, Surroundings};
use rayon::prelude::*;
use std::f64::consts::TAU;
use std::sync::atomic::{AtomicU32, Ordering};

pub(super) use at_rest::at_rest;
pub(super) use emitter::{Emitter, Surface};
pub(super) use flight::LONGEST_FLIGHT_S;
pub(super) use ground::Ground;
pub(super) use manner::sum as sum_of_shares;
pub(super) use obstacles::Obstacles;
pub(super) use outline::Outline;
pub(super) use wind::{Eddies, Gusts, Wind};

/// Maximum distance of curves from a leaf's poses, relative to its length, and in radians.
const TOLERANCE: f64 = 0.01;
/// Gap below a leaf at rest, relative to its length, so that curves stay above the ground. Leaves get up to
/// twice this, so that stacked ones are not coplanar.
const CLEARANCE: f64 = 0.02;
/// Aerodynamic forces on a leaf, relative to those on the same area of an endless strip of its width, as air
/// also flows around its ends. A disc has drag 1.17 (Hoerner, Fluid-Dynamic Drag, 1965) in place of the
/// plate's 2.4, and an added mass of `8/3` radius^3 air (Lamb, Hydrodynamics, section 102) in place of `pi^2
/// / 2`: ratios of 0.49 and 0.54. With one ratio for all forces, a leaf falls like a strip whose mass is
/// divided by it.
const OF_A_STRIP: f64 = 0.5;
/// Leaves that one thread takes at a time: enough to keep lanes busy until the last ones.
const LEAVES_AT_A_TIME: u32 = 64;
/// Maximum twist of leaves in the plane of their blade, radians; leaves do not fall along their vein.
const MOST_TWIST: f64 = 0.7;

/// Block of falling leaves.
#[derive(Clone, Debug)]
pub(super) struct Fall {
    pub(super) count: u32,
    pub(super) seed: u32,
    /// Species, at least one.
    pub(super) species: Vec<Species>,
    /// Weights of modes; `None` if each leaf's own inertia decides.
    pub(super) motion: Option<FallMotion>,
    pub(super) emitter: Emitter,
    pub(super) wind: Wind,
    pub(super) ground: Ground,
    pub(super) obstacles: Obstacles,
    /// Times of the first and last release.
    pub(super) release_s: (f64, f64),
    /// Factor on all speeds except the wind's.
    pub(super) speed_gain: Track<f64>,
}

/// Leaves of one kind.
#[derive(Clone, Debug)]
pub(super) struct Species {
    /// Weight of this kind among the leaves.
    pub(super) share: f64,
    /// Outlines, at least one.
    pub(super) outlines: Vec<Outline>,
    /// Ranges, from the smallest to the largest.
    pub(super) length_m: (f64, f64),
    /// Range of widths, if not the mesh's.
    pub(super) width_m: Option<(f64, f64)>,
    pub(super) areal_mass_kg_per_m2: (f64, f64),
    pub(super) curl: (f64, f64),
}

/// A leaf with all its keys.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Fallen {
    pub(super) species: usize,
    /// Index of the species' outline.
    pub(super) outline: usize,
    /// Number in `[0, 1)` that selects its material.
    pub(super) material: f64,
    pub(super) scale: f64,
    pub(super) translation: Track<DVec3>,
    pub(super) rotation: Track<DQuat>,
    pub(super) release_s: f64,
    /// False if the wind kept it up until the time limit.
    pub(super) landed: bool,
}

/// Random draws of a leaf. New ones go to the end, so that old scenes do not change.
#[derive(Clone, Copy)]
enum Draw {
    Place,
    Release = 3,
    Species,
    Outline,
    Material,
    Length,
    Width,
    ArealMass,
    Curl,
    Heading,
    Slope,
    Twist,
    Clearance,
    /// The last entry, as a manner takes several draws.
    Manner,
}

impl Fall {
    /// Flights of all leaves, in order; calls `tell` with the number that are done.
    fn fly(&self, tell: &(dyn Fn(u32) + Sync)) -> Vec<Flown> {
        let done = AtomicU32::new(0);
        (0..self.count.div_ceil(LEAVES_AT_A_TIME))
            .into_par_iter()
            .flat_map_iter(|part| {
                let first = part * LEAVES_AT_A_TIME;
                let numbers = first..self.count.min(first + LEAVES_AT_A_TIME);
                let mut all = vec![Flown::default(); numbers.len()];
                let leaves = numbers.map(|number| self.leaf(number));
                together::fly(leaves, self.surroundings(), |place, flight| {
                    let (middle, tolerance) = self.keyed_as(first + place as u32);
                    all[place] = Flown::new(flight, middle, tolerance).unwrap_or_default();
                    tell(done.fetch_add(1, Ordering::Relaxed) + 1);
                });
                all
            })
            .collect()
    }

    /// Flights of all leaves, with progress.
    fn fly_and_tell(&self, baking: &Baking) -> Vec<Flown> {
        self.fly(&|done| (baking.tell)(done, self.count))
    }

    /// Point of a leaf's mesh that is its centre, scaled, and the tolerance of its keys.
    fn keyed_as(&self, number: u32) -> (DVec3, Tolerance) {
        let Look { shape, length_m, scale, .. } = self.look(number);
        (shape.middle * scale, Tolerance { place_m: TOLERANCE * length_m, turn_rad: TOLERANCE })
    }

    fn surroundings(&self) -> Surroundings<'_> {
        let Self { wind, ground, obstacles, speed_gain, .. } = self;
        Surroundings { wind, ground, obstacles, speed_gain }
    }

    /// Random properties of a leaf.
    fn look(&self, number: u32) -> Look<'_> {
        let chance = Chance::of(self.seed, number);
        let draw = |draw: Draw| chance.at(draw as u64);
        let species = self.choose_species(draw(Draw::Species));
        let kind = &self.species[species];
        let outline = (draw(Draw::Outline) * kind.outlines.len() as f64) as usize;
        let shape = &kind.outlines[outline];
        let length_m = within(kind.length_m, draw(Draw::Length));
        let release_s = within(self.release_s, draw(Draw::Release));
        let (material, scale) = (draw(Draw::Material), length_m / shape.size.z);
        Look { chance, species, kind, outline, shape, material, length_m, scale, release_s }
    }

    fn leaf(&self, number: u32) -> Leaf {
        let Look { chance, kind, shape, length_m, scale, release_s, .. } = self.look(number);
        let draw = |draw: Draw| chance.at(draw as u64);
        let width_m = kind.width_m.map_or(scale * shape.size.x, |width_m| within(width_m, draw(Draw::Width)));
        let areal_mass = within(kind.areal_mass_kg_per_m2, draw(Draw::ArealMass)) / OF_A_STRIP;
        let (inertia, manner_of, damping) = match &self.motion {
            Some(motion) => manner::choose(motion, chance, Draw::Manner as u64),
            None => manner::natural(plate::inertia(width_m, areal_mass), chance, Draw::Manner as u64),
        };
        let outline: Vec<DVec3> = shape.points.iter().map(|&point| point * scale).collect();
        Leaf {
            plate: plate::Plate { inertia, damping, curl: within(kind.curl, draw(Draw::Curl)) },
            scales: plate::Scales::new(width_m, areal_mass),
            speed_gain: self.speed_gain.hull().into_iter().fold(0.0, f64::max),
            manner: manner_of,
            middle: self.emitter.place(chance, Draw::Place as u64),
            release_s,
            heading: direction(draw(Draw::Heading)),
            slope: direction(draw(Draw::Slope)),
            twist: twist(MOST_TWIST * (2.0 * draw(Draw::Twist) - 1.0)),
            reach_m: outline.iter().map(|point| point.length()).fold(0.0, f64::max),
            outline,
            rests: shape.rests,
            clearance_m: CLEARANCE * length_m * (1.0 + draw(Draw::Clearance)),
        }
    }

    fn choose_species(&self, fraction: f64) -> usize {
        let total: f64 = self.species.iter().map(|species| species.share).sum();
        let mut left = fraction * total;
        let chosen = self.species.iter().position(|species| {
            left -= species.share;
            left < 0.0
        });
        chosen.unwrap_or(self.species.len() - 1)
    }
}

/// Random properties of a leaf, and the source of further draws.
struct Look<'a> {
    chance: Chance,
    species: usize,
    kind: &'a Species,
    outline: usize,
    shape: &'a Outline,
    material: f64,
    length_m: f64,
    scale: f64,
    release_s: f64,
}

/// Number at a fraction of a range.
fn within((low, high): (f64, f64), fraction: f64) -> f64 {
    low + (high - low) * fraction
}

/// Cosine and sine of `fraction` of a full turn.
fn direction(fraction: f64) -> [f64; 2] {
    let (sin, cos) = libm::sincos(TAU * fraction);
    [cos, sin]
}

fn twist(angle: f64) -> DQuat {
    let (sin, cos) = libm::sincos(0.5 * angle);
    DQuat::from_xyzw(0.0, sin, 0.0, cos)
}
