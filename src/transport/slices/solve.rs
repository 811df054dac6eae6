//! One slice, solved. In go the slice and where its samples lie, out come the samples' values.
//! Invariant: each value is what the per-ray method finds for the same ray, to rounding.

use super::border::Borders;
use super::chord::Chord;
use super::edges::Edges;
use super::fan::{Fan, LEAST_SPREAD, Place, Slice};
use super::outline::Outline;
use super::slice_job::SliceJob;
use super::slice_ray::SliceRay;
use super::sweep::{LightRays, PlanarClip, Sweep};
use super::veiled::VeilSweep;
use crate::accel::{Cut, HalfPlane};
use crate::fog::FogSlice;
use crate::math::{PlanarRay, Ray, Sampler, kronecker};
use crate::snapshot::{Facet, FrozenLight, Snapshot};
use crate::transport::Sample;
use crate::transport::path::Scratch;
use glam::DVec2;

/// Memory that the slices of one thread share.
#[derive(Default)]
pub struct SliceScratch {
    chords: Vec<Chord>,
    lowest_slopes: Vec<f64>,
    cuts: Vec<Cut>,
    sweep: Sweep,
    veils: VeilSweep,
    edges: Edges,
    fog: FogSlice,
    followed: Scratch,
}

/// A part of a chord all of which sees the same things, and the sample that stands for it.
pub struct Piece<'a> {
    /// The chord.
    pub chord: &'a Chord,
    /// Where the sample lies.
    pub place: Place,
    /// Between which parts of the chord's area it lies, `0..=1`.
    pub range: [f64; 2],
    /// What it counts, as the area does that it stands for.
    pub weight: f64,
}

/// Calls back with each piece of a slice's chords, in their order, away from the light, and with what its sample sees by the slice's light alone. Rays that blended surfaces touch
/// are followed by themselves. Notes the outline of what is seen if it is given one, begun by the caller. Returns how many segments
/// the slice gathered; `None` if there is no chord, and so nothing done.
pub fn solve(
    job: &SliceJob,
    slice: &Slice,
    of_slice: impl Iterator<Item = Chord>,
    mut outline: Option<&mut Outline>,
    scratch: &mut SliceScratch,
    mut sample: impl FnMut(&Piece, &Sample),
) -> Option<usize> {
    let (snapshot, light, eye) = (job.snapshot, job.light, job.fan.eye);
    let light_rays = match *light {
        FrozenLight::Sun { .. } => LightRays::Parallel,
        FrozenLight::Point { position, .. } => LightRays::From((position - eye).length()),
    };
    let planar = |place: &Place| planar(job.fan, slice, place);
    let SliceScratch { chords, lowest_slopes, cuts, sweep, veils, edges, fog, followed } = scratch;
    chords.clear();
    chords.extend(of_slice);
    lowest_slopes.clear();
    lowest_slopes.extend(chords.iter().map(|chord| chord.slopes[1]));
    let lowest_slope = *lowest_slopes.last()?;
    let half_plane = HalfPlane { eye, axis: job.fan.axis, outward: slice.outward, lowest_slope };
    let clip = PlanarClip::of(&snapshot.view, slice.outward, job.fan.axis);
    (sweep.clip, veils.sweep.clip) = (clip, clip);
    cuts.clear();
    snapshot.blended.add_cuts(&half_plane, cuts);
    let blended_cuts = cuts.len();
    veils.start(cuts, light_rays, lowest_slopes);
    cuts.clear();
    snapshot.tree.add_cuts(&half_plane, cuts);
    sweep.start(cuts, light_rays, lowest_slopes);
    let middle_slope = lowest_slopes[lowest_slopes.len() / 2];
    fog.start(&snapshot.medium, light, &half_plane, middle_slope, cuts);

    let mut met: Option<Facet> = None;
    let borders = Borders::new(snapshot, job.fan, slice, light_rays);
    for chord in chords.iter() {
        let [highest_slope, lowest_slope] = chord.slopes;
        sweep.enter(highest_slope, |start, end| fog.darken(start, end));
        veils.enter(highest_slope);
        let mut piece_start = chord.start;
        let chord_area = chord.end - chord.start;
        let ends = edges.pieces(chord, slice, [sweep, &veils.sweep], light_rays, highest_slope..lowest_slope);
        let mut piece_slope = highest_slope;
        for (number, end) in ends.iter().enumerate() {
            let piece_end = end.area;
            let phase = kronecker(chord.phase, number);
            let area = piece_end - piece_start;
            let place = slice.place(piece_start + phase * area);
            let planar = planar(&place);
            let meeting = sweep.advance(&planar, light_rays, |start, end| fog.darken(start, end));
            if let Some(meeting) =
                meeting.filter(|meeting| met.is_none_or(|met| met.primitive != meeting.primitive))
            {
                met = Some(snapshot.facet(meeting.primitive));
            }
            let random = (chord.phase * f64::from(u32::MAX)) as u32;
            let (x, y) = chord.pixel;
            let slice_ray = SliceRay {
                job,
                ray: Ray { origin: eye, direction: place.direction },
                planar,
                light_rays,
                meeting: meeting.zip(met.as_ref()),
                sampler: Sampler::new(x as u32, y as u32, number as u32, random),
            };
            let is_veiled = blended_cuts > 0 && veils.touches(&planar, light_rays, slice_ray.distance());
            let value =
                if is_veiled { slice_ray.by_itself(followed) } else { slice_ray.value(sweep, fog, followed) };
            let range = [piece_start, piece_end].map(|end| (end - chord.start) / chord_area);
            sample(&Piece { chord, place, range, weight: chord.weight_per_area * area }, &value);
            if let Some(outline) = &mut outline {
                outline.add(chord.pixel, piece_slope, end.slope);
                if number + 1 < ends.len() {
                    outline.end(end.origin.and_then(|origin| borders.of(&origin)));
                }
            }
            (piece_start, piece_slope) = (piece_end, end.slope);
        }
    }
    Some(blended_cuts + cuts.len())
}

/// How many segments a whole slice would gather of what is not blended.
pub fn count_segments(snapshot: &Snapshot, fan: &Fan, slice: &Slice) -> usize {
    let lowest_slope = slice.slope_at(slice.length);
    let half_plane = HalfPlane { eye: fan.eye, axis: fan.axis, outward: slice.outward, lowest_slope };
    let mut cuts = Vec::new();
    snapshot.tree.add_cuts(&half_plane, &mut cuts);
    cuts.len()
}

fn planar(fan: &Fan, slice: &Slice, place: &Place) -> PlanarRay {
    // Rounding must not put a ray along the axis on the other side of it.
    let reach = place.direction.dot(slice.outward).max(LEAST_SPREAD);
    PlanarRay::new(DVec2::new(reach, place.direction.dot(fan.axis)))
}
