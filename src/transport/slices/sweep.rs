//! The sweep over the directions of a slice, from the light outwards. In go the slice's segments
//! and ever lower slopes, out come what a ray of that slope meets first and which part of it lies in
//! shadow. Invariant: between two slopes the shadow only grows, so each segment enters it once.
//!
//! In the half plane through camera and light let `reach` be the distance from the axis and `height`
//! that along it. A ray has the slope `height / reach`; a point above it shadows the ray where the
//! light's own ray through the point meets it, and *which of the light's rays that is does not depend
//! on the camera's ray*: it is named by the reach for a distant light, and by the angle at the light
//! for a near one. So a segment wholly above a ray shadows it over an interval of these names that
//! is known beforehand.

use crate::accel::{Cut, PrimitiveId};
use crate::math::IntervalSet;
use glam::DVec2;

/// How the light's rays are named within a half plane.
#[derive(Clone, Copy, Debug)]
pub(super) enum LightRays {
    /// All parallel to the axis: by their distance from it.
    Parallel,
    /// Out of a point on the axis at this height: by the angle with the way back to the camera.
    From(f64),
}

impl LightRays {
    /// The name of the light's ray through a point.
    pub(super) fn through(self, point: DVec2) -> f64 {
        match self {
            Self::Parallel => point.x,
            Self::From(height) => point.x.atan2(height - point.y),
        }
    }

    /// Reach of the point where a ray of the light meets the camera's ray of a slope; infinite if it does not.
    pub(super) fn reach(self, name: f64, slope: f64) -> f64 {
        match self {
            Self::Parallel => name,
            Self::From(height) => {
                // reach = tan(name) (height - slope reach).
                let (sin, cos) = name.sin_cos();
                let divisor = cos + slope * sin;
                if divisor > 0.0 { height * sin / divisor } else { f64::INFINITY }
            }
        }
    }
}

/// Places count as the same within this fraction of their coordinates: 16 roundings of the single
/// precision in which segments are cut.
const SAME_PLACE: f64 = 1e-6;

/// A segment of the slice, ready for the sweep.
#[derive(Clone, Copy, Debug)]
struct Segment {
    primitive: PrimitiveId,
    ends: [DVec2; 2],
    slopes: [f64; 2],
    names: [f64; 2],
}

impl Segment {
    fn upper_slope(&self) -> f64 {
        self.slopes[0].max(self.slopes[1])
    }

    fn shadow(&self) -> (f64, f64) {
        (self.names[0].min(self.names[1]), self.names[0].max(self.names[1]))
    }

    fn length(&self) -> f64 {
        self.ends[0].distance(self.ends[1])
    }

    /// Whether each end lies above a ray; ends on the ray count as above, for all segments alike.
    fn above(&self, slope: f64) -> [bool; 2] {
        self.slopes.map(|end| end >= slope)
    }

    /// Where a ray meets the segment that it is known to meet.
    fn crossing(&self, slope: f64) -> DVec2 {
        let [a, b] = self.ends;
        let (above_a, above_b) = (a.y - slope * a.x, b.y - slope * b.x);
        let fraction = above_a / (above_a - above_b);
        let reach = a.x + fraction.clamp(0.0, 1.0) * (b.x - a.x);
        DVec2::new(reach, slope * reach)
    }
}

/// The state of the sweep.
#[derive(Debug, Default)]
pub(super) struct Sweep {
    /// By descending upper slope.
    segments: Vec<Segment>,
    next: usize,
    /// Segments that the current ray meets.
    active: Vec<Segment>,
    /// What the segments above the current ray shadow.
    shadows: IntervalSet,
}

/// What a ray meets first.
#[derive(Clone, Copy, Debug)]
pub(super) struct Meeting {
    pub(super) primitive: PrimitiveId,
    /// Whether the light reaches the place where it is met.
    pub(super) is_lit: bool,
}

impl Sweep {
    /// Starts over with the cuts of another slice.
    pub(super) fn start(&mut self, cuts: &[Cut], rays: LightRays, lowest_slope: f64) {
        self.segments.clear();
        self.segments.extend(cuts.iter().filter_map(|cut| segment(cut, rays, lowest_slope)));
        self.segments.sort_by(|a, b| b.upper_slope().total_cmp(&a.upper_slope()));
        self.next = 0;
        self.active.clear();
        self.shadows.clear();
    }

    /// Goes on to a ray of a lower slope, says what it meets first, and leaves in `shadows` the names
    /// of all of the light's rays that do not reach it before that.
    pub(super) fn advance(
        &mut self,
        slope: f64,
        rays: LightRays,
        shadows: &mut IntervalSet,
    ) -> Option<Meeting> {
        while let Some(segment) = self.segments.get(self.next).filter(|s| s.upper_slope() >= slope) {
            self.active.push(*segment);
            self.next += 1;
        }
        let union = &mut self.shadows;
        self.active.retain(|segment| {
            let is_above = segment.above(slope) == [true, true];
            if is_above {
                let (start, end) = segment.shadow();
                union.insert(start, end);
            }
            !is_above
        });

        shadows.clone_from(union);
        let mut first: Option<(f64, usize)> = None;
        for (index, segment) in self.active.iter().enumerate() {
            let meets = segment.crossing(slope);
            if first.is_none_or(|(reach, _)| meets.x < reach) {
                first = Some((meets.x, index));
            }
        }
        let (reach, met) = first?;
        let primitive = self.active[met].primitive;
        let name = rays.through(DVec2::new(reach, slope * reach));
        let mut is_lit = !shadows.contains(name);
        for (index, segment) in self.active.iter().enumerate() {
            let meets = segment.crossing(slope);
            let crossing = rays.through(meets);
            let upper_end = segment.names[usize::from(!segment.above(slope)[0])];
            let (start, end) = (crossing.min(upper_end), crossing.max(upper_end));
            shadows.insert(start, end);
            // What lies in the same place does not shadow it: two leaves in one plane, say.
            let is_there = (meets.x - reach).abs() <= SAME_PLACE * (reach + segment.length());
            is_lit &= index == met || is_there || !(start < name && name < end);
        }
        Some(Meeting { primitive, is_lit })
    }
}

/// A cut without the part beyond the axis; `None` if nothing is left that matters.
fn segment(cut: &Cut, rays: LightRays, lowest_slope: f64) -> Option<Segment> {
    let [a, b] = cut.ends;
    if a.x.max(b.x) <= 0.0 {
        return None;
    }
    let clipped = |end: DVec2, other: DVec2| {
        if end.x >= 0.0 {
            return end;
        }
        let fraction = end.x / (end.x - other.x);
        DVec2::new(0.0, end.y + fraction * (other.y - end.y))
    };
    let ends = [clipped(a, b), clipped(b, a)];
    let slopes = ends.map(|end| {
        let slope = end.y / end.x;
        // Through the camera itself: neither above nor below anything.
        if slope.is_nan() { f64::NEG_INFINITY } else { slope }
    });
    (slopes[0].max(slopes[1]) >= lowest_slope).then(|| Segment {
        primitive: cut.primitive,
        ends,
        slopes,
        names: ends.map(|end| rays.through(end)),
    })
}
