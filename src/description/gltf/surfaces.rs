//! Materials in glTF's terms. In go validated numbers, out come typed values. Invariant: every number is in
//! glTF's range.

use crate::description::image::DecodedImage;
use glam::DVec3;
use serde_json::Value;

/// Supported part of a material.
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
    /// Reflectance along the normal of its non-metallic part (KHR_materials_ior, KHR_materials_specular).
    pub f0: DVec3,
    /// Multiplies it (KHR_materials_specular).
    pub f0_texture: Option<TextureMap>,
    /// Weight of that reflection (KHR_materials_specular), `0..=1`; 0 leaves pure Lambert.
    pub specular: f64,
    /// Clear coat over all (KHR_materials_clearcoat).
    pub clearcoat: Clearcoat,
    /// Sheen of cloth (KHR_materials_sheen).
    pub sheen: Sheen,
    /// Normal map and its scale.
    pub normal_map: Option<(TextureMap, f64)>,
    /// Linear.
    pub emission: DVec3,
    /// Multiplies it (KHR_materials_emissive_strength).
    pub emission_strength: f64,
    /// Multiplies it.
    pub emission_texture: Option<TextureMap>,
    /// Emits its base colour and is not lit (KHR_materials_unlit).
    pub unlit: bool,
    /// Share of diffuse light that is transmitted diffusely, and its colour
    /// (KHR_materials_diffuse_transmission).
    pub diffuse_transmission: (f64, DVec3),
    /// Multiplies that colour.
    pub diffuse_transmission_texture: Option<TextureMap>,
    /// Share of diffuse light that passes straight through (KHR_materials_transmission).
    pub transmission: f64,
    /// Meaning of alpha.
    pub alpha_mode: AlphaMode,
    /// Whether its back faces are visible.
    pub double_sided: bool,
    /// Custom properties.
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
    /// Normal map of the coat, which the material's own does not affect, and its scale.
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

/// Texture and its layer of texture coordinates.
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
    /// Ignored.
    #[default]
    Opaque,
    /// Hidden where alpha is below this, `0..=1`.
    Mask(f64),
    /// Coverage.
    Blend,
}

/// Decoded image and its wrap modes.
#[derive(Clone, Debug)]
pub struct Texture {
    /// The image's name, else `image N`.
    pub name: String,
    /// Texels.
    pub image: DecodedImage,
    /// Across, and down.
    pub wrap: [Wrap; 2],
}

/// Wrap mode of a texture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Wrap {
    /// Repeats the image.
    #[default]
    Repeat,
    /// Repeats the edge texel.
    Clamp,
    /// Repeats the image, mirrored.
    Mirror,
}
