//! Surface at a hit. In goes the accelerator's hit, out come the surface's properties. Invariant: both
//! normals have unit length and face the ray's origin.

mod layers;
mod texels;

use super::Snapshot;
use crate::accel::{Hit, PrimitiveId, prefetch};
use crate::color::Rgb;
use crate::math::Ray;
use crate::scattering::{Dielectric, Gloss, Layers, specular_normal};
use crate::scene::{Material, Mesh, Painted, Texture, TextureMap};
use glam::{DMat3, DVec3, Vec3, Vec4};
use texels::{FacetTexels, Specular};

/// A point of a surface, ready for shading.
#[derive(Clone, Copy, Debug)]
pub struct SurfacePoint {
    /// Position relative to the camera, metres.
    pub position: DVec3,
    /// Normal of the flat triangle.
    pub geometric_normal: DVec3,
    /// Normal for shading, interpolated where the mesh has normals.
    pub shading_normal: DVec3,
    /// Shading normal before the normal map, where its bumps cast shadows on themselves.
    pub unbent_normal: Option<DVec3>,
    /// Shading normal of specular reflection: where bumps shade themselves it mirrors no light from within.
    pub specular_normal: DVec3,
    /// Lambert reflectance.
    pub albedo: Rgb,
    /// Lambert transmittance.
    pub transmission: Rgb,
    /// Glossy coat, if it has one.
    pub gloss: Option<Gloss>,
    /// Rough dielectric, which is a share of the surface.
    pub dielectric: Option<Dielectric>,
    /// Sheen and clear coat over it.
    pub layers: Option<Layers>,
    /// Unit vector towards the observer.
    pub to_eye: DVec3,
    /// Mirror reflectance.
    pub mirror: Rgb,
    /// Emitted radiance.
    pub emission: Rgb,
    /// Coverage, `0..=1`: the weight of reflected and emitted light.
    pub alpha: f64,
    /// Transmittance for light from behind.
    pub see_through: Rgb,
    /// Triangle, which rays from this point must not hit again.
    pub primitive: PrimitiveId,
    /// The instance's number.
    pub leaf_id: u32,
}

/// A placed triangle with all data that its points share, for reuse by rays that hit it.
#[derive(Clone, Copy, Debug)]
pub struct Facet<'a> {
    /// Triangle.
    pub primitive: PrimitiveId,
    mesh: &'a Mesh,
    material: &'a Material,
    textures: &'a [Texture],
    texture: Option<&'a Texture>,
    /// Attributes with which a normal map bends its normals.
    bending: Option<Bending<'a>>,
    leaf_id: u32,
    /// Whether its normal points into its body, as its instance is mirrored.
    is_turned: bool,
    corners: [usize; 3],
    first_corner: DVec3,
    /// Unit normal; zero if the triangle has no area.
    normal: DVec3,
    /// Gradients of the second and third barycentric coordinate.
    gradients: [DVec3; 2],
    /// Normals at the corners, if the mesh has any.
    corner_normals: Option<[DVec3; 3]>,
}

/// Attributes of a mesh that a normal map needs.
#[derive(Clone, Copy, Debug)]
struct Bending<'a> {
    positions: &'a [Vec3],
    /// Normals of the mesh; empty for flat meshes.
    normals: &'a [Vec3],
    tangents: &'a [Vec4],
    relative_from_mesh_normal: DMat3,
}

/// Angle to a plane, in radians, below which a point seen from there lies within it.
const IN_PLANE: f64 = 1e-12;

impl Snapshot<'_> {
    /// A triangle of the tree.
    pub fn facet(&self, primitive: PrimitiveId) -> Facet<'_> {
        let placed = &self.placed[primitive.instance as usize];
        let instance = &self.scene.instances[placed.instance()];
        let mesh = &self.scene.meshes[placed.mesh()];
        let triangle = mesh.triangles[primitive.triangle as usize];
        let material = &self.materials[instance.material.unwrap_or(triangle.material)];
        let corners = triangle.vertices.map(|vertex| vertex as usize);
        let (positions, normals, tangents) = match &placed.bent {
            None => (&mesh.positions, &mesh.normals, &mesh.tangents),
            Some(bent) => (&bent.shape.positions, &bent.shape.normals, &bent.shape.tangents),
        };
        for corner in corners {
            // Its points will read them.
            mesh.uvs.get(corner).into_iter().for_each(prefetch);
            tangents.get(corner).into_iter().for_each(prefetch);
        }
        let relative_from_mesh = self.relative_from_mesh(primitive.instance as usize);
        let is_bent = material.has_normal_map() && !tangents.is_empty();
        // Normals are covectors.
        let relative_from_mesh_normal = if is_bent || !normals.is_empty() {
            relative_from_mesh.matrix3.inverse().transpose()
        } else {
            DMat3::ZERO
        };
        let [a, b, c] =
            corners.map(|corner| relative_from_mesh.transform_point3(positions[corner].as_dvec3()));
        let (ab, ac) = (b - a, c - a);
        let area_normal = ab.cross(ac);
        let texture = material.base_color_texture.filter(|_| !mesh.uvs.is_empty());
        Facet {
            primitive,
            mesh,
            material,
            textures: &self.scene.textures,
            texture: texture.map(|texture| &self.scene.textures[texture]),
            bending: is_bent.then_some(Bending { positions, normals, tangents, relative_from_mesh_normal }),
            leaf_id: instance.leaf_id,
            is_turned: material.has_front() && relative_from_mesh.matrix3.determinant() < 0.0,
            corners,
            first_corner: a,
            normal: area_normal.normalize_or_zero(),
            gradients: [ac.cross(area_normal), area_normal.cross(ab)]
                .map(|gradient| gradient / area_normal.length_squared()),
            corner_normals: (!normals.is_empty())
                .then(|| corners.map(|corner| relative_from_mesh_normal * normals[corner].as_dvec3())),
        }
    }

    /// The corners of a triangle, in relative space.
    pub fn corners(&self, primitive: PrimitiveId) -> [DVec3; 3] {
        let placed = &self.placed[primitive.instance as usize];
        let mesh = &self.scene.meshes[placed.mesh()];
        let positions = placed.bent.as_ref().map_or(&mesh.positions, |bent| &bent.shape.positions);
        let vertices = mesh.triangles[primitive.triangle as usize].vertices;
        let relative_from_mesh = self.relative_from_mesh(primitive.instance as usize);
        vertices.map(|vertex| relative_from_mesh.transform_point3(positions[vertex as usize].as_dvec3()))
    }

    /// Whether alpha may vary over a triangle.
    pub fn is_textured(&self, primitive: PrimitiveId) -> bool {
        let instance = &self.scene.instances[self.placed[primitive.instance as usize].instance()];
        let mesh = &self.scene.meshes[instance.mesh];
        let triangle = mesh.triangles[primitive.triangle as usize];
        let material = &self.materials[instance.material.unwrap_or(triangle.material)];
        let fades = || {
            let [a, b, c] = triangle.vertices.map(|vertex| mesh.alphas.get(vertex as usize));
            a != b || a != c
        };
        material.base_color_texture.is_some_and(|texture| self.scene.textures[texture].has_alpha()) || fades()
    }

    /// Returns the surface at a hit of `ray`.
    pub fn surface(&self, ray: &Ray, hit: &Hit) -> SurfacePoint {
        self.facet(hit.primitive).at(ray, hit.t, hit.barycentrics)
    }
}

impl Facet<'_> {
    /// Distance along a ray to its plane; NaN if the ray starts in that plane, to rounding, and so meets it
    /// nowhere else or lies within it.
    pub fn distance_along(&self, ray: &Ray) -> f64 {
        let way = self.first_corner - ray.origin;
        let height = way.dot(self.normal);
        if height * height <= IN_PLANE * IN_PLANE * way.length_squared() {
            return f64::NAN;
        }
        height / ray.direction.dot(self.normal)
    }

    /// Whether it is visible without lights, by emission or by what it reflects if `is_seen_around`.
    pub fn shows(&self, is_seen_around: bool) -> bool {
        let Material { emission, mirror, coat, .. } = self.material;
        *emission != Rgb::ZERO || *mirror != Rgb::ZERO || is_seen_around && coat.is_some()
    }

    /// The surface at a distance along a ray.
    pub fn seen_along(&self, ray: &Ray, distance: f64) -> SurfacePoint {
        let [_, v, w] = self.weights_at(ray.at(distance));
        self.at(ray, distance, [v, w])
    }

    /// Barycentric coordinates of a point of its plane.
    pub fn weights_at(&self, point: DVec3) -> [f64; 3] {
        let [v, w] = self.gradients.map(|gradient| gradient.dot(point - self.first_corner));
        [1.0 - v - w, v, w]
    }

    /// Asks for the texels that [`Self::seen_along`] will read.
    pub fn prefetch_texels(&self, ray: &Ray, distance: f64) {
        let Material { base_color_texture, transmission_texture, normal_map, coat, .. } = self.material;
        let base = base_color_texture.map(|texture| TextureMap { texture, layer: 0 });
        let others =
            [*transmission_texture, normal_map.map(|(map, _)| map), coat.and_then(|coat| coat.texture)];
        let weights = self.weights_at(ray.at(distance));
        for map in others.into_iter().filter(|map| *map != base).chain([base]).flatten() {
            self.texels_around(map, weights).into_iter().flatten().for_each(prefetch);
        }
    }

    fn at(&self, ray: &Ray, distance: f64, [v, w]: [f64; 2]) -> SurfacePoint {
        let (material, weights) = (self.material, [1.0 - v - w, v, w]);
        let geometric_normal = self.normal_towards(ray);
        let unbent = self.interpolated_normal(geometric_normal, weights);
        let layers = self.layers(weights, unbent);
        let let_out = layers.as_ref().map_or(1.0, |layers| layers.lets_out(-ray.direction));
        let texels = FacetTexels::new(self, weights);
        let paint = texels.paint();
        let painted = |what: Painted, own: Rgb| if material.painted == what { own * paint } else { own };
        let base_color = material.base_color * paint;
        let is_within = (self.normal.dot(ray.direction) > 0.0) != self.is_turned;
        let metal_paint = if material.has_plain_metal { Rgb::ONE } else { paint };
        let color = material.metal_color.map_or(base_color, |color| color * metal_paint);
        let Specular { gloss, dielectric, matte } = texels.specular(color, is_within);
        let transmission = material.transmission * texels.of(material.transmission_texture);
        let emission = match material.emission {
            Rgb::ZERO => Rgb::ZERO,
            emission => painted(Painted::Emission, emission * texels.of(material.emission_texture)),
        };
        let (alpha, see_through) = texels.opacity();
        let to_eye = -ray.direction;
        let bent = material.normal_map.map_or(unbent, |map| self.bent(unbent, map, weights));
        let unbent_normal = material.has_bump_shadows.then_some(unbent);
        let specular_normal = unbent_normal.map_or(bent, |_| specular_normal(geometric_normal, to_eye, bent));
        let [reflected, transmitted] = match &gloss {
            Some(gloss) => gloss.leaves_in_turn(material.coat_takes, specular_normal.dot(to_eye)),
            None => [Rgb::ONE; 2],
        };
        SurfacePoint {
            position: ray.at(distance),
            geometric_normal,
            shading_normal: bent,
            unbent_normal,
            specular_normal,
            albedo: reflected * base_color * matte,
            transmission: transmitted * transmission * matte,
            gloss,
            dielectric,
            layers,
            to_eye,
            mirror: let_out * painted(Painted::Mirror, material.mirror),
            emission: let_out * emission,
            alpha,
            see_through,
            primitive: self.primitive,
            leaf_id: self.leaf_id,
        }
    }

    /// Normal of the flat triangle, on the ray's side.
    fn normal_towards(&self, ray: &Ray) -> DVec3 {
        match self.normal {
            DVec3::ZERO => -ray.direction,
            normal if normal.dot(ray.direction) > 0.0 => -normal,
            normal => normal,
        }
    }

    /// Normal of the mesh, on the side of the geometric one.
    fn interpolated_normal(&self, geometric_normal: DVec3, weights: [f64; 3]) -> DVec3 {
        self.corner_normals.map_or(geometric_normal, |normals| {
            let normal: DVec3 = (0..3).map(|corner| weights[corner] * normals[corner]).sum();
            match normal.try_normalize() {
                Some(normal) if normal.dot(geometric_normal) < 0.0 => -normal,
                Some(normal) => normal,
                None => geometric_normal,
            }
        })
    }

    fn bent(&self, normal: DVec3, (map, scale): (TextureMap, f64), weights: [f64; 3]) -> DVec3 {
        let Some((bending, texel)) = self.bending.zip(self.texel(map, weights)) else { return normal };
        let [bent, unbent] = bending.bent(self.corners, weights, 2.0 * texel - Rgb::ONE, scale);
        // Seen from behind, it is bent as seen from the front and then reversed.
        let is_turned = unbent.dot(normal) < 0.0;
        bent.try_normalize().map_or(normal, |bent| if is_turned { -bent } else { bent })
    }
}

impl Bending<'_> {
    /// Direction of a normal map's texel at a point of the triangle, in the world's axes, and the unbent
    /// normal; neither of unit length.
    ///
    /// Like Blender and its bakers it neither normalises nor orthogonalises interpolated vectors, and bends
    /// in mesh space (Mikkelsen 2008, "Simulation of wrinkled surfaces revisited", 2.2; glTF 2.0, 3.9.3: +X
    /// is to the right in the texture, +Y up, +Z towards the viewer; only x and y are scaled).
    fn bent(&self, corners: [usize; 3], weights: [f64; 3], texel: DVec3, scale: f64) -> [DVec3; 2] {
        let between = |value: &dyn Fn(usize) -> Vec3| -> DVec3 {
            (0..3).map(|corner| weights[corner] * value(corners[corner]).as_dvec3()).sum()
        };
        let normal = if self.normals.is_empty() {
            let [a, b, c] = corners.map(|corner| self.positions[corner].as_dvec3());
            (b - a).cross(c - a).normalize_or_zero()
        } else {
            between(&|corner| self.normals[corner])
        };
        let tangent = between(&|corner| self.tangents[corner].truncate());
        let bitangent = f64::from(self.tangents[corners[0]].w) * normal.cross(tangent);
        let bent = scale * (texel.x * tangent + texel.y * bitangent) + texel.z * normal;
        [bent, normal].map(|direction| self.relative_from_mesh_normal * direction)
    }
}
