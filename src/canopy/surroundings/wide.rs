//! Bounds of parts, and parts that may be ground. In go parts, out come boxes and level corners. Invariant:
//! plain ground below layers of fog has no box, so it gets no cells.

use super::{AT_ONCE, POINTS, PlacedPart, Surroundings};
use crate::canopy::core_bounds::{Weighed, union};
use crate::math::{corners, large_list};
use crate::ordinates::surface_optics::{MeanOptics, SurfaceOptics};
use glam::DVec3;
use rayon::prelude::*;

/// A part that may be ground.
pub(crate) struct WidePart {
    pub(crate) number: usize,
    /// Corners in world space.
    pub(crate) corners: Vec<DVec3>,
    pub(crate) width_m: f64,
    /// Area of the largest side of its bounds.
    pub(crate) area_m2: f64,
}

impl Surroundings<'_> {
    /// Parts of walls with at least a width that face up or down; closed bodies only where they face up.
    pub(crate) fn wide_parts(&self, width_m: f64, up: DVec3) -> Vec<WidePart> {
        let parts = self.parts.iter().enumerate();
        let wide = parts.filter(|(_, part)| part.width_m >= width_m && !part.is_blended);
        let tell = |(number, part): (usize, &PlacedPart)| {
            let corners = self.level_corners(part, up);
            let area_m2 = part.width_m * part.length_m;
            (!corners.is_empty()).then_some(WidePart { number, corners, width_m: part.width_m, area_m2 })
        };
        wide.filter_map(tell).collect()
    }

    /// Corners of a part's triangles that are no steeper than an embankment.
    fn level_corners(&self, placed: &PlacedPart, up: DVec3) -> Vec<DVec3> {
        /// Minimum component of the normal along `up`.
        const STEEPEST: f64 = 0.3;
        let (mesh, part) = (self.mesh(placed), placed.part);
        let primitives = part.triangles.iter().filter_map(|&triangle| mesh.primitive(triangle));
        let corners = primitives.map(|primitive| self.world_corners(primitive));
        let is_level = |[a, b, c]: &[DVec3; 3]| {
            let along = (*b - *a).cross(*c - *a).normalize_or_zero().dot(up);
            along > STEEPEST || !part.is_closed && along < -STEEPEST
        };
        corners.filter(is_level).flatten().collect()
    }

    /// Mean optics of parts, by their areas.
    pub(crate) fn mean_of(&self, numbers: &[usize]) -> SurfaceOptics {
        let mut mean = MeanOptics::default();
        for part in numbers.iter().map(|&number| &self.parts[number]) {
            mean.add(part.width_m * part.length_m, &self.mean_optics(part, POINTS));
        }
        mean.mean()
    }

    /// Marks parts as plain ground below layers of fog.
    pub(crate) fn mark_plain(&mut self, numbers: &[usize]) {
        numbers.iter().for_each(|&number| self.parts[number].is_plain = true);
    }

    /// Boxes of all parts that are narrower and not plain ground, in world space.
    pub(crate) fn boxes(&self, widest_m: f64) -> Vec<Weighed> {
        let is_narrow = |part: &&PlacedPart| !part.is_large(widest_m) && !part.is_plain;
        let weighed = |part: &PlacedPart| {
            let corners = self.corners(part).into_iter().map(|corner| (corner, corner));
            let bounds = corners.reduce(union)?;
            Some(Weighed { bounds, area_m2: part.width_m * part.length_m })
        };
        let mut boxes = large_list(self.parts.len());
        for parts in self.parts.chunks(AT_ONCE) {
            boxes.extend(parts.par_iter().filter(is_narrow).filter_map(weighed).collect::<Vec<_>>());
        }
        boxes
    }

    /// Corners of a part's bounds.
    fn corners(&self, placed: &PlacedPart) -> Vec<DVec3> {
        let (mesh, part) = (self.mesh(placed), placed.part);
        if mesh.is_bent {
            let primitives = part.triangles.iter().filter_map(|&triangle| mesh.primitive(triangle));
            return primitives.flat_map(|primitive| self.world_corners(primitive)).collect();
        }
        let relative = |corner: DVec3| mesh.relative_from_mesh.transform_point3(corner);
        let world = |corner: DVec3| self.snapshot.world_from_relative(relative(corner));
        corners((part.low, part.high)).map(world).to_vec()
    }
}
