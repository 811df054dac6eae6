//! First-collision source: light of suns and lamps that is scattered for the first time, and emission. In go
//! collisions, out come sources of the sweep. Invariant: the part beyond harmonics has degrees that no
//! harmonic of the solution has, so no light counts twice.
//!
//! Between orders of scattering harmonics up to l = 2 suffice, with delta-M. A beam is scattered mostly by
//! small angles, and its path through fog depends on them. So its first scattering is kept up to l = 5, the
//! highest degree that 50 ordinates resolve.

use super::harmonics::COUNT;
use super::moments::{Moments, NodeMoments};
use crate::color::Rgb;
use crate::math::legendre;
use glam::DVec3;
use std::f64::consts::PI;

/// Number of degrees, from 0, of the first scattering of a beam.
pub(crate) const FIRST_DEGREES: usize = 6;

/// Source of the first collisions, with which source iteration begins.
pub(crate) struct FirstCollisionSource {
    /// Volume source by harmonics, per metre and steradian.
    pub(crate) volume: Moments,
    /// Scattering of beams in degrees beyond the harmonics.
    pub(crate) beams: Vec<BeamSource>,
    /// Radiance that leaves each patch of wall, for a Lambertian wall.
    pub(crate) walls: Vec<Rgb>,
    pub(crate) glossy: GlossySource,
    /// Correction that is subtracted from the second order's source.
    pub(crate) not_again: Option<NodeMoments>,
    pub(crate) emission: Option<Emission>,
    pub(crate) bright: Option<BrightWalls>,
}

/// Walls so much brighter than others that ordinates would spread their light in beams. Irradiance that they
/// give other walls is known. The rest of the source lacks their light.
pub(crate) struct BrightWalls {
    /// Radiance of each patch of wall, 0 for those that are not bright.
    pub(crate) radiances: Vec<Rgb>,
    /// Irradiance on each patch by bright ones.
    pub(crate) irradiances: Vec<Rgb>,
}

/// Emission of the medium and of walls.
pub(crate) struct Emission {
    /// Volume source by harmonics, per metre and steradian.
    pub(crate) volume: Moments,
    /// Radiance of each patch of wall.
    pub(crate) walls: Vec<Rgb>,
    /// Whether [`FirstCollisionSource::walls`] includes this emission as scattered by walls.
    pub(crate) has_lit_walls: bool,
    /// Whether emission itself is part of the solution, or only its scattered light.
    pub(crate) is_part: bool,
    /// Correction that is subtracted from its scattered light. If there is one, emission is swept by itself,
    /// otherwise with all other light.
    pub(crate) not_again: Option<NodeMoments>,
}

/// First degree beyond the harmonics, and the number of such degrees.
const FIRST: usize = 3;
const BEYOND: usize = FIRST_DEGREES - FIRST;

/// Sources of fog by Legendre degree of the angle to the direction of a sun's light.
pub(crate) struct BeamSource {
    travel: DVec3,
    /// Sources by channel, degree and node, per metre.
    sources: [[Vec<f32>; BEYOND]; 3],
}

impl BeamSource {
    /// Source from a beam's irradiance by channel and node, W/m^2, and scattering coefficients by degree,
    /// 1/m.
    pub(crate) fn new(
        travel: DVec3,
        irradiance: &[Vec<f32>; 3],
        scattering: &[[Vec<f32>; FIRST_DEGREES]; 3],
    ) -> Self {
        let of_degree = |channel: usize, degree: usize| {
            let shares = &scattering[channel][degree];
            irradiance[channel].iter().zip(shares).map(|(irradiance, share)| irradiance * share).collect()
        };
        let sources =
            std::array::from_fn(|channel| std::array::from_fn(|place| of_degree(channel, FIRST + place)));
        Self { travel, sources }
    }

    /// The source with nodes in another order.
    pub(crate) fn map(&self, of_nodes: impl Fn(&[f32]) -> Vec<f32>) -> Self {
        let sources =
            self.sources.each_ref().map(|channel| channel.each_ref().map(|degree| of_nodes(degree)));
        Self { travel: self.travel, sources }
    }

    /// Sources of one channel, degree by degree.
    pub(crate) fn channel(&self, channel: usize) -> [&[f32]; BEYOND] {
        self.sources[channel].each_ref().map(Vec::as_slice)
    }

    /// Weight of each degree along a direction of travel, 1/sr.
    pub(crate) fn factors(&self, direction: DVec3) -> [f32; BEYOND] {
        let polynomials = legendre::<FIRST_DEGREES>(self.travel.dot(direction));
        std::array::from_fn(|place| {
            let degree = FIRST + place;
            ((2 * degree + 1) as f64 / (4.0 * PI) * polynomials[degree]) as f32
        })
    }
}

/// Source of glossy walls: radiance along ordinates in excess of a Lambertian wall's. The sum over all
/// ordinates is the reflection of the wall's coat.
#[derive(Default)]
pub(crate) struct GlossySource {
    patches: Vec<u32>,
    /// Radiances by channel, then by ordinate, then by patch, W m^-2 sr^-1.
    radiances: [Vec<f32>; 3],
}

impl GlossySource {
    /// Radiances of each patch along each ordinate; empty for patches without a coat.
    pub(crate) fn new(of_patches: &[Vec<Rgb>]) -> Self {
        let shining = || of_patches.iter().zip(0..).filter(|(along, _)| !along.is_empty());
        let ordinates = of_patches.iter().map(Vec::len).max().unwrap_or(0);
        let of_channel = |channel: usize| {
            let along = |ordinate: usize| shining().map(move |(along, _)| along[ordinate][channel] as f32);
            (0..ordinates).flat_map(along).collect()
        };
        Self { patches: shining().map(|(_, number)| number).collect(), radiances: [0, 1, 2].map(of_channel) }
    }

    /// Adds the radiances along one ordinate to those of Lambertian walls, for one channel.
    pub(crate) fn add_to(&self, of_walls: &mut [f32], channel: usize, ordinate: usize) {
        let start = ordinate * self.patches.len();
        for (&patch, radiance) in self.patches.iter().zip(&self.radiances[channel][start..]) {
            of_walls[patch as usize] += radiance;
        }
    }
}

const _: () = assert!(FIRST * FIRST == COUNT, "harmonics go up to l = 2");
