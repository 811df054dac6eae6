//! Edges that cut a chord into pieces of uniform appearance. In go the segments that its rays may meet, out
//! come the areas at which its pieces end. A piece ends where another surface becomes visible, or where light
//! begins or ends on it. Invariant: the pieces are the whole chord, each sampled uniformly. So a superfluous
//! edge, or one missed where two leaves intersect, changes the error and not the mean.

use super::chord::Chord;
use super::light_rays::LightRays;
use super::segment::{CutEnd, Segment, ordered};
use super::slice::Slice;
use super::sweep::Sweep;
use crate::accel::PrimitiveId;
use glam::DVec2;
use std::ops::Range;
use std::ptr;

/// Maximum number of segments in a pixel whose edges are sought, and of pieces of a chord. Beyond it more
/// slices are a better use of time.
const CROWD: usize = 12;
const MOST_PIECES: usize = 8;

/// Number of equal pieces of a chord with more segments.
const CROWD_PIECES: u32 = 2;

/// Pieces smaller than this part of their chord are joined to the next.
const LEAST_PIECE: f64 = 1e-4;

/// Maximum distance between coincident ends of neighbouring triangles, as a fraction of their coordinates.
const SAME_PLACE: f64 = 1e-5;

/// Sine of the smallest angle between two triangles that makes an edge: below it both sides look alike.
const LEAST_BEND: f64 = 0.1;

/// Origin of an edge: the border of a triangle, or its shadow.
#[derive(Clone, Copy, Debug)]
pub(super) struct EdgeOrigin {
    pub(super) border: CutEnd,
    /// Triangle that the shadow lies on; `None` for a border of the triangle itself.
    pub(super) shaded: Option<PrimitiveId>,
}

#[derive(Clone, Copy, Debug)]
pub(super) struct PieceEnd {
    /// Area per radian that the slice has passed there.
    pub(super) area: f64,
    /// Slope of the ray there.
    pub(super) slope: f64,
    /// Origin of the edge; `None` at the end of the chord, too.
    pub(super) origin: Option<EdgeOrigin>,
}

/// The pieces of one chord, and memory to find them.
#[derive(Default)]
pub(super) struct Edges {
    ends: Vec<f64>,
    /// Slopes of rays through edges, with the edges' origins.
    slopes: Vec<(f64, Option<EdgeOrigin>)>,
    piece_ends: Vec<PieceEnd>,
}

impl Edges {
    /// Ends of the pieces of a chord between two slopes. Sweeps over different surfaces have entered it.
    pub(super) fn pieces(
        &mut self,
        chord: &Chord,
        slice: &Slice,
        sweeps: [&Sweep; 2],
        light_rays: LightRays,
        slopes: Range<f64>,
    ) -> &[PieceEnd] {
        self.slopes.clear();
        self.piece_ends.clear();
        let area = chord.end - chord.start;
        if area <= 0.0 {
            self.piece_ends.push(PieceEnd { area: chord.end, slope: slopes.end, origin: None });
            return &self.piece_ends;
        }
        let segments: usize = sweeps.iter().map(|sweep| sweep.active.count()).sum();
        let mut is_crowded = segments > CROWD;
        if !is_crowded {
            for sweep in sweeps {
                self.add_edges(sweep, light_rays, slopes.clone());
            }
            self.slopes.sort_unstable_by(|a, b| b.0.total_cmp(&a.0));
            is_crowded = self.slopes.len() >= MOST_PIECES;
        }
        if is_crowded {
            let end = |piece: u32| {
                let area = chord.start + area * f64::from(piece) / f64::from(CROWD_PIECES);
                PieceEnd { area, slope: slice.slope_at(slice.length_at(area)), origin: None }
            };
            self.piece_ends.extend((1..CROWD_PIECES).map(end));
        } else {
            let mut start = chord.start;
            for (slope, origin) in self.slopes.drain(..) {
                let edge = slice.area_at_slope(slope);
                if edge - start > LEAST_PIECE * area && chord.end - edge > LEAST_PIECE * area {
                    self.piece_ends.push(PieceEnd { area: edge, slope, origin });
                    start = edge;
                }
            }
        }
        self.piece_ends.push(PieceEnd { area: chord.end, slope: slopes.end, origin: None });
        &self.piece_ends
    }

    /// Adds the slopes of a sweep's edges.
    fn add_edges(&mut self, sweep: &Sweep, light_rays: LightRays, Range { start, end }: Range<f64>) {
        let Self { ends, slopes, .. } = self;
        ends.clear();
        let segments = &sweep.active;
        if segments.count() == 0 {
            return;
        }
        let is_within = |slope: &f64| end < *slope && *slope < start;
        ends.extend(segments.iter().flat_map(|segment| [segment.upper.slope, segment.lower.slope]));
        if let Some(clip) = &sweep.clip {
            ends.extend(segments.iter().flat_map(|segment| clip.slopes_on(segment)));
        }
        ends.retain(is_within);
        ends.sort_unstable_by(|a, b| b.total_cmp(a));
        ends.dedup();
        ends.push(end);
        // The visible segment, and the slope from which it is visible.
        let mut seen: Option<&Segment> = None;
        let (mut since, mut from) = (start, start);
        for &to in ends.iter() {
            let nearest = nearest(sweep, 0.5 * (from + to));
            if !nearest.map_or(seen.is_none(), |nearest| seen.is_some_and(|seen| ptr::eq(seen, nearest))) {
                if let Some(seen) = seen {
                    add_shadow_edges(seen, since..from, sweep, light_rays, slopes);
                }
                if from < start && !seen.zip(nearest).is_some_and(|(seen, next)| goes_on(seen, next)) {
                    slopes.push((from, border(seen, nearest, from)));
                }
                (seen, since) = (nearest, from);
            }
            from = to;
        }
        if let Some(seen) = seen {
            add_shadow_edges(seen, since..end, sweep, light_rays, slopes);
        }
    }
}

fn nearest(sweep: &Sweep, slope: f64) -> Option<&Segment> {
    let met = sweep.active.met_at(slope).map(|number| sweep.active.segment(number));
    let points = met.map(|segment| (segment, segment.crossing(DVec2::new(1.0, slope))));
    let reaches = points
        .filter(|(segment, point)| sweep.shows(segment, *point))
        .map(|(segment, point)| (segment, point.x));
    reaches.min_by(|a, b| a.1.total_cmp(&b.1)).map(|(segment, _)| segment)
}

/// Border of the triangle that ends where visibility changes, at a slope; `None` where two triangles
/// intersect.
fn border(before: Option<&Segment>, after: Option<&Segment>, slope: f64) -> Option<EdgeOrigin> {
    let ended = before.map(|segment| (segment, segment.lower)).filter(|(_, end)| end.slope == slope);
    let begun = after.map(|segment| (segment, segment.upper)).filter(|(_, end)| end.slope == slope);
    let (segment, end) = ended.or(begun)?;
    Some(EdgeOrigin { border: segment.cut_end(end), shaded: None })
}

/// Whether two segments are neighbouring triangles of a surface, without an edge between them.
fn goes_on(before: &Segment, after: &Segment) -> bool {
    let (end, start) = (before.lower.point, after.upper.point);
    let (a, b) = (end - before.upper.point, after.lower.point - start);
    before.primitive.instance == after.primitive.instance
        && end.distance(start) <= SAME_PLACE * (end.length() + start.length())
        && a.perp_dot(b).abs() < LEAST_BEND * a.length() * b.length()
}

/// Adds the slopes at which shadows begin or end on a segment, in the range of slopes in which it is visible.
fn add_shadow_edges(
    segment: &Segment,
    seen: Range<f64>,
    sweep: &Sweep,
    light_rays: LightRays,
    slopes: &mut Vec<(f64, Option<EdgeOrigin>)>,
) {
    let name_at = |slope: f64| light_rays.through(segment.crossing(DVec2::new(1.0, slope)));
    let (from, to) = ordered(name_at(seen.start), name_at(seen.end));
    let is_within = |name: &f64| from < *name && *name < to;
    let slope_at = |name: f64| {
        let point = segment.point_on(light_rays, name);
        point.y / point.x
    };
    let shadow_of = |border| EdgeOrigin { border, shaded: Some(segment.primitive) };
    let passed = &sweep.shadows;
    let first = passed.as_slice().partition_point(|&(_, end)| end <= from);
    for &(start, end) in passed.as_slice()[first..].iter().take_while(|(start, _)| *start < to) {
        for name in [start, end].into_iter().filter(is_within) {
            slopes.push((slope_at(name), sweep.passed_end(name).map(shadow_of)));
        }
    }
    let others = sweep.active.iter().filter(|other| !ptr::eq(*other, segment));
    for other in others.filter(|other| sweep.casts_shadow(other)) {
        for end in [other.upper, other.lower] {
            if is_within(&end.name) && !passed.contains(end.name) {
                let slope = slope_at(end.name);
                // The end is on the light's side of the segment.
                if end.slope > slope {
                    slopes.push((slope, Some(shadow_of(other.cut_end(end)))));
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accel::{Cut, PrimitiveId};
    use crate::math::PlanarRay;
    use proptest::prelude::*;

    fn ray(slope: f64) -> PlanarRay {
        PlanarRay::new(DVec2::new(1.0, slope).normalize())
    }

    proptest! {
        /// Leaves that do not touch, one in each cell of a grid: there is an edge wherever visibility or
        /// light changes.
        #[test]
        fn nothing_changes_between_edges(
            leaves in prop::collection::vec((prop::array::uniform2(0.05..0.95_f64), prop::array::uniform2(0.05..0.95_f64)), 12),
            lamp in prop::option::of(4.0..9.0_f64),
        ) {
            let light_rays = lamp.map_or(LightRays::Parallel, LightRays::From);
            let cuts: Vec<Cut> = leaves.iter().enumerate().map(|(number, &(a, b))| {
                let corner = DVec2::new(1.0 + (number % 4) as f64, (number / 4) as f64 - 1.5);
                let primitive = PrimitiveId { instance: number as u32, triangle: 0 };
                Cut { primitive, ends: [corner + DVec2::from(a), corner + DVec2::from(b)], rounding: Cut::SINGLE }
            }).collect();
            let (highest, lowest) = (1.2, -1.2);
            let mut sweep = Sweep::default();
            sweep.start(&cuts, light_rays, &[lowest]);
            sweep.enter(highest, |_, _| {});
            let mut edges = Edges::default();
            edges.add_edges(&sweep, light_rays, highest..lowest);

            let mut before = None;
            let steps = 1000;
            for step in 0..=steps {
                let slope = highest + (lowest - highest) * f64::from(step) / f64::from(steps);
                let seen = sweep.advance(&ray(slope), light_rays, |_, _| {}).map(|met| (met.primitive, met.is_lit));
                if let Some((last, last_seen)) = before {
                    let has_edge = edges.slopes.iter().any(|(edge, _)| slope - 1e-6 <= *edge && *edge <= last + 1e-6);
                    prop_assert!(seen == last_seen || has_edge, "{last}: {last_seen:?}, {slope}: {seen:?}, {:?}", edges.slopes);
                }
                before = Some((slope, seen));
            }
        }
    }

    /// The triangles of a flat leaf have no edge between them, those of a folded one have.
    #[test]
    fn a_surface_goes_on_where_it_does_not_bend() {
        let cut = |triangle: u32, a: DVec2, b: DVec2| Cut {
            primitive: PrimitiveId { instance: 0, triangle },
            ends: [a, b],
            rounding: Cut::SINGLE,
        };
        let edges_of = |fold: DVec2| {
            let (start, middle) = (DVec2::new(2.0, 1.0), DVec2::new(2.0, 0.0));
            let cuts = [cut(0, start, middle), cut(1, middle, middle + fold)];
            let mut sweep = Sweep::default();
            sweep.start(&cuts, LightRays::Parallel, &[-1.0]);
            sweep.enter(1.0, |_, _| {});
            let mut edges = Edges::default();
            edges.add_edges(&sweep, LightRays::Parallel, 1.0..-1.0);
            edges.slopes.iter().map(|(slope, _)| *slope).collect::<Vec<_>>()
        };
        // From the leaf's upper end to its lower one.
        assert_eq!(edges_of(DVec2::new(0.0, -1.0)), [0.5, -0.5]);
        assert_eq!(edges_of(DVec2::new(1.0, -1.0)), [0.5, 0.0, -1.0 / 3.0]);
    }
}
