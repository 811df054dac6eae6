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

/// A ray of the camera within the half plane.
#[derive(Clone, Copy, Debug)]
pub(super) struct PlanarRay {
    /// Unit vector: reach and height per metre.
    pub(super) direction: DVec2,
    /// Height per reach.
    pub(super) slope: f64,
}

impl PlanarRay {
    pub(super) fn new(direction: DVec2) -> Self {
        Self { direction, slope: direction.y / direction.x }
    }
}

/// Places count as the same within this fraction of their coordinates: 16 roundings of the single
/// precision in which segments are cut.
const SAME_PLACE: f64 = 1e-6;

/// A segment of the slice that some ray meets.
#[derive(Clone, Copy, Debug)]
struct Segment {
    primitive: PrimitiveId,
    upper: End,
    lower: End,
    /// The first ray that it lies wholly above.
    until: u32,
}

/// An end of a segment.
#[derive(Clone, Copy, Debug)]
struct End {
    point: DVec2,
    slope: f64,
    /// The light's ray through it.
    name: f64,
}

impl Segment {
    /// Where a ray meets the segment that it is known to meet.
    fn crossing(&self, ray: &PlanarRay) -> DVec2 {
        let (a, b) = (self.upper.point, self.lower.point);
        let (above, below) = (ray.direction.perp_dot(a), ray.direction.perp_dot(b));
        let fraction = above / (above - below);
        // Seen edge-on the two are alike, and any place will do.
        let fraction = if fraction.is_nan() { 0.0 } else { fraction.clamp(0.0, 1.0) };
        a + fraction * (b - a)
    }

    fn length(&self) -> f64 {
        self.upper.point.distance(self.lower.point)
    }

    fn shadow(&self) -> (f64, f64) {
        ordered(self.upper.name, self.lower.name)
    }
}

fn ordered(a: f64, b: f64) -> (f64, f64) {
    (a.min(b), a.max(b))
}

/// The state of the sweep.
#[derive(Debug, Default)]
pub(super) struct Sweep {
    /// By the first ray below their upper ends: segments that rays meet, and the shadows of those that
    /// lie between two rays.
    segments: Buckets<Segment>,
    passed_shadows: Buckets<(f64, f64)>,
    /// Number of the next ray.
    next: usize,
    /// Segments that the current ray meets.
    active: Vec<Segment>,
    /// What the segments above the current ray shadow.
    shadows: IntervalSet,
    /// Where each active segment is met and what its upper part shadows, and the union of that.
    own_shadows: Vec<(DVec2, f64, f64)>,
    own_union: IntervalSet,
    /// Which of the active segments is met first.
    met: Option<usize>,
}

/// What a ray meets first.
#[derive(Clone, Copy, Debug)]
pub(super) struct Meeting {
    pub(super) primitive: PrimitiveId,
    /// Where, metres along the ray.
    pub(super) distance: f64,
    /// Whether the light reaches the place where it is met.
    pub(super) is_lit: bool,
}

impl Sweep {
    /// Starts over with the cuts of another slice and the slopes of its rays, from the highest to the lowest.
    pub(super) fn start(&mut self, cuts: &[Cut], light_rays: LightRays, slopes: &[f64]) {
        self.segments.clear();
        self.passed_shadows.clear();
        for cut in cuts {
            let Some([upper, lower]) = ends_beside_axis(cut, light_rays) else { continue };
            // An end on a ray counts as above it, for all segments alike.
            let from = slopes.partition_point(|slope| *slope > upper.slope);
            let until = from + slopes[from..].iter().take_while(|slope| **slope > lower.slope).count();
            if from == slopes.len() {
                continue;
            }
            let segment = Segment { primitive: cut.primitive, upper, lower, until: until as u32 };
            if from < until {
                self.segments.push(from, segment);
            } else {
                self.passed_shadows.push_or_merge(from, segment.shadow());
            }
        }
        self.segments.sort(slopes.len());
        self.passed_shadows.sort(slopes.len());
        self.next = 0;
        self.active.clear();
        self.shadows.clear();
    }

    /// Goes on to the next ray and says what it meets first. `darken` is told between which of the
    /// light's rays the shadow of what lies above has grown.
    pub(super) fn advance(
        &mut self,
        ray: &PlanarRay,
        light_rays: LightRays,
        mut darken: impl FnMut(f64, f64),
    ) -> Option<Meeting> {
        let (current, union) = (self.next, &mut self.shadows);
        self.next += 1;
        let mut add = |(start, end): (f64, f64)| {
            union.for_each_gap(start, end, &mut darken);
            union.insert(start, end);
        };
        self.passed_shadows.bucket(current).iter().copied().for_each(&mut add);
        self.active.retain(|segment| {
            let is_met = segment.until as usize > current;
            if !is_met {
                add(segment.shadow());
            }
            is_met
        });
        self.active.extend_from_slice(self.segments.bucket(current));

        self.own_shadows.clear();
        let mut first: Option<(DVec2, usize)> = None;
        for (index, segment) in self.active.iter().enumerate() {
            let point = segment.crossing(ray);
            if first.is_none_or(|(nearest, _)| point.dot(ray.direction) < nearest.dot(ray.direction)) {
                first = Some((point, index));
            }
            let (start, end) = ordered(light_rays.through(point), segment.upper.name);
            self.own_shadows.push((point, start, end));
        }
        self.met = first.map(|(_, index)| index);
        let (place, met) = first?;
        let name = light_rays.through(place);
        let is_dark = |index: usize| {
            let (point, start, end) = self.own_shadows[index];
            // What lies in the same place does not shadow it: two leaves in one plane, say.
            let is_there =
                point.distance(place) <= SAME_PLACE * (place.length() + self.active[index].length());
            index != met && !is_there && start < name && name < end
        };
        let is_lit = !self.shadows.contains(name) && !(0..self.active.len()).any(is_dark);
        let distance = place.dot(ray.direction);
        Some(Meeting { primitive: self.active[met].primitive, distance, is_lit })
    }

    /// Names of the light's rays that do not reach the current ray: what lies above it blocks them, and
    /// what it meets. `end` names the one through the place where the ray ends, if it meets anything: better known than the
    /// segment there, whose own shadow must not end before.
    pub(super) fn shadows(&mut self, end: Option<f64>) -> (&IntervalSet, &IntervalSet) {
        if let (Some(index), Some(name)) = (self.met, end) {
            let (point, ..) = self.own_shadows[index];
            let (start, end) = ordered(name, self.active[index].upper.name);
            self.own_shadows[index] = (point, start, end);
        }
        self.own_union.clear();
        for &(_, start, end) in &self.own_shadows {
            self.own_union.insert(start, end);
        }
        (&self.shadows, &self.own_union)
    }
}

/// The ends of a cut, the upper first, without the part beyond the axis; `None` if nothing is left.
fn ends_beside_axis(cut: &Cut, light_rays: LightRays) -> Option<[End; 2]> {
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
        // Through the camera itself: neither above nor below anything.
        let slope = if slope.is_nan() { f64::NEG_INFINITY } else { slope };
        End { point, slope, name: light_rays.through(point) }
    };
    let (mut a, mut b) = (end(clipped(a, b)), end(clipped(b, a)));
    // Out of the camera itself, but for rounding: seen edge-on, so that no ray but one meets it.
    let length = a.point.distance(b.point);
    if a.point.length() <= SAME_PLACE * length {
        a.slope = b.slope;
    } else if b.point.length() <= SAME_PLACE * length {
        b.slope = a.slope;
    }
    Some(if a.slope >= b.slope { [a, b] } else { [b, a] })
}

/// Things by number, sorted in linear time; those of one number stay in the order in which they came.
#[derive(Debug)]
struct Buckets<T> {
    unsorted: Vec<(u32, T)>,
    sorted: Vec<T>,
    /// Where each bucket ends.
    ends: Vec<u32>,
}

impl<T> Default for Buckets<T> {
    fn default() -> Self {
        Self { unsorted: Vec::new(), sorted: Vec::new(), ends: Vec::new() }
    }
}

impl<T: Copy> Buckets<T> {
    fn clear(&mut self) {
        self.unsorted.clear();
    }

    fn push(&mut self, bucket: usize, item: T) {
        self.unsorted.push((bucket as u32, item));
    }

    /// Makes `buckets` buckets of what was pushed.
    fn sort(&mut self, buckets: usize) {
        let Self { unsorted, sorted, ends } = self;
        ends.clear();
        ends.resize(buckets, 0);
        for (bucket, _) in unsorted.iter() {
            ends[*bucket as usize] += 1;
        }
        let mut start = 0;
        for end in ends.iter_mut() {
            let count = *end;
            *end = start;
            start += count;
        }
        sorted.clear();
        sorted.extend(unsorted.iter().map(|(_, item)| *item));
        for (bucket, item) in unsorted.iter() {
            let place = &mut ends[*bucket as usize];
            sorted[*place as usize] = *item;
            *place += 1;
        }
    }

    fn bucket(&self, bucket: usize) -> &[T] {
        let start = if bucket == 0 { 0 } else { self.ends[bucket - 1] };
        &self.sorted[start as usize..self.ends[bucket] as usize]
    }
}

impl Buckets<(f64, f64)> {
    /// Pushes an interval, or widens the one pushed last where the two touch: neighbouring triangles mostly do.
    fn push_or_merge(&mut self, bucket: usize, (start, end): (f64, f64)) {
        match self.unsorted.last_mut() {
            Some((last, interval))
                if *last as usize == bucket && start <= interval.1 && end >= interval.0 =>
            {
                *interval = (interval.0.min(start), interval.1.max(end));
            }
            _ => self.push(bucket, (start, end)),
        }
    }
}
