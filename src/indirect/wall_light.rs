//! Light of lamps and suns on walls. In go patches of walls, out come the irradiance on each and its
//! highlights. Invariant: origins of shadow rays depend on the wall and the grid alone.

use super::highlights::{self, Arriving};
use super::lit_square::Square;
use super::walls::SnapshotWalls;
use crate::accel::PrimitiveId;
use crate::canopy::delta_scaled_fog::DeltaScaledFog;
use crate::canopy::surface_optics::optics_at;
use crate::color::Rgb;
use crate::fog::exp_minus;
use crate::light::{Emission, LightPlace};
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
/// Distance in cells up to which all points of an emissive surface light a patch; farther ones are sampled.
const NEAR: f64 = 2.0;
/// Width in cells of a gap between a wall and an emissive surface that nodes do not resolve.
const GAP: f64 = 0.5;
/// Maximum share of light that comes back in such a gap: between white surfaces it would have no end.
const MOST_BACK: Rgb = Rgb::splat(0.95);

#[derive(Clone, Copy)]
pub(super) struct WallLight<'a> {
    pub(super) snapshot: &'a Snapshot<'a>,
    pub(super) lights: &'a [Luminaire],
    /// Emissive surfaces that light walls as lamps do.
    pub(super) emissive: &'a [Luminaire],
    pub(super) grid: &'a Grid,
    pub(super) fog: &'a DeltaScaledFog<'a>,
    pub(super) walls: &'a SnapshotWalls,
    pub(super) quadrature: &'a Quadrature,
    /// Returns whether the light is no longer needed.
    pub(super) cancelled: &'a (dyn Fn() -> bool + Sync),
}

/// Irradiance on walls, and their highlights.
pub(super) struct LitWalls {
    /// Irradiance on each patch, W/m^2.
    pub(super) irradiances: Vec<Rgb>,
    pub(super) glossy: GlossySource,
}

impl WallLight<'_> {
    /// Computes the light of all lamps, suns and emissive surfaces.
    pub(super) fn found(&self) -> LitWalls {
        let lit = |(patch, &primitive): (&Patch, &PrimitiveId)| {
            let lights = self.lights.iter().chain(self.emissive);
            let arriving = |light| self.arriving(light, (patch, primitive), |_, _| ());
            let lights: Vec<Arriving> = lights.filter_map(arriving).collect();
            let highlights =
                highlights::of_patch(self.snapshot, (patch, primitive), &lights, self.quadrature);
            (lights.iter().map(|light| light.irradiance).sum::<Rgb>(), highlights)
        };
        let patches = self.walls.walls.patches.par_iter().zip(&self.walls.primitives);
        let (irradiances, along): (Vec<Rgb>, Vec<_>) = patches.map(lit).unzip();
        LitWalls { irradiances, glossy: GlossySource::new(&along) }
    }

    /// Light of one luminaire on a patch, none once `cancelled`. `tell` gets the irradiance on each of its
    /// squares.
    pub(super) fn arriving(
        &self,
        light: &Luminaire,
        (patch, primitive): (&Patch, PrimitiveId),
        mut tell: impl FnMut(&Square, Rgb),
    ) -> Option<Arriving> {
        if (self.cancelled)() {
            return None;
        }
        let (node, middle) = self.node_and_middle(patch);
        let (points, cell_m) = (light.points(), self.grid.cell_m);
        let is_within = |from: DVec3, point: &FrozenLight, cells: f64| matches!(point.place(), LightPlace::At(place) if place.distance(from) < cells * cell_m);
        let is_near = |point: &FrozenLight| is_within(middle, point, NEAR);
        let near: Vec<&FrozenLight> = points.iter().filter(|point| is_near(point)).collect();
        // Each patch samples points of its own, as few points give no common mean.
        let first = if points.is_empty() { 0 } else { node * SHADOW_RAYS * SHADOW_RAYS };
        let squares = self.squares(patch, primitive);
        let (mut sum, mut way_to_light) = (Rgb::ZERO, DVec3::ZERO);
        for (number, square) in &squares {
            let sampled = light.point([0.3, 0.6, 0.9].map(|phase| kronecker(phase, first + number)));
            let is_far = points.is_empty() || !is_near(&sampled);
            let shares = near.iter().map(|point| (*point, 1.0 / points.len() as f64));
            let (mut free, mut in_gap) = (Rgb::ZERO, Rgb::ZERO);
            for (point, share) in shares.chain(is_far.then_some((&sampled, 1.0))) {
                let (to_light, irradiance) = self.on_square(square, point, (patch, primitive));
                way_to_light += share * irradiance.element_sum() * to_light;
                let is_in_gap = !self.emissive.is_empty() && is_within(square.middle, point, GAP);
                *(if is_in_gap { &mut in_gap } else { &mut free }) += share * irradiance;
            }
            let leaving = if in_gap == Rgb::ZERO {
                1.0
            } else {
                let (leaving, back) = self.leaving_gap(square, (patch, primitive), first + number);
                in_gap /= Rgb::ONE - (patch.optics.reflectance * back).min(MOST_BACK);
                leaving
            };
            sum += free + leaving * in_gap;
            tell(square, free + in_gap);
        }
        let to_light = way_to_light.try_normalize()?;
        Some(Arriving { to_light, irradiance: sum / squares.len().max(1) as f64 })
    }

    /// Node next to a patch, and the place on the patch's plane, in relative space, nearest to it: that
    /// depends on no leaf.
    fn node_and_middle(&self, patch: &Patch) -> (usize, DVec3) {
        let node = self.grid.nearest(patch.position + 0.25 * self.grid.cell_m * patch.normal);
        let place = self.grid.position(node);
        let height = (place - patch.position).dot(patch.normal);
        (node, place - height * patch.normal - self.snapshot.view.eye)
    }

    /// Squares of a patch with their numbers. Beyond a corner the wall continues in another plane.
    fn squares(&self, patch: &Patch, primitive: PrimitiveId) -> Vec<(usize, Square)> {
        let (right, up) = patch.normal.any_orthonormal_pair();
        let (_, middle) = self.node_and_middle(patch);
        let step = self.grid.cell_m / SHADOW_RAYS as f64;
        let off_wall = self.off_wall(patch);
        let seen = patch.position - self.snapshot.view.eye + off_wall;
        let square = |number: usize| {
            let offset = |index: usize| (index as f64 + 0.5 - 0.5 * SHADOW_RAYS as f64) * step;
            let middle = middle + offset(number % SHADOW_RAYS) * right + offset(number / SHADOW_RAYS) * up;
            (number, Square { middle, half: [0.5 * step * right, 0.5 * step * up] })
        };
        let is_open = |(_, square): &(usize, Square)| {
            let way = square.middle + off_wall - seen;
            let ray = Ray { origin: seen, direction: way.normalize_or_zero() };
            !self.snapshot.tree.any_hit(&ray, way.length(), Some(primitive))
        };
        (0..SHADOW_RAYS * SHADOW_RAYS).map(square).filter(is_open).collect()
    }

    /// Offset of shadow rays from a patch.
    fn off_wall(&self, patch: &Patch) -> DVec3 {
        0.02 * self.grid.cell_m * patch.normal
    }

    /// Direction to a light without extent, and its irradiance on a square.
    fn on_square(
        &self,
        square: &Square,
        point: &FrozenLight,
        (patch, primitive): (&Patch, PrimitiveId),
    ) -> (DVec3, Rgb) {
        let (to_light, unshadowed) = square.lit(point, patch.normal);
        if unshadowed == Rgb::ZERO {
            return (to_light, Rgb::ZERO);
        }
        let origin = square.middle + self.off_wall(patch);
        let (direction, distance, _) = point.arriving_at(origin);
        (to_light, unshadowed * self.reaching(point, &Ray { origin, direction }, distance, primitive))
    }

    /// Share of a square's light that leaves the gap between it and an emissive surface, and the share that
    /// comes back from that surface. Sweeps see no surface in such a gap.
    fn leaving_gap(
        &self,
        square: &Square,
        (patch, primitive): (&Patch, PrimitiveId),
        number: usize,
    ) -> (f64, Rgb) {
        const RAYS: usize = 16;
        let (mut leaving, mut back) = (0.0, Rgb::ZERO);
        for ray in 0..RAYS {
            let u = [0.2, 0.7].map(|phase| kronecker(phase, RAYS * number + ray));
            let direction = Emission::Flat { normal: patch.normal }.sample(u);
            let ray = Ray { origin: square.middle + self.off_wall(patch), direction };
            let hit = self.snapshot.tree.nearest_hit(&ray, GAP * self.grid.cell_m, Some(primitive));
            match hit.filter(|hit| self.snapshot.emission(hit.primitive) != Rgb::ZERO) {
                None => leaving += 1.0 / RAYS as f64,
                Some(hit) => {
                    let place = self.snapshot.world_from_relative(ray.at(hit.t));
                    let optics = optics_at(self.snapshot, hit.primitive, place, -direction);
                    back += optics.reflectance / RAYS as f64;
                }
            }
        }
        (leaving, back)
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
