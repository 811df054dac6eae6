//! Whole pictures from epipolar slices. Every camera ray lies in a half plane through the camera and a light.
//! Such a *slice* cuts the scene in segments of two dimensions. One sweep over the slice's directions solves
//! visibility, shadow and shafts together, without a single ray. In go a snapshot and one of its lights, out
//! come weighted samples. Invariant: a sample is exact for the ray that it stands for. Only which rays are
//! chosen is a matter of sampling.
//!
//! To read it: `fan.rs` has the half planes, `slice.rs` the line that one is in the picture. `chord.rs` has
//! the pixels that such a line crosses, `solve.rs` the one loop over them. `sweep.rs` (on `segment.rs`,
//! `active.rs` and `buckets.rs`) finds what a ray meets and which parts of it are lit; `slice_ray.rs` makes a
//! colour of that. The rest serves these. `edges.rs` cuts chords, and `outline.rs` (on `border.rs`) says what
//! lies between slices. `veiled.rs` finds the rays that blended surfaces touch.
//! [`FogSlice`](crate::fog::FogSlice) says what fog does along a ray. Where it has no answer, the method for
//! single rays does.

mod active;
mod border;
mod buckets;
mod chord;
mod edges;
mod fan;
mod light_rays;
mod outline;
mod picture;
mod segment;
mod slice;
mod slice_job;
mod slice_ray;
mod solve;
mod sweep;
mod veiled;

pub use chord::{Chord, Crossing};
pub use fan::{Fan, Separation};
pub use outline::{FARTHEST_SHIFT_PX, Outline, Strip};
pub use slice::{Place, Ring, Slice};
pub use slice_job::SliceJob;
pub use solve::{Piece, SliceScratch, count_segments};
