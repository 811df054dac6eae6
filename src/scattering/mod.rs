//! What matter does to light: phase functions and optical depth. In go points and directions, out
//! come fractions of light. Invariant: nothing here knows visibility, cameras or pixels.

mod fog_box;
mod medium;
mod phase;

pub use fog_box::FogBox;
pub use medium::{Medium, Source, Stretch, exp_minus};
pub use phase::henyey_greenstein;
