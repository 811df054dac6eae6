//! Draco compression (KHR_draco_mesh_compression). In go compressed primitives, out come plain accessors.
//! Invariants: every accessor has as many bytes as its count and type require. Memory is at most a fixed
//! multiple of the file's size.

use super::buffers::Buffers;
use super::invalid;
use super::json::{Document, Primitive};
use crate::diagnostic::Diagnostic;
use draco_gltf::{DecodeLimits, DracoPrimitiveContract, DracoPrimitiveExtension, JsonValue};
use std::collections::BTreeMap;
use std::path::Path;

const EXTENSION: &str = "KHR_draco_mesh_compression";
/// Maximum bytes that one compressed byte expands to; regular meshes take about a bit a triangle.
const MOST_EXPANSION: u64 = 4096;
/// Bytes that even the smallest stream may expand to.
const SMALL_BYTES: u64 = 1 << 20;
/// Mode of triangle lists, the only one in Draco's streams.
const TRIANGLES: u32 = 4;

/// Decompressed accessor without a buffer view.
pub(super) struct Unpacked {
    /// Number of elements; more than the accessor's where Draco split vertices at seams.
    pub(super) count: usize,
    pub(super) width: usize,
    /// glTF's code for the component type.
    pub(super) component_type: u32,
    /// Element by element, little-endian.
    pub(super) bytes: Vec<u8>,
}

/// Errors of primitives that cannot be decompressed, by mesh and primitive.
pub(super) type Damaged = BTreeMap<(usize, usize), Diagnostic>;

/// Decompresses all primitives: accessors by their indices, and errors.
pub(super) fn unpack(
    document: &Document,
    buffers: &Buffers<'_>,
    file: &Path,
) -> (BTreeMap<usize, Unpacked>, Damaged) {
    let (mut unpacked, mut damaged) = (BTreeMap::new(), Damaged::new());
    for (mesh_index, mesh) in document.meshes.iter().enumerate() {
        for (number, primitive) in mesh.primitives.iter().enumerate() {
            let path = format!("meshes[{mesh_index}].primitives[{number}]");
            match of_primitive(primitive, document, buffers, file, &path) {
                Ok(filled) => unpacked.extend(filled),
                Err(damage) => {
                    damaged.insert((mesh_index, number), damage);
                }
            }
        }
    }
    (unpacked, damaged)
}

fn of_primitive(
    primitive: &Primitive,
    document: &Document,
    buffers: &Buffers<'_>,
    file: &Path,
    path: &str,
) -> Result<Vec<(usize, Unpacked)>, Diagnostic> {
    let mut unpacked = Vec::new();
    let Some(extension) = primitive.extensions.get(EXTENSION) else { return Ok(unpacked) };
    let path = format!("{path}.extensions.{EXTENSION}");
    let damaged = |found: String| {
        invalid(file, path.as_str(), found).expected("a mesh as Draco 2.2 compresses it").remedy(
            "export the original scene again, or without compression (Blender: Data > Compression off)",
        )
    };
    if primitive.mode != TRIANGLES {
        return Err(damaged(format!("a compressed mesh cannot be of mode {}", primitive.mode)));
    }
    let extension = JsonValue::parse(extension.to_string().as_bytes())
        .and_then(|json| DracoPrimitiveExtension::from_json(&json).map_err(|error| plain(&error)))
        .map_err(|error| damaged(format!("the extension is malformed: {error}")))?;
    let (payload, _) = buffers.view(extension.buffer_view(), &format!("{path}.bufferView"))?;

    let contract = contract(primitive, document, &extension, payload.len()).map_err(&damaged)?;
    let geometry = extension.decode(payload, &contract).map_err(|error| damaged(plain(&error)))?;

    for attribute in geometry.attributes() {
        let Some(&index) = primitive.attributes.get(attribute.semantic()) else { continue };
        let filled = Unpacked {
            count: attribute.count(),
            width: usize::from(attribute.components()),
            component_type: attribute.component_type() as u32,
            bytes: attribute.bytes().to_vec(),
        };
        unpacked.push((index, filled));
    }
    if let (Some(index), Some(indices)) = (primitive.indices, geometry.indices()) {
        let filled = Unpacked {
            count: indices.count(),
            width: 1,
            component_type: indices.component_type() as u32,
            bytes: indices.bytes().to_vec(),
        };
        unpacked.push((index, filled));
    }
    Ok(unpacked)
}

/// Limits on the decoded mesh: its accessors' counts, and a multiple of the compressed size. Fails if an
/// accessor is missing.
fn contract(
    primitive: &Primitive,
    document: &Document,
    extension: &DracoPrimitiveExtension,
    bytes: usize,
) -> Result<DracoPrimitiveContract, String> {
    let most_bytes = (bytes as u64).saturating_mul(MOST_EXPANSION).saturating_add(SMALL_BYTES);
    let mut limits = DecodeLimits::default();
    limits.max_points = most_bytes;
    limits.max_faces = most_bytes;
    limits.max_decoded_bytes = most_bytes;
    let mut contract = DracoPrimitiveContract::new().with_limits(limits);
    for (semantic, _) in extension.attributes() {
        let accessor = primitive.attributes.get(semantic).and_then(|&index| document.accessors.get(index));
        let Some(accessor) = accessor else {
            return Err(format!("the primitive has no accessor for the compressed {semantic}"));
        };
        contract = contract.with_attribute(semantic, accessor.count as u64, accessor.normalized);
    }
    if let Some(indices) = primitive.indices.and_then(|index| document.accessors.get(index)) {
        contract = contract.with_indices(indices.count as u64);
    }
    Ok(contract)
}

/// Message of the decoder, without its prefix.
fn plain(error: &impl std::fmt::Display) -> String {
    error.to_string().replace("error:", "error,")
}
