//! Cryptomatte metadata. In go a frame and names, out come EXR attributes. Invariant: the manifest has
//! exactly the ids in the frame's channels.

use crate::film::{Frame, MATTE_LAYER};
use crate::scene::murmur3;
use std::collections::{BTreeMap, BTreeSet};

/// Attributes of the Cryptomatte specification 1.2.0, by name; none if the frame has no such channels.
pub(super) fn attributes(frame: &Frame, object_names: &BTreeMap<u32, String>) -> Vec<(String, String)> {
    let ids: BTreeSet<u32> = frame
        .channels
        .iter()
        .filter(|channel| channel.name.starts_with(MATTE_LAYER) && channel.holds_ids())
        .flat_map(|channel| channel.pixels.iter().map(|id| id.to_bits()))
        .collect();
    if ids.is_empty() {
        return Vec::new();
    }
    let named = object_names.iter().filter(|(id, _)| ids.contains(id));
    let manifest: BTreeMap<&str, String> =
        named.map(|(id, name)| (name.as_str(), format!("{id:08x}"))).collect();
    // The key is the first seven digits of the layer's hash.
    let key = &format!("{:08x}", murmur3(MATTE_LAYER.as_bytes()))[..7];
    let manifest = serde_json::json!(manifest).to_string();
    [
        ("name", MATTE_LAYER),
        ("hash", "MurmurHash3_32"),
        ("conversion", "uint32_to_float32"),
        ("manifest", &manifest),
    ]
    .map(|(field, value)| (format!("cryptomatte/{key}/{field}"), value.to_owned()))
    .to_vec()
}
