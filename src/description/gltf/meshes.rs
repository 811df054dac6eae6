//! Meshes, checked and turned into triangles. Invariant: every triangle's indices are in range, and
//! normals and texture coordinates are as many as positions, or none.

use super::accessor::{Accessors, Component, Wanted};
use super::json::{self, Document};
use super::report::Report;
use super::texture_maps::{Slot, layer, layers as layers_of, slots};
use super::{Mesh, Primitive, morphs, named, skins};
use crate::description::tangents::{self, Vertices};
use crate::diagnostic::{Diagnostic, Loss};
use glam::{DVec2, Vec2, Vec3, Vec4};
use std::collections::BTreeMap;

// Integers where KHR_mesh_quantization allows them; floats are what the core specification has.
const SIGNED_OR_NOT: &[Component] =
    &[Component::F32, Component::I8, Component::U8, Component::I16, Component::U16];
const POSITIONS: Wanted = Wanted { purpose: "positions", width: 3, components: SIGNED_OR_NOT };
const NORMALS: Wanted =
    Wanted { purpose: "normals", width: 3, components: &[Component::F32, Component::I8, Component::I16] };
const TANGENTS: Wanted = Wanted { purpose: "tangents", width: 4, ..NORMALS };
const UVS: Wanted = Wanted { purpose: "texture coordinates", width: 2, components: SIGNED_OR_NOT };
const COLORS: Wanted = Wanted {
    purpose: "vertex colours",
    width: 3,
    components: &[Component::F32, Component::U8, Component::U16],
};
const INDICES: Wanted =
    Wanted { purpose: "indices", width: 1, components: &[Component::U8, Component::U16, Component::U32] };

/// All meshes.
pub(super) fn read(document: &Document, accessors: &Accessors<'_>, report: &mut Report) -> Vec<Mesh> {
    let convert = |(index, mesh): (usize, &json::Mesh)| {
        let name = named(&mesh.name, "mesh", index);
        if mesh.primitives.is_empty() {
            report.error(
                format!("meshes[{index}].primitives"),
                "the mesh is empty",
                "at least one primitive",
            );
        }
        let mut primitives = Vec::new();
        for (number, primitive) in mesh.primitives.iter().enumerate() {
            let path = format!("meshes[{index}].primitives[{number}]");
            report_unused(primitive, &name, report);
            if !is_made_of_triangles(primitive.mode) {
                report.not_honoured(Loss::PointsAndLines, &name);
                continue;
            }
            if let Some(material) = primitive.material {
                report.index_exists(
                    format!("{path}.material"),
                    material,
                    document.materials.len(),
                    "material",
                );
            }
            let primitive = read_primitive(document, primitive, &path, &name, accessors, report);
            primitives.extend(report.keep(primitive));
        }
        let weights = morphs::weights(mesh, index, report);
        Mesh { name, primitives, weights }
    };
    document.meshes.iter().enumerate().map(convert).collect()
}

fn is_made_of_triangles(mode: u32) -> bool {
    // 0 to 3 are points and lines; what is no mode at all is refused further on.
    mode > 3
}

fn report_unused(primitive: &json::Primitive, mesh: &str, report: &mut Report) {
    if primitive.extensions.contains_key("KHR_materials_variants") {
        report.not_honoured(Loss::MaterialVariants, mesh);
    }
}

fn read_primitive(
    document: &Document,
    primitive: &json::Primitive,
    path: &str,
    mesh: &str,
    accessors: &Accessors<'_>,
    report: &mut Report,
) -> Result<Primitive, Diagnostic> {
    let attribute = |name: &str| attribute(&primitive.attributes, name, path);
    let Some((index, user)) = attribute("POSITION") else {
        return Err(accessors
            .invalid(format!("{path}.attributes"), "the mesh has no positions")
            .expected("POSITION"));
    };
    let positions: Vec<Vec3> = vectors(&accessors.read(index, POSITIONS, &user)?);
    let same_count = |accessor: usize, user: &str| {
        let count = accessors.count(accessor);
        if count == positions.len() {
            return Ok(());
        }
        Err(accessors
            .invalid(user, format!("there are {} positions and {count} of these", positions.len()))
            .expected("as many as there are positions"))
    };
    let normals = match attribute("NORMAL") {
        Some((index, user)) => {
            same_count(index, &user)?;
            unit_vectors(&accessors.read(index, NORMALS, &user)?)
        }
        None => Some(Vec::new()),
    };
    let normals = normals.unwrap_or_else(|| {
        report.not_honoured(Loss::NormalsWithoutLength, mesh);
        Vec::new()
    });
    let slots = primitive.material.and_then(|material| document.materials.get(material)).map(slots);
    let mut layers = Vec::new();
    for (set, transform) in layers_of(slots.as_deref().unwrap_or_default()) {
        layers.push(match attribute(&format!("TEXCOORD_{set}")) {
            Some((index, user)) => {
                same_count(index, &user)?;
                let uvs = accessors.read(index, UVS, &user)?;
                let transformed = |uv| transform.transform_point2(DVec2::from_slice(uv)).as_vec2();
                let uvs: Vec<Vec2> = uvs.chunks_exact(2).map(transformed).collect();
                if !uvs.iter().all(|uv| uv.is_finite()) {
                    return Err(accessors
                        .invalid(user, "a texture's transform makes these texture coordinates infinite")
                        .expected("an offset and a scale of a usual size"));
                }
                uvs
            }
            None => {
                report.not_honoured(Loss::TextureCoordinatesMissing, mesh);
                vec![Vec2::ZERO; positions.len()]
            }
        });
    }
    let mut layers = layers.into_iter();
    let (uvs, more_uvs) = (layers.next().unwrap_or_default(), layers.collect());
    let colors = match attribute("COLOR_0") {
        Some((index, user)) => {
            same_count(index, &user)?;
            let has_alpha = document.accessors.get(index).is_some_and(|accessor| accessor.shape == "VEC4");
            let width = if has_alpha { 4 } else { 3 };
            colors(&accessors.read(index, Wanted { width, ..COLORS }, &user)?, width, mesh, report)
        }
        None => Vec::new(),
    };
    if attribute("COLOR_1").is_some() {
        report.not_honoured(Loss::VertexColorSets, mesh);
    }
    let indices = match primitive.indices {
        Some(index) => indices(accessors, index, positions.len(), &format!("{path}.indices"))?,
        None => (0..positions.len() as u32).collect(),
    };
    let triangles = triangles(&indices, primitive.mode).ok_or_else(|| {
        accessors
            .invalid(format!("{path}.mode"), format!("{} vertices of mode {}", indices.len(), primitive.mode))
            .expected("whole triangles: mode 4 with a multiple of 3 vertices, or mode 5 or 6 with 3 or more")
    })?;
    let targets = morphs::targets(primitive, positions.len(), path, mesh, accessors, report)?;
    let influences =
        skins::influences(&primitive.attributes, positions.len(), path, mesh, accessors, report)?;
    let mut whole = Primitive {
        positions,
        normals,
        uvs,
        more_uvs,
        colors,
        tangents: Vec::new(),
        triangles,
        material: primitive.material,
        targets,
        influences,
    };
    let normal_map = slots.iter().flatten().find(|slot| slot.purpose.is_bending());
    if let Some(Slot { info, .. }) = normal_map {
        // Those of the coordinates themselves, as Blender has them, whatever is done to these for the image.
        let (set, _) = layer(info);
        add_tangents(&mut whole, primitive, set, (path, mesh), accessors, report)?;
    }
    Ok(whole)
}

/// The tangents of the file, or those that it leaves to be computed from texture coordinates (specification, 3.7.2.1).
fn add_tangents(
    whole: &mut Primitive,
    primitive: &json::Primitive,
    set: usize,
    (path, mesh): (&str, &str),
    accessors: &Accessors<'_>,
    report: &mut Report,
) -> Result<(), Diagnostic> {
    let as_many = |values: usize, user: String| {
        if values == whole.positions.len() {
            return Ok(());
        }
        let found = format!("there are {} positions and {values} of these", whole.positions.len());
        Err(accessors.invalid(user, found).expected("as many as there are positions"))
    };
    if let Some((index, user)) = attribute(&primitive.attributes, "TANGENT", path) {
        let numbers = accessors.read(index, TANGENTS, &user)?;
        as_many(numbers.len() / 4, user)?;
        let tangent = |numbers: &[f64]| {
            let [x, y, z, side] = [0, 1, 2, 3].map(|at| numbers[at] as f32);
            let direction = Vec3::new(x, y, z).try_normalize()?;
            (side != 0.0).then(|| direction.extend(side.signum()))
        };
        let given: Option<Vec<Vec4>> = numbers.chunks_exact(4).map(tangent).collect();
        // Without normals they mean nothing.
        match given {
            Some(given) if !whole.normals.is_empty() => {
                whole.tangents = given;
                return Ok(());
            }
            Some(_) => {}
            None => report.not_honoured(Loss::TangentsUnusable, mesh),
        }
    }
    let Some((index, user)) = attribute(&primitive.attributes, &format!("TEXCOORD_{set}"), path) else {
        return Ok(());
    };
    let uvs = accessors.read(index, UVS, &user)?;
    as_many(uvs.len() / 2, user)?;
    let uvs: Vec<Vec2> = uvs.chunks_exact(2).map(|uv| DVec2::from_slice(uv).as_vec2()).collect();
    if !make_tangents(whole, &uvs) {
        report.not_honoured(Loss::NormalMapUnusable, mesh);
    }
    Ok(())
}

/// Gives a primitive tangents, and the copies of vertices that these need; `false` if too many triangles meet in one place.
fn make_tangents(whole: &mut Primitive, uvs: &[Vec2]) -> bool {
    let vertices = Vertices { positions: &whole.positions, normals: &whole.normals, uvs };
    let Some(made) = tangents::generate(vertices, &mut whole.triangles) else { return false };
    made.copy(&mut whole.positions);
    made.copy(&mut whole.normals);
    made.copy(&mut whole.uvs);
    whole.more_uvs.iter_mut().for_each(|uvs| made.copy(uvs));
    made.copy(&mut whole.colors);
    for target in &mut whole.targets {
        made.copy(&mut target.positions);
        made.copy(&mut target.normals);
        made.copy(&mut target.tangents);
    }
    if let Some(influences) = &mut whole.influences {
        for &original in &made.originals {
            let own =
                original as usize * influences.per_vertex..(original as usize + 1) * influences.per_vertex;
            influences.joints.extend_from_within(own.clone());
            influences.weights.extend_from_within(own);
        }
    }
    whole.tangents = made.tangents;
    true
}

fn attribute(attributes: &BTreeMap<String, usize>, name: &str, path: &str) -> Option<(usize, String)> {
    attributes.get(name).map(|&index| (index, format!("{path}.attributes.{name}")))
}

fn indices(
    accessors: &Accessors<'_>,
    accessor: usize,
    vertices: usize,
    user: &str,
) -> Result<Vec<u32>, Diagnostic> {
    let indices = accessors.read(accessor, INDICES, user)?;
    match indices.iter().position(|&index| index >= vertices as f64) {
        None => Ok(indices.into_iter().map(|index| index as u32).collect()),
        Some(at) => Err(accessors
            .invalid(user, format!("index {at} is {}, and there are {vertices} vertices", indices[at]))
            .expected("indices of vertices that exist")),
    }
}

/// Triangles of a list, a strip or a fan (specification, 3.7.2.1); `None` if they are not whole.
fn triangles(indices: &[u32], mode: u32) -> Option<Vec<[u32; 3]>> {
    let whole = if mode == 4 { indices.len().is_multiple_of(3) } else { indices.len() >= 3 };
    if !whole || indices.is_empty() {
        return None;
    }
    match mode {
        4 => Some(indices.chunks_exact(3).map(|c| [c[0], c[1], c[2]]).collect()),
        5 => {
            let turned = |(i, w): (usize, &[u32])| {
                if i % 2 == 0 { [w[0], w[1], w[2]] } else { [w[0], w[2], w[1]] }
            };
            Some(indices.windows(3).enumerate().map(turned).collect())
        }
        6 => Some(indices[1..].windows(2).map(|w| [indices[0], w[0], w[1]]).collect()),
        _ => None,
    }
}

/// Linear colours at the vertices; none if all are white, which Blender writes where nothing uses them.
fn colors(numbers: &[f64], width: usize, mesh: &str, report: &mut Report) -> Vec<Vec3> {
    if width == 4 && numbers.chunks_exact(4).any(|color| color[3] < 1.0) {
        report.not_honoured(Loss::VertexAlpha, mesh);
    }
    let color = |c: &[f64]| Vec3::new(c[0] as f32, c[1] as f32, c[2] as f32).clamp(Vec3::ZERO, Vec3::ONE);
    let colors: Vec<Vec3> = numbers.chunks_exact(width).map(color).collect();
    if colors.iter().all(|color| *color == Vec3::ONE) { Vec::new() } else { colors }
}

pub(super) fn vectors(numbers: &[f64]) -> Vec<Vec3> {
    numbers.chunks_exact(3).map(|v| Vec3::new(v[0] as f32, v[1] as f32, v[2] as f32)).collect()
}

/// The vectors at unit length; `None` if one has no length.
fn unit_vectors(numbers: &[f64]) -> Option<Vec<Vec3>> {
    vectors(numbers).into_iter().map(|vector| vector.try_normalize()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn strips_and_fans_keep_their_winding() {
        let indices = [0, 1, 2, 3, 4];
        assert_eq!(triangles(&indices, 5), Some(vec![[0, 1, 2], [1, 3, 2], [2, 3, 4]]));
        assert_eq!(triangles(&indices, 6), Some(vec![[0, 1, 2], [0, 2, 3], [0, 3, 4]]));
        assert_eq!(triangles(&indices, 4), None);
    }
}
