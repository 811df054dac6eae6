//! Fog. In go rays, lights and lit intervals, out come optical depths and in-scattered radiance. Invariant:
//! shadows are input; this module knows no surfaces, cameras or pixels.
//!
//! Transport queries a [`Medium`]: `medium.rs` for points and rays, `scattered.rs` for in-scattered radiance
//! along a ray, [`FogSlice`] for all rays of a half plane. A medium is a list of banks (`bank.rs`). Each has
//! a density that is uniform, falls with height (`falloff.rs`) or is given by voxels (`voxel_fog.rs`).
//! `sun_interval.rs` and `near_light.rs` choose how to integrate an interval of a ray (`ray_interval.rs`): in
//! closed form or by a fit; transport does not see which.

mod bank;
mod beer_lambert;
mod emitter;
mod events;
mod falloff;
mod foggy_ray;
mod layer;
mod lit_segments;
mod medium;
mod near_light;
mod phase;
mod prefix_sums;
mod ray_interval;
mod scattered;
mod slice;
mod sun_interval;
mod voxel_cells;
mod voxel_fog;
mod voxel_interval;

pub use bank::FogBank;
pub use beer_lambert::{exp_minus, exp_minus_with_mean};
pub use emitter::Emitter;
pub use events::{Loss, Losses};
pub use falloff::Falloff;
pub use foggy_ray::FoggyRay;
pub use lit_segments::LitSegments;
pub use medium::Medium;
pub use phase::{BEAM_DEGREES, henyey_greenstein, henyey_greenstein_pdf, sample_henyey_greenstein};
pub use scattered::Passage;
pub use slice::FogSlice;
