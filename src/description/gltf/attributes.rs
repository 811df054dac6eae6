//! Vertex attributes of a primitive, except positions. In go accessors, out come numbers, one set a vertex.
//! Invariant: an attribute that is unreadable or of the wrong length is dropped and reported, never partly
//! read.

use super::accessor::{Accessors, Component, Wanted};
use super::json::{self, Document};
use super::report::Report;
use super::texture_maps::Layer;
use crate::diagnostic::Loss;
use glam::{DVec2, Vec2, Vec3, Vec4};

// Integers are allowed by KHR_mesh_quantization; the core specification has floats.
pub(super) const SIGNED_OR_NOT: &[Component] =
    &[Component::F32, Component::I8, Component::U8, Component::I16, Component::U16];
pub(super) const UNSIGNED: &[Component] = &[Component::F32, Component::U8, Component::U16];
const NORMALS: Wanted =
    Wanted { purpose: "normals", width: 3, components: &[Component::F32, Component::I8, Component::I16] };
const TANGENTS: Wanted = Wanted { purpose: "tangents", width: 4, ..NORMALS };
const UVS: Wanted = Wanted { purpose: "texture coordinates", width: 2, components: SIGNED_OR_NOT };
const COLORS: Wanted = Wanted { purpose: "vertex colours", width: 3, components: UNSIGNED };

/// Place of a primitive in its file, and its mesh's name for messages.
#[derive(Clone, Copy)]
pub(super) struct At<'a> {
    pub(super) path: &'a str,
    pub(super) mesh: &'a str,
}

pub(super) struct Attributes<'a> {
    pub(super) document: &'a Document,
    pub(super) primitive: &'a json::Primitive,
    /// Number of vertices.
    pub(super) vertices: usize,
    pub(super) path: &'a str,
    pub(super) mesh: &'a str,
    pub(super) accessors: &'a Accessors<'a>,
    pub(super) report: &'a mut Report,
}

impl Attributes<'_> {
    /// Unit normals, or none.
    pub(super) fn normals(&mut self) -> Vec<Vec3> {
        let Some(numbers) = self.numbers("NORMAL", NORMALS) else { return Vec::new() };
        let unit: Option<Vec<Vec3>> = vectors(&numbers).into_iter().map(Vec3::try_normalize).collect();
        unit.unwrap_or_else(|| {
            self.report.not_honoured(Loss::NormalsWithoutLength, self.mesh);
            Vec::new()
        })
    }

    /// Texture coordinates after the texture's transform; zeros if there are none.
    pub(super) fn uvs(&mut self, (set, transform): Layer) -> Vec<Vec2> {
        let name = format!("TEXCOORD_{set}");
        if !self.primitive.attributes.contains_key(&name) {
            self.report.not_honoured(Loss::TextureCoordinatesMissing, self.mesh);
        }
        let uvs = self.numbers(&name, UVS).map(|numbers| {
            let transformed = |uv| transform.transform_point2(DVec2::from_slice(uv)).as_vec2();
            numbers.chunks_exact(2).map(transformed).collect::<Vec<_>>()
        });
        match uvs {
            Some(uvs) if uvs.iter().all(|uv| uv.is_finite()) => return uvs,
            Some(_) => {
                let found = "a texture's transform makes these texture coordinates infinite";
                self.report.put_right(Loss::AttributeDamaged, &self.user(&name), found);
            }
            None => {}
        }
        vec![Vec2::ZERO; self.vertices]
    }

    /// Texture coordinates before any transform.
    pub(super) fn plain_uvs(&mut self, set: usize) -> Option<Vec<Vec2>> {
        let numbers = self.numbers(&format!("TEXCOORD_{set}"), UVS)?;
        Some(numbers.chunks_exact(2).map(|uv| DVec2::from_slice(uv).as_vec2()).collect())
    }

    /// Linear colours, and alphas. Either is empty if all are 1, as Blender writes them where they are
    /// unused.
    pub(super) fn colors(&mut self) -> (Vec<Vec3>, Vec<f32>) {
        if self.primitive.attributes.contains_key("COLOR_1") {
            self.report.not_honoured(Loss::VertexColorSets, self.mesh);
        }
        let Some(index) = self.primitive.attributes.get("COLOR_0") else { return Default::default() };
        let has_alpha = self.document.accessors.get(*index).is_some_and(|accessor| accessor.shape == "VEC4");
        let width = if has_alpha { 4 } else { 3 };
        let Some(numbers) = self.numbers("COLOR_0", Wanted { width, ..COLORS }) else {
            return Default::default();
        };
        let color = |c: &[f64]| Vec3::new(c[0] as f32, c[1] as f32, c[2] as f32).clamp(Vec3::ZERO, Vec3::ONE);
        let mut colors: Vec<Vec3> = numbers.chunks_exact(width).map(color).collect();
        let alpha = |c: &[f64]| (c[3] as f32).clamp(0.0, 1.0);
        let mut alphas: Vec<f32> = match has_alpha {
            true => numbers.chunks_exact(4).map(alpha).collect(),
            false => Vec::new(),
        };
        if colors.iter().all(|color| *color == Vec3::ONE) {
            colors.clear();
        }
        if alphas.iter().all(|alpha| *alpha == 1.0) {
            alphas.clear();
        }
        (colors, alphas)
    }

    /// Tangents of the file, if they are usable.
    pub(super) fn tangents(&mut self) -> Option<Vec<Vec4>> {
        let numbers = self.numbers("TANGENT", TANGENTS)?;
        let tangent = |numbers: &[f64]| {
            let [x, y, z, side] = [0, 1, 2, 3].map(|at| numbers[at] as f32);
            let direction = Vec3::new(x, y, z).try_normalize()?;
            (side != 0.0).then(|| direction.extend(side.signum()))
        };
        let given: Option<Vec<Vec4>> = numbers.chunks_exact(4).map(tangent).collect();
        if given.is_none() {
            self.report.not_honoured(Loss::TangentsUnusable, self.mesh);
        }
        given
    }

    /// Numbers of an attribute; `None` if it is missing or unreadable.
    fn numbers(&mut self, name: &str, wanted: Wanted) -> Option<Vec<f64>> {
        let index = *self.primitive.attributes.get(name)?;
        let read = self.accessors.read_for(self.vertices, index, wanted, &self.user(name));
        self.report.spare(Loss::AttributeDamaged, read)
    }

    fn user(&self, name: &str) -> String {
        format!("{}.attributes.{name}", self.path)
    }
}

pub(super) fn vectors(numbers: &[f64]) -> Vec<Vec3> {
    numbers.chunks_exact(3).map(|v| Vec3::new(v[0] as f32, v[1] as f32, v[2] as f32)).collect()
}
