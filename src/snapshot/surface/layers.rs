//! Sheen and clear coat at a surface point. In go a facet and a point on it, out come its layers. Invariant:
//! a surface without layers looks up no texture.

use super::Facet;
use crate::color::Rgb;
use crate::scattering::{Clearcoat, Layers, Sheen};
use crate::scene::TextureMap;
use glam::DVec3;

impl Facet<'_> {
    /// Returns the layers; `normal` is the shading normal before the surface's own normal map.
    pub(super) fn layers(&self, weights: [f64; 3], normal: DVec3) -> Option<Layers> {
        let material = self.material;
        if material.sheen.is_none() && material.clearcoat.is_none() {
            return None;
        }
        let texel =
            |map: Option<TextureMap>| map.and_then(|map| self.texel(map, weights)).unwrap_or(Rgb::ONE);
        let sheen = material.sheen.map(|sheen| {
            let roughness =
                sheen.roughness_texture.and_then(|map| self.texel_alpha(map, weights)).unwrap_or(1.0);
            Sheen::new(sheen.color * texel(sheen.color_texture), sheen.roughness * roughness)
        });
        let clearcoat = material.clearcoat.map(|coat| {
            let normal = coat.normal_map.map_or(normal, |map| self.bent(normal, map, weights));
            let roughness = coat.roughness * texel(coat.roughness_texture).y;
            let made = if material.is_principled { Clearcoat::principled } else { Clearcoat::new };
            made(normal, coat.share * texel(coat.texture).x, roughness)
        });
        Some(Layers { sheen, clearcoat })
    }
}
