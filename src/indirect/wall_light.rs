//! Light of lamps and suns on walls. In go patches of walls, out come the irradiance on each and what shines
//! of it. Invariant: where its shadow rays start depends on the wall and the grid alone.

use super::grid::Grid;
use super::highlights::{self, Arriving, Highlights};
use super::ordinates::Ordinates;
use super::swept_fog::SweptFog;
use super::walls::{Patch, Walls};
use crate::accel::PrimitiveId;
use crate::color::Rgb;
use crate::math::{Ray, kronecker};
use crate::snapshot::{FrozenLight, Luminaire, Snapshot};
use glam::DVec3;
use rayon::prelude::*;

/// Shadow rays to a patch of wall, along each side.
const SHADOW_RAYS: usize = 4;

pub(super) struct WallLight<'a> {
    pub(super) snapshot: &'a Snapshot<'a>,
    pub(super) grid: &'a Grid,
    pub(super) fog: &'a SweptFog<'a>,
    pub(super) walls: &'a Walls,
    pub(super) ordinates: &'a Ordinates,
}

/// What falls on walls, and what of it goes its own way.
pub(super) struct LitWalls {
    /// Of each patch, W/m^2.
    pub(super) irradiances: Vec<Rgb>,
    pub(super) highlights: Highlights,
}

impl WallLight<'_> {
    /// Of all lights.
    pub(super) fn found(&self) -> LitWalls {
        let lit = |patch: &Patch| {
            let lights = self.snapshot.lights.iter().filter_map(|light| self.arriving(light, patch));
            let lights: Vec<Arriving> = lights.collect();
            let highlights = highlights::of_patch(self.snapshot, patch, &lights, self.ordinates);
            (lights.iter().map(|light| light.irradiance).sum::<Rgb>(), highlights)
        };
        let (irradiances, along): (Vec<Rgb>, Vec<_>) = self.walls.patches.par_iter().map(lit).unzip();
        LitWalls { irradiances, highlights: Highlights::new(&along) }
    }

    fn arriving(&self, light: &Luminaire, patch: &Patch) -> Option<Arriving> {
        let (right, up) = patch.normal.any_orthonormal_pair();
        // About the middle of the patch's cell, on its plane: where it is depends on no leaf.
        let middle =
            self.grid.position(self.grid.nearest(patch.position + 0.25 * self.grid.cell_m * patch.normal));
        let middle = middle - (middle - patch.position).dot(patch.normal) * patch.normal;
        let step = self.grid.cell_m / SHADOW_RAYS as f64;
        let off_wall = 0.02 * self.grid.cell_m * patch.normal - self.snapshot.view.eye;
        let (mut sum, mut way_to_light, mut count) = (Rgb::ZERO, DVec3::ZERO, 0.0);
        for number in 0..SHADOW_RAYS * SHADOW_RAYS {
            let offset = |index: usize| (index as f64 + 0.5 - 0.5 * SHADOW_RAYS as f64) * step;
            let place = middle + offset(number % SHADOW_RAYS) * right + offset(number / SHADOW_RAYS) * up;
            let (seen, origin) = (patch.position + off_wall, place + off_wall);
            let way = Ray { origin: seen, direction: (origin - seen).normalize_or_zero() };
            // Beyond a corner the wall goes on in another plane.
            if self.snapshot.tree.any_hit(&way, (origin - seen).length(), Some(patch.primitive)) {
                continue;
            }
            count += 1.0;
            let point = light.point([0.3, 0.6, 0.9].map(|phase| kronecker(phase, number)));
            let (to_light, distance, arriving) = point.arriving_at(origin);
            let cos = to_light.dot(patch.normal);
            if cos > 0.0 && arriving != Rgb::ZERO {
                let ray = Ray { origin, direction: to_light };
                let irradiance = cos * arriving * self.reaching(&point, &ray, distance, patch.primitive);
                sum += irradiance;
                way_to_light += irradiance.element_sum() * to_light;
            }
        }
        let to_light = way_to_light.try_normalize()?;
        Some(Arriving { to_light, irradiance: sum / f64::max(count, 1.0) })
    }

    /// What is left of a light's that comes along a ray from a distance.
    fn reaching(&self, light: &FrozenLight, ray: &Ray, distance: f64, from: PrimitiveId) -> Rgb {
        let visible = self.snapshot.visibility(ray, distance, Some(from));
        if visible == Rgb::ZERO {
            return Rgb::ZERO;
        }
        let dimming = self.fog.dimming_of(matches!(light, FrozenLight::Sun { .. }));
        visible * dimming.transmittance(ray.origin, ray.direction, distance)
    }
}
