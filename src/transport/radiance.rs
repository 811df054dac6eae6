//! Radiance along one camera ray. In go a snapshot and a ray, out comes a sample. Invariant: radiance is that
//! of the surface times the transmittance before it, plus `shafts`; blended surfaces add their own light,
//! attenuated alike.

use super::branches::Branches;
use super::leg::{Airlight, Leg, LegEnd, Shown};
use super::path::{Illumination, Path, Scratch, Start, Transport};
use super::shafts;
use super::stack::Stack;
use super::visibility::{RayEnd, Way, ray_end};
use super::{MATTES_OF_A_SAMPLE, Matte, Sample, SurfaceFeatures};
use super::{direct, fog_emission, indirect, lamps_seen, sky_light};
use crate::color::Rgb;
use crate::math::{Ray, Sampler};
use crate::snapshot::{BlendedHit, Snapshot, SurfacePoint};
use std::ops::Range;

/// One of the snapshot's lights. It may include the rest: emission, the background and indirect light, which
/// are seen along the same rays.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct OneLight {
    /// Index among the snapshot's lights.
    pub number: usize,
    /// Whether it includes the rest.
    pub with_rest: bool,
}

/// A component of the light of a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Component {
    /// The sum of all others.
    All,
    /// Light of one of the snapshot's lights.
    Light(OneLight),
    /// Light of the sky that was scattered on the way.
    Sky,
    /// Indirect light of all lights: a part of the other components, much cheaper without the rest. With
    /// random walks it is the mean of so many.
    Indirect(Branches),
}

/// Blended surfaces show in the data passes from this alpha on.
const SOLID_ALPHA: f64 = 0.5;

/// Traces a camera ray: single scattering in fog, direct light on the surface behind it, and mirrored light,
/// attenuated by the fog in between.
pub fn radiance(
    snapshot: &Snapshot,
    transport: &Transport,
    ray: &Ray,
    sampler: &mut Sampler,
    scratch: &mut Scratch,
) -> Sample {
    transport.radiance_of(Component::All, snapshot, ray, sampler, scratch)
}

impl Transport<'_> {
    /// Radiance of one component along a ray; of a single light without [`Sample::hue`].
    ///
    /// Each light has one point for the whole ray: fog, surface and mirrors then see the same light, and
    /// shafts fit the shadows they cast.
    pub fn radiance_of(
        &self,
        component: Component,
        snapshot: &Snapshot,
        ray: &Ray,
        sampler: &mut Sampler,
        scratch: &mut Scratch,
    ) -> Sample {
        let Wanted { lights: range, with_hues, has_rest, sky } = Wanted::of(component, snapshot);
        let (indirect_alone, branches) = match component {
            Component::Indirect(branches) => (true, branches),
            _ => (false, Branches::ONE),
        };
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
        let light =
            Illumination { lights: &lights, has_rest, sky, is_in_specular: false, indirect_alone, branches };
        let mut path = Path { snapshot, transport: self, light, sampler, scratch };
        let (leg, surface) = path.follow(ray, Start::Camera, self.mirror_depth);
        let sample = path.sample(&leg, surface.as_ref(), ray, hue);
        scratch.lights = lights;
        sample
    }
}

/// Light that a camera ray sees.
struct Wanted {
    /// Indices of the snapshot's lights.
    lights: Range<usize>,
    /// Whether light has the hues of its sampled points.
    with_hues: bool,
    has_rest: bool,
    sky: bool,
}

impl Wanted {
    fn of(component: Component, snapshot: &Snapshot) -> Self {
        match component {
            Component::All | Component::Indirect(_) => {
                Self { lights: 0..snapshot.lights.len(), with_hues: true, has_rest: true, sky: true }
            }
            Component::Light(OneLight { number, with_rest }) => {
                Self { lights: number..number + 1, with_hues: false, has_rest: with_rest, sky: false }
            }
            Component::Sky => Self { lights: 0..0, with_hues: false, has_rest: false, sky: true },
        }
    }
}

impl Path<'_> {
    /// Sample of a leg for the film, before light is multiplied by its hue. The data passes show
    /// `surface`.
    pub(super) fn sample(&self, leg: &Leg, surface: Option<&SurfacePoint>, ray: &Ray, hue: Rgb) -> Sample {
        let Self { snapshot, transport, .. } = self;
        let Leg { shown, airlight, end } = *leg;
        let Shown { radiance, emitted, indirect } = shown;
        let Airlight { shafts, indirect_shafts, transmittance } = airlight;
        let is_covered = end.is_covered || snapshot.has_background();
        let alpha = if is_covered { 1.0 } else { 1.0 - mean(transmittance) } - end.held_out;
        let motion_px = snapshot.motion_px(surface, ray.direction);
        let surface = surface.filter(|_| transport.features).map(|point| SurfaceFeatures {
            depth_m: snapshot.view.depth(point.position),
            normal: point.shading_normal,
            position: snapshot.world_from_relative(point.position),
            albedo: point.albedo,
            leaf_id: point.leaf_id,
        });
        Sample {
            radiance,
            emitted,
            hue,
            indirect,
            shafts,
            indirect_shafts,
            transmittance,
            alpha,
            surface,
            motion_px,
            mattes: end.mattes,
        }
    }

    /// Traces a ray to the first surface, and beyond it by mirrors. Returns the surface that data passes
    /// show, too.
    pub(super) fn follow(
        &mut self,
        ray: &Ray,
        from: Start,
        mirrors_left: u32,
    ) -> (Leg, Option<SurfacePoint>) {
        let (snapshot, light) = (self.snapshot, self.light);
        let shown = match from {
            Start::Camera => snapshot.view.shown_along(ray),
            Start::Surface(_) | Start::Specular(_) => 0.0..f64::INFINITY,
        };
        let RayEnd { hit, passes_hidden } = ray_end(snapshot, ray, &shown, from);
        let distance = hit.map_or(f64::INFINITY, |hit| hit.t);
        let is_hole = hit.is_some_and(|hit| from.sees_hole(snapshot, hit.primitive));
        let surface = hit.filter(|_| !is_hole).map(|hit| snapshot.surface(ray, &hit));

        let shown = shown.start..distance.min(shown.end);
        let blended = match from.leaving() {
            None => snapshot.blended_seen(ray, &shown),
            leaving => snapshot.blended_hits(ray, &shown, leaving),
        };
        let way = Way { distance, blended, passes_hidden };
        let (shafts, indirect_shafts, fog) = if snapshot.medium.is_empty() {
            (Rgb::ZERO, Rgb::ZERO, Rgb::ONE)
        } else {
            let indirect = indirect::in_scattered(self, ray, &way, from);
            let scattered = self.scattered_once((ray, from), &way) + indirect;
            (scattered, indirect, self.through_fog((ray, from), distance))
        };
        let (mut in_front, seen_through) = self.blended((ray, from), shafts, &way.blended, mirrors_left);
        in_front += lamps_seen::on_the_way(self, (ray, from), &way);
        let transmittance = fog * seen_through;
        let behind = match &surface {
            None if is_hole || matches!(from, Start::Specular(_)) => Shown::default(),
            None => Shown::emitted(light.background(snapshot, ray.direction, from)),
            Some(point) => self.scattered(point) + self.emitted_and_mirrored(ray, point, mirrors_left),
        };
        let held_out =
            self.held_out((ray, from), &way.blended) + if is_hole { mean(transmittance) } else { 0.0 };
        let is_solid =
            |point: &SurfacePoint| point.alpha >= SOLID_ALPHA && !from.sees_hole(snapshot, point.primitive);
        let solid = way.blended.iter().map(|hit| hit.point).find(is_solid);
        let mattes = mattes(snapshot, &way.blended, surface.as_ref());
        let airlight = Airlight { shafts, indirect_shafts, transmittance };
        let leg =
            Leg::new(airlight, in_front, behind, LegEnd { is_covered: hit.is_some(), held_out, mattes });
        (leg, solid.or(surface))
    }

    /// Radiance of lights and of the sky that fog scatters once along a ray, if the illumination includes
    /// them.
    fn scattered_once(&mut self, (ray, from): (&Ray, Start), way: &Way) -> Rgb {
        if self.light.indirect_alone {
            return Rgb::ZERO;
        }
        shafts::in_scattered(self, (ray, from), way)
            + sky_light::in_scattered(self, (ray, from), way)
            + fog_emission::on_the_way(self, ray, way)
    }

    /// The share of a ray that ends at blended holdouts.
    fn held_out(&self, (ray, from): (&Ray, Start), blended: &[BlendedHit]) -> f64 {
        let snapshot = self.snapshot;
        if snapshot.rays_of_instances().is_none() {
            return 0.0;
        }
        let (mut sum, mut seen_through) = (0.0, Rgb::ONE);
        for BlendedHit { t, point } in blended {
            if from.sees_hole(snapshot, point.primitive) {
                let fog = self.through_fog((ray, from), *t);
                sum += mean(seen_through * fog) * point.alpha;
            }
            seen_through *= point.see_through;
        }
        sum
    }

    /// Shafts and light of the blended surfaces, front to back, and the transmittance of all of them.
    fn blended(
        &mut self,
        (ray, from): (&Ray, Start),
        shafts: Rgb,
        blended: &[BlendedHit],
        mirrors_left: u32,
    ) -> (Shown, Rgb) {
        let (snapshot, light) = (self.snapshot, self.light);
        let (mut sum, mut seen_through) = (Shown { radiance: shafts, ..Shown::default() }, Rgb::ONE);
        let stack = Stack::of(snapshot, &light, ray, blended, self.sampler);
        for (index, hit) in blended.iter().enumerate() {
            let point = &hit.point;
            if from.sees_hole(snapshot, point.primitive) {
                seen_through *= point.see_through;
                continue;
            }
            let share = stack.as_ref().map_or(1.0, |stack| stack.shares[index]);
            let mut scattered = match &stack {
                None => direct::scattered(snapshot, light.lights, point),
                Some(stack) => stack.scattered[index],
            };
            let mut shown = Shown::emitted(light.emitted(point));
            if share > 0.0 {
                shown.indirect = share * indirect::scattered(self, point);
                scattered += share * sky_light::scattered(self, point) + shown.indirect;
                shown += self.mirrored(ray, point, mirrors_left).weakened(Rgb::splat(share));
            }
            shown.radiance = scattered + shown.radiance;
            let through_fog = self.through_fog((ray, from), hit.t);
            sum += shown.weakened(seen_through * through_fog * point.alpha);
            seen_through *= point.see_through;
        }
        (sum, seen_through)
    }

    /// Radiance that a surface scatters towards the eye.
    fn scattered(&mut self, point: &SurfacePoint) -> Shown {
        let indirect = indirect::scattered(self, point);
        if self.light.indirect_alone {
            return Shown { radiance: indirect, indirect, ..Shown::default() };
        }
        let radiance = direct::scattered(self.snapshot, self.light.lights, point)
            + sky_light::scattered(self, point)
            + indirect;
        Shown { radiance, indirect, ..Shown::default() }
    }

    /// Emission of a surface, and radiance seen in it if it is a mirror.
    pub(super) fn emitted_and_mirrored(
        &mut self,
        ray: &Ray,
        point: &SurfacePoint,
        mirrors_left: u32,
    ) -> Shown {
        Shown::emitted(self.light.emitted(point)) + self.mirrored(ray, point, mirrors_left)
    }

    /// Radiance that a mirror reflects towards the eye, and that of lamps that show in a smooth surface.
    fn mirrored(&mut self, ray: &Ray, point: &SurfacePoint, mirrors_left: u32) -> Shown {
        let images = Shown::emitted(lamps_seen::images(self, point));
        if mirrors_left == 0 || point.mirror == Rgb::ZERO {
            return images;
        }
        let normal = point.shading_normal;
        let reflected = ray.direction - 2.0 * ray.direction.dot(normal) * normal;
        // An interpolated normal may mirror a ray into the surface, where a mirror reflects nothing.
        let leaves = reflected.dot(point.geometric_normal) > 0.0;
        if !leaves {
            return images;
        }
        let ray = Ray { origin: point.position, direction: reflected.normalize() };
        let (seen, _) = self.follow(&ray, Start::Surface(point.primitive), mirrors_left - 1);
        let indirect = seen.shown.indirect + seen.airlight.indirect_shafts;
        images + Shown { indirect, ..seen.shown }.weakened(point.mirror)
    }
}

/// Mean of the colour channels.
pub(super) fn mean(transmittance: Rgb) -> f64 {
    transmittance.element_sum() / 3.0
}

/// Objects that a ray sees, each with its share after those in front of it.
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
