//! One slice, solved. In go the slice and where its samples lie, out come the samples' values.
//! Invariant: each value is what the per-ray method finds for the same ray, to rounding.

use super::Fan;
use super::fan::{Place, Slice};
use super::fog_profile::FogProfile;
use super::sweep::{LightRays, PlanarRay, Sweep};
use super::veiled::VeilSweep;
use crate::accel::{Cut, HalfPlane};
use crate::color::Rgb;
use crate::math::{Ray, Sampler};
use crate::snapshot::{Facet, FrozenLight, Snapshot};
use crate::transport::Sample;
use crate::transport::direct::Unshadowed;
use crate::transport::radiance::{Illumination, Leg, Scratch, Transport, follow, mattes, own_and_mirrored};
use glam::{DVec2, DVec3};

/// No ray counts as nearer to the axis than this, in radians: directions in double precision do not say more.
const LEAST_SPREAD: f64 = 1e-15;

/// Memory that the slices of one thread share.
#[derive(Default)]
pub struct SliceScratch {
    rays: Vec<SliceRay>,
    slopes: Vec<f64>,
    cuts: Vec<Cut>,
    sweep: Sweep,
    veils: VeilSweep,
    fog: FogProfile,
    followed: Scratch,
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
}

/// A sample's ray.
#[derive(Clone, Copy)]
struct SliceRay {
    /// Counted along the slice.
    index: usize,
    place: Place,
    planar: PlanarRay,
}

/// Calls back with the place and the value, of the slice's light alone, of each sample along a slice, away from the light;
/// in go their numbers on it and places. Rays that blended surfaces touch
/// are followed by themselves. Returns how many segments
/// the slice gathered; `None` if there is no sample, and so nothing done.
pub fn solve(
    job: &SliceJob,
    slice: &Slice,
    places: impl Iterator<Item = (usize, Place)>,
    scratch: &mut SliceScratch,
    mut sample: impl FnMut(&Place, &Sample),
) -> Option<usize> {
    let snapshot = job.snapshot;
    let (light, eye) = (job.light, job.fan.eye);
    let light_rays = match *light {
        FrozenLight::Sun { .. } => LightRays::Parallel,
        FrozenLight::Point { position, .. } => LightRays::From((position - eye).length()),
    };
    // Rounding must not put a ray along the axis on the other side of it.
    let in_plane = |direction: DVec3| {
        DVec2::new(direction.dot(slice.outward).max(LEAST_SPREAD), direction.dot(job.fan.axis))
    };
    let SliceScratch { rays, slopes, cuts, sweep, veils, fog, followed } = scratch;
    rays.clear();
    rays.extend(places.map(|(index, place)| SliceRay {
        index,
        place,
        planar: PlanarRay::new(in_plane(place.direction)),
    }));
    let lowest_slope = rays.last()?.planar.slope;
    slopes.clear();
    slopes.extend(rays.iter().map(|ray| ray.planar.slope));
    let half_plane = HalfPlane { eye, axis: job.fan.axis, outward: slice.outward, lowest_slope };
    cuts.clear();
    snapshot.blended.add_cuts(&half_plane, cuts);
    let blended_cuts = cuts.len();
    veils.start(cuts, light_rays, slopes);
    cuts.clear();
    snapshot.tree.add_cuts(&half_plane, cuts);
    sweep.start(cuts, light_rays, slopes);
    let middle_slope = slopes[slopes.len() / 2];
    let has_profile = matches!(light, FrozenLight::Sun { .. })
        && fog.start(&snapshot.medium, &half_plane, middle_slope, cuts);

    let mut met: Option<Facet> = None;
    for &SliceRay { index, place, planar } in rays.iter() {
        let ray = Ray { origin: eye, direction: place.direction };
        let meeting = sweep.advance(&planar, light_rays, |start, end| {
            if has_profile {
                fog.darken(start, end);
            }
        });
        if let Some(meeting) =
            meeting.filter(|meeting| met.is_none_or(|met| met.primitive != meeting.primitive))
        {
            met = Some(snapshot.facet(meeting.primitive));
        }
        let surface = meeting.zip(met.as_ref()).map(|(meeting, facet)| {
            // The plane is known in double precision, the segment only in single.
            let on_plane = facet.distance_along(&ray);
            let distance = if on_plane.is_finite() { on_plane } else { meeting.distance };
            (facet, distance, meeting.is_lit)
        });
        let distance = surface.map_or(f64::INFINITY, |(_, distance, _)| distance);
        let lights = std::slice::from_ref(light);
        let illumination = Illumination { lights, self_luminous: job.self_luminous, sky: false };
        if blended_cuts > 0 && veils.touches(&planar, light_rays, distance) {
            let (transport, mirrors) = (job.transport, job.transport.mirror_depth);
            let mut sampler = Sampler::new(index as u32, 0, 0, 0);
            let leg = follow(snapshot, transport, illumination, &ray, None, mirrors, &mut sampler, followed);
            sample(&place, &leg.sample(snapshot, transport, &ray));
            continue;
        }
        let end = distance * planar.direction.x;
        let end_name = surface.map(|_| light_rays.through(distance * planar.direction));
        let (shadows, own_shadows) = sweep.shadows(end_name);
        let passage = match *light {
            FrozenLight::Sun { irradiance, .. } if has_profile => fog
                .follow(&planar, &ray, end, shadows, own_shadows)
                .map(|passage| (passage.scattered * irradiance, passage.transmittance)),
            _ => None,
        };
        let (shafts, transmittance) = passage.unwrap_or_else(|| {
            let distance_of = |name: f64| light_rays.reach(name, planar.slope) / planar.direction.x;
            let all = shadows.as_slice().iter().chain(own_shadows.as_slice());
            let shadows = all.map(|&(start, end)| (distance_of(start), distance_of(end)));
            by_segments(snapshot, light, &ray, distance, shadows, followed)
        });
        let shows = |&(facet, _, is_lit): &(&Facet, f64, bool)| {
            is_lit || facet.shines_or_mirrors() || job.transport.features
        };
        let seen =
            surface.filter(shows).map(|(facet, distance, is_lit)| (facet.seen_along(&ray, distance), is_lit));
        let behind_fog = match seen {
            None if surface.is_some() => Rgb::ZERO,
            None => illumination.background(snapshot, ray.direction),
            Some((point, is_lit)) => {
                let unshadowed = if is_lit { Unshadowed::new(light, &point) } else { None };
                let reflected = unshadowed.map_or(Rgb::ZERO, |unshadowed| {
                    unshadowed.radiance
                        * match light {
                            FrozenLight::Sun { .. } if has_profile => {
                                fog.transmittance_to_light(&planar, end)
                            }
                            _ => {
                                let Unshadowed { to_light, distance, .. } = unshadowed;
                                snapshot.medium.transmittance(point.position, to_light, distance)
                            }
                        }
                });
                let mut sampler = Sampler::new(index as u32, 0, 0, 0);
                let (transport, mirrors) = (job.transport, job.transport.mirror_depth);
                reflected
                    + own_and_mirrored(
                        snapshot,
                        transport,
                        illumination,
                        &ray,
                        &point,
                        mirrors,
                        &mut sampler,
                        followed,
                    )
            }
        };
        let radiance = behind_fog * transmittance + shafts;
        let covered = surface.is_some();
        let surface = seen.map(|(point, _)| point);
        let mattes = mattes(snapshot, &[], surface.as_ref());
        let leg = Leg { radiance, shafts, transmittance, covered, surface, mattes };
        sample(&place, &leg.sample(snapshot, job.transport, &ray));
    }
    Some(blended_cuts + cuts.len())
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
