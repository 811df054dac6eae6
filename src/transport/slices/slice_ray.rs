//! One ray of a slice. In go its first hit and the sweep's shadows, out comes its sample. Invariant: the
//! sample is that of the per-ray method, to rounding.

use super::light_rays::LightRays;
use super::slice_job::SliceJob;
use super::sweep::{Meeting, Sweep};
use crate::color::Rgb;
use crate::fog::{FogSlice, LitSegments, Passage};
use crate::math::{PlanarRay, Ray, Sampler};
use crate::snapshot::{Facet, SurfacePoint};
use crate::transport::direct::Unshadowed;
use crate::transport::leg::{Airlight, Leg, LegEnd, Shown};
use crate::transport::path::{Illumination, Path, Scratch, Start};
use crate::transport::radiance::{mattes, mean};
use crate::transport::shafts::{RaySegment, by_segments};
use crate::transport::visibility::Way;
use crate::transport::{Branches, Sample};
use crate::transport::{fog_emission, indirect, lamps_seen};

/// A ray of a slice and its first hit.
pub(super) struct SliceRay<'a> {
    pub(super) job: &'a SliceJob<'a>,
    pub(super) ray: Ray,
    pub(super) planar: PlanarRay,
    pub(super) light_rays: LightRays,
    pub(super) meeting: Option<(Meeting, &'a Facet<'a>)>,
    /// Random numbers for choices beyond the surface.
    pub(super) sampler: Sampler,
}

impl SliceRay<'_> {
    /// Metres to the surface.
    pub(super) fn distance(&self) -> f64 {
        self.meeting.map_or(f64::INFINITY, |(meeting, facet)| {
            // The triangle's plane is known in double precision, the segment only in single.
            let on_plane = facet.distance_along(&self.ray);
            if on_plane.is_finite() { on_plane } else { meeting.distance }
        })
    }

    fn path<'s>(&'s self, sampler: &'s mut Sampler, scratch: &'s mut Scratch) -> Path<'s> {
        let SliceJob { snapshot, transport, light, has_rest, .. } = *self.job;
        let lights = std::slice::from_ref(light);
        let light = Illumination {
            lights,
            has_rest,
            sky: false,
            is_in_specular: false,
            indirect_alone: false,
            branches: Branches::ONE,
        };
        Path { snapshot, transport, light, sampler, scratch }
    }

    /// Sample by the per-ray method.
    pub(super) fn by_itself(&self, scratch: &mut Scratch) -> Sample {
        let mut sampler = self.sampler;
        let mut path = self.path(&mut sampler, scratch);
        let (leg, surface) = path.follow(&self.ray, Start::Camera, self.job.transport.mirror_depth);
        path.sample(&leg, surface.as_ref(), &self.ray, self.job.hue)
    }

    /// Sample, with the shadows of a sweep and the fog of its slice.
    pub(super) fn value(&self, sweep: &mut Sweep, fog: &mut FogSlice, scratch: &mut Scratch) -> Sample {
        let Self { ref ray, planar, light_rays, .. } = *self;
        let SliceJob { snapshot, transport, light, .. } = *self.job;
        let mut sampler = self.sampler;
        let mut path = self.path(&mut sampler, scratch);
        let distance = self.distance();
        if let Some((_, facet)) = self.meeting {
            // They come while shadows and fog are found.
            facet.prefetch_texels(ray, distance);
        }
        let end = distance * planar.direction.x;
        let end_name = self.meeting.map(|_| light_rays.through(distance * planar.direction));
        let shadows = sweep.shadows(end_name);
        let Passage { scattered: shafts, transmittance } =
            fog.follow(&planar, ray, end, shadows).unwrap_or_else(|| {
                let distance_of = |name: f64| light_rays.reach(name, planar.slope) / planar.direction.x;
                let shade = |lit: &mut LitSegments| {
                    for (start, end) in shadows.0.as_slice().iter().chain(shadows.1.as_slice()) {
                        lit.shadows_mut().insert(distance_of(*start), distance_of(*end));
                    }
                };
                by_segments(&mut path, RaySegment { ray, from: Start::Camera, distance }, light, shade)
            });
        let is_hole = self.meeting.is_some_and(|(meeting, _)| snapshot.is_holdout(meeting.primitive));
        let shows = |(meeting, facet): &(Meeting, &Facet)| {
            let is_seen_around = transport.indirect.is_some() || snapshot.shows_lamps(0.0, ray.origin);
            let has_light = meeting.is_lit || facet.shows(is_seen_around) || path.indirect().is_some();
            !is_hole && (has_light || transport.features)
        };
        let seen = self.meeting.filter(shows);
        let is_lit = seen.is_some_and(|(meeting, _)| meeting.is_lit);
        let surface = seen.map(|(_, facet)| facet.seen_along(ray, distance));
        let behind = match &surface {
            None if self.meeting.is_some() => Shown::default(),
            None => Shown::emitted(path.light.background(snapshot, ray.direction, Start::Camera)),
            Some(point) => {
                let to_light = is_lit.then(|| fog.transmittance_to_light(&planar, end)).flatten();
                self.reflected(&mut path, point, is_lit, to_light)
            }
        };
        let indirect_shafts = path
            .indirect()
            .map_or(Rgb::ZERO, |indirect| indirect.seen_in_fog(snapshot, ray, distance, transmittance));
        let way = Way { distance, ..Way::default() };
        let emission = fog_emission::on_the_way(&path, ray, &way);
        let lamps = lamps_seen::on_the_way(&path, (ray, Start::Camera), &way);
        let shafts = shafts + indirect_shafts + emission;
        let held_out = if is_hole { mean(transmittance) } else { 0.0 };
        let mattes = mattes(snapshot, &[], surface.as_ref());
        let leg = Leg::new(
            Airlight { shafts, indirect_shafts, transmittance },
            Shown { radiance: shafts, ..Shown::default() } + lamps,
            behind,
            LegEnd { is_covered: self.meeting.is_some(), held_out, mattes },
        );
        path.sample(&leg, surface.as_ref(), ray, self.job.hue)
    }

    /// Radiance that leaves the surface towards the camera. `to_light` is the transmittance of fog to the
    /// light, if known.
    fn reflected(&self, path: &mut Path, point: &SurfacePoint, is_lit: bool, to_light: Option<Rgb>) -> Shown {
        let SliceJob { snapshot, transport, light, .. } = *self.job;
        let unshadowed = if is_lit { Unshadowed::beside_images(light, point) } else { None };
        let of_light = unshadowed.map_or(Rgb::ZERO, |Unshadowed { radiance, to_light: way, distance }| {
            radiance
                * to_light
                    .unwrap_or_else(|| snapshot.medium.transmittance_from(point.position, way, distance))
        });
        let indirect = indirect::scattered(path, point);
        let scattered = Shown { radiance: of_light + indirect, indirect, ..Shown::default() };
        scattered + path.emitted_and_mirrored(&self.ray, point, transport.mirror_depth)
    }
}
