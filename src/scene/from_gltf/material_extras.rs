//! Properties of surfaces in `sunfleck_material` that glTF lacks. In go the custom property and glTF's
//! material, out comes the complete material. Invariant: its shares add up to at most 1.

use super::Builder;
use super::extras::{self, Channels, Unknown};
use crate::color::Rgb;
use crate::description::gltf;
use crate::diagnostic::Loss;
use crate::scene::{Coat, Dielectric, Material, Painted, TextureMap};
use serde::Deserialize;

/// Tolerance of sums of shares above 1: Blender and others store colours in single precision and properties
/// in double, so that 0.6 and 0.4 give 1.000000024.
const SINGLE_PRECISION: f64 = 1e-6;

/// `sunfleck_material` of a material.
#[derive(Debug, Deserialize)]
pub(super) struct MaterialExtras {
    mirror: Option<Channels>,
    filter_color: Option<Channels>,
    transmission: Option<Channels>,
    metal: Option<Channels>,
    /// Whether the base colour's texture does not multiply `metal`.
    #[serde(default)]
    plain_metal: bool,
    /// Whether metal reflects equally at all angles.
    #[serde(default)]
    even_metal: bool,
    /// Whether the base colour's texture multiplies `transmission` too.
    #[serde(default)]
    transmission_textured: bool,
    /// Whether it is Blender's Principled BSDF.
    #[serde(default)]
    principled: bool,
    /// Factors on the light that its coat removes from the base colour and from transmission.
    coat_takes: Option<[Channels; 2]>,
    /// Whether Blender's *Bump Map Correction* is on.
    #[serde(default)]
    bump_map_correction: bool,
    /// Whether 8-bit pictures are interpolated by their codes.
    #[serde(default)]
    pub(super) encoded_filtering: bool,
    thin_dielectric: Option<Thin>,
    #[serde(flatten)]
    unknown: Unknown,
}

/// `thin_dielectric` of a material.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Thin {
    share: f64,
    #[serde(default = "glass")]
    ior: f64,
    /// Whether it is one face of a solid, and not a thin sheet.
    #[serde(default)]
    one_face: bool,
}

fn glass() -> f64 {
    1.5
}

impl MaterialExtras {
    /// Applies the property to a material, after `sunfleck_leaf`.
    pub(super) fn apply(&self, material: &mut Material, source: &gltf::Material) {
        if let Some(mirror) = self.mirror {
            (material.mirror, material.painted) = (mirror.into(), Painted::BaseColor);
        }
        material.is_principled = self.principled;
        material.coat_takes = self.coat_takes.map_or(material.coat_takes, |takes| takes.map(Rgb::from));
        material.has_bump_shadows = self.bump_map_correction;
        material.metal_color = self.metal.map_or(material.metal_color, |metal| Some(metal.into()));
        material.has_plain_metal = self.metal.is_some() && self.plain_metal;
        material.has_even_metal = self.even_metal;
        material.filter_color = self.filter_color.map_or(material.filter_color, Rgb::from);
        if let Some(Thin { share, ior, one_face }) = self.thin_dielectric {
            material.dielectric = Some(Dielectric { share, ior, has_one_face: one_face });
            // A material without a coat only has a roughness.
            let (roughness, texture) = (source.roughness, source.metallic_roughness_texture);
            let plain = Coat { metallic: 0.0, roughness, texture, f0: Rgb::ZERO, f0_texture: None, f90: 0.0 };
            material.coat.get_or_insert(plain);
        }
        if let Some(transmission) = self.transmission {
            material.transmission = transmission.into();
            let of_base = material.base_color_texture.map(|texture| TextureMap { texture, layer: 0 });
            material.transmission_texture = of_base.filter(|_| self.transmission_textured);
        }
    }
}

impl Builder<'_> {
    pub(super) fn material_extras(
        &mut self,
        index: usize,
        source: &gltf::Material,
    ) -> Option<MaterialExtras> {
        let path = format!("materials[{index}]");
        let mut extras: MaterialExtras =
            extras::read(&source.extras, "sunfleck_material", &path, &mut self.report)?;
        let name = |field: &str| format!("sunfleck_material.{field}` of `{}", source.name);
        extras::tell_unknown(&extras.unknown, &mut self.report, name);
        for takes in extras.coat_takes.iter_mut().flatten() {
            let least = Rgb::from(*takes).min_element();
            if least < 0.0 {
                let path = format!("{path}.extras.sunfleck_material.coat_takes");
                self.report.put_right(Loss::ValueOutOfRange, &path, least);
                *takes = Channels::Each(Rgb::from(*takes).max(Rgb::ZERO).to_array());
            }
        }
        if let Some(thin) = &mut extras.thin_dielectric {
            let path = format!("{path}.extras.sunfleck_material.thin_dielectric");
            for (name, value, range) in
                [("share", &mut thin.share, 0.0..=1.0), ("ior", &mut thin.ior, 1.0..=3.0)]
            {
                if !range.contains(value) {
                    self.report.put_right(Loss::ValueOutOfRange, &format!("{path}.{name}"), *value);
                    *value = value.clamp(*range.start(), *range.end());
                }
            }
        }
        Some(extras)
    }

    /// Refuses a material whose shares exceed 1 at any of these times.
    pub(super) fn check_shares(&mut self, index: usize, moments: impl Iterator<Item = Material>) {
        for material in moments {
            let shares = [material.base_color, material.transmission, material.mirror, material.filter_color];
            let sum: Rgb = shares.iter().sum();
            let metal = material.metal_color.unwrap_or_default();
            let least = shares.iter().chain([&metal]).map(|share| share.min_element()).fold(0.0, f64::min);
            if least < 0.0 || sum.max(metal).max_element() > 1.0 + SINGLE_PRECISION {
                let found =
                    format!("base colour, transmission, mirror and filter add up to {sum}, metal is {metal}");
                let expected = "shares of at least 0 that add up to 1 at most";
                self.report.error(format!("materials[{index}].extras.sunfleck_material"), found, expected);
                return;
            }
        }
    }
}
