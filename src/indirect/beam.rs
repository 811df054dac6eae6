//! A sun's light as fog scatters it first, beyond what nine harmonics tell. In goes its irradiance by node,
//! out come sources along ordinates. Invariant: they are of degrees that no harmonic of the field has, so
//! nothing counts twice.
//!
//! From order to order harmonics up to l = 2 are enough, with delta-M. Of a sun's light most is scattered by
//! small angles, and how far it goes through fog depends on where it goes then. So its first scattering is
//! told up to l = 5, which 50 ordinates can tell apart.

use super::harmonics::COUNT;
use super::matter::Matter;
use crate::fog::{BEAM_DEGREES, legendre};
use glam::DVec3;
use std::f64::consts::PI;

/// The first degree that no harmonic has, and how many there are.
const FIRST: usize = 3;
const BEYOND: usize = BEAM_DEGREES as usize - FIRST;

/// Sources of fog by degree of the cosine to where a sun's light travels.
pub(super) struct Beam {
    travel: DVec3,
    /// By channel, degree and node, per metre.
    sources: [[Vec<f32>; BEYOND]; 3],
}

impl Beam {
    /// Of a sun's irradiance by channel and node, W/m^2.
    pub(super) fn new(travel: DVec3, irradiance: &[Vec<f32>; 3], matter: &Matter) -> Self {
        let of_degree = |channel: usize, degree: usize| {
            let shares = matter.first_scattering(channel, degree);
            irradiance[channel].iter().zip(shares).map(|(irradiance, share)| irradiance * share).collect()
        };
        let sources =
            std::array::from_fn(|channel| std::array::from_fn(|place| of_degree(channel, FIRST + place)));
        Self { travel, sources }
    }

    /// Nodes in another order.
    pub(super) fn map(&self, of_nodes: impl Fn(&[f32]) -> Vec<f32>) -> Self {
        let sources =
            self.sources.each_ref().map(|channel| channel.each_ref().map(|degree| of_nodes(degree)));
        Self { travel: self.travel, sources }
    }

    /// Of one channel, degree by degree.
    pub(super) fn channel(&self, channel: usize) -> [&[f32]; BEYOND] {
        self.sources[channel].each_ref().map(Vec::as_slice)
    }

    /// What each degree counts along a direction of travel, 1/sr.
    pub(super) fn factors(&self, direction: DVec3) -> [f32; BEYOND] {
        let polynomials = legendre::<{ BEAM_DEGREES as usize }>(self.travel.dot(direction));
        std::array::from_fn(|place| {
            let degree = FIRST + place;
            ((2 * degree + 1) as f64 / (4.0 * PI) * polynomials[degree]) as f32
        })
    }
}

const _: () = assert!(FIRST * FIRST == COUNT, "harmonics go up to l = 2");
