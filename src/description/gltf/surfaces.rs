//! Materials of a glTF file in its own terms. Invariant: every number is in the range that glTF gives it.

use crate::description::image::DecodedImage;
use glam::DVec3;
use serde_json::Value;

/// The part of a material that we can make use of.
#[derive(Clone, Debug, Default)]
pub struct Material {
    /// The author's name, else `material N`.
    pub name: String,
    /// Linear, alpha last; in `0..=1`.
    pub base_color: [f64; 4],
    /// Index into [`super::GltfScene::textures`].
    pub base_color_texture: Option<usize>,
    /// Metallic factor, in `0..=1`.
    pub metallic: f64,
    /// Roughness, in `0..=1`.
    pub roughness: f64,
    /// Texture whose blue multiplies `metallic`, and whose green `roughness`.
    pub metallic_roughness_texture: Option<TextureMap>,
    /// Reflectance along the normal where it is no metal (KHR_materials_ior, KHR_materials_specular).
    pub f0: DVec3,
    /// Multiplies it (KHR_materials_specular).
    pub f0_texture: Option<TextureMap>,
    /// Strength of that reflection (KHR_materials_specular), `0..=1`; 0 leaves pure Lambert.
    pub specular: f64,
    /// Clear coat over all (KHR_materials_clearcoat).
    pub clearcoat: Clearcoat,
    /// Sheen of cloth (KHR_materials_sheen).
    pub sheen: Sheen,
    /// Directions that bend the normal, and how much of their bending counts.
    pub normal_map: Option<(TextureMap, f64)>,
    /// Linear.
    pub emission: DVec3,
    /// Multiplies it (KHR_materials_emissive_strength).
    pub emission_strength: f64,
    /// Multiplies it.
    pub emission_texture: Option<TextureMap>,
    /// Shines in its base colour instead of being lit (KHR_materials_unlit).
    pub unlit: bool,
    /// Share of the matte light that comes out on the other side, and in which colour
    /// (KHR_materials_diffuse_transmission).
    pub diffuse_transmission: (f64, DVec3),
    /// Multiplies that colour.
    pub diffuse_transmission_texture: Option<TextureMap>,
    /// Share of the matte light that goes straight through (KHR_materials_transmission).
    pub transmission: f64,
    /// Meaning of alpha.
    pub alpha_mode: AlphaMode,
    /// Whether it shows from behind.
    pub double_sided: bool,
    /// Whatever the author attached.
    pub extras: Value,
}

/// A clear coat (`scattering::Clearcoat`).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Clearcoat {
    /// Share of the surface that it covers, `0..=1`.
    pub share: f64,
    /// Texture whose red multiplies `share`.
    pub texture: Option<TextureMap>,
    /// Roughness, in `0..=1`.
    pub roughness: f64,
    /// Texture whose green multiplies `roughness`.
    pub roughness_texture: Option<TextureMap>,
    /// Directions that bend its normal, which the material's own normal map does not.
    pub normal_map: Option<(TextureMap, f64)>,
}

/// Sheen of cloth (`scattering::Sheen`).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sheen {
    /// Linear, in `0..=1`.
    pub color: DVec3,
    /// Multiplies it.
    pub color_texture: Option<TextureMap>,
    /// Roughness, in `0..=1`.
    pub roughness: f64,
    /// Texture whose alpha multiplies `roughness`.
    pub roughness_texture: Option<TextureMap>,
}

/// A texture and the layer of texture coordinates that it is looked up with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TextureMap {
    /// Index into [`super::GltfScene::textures`].
    pub texture: usize,
    /// 0 is [`super::Primitive::uvs`], the others are [`super::Primitive::more_uvs`].
    pub layer: usize,
}

/// Meaning of alpha.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum AlphaMode {
    /// Nothing.
    #[default]
    Opaque,
    /// Hidden where alpha is below this, `0..=1`.
    Mask(f64),
    /// Coverage.
    Blend,
}

/// A decoded image and how it goes on beyond its edges.
#[derive(Clone, Debug)]
pub struct Texture {
    /// The image's name, else `image N`.
    pub name: String,
    /// Texels.
    pub image: DecodedImage,
    /// Across, and down.
    pub wrap: [Wrap; 2],
}

/// Continuation of a texture beyond its edges.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Wrap {
    /// The image again.
    #[default]
    Repeat,
    /// The edge texel.
    Clamp,
    /// The image mirrored.
    Mirror,
}
