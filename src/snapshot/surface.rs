//! What lies at a hit: the accelerator's answer in, the surface's properties out. Invariant: both
//! normals have unit length and face the ray's origin.

use super::Snapshot;
use crate::accel::{Hit, PrimitiveId};
use crate::color::Rgb;
use crate::math::Ray;
use crate::scene::{AlphaMode, Material, Mesh, Texture, TextureIndex};
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
    /// Lambert transmittance.
    pub transmission: Rgb,
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

/// A placed triangle with all that its points share: worth keeping where many rays meet the same one.
#[derive(Clone, Copy, Debug)]
pub struct Facet<'scene> {
    /// Which triangle.
    pub primitive: PrimitiveId,
    mesh: &'scene Mesh,
    material: &'scene Material,
    texture: Option<&'scene Texture>,
    transmission_texture: Option<&'scene Texture>,
    leaf_id: u32,
    corners: [usize; 3],
    first_corner: DVec3,
    /// Unit length; zero if the triangle has no area.
    normal: DVec3,
    /// Gradients of the second and third barycentric coordinate.
    gradients: [DVec3; 2],
    /// Normals at the corners, where the mesh has any.
    corner_normals: Option<[DVec3; 3]>,
}

impl<'scene> Snapshot<'scene> {
    /// A triangle of the tree.
    pub fn facet(&self, primitive: PrimitiveId) -> Facet<'scene> {
        let placed = &self.placed[primitive.instance as usize];
        let instance = &self.scene.instances[placed.instance];
        let mesh = &self.scene.meshes[instance.mesh];
        let triangle = mesh.triangles[primitive.triangle as usize];
        let material = &self.scene.materials[instance.material.unwrap_or(triangle.material)];
        let corners = triangle.vertices.map(|vertex| vertex as usize);
        let [a, b, c] = corners
            .map(|corner| placed.relative_from_mesh.transform_point3(mesh.positions[corner].as_dvec3()));
        let (ab, ac) = (b - a, c - a);
        let area_normal = ab.cross(ac);
        let texture = |texture: Option<TextureIndex>| {
            texture.filter(|_| !mesh.uvs.is_empty()).map(|texture| &self.scene.textures[texture])
        };
        Facet {
            primitive,
            mesh,
            material,
            texture: texture(material.base_color_texture),
            transmission_texture: texture(material.transmission_texture),
            leaf_id: instance.leaf_id,
            corners,
            first_corner: a,
            normal: area_normal.normalize_or_zero(),
            gradients: [ac.cross(area_normal), area_normal.cross(ab)]
                .map(|gradient| gradient / area_normal.length_squared()),
            corner_normals: (!mesh.normals.is_empty()).then(|| {
                corners.map(|corner| placed.relative_from_mesh_normal * mesh.normals[corner].as_dvec3())
            }),
        }
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
        self.facet(hit.primitive).at(ray, hit.t, hit.barycentrics)
    }
}

impl<'scene> Facet<'scene> {
    /// How far along a ray its plane lies; not finite if the ray runs within that plane.
    pub fn distance_along(&self, ray: &Ray) -> f64 {
        (self.first_corner - ray.origin).dot(self.normal) / ray.direction.dot(self.normal)
    }

    /// What a ray that meets it at a distance sees there.
    pub fn seen_along(&self, ray: &Ray, distance: f64) -> SurfacePoint {
        let within = ray.at(distance) - self.first_corner;
        self.at(ray, distance, self.gradients.map(|gradient| gradient.dot(within)))
    }

    fn at(&self, ray: &Ray, distance: f64, [v, w]: [f64; 2]) -> SurfacePoint {
        let weights = [1.0 - v - w, v, w];
        let geometric_normal = match self.normal {
            DVec3::ZERO => -ray.direction,
            normal if normal.dot(ray.direction) > 0.0 => -normal,
            normal => normal,
        };
        let shading_normal = self.corner_normals.map_or(geometric_normal, |normals| {
            let normal: DVec3 = (0..3).map(|corner| weights[corner] * normals[corner]).sum();
            match normal.try_normalize() {
                Some(normal) if normal.dot(geometric_normal) < 0.0 => -normal,
                Some(normal) => normal,
                None => geometric_normal,
            }
        });
        let material = self.material;
        let with_uv = |texture: &'scene Texture| {
            let uv = |corner: usize| self.mesh.uvs[self.corners[corner]];
            let uv: Vec2 = (0..3).map(|corner| weights[corner] as f32 * uv(corner)).sum();
            (texture, uv)
        };
        let texture = self.texture.map(with_uv);
        let color = texture.map_or(Rgb::ONE, |(texture, uv)| texture.color(uv));
        let transmission_color = match self.transmission_texture {
            None => Rgb::ONE,
            _ if material.transmission_texture == material.base_color_texture => color,
            Some(other) => other.color(with_uv(other).1),
        };
        let (alpha, see_through) = match material.alpha_mode {
            AlphaMode::Opaque => (1.0, Rgb::ZERO),
            AlphaMode::Blend => {
                let alpha =
                    material.opacity * texture.map_or(1.0, |(texture, uv)| texture.alpha(uv).clamp(0.0, 1.0));
                (alpha, Rgb::splat(1.0 - alpha) + alpha * material.filter_color)
            }
        };
        SurfacePoint {
            position: ray.at(distance),
            geometric_normal,
            shading_normal,
            albedo: material.base_color * color,
            transmission: material.transmission * transmission_color,
            mirror: material.mirror,
            emission: material.emission,
            alpha,
            see_through,
            primitive: self.primitive,
            leaf_id: self.leaf_id,
        }
    }
}
