//! Hash of a file's pixels. In go channels, out come hexadecimal digits. Invariant: it depends only on the
//! channels' names, types and stored bits.

use exr::image::{AnyChannels, FlatSamples};
use sha2::{Digest, Sha256};

/// Values hashed at a time, within the cache.
const BLOCK: usize = 1 << 14;

/// SHA-256 as hexadecimal digits; the module's head defines the order of the bytes.
pub(super) fn pixel_hash(channels: &AnyChannels<FlatSamples>) -> String {
    let mut ordered: Vec<_> = channels.list.iter().collect();
    ordered.sort_by(|a, b| a.name.bytes().cmp(b.name.bytes()));
    let mut digest = Sha256::new();
    for channel in ordered {
        digest.update(channel.name.bytes());
        match &channel.sample_data {
            FlatSamples::F16(values) => {
                update(&mut digest, "half", values, |value| value.to_bits().to_le_bytes());
            }
            FlatSamples::F32(values) => update(&mut digest, "float", values, |value| value.to_le_bytes()),
            FlatSamples::U32(values) => update(&mut digest, "uint", values, |value| value.to_le_bytes()),
        }
    }
    digest.finalize().iter().map(|byte| format!("{byte:02x}")).collect()
}

fn update<T: Copy, const BYTES: usize>(
    digest: &mut Sha256,
    kind: &str,
    values: &[T],
    bytes: impl Fn(T) -> [u8; BYTES],
) {
    digest.update([0]);
    digest.update(kind);
    digest.update([0]);
    let mut buffer = Vec::with_capacity(BLOCK * BYTES);
    for block in values.chunks(BLOCK) {
        buffer.clear();
        buffer.extend(block.iter().flat_map(|&value| bytes(value)));
        digest.update(&buffer);
    }
}
