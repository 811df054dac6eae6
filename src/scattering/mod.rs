//! Specular reflection of surfaces: coats, cloth and rough mirrors. In go directions, out come shares of
//! light. Invariant: nothing here knows visibility, cameras or pixels.

mod albedos;
mod fresnel;
mod ggx;
mod gloss;
mod layers;
mod sheen;

pub use albedos::LEAST_ROUGHNESS;
pub use gloss::Gloss;
pub use layers::{Clearcoat, Layers};
pub use sheen::Sheen;
