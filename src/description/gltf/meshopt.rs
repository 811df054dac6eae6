//! Compressed buffer views (EXT_meshopt_compression). In go compressed bytes, out come those of the view.
//! Invariant: memory is at most a fixed multiple of the file's size.

use super::json::MeshoptView;
use draco_gltf::meshopt::{MeshoptFilter, MeshoptMode, decode_buffer_view};

/// Maximum bytes that one compressed byte expands to: 256 equal vertices of 256 bytes take two bits for each
/// byte of a vertex (meshoptimizer's vertex codec).
const MOST_EXPANSION: usize = 1024;
/// Bytes that even the smallest stream may expand to.
const SMALL_BYTES: usize = 1 << 16;

/// Decompresses `source`, or fails with the reason.
pub(super) fn unpack(view: &MeshoptView, source: &[u8]) -> Result<Vec<u8>, String> {
    let most = source.len().saturating_mul(MOST_EXPANSION).saturating_add(SMALL_BYTES);
    let length = view.count.checked_mul(view.byte_stride).filter(|length| *length <= most);
    let Some(length) = length else {
        return Err(format!(
            "{} elements of {} bytes are more than {} compressed bytes hold",
            view.count,
            view.byte_stride,
            source.len()
        ));
    };
    let mode = MeshoptMode::from_name(&view.mode).map_err(|error| error.to_string())?;
    let filter = view.filter.as_deref().unwrap_or("NONE");
    let filter = MeshoptFilter::from_name(filter).map_err(|error| error.to_string())?;
    let mut bytes = vec![0; length];
    match decode_buffer_view(&mut bytes, source, mode, filter, view.count, view.byte_stride) {
        Ok(()) => Ok(bytes),
        Err(error) => Err(format!("the compressed data are damaged: {error}")),
    }
}
