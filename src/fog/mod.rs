//! Fog. In go rays, lights and what is lit, out come optical depths and light scattered towards the eye.
//! Invariant: a shadow is something that this module is told; it knows no surfaces, cameras or pixels.
//!
//! [`Medium`] is what all fog together is asked: `medium.rs` by points and rays, `scattered.rs` for the light
//! of a ray, [`FogSlice`] for all rays of a half plane. It is made of banks (`bank.rs`), whose
//! density is even or thins out with height (`falloff.rs`). Which closed form a ray's stretch has
//! (`stretch.rs`), if any, is decided in `sun_stretch.rs` and `near_light.rs`; transport never knows.

mod bank;
mod beer_lambert;
mod emitter;
mod events;
mod falloff;
mod foggy_ray;
mod lit_segments;
mod medium;
mod near_light;
mod phase;
mod prefix_sums;
mod scattered;
mod slice;
mod stretch;
mod sun_stretch;
mod voxel_cells;
mod voxel_fog;
mod voxel_stretch;

pub use bank::FogBank;
pub use beer_lambert::{exp_minus, exp_minus_little};
pub use emitter::Emitter;
pub use events::{Loss, Losses};
pub use falloff::Falloff;
pub use foggy_ray::FoggyRay;
pub use lit_segments::LitSegments;
pub use medium::Medium;
pub use phase::{BEAM_DEGREES, henyey_greenstein, pick_henyey_greenstein, picked_henyey_greenstein};
pub use scattered::Passage;
pub use slice::FogSlice;
