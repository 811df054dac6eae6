//! Rays that carry the power of lamps and suns. In go lights, out come rays. Invariant: rays are fixed to the
//! world and the lights, never to leaves, so a leaf's light changes smoothly as it moves.

use super::delta_scaled_fog::DeltaScaledFog;
use crate::color::Rgb;
use crate::light::{Emission, LampShape};
use crate::math::{Ray, bounds, corners, kronecker, large_list};
use crate::ordinates::grid::Grid;
use crate::snapshot::{FrozenLight, Luminaire, Snapshot};
use glam::DVec3;
use std::f64::consts::TAU;

/// Number of a sun's neighbouring rays that light fog as one ray, as far as none of them has ended.
pub(crate) const BUNDLE: usize = 4;
/// Number of a sun's rays through a cell, along each side.
const RAYS_PER_CELL: f64 = 8.0;
/// Maximum number of rays of a sun.
const MOST_RAYS: f64 = 100_000.0;
const LAMP_RAYS: usize = 40_000;

pub(crate) struct PowerRay {
    pub(crate) ray: Ray,
    /// Power before any fog, W.
    pub(crate) power: Rgb,
    /// Optical depths before its origin: delta-scaled, and of all fog.
    pub(crate) depths: [Rgb; 2],
    /// Whether it is a sun's, whose forward peak is kept apart; a lamp's light has no single direction.
    pub(crate) is_of_sun: bool,
    /// Extent of the lamp, which gives the share of the power at a place.
    pub(crate) shape: LampShape,
}

impl PowerRay {
    /// Parallel rays as a single ray in their middle.
    pub(crate) fn together<'a>(rays: impl Iterator<Item = &'a Self> + Clone) -> Self {
        let count = rays.clone().count() as f64;
        let mean = |of: &dyn Fn(&Self) -> DVec3| rays.clone().map(of).sum::<DVec3>() / count;
        let ray = Ray { origin: mean(&|ray| ray.ray.origin), direction: mean(&|ray| ray.ray.direction) };
        let depths = [0, 1].map(|which| mean(&|ray| ray.depths[which]));
        let power = count * mean(&|ray| ray.power);
        Self { ray, power, depths, is_of_sun: true, shape: LampShape::NONE }
    }
}

/// Rays of emitters on a grid.
pub(crate) struct Emitters<'a> {
    pub(crate) snapshot: &'a Snapshot<'a>,
    pub(crate) grid: &'a Grid,
    pub(crate) fog: &'a DeltaScaledFog<'a>,
}

impl Emitters<'_> {
    /// Rays of a sun, equally spaced at right angles to its direction, at places that depend on the direction
    /// alone. Each [`BUNDLE`] neighbouring rays are consecutive.
    pub(crate) fn of_sun(&self, light: &Luminaire, to_light: DVec3) -> Vec<PowerRay> {
        let (right, up) = to_light.any_orthonormal_pair();
        let place = |corner: DVec3| DVec3::new(corner.dot(right), corner.dot(up), corner.dot(to_light));
        let (least, most) = bounds(corners(self.grid.volume()).map(place));
        let span = most - least;
        let spacing = (self.grid.cell_m / RAYS_PER_CELL).max((span.x * span.y / MOST_RAYS).sqrt());
        let irradiance = mean_irradiance(light);
        let eye = self.snapshot.view.eye;
        let boxes = [self.snapshot.tree.bounds(), self.snapshot.blended.bounds()].into_iter().flatten();
        let farthest =
            boxes.map(|(low, high)| DVec3::select(to_light.cmpgt(DVec3::ZERO), high, low).dot(to_light));
        let start = farthest.fold(most.z - eye.dot(to_light), f64::max) + self.grid.cell_m;
        let bundle = BUNDLE as i64;
        let columns = (least.x / spacing).floor() as i64..=(most.x / spacing).ceil() as i64;
        let columns = bundle * columns.start().div_euclid(bundle)..bundle * (columns.end() / bundle + 1);
        let rows = (least.y / spacing).floor() as i64..(most.y / spacing).ceil() as i64 + 1;
        let mut rays = large_list(rows.clone().count() * columns.clone().count());
        for row in rows {
            for column in columns.clone() {
                let across = (column as f64 + 0.5) * spacing * right + (row as f64 + 0.5) * spacing * up;
                let across = across - across.dot(to_light) * to_light;
                let relative = across - (eye - eye.dot(to_light) * to_light);
                let origin = relative + start * to_light;
                let depths = [self.fog.dimming_of(true), &self.snapshot.medium].map(|medium| {
                    medium.rough_optical_depth(&Ray { origin, direction: to_light }, f64::INFINITY)
                });
                let ray = Ray { origin, direction: -to_light };
                let power = spacing * spacing * irradiance;
                rays.push(PowerRay { ray, power, depths, is_of_sun: true, shape: LampShape::NONE });
            }
        }
        rays
    }
}

/// Rays of a lamp, evenly distributed over the directions in which it emits.
pub(crate) fn of_lamp(light: &Luminaire) -> Vec<PowerRay> {
    let FrozenLight::Point { emission, .. } = light.centre() else { return Vec::new() };
    let (axis, least_cos) = match &emission {
        Emission::Even => (DVec3::Y, -1.0),
        Emission::Spot(cone) | Emission::Gridded(cone) => (cone.axis, cone.cos_outer),
        Emission::Flat { normal } => (*normal, 0.0),
    };
    let (right, up) = axis.any_orthonormal_pair();
    let solid_angle = TAU * (1.0 - least_cos) / LAMP_RAYS as f64;
    let ray = |number: usize| {
        let along = 1.0 - (1.0 - least_cos) * (number as f64 + 0.5) / LAMP_RAYS as f64;
        let (sin, cos) = (TAU * kronecker(0.0, number)).sin_cos();
        let across = (1.0 - along * along).max(0.0).sqrt();
        let direction = along * axis + across * (cos * right + sin * up);
        let point = light.point([0.37, 0.11, 0.73].map(|phase| kronecker(phase, number * 7)));
        let FrozenLight::Point { position, intensity, emission, shape } = point else {
            unreachable!("a lamp is one all over")
        };
        let power = solid_angle * intensity * emission.share(direction);
        let ray = Ray { origin: position, direction };
        PowerRay { ray, power, depths: [Rgb::ZERO; 2], is_of_sun: false, shape }
    };
    let mut rays = large_list(LAMP_RAYS);
    rays.extend((0..LAMP_RAYS).map(ray).filter(|ray| ray.power != Rgb::ZERO));
    rays
}

/// Irradiance of the whole disc of a sun, on a plane that faces it.
pub(crate) fn mean_irradiance(light: &Luminaire) -> Rgb {
    const POINTS: usize = 64;
    if light.is_delta() {
        let FrozenLight::Sun { irradiance, .. } = light.centre() else { return Rgb::ZERO };
        return irradiance;
    }
    let irradiance = |number: usize| match light.point([
        (number as f64 + 0.5) / POINTS as f64,
        kronecker(0.0, number),
        0.5,
    ]) {
        FrozenLight::Sun { irradiance, .. } => irradiance,
        FrozenLight::Point { .. } => Rgb::ZERO,
    };
    (0..POINTS).map(irradiance).sum::<Rgb>() / POINTS as f64
}
