//! Light of lamps and suns on walls. In go patches of walls, out come the irradiance on each and its
//! highlights. Invariant: origins of shadow rays depend on the wall and the grid alone.

use super::highlights::{self, Arriving};
use super::walls::SnapshotWalls;
use crate::accel::PrimitiveId;
use crate::canopy::delta_scaled_fog::DeltaScaledFog;
use crate::color::Rgb;
use crate::fog::exp_minus;
use crate::math::{Ray, kronecker};
use crate::ordinates::first_collision_source::GlossySource;
use crate::ordinates::grid::Grid;
use crate::ordinates::quadrature::Quadrature;
use crate::ordinates::walls::Patch;
use crate::snapshot::{FrozenLight, Luminaire, Snapshot};
use glam::DVec3;
use rayon::prelude::*;

/// Number of shadow rays to a patch of a wall, along each side.
const SHADOW_RAYS: usize = 4;

pub(super) struct WallLight<'a> {
    pub(super) snapshot: &'a Snapshot<'a>,
    pub(super) lights: &'a [Luminaire],
    /// Emissive surfaces that light walls as lamps do; their points nearer than `nearest_m` do not count,
    /// metres.
    pub(super) emissive: &'a [Luminaire],
    pub(super) nearest_m: f64,
    pub(super) grid: &'a Grid,
    pub(super) fog: &'a DeltaScaledFog<'a>,
    pub(super) walls: &'a SnapshotWalls,
    pub(super) quadrature: &'a Quadrature,
}

/// Irradiance on walls, and their highlights.
pub(super) struct LitWalls {
    /// Irradiance on each patch, W/m^2.
    pub(super) irradiances: Vec<Rgb>,
    pub(super) glossy: GlossySource,
}

/// A part of a wall that is lit uniformly.
struct Square {
    /// Centre in relative space.
    middle: DVec3,
    /// Vectors from its centre to the middles of two sides.
    half: [DVec3; 2],
}

impl Square {
    /// Unit vector to a light, and the mean irradiance on the side of a normal, W/m^2. For a lamp it is the
    /// intensity times the solid angle over the area, at any distance.
    fn lit(&self, light: &FrozenLight, normal: DVec3) -> (DVec3, Rgb) {
        let (to_light, distance, arriving) = light.arriving_at(self.middle);
        let irradiance = match light {
            FrozenLight::Sun { .. } => to_light.dot(normal).max(0.0) * arriving,
            FrozenLight::Point { position, .. } if to_light.dot(normal) > 0.0 => {
                let area = 4.0 * self.half[0].length() * self.half[1].length();
                arriving * distance * distance * self.solid_angle(*position) / area
            }
            FrozenLight::Point { .. } => Rgb::ZERO,
        };
        (to_light, irradiance)
    }

    /// Solid angle of the square as seen from a point, sr.
    fn solid_angle(&self, from: DVec3) -> f64 {
        let [right, up] = self.half;
        let [a, b, c, d] = [-right - up, right - up, right + up, up - right]
            .map(|corner| (self.middle + corner - from).normalize_or_zero());
        of_triangle(a, b, c) + of_triangle(a, c, d)
    }
}

/// Solid angle of a triangle, given unit vectors to its corners, sr (Van Oosterom & Strackee 1983, "The solid
/// angle of a plane triangle", equation 8).
fn of_triangle(a: DVec3, b: DVec3, c: DVec3) -> f64 {
    2.0 * a.dot(b.cross(c)).abs().atan2(1.0 + a.dot(b) + b.dot(c) + c.dot(a))
}

impl WallLight<'_> {
    /// Computes the light of all lamps, suns and emissive surfaces.
    pub(super) fn found(&self) -> LitWalls {
        let lit = |(patch, &primitive): (&Patch, &PrimitiveId)| {
            let lamps = self.lights.iter().map(|light| (light, 0.0));
            let emissive = self.emissive.iter().map(|light| (light, self.nearest_m));
            let arriving = |light| self.arriving(light, (patch, primitive));
            let lights: Vec<Arriving> = lamps.chain(emissive).filter_map(arriving).collect();
            let highlights =
                highlights::of_patch(self.snapshot, (patch, primitive), &lights, self.quadrature);
            (lights.iter().map(|light| light.irradiance).sum::<Rgb>(), highlights)
        };
        let patches = self.walls.walls.patches.par_iter().zip(&self.walls.primitives);
        let (irradiances, along): (Vec<Rgb>, Vec<_>) = patches.map(lit).unzip();
        LitWalls { irradiances, glossy: GlossySource::new(&along) }
    }

    /// Light of one luminaire on a patch; its points within `nearest_m` do not count.
    fn arriving(
        &self,
        (light, nearest_m): (&Luminaire, f64),
        (patch, primitive): (&Patch, PrimitiveId),
    ) -> Option<Arriving> {
        let (right, up) = patch.normal.any_orthonormal_pair();
        // Around the centre of the patch's cell, on its plane: the place depends on no leaf.
        let node = self.grid.nearest(patch.position + 0.25 * self.grid.cell_m * patch.normal);
        let middle = self.grid.position(node);
        // For an emissive surface each patch has sampled points of its own, as few points give no common
        // mean.
        let first = if nearest_m > 0.0 { node * SHADOW_RAYS * SHADOW_RAYS } else { 0 };
        let middle = middle - (middle - patch.position).dot(patch.normal) * patch.normal;
        let step = self.grid.cell_m / SHADOW_RAYS as f64;
        let off_wall = 0.02 * self.grid.cell_m * patch.normal - self.snapshot.view.eye;
        let (mut sum, mut way_to_light, mut count) = (Rgb::ZERO, DVec3::ZERO, 0.0);
        for number in 0..SHADOW_RAYS * SHADOW_RAYS {
            let offset = |index: usize| (index as f64 + 0.5 - 0.5 * SHADOW_RAYS as f64) * step;
            let place = middle + offset(number % SHADOW_RAYS) * right + offset(number / SHADOW_RAYS) * up;
            let square = Square {
                middle: place - self.snapshot.view.eye,
                half: [0.5 * step * right, 0.5 * step * up],
            };
            let (seen, origin) = (patch.position + off_wall, place + off_wall);
            let way = Ray { origin: seen, direction: (origin - seen).normalize_or_zero() };
            // Beyond a corner the wall continues in another plane.
            if self.snapshot.tree.any_hit(&way, (origin - seen).length(), Some(primitive)) {
                continue;
            }
            count += 1.0;
            let point = light.point([0.3, 0.6, 0.9].map(|phase| kronecker(phase, first + number)));
            let (to_light, unshadowed) = square.lit(&point, patch.normal);
            if unshadowed != Rgb::ZERO {
                let (direction, distance, _) = point.arriving_at(origin);
                if distance < nearest_m {
                    continue;
                }
                let ray = Ray { origin, direction };
                let irradiance = unshadowed * self.reaching(&point, &ray, distance, primitive);
                sum += irradiance;
                way_to_light += irradiance.element_sum() * to_light;
            }
        }
        let to_light = way_to_light.try_normalize()?;
        Some(Arriving { to_light, irradiance: sum / f64::max(count, 1.0) })
    }

    /// Share of a light that arrives along a ray from a distance.
    fn reaching(&self, light: &FrozenLight, ray: &Ray, distance: f64, from: PrimitiveId) -> Rgb {
        let visible = self.snapshot.visibility(ray, distance, Some(from));
        if visible == Rgb::ZERO {
            return Rgb::ZERO;
        }
        let dimming = self.fog.dimming_of(matches!(light, FrozenLight::Sun { .. }));
        visible * exp_minus(dimming.rough_optical_depth(ray, distance))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::light::{Emission, LampShape};
    use std::f64::consts::PI;

    /// A lamp sends half of its light to a wide wall, however near it is; a far wall has that of a point
    /// light.
    #[test]
    fn a_lamp_lights_a_square_by_its_solid_angle() {
        let lit = |half_m: f64, height_m: f64| {
            let square = Square { middle: DVec3::ZERO, half: [half_m * DVec3::X, half_m * DVec3::Y] };
            let (position, intensity) = (height_m * DVec3::Z, Rgb::splat(3.0));
            let (emission, shape) = (Emission::Even, LampShape::NONE);
            square.lit(&FrozenLight::Point { position, intensity, emission, shape }, DVec3::Z).1.x
        };
        for height_m in [1e-9, 1e-3, 1e-2] {
            let power = 4.0 * 1e4 * lit(100.0, height_m);
            assert!((power / (3.0 * 2.0 * PI) - 1.0).abs() < 1e-3, "{height_m}: {power}");
        }
        assert!((lit(1e-3, 2.0) / (3.0 / 4.0) - 1.0).abs() < 1e-6);
        // A face of a cube around the lamp has a sixth of its light.
        assert!((4.0 * lit(1.0, 1.0) / (3.0 * 4.0 * PI / 6.0) - 1.0).abs() < 1e-12);
        assert_eq!(lit(1.0, -1.0), 0.0, "from behind");
    }
}
