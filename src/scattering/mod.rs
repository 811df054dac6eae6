//! Specular scattering of surfaces: coats, cloth, rough mirrors and frosted glass. In go directions, out come
//! BSDFs, samples and albedos. Invariant: this module knows no visibility, cameras or pixels.

mod albedos;
mod bump_shadow;
mod dielectric;
mod fresnel;
mod ggx;
mod gloss;
mod interface;
mod layers;
mod microfacets;
mod sheen;
mod specular_normal;
mod thin_dielectric;

pub use albedos::LEAST_ROUGHNESS;
pub use bump_shadow::bump_shadow;
pub use dielectric::Dielectric;
pub use gloss::Gloss;
pub use interface::Interface;
pub use layers::{Clearcoat, Layers};
pub use sheen::Sheen;
pub use specular_normal::specular_normal;
pub use thin_dielectric::ThinDielectric;
