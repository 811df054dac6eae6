//! Cache of bakes. In go names and functions that bake, out come leaves, from the cache where it has them.
//! Invariant: a cached bake equals a new one to the last bit. Its name identifies its inputs and the edition
//! of this code, and a checksum detects damage.
//!
//! A file is little-endian: a magic number, the number of leaves, for each leaf its length and bytes, and a
//! CRC-32 of all. Leaves are read one by one, so none is in memory twice.

use super::flown::Flown;
use super::leaf::Pose;
use crate::scene::baking::Baking;
use crate::scene::{Hashed, Track};
use glam::{DQuat, DVec3};
use rayon::prelude::*;
use sha2::{Digest, Sha256};
use std::fmt::Debug;
use std::io::Read;

/// Edition, which every change of the results has to raise: old bakes then have other names.
pub(super) const EDITION: u32 = 4;
/// Minimum number of leaves to cache; fewer are baked faster than a file is found.
const FEWEST: usize = 20;

/// Leaf that can be cached.
pub(super) trait Kept: Sized + Sync {
    /// Magic number of a file of such leaves.
    const MAGIC: &[u8; 16];

    /// Appends its bytes; `None` for a leaf whose keys have no compact form.
    fn write(&self, bytes: &mut Vec<u8>) -> Option<()>;

    /// Decodes a leaf from all these bytes; `None` for bytes that `write` cannot give.
    fn read(bytes: &[u8]) -> Option<Self>;
}

/// Reads leaves from the cache under a name, or bakes and stores them.
pub(super) fn recalled<L: Kept>(
    name: &str,
    count: usize,
    baking: &Baking,
    bake: impl FnOnce() -> Vec<L>,
) -> Vec<L> {
    if count < FEWEST {
        return bake();
    }
    let recalled = (baking.recall)(name).and_then(decode);
    if let Some(leaves) = recalled.filter(|leaves: &Vec<L>| leaves.len() == count) {
        return leaves;
    }
    let leaves = bake();
    if let Some(parts) = encode(&leaves) {
        (baking.keep)(name, &parts.iter().map(Vec::as_slice).collect::<Vec<_>>());
    }
    leaves
}

/// Name of a bake, a hash of its inputs.
pub(super) fn name_of(what: &impl Debug) -> String {
    let mut hash = Hashed(Sha256::new());
    // Shortest decimals round-trip, so different numbers have different names.
    hash.add(format_args!("{EDITION} {what:?}"));
    hash.0.finalize().iter().map(|byte| format!("{byte:02x}")).collect()
}

impl Kept for Flown {
    const MAGIC: &[u8; 16] = b"sunfleck bake 4\n";

    fn write(&self, bytes: &mut Vec<u8>) -> Option<()> {
        bytes.extend((self.tail.len() as u64).to_le_bytes());
        for pose in &self.tail {
            let numbers = [[pose.time_s].as_slice(), &pose.middle.to_array(), &pose.turn.to_array()].concat();
            bytes.extend(numbers.into_iter().flat_map(f64::to_le_bytes));
        }
        bytes.extend(self.velocity.to_array().into_iter().flat_map(f64::to_le_bytes));
        if let Some((places, turns)) = &self.head {
            places.write(bytes)?;
            turns.write(bytes)?;
        }
        Some(())
    }

    fn read(bytes: &[u8]) -> Option<Self> {
        let mut rest = bytes;
        let mut tail = Vec::new();
        for _ in 0..u64::from_le_bytes(take(&mut rest)?) {
            let ([time_s], middle) = (numbers(&mut rest)?, DVec3::from_array(numbers(&mut rest)?));
            tail.push(Pose { time_s, middle, turn: DQuat::from_array(numbers(&mut rest)?) });
        }
        tail.shrink_to_fit();
        let velocity = DVec3::from_array(numbers(&mut rest)?);
        let head =
            if rest.is_empty() { None } else { Some((Track::read(&mut rest)?, Track::read(&mut rest)?)) };
        Self { head, tail, velocity }.checked()
    }
}

/// Parts of a file; `None` if a leaf cannot be cached.
pub(super) fn encode<L: Kept>(leaves: &[L]) -> Option<Vec<Vec<u8>>> {
    let head = [L::MAGIC.as_slice(), &(leaves.len() as u64).to_le_bytes()].concat();
    let mut parts = vec![head];
    parts.par_extend(leaves.par_iter().map(|leaf| leaf_bytes(leaf).unwrap_or_default()));
    if parts.iter().any(Vec::is_empty) {
        return None;
    }
    // The checksum detects damage, not forgery.
    let mut hash = crc32fast::Hasher::new();
    parts.iter().for_each(|part| hash.update(part));
    parts.push(hash.finalize().to_le_bytes().to_vec());
    Some(parts)
}

/// Decodes a file; `None` unless `encode` can give it.
pub(super) fn decode<L: Kept>(file: impl Read) -> Option<Vec<L>> {
    let mut file = Hashing { file, hash: crc32fast::Hasher::new() };
    if &file.take::<16>()? != L::MAGIC {
        return None;
    }
    let (mut leaves, mut bytes) = (Vec::new(), Vec::new());
    for _ in 0..u64::from_le_bytes(file.take()?) {
        let length = u64::from_le_bytes(file.take()?);
        file.read(length, &mut bytes)?;
        leaves.push(L::read(&bytes)?);
    }
    let found = file.hash.clone().finalize();
    let whole = u32::from_le_bytes(file.take()?) == found && file.take::<1>().is_none();
    whole.then_some(leaves)
}

/// Reader that computes the CRC-32 of its bytes.
struct Hashing<R> {
    file: R,
    hash: crc32fast::Hasher,
}

impl<R: Read> Hashing<R> {
    fn take<const N: usize>(&mut self) -> Option<[u8; N]> {
        let bytes = take(&mut self.file)?;
        self.hash.update(&bytes);
        Some(bytes)
    }

    /// Replaces `bytes` by the next `length` bytes; it allocates no more than exist.
    fn read(&mut self, length: u64, bytes: &mut Vec<u8>) -> Option<()> {
        bytes.clear();
        let read = self.file.by_ref().take(length).read_to_end(bytes).ok()?;
        self.hash.update(bytes);
        (read as u64 == length).then_some(())
    }
}

/// Length and bytes of a leaf; `None` if it cannot be cached.
fn leaf_bytes(leaf: &impl Kept) -> Option<Vec<u8>> {
    let mut bytes = vec![0; size_of::<u64>()];
    leaf.write(&mut bytes)?;
    let length = (bytes.len() - size_of::<u64>()) as u64;
    bytes[..size_of::<u64>()].copy_from_slice(&length.to_le_bytes());
    Some(bytes)
}

pub(super) fn take<const N: usize>(file: &mut impl Read) -> Option<[u8; N]> {
    let mut bytes = [0; N];
    file.read_exact(&mut bytes).ok()?;
    Some(bytes)
}

fn numbers<const N: usize>(file: &mut impl Read) -> Option<[f64; N]> {
    let mut numbers = [0.0; N];
    for number in &mut numbers {
        *number = f64::from_le_bytes(take(file)?);
    }
    Some(numbers)
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::super::Fall;
    use super::super::tests::{calm, every_way, fall, level, storm};
    use super::*;

    fn few() -> Vec<Flown> {
        Fall { count: 20, ..fall(every_way(), storm(), level()) }.fly(&|_| {})
    }

    fn bytes_of(leaves: &[Flown]) -> Vec<u8> {
        encode(leaves).unwrap().concat()
    }

    #[test]
    fn what_is_kept_comes_back_to_the_last_bit() {
        let leaves = few();
        let bytes = bytes_of(&leaves);
        assert_eq!(decode::<Flown>(&bytes[..]).unwrap(), leaves);
        assert_eq!(decode::<Flown>(&bytes_of(&[])[..]).unwrap(), []);
        // Nothing is kept twice as large as need be.
        let keys = |leaf: &Flown| match &leaf.head {
            Some((places, turns)) => places.times_s().len() * 22 + turns.times_s().len() * 20,
            None => 0,
        };
        let most = leaves.iter().map(|leaf| keys(leaf) + leaf.tail.len() * 64 + 100).sum::<usize>();
        assert!(bytes.len() < most + 100, "{} {most}", bytes.len());
    }

    #[test]
    fn no_damaged_byte_is_trusted() {
        let bytes = bytes_of(&few()[..2]);
        for place in (0..bytes.len()).step_by(7) {
            let mut damaged = bytes.clone();
            damaged[place] ^= 1;
            assert!(decode::<Flown>(&damaged[..]).is_none(), "byte {place}");
        }
        for length in (0..bytes.len()).step_by(13) {
            assert!(decode::<Flown>(&bytes[..length]).is_none(), "{length} bytes");
        }
        // Nor is what has a checksum and does not hold together.
        for count in [3_u64, u64::MAX] {
            let mut content = bytes[..bytes.len() - 4].to_vec();
            content[Flown::MAGIC.len()..Flown::MAGIC.len() + 8].copy_from_slice(&count.to_le_bytes());
            let checksum = crc32fast::hash(&content);
            content.extend(checksum.to_le_bytes());
            assert!(decode::<Flown>(&content[..]).is_none(), "{count} leaves");
        }
    }

    #[test]
    fn names_tell_falls_apart() {
        let falls = [
            fall(every_way(), storm(), level()),
            fall(every_way(), calm(), level()),
            Fall { seed: 4, ..fall(every_way(), storm(), level()) },
            Fall { count: 201, ..fall(every_way(), storm(), level()) },
            Fall { speed_gain: (1.0 + f64::EPSILON).into(), ..fall(every_way(), storm(), level()) },
            Fall { motion: None, ..fall(every_way(), storm(), level()) },
        ];
        let names: std::collections::BTreeSet<String> = falls.iter().map(name_of).collect();
        assert_eq!(names.len(), falls.len());
        assert_eq!(name_of(&falls[0]), name_of(&fall(every_way(), storm(), level())));
    }
}
