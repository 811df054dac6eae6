//! Keyed values. In go keys of a file, out come tracks in SI units. Invariant: a track stays within its
//! field's range between keys too, as the control points of all its curves do.

use super::problems::Problems;
use crate::description::ron::{self, Animated, Degrees, Keyable, Keys, Quaternion, ToNext, Vector};
use crate::scene::{Animate, Handle, Key, Rotation, Segment, Track};
use glam::DQuat;

pub(super) fn track<T: Keyable<Si: Animate>>(
    keyed: &Animated<T>,
    field: &str,
    problems: &mut Problems,
) -> Option<Track<T::Si>> {
    let keys = match keyed {
        Animated::Still(value) => return Some(Track::from(value.si())),
        Animated::Keyed(keys) => keys,
    };
    check(keys, field, problems)?;
    Track::new(keys.keys.iter().map(resolved).collect(), keys.extend)
}

/// Rotation from either of its two forms; `None` without, or with both.
pub(super) fn rotation(
    degrees: Option<&Animated<Vector<Degrees>>>,
    quaternion: Option<&Animated<Quaternion>>,
    owner: &str,
    problems: &mut Problems,
) -> Option<Rotation> {
    match (degrees, quaternion) {
        (None, None) => Some(Rotation::Quaternion(DQuat::IDENTITY.into())),
        (Some(angles), None) => {
            track(angles, &format!("{owner}.rotation_deg"), problems).map(Rotation::EulerXyz)
        }
        (None, Some(turn)) => {
            track(turn, &format!("{owner}.rotation_quaternion"), problems).map(Rotation::Quaternion)
        }
        (Some(_), Some(_)) => {
            problems.error(
                owner,
                "the rotation is given twice",
                "either `rotation_deg` or `rotation_quaternion`",
                "take one of the two out",
            );
            None
        }
    }
}

fn check<T: Keyable<Si: Animate>>(keys: &Keys<T>, field: &str, problems: &mut Problems) -> Option<()> {
    if keys.keys.is_empty() {
        problems.error(field, "there are no keys", "at least one key", "add a key, or write a plain value");
        return None;
    }
    let mut valid = true;
    for (index, pair) in keys.keys.windows(2).enumerate() {
        let (from_s, to_s) = (pair[0].at_s.si(), pair[1].at_s.si());
        if from_s >= to_s {
            valid = false;
            let found = format!("the key at {to_s} s follows the key at {from_s} s");
            let path = format!("{field}.keys[{}].at_s", index + 1);
            problems.error(&path, found, "times that increase from key to key", "sort the keys by time");
            continue;
        }
        let path = format!("{field}.keys[{index}].to_next");
        if let ToNext::Bezier { leave, arrive } = pair[0].to_next
            && (leave.at_s.si() < from_s || arrive.at_s.si() > to_s)
        {
            valid = false;
            let expected = format!("`leave` not before {from_s} s, and `arrive` not after {to_s} s");
            let found = "a handle lies on the wrong side of its key";
            problems.error(&path, found, &expected, "move the handle to the side of its curve");
        }
        let inner = resolved(&pair[0]).inner_control_points(&resolved(&pair[1]));
        if !inner.into_iter().all(T::admits) {
            valid = false;
            let found = "the curve to the next key may leave the field's range";
            problems.error(&path, found, T::EXPECTED, "make the slopes less steep, or use `Linear`");
        }
    }
    valid.then_some(())
}

fn resolved<T: Keyable<Si: Animate>>(key: &ron::Key<T>) -> Key<T::Si> {
    let handle = |handle: ron::Handle<T>| Handle { time_s: handle.at_s.si(), value: handle.value.si() };
    Key {
        time_s: key.at_s.si(),
        value: key.value.si(),
        to_next: match key.to_next {
            ToNext::Step => Segment::Step,
            ToNext::Linear => Segment::Linear,
            ToNext::Hermite { leave_per_s, arrive_per_s } => {
                Segment::Hermite { leave: T::rate_si(leave_per_s), arrive: T::rate_si(arrive_per_s) }
            }
            ToNext::Bezier { leave, arrive } => {
                Segment::Bezier { leave: handle(leave), arrive: handle(arrive) }
            }
        },
    }
}
