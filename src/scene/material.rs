//! Materials of surfaces. In go validated parameters, out come materials over time. Invariant: `base_color +
//! transmission + mirror + filter_color <= 1` per channel, so no surface reflects more than it receives.

use super::{TextureIndex, Track};
use crate::color::Rgb;
pub use crate::description::gltf::{Clearcoat, Sheen, TextureMap};

/// Two-sided surface: diffuse reflection and transmission, mirror and emission added up, with an optional
/// coat.
#[derive(Clone, Debug)]
pub struct Material {
    /// The author's name.
    pub name: String,
    /// Lambert reflectance, `0..=1`; multiplied by the texture, if there is one.
    pub base_color: Rgb,
    /// Image that multiplies the `painted` property, with the first texture coordinates.
    pub base_color_texture: Option<TextureIndex>,
    /// Property that this image and vertex colours multiply.
    pub painted: Painted,
    /// Lambert transmittance, `0..=1`: diffuse light on the far side.
    pub transmission: Rgb,
    /// Image whose colour multiplies `transmission`.
    pub transmission_texture: Option<TextureMap>,
    /// Perfect mirror reflectance, `0..=1`.
    pub mirror: Rgb,
    /// Radiance emitted from both sides, W m^-2 sr^-1.
    pub emission: Rgb,
    /// Image whose colour multiplies `emission`.
    pub emission_texture: Option<TextureMap>,
    /// Glossy coat, or metal; without one the surface is matte.
    pub coat: Option<Coat>,
    /// Whether its coat is that of Blender's Principled BSDF in Cycles.
    pub is_principled: bool,
    /// Factors on the light that the coat removes from the base colour and from transmission, as part of a
    /// surface may lie beside its coat.
    pub coat_takes: [Rgb; 2],
    /// Reflectance of metal along the normal, if it is not `base_color`; metal transmits nothing.
    pub metal_color: Option<Rgb>,
    /// Whether no texture multiplies the metal's colour.
    pub has_plain_metal: bool,
    /// Whether metal reflects equally at all angles.
    pub has_even_metal: bool,
    /// Dielectric with the coat's roughness and the metal's colour inside.
    pub dielectric: Option<Dielectric>,
    /// Clear coat on top.
    pub clearcoat: Option<Clearcoat>,
    /// Sheen, beneath the clear coat.
    pub sheen: Option<Sheen>,
    /// Normal map and its scale.
    pub normal_map: Option<(TextureMap, f64)>,
    /// Whether bumps of the map shadow themselves, as in Cycles.
    pub has_bump_shadows: bool,
    /// Use of alpha, which is `opacity` times the texture's.
    pub alpha_mode: AlphaMode,
    /// Alpha, `0..=1`; multiplied by the texture's, if there is one.
    pub opacity: f64,
    /// Share of light that passes straight through where alpha is 1, `0..=1`.
    pub filter_color: Rgb,
    /// Track of its parameters, if they change.
    pub changes: Option<Track<MaterialNumbers>>,
}

/// Parameters of a [`Material`] that may change, in the order of [`Material::numbers`].
pub type MaterialNumbers = [f64; NUMBERS];
const NUMBERS: usize = 26;

/// Property that a surface's colours multiply.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Painted {
    /// [`Material::base_color`].
    #[default]
    BaseColor,
    /// [`Material::mirror`], for coloured metal.
    Mirror,
    /// [`Material::emission`], for surfaces that emit their own colours.
    Emission,
}

/// glTF's metallic-roughness model (`scattering::Gloss`).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coat {
    /// Share of metal, `0..=1`: it reflects `base_color` in the coat and nothing beneath it.
    pub metallic: f64,
    /// Roughness, `0..=1`, as in glTF: the square root of alpha.
    pub roughness: f64,
    /// Image whose blue multiplies `metallic` and whose green `roughness`.
    pub texture: Option<TextureMap>,
    /// Reflectance along the normal of the non-metallic part, `0..=1`.
    pub f0: Rgb,
    /// Image whose colour multiplies `f0`.
    pub f0_texture: Option<TextureMap>,
    /// Reflectance at grazing angles of the non-metallic part.
    pub f90: f64,
}

/// Rough dielectric (`scattering::Dielectric`).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dielectric {
    /// Its share of the non-metallic part, coat included, `0..=1`.
    pub share: f64,
    /// Refractive index, 1 or more.
    pub ior: f64,
    /// Whether it is one face of a solid, and not a thin sheet.
    pub has_one_face: bool,
}

/// Alpha modes of glTF; parts hidden by a mask are cut out of the mesh instead (`scene/outline`).
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum AlphaMode {
    /// Alpha is ignored.
    Opaque,
    /// Shows the share alpha of the surface, and the share `1 - alpha + alpha * filter_color` of what lies
    /// behind it.
    Blend,
}

impl Material {
    /// Material with a tint on the painted property and on transmitted light.
    pub fn tinted(&self, color: Rgb) -> Self {
        let mut tinted = self.clone();
        tinted.base_color *= color;
        tinted.transmission *= color;
        if !tinted.has_plain_metal {
            tinted.metal_color = tinted.metal_color.map(|metal| metal * color);
        }
        match self.painted {
            Painted::BaseColor => {}
            Painted::Mirror => tinted.mirror *= color,
            Painted::Emission => tinted.emission *= color,
        }
        tinted
    }

    /// Its colours, then its other parameters, then its metal's colour; zeros for a missing coat, normal map
    /// or metal.
    pub fn numbers(&self) -> MaterialNumbers {
        let (f0, metallic, roughness, f90) = self
            .coat
            .map_or((Rgb::ZERO, 0.0, 0.0, 0.0), |coat| (coat.f0, coat.metallic, coat.roughness, coat.f90));
        let colors = [self.base_color, self.transmission, self.mirror, self.emission, self.filter_color, f0];
        let scale = self.normal_map.map_or(0.0, |(_, scale)| scale);
        let mut numbers = [0.0; NUMBERS];
        for (three, color) in numbers.chunks_exact_mut(3).zip(colors) {
            three.copy_from_slice(&color.to_array());
        }
        numbers[18..23].copy_from_slice(&[self.opacity, metallic, roughness, f90, scale]);
        numbers[23..].copy_from_slice(&self.metal_color.unwrap_or_default().to_array());
        numbers
    }

    /// Material at a time.
    pub fn at(&self, time_s: f64) -> Self {
        let mut now = self.clone();
        let Some(changes) = &self.changes else { return now };
        let numbers = changes.at(time_s);
        let color = |index: usize| Rgb::from_slice(&numbers[3 * index..]);
        let [opacity, metallic, roughness, f90, scale] = [18, 19, 20, 21, 22].map(|index| numbers[index]);
        (now.base_color, now.transmission, now.mirror) = (color(0), color(1), color(2));
        (now.emission, now.filter_color, now.opacity) = (color(3), color(4), opacity);
        now.coat = now.coat.map(|coat| Coat { f0: color(5), metallic, roughness, f90, ..coat });
        now.metal_color = now.metal_color.map(|_| Rgb::from_slice(&numbers[23..]));
        now.normal_map = now.normal_map.map(|(map, _)| (map, scale));
        now
    }

    /// Whether it has a normal map.
    pub fn has_normal_map(&self) -> bool {
        self.normal_map.is_some() || self.clearcoat.is_some_and(|coat| coat.normal_map.is_some())
    }

    /// Whether front and back differ.
    pub fn has_front(&self) -> bool {
        self.dielectric.is_some_and(|dielectric| dielectric.has_one_face)
    }

    /// Whether it is constant.
    pub fn is_constant(&self) -> bool {
        self.changes.as_ref().is_none_or(Track::is_constant)
    }
}

impl Default for Material {
    fn default() -> Self {
        Self {
            name: String::from("default"),
            base_color: Rgb::splat(0.8),
            base_color_texture: None,
            painted: Painted::BaseColor,
            transmission: Rgb::ZERO,
            transmission_texture: None,
            mirror: Rgb::ZERO,
            emission: Rgb::ZERO,
            emission_texture: None,
            coat: None,
            is_principled: false,
            coat_takes: [Rgb::ONE; 2],
            metal_color: None,
            has_plain_metal: false,
            has_even_metal: false,
            dielectric: None,
            clearcoat: None,
            sheen: None,
            normal_map: None,
            has_bump_shadows: false,
            alpha_mode: AlphaMode::Opaque,
            opacity: 1.0,
            filter_color: Rgb::ZERO,
            changes: None,
        }
    }
}
