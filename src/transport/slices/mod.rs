//! Whole pictures from epipolar slices. Every camera ray lies in a half plane through the camera
//! and a light; what such a *slice* cuts of the scene is a set of segments in two dimensions, and
//! one sweep over the directions in it solves visibility, shadow and shafts together, without a
//! single ray. In go a snapshot and one of its lights, out come weighted samples. Invariant: a
//! sample is exact for the ray that it stands for; only which rays are chosen is a matter of sampling.
//!
//! To read it: `fan.rs` has the half planes and the lines that they are in the picture, `chord.rs` the pixels that such a line
//! crosses, `solve.rs` the one loop over them; `sweep.rs` (on `buckets.rs`) finds what a ray meets and which parts of it are lit, `slice_ray.rs`
//! makes a colour of that. Then what serves these: `edges.rs` cuts chords, `outline.rs` (on `border.rs`) says what lies between slices, `veiled.rs` finds the rays that
//! blended surfaces touch. Fog under a sun is integrated for a whole slice: `fog_profile.rs`, stretch by stretch (`stretch.rs`) between the borders of
//! what the slice cuts of it (`fog_section.rs`), with what is lit (`lit_cells.rs`), by `depth_line.rs` where it is even, by `depth_series.rs` and
//! `thinning_fog.rs` where it thins out with height.

mod border;
mod buckets;
mod chord;
mod depth_line;
mod depth_series;
mod edges;
mod fan;
mod fog_profile;
mod fog_section;
mod lit_cells;
mod outline;
mod slice_job;
mod slice_ray;
mod solve;
mod stretch;
mod sweep;
mod thinning_fog;
mod veiled;

pub use chord::{Chord, Crossing};
pub use fan::{Fan, Place, Ring, Separation, Slice, pixel};
pub use outline::{FARTHEST_SHIFT_PX, Outline, Strip};
pub use slice_job::SliceJob;
pub use solve::{Piece, SliceScratch, count_segments, solve};
