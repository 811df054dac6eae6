//! What matter does to light: phase functions, optical depth and the shine of surfaces. In go points and directions, out
//! come fractions of light. Invariant: nothing here knows visibility, cameras or pixels.

mod beer_lambert;
mod falloff;
mod fog_bank;
mod gloss;
mod layers;
mod medium;
mod phase;
mod sheen;

pub use beer_lambert::{exp_minus, mean_transmittance};
pub use falloff::{Climb, Falloff};
pub use fog_bank::{FogBank, LightPlace};
pub use gloss::{Gloss, LEAST_ROUGHNESS};
pub use layers::{Clearcoat, Layers};
pub use medium::{Course, Medium, Stretch};
pub use phase::{henyey_greenstein, pick_henyey_greenstein, picked_henyey_greenstein};
pub use sheen::Sheen;
