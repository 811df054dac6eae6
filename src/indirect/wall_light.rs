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
use crate::ordinates::occluders::OFF_WALL;
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
    /// Irradiance on each patch, W/m^2, whose reflected light leaves the gap before it.
    pub(super) irradiances: Vec<Rgb>,
    /// All irradiance on each patch, of which light that passes through leaves on the other side.
    pub(super) through: Vec<Rgb>,
    pub(super) glossy: GlossySource,
    /// Squares of each patch that are part of it, as bits.
    pub(super) squares: Vec<u16>,
}

/// A patch as a target of light.
pub(super) struct Target<'a> {
    pub(super) patch: &'a Patch,
    pub(super) primitive: PrimitiveId,
    /// Number of the node next to it.
    pub(super) node: usize,
    /// The place on its plane, in relative space, nearest to that node: it depends on no leaf.
    pub(super) middle: DVec3,
    /// Its squares with their numbers.
    pub(super) squares: Vec<(usize, Square)>,
}

/// Light of one luminaire on a patch.
pub(super) struct Lit {
    arriving: Arriving,
    /// Irradiance of which transmitted light leaves on the other side, W/m^2.
    through: Rgb,
}

impl WallLight<'_> {
    /// Computes the light of all lamps, suns and emissive surfaces.
    pub(super) fn found(&self) -> LitWalls {
        let is_lit = !(self.lights.is_empty() && self.emissive.is_empty());
        let lit = |number: usize| {
            let mut target = self.target(number);
            let facet = (target.patch, target.primitive);
            target.squares.retain(|(_, square)| is_lit && self.is_part(facet, square));
            let lights = self.lights.iter().chain(self.emissive);
            let lit = lights.filter_map(|light| self.lit(light, &target, |_| ()));
            let (lights, through): (Vec<Arriving>, Vec<Rgb>) =
                lit.map(|lit| (lit.arriving, lit.through)).unzip();
            let highlights = highlights::of_patch(self.snapshot, facet, &lights, self.quadrature);
            let irradiance = lights.iter().map(|light| light.irradiance).sum::<Rgb>();
            let squares = target.squares.iter().fold(0, |all, (square, _)| all | 1 << square);
            ((irradiance, through.into_iter().sum::<Rgb>()), (highlights, squares))
        };
        let patches = (0..self.walls.primitives.len()).into_par_iter();
        let (light, rest): (Vec<(Rgb, Rgb)>, Vec<_>) = patches.map(lit).unzip();
        let (irradiances, through) = light.into_iter().unzip();
        let (along, squares): (Vec<_>, _) = rest.into_iter().unzip();
        LitWalls { irradiances, through, glossy: GlossySource::new(&along), squares }
    }

    /// Light of one luminaire on a patch, none once `cancelled`. `tell` gets the irradiance on each of its
    /// squares in turn.
    pub(super) fn lit(&self, light: &Luminaire, target: &Target, mut tell: impl FnMut(Rgb)) -> Option<Lit> {
        if (self.cancelled)() {
            return None;
        }
        let &Target { patch, node, middle, ref squares, .. } = target;
        let (points, cell_m) = (light.points(), self.grid.cell_m);
        let is_within = |from: DVec3, point: &FrozenLight, cells: f64| matches!(point.place(), LightPlace::At(place) if place.distance(from) < cells * cell_m);
        let is_near = |point: &FrozenLight| is_within(middle, point, NEAR);
        let near: Vec<&FrozenLight> = points.iter().filter(|point| is_near(point)).collect();
        // Each patch samples points of its own, as few points give no common mean.
        let first = if points.is_empty() { 0 } else { node * SHADOW_RAYS * SHADOW_RAYS };
        let (mut sum, mut through, mut way_to_light) = (Rgb::ZERO, Rgb::ZERO, DVec3::ZERO);
        for (number, square) in squares {
            let sampled = light.point([0.3, 0.6, 0.9].map(|phase| kronecker(phase, first + number)));
            let is_far = points.is_empty() || !is_near(&sampled);
            let shares = near.iter().map(|point| (*point, 1.0 / points.len() as f64));
            let (mut free, mut in_gap) = (Rgb::ZERO, Rgb::ZERO);
            for (point, share) in shares.chain(is_far.then_some((&sampled, 1.0))) {
                let (to_light, irradiance) = self.on_square(square, point, target);
                way_to_light += share * irradiance.element_sum() * to_light;
                let is_in_gap = !self.emissive.is_empty() && is_within(square.middle, point, GAP);
                *(if is_in_gap { &mut in_gap } else { &mut free }) += share * irradiance;
            }
            let leaving = if in_gap == Rgb::ZERO {
                1.0
            } else {
                let (leaving, back) = self.leaving_gap(square, target, first + number);
                in_gap *= again(patch.optics.reflectance * back);
                leaving
            };
            sum += free + leaving * in_gap;
            through += free + in_gap;
            tell(free + in_gap);
        }
        let to_light = way_to_light.try_normalize()?;
        let count = squares.len().max(1) as f64;
        Some(Lit { arriving: Arriving { to_light, irradiance: sum / count }, through: through / count })
    }

    /// A patch with all squares around its middle.
    pub(super) fn target(&self, number: usize) -> Target<'_> {
        let (patch, primitive) = (&self.walls.walls.patches[number], self.walls.primitives[number]);
        let (node, middle) = self.node_and_middle(patch);
        let squares = self.squares(patch, middle).collect();
        Target { patch, primitive, node, middle, squares }
    }

    /// Node next to a patch, and the place on the patch's plane, in relative space, nearest to it.
    fn node_and_middle(&self, patch: &Patch) -> (usize, DVec3) {
        let node = self.grid.nearest(patch.position + 0.25 * self.grid.cell_m * patch.normal);
        let place = self.grid.position(node);
        let height = (place - patch.position).dot(patch.normal);
        (node, place - height * patch.normal - self.snapshot.view.eye)
    }

    /// Squares around the middle of a patch, with their numbers.
    fn squares(&self, patch: &Patch, middle: DVec3) -> impl Iterator<Item = (usize, Square)> {
        let (right, up) = patch.normal.any_orthonormal_pair();
        let step = self.grid.cell_m / SHADOW_RAYS as f64;
        (0..SHADOW_RAYS * SHADOW_RAYS).map(move |number| {
            let offset = |index: usize| (index as f64 + 0.5 - 0.5 * SHADOW_RAYS as f64) * step;
            let middle = middle + offset(number % SHADOW_RAYS) * right + offset(number / SHADOW_RAYS) * up;
            (number, Square { middle, half: [0.5 * step * right, 0.5 * step * up] })
        })
    }

    /// Whether a square is part of a patch. Beyond a corner the wall continues in another plane.
    pub(super) fn is_part(&self, (patch, primitive): (&Patch, PrimitiveId), square: &Square) -> bool {
        let off_wall = self.off_wall(patch);
        let seen = patch.position - self.snapshot.view.eye + off_wall;
        let way = square.middle + off_wall - seen;
        let ray = Ray { origin: seen, direction: way.normalize_or_zero() };
        !self.snapshot.tree.any_hit(&ray, way.length(), Some(primitive))
    }

    /// Offset of shadow rays from a patch. What no node sees lies close before another wall.
    fn off_wall(&self, patch: &Patch) -> DVec3 {
        let cells = if patch.seen_by.is_empty() { OFF_WALL } else { 0.02 };
        cells * self.grid.cell_m * patch.normal
    }

    /// Direction to a light without extent, and its irradiance on a square.
    pub(super) fn on_square(
        &self,
        square: &Square,
        point: &FrozenLight,
        &Target { patch, primitive, .. }: &Target,
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
        &Target { patch, primitive, .. }: &Target,
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

/// Light in a gap with all that comes back, relative to what first arrives, by the share that does.
fn again(back: Rgb) -> Rgb {
    (Rgb::ONE - back.min(MOST_BACK)).recip()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Light ends even between white surfaces that nothing leaves.
    #[test]
    fn light_in_a_gap_ends() {
        assert_eq!(again(Rgb::ZERO), Rgb::ONE);
        assert_eq!(again(Rgb::splat(0.5)), Rgb::splat(2.0));
        let most = again(Rgb::ONE).x;
        assert!(most > 10.0 && most < 100.0, "{most}");
    }
}
