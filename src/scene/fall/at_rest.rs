//! Falls that share a ground, until all their leaves rest. In go falls, out come their leaves, computed or
//! from the cache. Invariant: the cached result of several falls is valid while none of them changes. Their
//! flights are cached one by one, so a change of one fall keeps the flights of the others.

use super::kept::{Kept, name_of, recalled, take};
use super::pile::{AtRest, come_to_rest};
use super::{Fall, Fallen, Look};
use crate::scene::Track;
use crate::scene::baking::Baking;

/// Leaves of each fall, in their order. `falls` share one ground.
pub(in crate::inside::scene) fn at_rest(falls: &[&Fall], baking: &Baking) -> Vec<Vec<Fallen>> {
    let names: Vec<String> = falls.iter().map(name_of).collect();
    let count = falls.iter().map(|fall| fall.count as usize).sum();
    let fly = |fall: &Fall, name: &str| match falls.len() {
        1 => fall.fly_and_tell(baking),
        _ => recalled(name, fall.count as usize, baking, || fall.fly_and_tell(baking)),
    };
    let leaves = recalled(&name_of(&names), count, baking, || {
        let flown = falls.iter().zip(&names).map(|(&fall, name)| (fall, fly(fall, name)));
        come_to_rest(flown.collect()).into_iter().flatten().collect()
    });
    let mut leaves = leaves.into_iter();
    let of = |fall: &&Fall| {
        let own = (0..fall.count).zip(leaves.by_ref());
        own.filter_map(|(number, leaf)| Some(fall.fallen(number, leaf?))).collect()
    };
    falls.iter().map(of).collect()
}

impl Fall {
    fn fallen(&self, number: u32, AtRest { translation, rotation, landed }: AtRest) -> Fallen {
        let Look { species, outline, material, scale, release_s, .. } = self.look(number);
        Fallen { species, outline, material, scale, translation, rotation, release_s, landed }
    }
}

/// `None` is a leaf without a pose.
impl Kept for Option<AtRest> {
    const MAGIC: &[u8; 16] = b"sunfleck rest 4\n";

    fn write(&self, bytes: &mut Vec<u8>) -> Option<()> {
        let Some(AtRest { translation, rotation, landed }) = self else { return Some(()) };
        bytes.push(u8::from(*landed));
        translation.write(bytes)?;
        rotation.write(bytes)
    }

    fn read(mut bytes: &[u8]) -> Option<Self> {
        if bytes.is_empty() {
            return Some(None);
        }
        let [landed] = take(&mut bytes)?;
        let (translation, rotation) = (Track::read(&mut bytes)?, Track::read(&mut bytes)?);
        bytes.is_empty().then_some(Some(AtRest { translation, rotation, landed: landed != 0 }))
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::super::kept::encode;
    use super::super::tests::{calm, every_way, fall, level};
    use super::*;
    use crate::scene::Key;
    use glam::{DQuat, DVec3};
    use std::cell::RefCell;
    use std::collections::BTreeMap;
    use std::io::{Cursor, Read};

    fn some(count: u32, seed: u32) -> Fall {
        Fall { count, seed, release_s: (0.0, 0.0), ..fall(every_way(), calm(), level()) }
    }

    /// Places, turns, and whether a leaf landed.
    type Keys = (Vec<Key<DVec3>>, Vec<Key<DQuat>>, bool);

    /// Keys of all leaves, in however many pieces they are kept.
    fn keys(leaves: Vec<Vec<Fallen>>) -> Vec<Keys> {
        let of = |leaf: Fallen| (leaf.translation.keys(), leaf.rotation.keys(), leaf.landed);
        leaves.into_iter().flatten().map(of).collect()
    }

    /// Files by their names, and how many were kept so far.
    #[derive(Default)]
    struct Store(RefCell<(BTreeMap<String, Vec<u8>>, usize)>);

    impl Store {
        fn at_rest(&self, falls: &[&Fall]) -> Vec<Keys> {
            let recall = |name: &str| {
                let bytes = self.0.borrow().0.get(name)?.clone();
                Some(Box::new(Cursor::new(bytes)) as Box<dyn Read>)
            };
            let keep = |name: &str, parts: &[&[u8]]| {
                let (files, kept) = &mut *self.0.borrow_mut();
                files.insert(name.to_owned(), parts.concat());
                *kept += 1;
            };
            keys(at_rest(falls, &Baking { tell: &|_, _| {}, recall: &recall, keep: &keep }))
        }

        fn kept(&self) -> usize {
            self.0.borrow().1
        }
    }

    #[test]
    fn leaves_at_rest_are_recalled_and_other_leaves_are_not_taken() {
        let (store, many) = (Store::default(), some(20, 3));
        let leaves = store.at_rest(&[&many]);
        assert_eq!(leaves, keys(at_rest(&[&many], &Baking::ALONE)));
        assert_eq!((store.at_rest(&[&many]), store.kept()), (leaves.clone(), 1));
        // Few leaves are not worth a file.
        store.at_rest(&[&some(19, 3)]);
        assert_eq!(store.kept(), 1);
        // Flights, and too few leaves, under the right name and checksum.
        let flights = encode(&many.fly_and_tell(&Baking::ALONE)).unwrap().concat();
        let too_few = encode(&vec![None::<AtRest>; 19]).unwrap().concat();
        for (foreign, kept) in [(flights, 2), (too_few, 3)] {
            store.0.borrow_mut().0.values_mut().for_each(|file| file.clone_from(&foreign));
            assert_eq!((store.at_rest(&[&many]), store.kept()), (leaves.clone(), kept));
        }
    }

    #[test]
    fn a_fall_that_changes_leaves_the_flights_of_others() {
        let (store, [one, other, new]) = (Store::default(), [3, 4, 5].map(|seed| some(20, seed)));
        store.at_rest(&[&one, &other]);
        assert_eq!(store.kept(), 3);
        let leaves = store.at_rest(&[&one, &new]);
        assert_eq!(store.kept(), 5);
        assert_eq!(leaves, keys(at_rest(&[&one, &new], &Baking::ALONE)));
        assert_eq!((store.at_rest(&[&one, &new]), store.kept()), (leaves, 5));
    }
}
