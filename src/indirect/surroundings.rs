//! What light meets on its way from order to order, in world space: small things as surfels, large ones as walls. In goes a snapshot, out come both and
//! the box that they fill. Invariant: each visible triangle is part of one of them.

use crate::accel::PrimitiveId;
use crate::color::Rgb;
use crate::math::Ray;
use crate::snapshot::{DrawnMesh, MeshPart, Snapshot, SurfacePoint};
use glam::DVec3;

/// A piece of a leaf.
#[derive(Clone, Copy, Debug)]
pub(super) struct Surfel {
    /// In world space.
    pub(super) position: DVec3,
    pub(super) normal: DVec3,
    /// m^2; of a closed body half of it, as half of it is turned away.
    pub(super) area: f64,
    pub(super) scatters: Scatters,
}

/// What becomes of light that meets a surface, and what it adds.
#[derive(Clone, Copy, Debug)]
pub(super) struct Scatters {
    /// Share that comes back.
    pub(super) reflectance: Rgb,
    /// Share that comes through.
    pub(super) transmittance: Rgb,
    /// Emitted radiance.
    pub(super) emission: Rgb,
    /// Share that does not pass as if there were nothing.
    pub(super) cover: f64,
}

/// A triangle of something that is larger than a cell.
#[derive(Clone, Copy, Debug)]
pub(super) struct WallTriangle {
    /// In world space.
    pub(super) corners: [DVec3; 3],
    pub(super) primitive: PrimitiveId,
}

/// A part of a mesh where it is placed.
struct PlacedPart<'a> {
    mesh: DrawnMesh<'a>,
    part: &'a MeshPart,
    /// Of its sides the second longest: how wide a leaf is, or a trunk, or a wall; metres.
    width_m: f64,
}

/// The parts that a snapshot shows.
pub(super) struct Surroundings<'a> {
    snapshot: &'a Snapshot<'a>,
    parts: Vec<PlacedPart<'a>>,
}

impl<'a> Surroundings<'a> {
    pub(super) fn of(snapshot: &'a Snapshot) -> Self {
        let meshes = (0..snapshot.mesh_count()).map(|number| snapshot.mesh(number));
        let placed = |mesh: DrawnMesh<'a>| {
            let axes = mesh.relative_from_mesh.matrix3;
            let scale = DVec3::new(axes.x_axis.length(), axes.y_axis.length(), axes.z_axis.length());
            mesh.parts().iter().map(move |part| {
                let mut sides = ((part.high - part.low) * scale).to_array();
                sides.sort_by(f64::total_cmp);
                PlacedPart { mesh, part, width_m: sides[1] }
            })
        };
        Self { snapshot, parts: meshes.flat_map(placed).collect() }
    }

    /// The box about all parts of at most that width, in world space; `None` if there is none.
    pub(super) fn bounds(&self, width_m: std::ops::Range<f64>) -> Option<(DVec3, DVec3)> {
        let parts = self.parts.iter().filter(|part| width_m.contains(&part.width_m));
        let corners = parts.flat_map(|part| self.corners(part));
        corners.map(|corner| (corner, corner)).reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)))
    }

    /// How wide leaves are, as the mean by their area over all parts narrower than `widest_m`; 0 if there are none.
    pub(super) fn leaf_width_m(&self, widest_m: f64) -> f64 {
        let leaves = self.parts.iter().filter(|part| part.width_m < widest_m);
        let (weighted, all) = leaves.fold((0.0, 0.0), |(weighted, all), leaf| {
            let area = (leaf.part.high - leaf.part.low).length_squared();
            (weighted + area * leaf.width_m, all + area)
        });
        if all > 0.0 { weighted / all } else { 0.0 }
    }

    /// Small things: parts narrower than `width_m`.
    pub(super) fn surfels(&self, width_m: f64) -> Vec<Surfel> {
        let leaves = self.parts.iter().filter(|part| part.width_m < width_m);
        leaves
            .flat_map(|leaf| {
                leaf.part.places.iter().filter_map(|place| self.surfel(leaf, place.triangle, place.share))
            })
            .collect()
    }

    /// All else.
    pub(super) fn walls(&self, width_m: f64) -> Vec<WallTriangle> {
        let walls = self.parts.iter().filter(|part| part.width_m >= width_m);
        let triangle = |wall: &PlacedPart<'a>, triangle: u32| {
            let primitive = wall.mesh.primitive(triangle)?;
            Some(WallTriangle { corners: self.world_corners(primitive), primitive })
        };
        walls
            .flat_map(|wall| wall.part.triangles.iter().filter_map(move |&number| triangle(wall, number)))
            .collect()
    }

    /// Places that a part lies between.
    fn corners(&self, PlacedPart { mesh, part, .. }: &PlacedPart) -> Vec<DVec3> {
        if mesh.is_bent {
            let primitives = part.triangles.iter().filter_map(|&triangle| mesh.primitive(triangle));
            return primitives.flat_map(|primitive| self.world_corners(primitive)).collect();
        }
        let corner = |number: usize| {
            let side = |axis: usize| if number >> axis & 1 == 0 { part.low[axis] } else { part.high[axis] };
            mesh.relative_from_mesh.transform_point3(DVec3::new(side(0), side(1), side(2)))
        };
        (0..8).map(|number| self.snapshot.world_from_relative(corner(number))).collect()
    }

    fn world_corners(&self, primitive: PrimitiveId) -> [DVec3; 3] {
        self.snapshot.corners(primitive).map(|corner| self.snapshot.world_from_relative(corner))
    }

    fn surfel(&self, leaf: &PlacedPart, triangle: u32, share: f64) -> Option<Surfel> {
        let primitive = leaf.mesh.primitive(triangle)?;
        let [a, b, c] = self.world_corners(primitive);
        let area_normal = 0.5 * (b - a).cross(c - a);
        let normal = area_normal.try_normalize()?;
        let position = (a + b + c) / 3.0;
        let scatters = scatters(self.snapshot, primitive, position, normal);
        let sides = if leaf.part.is_closed { 0.5 } else { 1.0 };
        let area = sides * share * area_normal.length() * scatters.cover;
        Some(Surfel { position, normal, area, scatters })
    }
}

/// What a surface does to light on the side that `normal` faces, at a place of world space.
pub(super) fn scatters(
    snapshot: &Snapshot,
    primitive: PrimitiveId,
    position: DVec3,
    normal: DVec3,
) -> Scatters {
    let towards = Ray { origin: position + normal - snapshot.view.eye, direction: -normal };
    scatters_of(&snapshot.facet(primitive).seen_along(&towards, 1.0))
}

/// The same of a point.
pub(super) fn scatters_of(point: &SurfacePoint) -> Scatters {
    Scatters {
        reflectance: reflectance(point),
        transmittance: point.transmission,
        emission: point.emission,
        cover: 1.0 - (1.0 - point.alpha).clamp(0.0, 1.0),
    }
}

/// All that comes back, whatever way: what shines counts as matte.
fn reflectance(point: &SurfacePoint) -> Rgb {
    /// About where most light falls and most is seen.
    const COS: f64 = 0.6;
    let coat = point.gloss.as_ref().map_or(Rgb::ZERO, |gloss| gloss.albedo(COS));
    (point.albedo * (Rgb::ONE - coat) + coat + point.mirror).clamp(Rgb::ZERO, Rgb::ONE)
}
