//! One slice, solved. In go the slice and where its samples lie, out come the samples' values.
//! Invariant: each value is what the per-ray method finds for the same ray, to rounding.

use super::Fan;
use super::fan::{Place, Slice};
use super::sweep::{LightRays, Meeting, Sweep};
use crate::accel::{Cut, HalfPlane};
use crate::color::Rgb;
use crate::math::{IntervalSet, Ray, Sampler};
use crate::snapshot::{FrozenLight, Snapshot};
use crate::transport::Sample;
use crate::transport::direct::reflected_from;
use crate::transport::radiance::{Illumination, Leg, Scratch, Transport, own_and_mirrored};
use glam::{DVec2, DVec3};

/// Memory that the slices of one thread share.
#[derive(Default)]
pub struct SliceScratch {
    cuts: Vec<Cut>,
    sweep: Sweep,
    shadows: IntervalSet,
    rays: Scratch,
}

/// A sample and where it lies.
#[derive(Clone, Copy, Debug)]
pub struct SliceSample {
    /// In pixels of the full picture, y downwards.
    pub film_px: DVec2,
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
    /// The slices' light, as its index in the snapshot.
    pub light: usize,
    /// Whether what shines by itself is counted with this light.
    pub self_luminous: bool,
    /// All slices of the light.
    pub fan: &'a Fan,
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
    let light = &snapshot.lights[job.light];
    let rays = match *light {
        FrozenLight::Sun { .. } => LightRays::Parallel,
        FrozenLight::Point { position, .. } => LightRays::From(position.length()),
    };
    let slope_of = |direction: DVec3| direction.dot(job.fan.axis) / direction.dot(slice.outward);
    let lowest_slope = slope_of(slice.far_end());
    let SliceScratch { cuts, sweep, shadows, rays: ray_scratch } = scratch;
    cuts.clear();
    let half_plane = HalfPlane { axis: job.fan.axis, outward: slice.outward, lowest_slope };
    snapshot.tree.add_cuts(&half_plane, cuts);
    sweep.start(cuts, rays, lowest_slope);

    for (index, area) in areas_per_rad.enumerate() {
        let Place { film_px, direction } = slice.place(area);
        let slope = slope_of(direction);
        let meeting = sweep.advance(slope, rays, shadows);
        let spread = direction.dot(slice.outward);
        let distance_of = |name: f64| rays.reach(name, slope) / spread;
        let ray = Ray { origin: DVec3::ZERO, direction };
        let leg = leg(job, light, &ray, meeting, shadows, distance_of, index as u32, ray_scratch);
        sample(SliceSample { film_px, value: leg.sample(snapshot, job.transport) });
    }
}

#[allow(clippy::too_many_arguments, reason = "the inner loop, split for reading")]
fn leg(
    job: &SliceJob,
    light: &FrozenLight,
    ray: &Ray,
    meeting: Option<Meeting>,
    shadows: &IntervalSet,
    distance_of: impl Fn(f64) -> f64,
    index: u32,
    scratch: &mut Scratch,
) -> Leg {
    let snapshot = job.snapshot;
    let hit = meeting.and_then(|meeting| snapshot.hit_on(ray, meeting.primitive));
    let distance = hit.map_or(f64::INFINITY, |hit| hit.t);
    let surface = hit.map(|hit| snapshot.surface(ray, &hit));

    let (mut shafts, mut transmittance) = (Rgb::ZERO, Rgb::ONE);
    if let Some(range) = snapshot.medium.range(ray, distance) {
        let Scratch { lit, cuts, stretches } = scratch;
        let known = shadows.as_slice().iter().map(|&(start, end)| (distance_of(start), distance_of(end)));
        lit.set(ray, light, range, known);
        snapshot.medium.stretches(ray, distance, light.source(), cuts, stretches);
        shafts = lit.integrate(&snapshot.medium, stretches, ray, light);
        transmittance = snapshot.medium.transmittance(ray.origin, ray.direction, distance);
    }
    let illumination = Illumination { lights: std::slice::from_ref(light), self_luminous: job.self_luminous };
    let behind_fog = surface.zip(meeting).map_or_else(
        || illumination.background(snapshot),
        |(point, meeting)| {
            let direct = reflected_from(snapshot, light, &point, |_, _| meeting.is_lit);
            let mut sampler = Sampler::new(index, 0, 0, 0);
            let mirrors = job.transport.mirror_depth;
            let transport = job.transport;
            direct
                + own_and_mirrored(
                    snapshot,
                    transport,
                    illumination,
                    ray,
                    &point,
                    mirrors,
                    &mut sampler,
                    scratch,
                )
        },
    );
    Leg { radiance: behind_fog * transmittance + shafts, shafts, transmittance, surface }
}
