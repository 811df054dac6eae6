//! Segment: a triangle's cut, with the camera rays and the light's rays through its ends. In go cuts, out
//! come segments. Invariant: the upper end comes first, and no part lies beyond the axis.

use super::light_rays::LightRays;
use crate::accel::{Cut, PrimitiveId};
use glam::DVec2;

#[derive(Clone, Copy, Debug)]
pub(super) struct Segment {
    pub(super) primitive: PrimitiveId,
    pub(super) upper: End,
    pub(super) lower: End,
    /// See [`Cut::rounding`].
    pub(super) rounding: f64,
}

/// An end of a segment, with its triangle.
#[derive(Clone, Copy, Debug)]
pub(super) struct CutEnd {
    pub(super) primitive: PrimitiveId,
    /// Reach and height.
    pub(super) point: DVec2,
}

#[derive(Clone, Copy, Debug)]
pub(super) struct End {
    pub(super) point: DVec2,
    pub(super) slope: f64,
    /// Name of the light's ray through it.
    pub(super) name: f64,
}

impl Segment {
    /// Intersection of a ray with the segment; the ray is known to meet it.
    pub(super) fn crossing(&self, direction: DVec2) -> DVec2 {
        let (a, b) = (self.upper.point, self.lower.point);
        let (above, below) = (direction.perp_dot(a), direction.perp_dot(b));
        let fraction = above / (above - below);
        // Where the segment is seen edge-on any point will do.
        let fraction = if fraction.is_nan() { 0.0 } else { fraction.clamp(0.0, 1.0) };
        a + fraction * (b - a)
    }

    /// Intersection of one of the light's rays with the segment's line.
    pub(super) fn point_on(&self, light_rays: LightRays, name: f64) -> DVec2 {
        let (a, b) = (self.upper.point, self.lower.point);
        let (origin, direction) = light_rays.line(name);
        a + (origin - a).perp_dot(direction) / (b - a).perp_dot(direction) * (b - a)
    }

    pub(super) fn cut_end(&self, end: End) -> CutEnd {
        CutEnd { primitive: self.primitive, point: end.point }
    }

    pub(super) fn length(&self) -> f64 {
        self.upper.point.distance(self.lower.point)
    }

    /// The ends between which its shadow lies, in the order of their names.
    pub(super) fn shadow_ends(&self) -> [End; 2] {
        if self.upper.name <= self.lower.name { [self.upper, self.lower] } else { [self.lower, self.upper] }
    }
}

pub(super) fn ordered(a: f64, b: f64) -> (f64, f64) {
    (a.min(b), a.max(b))
}

/// Ends of a cut, the upper first, without the part beyond the axis; `None` if nothing is left.
pub(super) fn ends_beside_axis(cut: &Cut, light_rays: LightRays) -> Option<[End; 2]> {
    let [a, b] = cut.ends;
    if a.x.max(b.x) <= 0.0 {
        return None;
    }
    let clipped = |end: DVec2, other: DVec2| {
        // Not at -0 either, whose slope has the wrong sign.
        if end.x > 0.0 {
            return end;
        }
        let fraction = end.x / (end.x - other.x);
        DVec2::new(0.0, end.y + fraction * (other.y - end.y))
    };
    let end = |point: DVec2| {
        let slope = point.y / point.x;
        // A cut through the camera itself is neither above nor below any ray.
        let slope = if slope.is_nan() { f64::NEG_INFINITY } else { slope };
        End { point, slope, name: light_rays.through(point) }
    };
    let (mut a, mut b) = (end(clipped(a, b)), end(clipped(b, a)));
    // A cut that begins at the camera, to rounding, is seen edge-on: only one ray meets it.
    let length = a.point.distance(b.point);
    if a.point.length() <= cut.rounding * length {
        a.slope = b.slope;
    } else if b.point.length() <= cut.rounding * length {
        b.slope = a.slope;
    }
    // A cut that begins at the light, such as a lamp in a wall, is edge-on to it and shadows only one ray.
    if let LightRays::From(height) = light_rays {
        let same_m = cut.rounding * (length + height.abs());
        let is_at_light = |end: &End| end.point.distance(DVec2::new(0.0, height)) <= same_m;
        if is_at_light(&a) {
            a.name = b.name;
        } else if is_at_light(&b) {
            b.name = a.name;
        }
    }
    Some(if a.slope >= b.slope { [a, b] } else { [b, a] })
}
