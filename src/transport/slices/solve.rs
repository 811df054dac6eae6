//! Solution of one slice. In go the slice and the places of its samples, out come the samples' values.
//! Invariant: each value is that of the per-ray method for the same ray, to rounding.

use super::border::Borders;
use super::chord::Chord;
use super::edges::Edges;
use super::fan::Fan;
use super::light_rays::LightRays;
use super::outline::Outline;
use super::slice::{LEAST_SPREAD, Place, Slice};
use super::slice_job::SliceJob;
use super::slice_ray::SliceRay;
use super::sweep::{Meeting, PlanarClip, Sweep};
use super::veiled::touches;
use crate::accel::{Cut, HalfPlane};
use crate::fog::FogSlice;
use crate::math::{PlanarRay, Ray, Sampler, kronecker};
use crate::snapshot::{Facet, FrozenLight, Snapshot};
use crate::transport::Sample;
use crate::transport::path::Scratch;
use glam::{DVec2, DVec3};

/// Memory that the slices of one thread share.
#[derive(Default)]
pub struct SliceScratch {
    chords: Vec<Chord>,
    edges: Edges,
    of_rays: RayScratch,
}

/// The part of it that rays use.
#[derive(Default)]
struct RayScratch {
    lowest_slopes: Vec<f64>,
    cuts: Vec<Cut>,
    sweep: Sweep,
    veils: Sweep,
    fog: FogSlice,
    followed: Scratch,
}

/// A part of a chord that sees the same surfaces throughout, and the sample that represents it.
pub struct Piece<'a> {
    /// The chord.
    pub chord: &'a Chord,
    /// Place of the sample.
    pub place: Place,
    /// Range of the chord's area that it covers, `0..=1`.
    pub range: [f64; 2],
    /// Weight: the area that it covers.
    pub weight: f64,
    /// Number of pieces of the chord before it.
    number: usize,
}

impl SliceJob<'_> {
    /// Calls back with each piece of a slice's chords, in order away from the light, and its sample by the
    /// slice's light alone. Rays that blended surfaces touch are traced by the per-ray method. Records the
    /// outline if the caller passes one that it has begun. Returns the number of segments that the slice
    /// gathered; `None` if there is no chord.
    pub fn solve(
        &self,
        slice: &Slice,
        of_slice: impl Iterator<Item = Chord>,
        mut outline: Option<&mut Outline>,
        scratch: &mut SliceScratch,
        mut sample: impl FnMut(&Piece, &mut Sample),
    ) -> Option<usize> {
        let SliceScratch { chords, edges, of_rays } = scratch;
        chords.clear();
        chords.extend(of_slice);
        let mut rays = Rays::new(self, slice, chords, of_rays)?;
        let light_rays = rays.light_rays;
        let borders = Borders::new(self.snapshot, self.fan, slice, light_rays);
        for chord in chords.iter() {
            rays.enter(chord);
            let [highest_slope, lowest_slope] = chord.slopes;
            let (mut piece_start, mut piece_slope) = (chord.start, highest_slope);
            let ends = edges.pieces(chord, slice, rays.sweeps(), light_rays, highest_slope..lowest_slope);
            for (number, end) in ends.iter().enumerate() {
                let piece = Piece::new(chord, slice, number, [piece_start, end.area]);
                sample(&piece, &mut rays.value(&piece));
                if let Some(outline) = &mut outline {
                    outline.add(chord.pixel, piece_slope, end.slope);
                    if number + 1 < ends.len() {
                        outline.end(end.origin.and_then(|origin| borders.of(&origin)));
                    }
                }
                (piece_start, piece_slope) = (end.area, end.slope);
            }
        }
        Some(rays.segments)
    }
}

impl<'a> Piece<'a> {
    fn new(chord: &'a Chord, slice: &Slice, number: usize, [start, end]: [f64; 2]) -> Self {
        let area = end - start;
        let chord_area = chord.end - chord.start;
        Self {
            chord,
            place: slice.place(start + kronecker(chord.phase, number) * area),
            range: [start, end].map(|passed| (passed - chord.start) / chord_area),
            weight: chord.weight_per_area * area,
            number,
        }
    }
}

/// Rays of one slice, queried in order away from the light: its cut of the scene, swept so far.
struct Rays<'a> {
    job: &'a SliceJob<'a>,
    outward: DVec3,
    light_rays: LightRays,
    sweep: &'a mut Sweep,
    veils: &'a mut Sweep,
    has_veils: bool,
    fog: &'a mut FogSlice,
    followed: &'a mut Scratch,
    /// The triangle that the last ray met: neighbouring rays mostly meet the same one.
    met: Option<Facet<'a>>,
    /// Number of segments that were gathered.
    segments: usize,
}

impl<'a> Rays<'a> {
    /// Gathers the slice's cuts within the extent of its chords; `None` if there are no chords.
    fn new(
        job: &'a SliceJob<'a>,
        slice: &Slice,
        chords: &[Chord],
        scratch: &'a mut RayScratch,
    ) -> Option<Self> {
        let (snapshot, light, eye, axis) = (job.snapshot, job.light, job.fan.eye, job.fan.axis);
        let light_rays = match *light {
            FrozenLight::Sun { .. } => LightRays::Parallel,
            FrozenLight::Point { position, .. } => LightRays::From((position - eye).length()),
        };
        let RayScratch { lowest_slopes, cuts, sweep, veils, fog, followed } = scratch;
        lowest_slopes.clear();
        lowest_slopes.extend(chords.iter().map(|chord| chord.slopes[1]));
        let lowest_slope = *lowest_slopes.last()?;
        let half_plane = HalfPlane { eye, axis, outward: slice.outward, lowest_slope };
        let clip = PlanarClip::of(&snapshot.view, slice.outward, axis);
        (sweep.clip, veils.clip) = (clip, clip);
        // The sweep of blended surfaces only finds the rays that they touch.
        sweep.rays = snapshot.rays_of_instances().cloned();
        cuts.clear();
        snapshot.blended.add_cuts(&half_plane, cuts);
        let blended_cuts = cuts.len();
        veils.start(cuts, light_rays, lowest_slopes);
        cuts.clear();
        snapshot.tree.add_cuts(&half_plane, cuts);
        sweep.start(cuts, light_rays, lowest_slopes);
        let middle_slope = lowest_slopes[lowest_slopes.len() / 2];
        fog.start(&snapshot.medium, light, &half_plane, middle_slope, cuts);
        let (has_veils, segments) = (blended_cuts > 0, blended_cuts + cuts.len());
        let outward = slice.outward;
        Some(Self { job, outward, light_rays, sweep, veils, has_veils, fog, followed, met: None, segments })
    }

    /// Moves on to the next chord.
    fn enter(&mut self, chord: &Chord) {
        let fog = &mut *self.fog;
        self.sweep.enter(chord.slopes[0], |start, end| fog.darken(start, end));
        self.veils.enter(chord.slopes[0], |_, _| {});
    }

    /// Sweeps of opaque and of blended surfaces.
    fn sweeps(&self) -> [&Sweep; 2] {
        [self.sweep, self.veils]
    }

    /// Sample of a piece's ray.
    #[inline]
    fn value(&mut self, piece: &Piece) -> Sample {
        let Self { job, light_rays, .. } = *self;
        let direction = piece.place.direction;
        // Rounding must not put a ray along the axis on its other side.
        let reach = direction.dot(self.outward).max(LEAST_SPREAD);
        let planar = PlanarRay::new(DVec2::new(reach, direction.dot(job.fan.axis)));
        let fog = &mut *self.fog;
        let meeting = self.sweep.advance(&planar, light_rays, |start, end| fog.darken(start, end));
        if let Some(Meeting { primitive, .. }) = meeting
            && self.met.is_none_or(|met| met.primitive != primitive)
        {
            self.met = Some(job.snapshot.facet(primitive));
            // It comes while shadows and fog are found.
            if let Some(indirect) = job.transport.indirect.filter(|_| job.has_rest) {
                indirect.prefetch(job.snapshot, primitive);
            }
        }
        let ((x, y), (seed, number)) = (piece.chord.pixel, piece.chord.random);
        let ray = SliceRay {
            job,
            ray: Ray { origin: job.fan.eye, direction },
            planar,
            light_rays,
            meeting: meeting.zip(self.met.as_ref()),
            sampler: Sampler::new(seed ^ piece.number as u32, x as u32, y as u32, number),
        };
        if self.has_veils && touches(self.veils, &planar, light_rays, ray.distance()) {
            ray.by_itself(self.followed)
        } else {
            ray.value(self.sweep, fog, self.followed)
        }
    }
}

/// Number of segments of opaque surfaces that a whole slice would gather.
pub fn count_segments(snapshot: &Snapshot, fan: &Fan, slice: &Slice) -> usize {
    let lowest_slope = slice.slope_at(slice.length);
    let half_plane = HalfPlane { eye: fan.eye, axis: fan.axis, outward: slice.outward, lowest_slope };
    let mut cuts = Vec::new();
    snapshot.tree.add_cuts(&half_plane, &mut cuts);
    cuts.len()
}
