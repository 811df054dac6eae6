//! One slice, solved. In go the slice and where its samples lie, out come the samples' values.
//! Invariant: each value is what the per-ray method finds for the same ray, to rounding.

use super::Fan;
use super::fan::{Place, Slice};
use super::fog_profile::FogProfile;
use super::sweep::{LightRays, Sweep};
use crate::accel::{Cut, HalfPlane};
use crate::color::Rgb;
use crate::math::{IntervalSet, Ray, Sampler};
use crate::scene::Size;
use crate::snapshot::{FrozenLight, Snapshot};
use crate::transport::Sample;
use crate::transport::direct::reflected_from;
use crate::transport::radiance::{Illumination, Leg, Scratch, Transport, own_and_mirrored};
use glam::DVec3;

/// No ray counts as nearer to the axis than this, in radians: directions in double precision do not say more.
const LEAST_SPREAD: f64 = 1e-15;

/// Memory that the slices of one thread share.
#[derive(Default)]
pub struct SliceScratch {
    cuts: Vec<Cut>,
    sweep: Sweep,
    shadows: IntervalSet,
    fog: FogProfile,
    rays: Scratch,
}

/// A sample and where it lies.
#[derive(Clone, Copy, Debug)]
pub struct SliceSample {
    /// Where.
    pub place: Place,
    /// Its value, of the slice's light alone.
    pub value: Sample,
}

/// What is to be solved.
#[derive(Clone, Copy)]
pub struct SliceJob<'a> {
    /// The frame.
    pub snapshot: &'a Snapshot<'a>,
    /// How rays that leave the slices are followed.
    pub transport: &'a Transport,
    /// The slices' light: a light of the snapshot, or a point of one.
    pub light: &'a FrozenLight,
    /// Whether what shines by itself is counted with this light.
    pub self_luminous: bool,
    /// All slices of the light, from where they are seen.
    pub fan: &'a Fan,
    /// The whole picture.
    pub size: Size,
    /// Samples at other pixels are passed over.
    pub wanted: &'a (dyn Fn(usize, usize) -> bool + Sync),
}

/// Values of samples at ever larger areas of a slice (see [`Slice::place`]).
pub fn solve(
    job: &SliceJob,
    slice: &Slice,
    areas_per_rad: impl Iterator<Item = f64>,
    scratch: &mut SliceScratch,
    mut sample: impl FnMut(SliceSample),
) {
    let snapshot = job.snapshot;
    let (light, eye) = (job.light, job.fan.eye);
    let rays = match *light {
        FrozenLight::Sun { .. } => LightRays::Parallel,
        FrozenLight::Point { position, .. } => LightRays::From((position - eye).length()),
    };
    // Rounding must not put a ray along the axis on the other side of it.
    let spread_of = |direction: DVec3| direction.dot(slice.outward).max(LEAST_SPREAD);
    let slope_of = |direction: DVec3| direction.dot(job.fan.axis) / spread_of(direction);
    let lowest_slope = slope_of(slice.far_end());
    let SliceScratch { cuts, sweep, shadows, fog, rays: ray_scratch } = scratch;
    let is_wanted = |place: &Place| {
        let (x, y) = place.pixel(job.size);
        (job.wanted)(x, y)
    };
    let mut places = areas_per_rad
        .map(|area| slice.place(area))
        .enumerate()
        .filter(|(_, place)| is_wanted(place))
        .peekable();
    if places.peek().is_none() {
        return;
    }
    cuts.clear();
    let half_plane = HalfPlane { eye, axis: job.fan.axis, outward: slice.outward, lowest_slope };
    snapshot.tree.add_cuts(&half_plane, cuts);
    sweep.start(cuts, rays, lowest_slope);
    let has_profile = snapshot.medium.is_even() && matches!(light, FrozenLight::Sun { .. });
    if has_profile {
        fog.start(&snapshot.medium, &half_plane);
    }

    for (index, place) in places {
        let direction = place.direction;
        let slope = slope_of(direction);
        let spread = spread_of(direction);
        let meeting = sweep.advance(slope, rays, shadows);
        let ray = Ray { origin: eye, direction };
        let hit = meeting.and_then(|meeting| snapshot.hit_on(&ray, meeting.primitive));
        let distance = hit.map_or(f64::INFINITY, |hit| hit.t);
        let (shafts, transmittance) = match *light {
            FrozenLight::Sun { irradiance, .. } if has_profile => {
                let passage = fog.follow(slope, spread, distance * spread, shadows);
                (passage.scattered * irradiance, passage.transmittance)
            }
            _ => {
                let names = shadows.as_slice().iter();
                let distance_of = |name: f64| rays.reach(name, slope) / spread;
                let known = names.map(|&(start, end)| (distance_of(start), distance_of(end)));
                by_segments(snapshot, light, &ray, distance, known, ray_scratch)
            }
        };
        let surface = hit.map(|hit| snapshot.surface(&ray, &hit));
        let illumination =
            Illumination { lights: std::slice::from_ref(light), self_luminous: job.self_luminous };
        let behind_fog = surface.zip(meeting).map_or_else(
            || illumination.background(snapshot, direction),
            |(point, meeting)| {
                let mut sampler = Sampler::new(index as u32, 0, 0, 0);
                let (transport, mirrors) = (job.transport, job.transport.mirror_depth);
                reflected_from(
                    snapshot,
                    light,
                    &point,
                    |_, _| if meeting.is_lit { Rgb::ONE } else { Rgb::ZERO },
                ) + own_and_mirrored(
                    snapshot,
                    transport,
                    illumination,
                    &ray,
                    &point,
                    mirrors,
                    &mut sampler,
                    ray_scratch,
                )
            },
        );
        let radiance = behind_fog * transmittance + shafts;
        let leg = Leg { radiance, shafts, transmittance, covered: surface.is_some(), surface };
        sample(SliceSample { place, value: leg.sample(snapshot, job.transport) });
    }
}

/// Light scattered on the way, and transmittance, as for any ray whose shadows are known.
fn by_segments(
    snapshot: &Snapshot,
    light: &FrozenLight,
    ray: &Ray,
    distance: f64,
    shadows: impl Iterator<Item = (f64, f64)>,
    scratch: &mut Scratch,
) -> (Rgb, Rgb) {
    let medium = &snapshot.medium;
    let Some(range) = medium.range(ray, distance) else { return (Rgb::ZERO, Rgb::ONE) };
    let Scratch { lit, cuts, stretches, .. } = scratch;
    lit.set(ray, light, range, shadows);
    medium.stretches(ray, distance, light.source(), cuts, stretches);
    let shafts = lit.integrate(medium, stretches, ray, light);
    (shafts, medium.transmittance(ray.origin, ray.direction, distance))
}
