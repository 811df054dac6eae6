//! Beams of suns, learned from random walks. In go sunlit points that walks met, out come rays of suns and
//! their density. Invariant: a point with a positive density has rays that begin above it. If it is in the
//! sun, they end at it or pass through it.

use crate::math::{KdDensity, Ray};
use crate::snapshot::FrozenLight;
use glam::{DVec2, DVec3};

/// Maximum share of points in the sun, among those that walks met, for which beams are worth their rays.
/// With more, walks meet it soon by themselves: a beam costs more than it saves in a canopy of which 10 % are
/// in the sun, and less in a room of 5 %.
const MOST_SUNLIT: f64 = 0.07;
/// Minimum number of points in the sun from which a beam is learned.
const FEWEST: usize = 32;
/// Margin above the points, as a share of their extent along the beam.
const ABOVE: f64 = 0.01;

/// Point that a walk met, on a surface or in fog.
#[derive(Clone, Copy, Debug)]
pub(super) struct MetPoint {
    /// Index of the sun among the snapshot's lights.
    pub(super) light: usize,
    pub(super) position: DVec3,
    /// Luminance of the sun's light that it gave the walk.
    pub(super) luminance: f64,
}

/// Beams of all suns that are worth it.
#[derive(Clone, Debug, Default)]
pub(super) struct SunBeams(Vec<Beam>);

/// Part of a sun's light. Its plane is at right angles to the middle of the sun, above all of its points.
#[derive(Clone, Debug)]
pub(super) struct Beam {
    /// Index among the snapshot's lights.
    pub(super) light: usize,
    /// Probability of choosing it.
    chance: f64,
    /// Unit vectors in the plane, and towards the sun.
    axes: [DVec3; 3],
    /// Height of the plane along the last axis, and of the lowest point below it, metres.
    height: f64,
    low: f64,
    /// Density of rays in the plane, 1/m^2.
    density: KdDensity,
}

impl SunBeams {
    /// Beams to where walks met the sun; none where they meet it often. `to_sun` has the direction of a light
    /// that is a sun.
    pub(super) fn learned(met: &[MetPoint], to_sun: impl Fn(usize) -> Option<DVec3>) -> Self {
        let count = met.iter().map(|point| point.light + 1).max().unwrap_or(0);
        let beam = |light: usize| {
            let (mut points, mut all) = (Vec::new(), 0_usize);
            for point in met.iter().filter(|point| point.light == light) {
                all += 1;
                points.extend((point.luminance > 0.0).then_some(*point));
            }
            let is_worth = points.len() >= FEWEST && (points.len() as f64) < MOST_SUNLIT * all as f64;
            Beam::through(light, &points, to_sun(light).filter(|_| is_worth)?)
        };
        let mut beams: Vec<Beam> = (0..count).filter_map(beam).collect();
        let sum: f64 = beams.iter().map(|beam| beam.chance).sum();
        for beam in &mut beams {
            beam.chance /= sum;
        }
        Self(beams)
    }

    pub(super) fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Beam that a uniform number chooses, and the remainder of the number, uniform again.
    pub(super) fn choose(&self, mut u: f64) -> Option<(&Beam, f64)> {
        let chosen = self.0.iter().find(|beam| {
            u -= beam.chance;
            u < 0.0
        });
        let beam = chosen.or(self.0.last())?;
        Some((beam, (1.0 + u / beam.chance).clamp(0.0, 1.0 - f64::EPSILON)))
    }

    /// The beam of a light.
    pub(super) fn of(&self, light: usize) -> Option<&Beam> {
        self.0.iter().find(|beam| beam.light == light)
    }
}

impl Beam {
    fn through(light: usize, points: &[MetPoint], to_sun: DVec3) -> Option<Self> {
        let (right, up) = to_sun.any_orthonormal_pair();
        let axes = [right, up, to_sun];
        let placed = |point: &MetPoint| {
            let at = point.position;
            (DVec2::new(at.dot(right), at.dot(up)), point.luminance)
        };
        let along = points.iter().map(|point| point.position.dot(to_sun));
        let (low, high) =
            along.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), at| (low.min(at), high.max(at)));
        let density = KdDensity::of(points.iter().map(placed).collect())?;
        let chance = points.iter().map(|point| point.luminance).sum();
        Some(Self { light, chance, axes, height: high + ABOVE * (high - low), low, density })
    }

    /// Ray from a point of the sun that two uniform numbers sample.
    pub(super) fn ray(&self, to_light: DVec3, u: DVec2) -> Ray {
        let ([right, up, to_sun], at) = (self.axes, self.density.sample(u));
        Ray { origin: at.x * right + at.y * up + self.height * to_sun, direction: -to_light }
    }

    /// Probability density with which rays from a point of the sun meet an unoccluded point, 1/m^2.
    pub(super) fn per_m2(&self, light: &FrozenLight, position: DVec3, normal: DVec3) -> f64 {
        let FrozenLight::Sun { to_light, .. } = light else { return 0.0 };
        let Some((ray, _)) = self.ray_through(*to_light, position) else { return 0.0 };
        let [right, up, to_sun] = self.axes;
        let per_m2 = self.density.pdf(DVec2::new(ray.origin.dot(right), ray.origin.dot(up)));
        self.chance * per_m2 * to_light.dot(normal).abs() / to_light.dot(to_sun)
    }

    /// Ray from a point of the sun through a place, and the place's distance along it; `None` above the
    /// plane.
    pub(super) fn ray_through(&self, to_light: DVec3, place: DVec3) -> Option<(Ray, f64)> {
        let to_sun = self.axes[2];
        let t = (self.height - place.dot(to_sun)) / to_light.dot(to_sun);
        let is_below = t >= 0.0 && to_light.dot(to_sun) > 0.0;
        is_below.then(|| (Ray { origin: place + t * to_light, direction: -to_light }, t))
    }

    /// Length of the rays on which points are sampled, metres.
    pub(super) fn length(&self) -> f64 {
        (1.0 + ABOVE) * (self.height - self.low)
    }
}
