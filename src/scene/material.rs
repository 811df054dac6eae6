//! Materials of surfaces. Invariant: `base_color + transmission + mirror + filter_color <= 1` per channel,
//! so no surface gives more than it receives.

use super::{TextureIndex, Track};
use crate::color::Rgb;
pub use crate::description::gltf::{Clearcoat, Sheen, TextureMap};

/// A two-sided surface: Lambert to the near and to the far side, mirror and emission added up, perhaps
/// under a coat.
#[derive(Clone, Debug)]
pub struct Material {
    /// The author's name.
    pub name: String,
    /// Lambert reflectance, `0..=1`; multiplied by the texture if there is one.
    pub base_color: Rgb,
    /// Image whose colour multiplies what is `painted`; looked up with the first texture coordinates.
    pub base_color_texture: Option<TextureIndex>,
    /// Property that that image and the colours of vertices multiply.
    pub painted: Painted,
    /// Lambert transmittance, `0..=1`: what comes out, diffuse, on the side that the light does not
    /// fall on.
    pub transmission: Rgb,
    /// Image whose colour multiplies `transmission`.
    pub transmission_texture: Option<TextureMap>,
    /// Perfect mirror reflectance, `0..=1`.
    pub mirror: Rgb,
    /// Radiance emitted to either side, W m^-2 sr^-1.
    pub emission: Rgb,
    /// Image whose colour multiplies `emission`.
    pub emission_texture: Option<TextureMap>,
    /// Glossy coat, or metal; without one it is matte.
    pub coat: Option<Coat>,
    /// Whether its coat is that of Blender's Principled BSDF, as Cycles has it.
    pub is_principled: bool,
    /// How many times what that coat takes from beneath it is taken from the base colour and from
    /// transmission: a share of a surface may lie beside its coat.
    pub coat_takes: [Rgb; 2],
    /// Reflectance of metal along the normal, if it is not `base_color`: nothing goes through metal.
    pub metal_color: Option<Rgb>,
    /// Whether no texture multiplies that.
    pub has_plain_metal: bool,
    /// Whether metal reflects as much at grazing angles as along the normal.
    pub has_even_metal: bool,
    /// A dielectric of the coat's roughness, whose inside has the metal's colour.
    pub dielectric: Option<Dielectric>,
    /// A clear coat over all.
    pub clearcoat: Option<Clearcoat>,
    /// Sheen of cloth, beneath the clear coat.
    pub sheen: Option<Sheen>,
    /// Image of directions that bend the normal, and how much of their bending counts.
    pub normal_map: Option<(TextureMap, f64)>,
    /// Whether bumps of that map shade themselves, as in Cycles.
    pub has_bump_shadows: bool,
    /// Effect of alpha, which is `opacity` times that of the texture.
    pub alpha_mode: AlphaMode,
    /// Alpha, `0..=1`; multiplied by the texture's if there is one.
    pub opacity: f64,
    /// Share of light that goes straight through where alpha is 1, `0..=1`.
    pub filter_color: Rgb,
    /// Track of its numbers, if they change.
    pub changes: Option<Track<MaterialNumbers>>,
}

/// The numbers of a [`Material`] that may change, in the order of [`Material::numbers`].
pub type MaterialNumbers = [f64; NUMBERS];
const NUMBERS: usize = 26;

/// Property that a picture on a surface multiplies.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Painted {
    /// [`Material::base_color`].
    #[default]
    BaseColor,
    /// [`Material::mirror`]: coloured metal.
    Mirror,
    /// [`Material::emission`]: what shines in its own colours.
    Emission,
}

/// glTF's metallic-roughness model (`scattering::Gloss`).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coat {
    /// Share of metal, `0..=1`: metals reflect `base_color` in the coat and nothing beneath it.
    pub metallic: f64,
    /// `0..=1`; glTF's roughness, the square root of its alpha.
    pub roughness: f64,
    /// Image whose blue multiplies `metallic` and whose green `roughness`.
    pub texture: Option<TextureMap>,
    /// Reflectance along the normal of what is no metal, `0..=1`.
    pub f0: Rgb,
    /// Image whose colour multiplies `f0`.
    pub f0_texture: Option<TextureMap>,
    /// Reflectance at grazing angles of what is no metal.
    pub f90: f64,
}

/// A rough dielectric (`scattering::Dielectric`).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dielectric {
    /// Share of what is no metal that it is, coat and all, `0..=1`.
    pub share: f64,
    /// Refractive index, 1 or more.
    pub ior: f64,
    /// Whether it is one face of a body, and no thin sheet.
    pub has_one_face: bool,
}

/// glTF's alpha modes; what a mask hides is cut out of the mesh instead (`scene/outline`).
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum AlphaMode {
    /// Alpha is ignored.
    Opaque,
    /// The share `1 - alpha + alpha * filter_color` of what lies behind shows, and the share
    /// alpha of the surface.
    Blend,
}

impl Material {
    /// Material in a tint, which multiplies the painted property and transmitted light.
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

    /// Numbers of its colours, then its single numbers, then its metal's colour; zeros for a coat, a normal
    /// map or a metal that it lacks.
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

    /// Whether an image bends a normal of it.
    pub fn has_normal_map(&self) -> bool {
        self.normal_map.is_some() || self.clearcoat.is_some_and(|coat| coat.normal_map.is_some())
    }

    /// Whether front and back differ.
    pub fn has_front(&self) -> bool {
        self.dielectric.is_some_and(|dielectric| dielectric.has_one_face)
    }

    /// True if it is the same at all times.
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
