//! Whole pictures from epipolar slices. Every camera ray lies in a half plane through the camera and a light.
//! Such a *slice* cuts the scene in segments of two dimensions. One sweep over the slice's directions solves
//! visibility, shadow and shafts together, without ray tracing. In go a snapshot and one of its lights, out
//! come weighted samples. Invariant: each sample is exact for its ray; only the choice of rays is sampling.
//!
//! To read it: `fan.rs` has the half planes, `slice.rs` the line of one in the picture. `chord.rs` has the
//! pixels on that line, `solve.rs` the one loop over them. `sweep.rs` (on `segment.rs` and `active.rs`) finds
//! the first hit of a ray and its lit parts; `slice_ray.rs` shades it. The rest serves these. `edges.rs` cuts
//! chords, and `outline.rs` (on `border.rs`) interpolates between slices. `veiled.rs` finds the rays that
//! blended surfaces touch. [`FogSlice`](crate::fog::FogSlice) integrates fog along a ray. Where it cannot,
//! the method for single rays does.

mod active;
mod border;
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
