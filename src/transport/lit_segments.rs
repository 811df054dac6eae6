//! The exact method. In go a ray, a light and the fog, out comes the light scattered along the
//! ray: visibility is a union of intervals found from the triangles themselves, and what is left
//! is integrated on smooth pieces. Invariant: nothing is sampled, nothing is stepped.

use super::near_light::NearLight;
use super::sun_stretch::SunStretch;
use super::veils::Veils;
use super::visibility::Way;
use crate::accel::LightPlane;
use crate::color::Rgb;
use crate::math::{IntervalSet, Ray};
use crate::scattering::{Medium, Stretch};
use crate::snapshot::{Emission, FrozenLight, Snapshot};
use glam::DVec3;
use std::ops::Range;

/// The parts of a ray that one light reaches.
#[derive(Clone, Debug, Default)]
pub struct LitSegments {
    shadows: IntervalSet,
    range: (f64, f64),
    /// What dims the rest of it.
    veils: Veils,
}

impl LitSegments {
    /// What `shadows` leave of `range`.
    pub fn from_shadows(shadows: IntervalSet, range: (f64, f64)) -> Self {
        Self { shadows, range, veils: Veils::default() }
    }

    /// Takes what the scene's `shadows` leave, where they are known already.
    pub(super) fn set(
        &mut self,
        ray: &Ray,
        light: &FrozenLight,
        range: (f64, f64),
        shadows: impl Iterator<Item = (f64, f64)>,
    ) {
        self.start(ray, light, range);
        for (start, end) in shadows {
            self.shadows.insert(start, end);
        }
    }

    /// Everything is lit, but for where the light does not shine.
    fn start(&mut self, ray: &Ray, light: &FrozenLight, range: (f64, f64)) {
        self.shadows.clear();
        self.veils.clear();
        self.range = range;
        if let FrozenLight::Point { position, emission, .. } = light {
            self.shade_outside(emission, ray, *position);
        }
    }

    /// Finds what `light` reaches of `ray` within `range`, which must not reach beyond the first surface.
    pub fn find(&mut self, snapshot: &Snapshot, ray: &Ray, light: &FrozenLight, range: (f64, f64)) {
        self.find_along(snapshot, ray, light, range, &Way::default());
    }

    /// The same of a ray that passes what lies on its way.
    pub(super) fn find_along(
        &mut self,
        snapshot: &Snapshot,
        ray: &Ray,
        light: &FrozenLight,
        range: (f64, f64),
        way: &Way,
    ) {
        self.start(ray, light, range);
        let plane = match *light {
            FrozenLight::Sun { to_light, .. } => LightPlane::towards_direction(ray, to_light, range),
            FrozenLight::Point { position, .. } => LightPlane::towards_point(ray, position, range),
        };
        if snapshot.has_blended() {
            self.veils.find(snapshot, ray, light, plane.as_ref(), range, &way.blended);
        }
        match plane {
            Some(plane) if way.passes_hidden => {
                let mut shadows = Vec::new();
                snapshot.tree.add_each_shadow(&plane, &mut shadows);
                shadows.into_iter().for_each(|shadow| self.shadows.insert(shadow.start, shadow.end));
            }
            Some(plane) => snapshot.tree.add_shadows(&plane, &mut self.shadows),
            None => {
                if is_blocked_in_line(snapshot, ray, light, range) {
                    self.shadows.insert(range.0, range.1);
                }
            }
        }
    }

    /// Calls `lit(start, end)` for each lit part, in order.
    pub fn for_each(&self, lit: impl FnMut(f64, f64)) {
        self.shadows.for_each_gap(self.range.0, self.range.1, lit);
    }

    /// Total length of the lit parts, metres.
    pub fn length(&self) -> f64 {
        let mut length = 0.0;
        self.for_each(|start, end| length += end - start);
        length
    }

    /// Radiance scattered into the ray from its lit parts, W m^-2 sr^-1.
    pub fn integrate(&self, medium: &Medium, stretches: &[Stretch], ray: &Ray, light: &FrozenLight) -> Rgb {
        let mut sum = Rgb::ZERO;
        match *light {
            FrozenLight::Sun { to_light, irradiance } => {
                for stretch in stretches {
                    let mut sunny = None;
                    self.for_each_part(self.part_of(stretch), |start, end, share| {
                        let sunny =
                            sunny.get_or_insert_with(|| SunStretch::new(medium, stretch, ray, to_light));
                        sum += share * sunny.integral(start, end);
                    });
                }
                sum * irradiance
            }
            FrozenLight::Point { position, intensity, emission } => {
                for stretch in stretches {
                    let near = NearLight::new(medium, stretch, ray, position, emission);
                    sum +=
                        near.integral(self.part_of(stretch), &|range, part| self.for_each_part(range, part));
                }
                sum * intensity
            }
        }
    }

    /// What the range holds of a stretch; the end may come before the start.
    fn part_of(&self, stretch: &Stretch) -> Range<f64> {
        stretch.start.max(self.range.0)..stretch.end.min(self.range.1)
    }

    /// Lit parts of a range, with the share of the light that is left there.
    fn for_each_part(&self, range: Range<f64>, mut lit: impl FnMut(f64, f64, Rgb)) {
        self.shadows.for_each_gap(range.start, range.end, |start, end| {
            self.veils.for_each_piece(start, end, &mut lit);
        });
    }

    /// What lies outside a spot's cone, or behind a flat light, counts as shadow.
    fn shade_outside(&mut self, emission: &Emission, ray: &Ray, position: DVec3) {
        let borders = emission.borders(ray, position);
        let mut start = self.range.0;
        for end in borders.into_iter().flatten().chain([self.range.1]) {
            let end = end.clamp(start, self.range.1);
            if !emission.reaches(ray.at(0.5 * (start + end)) - position) {
                self.shadows.insert(start, end);
            }
            start = end;
        }
    }
}

/// Ray and light in one line: the whole range is lit or dark.
fn is_blocked_in_line(snapshot: &Snapshot, ray: &Ray, light: &FrozenLight, range: (f64, f64)) -> bool {
    // The middle of the range sees the light along the ray itself, forwards or backwards. Between
    // the ray's origin and the end of the range there is nothing, so one ray from there will do.
    let origin = ray.at(0.5 * (range.0 + range.1));
    let (to_light, distance, _) = light.arriving_at(origin);
    snapshot.tree.any_hit(&Ray { origin, direction: to_light }, distance, None)
}
