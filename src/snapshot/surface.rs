//! What lies at a hit: the accelerator's answer in, the surface's properties out. Invariant: both
//! normals have unit length and face the ray's origin.

use super::Snapshot;
use crate::accel::{Hit, PrimitiveId};
use crate::color::Rgb;
use crate::math::Ray;
use crate::scene::AlphaMode;
use glam::{DVec3, Vec2};

/// A point of a surface, ready for shading.
#[derive(Clone, Copy, Debug)]
pub struct SurfacePoint {
    /// Relative to the camera, metres.
    pub position: DVec3,
    /// Of the flat triangle.
    pub geometric_normal: DVec3,
    /// Interpolated where the mesh has normals.
    pub shading_normal: DVec3,
    /// Lambert reflectance.
    pub albedo: Rgb,
    /// Mirror reflectance.
    pub mirror: Rgb,
    /// Emitted radiance.
    pub emission: Rgb,
    /// How much of it there is, `0..=1`: reflected and emitted light are to be weighted with it.
    pub alpha: f64,
    /// What it lets through of what lies behind.
    pub see_through: Rgb,
    /// Which triangle: rays that leave it must not meet it again.
    pub primitive: PrimitiveId,
    /// The instance's number.
    pub leaf_id: u32,
}

impl Snapshot<'_> {
    /// Where a ray meets the plane of a triangle that it is known to meet; `None` if it runs within that plane.
    pub fn hit_on(&self, ray: &Ray, primitive: PrimitiveId) -> Option<Hit> {
        let placed = &self.placed[primitive.instance as usize];
        let mesh = &self.scene.meshes[self.scene.instances[placed.instance].mesh];
        let corners = mesh.triangles[primitive.triangle as usize].vertices;
        let [a, b, c] = corners.map(|corner| {
            let position = mesh.positions[corner as usize].as_dvec3();
            placed.relative_from_mesh.transform_point3(position) - ray.origin
        });
        // Moeller & Trumbore 1997, without asking whether the point lies inside.
        let (ab, ac) = (b - a, c - a);
        let p = ray.direction.cross(ac);
        let determinant = ab.dot(p);
        let q = ab.cross(a);
        let (t, v, w) = (ac.dot(q), -a.dot(p), ray.direction.dot(q));
        let hit = Hit { t: t / determinant, primitive, barycentrics: [v / determinant, w / determinant] };
        hit.t.is_finite().then_some(hit)
    }

    /// Whether alpha may differ from place to place on a triangle.
    pub fn is_textured(&self, primitive: PrimitiveId) -> bool {
        let instance = &self.scene.instances[self.placed[primitive.instance as usize].instance];
        let triangle = self.scene.meshes[instance.mesh].triangles[primitive.triangle as usize];
        let material = &self.scene.materials[instance.material.unwrap_or(triangle.material)];
        material.base_color_texture.is_some_and(|texture| self.scene.textures[texture].has_alpha())
    }

    /// Looks up everything about a hit of `ray`.
    pub fn surface(&self, ray: &Ray, hit: &Hit) -> SurfacePoint {
        let placed = &self.placed[hit.primitive.instance as usize];
        let instance = &self.scene.instances[placed.instance];
        let mesh = &self.scene.meshes[instance.mesh];
        let triangle = mesh.triangles[hit.primitive.triangle as usize];
        let material = &self.scene.materials[instance.material.unwrap_or(triangle.material)];
        let corners = triangle.vertices.map(|vertex| vertex as usize);
        let [v, w] = hit.barycentrics;
        let weights = [1.0 - v - w, v, w];

        let [a, b, c] = corners
            .map(|corner| placed.relative_from_mesh.transform_point3(mesh.positions[corner].as_dvec3()));
        let towards_viewer = |normal: DVec3| if normal.dot(ray.direction) > 0.0 { -normal } else { normal };
        let geometric_normal = towards_viewer((b - a).cross(c - a).try_normalize().unwrap_or(-ray.direction));
        let shading_normal =
            if mesh.normals.is_empty() {
                geometric_normal
            } else {
                let normal: DVec3 =
                    (0..3).map(|corner| weights[corner] * mesh.normals[corners[corner]].as_dvec3()).sum();
                let normal = (placed.relative_from_mesh_normal * normal).try_normalize();
                normal.map_or(geometric_normal, |normal| {
                    if normal.dot(geometric_normal) < 0.0 { -normal } else { normal }
                })
            };
        let texture = material.base_color_texture.filter(|_| !mesh.uvs.is_empty());
        let texture = texture.map(|texture| {
            let uv: Vec2 = (0..3).map(|corner| weights[corner] as f32 * mesh.uvs[corners[corner]]).sum();
            (&self.scene.textures[texture], uv)
        });
        let albedo =
            texture.map_or(material.base_color, |(texture, uv)| material.base_color * texture.color(uv));
        let (alpha, see_through) = match material.alpha_mode {
            AlphaMode::Opaque | AlphaMode::Mask { .. } => (1.0, Rgb::ZERO),
            AlphaMode::Blend => {
                let alpha =
                    material.opacity * texture.map_or(1.0, |(texture, uv)| texture.alpha(uv).clamp(0.0, 1.0));
                (alpha, Rgb::splat(1.0 - alpha) + alpha * material.filter_color)
            }
        };
        SurfacePoint {
            position: ray.at(hit.t),
            geometric_normal,
            shading_normal,
            albedo,
            mirror: material.mirror,
            emission: material.emission,
            alpha,
            see_through,
            primitive: hit.primitive,
            leaf_id: instance.leaf_id,
        }
    }
}
