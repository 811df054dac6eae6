//! Whole pictures from epipolar slices. Every camera ray lies in a half plane through the camera
//! and a light; what such a *slice* cuts of the scene is a set of segments in two dimensions, and
//! one sweep over the directions in it solves visibility, shadow and shafts together, without a
//! single ray. In go a snapshot and one of its lights, out come weighted samples. Invariant: a
//! sample is exact for the ray that it stands for; only which rays are chosen is a matter of sampling.

mod buckets;
mod chord;
mod depth_line;
mod depth_series;
mod edges;
mod fan;
mod fog_profile;
mod fog_section;
mod lit_cells;
mod sight;
mod solve;
mod stretch;
mod swath;
mod sweep;
mod thinning_fog;
mod veiled;

pub use chord::{Chord, Crossing};
pub use fan::{Fan, Place, Ring, Separation, Slice, pixel};
pub use solve::{Piece, SliceJob, SliceScratch, count_segments, solve};
pub use swath::{Share, Swath};
