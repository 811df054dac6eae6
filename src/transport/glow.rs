//! Light of what glows, scattered once. In go a vertex of a random walk and uniform numbers, out comes an
//! estimate of what it scatters towards the eye. Invariant: what is met and what is picked by its power make
//! up the whole (see `connection.rs`).

use super::connection::{Receiver, Target, Turn};
use super::path::Path;
use crate::color::Rgb;
use crate::snapshot::SurfacePoint;

/// Radiance that is scattered of what a point of the glow sends there, W m^-2 sr^-1.
pub(super) fn scattered(path: &mut Path, receiver: &Receiver) -> Rgb {
    let (snapshot, light) = (path.snapshot, path.light);
    let Some(glow) = snapshot.glow().filter(|_| light.has_rest) else { return Rgb::ZERO };
    let (primitive, position) = glow.pick(snapshot, path.sampler.next_3d());
    let target = Target { primitive, position, per_m2: glow.picked_per_m2(snapshot, primitive) };
    receiver.lit_by(snapshot, &target, |point| light.emitted(point))
}

/// What a surface emits that a walk meets, by the share by which it counts; all of it in a mirror.
pub(super) fn met(path: &Path, turn: Option<Turn>, point: &SurfacePoint) -> Rgb {
    let emitted = path.light.emitted(point);
    let (Some(turn), Some(glow)) = (turn, path.snapshot.glow()) else { return emitted };
    emitted * turn.share_of_met(point, glow.picked_per_m2(path.snapshot, point.primitive))
}
