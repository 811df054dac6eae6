//! Leaves that come to rest on each other. In go falls that share a ground, with the flights of their leaves;
//! out come the leaves. Invariant: a leaf rests on the ground and on leaves that landed before it,
//! independent of threads; later ones do not move it.
//!
//! Leaves are stiff, and rest on a height field ([`Heap`]); docs/decisions/falling.md lists the limitations.

use super::flown::Flown;
use super::ground::Ground;
use super::heap::{Heap, Lie, Sheet};
use super::landing::{self, LEAST_INTERVAL_S, Settling};
use super::leaf::{Leaf, Pose};
use super::{Fall, Look, lean};
use crate::scene::Track;
use glam::{DQuat, DVec2, DVec3};
use rayon::prelude::*;
use std::mem;

/// Number of iterations of a leaf's lean, each with the heights under its current pose.
const LEANS: usize = 3;
/// Maximum slope of a leaf relative to its pose on bare ground.
const MOST_LEAN: f64 = 0.8;

/// Leaves that land before their tracks are built, to limit memory.
const LANDINGS_AT_A_TIME: usize = 256;

/// Keys of a leaf, until it rests if it lands.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct AtRest {
    pub(super) translation: Track<DVec3>,
    pub(super) rotation: Track<DQuat>,
    /// False if the wind kept it up until the time limit.
    pub(super) landed: bool,
}

/// Landing of a leaf: the number of poses of its tail before the touch, the touch, and the settling.
struct Landing {
    until: usize,
    touch: Pose,
    settling: Settling,
}

/// Leaves of each fall, in their order; `None` without a pose. `falls` share one ground.
pub(super) fn come_to_rest(mut falls: Vec<(&Fall, Vec<Flown>)>) -> Vec<Vec<Option<AtRest>>> {
    let mut heap =
        Heap::new(falls.iter().flat_map(|(fall, _)| fall.species.iter().map(|kind| kind.length_m)));
    let sheets: Vec<Vec<Vec<Sheet>>> = (falls.iter())
        .map(|(fall, _)| {
            let of = |kind: &super::Species| {
                let sheet = |shape| heap.sheet(shape, kind.length_m.1 / shape.size.z);
                kind.outlines.iter().map(sheet).collect()
            };
            fall.species.iter().map(of).collect()
        })
        .collect();
    let mut order: Vec<(f64, usize, usize)> = Vec::new();
    for (block, (_, flown)) in falls.iter().enumerate() {
        let touches = flown.iter().enumerate();
        order.extend(touches.filter_map(|(number, flown)| Some((flown.tail.last()?.time_s, block, number))));
    }
    order.sort_by(|a, b| a.0.total_cmp(&b.0).then((a.1, a.2).cmp(&(b.1, b.2))));
    let mut at_rest: Vec<Vec<Option<AtRest>>> =
        (falls.iter_mut()).map(|(_, flown)| flown.par_iter_mut().map(never_landed).collect()).collect();
    for part in order.chunks(LANDINGS_AT_A_TIME) {
        let landed = part.iter().map(|&(_, block, number)| {
            let fall = falls[block].0;
            let flown = mem::take(&mut falls[block].1[number]);
            let Look { species, outline, scale, .. } = fall.look(number as u32);
            let sheet = sheets[block][species][outline].scaled(scale);
            let landing = land(fall, &fall.leaf(number as u32), &sheet, &flown, &heap);
            heap.lay(&sheet, lie(&landing.settling.rest));
            (block, number, flown, landing)
        });
        let landed: Vec<_> = landed.collect();
        let leaves: Vec<_> = (landed.into_par_iter())
            .map(|(block, number, flown, landing)| {
                (block, number, falls[block].0.landed(number as u32, flown, landing))
            })
            .collect();
        for (block, number, leaf) in leaves {
            at_rest[block][number] = leaf;
        }
    }
    at_rest
}

/// Leaf that is still in the air at the end; `None` if it landed or has no pose.
fn never_landed(flown: &mut Flown) -> Option<AtRest> {
    if !flown.tail.is_empty() {
        return None;
    }
    let (translation, rotation) = flown.head.take()?;
    Some(AtRest { translation, rotation, landed: false })
}

impl Fall {
    /// Leaf that landed; `None` without a pose.
    fn landed(&self, number: u32, flown: Flown, landing: Landing) -> Option<AtRest> {
        let Landing { until, touch, settling } = landing;
        let settling = settling.poses(&self.leaf(number), &self.ground);
        let (middle, tolerance) = self.keyed_as(number);
        let (translation, rotation) = flown.into_rest(until, touch, settling, middle, tolerance)?;
        Some(AtRest { translation, rotation, landed: true })
    }
}

fn land(fall: &Fall, leaf: &Leaf, sheet: &Sheet, flown: &Flown, heap: &Heap) -> Landing {
    let last = flown.tail.len() - 1;
    let (until, touch, velocity) = first_meeting(leaf, sheet, flown, heap).map_or_else(
        || (last, flown.tail[last], flown.velocity),
        |(at, touch)| {
            let (before, after) = (flown.tail[at], flown.tail[at + 1]);
            let velocity = (after.middle - before.middle) / (after.time_s - before.time_s);
            // Keys keep their minimum interval.
            let apart = touch.time_s - before.time_s >= LEAST_INTERVAL_S;
            if apart { (at + 1, touch, velocity) } else { (at, before, velocity) }
        },
    );
    let mut settling = Settling::new(leaf, fall.surroundings(), touch, velocity, 0.5 * leaf.interval_s());
    settling.rest = rest(leaf, sheet, settling.rest, heap, &fall.ground);
    Landing { until, touch, settling }
}

/// First touch of a leaf with the heap, and the pose of its tail before it.
fn first_meeting(leaf: &Leaf, sheet: &Sheet, flown: &Flown, heap: &Heap) -> Option<(usize, Pose)> {
    let is_below = |pose: &Pose| {
        let lowest_m = pose.middle.y - leaf.reach_m - leaf.clearance_m;
        heap.may_reach(pose.middle, leaf.reach_m, lowest_m)
            && pose.middle.y < heap.lowest_height_m(sheet, lie(pose)) + leaf.clearance_m
    };
    let first = flown.first();
    let own = &flown.tail[first..];
    if own.len() > 1 && is_below(&own[0]) {
        return Some((first, own[0]));
    }
    let mut ways = own.windows(2).enumerate();
    ways.find_map(|(at, way)| Some((first + at, landing::first_below(way[0], way[1], is_below)?)))
}

fn rest(leaf: &Leaf, sheet: &Sheet, bare: Pose, heap: &Heap, ground: &Ground) -> Pose {
    if heap.lowest_height_m(sheet, lie(&bare)) == f64::NEG_INFINITY {
        return bare;
    }
    let own_weight = sheet.mean();
    let (mut lowest_m, mut rest, mut lean) = (f64::INFINITY, bare, DVec2::ZERO);
    for _ in 0..=LEANS {
        let up = DVec3::new(-lean.x, 1.0, -lean.y).normalize();
        let turn = DQuat::from_rotation_arc(DVec3::Y, up) * bare.turn;
        let rises = heap.rises(sheet, lie(&Pose { turn, ..bare }), ground);
        let rise = rises.iter().map(|rise| rise.y).fold(f64::NEG_INFINITY, f64::max) + leaf.clearance_m;
        let weight = turn * own_weight;
        if rise + weight.y < lowest_m {
            lowest_m = rise + weight.y;
            rest = Pose { turn, middle: bare.middle + DVec3::Y * rise, ..bare };
        }
        let from_weight: Vec<DVec3> =
            rises.iter().map(|&rise| rise - DVec3::new(weight.x, 0.0, weight.z)).collect();
        lean = (lean + lean::slopes(&from_weight)).clamp_length_max(MOST_LEAN);
    }
    rest.middle.y = rest.middle.y.max(landing::lowest_height_m(leaf, ground, &rest));
    rest
}

fn lie(pose: &Pose) -> Lie {
    Lie { middle: pose.middle, turn: pose.turn }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::super::Emitter;
    use super::super::tests::{calm, every_way, fall, level, storm};
    use super::*;

    /// Two falls onto half a square metre.
    fn crowd() -> [Fall; 2] {
        let emitter = Emitter::Box(DVec3::new(-0.35, 1.0, -0.35), DVec3::new(0.35, 1.2, 0.35));
        let one = Fall { count: 100, emitter, ..fall(every_way(), calm(), level()) };
        [Fall { seed: 8, ..one.clone() }, one]
    }

    /// Leaves of each fall at rest: each was somewhere.
    fn lying(falls: Vec<(&Fall, Vec<Flown>)>) -> Vec<Vec<AtRest>> {
        come_to_rest(falls).into_iter().map(|leaves| leaves.into_iter().flatten().collect()).collect()
    }

    fn flown(falls: &[Fall]) -> Vec<(&Fall, Vec<Flown>)> {
        falls.iter().map(|fall| (fall, fall.fly(&|_| {}))).collect()
    }

    /// Leaves of which only some ever land.
    fn up_in_the_air(flown: &[Flown], lands: impl Fn(usize) -> bool) -> Vec<Flown> {
        let head = flown.iter().find_map(|leaf| leaf.head.clone());
        let gone = Flown { head, tail: Vec::new(), velocity: DVec3::ZERO };
        let leaves = flown.iter().enumerate();
        leaves.map(|(number, leaf)| if lands(number) { leaf.clone() } else { gone.clone() }).collect()
    }

    /// A mesh as it lies.
    fn triangles(fall: &Fall, number: u32, leaf: &AtRest) -> Vec<[DVec3; 3]> {
        let Look { shape, scale, .. } = fall.look(number);
        let (place, turn) = (leaf.translation.at(1e4), leaf.rotation.at(1e4));
        let in_the_world = |corner: DVec3| place + turn * ((corner + shape.middle) * scale);
        shape.triangles.iter().map(|corners| corners.map(in_the_world)).collect()
    }

    /// Depth of a leaf below the upper side of another, over its length.
    fn depth(leaf: &[[DVec3; 3]], other: &[[DVec3; 3]], length_m: f64) -> f64 {
        let samples = leaf.iter().flat_map(|[a, b, c]| {
            (0..=20)
                .flat_map(move |i| (0..=20 - i).map(move |j| (0.05 * f64::from(i), 0.05 * f64::from(j))))
                .map(move |(u, v)| *a * (1.0 - u - v) + *b * u + *c * v)
        });
        let below = samples.flat_map(|point| {
            other.iter().filter_map(move |&triangle| {
                Some(super::super::ground::height_in(triangle, DVec2::new(point.x, point.z))? - point.y)
            })
        });
        below.fold(0.0_f64, f64::max) / length_m
    }

    /// The deepest that any leaf is below one that landed before, and how many are at all.
    fn deepest(falls: &[(&Fall, Vec<Flown>)], fallen: &[Vec<AtRest>]) -> (f64, usize) {
        let mut leaves = Vec::new();
        for ((fall, flown), fallen) in falls.iter().zip(fallen) {
            for (number, (flown, leaf)) in (0..).zip(flown.iter().zip(fallen)) {
                let Look { length_m, .. } = fall.look(number);
                leaves.push((flown.tail.last().unwrap().time_s, triangles(fall, number, leaf), length_m));
            }
        }
        leaves.sort_by(|a, b| a.0.total_cmp(&b.0));
        let pairs = (0..leaves.len()).flat_map(|later| (0..later).map(move |earlier| (later, earlier)));
        let depths: Vec<f64> = pairs
            .map(|(later, earlier)| depth(&leaves[later].1, &leaves[earlier].1, leaves[later].2))
            .filter(|&depth| depth > 0.0)
            .collect();
        (depths.iter().copied().fold(0.0, f64::max), depths.len())
    }

    #[test]
    fn leaves_lie_on_each_other_and_not_through() {
        let falls = crowd();
        let together = flown(&falls);
        let (deepest_together, pairs) = deepest(&together, &lying(together.clone()));
        // Each as if there were no others.
        let apart: Vec<Vec<AtRest>> = (together.iter())
            .map(|(fall, flown)| {
                let alone = |number: usize| {
                    let others = up_in_the_air(flown, |other| other == number);
                    lying(vec![(*fall, others)]).remove(0).swap_remove(number)
                };
                (0..flown.len()).map(alone).collect()
            })
            .collect();
        let (deepest_apart, pairs_apart) = deepest(&together, &apart);
        assert!(deepest_apart > 0.1 && pairs_apart > 50, "{deepest_apart} {pairs_apart}");
        assert!(deepest_together < 0.01 && pairs * 20 < pairs_apart, "{deepest_together} {pairs}");
    }

    #[test]
    fn later_leaves_move_none_that_lies() {
        let falls = crowd();
        let all = flown(&falls);
        let all_lie = lying(all.clone());
        let until_s = 4.0;
        let early = |flown: &Flown| flown.tail.last().unwrap().time_s < until_s;
        let fewer: Vec<(&Fall, Vec<Flown>)> = (all.iter())
            .map(|(fall, flown)| (*fall, up_in_the_air(flown, |number| early(&flown[number]))))
            .collect();
        let mut compared = 0;
        for ((then, now), (_, flown)) in lying(fewer).iter().zip(&all_lie).zip(&all) {
            for ((then, now), _) in then.iter().zip(now).zip(flown).filter(|(_, flown)| early(flown)) {
                assert_eq!(then, now);
                compared += 1;
            }
        }
        assert!((50..190).contains(&compared), "{compared}");
    }

    #[test]
    fn no_leaf_pops_onto_the_others() {
        for (wind, bar_m_per_s) in [(calm(), 4.0), (storm(), 10.0)] {
            let falls = crowd().map(|fall| Fall { wind: wind.clone(), ..fall });
            let all = flown(&falls);
            for (fallen, (_, flown)) in lying(all.clone()).iter().zip(&all) {
                for (leaf, flown) in fallen.iter().zip(flown) {
                    let lands_s = flown.tail.last().unwrap().time_s;
                    let place = |moment: i32| leaf.translation.at(lands_s + f64::from(moment) / 480.0);
                    for moment in -240..480 {
                        let speed = (place(moment + 1) - place(moment)).length() * 480.0;
                        // What the air does to them: see `leaves_neither_jump_nor_flip`.
                        assert!(speed < bar_m_per_s, "{speed} m/s");
                    }
                }
            }
        }
    }

    #[test]
    fn heaps_are_the_same_on_any_number_of_threads() {
        let falls = crowd();
        let on = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| lying(flown(&falls)))
        };
        assert_eq!(on(1), on(3));
    }
}
