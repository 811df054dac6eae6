//! Bakes as bytes, and back. In goes a fall, out come its flights, from where bakes are kept if they are
//! there. Invariant: what comes from there is what baking gives, to the last bit, or it is not taken. Its
//! name says what was baked and by which edition of this code. Its checksum says that nothing is damaged.
//!
//! Little-endian: `MAGIC`, number of leaves, of each leaf its number of bytes and its flight; CRC-32 of all
//! that. Nothing is in memory twice: flights are read one after another.

use super::Fall;
use super::flown::Flown;
use super::leaf::Pose;
use crate::scene::Track;
use crate::scene::baking::Baking;
use glam::{DQuat, DVec3};
use rayon::prelude::*;
use sha2::{Digest, Sha256};
use std::fmt::{self, Write};
use std::io::Read;

/// Edition, to be raised with every change of what falls give: old bakes have old names then.
pub(super) const EDITION: u32 = 4;
const MAGIC: &[u8; 16] = b"sunfleck bake 4\n";
/// Fewer leaves are baked before a file is found.
const FEWEST: u32 = 20;

impl Fall {
    /// Flights of all leaves, in order, out of the store if they are in it.
    pub(in crate::inside::scene) fn fly_or_recall(&self, baking: &Baking) -> Vec<Flown> {
        let tell = |done| (baking.tell)(done, self.count);
        if self.count < FEWEST {
            return self.fly(&tell);
        }
        let name = self.name();
        let recalled = (baking.recall)(&name).and_then(decode);
        if let Some(flown) = recalled.filter(|flown| flown.len() == self.count as usize) {
            return flown;
        }
        let flown = self.fly(&tell);
        if let Some(parts) = encode(&flown) {
            (baking.keep)(&name, &parts.iter().map(Vec::as_slice).collect::<Vec<_>>());
        }
        flown
    }

    /// Name by all that flights depend on.
    pub(super) fn name(&self) -> String {
        let mut hash = Hashed(Sha256::new());
        // Shortest decimals give numbers back to the last bit, so that they tell all numbers apart.
        let written = write!(hash, "{EDITION} {self:?}");
        debug_assert!(written.is_ok());
        hash.0.finalize().iter().map(|byte| format!("{byte:02x}")).collect()
    }
}

struct Hashed(Sha256);

impl Write for Hashed {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        self.0.update(text);
        Ok(())
    }
}

/// Parts of a file; `None` if a flight has keys beyond what tracks keep in few bytes.
pub(super) fn encode(leaves: &[Flown]) -> Option<Vec<Vec<u8>>> {
    let head = [MAGIC.as_slice(), &(leaves.len() as u64).to_le_bytes()].concat();
    let mut parts = vec![head];
    parts.par_extend(leaves.par_iter().map(|leaf| leaf_bytes(leaf).unwrap_or_default()));
    if parts.iter().any(Vec::is_empty) {
        return None;
    }
    // Against damage, not against forgers, who may write their own leaves.
    let mut hash = crc32fast::Hasher::new();
    parts.iter().for_each(|part| hash.update(part));
    parts.push(hash.finalize().to_le_bytes().to_vec());
    Some(parts)
}

/// `None` of anything that `encode` did not write.
pub(super) fn decode(file: impl Read) -> Option<Vec<Flown>> {
    let mut file = Hashing { file, hash: crc32fast::Hasher::new() };
    if &file.take::<16>()? != MAGIC {
        return None;
    }
    let (mut leaves, mut bytes) = (Vec::new(), Vec::new());
    for _ in 0..u64::from_le_bytes(file.take()?) {
        let length = u64::from_le_bytes(file.take()?);
        file.read(length, &mut bytes)?;
        leaves.push(leaf_of(&bytes)?);
    }
    let found = file.hash.clone().finalize();
    let whole = u32::from_le_bytes(file.take()?) == found && file.take::<1>().is_none();
    whole.then_some(leaves)
}

/// A file, and the CRC-32 of what has been read of it.
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

    /// Replaces `bytes` by the next so many: no more room is made than there are.
    fn read(&mut self, length: u64, bytes: &mut Vec<u8>) -> Option<()> {
        bytes.clear();
        let read = self.file.by_ref().take(length).read_to_end(bytes).ok()?;
        self.hash.update(bytes);
        (read as u64 == length).then_some(())
    }
}

/// Its number of bytes and those; `None` of a flight that is not kept.
fn leaf_bytes(leaf: &Flown) -> Option<Vec<u8>> {
    let mut bytes = vec![0; LENGTH];
    bytes.extend((leaf.tail.len() as u64).to_le_bytes());
    for pose in &leaf.tail {
        let numbers = [[pose.time_s].as_slice(), &pose.middle.to_array(), &pose.turn.to_array()].concat();
        bytes.extend(numbers.into_iter().flat_map(f64::to_le_bytes));
    }
    bytes.extend(leaf.velocity.to_array().into_iter().flat_map(f64::to_le_bytes));
    if let Some((places, turns)) = &leaf.head {
        places.write(&mut bytes)?;
        turns.write(&mut bytes)?;
    }
    let length = (bytes.len() - LENGTH) as u64;
    bytes[..LENGTH].copy_from_slice(&length.to_le_bytes());
    Some(bytes)
}

const LENGTH: usize = size_of::<u64>();

fn leaf_of(bytes: &[u8]) -> Option<Flown> {
    let mut rest = bytes;
    let mut tail = Vec::new();
    for _ in 0..u64::from_le_bytes(take(&mut rest)?) {
        let ([time_s], middle) = (numbers(&mut rest)?, DVec3::from_array(numbers(&mut rest)?));
        tail.push(Pose { time_s, middle, turn: DQuat::from_array(numbers(&mut rest)?) });
    }
    tail.shrink_to_fit();
    let velocity = DVec3::from_array(numbers(&mut rest)?);
    let head = if rest.is_empty() { None } else { Some((Track::read(&mut rest)?, Track::read(&mut rest)?)) };
    Flown { head, tail, velocity }.checked()
}

fn take<const N: usize>(file: &mut impl Read) -> Option<[u8; N]> {
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
    use super::super::tests::{calm, every_way, fall, level, storm};
    use super::*;
    use std::cell::{Cell, RefCell};
    use std::collections::BTreeMap;
    use std::io::Cursor;

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
        assert_eq!(decode(&bytes[..]).unwrap(), leaves);
        assert_eq!(decode(&bytes_of(&[])[..]).unwrap(), []);
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
            assert!(decode(&damaged[..]).is_none(), "byte {place}");
        }
        for length in (0..bytes.len()).step_by(13) {
            assert!(decode(&bytes[..length]).is_none(), "{length} bytes");
        }
        // Nor is what has a checksum and does not hold together.
        for count in [3_u64, u64::MAX] {
            let mut content = bytes[..bytes.len() - 4].to_vec();
            content[MAGIC.len()..MAGIC.len() + 8].copy_from_slice(&count.to_le_bytes());
            let checksum = crc32fast::hash(&content);
            content.extend(checksum.to_le_bytes());
            assert!(decode(&content[..]).is_none(), "{count} leaves");
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
        let names: std::collections::BTreeSet<String> = falls.iter().map(Fall::name).collect();
        assert_eq!(names.len(), falls.len());
        assert_eq!(falls[0].name(), fall(every_way(), storm(), level()).name());
    }

    #[test]
    fn a_bake_is_recalled_and_another_falls_leaves_are_not_taken() {
        let (many, other) = (
            Fall { count: FEWEST, release_s: (0.0, 0.0), ..fall(every_way(), calm(), level()) },
            Fall { count: FEWEST - 1, ..fall(every_way(), calm(), level()) },
        );
        let (kept, baked) = (RefCell::new(BTreeMap::<String, Vec<u8>>::new()), Cell::new(0));
        let recall = |name: &str| {
            let bytes = kept.borrow().get(name)?.clone();
            Some(Box::new(Cursor::new(bytes)) as Box<dyn Read>)
        };
        let keep = |name: &str, parts: &[&[u8]]| {
            baked.set(baked.get() + 1);
            kept.borrow_mut().insert(name.to_owned(), parts.concat());
        };
        let baking = Baking { tell: &|_, _| {}, recall: &recall, keep: &keep };
        let flown = many.fly_or_recall(&baking);
        assert_eq!((many.fly_or_recall(&baking), baked.get()), (flown.clone(), 1));
        // Few leaves are not worth a file.
        other.fly_or_recall(&baking);
        assert_eq!(baked.get(), 1);
        // Leaves that were never anywhere, and too few of them, under the right name and checksum.
        let nowhere: Vec<Flown> =
            flown.iter().map(|leaf| Flown { head: None, tail: Vec::new(), ..leaf.clone() }).collect();
        for (foreign, bakes) in [(nowhere, 2), (flown[1..].to_vec(), 3)] {
            kept.borrow_mut().insert(many.name(), bytes_of(&foreign));
            assert_eq!((many.fly_or_recall(&baking), baked.get()), (flown.clone(), bakes));
        }
    }
}
