//! Meshes as triangles. In goes JSON, out come primitives. Invariant: every triangle's indices are in range,
//! and normals and texture coordinates are as many as positions, or none. Unreadable parts are dropped: the
//! attribute alone where possible, else the primitive.

use super::accessor::{Accessors, Component, Wanted};
use super::attributes::{At, Attributes, SIGNED_OR_NOT, vectors};
use super::draco::Damaged;
use super::json::{self, Document};
use super::report::Report;
use super::texture_maps::{Slot, layer, layers, slots};
use super::{Mesh, Primitive, morphs, named, skins};
use crate::description::tangents::{self, Vertices};
use crate::diagnostic::{Diagnostic, Loss};
use glam::{Vec2, Vec3};

const POSITIONS: Wanted = Wanted { purpose: "positions", width: 3, components: SIGNED_OR_NOT };
const INDICES: Wanted =
    Wanted { purpose: "indices", width: 1, components: &[Component::U8, Component::U16, Component::U32] };

/// Reads all meshes; `damaged` are the primitives that could not be decompressed.
pub(super) fn read(
    document: &Document,
    accessors: &Accessors<'_>,
    mut damaged: Damaged,
    report: &mut Report,
) -> Vec<Mesh> {
    let convert = |(index, mesh): (usize, &json::Mesh)| {
        let name = named(&mesh.name, "mesh", index);
        let mut primitives = Vec::new();
        for (number, primitive) in mesh.primitives.iter().enumerate() {
            let path = format!("meshes[{index}].primitives[{number}]");
            if primitive.extensions.contains_key("KHR_materials_variants") {
                report.not_honoured(Loss::MaterialVariants, &name);
            }
            // Points and lines; invalid modes are dropped later.
            if primitive.mode <= 3 {
                report.not_honoured(Loss::PointsAndLines, &name);
                continue;
            }
            // Such primitives are valid, but their contents are not specified.
            if !primitive.attributes.contains_key("POSITION") && primitive.extensions.is_empty() {
                report.not_honoured(Loss::PrimitiveWithoutPositions, &name);
                continue;
            }
            let primitive = match damaged.remove(&(index, number)) {
                Some(damage) => Err(damage),
                None => {
                    read_primitive(document, primitive, At { path: &path, mesh: &name }, accessors, report)
                }
            };
            primitives.extend(report.spare(Loss::PrimitiveDamaged, primitive));
        }
        let weights = morphs::weights(mesh, index, &mut primitives, report);
        Mesh { name, primitives, weights, extras: mesh.extras.clone() }
    };
    document.meshes.iter().enumerate().map(convert).collect()
}

fn read_primitive(
    document: &Document,
    primitive: &json::Primitive,
    at: At,
    accessors: &Accessors<'_>,
    report: &mut Report,
) -> Result<Primitive, Diagnostic> {
    let At { path, mesh } = at;
    let Some(&positions) = primitive.attributes.get("POSITION") else {
        let found = "the mesh has no positions";
        return Err(accessors.invalid(format!("{path}.attributes"), found).expected("POSITION"));
    };
    let positions: Vec<Vec3> =
        vectors(&accessors.read(positions, POSITIONS, &format!("{path}.attributes.POSITION"))?);
    let vertices = positions.len();
    let triangles = read_triangles(primitive, vertices, path, accessors, report)?;
    let material = primitive.material.filter(|&material| {
        report.index_exists(&format!("{path}.material"), material, document.materials.len(), "material")
    });
    let slots = material.map(|material| slots(&document.materials[material])).unwrap_or_default();
    let targets = morphs::targets(primitive, vertices, at, accessors, report);
    let influences = skins::influences(&primitive.attributes, vertices, at, accessors, report);

    let mut attributes = Attributes { document, primitive, vertices, path, mesh, accessors, report };
    let normals = attributes.normals();
    let mut layers: Vec<Vec<Vec2>> = layers(&slots).iter().map(|&layer| attributes.uvs(layer)).collect();
    let (colors, alphas) = attributes.colors();
    let mut whole = Primitive {
        positions,
        normals,
        uvs: if layers.is_empty() { Vec::new() } else { layers.remove(0) },
        more_uvs: layers,
        colors,
        alphas,
        tangents: Vec::new(),
        triangles,
        material,
        targets: attributes.report.spare(Loss::MorphTargetsDamaged, targets).unwrap_or_default(),
        influences: attributes.report.spare(Loss::SkinDamaged, influences).flatten(),
    };
    let normal_map = slots.iter().find(|slot| slot.purpose.is_bending());
    if let Some(Slot { info, .. }) = normal_map {
        // Tangents belong to the coordinates before the image's transform, as in Blender.
        let (set, _) = layer(info);
        add_tangents(&mut whole, set, &mut attributes);
    }
    Ok(whole)
}

/// Adds the file's tangents, or computes them from texture coordinates where the file has none
/// (specification, 3.7.2.1).
fn add_tangents(whole: &mut Primitive, set: usize, attributes: &mut Attributes<'_>) {
    // Tangents have no meaning without normals.
    if let Some(given) = attributes.tangents().filter(|_| !whole.normals.is_empty()) {
        whole.tangents = given;
        return;
    }
    let Some(uvs) = attributes.plain_uvs(set) else { return };
    if !make_tangents(whole, &uvs) {
        attributes.report.not_honoured(Loss::NormalMapUnusable, attributes.mesh);
    }
}

/// Computes tangents of a primitive, and copies vertices where they need it; `false` if too many triangles
/// meet at one point.
fn make_tangents(whole: &mut Primitive, uvs: &[Vec2]) -> bool {
    let vertices = Vertices { positions: &whole.positions, normals: &whole.normals, uvs };
    let Some(made) = tangents::generate(vertices, &mut whole.triangles) else { return false };
    made.copy(&mut whole.positions);
    made.copy(&mut whole.normals);
    made.copy(&mut whole.uvs);
    whole.more_uvs.iter_mut().for_each(|uvs| made.copy(uvs));
    made.copy(&mut whole.colors);
    made.copy(&mut whole.alphas);
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

fn read_triangles(
    primitive: &json::Primitive,
    vertices: usize,
    path: &str,
    accessors: &Accessors<'_>,
    report: &mut Report,
) -> Result<Vec<[u32; 3]>, Diagnostic> {
    let indices = match primitive.indices {
        Some(index) => indices(accessors, index, vertices, &format!("{path}.indices"))?,
        None => (0..vertices as u32).collect(),
    };
    let triangles = triangles(&indices, primitive.mode).ok_or_else(|| {
        accessors
            .invalid(format!("{path}.mode"), format!("{} vertices of mode {}", indices.len(), primitive.mode))
            .expected("triangles: mode 4, 5 or 6 with 3 vertices or more")
    })?;
    if primitive.mode == 4 && !indices.len().is_multiple_of(3) {
        report.put_right(Loss::TrianglesIncomplete, path, format!("{} vertices", indices.len()));
    }
    Ok(triangles)
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

/// Triangles of a list, a strip or a fan (specification, 3.7.2.1); `None` if there are none.
fn triangles(indices: &[u32], mode: u32) -> Option<Vec<[u32; 3]>> {
    if indices.len() < 3 {
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn strips_and_fans_keep_their_winding() {
        let indices = [0, 1, 2, 3, 4];
        assert_eq!(triangles(&indices, 5), Some(vec![[0, 1, 2], [1, 3, 2], [2, 3, 4]]));
        assert_eq!(triangles(&indices, 6), Some(vec![[0, 1, 2], [0, 2, 3], [0, 3, 4]]));
        assert_eq!(triangles(&indices, 4), Some(vec![[0, 1, 2]]));
        assert_eq!(triangles(&indices[..2], 4), None);
    }
}
