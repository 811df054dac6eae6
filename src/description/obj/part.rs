//! Part of an OBJ model. In goes one group as tobj indexes it, out come triangles. Invariant: every vertex
//! has all attributes of the group, and every triangle has an area.

use super::normalize::Group;
use super::tally::Tally;
use super::{ObjMaterial, ObjModel, ObjTriangle, triangulate};
use crate::color::linear_from_srgb;
use crate::diagnostic::{Loss, Place};
use glam::{DVec3, Vec2, Vec3};
use std::collections::HashMap;
use std::path::Path;

/// Vertices of one group, with one material.
pub(super) struct Part {
    group: Group,
    positions: Vec<Vec3>,
    normals: Vec<Vec3>,
    uvs: Vec<Vec2>,
    colors: Vec<Vec3>,
    pub(super) triangles: Vec<[u32; 3]>,
}

impl Part {
    /// Creates the part of a group. The material places its images on the texture coordinates, which default
    /// to 0.
    pub(super) fn new(mesh: &tobj::Mesh, group: Group, material: Option<&ObjMaterial>) -> Self {
        let placement = material.map(ObjMaterial::placement).unwrap_or_default();
        let vectors = |numbers: &[f32]| numbers.chunks_exact(3).map(Vec3::from_slice).collect::<Vec<_>>();
        // OBJ's `v` points up, ours down.
        let down = |uv: Vec2| Vec2::new(uv.x, 1.0 - uv.y);
        let uvs = mesh.texcoords.chunks_exact(2).map(|uv| down(placement.apply(Vec2::from_slice(uv))));
        // Vertex colours are in sRGB, as in Blender.
        let linear = |value: f32| linear_from_srgb(f64::from(value.clamp(0.0, 1.0))) as f32;
        let mut part = Self {
            group,
            positions: vectors(&mesh.positions),
            normals: vectors(&mesh.normals)
                .iter()
                .map(|normal| normal.as_dvec3().normalize().as_vec3())
                .collect(),
            uvs: uvs.collect(),
            colors: vectors(&mesh.vertex_color).iter().map(|color| color.map(linear)).collect(),
            triangles: Vec::new(),
        };
        if material.is_some_and(ObjMaterial::has_textures) && !group.has_uvs {
            part.uvs = vec![Vec2::ZERO; part.positions.len()];
        }
        part
    }

    /// Triangulates the group's faces, and counts degenerate ones, which are dropped.
    pub(super) fn cut(&mut self, mesh: &tobj::Mesh, path: &Path, tally: &mut Tally) -> usize {
        let mut without_area = 0;
        let all_triangles = vec![3; if mesh.face_arities.is_empty() { mesh.indices.len() / 3 } else { 0 }];
        let mut rest = mesh.indices.as_slice();
        for &arity in mesh.face_arities.iter().chain(&all_triangles) {
            let (polygon, after) = rest.split_at((arity as usize).min(rest.len()));
            rest = after;
            let corners: Vec<DVec3> = polygon.iter().map(|&index| self.position(index)).collect();
            let Some(cut) = triangulate::triangulate(&corners) else {
                without_area += 1;
                continue;
            };
            if !cut.simple {
                tally.add(Loss::ObjCrossingFace, "", Place::File(path.to_owned()));
            }
            let triangles = cut.triangles.iter().map(|triangle| triangle.map(|corner| polygon[corner]));
            let with_area: Vec<[u32; 3]> =
                triangles.filter(|&triangle| self.area_normal(triangle).try_normalize().is_some()).collect();
            self.triangles.extend(with_area);
        }
        without_area
    }

    fn position(&self, index: u32) -> DVec3 {
        self.positions[index as usize].as_dvec3()
    }

    /// Twice the area of a triangle, times its normal.
    fn area_normal(&self, triangle: [u32; 3]) -> DVec3 {
        triangulate::newell_normal(&triangle.map(|index| self.position(index)))
    }

    /// Sets smooth normals: the mean over adjacent triangles, weighted by their angles, so that triangulation
    /// has no effect (Thuermer and Wuethrich 1998, Computing Vertex Normals from Polygonal Facets).
    fn shade_smooth(&mut self) {
        // Adding 0 turns -0 into 0.
        let place = |position: Vec3| (position + Vec3::ZERO).to_array().map(f32::to_bits);
        let mut sums: HashMap<[u32; 3], DVec3> = HashMap::new();
        for &triangle in &self.triangles {
            let normal = self.area_normal(triangle).normalize_or_zero();
            for corner in 0..3 {
                let [at, next, last] = [0, 1, 2].map(|step| triangle[(corner + step) % 3]);
                let angle = (self.position(next) - self.position(at))
                    .angle_between(self.position(last) - self.position(at));
                *sums.entry(place(self.positions[at as usize])).or_default() += angle * normal;
            }
        }
        let normal = |&position: &Vec3| {
            let sum = sums.get(&place(position)).copied().unwrap_or_default();
            sum.normalize_or(DVec3::Y).as_vec3()
        };
        self.normals = self.positions.iter().map(normal).collect();
    }

    /// Gives every triangle its own vertices, with the triangle's normal.
    fn shade_flat(&mut self) {
        let corners: Vec<u32> = self.triangles.iter().flatten().copied().collect();
        self.normals = (self.triangles.iter())
            .flat_map(|&triangle| [self.area_normal(triangle).normalize_or(DVec3::Y).as_vec3(); 3])
            .collect();
        spread(&mut self.positions, &corners);
        spread(&mut self.uvs, &corners);
        spread(&mut self.colors, &corners);
        self.triangles =
            (0..corners.len() as u32 / 3).map(|index| [3 * index, 3 * index + 1, 3 * index + 2]).collect();
    }
}

/// Copies one value a vertex to one a corner, unless there are none.
fn spread<T: Copy>(values: &mut Vec<T>, corners: &[u32]) {
    if !values.is_empty() {
        *values = corners.iter().map(|&corner| values[corner as usize]).collect();
    }
}

/// Joins the groups; if one has normals or texture coordinates, all get them.
pub(super) fn merge(mut parts: Vec<Part>, model: &mut ObjModel) {
    parts.retain(|part| !part.triangles.is_empty());
    for part in parts.iter_mut().filter(|part| part.normals.is_empty() && part.group.smoothing != 0) {
        part.shade_smooth();
    }
    let with_normals = parts.iter().any(|part| !part.normals.is_empty());
    let with_uvs = parts.iter().any(|part| !part.uvs.is_empty());
    for mut part in parts {
        if with_normals && part.normals.is_empty() {
            part.shade_flat();
        }
        if with_uvs && part.uvs.is_empty() {
            part.uvs = vec![Vec2::ZERO; part.positions.len()];
        }
        let base = model.positions.len() as u32;
        let material = (part.group.material != usize::MAX).then_some(part.group.material);
        model.triangles.extend(
            part.triangles
                .iter()
                .map(|triangle| ObjTriangle { vertices: triangle.map(|vertex| base + vertex), material }),
        );
        model.positions.append(&mut part.positions);
        model.normals.append(&mut part.normals);
        model.uvs.append(&mut part.uvs);
        model.colors.append(&mut part.colors);
    }
}
