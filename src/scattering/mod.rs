//! How surfaces shine: coats, cloth and rough mirrors. In go directions, out come shares of light. Invariant: nothing here knows
//! visibility, cameras or pixels.

mod gloss;
mod layers;
mod sheen;

pub use gloss::{Gloss, LEAST_ROUGHNESS};
pub use layers::{Clearcoat, Layers};
pub use sheen::Sheen;
