//! Light of suns that a surface scatters to the vertex of a walk. In go that vertex and uniform numbers, out
//! comes an estimate of the radiance that the vertex scatters towards the eye. Invariant: sunlit points that
//! walks meet and those at the ends of beams have weights that add up to 1 (see `connection.rs`).
//!
//! The sun shines through a window on a patch of the floor, and lights the room by it. Walks from the eye
//! hardly ever meet the patch. As with lamps (`lamp_spots.rs`), rays of the sun sample it. They go where
//! first walks met the sun (see `sun_beams.rs`).

use super::connection::{Receiver, Target};
use super::direct;
use super::path::Path;
use super::sun_beams::{Beam, MetPoint};
use super::turn::Turn;
use crate::color::{Rgb, luminance};
use crate::snapshot::{FrozenLight, SurfacePoint};

/// Radiance of a spot in the sun that the receiver scatters, W m^-2 sr^-1, from one sampled point.
pub(super) fn scattered(path: &mut Path, receiver: &Receiver) -> Rgb {
    let (snapshot, lights) = (path.snapshot, path.light.lights);
    let beams = path.scratch.learned.as_deref().map(|learned| &learned.on_surfaces);
    let Some(beams) = beams.filter(|beams| !beams.is_empty()) else { return Rgb::ZERO };
    let [which, u, v] = path.sampler.next_3d();
    let Some((beam, _)) = beams.choose(which) else { return Rgb::ZERO };
    let Some(light @ &FrozenLight::Sun { to_light, .. }) = lights.get(beam.light) else { return Rgb::ZERO };
    let ray = beam.ray(to_light, [u, v].into());
    let Some(hit) = snapshot.casting().nearest_hit(&ray, f64::INFINITY, None) else { return Rgb::ZERO };
    let spot = snapshot.surface(&ray, &hit);
    let per_m2 = beam.per_m2(light, spot.position, spot.geometric_normal);
    let target = Target { primitive: hit.primitive, position: spot.position, per_m2 };
    receiver.lit_by(snapshot, &target, |point| direct::of_light(snapshot, light, point))
}

/// Radiance of suns' light that a surface met by a walk scatters, weighted for multiple importance sampling.
/// Until there are beams, it is noted for them.
pub(super) fn met(path: &mut Path, (turn, throughput): (Option<Turn>, Rgb), point: &SurfacePoint) -> Rgb {
    let snapshot = path.snapshot;
    let turn = turn.filter(|_| snapshot.ends_light(point.primitive));
    let mut sum = Rgb::ZERO;
    for (number, light) in path.light.lights.iter().enumerate() {
        if !matches!(light, FrozenLight::Sun { .. }) {
            continue;
        }
        let scattered = direct::of_light(snapshot, light, point);
        let share = match (&path.scratch.learned, turn) {
            (Some(learned), Some(turn)) if scattered != Rgb::ZERO => {
                let per_m2 = |beam: &Beam| beam.per_m2(light, point.position, point.geometric_normal);
                learned.on_surfaces.of(number).map_or(1.0, |beam| turn.share_of_met(point, per_m2(beam)))
            }
            (None, Some(_)) if path.light.indirect_alone => {
                let luminance = luminance(throughput * scattered);
                let met = MetPoint { light: number, position: point.position, luminance };
                path.scratch.noted.on_surfaces.push(met);
                1.0
            }
            _ => 1.0,
        };
        sum += share * scattered;
    }
    sum
}
