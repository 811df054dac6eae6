//! Sweep over the directions of a slice, from the light outwards. In go the slice's segments and falling
//! slopes. Out come the first hit of the ray of each slope, and the parts of the ray in shadow. Invariant:
//! from ray to ray the shadow only grows, so each segment enters it once.
//!
//! In the half plane through camera and light, `reach` is the distance from the axis and `height` that along
//! it. A ray has the slope `height / reach`. A point above the ray shadows it where the light's own ray
//! through the point meets it. *That ray of the light does not depend on the camera's ray.* Its name is its
//! reach for a distant light, and its angle at the light for a near one. So a segment wholly above a ray
//! shadows it over a fixed interval of these names.

use super::active::Active;
use super::light_rays::LightRays;
use super::segment::{CutEnd, Segment, ends_beside_axis, ordered};
use crate::accel::{Cut, PrimitiveId};
use crate::math::{IntervalSet, PlanarRay};
use crate::scene::Clip;
use crate::snapshot::{RaysOfInstances, View};
use glam::{DVec2, DVec3};

/// The camera's clipping planes, as a half plane cuts them.
#[derive(Clone, Copy, Debug)]
pub(super) struct PlanarClip {
    /// Depth of a point from its reach and height: metres along the view axis.
    depth: DVec2,
    clip: Clip,
}

impl PlanarClip {
    /// Clipping planes of a slice; `None` if they hide nothing.
    pub(super) fn of(view: &View, outward: DVec3, axis: DVec3) -> Option<Self> {
        let depth = DVec2::new(view.depth(outward), view.depth(axis));
        Some(Self { depth, clip: view.clip() }).filter(|planes| planes.clip != Clip::NONE)
    }

    /// Whether surfaces at a point are visible.
    fn shows(&self, point: DVec2) -> bool {
        let depth = self.depth.dot(point);
        self.clip.start_m <= depth && depth < self.clip.end_m
    }

    /// Slopes of the rays through the points where a segment crosses one of the planes.
    pub(super) fn slopes_on(&self, segment: &Segment) -> impl Iterator<Item = f64> {
        let [(a, from), (b, to)] =
            [segment.upper, segment.lower].map(|end| (end.point, self.depth.dot(end.point)));
        let crossed = [self.clip.start_m, self.clip.end_m].into_iter();
        crossed.filter(move |depth| (from < *depth) != (to < *depth)).map(move |depth| {
            let point = a + (depth - from) / (to - from) * (b - a);
            point.y / point.x
        })
    }
}

#[derive(Debug, Default)]
pub(super) struct Sweep {
    /// The camera's clipping planes, if they hide anything.
    pub(super) clip: Option<PlanarClip>,
    /// Ray visibility of instances, if not all rays meet all.
    pub(super) rays: Option<RaysOfInstances>,
    /// Segments by the first part of the slice with rays that may meet their upper ends.
    segments: Vec<Vec<Segment>>,
    /// Number of the next part.
    next: usize,
    /// Segments that rays of the current part may meet and have not yet passed.
    pub(super) active: Active,
    /// Shadows of the segments above the current ray.
    pub(super) shadows: IntervalSet,
    /// Names of the light's rays at which parts of `shadows` began and ended as they were added, and the ends
    /// of segments there.
    passed_names: Vec<f64>,
    passed_ends: Vec<CutEnd>,
    /// The active segments that the current ray meets.
    crossings: Vec<Crossing>,
    own_union: IntervalSet,
    /// Index of the nearest crossing.
    met: Option<usize>,
}

/// The first place of a number; many are compared at once.
fn position_of(number: f64, numbers: &[f64]) -> Option<usize> {
    const AT_ONCE: usize = 16;
    let is_among = |some: &[f64]| some.iter().fold(false, |any, other| any | (*other == number));
    let some = numbers.chunks(AT_ONCE).position(is_among)?;
    let from = AT_ONCE * some;
    numbers[from..].iter().position(|other| *other == number).map(|index| from + index)
}

/// Crossing of a ray and a segment, and the shadow of the segment's part above the ray.
#[derive(Clone, Copy, Debug)]
struct Crossing {
    segment: usize,
    point: DVec2,
    shadow: (f64, f64),
}

/// First hit of a ray.
#[derive(Clone, Copy, Debug)]
pub(super) struct Meeting {
    pub(super) primitive: PrimitiveId,
    /// Distance along the ray, metres.
    pub(super) distance: f64,
    /// Whether the light reaches that point.
    pub(super) is_lit: bool,
}

impl Sweep {
    /// Starts anew with the cuts of another slice. `lowest_slopes` are those of its parts, from the highest
    /// to the lowest.
    pub(super) fn start(&mut self, cuts: &[Cut], light_rays: LightRays, lowest_slopes: &[f64]) {
        self.segments.iter_mut().for_each(Vec::clear);
        self.segments.resize_with(lowest_slopes.len().max(self.segments.len()), Vec::new);
        for cut in cuts {
            let Some([upper, lower]) = ends_beside_axis(cut, light_rays) else { continue };
            let part = lowest_slopes.partition_point(|slope| *slope > upper.slope);
            if part < lowest_slopes.len() {
                let Cut { primitive, rounding, .. } = *cut;
                self.segments[part].push(Segment { primitive, upper, lower, rounding });
            }
        }
        self.next = 0;
        self.active.clear();
        self.shadows.clear();
        self.passed_names.clear();
        self.passed_ends.clear();
    }

    /// Moves on to the next part of the slice, whose rays have slopes up to `highest_slope`. `darken`
    /// receives each interval of names by which the shadow of passed segments has grown.
    pub(super) fn enter(&mut self, highest_slope: f64, darken: impl FnMut(f64, f64)) {
        self.active.extend(self.segments[self.next].drain(..));
        self.next += 1;
        self.pass(highest_slope, darken);
    }

    /// Whether the camera sees a segment at a point.
    pub(super) fn shows(&self, segment: &Segment, point: DVec2) -> bool {
        let is_seen = |rays: &RaysOfInstances| rays[segment.primitive.instance as usize].visible_to_camera;
        self.clip.is_none_or(|clip| clip.shows(point)) && self.rays.as_ref().is_none_or(is_seen)
    }

    pub(super) fn casts_shadow(&self, segment: &Segment) -> bool {
        self.rays.as_ref().is_none_or(|rays| rays[segment.primitive.instance as usize].casts_shadow)
    }

    /// End of a segment at which one of the passed shadows begins or ends.
    pub(super) fn passed_end(&self, name: f64) -> Option<CutEnd> {
        position_of(name, &self.passed_names).map(|index| self.passed_ends[index])
    }

    /// Moves segments wholly above a slope to the shadows.
    fn pass(&mut self, slope: f64, mut darken: impl FnMut(f64, f64)) {
        let Self { shadows, passed_names, passed_ends, rays, .. } = self;
        let mut add = |ends: [(f64, CutEnd); 2]| {
            let [(start, _), (end, _)] = ends;
            shadows.insert_and_tell(start, end, &mut darken);
            for (name, end) in ends {
                passed_names.push(name);
                passed_ends.push(end);
            }
        };
        // Neighbouring triangles mostly touch, and are added as one.
        let mut pending: Option<[(f64, CutEnd); 2]> = None;
        self.active.pass(slope, |segment| {
            if rays.as_ref().is_some_and(|rays| !rays[segment.primitive.instance as usize].casts_shadow) {
                return;
            }
            let shadow = segment.shadow_ends().map(|end| (end.name, segment.cut_end(end)));
            pending = match pending {
                Some([start, end]) if shadow[0].0 <= end.0 && start.0 <= shadow[1].0 => Some([
                    if shadow[0].0 < start.0 { shadow[0] } else { start },
                    if shadow[1].0 > end.0 { shadow[1] } else { end },
                ]),
                before => {
                    before.into_iter().for_each(&mut add);
                    Some(shadow)
                }
            };
        });
        pending.into_iter().for_each(add);
    }

    /// Moves on to the next ray and returns its first hit; `darken` as for [`Sweep::enter`].
    pub(super) fn advance(
        &mut self,
        ray: &PlanarRay,
        light_rays: LightRays,
        darken: impl FnMut(f64, f64),
    ) -> Option<Meeting> {
        self.pass(ray.slope, darken);
        self.crossings.clear();
        let mut first: Option<(DVec2, usize)> = None;
        for index in self.active.met_at(ray.slope) {
            let segment = self.active.segment(index);
            let point = segment.crossing(ray.direction);
            // Invisible surfaces still cast shadows.
            if self.shows(segment, point)
                && first.is_none_or(|(nearest, _)| point.dot(ray.direction) < nearest.dot(ray.direction))
            {
                first = Some((point, self.crossings.len()));
            }
            let shadow = self.shadow_on(segment, light_rays.through(point));
            self.crossings.push(Crossing { segment: index, point, shadow });
        }
        self.met = first.map(|(_, index)| index);
        let (place, met) = first?;
        let name = light_rays.through(place);
        let is_dark = |(index, crossing): (usize, &Crossing)| {
            let Crossing { segment, point, shadow: (start, end) } = *crossing;
            // Surfaces in the same place do not shadow each other, such as two leaves in one plane.
            let segment = self.active.segment(segment);
            let is_there = || point.distance(place) <= segment.rounding * (place.length() + segment.length());
            index != met && start < name && name < end && !is_there()
        };
        let is_lit = !self.shadows.contains(name) && !self.crossings.iter().enumerate().any(is_dark);
        let distance = place.dot(ray.direction);
        let primitive = self.active.segment(self.crossings[met].segment).primitive;
        Some(Meeting { primitive, distance, is_lit })
    }

    /// Names of the light's rays between which a segment casts a shadow by its part above a ray that meets it
    /// at `name`. The interval is empty if it casts none.
    fn shadow_on(&self, segment: &Segment, name: f64) -> (f64, f64) {
        if self.casts_shadow(segment) { ordered(name, segment.upper.name) } else { (name, name) }
    }

    /// Shadows on the current ray, as names of the light's rays: of passed segments, and of those that it
    /// meets, but for those beyond its end. `end` is the name there, if it hits anything. It is more precise
    /// than the segment, whose own shadow must not end before it.
    pub(super) fn shadows(&mut self, end: Option<f64>) -> (&IntervalSet, &IntervalSet) {
        if let (Some(index), Some(name)) = (self.met, end) {
            let segment = self.active.segment(self.crossings[index].segment);
            self.crossings[index].shadow = self.shadow_on(segment, name);
        }
        self.own_union.clear();
        // Names grow along a ray. In a crown most of the segments that it meets lie behind the first.
        let shadows = self.crossings.iter().map(|crossing| crossing.shadow);
        for (start, end) in shadows.filter(|(start, _)| end.is_none_or(|end| *start < end)) {
            self.own_union.insert(start, end);
        }
        (&self.shadows, &self.own_union)
    }
}

#[cfg(test)]
mod tests {
    use super::position_of;

    #[test]
    fn the_first_of_equal_numbers_is_found() {
        let numbers: Vec<f64> = (0..50).map(|number| f64::from(number % 20)).collect();
        for count in 0..numbers.len() {
            for number in [0.0, 7.0, 15.0, 16.0, 19.0, 0.5] {
                let expected = numbers[..count].iter().position(|other| *other == number);
                assert_eq!(position_of(number, &numbers[..count]), expected, "{number} of {count}");
            }
        }
    }
}
