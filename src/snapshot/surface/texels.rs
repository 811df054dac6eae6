//! Image and vertex values at a point of a facet. In go barycentric coordinates, out come colours, alphas and
//! the coat that results. Invariant: without image and vertex colours a value is 1.

use super::Facet;
use crate::color::Rgb;
use crate::scattering::{Dielectric, Gloss, Interface, ThinDielectric};
use crate::scene::{AlphaMode, Mesh, Texture, TextureMap};
use glam::{DVec3, Vec2};

/// A point of a facet, with the texel of its base colour: other maps mostly share its image.
pub(super) struct FacetTexels<'a> {
    facet: &'a Facet<'a>,
    weights: [f64; 3],
    /// Image of the base colour, and the coordinates in it.
    base: Option<(&'a Texture, Vec2)>,
    color: Rgb,
}

/// Specular part of a surface.
pub(super) struct Specular {
    pub(super) gloss: Option<Gloss>,
    pub(super) dielectric: Option<Dielectric>,
    /// Share of the diffuse part.
    pub(super) matte: f64,
}

impl<'a> FacetTexels<'a> {
    pub(super) fn new(facet: &'a Facet<'a>, weights: [f64; 3]) -> Self {
        let base = facet.texture.map(|texture| (texture, facet.interpolated(&facet.mesh.uvs, weights)));
        let color = base.map_or(Rgb::ONE, |(texture, uv)| texture.color(uv));
        Self { facet, weights, base, color }
    }

    /// The colour of a map.
    pub(super) fn of(&self, map: Option<TextureMap>) -> Rgb {
        match map {
            None => Rgb::ONE,
            // Mostly the texel of the base colour.
            Some(TextureMap { texture, layer: 0 })
                if self.facet.material.base_color_texture == Some(texture) =>
            {
                self.color
            }
            Some(map) => self.facet.texel(map, self.weights).unwrap_or(Rgb::ONE),
        }
    }

    /// The base colour of image and vertices.
    pub(super) fn paint(&self) -> Rgb {
        let Facet { mesh, corners, .. } = self.facet;
        if mesh.colors.is_empty() {
            return self.color;
        }
        let corner = |corner: usize| self.weights[corner] * mesh.colors[corners[corner]].as_dvec3();
        self.color * (0..3).map(corner).sum::<DVec3>()
    }

    /// Specular part of a surface with a colour for metal and dielectric; `is_within` if the eye sees its
    /// back.
    pub(super) fn specular(&self, color: Rgb, is_within: bool) -> Specular {
        let Some(coat) = self.facet.material.coat else {
            return Specular { gloss: None, dielectric: None, matte: 1.0 };
        };
        let texel = coat.texture.and_then(|map| self.facet.texel(map, self.weights)).unwrap_or(Rgb::ONE);
        let (metallic, roughness) = (coat.metallic * texel.z, coat.roughness * texel.y);
        let f0 = coat.f0 * self.of(coat.f0_texture);
        // glTF 2.0, appendix B.3.5: metals have their colour in the coat, and nothing below it.
        let plain = Gloss::new(f0, Rgb::splat(coat.f90), roughness);
        let gloss = if self.facet.material.is_principled { plain.principled() } else { plain };
        let grazing = if self.facet.material.has_even_metal { color } else { Rgb::ONE };
        let matte = 1.0 - metallic;
        let Some(own) = self.facet.material.dielectric else {
            return Specular {
                gloss: Some(gloss.with_metal(metallic, color, grazing)),
                dielectric: None,
                matte,
            };
        };
        // It takes its share of the non-metallic part, coat included.
        let share = matte * own.share;
        let cover = 1.0 - share;
        let is_left = cover > 0.0;
        let gloss = is_left.then(|| gloss.with_metal(metallic / cover, color, grazing).covering(cover));
        let dielectric = if own.has_one_face {
            Dielectric::Interface(Interface::new(share, color, own.ior, roughness, is_within))
        } else {
            Dielectric::Thin(ThinDielectric::new(share, color, own.ior, roughness))
        };
        Specular { gloss, dielectric: Some(dielectric), matte: matte - share }
    }

    /// Coverage of the surface, and its transmittance for light from behind.
    pub(super) fn opacity(&self) -> (f64, Rgb) {
        let material = self.facet.material;
        match material.alpha_mode {
            AlphaMode::Opaque => (1.0, Rgb::ZERO),
            AlphaMode::Blend => {
                let of_image = self.base.map_or(1.0, |(image, uv)| image.alpha(uv).clamp(0.0, 1.0));
                let alpha = material.opacity * of_image * self.vertex_alpha();
                (alpha, Rgb::splat(1.0 - alpha) + alpha * material.filter_color)
            }
        }
    }

    fn vertex_alpha(&self) -> f64 {
        let Facet { mesh, corners, .. } = self.facet;
        if mesh.alphas.is_empty() {
            return 1.0;
        }
        let corner = |corner: usize| self.weights[corner] * f64::from(mesh.alphas[corners[corner]]);
        (0..3).map(corner).sum::<f64>().clamp(0.0, 1.0)
    }
}

impl Facet<'_> {
    fn interpolated(&self, uvs: &[Vec2], weights: [f64; 3]) -> Vec2 {
        (0..3).map(|corner| weights[corner] as f32 * uvs[self.corners[corner]]).sum()
    }

    /// The colour of an image; `None` if the mesh has no coordinates for it.
    pub(super) fn texel(&self, map: TextureMap, weights: [f64; 3]) -> Option<Rgb> {
        let uvs = layer(self.mesh, map.layer)?;
        Some(self.textures[map.texture].color(self.interpolated(uvs, weights)))
    }

    /// Memory of the texels around a point in an image.
    pub(super) fn texels_around(&self, map: TextureMap, weights: [f64; 3]) -> [Option<&u8>; 2] {
        let Some(uvs) = layer(self.mesh, map.layer) else { return [None; 2] };
        self.textures[map.texture].memory_at(self.interpolated(uvs, weights))
    }

    /// Alpha of an image; `None` if the mesh has no coordinates for it.
    pub(super) fn texel_alpha(&self, map: TextureMap, weights: [f64; 3]) -> Option<f64> {
        let uvs = layer(self.mesh, map.layer)?;
        Some(self.textures[map.texture].alpha(self.interpolated(uvs, weights)))
    }
}

/// Texture coordinates of a layer of a mesh, if it has them.
fn layer(mesh: &Mesh, layer: usize) -> Option<&[Vec2]> {
    let uvs = if layer == 0 { Some(&mesh.uvs) } else { mesh.more_uvs.get(layer - 1) };
    uvs.map(Vec::as_slice).filter(|uvs| !uvs.is_empty())
}
