//! Bakes as bytes, and back. In goes a fall, out come its flights, from where bakes are kept if they are
//! there. Invariant: what comes from there is what baking gives, to the last bit, or it is not taken. Its
//! name says what was baked and by which edition of this code. Its checksum says that nothing is damaged.
//!
//! Little-endian: `MAGIC`, number of leaves, of each leaf where it ends; the leaves'
//! flights; CRC-32 of all that.

use super::Fall;
use super::flown::Flown;
use super::leaf::Pose;
use crate::scene::baking::Baking;
use crate::scene::{Animate, Extend, Key, Segment, Track};
use glam::{DQuat, DVec3};
use rayon::prelude::*;
use sha2::{Digest, Sha256};
use std::fmt::{self, Write};

/// Edition, to be raised with every change of what falls give: old bakes have old names then.
pub(super) const EDITION: u32 = 3;
const MAGIC: &[u8; 16] = b"sunfleck bake 3\n";
const CHECKSUM_BYTES: usize = 4;
/// Fewer leaves are baked before a file is found.
const FEWEST: u32 = 1000;

impl Fall {
    /// Flights of all leaves, in order, out of the store if they are in it.
    pub(in crate::inside::scene) fn fly_or_recall(&self, baking: &Baking) -> Vec<Flown> {
        let tell = |done| (baking.tell)(done, self.count);
        if self.count < FEWEST {
            return self.fly(&tell);
        }
        let name = self.name();
        let recalled = (baking.recall)(&name).and_then(|bytes| decode(&bytes));
        if let Some(flown) = recalled.filter(|flown| flown.len() == self.count as usize) {
            return flown;
        }
        let flown = self.fly(&tell);
        (baking.keep)(&name, &encode(&flown));
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

pub(super) fn encode(leaves: &[Flown]) -> Vec<u8> {
    let bodies: Vec<Vec<u8>> = leaves.par_iter().map(leaf_bytes).collect();
    let mut bytes = MAGIC.to_vec();
    bytes.extend((leaves.len() as u64).to_le_bytes());
    let mut end = 0;
    for body in &bodies {
        end += body.len() as u64;
        bytes.extend(end.to_le_bytes());
    }
    for body in &bodies {
        bytes.extend_from_slice(body);
    }
    // Against damage, not against forgers, who may write their own leaves.
    let checksum = crc32fast::hash(&bytes);
    bytes.extend(checksum.to_le_bytes());
    bytes
}

/// `None` of anything that `encode` did not write.
pub(super) fn decode(bytes: &[u8]) -> Option<Vec<Flown>> {
    let (content, checksum) = bytes.split_at_checked(bytes.len().checked_sub(CHECKSUM_BYTES)?)?;
    if crc32fast::hash(content).to_le_bytes() != *checksum {
        return None;
    }
    let mut reader = Reader(content.strip_prefix(MAGIC)?);
    let count = usize::try_from(reader.integer()?).ok()?;
    let (ends, bodies) = reader.0.split_at_checked(count.checked_mul(8)?)?;
    let end = |leaf: usize| Reader(&ends[8 * leaf..]).integer().and_then(|end| usize::try_from(end).ok());
    (0..count)
        .into_par_iter()
        .map(|leaf| {
            let start = if leaf == 0 { 0 } else { end(leaf - 1)? };
            leaf_of(bodies.get(start..end(leaf)?)?)
        })
        .collect()
}

fn leaf_bytes(leaf: &Flown) -> Vec<u8> {
    let mut bytes = Vec::new();
    bytes.extend((leaf.tail.len() as u64).to_le_bytes());
    for pose in &leaf.tail {
        let numbers = [[pose.time_s].as_slice(), &pose.middle.to_array(), &pose.turn.to_array()].concat();
        bytes.extend(numbers.into_iter().flat_map(f64::to_le_bytes));
    }
    bytes.extend(leaf.velocity.to_array().into_iter().flat_map(f64::to_le_bytes));
    if let Some((places, turns)) = &leaf.head {
        push_track(places, &mut bytes);
        push_track(turns, &mut bytes);
    }
    bytes
}

fn leaf_of(bytes: &[u8]) -> Option<Flown> {
    let mut reader = Reader(bytes);
    let mut tail = Vec::new();
    for _ in 0..reader.integer()? {
        let (time_s, middle) = (reader.number()?, DVec3::from_array(reader.numbers()?));
        tail.push(Pose { time_s, middle, turn: DQuat::from_array(reader.numbers()?) });
    }
    let velocity = DVec3::from_array(reader.numbers()?);
    let head = if reader.0.is_empty() { None } else { Some((reader.track()?, reader.track()?)) };
    Flown { head, tail, velocity }.checked()
}

/// Times, values and slopes of a smooth track whose numbers are of single precision.
fn push_track<T: Animate>(track: &Track<T>, bytes: &mut Vec<u8>) {
    let keys = track.keys();
    bytes.extend((keys.len() as u64).to_le_bytes());
    let mut singles = Vec::with_capacity(2 * T::SINGLES);
    for key in keys {
        singles.clear();
        key.value.push_singles(&mut singles);
        let leave = if let Segment::Hermite { leave, .. } = key.to_next { leave } else { T::ZERO };
        leave.push_singles(&mut singles);
        bytes.extend(key.time_s.to_le_bytes());
        bytes.extend(singles.iter().flat_map(|single| single.to_le_bytes()));
    }
}

struct Reader<'a>(&'a [u8]);

impl Reader<'_> {
    fn take<const N: usize>(&mut self) -> Option<[u8; N]> {
        let (first, rest) = self.0.split_first_chunk()?;
        self.0 = rest;
        Some(*first)
    }

    fn integer(&mut self) -> Option<u64> {
        self.take().map(u64::from_le_bytes)
    }

    fn number(&mut self) -> Option<f64> {
        self.take().map(f64::from_le_bytes)
    }

    fn numbers<const N: usize>(&mut self) -> Option<[f64; N]> {
        let mut numbers = [0.0; N];
        for number in &mut numbers {
            *number = self.number()?;
        }
        Some(numbers)
    }

    fn value<T: Animate>(&mut self) -> Option<T> {
        let mut singles = [0.0; 4];
        for single in &mut singles[..T::SINGLES] {
            *single = f32::from_le_bytes(self.take()?);
        }
        Some(T::from_singles(&singles[..T::SINGLES]))
    }

    fn track<T: Animate>(&mut self) -> Option<Track<T>> {
        let count = usize::try_from(self.integer()?).ok()?;
        let mut keys: Vec<Key<T>> = Vec::new();
        for _ in 0..count {
            let (time_s, value, leave) = (self.number()?, self.value()?, self.value()?);
            if let Some(Key { to_next: Segment::Hermite { arrive, .. }, .. }) = keys.last_mut() {
                *arrive = leave;
            }
            keys.push(Key { time_s, value, to_next: Segment::Hermite { leave, arrive: T::ZERO } });
        }
        Track::new(keys, Extend::Hold)
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::super::tests::{calm, every_way, fall, level, storm};
    use super::*;
    use std::cell::{Cell, RefCell};
    use std::collections::BTreeMap;

    fn few() -> Vec<Flown> {
        Fall { count: 20, ..fall(every_way(), storm(), level()) }.fly(&|_| {})
    }

    #[test]
    fn what_is_kept_comes_back_to_the_last_bit() {
        let leaves = few();
        let bytes = encode(&leaves);
        assert_eq!(decode(&bytes).unwrap(), leaves);
        assert_eq!(decode(&encode(&[])).unwrap(), []);
        // Single precision: nothing is kept twice as large as need be.
        let keys = |leaf: &Flown| match &leaf.head {
            Some((places, turns)) => places.times_s().len() * 32 + turns.times_s().len() * 40,
            None => 0,
        };
        let most = leaves.iter().map(|leaf| keys(leaf) + leaf.tail.len() * 64 + 100).sum::<usize>();
        assert!(bytes.len() < most + 100, "{} {most}", bytes.len());
    }

    #[test]
    fn no_damaged_byte_is_trusted() {
        let bytes = encode(&few()[..2]);
        for place in (0..bytes.len()).step_by(7) {
            let mut damaged = bytes.clone();
            damaged[place] ^= 1;
            assert!(decode(&damaged).is_none(), "byte {place}");
        }
        for length in (0..bytes.len()).step_by(13) {
            assert!(decode(&bytes[..length]).is_none(), "{length} bytes");
        }
        // Nor is what has a checksum and does not hold together.
        for count in [3_u64, u64::MAX] {
            let mut content = bytes[..bytes.len() - CHECKSUM_BYTES].to_vec();
            content[MAGIC.len()..MAGIC.len() + 8].copy_from_slice(&count.to_le_bytes());
            let checksum = crc32fast::hash(&content);
            content.extend(checksum.to_le_bytes());
            assert!(decode(&content).is_none(), "{count} leaves");
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
        let (kept, baked) = (RefCell::new(BTreeMap::new()), Cell::new(0));
        let recall = |name: &str| kept.borrow().get(name).cloned();
        let keep = |name: &str, bytes: &[u8]| {
            baked.set(baked.get() + 1);
            kept.borrow_mut().insert(name.to_owned(), bytes.to_vec());
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
            kept.borrow_mut().insert(many.name(), encode(&foreign));
            assert_eq!((many.fly_or_recall(&baking), baked.get()), (flown.clone(), bakes));
        }
    }
}
