//! The story of one camera ray. Invariant: radiance is light of surfaces, weakened by all that lies before
//! them, plus `shafts`; without blended surfaces `surface * transmittance + shafts`.

use super::lit_segments::LitSegments;
use super::shafts::{VolumeMethod, in_scattered};
use super::stack::Stack;
use super::visibility::{BlendedHit, RayEnd, Way, blended_hits, ray_end};
use super::{MATTES_OF_A_SAMPLE, Matte, Sample, SurfaceFeatures, direct, sky_light};
use crate::accel::PrimitiveId;
use crate::color::Rgb;
use crate::math::{Ray, Sampler};
use crate::scattering::Stretch;
use crate::snapshot::{FrozenLight, Snapshot, SurfacePoint};
use glam::DVec3;
use std::ops::{AddAssign, Range};

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
    lights: Vec<FrozenLight>,
}

/// Which light is being followed: a picture may be made of one picture a light, added up.
#[derive(Clone, Copy)]
pub(super) struct Illumination<'a> {
    pub(super) lights: &'a [FrozenLight],
    /// Whether surfaces that shine by themselves, and the background, belong to it.
    pub(super) self_luminous: bool,
    /// Whether the light of the sky belongs to it.
    pub(super) sky: bool,
}

impl Illumination<'_> {
    /// What a surface scatters towards the eye.
    fn scattered(&self, snapshot: &Snapshot, point: &SurfacePoint, sampler: &mut Sampler) -> Rgb {
        direct::scattered(snapshot, self.lights, point) + self.scattered_of_sky(snapshot, point, sampler)
    }

    fn scattered_of_sky(&self, snapshot: &Snapshot, point: &SurfacePoint, sampler: &mut Sampler) -> Rgb {
        let sky = snapshot.sky.as_ref().filter(|sky| self.sky && sky.lights_surfaces());
        sky.map_or(Rgb::ZERO, |sky| sky_light::scattered(snapshot, sky, point, sampler))
    }

    /// What a surface emits.
    fn emitted(&self, point: &SurfacePoint) -> Rgb {
        if self.self_luminous { point.emission } else { Rgb::ZERO }
    }

    /// What lies behind everything.
    pub(super) fn background(&self, snapshot: &Snapshot, direction: DVec3) -> Rgb {
        if self.self_luminous { snapshot.radiance_beyond(direction) } else { Rgb::ZERO }
    }
}

/// A part of a picture: the picture is the sum of its parts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// Light of one of the snapshot's lights, with what shines by itself if it is the first.
    Light(usize),
    /// Light of the sky that was scattered on the way.
    Sky,
}

/// Where a ray that is followed starts.
#[derive(Clone, Copy)]
pub(super) enum Start {
    /// At the eye, whose clipping planes hide surfaces.
    Camera,
    /// On a mirror.
    Surface(PrimitiveId),
}

/// One leg of a path, from its origin to the first surface: its light.
pub(super) struct Leg {
    pub(super) radiance: Rgb,
    /// Of that what shines by itself.
    pub(super) own: Rgb,
    pub(super) shafts: Rgb,
    pub(super) transmittance: Rgb,
    /// Whether an opaque surface ends it.
    pub(super) covered: bool,
    pub(super) mattes: [Matte; MATTES_OF_A_SAMPLE],
}

/// What a surface shows beside the light that it scatters.
#[derive(Clone, Copy, Default)]
pub(super) struct Shown {
    pub(super) radiance: Rgb,
    /// Of that what shines by itself, it or what is seen in it.
    pub(super) own: Rgb,
}

impl Shown {
    /// What shines by itself.
    pub(super) fn own(own: Rgb) -> Self {
        Self { radiance: own, own }
    }

    fn times(self, share: f64) -> Self {
        Self { radiance: share * self.radiance, own: share * self.own }
    }
}

impl AddAssign for Shown {
    fn add_assign(&mut self, other: Self) {
        self.radiance += other.radiance;
        self.own += other.own;
    }
}

/// Blended surfaces show in the data passes from this alpha on.
const SOLID_ALPHA: f64 = 0.5;

/// Follows a camera ray: single scattering in the fog, plus direct light on the surface behind it,
/// plus what mirrors show, weakened by the fog in between.
pub fn radiance(
    snapshot: &Snapshot,
    transport: &Transport,
    ray: &Ray,
    sampler: &mut Sampler,
    scratch: &mut Scratch,
) -> Sample {
    let wanted = Wanted { lights: 0..snapshot.lights.len(), with_hues: true, self_luminous: true, sky: true };
    radiance_of(wanted, snapshot, transport, ray, sampler, scratch)
}

/// The same of a part of the picture alone, its light without [`Sample::hue`].
pub fn radiance_of_part(
    part: Part,
    snapshot: &Snapshot,
    transport: &Transport,
    ray: &Ray,
    sampler: &mut Sampler,
    scratch: &mut Scratch,
) -> Sample {
    let wanted = match part {
        Part::Light(light) => {
            Wanted { lights: light..light + 1, with_hues: false, self_luminous: light == 0, sky: false }
        }
        Part::Sky => Wanted { lights: 0..0, with_hues: false, self_luminous: false, sky: true },
    };
    radiance_of(wanted, snapshot, transport, ray, sampler, scratch)
}

/// Which light a camera ray is to see.
struct Wanted {
    /// Indices of the snapshot's lights.
    lights: Range<usize>,
    /// Whether light has the hues of its points.
    with_hues: bool,
    self_luminous: bool,
    sky: bool,
}

/// Of each light one point for the whole ray: fog, surface and mirrors then see the same light, and
/// shafts fit the shadows they cast.
fn radiance_of(
    wanted: Wanted,
    snapshot: &Snapshot,
    transport: &Transport,
    ray: &Ray,
    sampler: &mut Sampler,
    scratch: &mut Scratch,
) -> Sample {
    let Wanted { lights: range, with_hues, self_luminous, sky } = wanted;
    let mut lights = std::mem::take(&mut scratch.lights);
    lights.clear();
    let mut hue = Rgb::ONE;
    for luminaire in &snapshot.lights[range] {
        lights.push(if luminaire.is_delta() {
            luminaire.centre()
        } else if with_hues {
            luminaire.point(sampler.next_3d())
        } else {
            let point;
            (point, hue) = luminaire.hued_point(sampler.next_3d());
            point
        });
    }
    let light = Illumination { lights: &lights, self_luminous, sky };
    let (leg, surface) =
        follow(snapshot, transport, light, ray, Start::Camera, transport.mirror_depth, sampler, scratch);
    scratch.lights = lights;
    leg.sample(surface.as_ref(), snapshot, transport, ray, hue)
}

impl Leg {
    /// What the film is to know of it, by light that has no hue yet; `surface` is what the data passes show.
    pub(super) fn sample(
        &self,
        surface: Option<&SurfacePoint>,
        snapshot: &Snapshot,
        transport: &Transport,
        ray: &Ray,
        hue: Rgb,
    ) -> Sample {
        let alpha = if self.covered || snapshot.has_background() {
            1.0
        } else {
            1.0 - self.transmittance.element_sum() / 3.0
        };
        let motion_px = snapshot.motion_px(surface, ray.direction);
        let surface = surface.filter(|_| transport.features).map(|point| SurfaceFeatures {
            depth_m: snapshot.view.depth(point.position),
            normal: point.shading_normal,
            position: snapshot.world_from_relative(point.position),
            albedo: point.albedo,
            leaf_id: point.leaf_id,
        });
        let Self { radiance, own, shafts, transmittance, mattes, .. } = *self;
        Sample { radiance, own, hue, shafts, transmittance, alpha, surface, motion_px, mattes }
    }
}

/// To the first surface and, by mirrors, beyond; with it comes the surface that data passes show.
#[allow(clippy::too_many_arguments, reason = "a recursion that carries its whole context")]
pub(super) fn follow(
    snapshot: &Snapshot,
    transport: &Transport,
    light: Illumination,
    ray: &Ray,
    from: Start,
    mirrors_left: u32,
    sampler: &mut Sampler,
    scratch: &mut Scratch,
) -> (Leg, Option<SurfacePoint>) {
    let (leaving, shown) = match from {
        Start::Camera => (None, snapshot.view.shown_along(ray)),
        Start::Surface(primitive) => (Some(primitive), 0.0..f64::INFINITY),
    };
    let RayEnd { hit, passes_hidden } = ray_end(snapshot, ray, &shown, leaving);
    let distance = hit.map_or(f64::INFINITY, |hit| hit.t);
    let surface = hit.map(|hit| snapshot.surface(ray, &hit));

    let blended = blended_hits(snapshot, ray, &(shown.start..distance.min(shown.end)), leaving);
    let way = Way { distance, blended, passes_hidden };
    let blended = way.blended.as_slice();
    let (shafts, fog) = if snapshot.medium.is_empty() {
        (Rgb::ZERO, Rgb::ONE)
    } else {
        let lights = in_scattered(snapshot, transport.volume, light.lights, ray, &way, sampler, scratch);
        let sky = snapshot.sky.as_ref().filter(|sky| light.sky && sky.lights_fog());
        let sky = sky
            .map_or(Rgb::ZERO, |sky| sky_light::in_scattered(snapshot, sky, ray, distance, blended, sampler));
        (lights + sky, snapshot.medium.transmittance(ray.origin, ray.direction, distance))
    };
    // Front to back: what each blended surface shows itself, and what all of them let through.
    let (mut radiance, mut own, mut seen_through) = (shafts, Rgb::ZERO, Rgb::ONE);
    let stack = Stack::of(snapshot, &light, ray, blended, sampler);
    for (index, hit) in blended.iter().enumerate() {
        let (point, mut scattered) = (&hit.point, Rgb::ZERO);
        let share = stack.as_ref().map_or(1.0, |stack| stack.shares[index]);
        let mut shown = Shown::own(light.emitted(point));
        match &stack {
            None => scattered += direct::scattered(snapshot, light.lights, point),
            Some(stack) => scattered += stack.scattered[index],
        }
        if share > 0.0 {
            scattered += share * light.scattered_of_sky(snapshot, point, sampler);
            let mirrored = mirrored(snapshot, transport, light, ray, point, mirrors_left, sampler, scratch);
            shown += mirrored.times(share);
        }
        let through_fog = snapshot.medium.transmittance(ray.origin, ray.direction, hit.t);
        let weight = seen_through * through_fog * hit.point.alpha;
        radiance += weight * (scattered + shown.radiance);
        own += weight * shown.own;
        seen_through *= hit.point.see_through;
    }
    let transmittance = fog * seen_through;
    let behind_fog = surface.map_or_else(
        || Shown::own(light.background(snapshot, ray.direction)),
        |point| {
            let scattered = light.scattered(snapshot, &point, sampler);
            let shown =
                own_and_mirrored(snapshot, transport, light, ray, &point, mirrors_left, sampler, scratch);
            Shown { radiance: scattered + shown.radiance, own: shown.own }
        },
    );
    radiance += behind_fog.radiance * transmittance;
    own += behind_fog.own * transmittance;
    let solid = blended.iter().map(|hit| hit.point).find(|point| point.alpha >= SOLID_ALPHA);
    let mattes = mattes(snapshot, blended, surface.as_ref());
    let leg = Leg { radiance, own, shafts, transmittance, covered: hit.is_some(), mattes };
    (leg, solid.or(surface))
}

/// Which objects a ray sees, and how much of each past those before it.
pub(super) fn mattes(
    snapshot: &Snapshot,
    blended: &[BlendedHit],
    surface: Option<&SurfacePoint>,
) -> [Matte; MATTES_OF_A_SAMPLE] {
    let mut mattes = [Matte::default(); MATTES_OF_A_SAMPLE];
    if snapshot.mattes.is_none() {
        return mattes;
    }
    let points = blended.iter().map(|hit| &hit.point).chain(surface);
    let mut left = 1.0;
    for (matte, point) in mattes.iter_mut().zip(points) {
        let id = snapshot.matte_id(point.primitive);
        *matte = Matte { id, share: (left * point.alpha) as f32 };
        left *= 1.0 - point.alpha;
    }
    mattes
}

/// Light that a surface emits, and what is seen in it if it is a mirror.
#[allow(clippy::too_many_arguments, reason = "a recursion that carries its whole context")]
pub(super) fn own_and_mirrored(
    snapshot: &Snapshot,
    transport: &Transport,
    light: Illumination,
    ray: &Ray,
    point: &SurfacePoint,
    mirrors_left: u32,
    sampler: &mut Sampler,
    scratch: &mut Scratch,
) -> Shown {
    let mut shown = Shown::own(light.emitted(point));
    shown += mirrored(snapshot, transport, light, ray, point, mirrors_left, sampler, scratch);
    shown
}

/// What is seen in a surface if it is a mirror.
#[allow(clippy::too_many_arguments, reason = "a recursion that carries its whole context")]
fn mirrored(
    snapshot: &Snapshot,
    transport: &Transport,
    light: Illumination,
    ray: &Ray,
    point: &SurfacePoint,
    mirrors_left: u32,
    sampler: &mut Sampler,
    scratch: &mut Scratch,
) -> Shown {
    if mirrors_left == 0 || point.mirror == Rgb::ZERO {
        return Shown::default();
    }
    let normal = point.shading_normal;
    let reflected = ray.direction - 2.0 * ray.direction.dot(normal) * normal;
    // An interpolated normal may send light through the surface: no mirror does.
    let leaves = reflected.dot(point.geometric_normal) > 0.0;
    if !leaves {
        return Shown::default();
    }
    let ray = Ray { origin: point.position, direction: reflected.normalize() };
    let from = Start::Surface(point.primitive);
    let (seen, _) = follow(snapshot, transport, light, &ray, from, mirrors_left - 1, sampler, scratch);
    Shown { radiance: point.mirror * seen.radiance, own: point.mirror * seen.own }
}
