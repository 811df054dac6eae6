//! Materials. In go fields of a file, out come materials of the scene. Invariant: fields that are left out
//! have the values of the material beneath: the default, or the one of an OBJ file that it replaces.

use super::{AlphaMode, Coat, Material, MaterialIndex, Resolver, TextureIndex, TextureMap};
use crate::color::Rgb;
use crate::description::ron;
use std::path::PathBuf;

/// Reflectance of plastics, leaves and most non-metals; glTF's default.
const DIELECTRIC_F0: f64 = 0.04;

impl Resolver<'_> {
    /// Adds the materials of the scene.
    pub(super) fn materials(&mut self) {
        for (name, material) in self.file.materials.iter() {
            let beneath = Material { name: name.to_owned(), ..Material::default() };
            let index = self.add_material(&format!("materials.{name}"), material, beneath);
            self.materials.insert(name, index);
        }
    }

    /// Adds a material with fields from a file, and others from the one `beneath` it.
    pub(super) fn add_material(
        &mut self,
        owner: &str,
        material: &ron::Material,
        beneath: Material,
    ) -> MaterialIndex {
        let image = |path: &Option<PathBuf>| self.textures.get(path.as_ref()?).copied();
        let [texture, through] = [&material.texture, &material.transmission_texture].map(image);
        let base_color = match material.base_color {
            Some(color) => color.si(),
            None if material.texture.is_some() => Rgb::ONE,
            None => beneath.base_color,
        };
        let base_color_texture = texture.or(beneath.base_color_texture);
        let as_map = |texture: TextureIndex| TextureMap { texture, layer: 0 };
        let is_blended = material.opacity.is_some() || material.filter_color.is_some();
        let coat = self.coat(owner, material);
        let normal_map = material.normal_map.as_ref().and_then(|map| {
            let texture = *self.normal_maps.get(&map.texture)?;
            Some((as_map(texture), map.scale.si()))
        });
        let made = Material {
            base_color,
            base_color_texture,
            transmission: material.transmission.si(),
            transmission_texture: through.or(base_color_texture).map(as_map),
            mirror: material.mirror.si(),
            alpha_mode: if is_blended { AlphaMode::Blend } else { beneath.alpha_mode },
            opacity: material.opacity.map_or(beneath.opacity, |opacity| opacity.si()),
            filter_color: material.filter_color.map_or(beneath.filter_color, |color| color.si()),
            emission: material.emission_w_per_m2_sr.map_or(beneath.emission, |emission| emission.si()),
            coat: coat.or(beneath.coat),
            normal_map: normal_map.or(beneath.normal_map),
            ..beneath
        };
        let beneath = if material.base_color.is_none() { base_color } else { Rgb::ZERO };
        self.check_energy(owner, &made, beneath);
        let index = self.scene.materials.len();
        self.scene.materials.push(made);
        self.mask(owner, material, index);
        index
    }

    /// Refuses reflectances above 1. `unsaid` is the base colour if it is not the author's.
    fn check_energy(&mut self, owner: &str, made: &Material, unsaid: Rgb) {
        if (made.base_color + made.transmission + made.mirror + made.filter_color).max_element() > 1.0 {
            let darker = String::from("make one of them darker");
            let remedy = match unsaid.max_element() {
                0.0 => darker,
                brightest => format!("{darker}: without a `base_color` here it is {brightest}"),
            };
            self.problems.error(
                owner,
                "the surface would give more light than it receives",
                "base_color + transmission + mirror + filter_color <= 1 in every channel",
                &remedy,
            );
        }
    }

    /// Registers the cutoff of a masked material.
    fn mask(&mut self, owner: &str, material: &ron::Material, index: MaterialIndex) {
        let Some(cutoff) = &material.alpha_cutoff else { return };
        if material.texture.is_none() || material.filter_color.is_some() {
            self.problems.error(
                &format!("{owner}.alpha_cutoff"),
                "the material has a mask without a texture, or a filter as well",
                "a `texture` with alpha, and no `filter_color`",
                "take `alpha_cutoff` or `filter_color` out",
            );
        }
        self.scene.materials[index].alpha_mode = AlphaMode::Opaque;
        self.cutoffs.insert(index, cutoff.si());
    }

    /// Coat of a material with a roughness.
    fn coat(&mut self, owner: &str, material: &ron::Material) -> Option<Coat> {
        let metallic = material.metallic.as_ref().map_or(0.0, |metallic| metallic.si());
        let Some(roughness) = &material.roughness else {
            if material.metallic.is_some() {
                let remedy = "add `roughness`, or take `metallic` out; a perfect mirror has `mirror`";
                let field = format!("{owner}.metallic");
                self.problems.error(&field, "the metal has no roughness", "a `roughness` beside it", remedy);
            }
            return None;
        };
        let f0 = Rgb::splat(DIELECTRIC_F0);
        Some(Coat { metallic, roughness: roughness.si(), texture: None, f0, f0_texture: None, f90: 1.0 })
    }
}
