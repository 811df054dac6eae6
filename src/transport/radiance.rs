//! The story of one camera ray. Invariant: `radiance = surface * transmittance + shafts`.

use super::lit_segments::LitSegments;
use super::shafts::{VolumeMethod, in_scattered};
use super::{Sample, SurfaceFeatures, direct};
use crate::accel::PrimitiveId;
use crate::color::Rgb;
use crate::math::{Ray, Sampler};
use crate::scattering::Stretch;
use crate::snapshot::{Snapshot, SurfacePoint};

/// How rays are to be followed.
#[derive(Clone, Copy, Debug)]
pub struct Transport {
    /// How light scattered in fog is found.
    pub volume: VolumeMethod,
    /// How often a ray may be reflected by mirrors.
    pub mirror_depth: u32,
    /// Whether [`Sample::surface`] is wanted.
    pub features: bool,
}

/// Memory that rays of one thread share.
#[derive(Default)]
pub struct Scratch {
    pub(super) lit: LitSegments,
    pub(super) cuts: Vec<f64>,
    pub(super) stretches: Vec<Stretch>,
}

/// One leg of a path: from its origin to the first surface.
struct Leg {
    radiance: Rgb,
    shafts: Rgb,
    transmittance: Rgb,
    surface: Option<SurfacePoint>,
}

/// Follows a camera ray: single scattering in the fog, plus direct light on the surface behind it,
/// plus what mirrors show, weakened by the fog in between.
pub fn radiance(
    snapshot: &Snapshot,
    transport: &Transport,
    ray: &Ray,
    sampler: &mut Sampler,
    scratch: &mut Scratch,
) -> Sample {
    let leg = follow(snapshot, transport, ray, None, transport.mirror_depth, sampler, scratch);
    let alpha = if leg.surface.is_some() || snapshot.background != Rgb::ZERO {
        1.0
    } else {
        1.0 - leg.transmittance.element_sum() / 3.0
    };
    let surface = leg.surface.filter(|_| transport.features).map(|point| SurfaceFeatures {
        depth_m: snapshot.view.depth(point.position),
        normal: point.shading_normal,
        position: snapshot.world_from_relative(point.position),
        albedo: point.albedo,
        leaf_id: point.leaf_id,
    });
    Sample { radiance: leg.radiance, shafts: leg.shafts, transmittance: leg.transmittance, alpha, surface }
}

fn follow(
    snapshot: &Snapshot,
    transport: &Transport,
    ray: &Ray,
    leaving: Option<PrimitiveId>,
    mirrors_left: u32,
    sampler: &mut Sampler,
    scratch: &mut Scratch,
) -> Leg {
    let hit = snapshot.tree.nearest_hit(ray, f64::INFINITY, leaving);
    let distance = hit.map_or(f64::INFINITY, |hit| hit.t);
    let surface = hit.map(|hit| snapshot.surface(ray, &hit));

    let (shafts, transmittance) = if snapshot.medium.is_empty() {
        (Rgb::ZERO, Rgb::ONE)
    } else {
        (
            in_scattered(snapshot, transport.volume, ray, distance, sampler, scratch),
            snapshot.medium.transmittance(ray.origin, ray.direction, distance),
        )
    };
    let behind_fog = surface.map_or(snapshot.background, |point| {
        let mut leaving = point.emission + direct::reflected(snapshot, &point);
        if mirrors_left > 0 && point.mirror.max_element() > 0.0 {
            let normal = point.shading_normal;
            let reflected = ray.direction - 2.0 * ray.direction.dot(normal) * normal;
            // An interpolated normal may send light through the surface: no mirror does.
            if reflected.dot(point.geometric_normal) > 0.0 {
                let ray = Ray { origin: point.position, direction: reflected.normalize() };
                let skip = Some(point.primitive);
                let seen = follow(snapshot, transport, &ray, skip, mirrors_left - 1, sampler, scratch);
                leaving += point.mirror * seen.radiance;
            }
        }
        leaving
    });
    Leg { radiance: behind_fog * transmittance + shafts, shafts, transmittance, surface }
}
