//! Materials and textures. In go those of glTF, out come those of the scene. Invariant: a property that is
//! not honoured is reported, once a kind.

use super::Builder;
use super::extras::{self, Leaf};
use crate::color::Rgb;
use crate::description::gltf::{self, Property};
use crate::diagnostic::Loss;
use crate::scene::{AlphaMode, Coat, Material, MaterialIndex, Painted, Texture, TextureMap};

impl Builder<'_> {
    /// Adds every material by the file's index, and the textures.
    pub(super) fn add_surfaces(&mut self, textures: Vec<gltf::Texture>) {
        self.scene.textures = textures.into_iter().map(texture).collect();
        for (index, source) in self.source.materials.iter().enumerate() {
            let leaf = self.leaf(index, source);
            let extras = self.material_extras(index, source);
            // The kind of material must not change with its parameters.
            let keeps_coat = self.is_animated(&[Property::Metallic, Property::Roughness], index);
            let converted = |source: &gltf::Material| {
                let mut material = material(source, keeps_coat);
                leaf.iter().for_each(|leaf| become_leaf(&mut material, source, leaf));
                extras.iter().for_each(|extras| extras.apply(&mut material, source));
                material
            };
            let changes = self.material_changes(index, |source| converted(source).numbers());
            let mut material = converted(source);
            material.changes = changes.filter(|changes| !changes.is_constant());
            if extras.is_some() {
                let times_s = material.changes.iter().flat_map(|changes| changes.times_s().into_owned());
                self.check_shares(index, times_s.map(|time_s| material.at(time_s)).chain([material.clone()]));
            }
            let fades = self.is_animated(&[Property::BaseColor], index);
            if fades && matches!(source.alpha_mode, gltf::AlphaMode::Mask(_)) {
                self.report.not_honoured(Loss::AnimatedMask, &source.name);
            }
            if extras.is_some_and(|extras| extras.encoded_filtering) {
                let emission = material.emission_texture.map(|map| map.texture);
                for texture in material.base_color_texture.into_iter().chain(emission) {
                    self.scene.textures[texture].texels.mix_codes();
                }
            }
            self.scene.materials.push(material);
        }
    }

    /// Transmission in a material's `sunfleck_leaf`.
    fn leaf(&mut self, index: usize, material: &gltf::Material) -> Option<Leaf> {
        let path = format!("materials[{index}]");
        let leaf: Leaf = extras::read(&material.extras, "sunfleck_leaf", &path, &mut self.report)?;
        extras::tell_unknown(&leaf.unknown, &mut self.report, |field| format!("sunfleck_leaf.{field}"));
        let path = format!("{path}.extras.sunfleck_leaf");
        let color = leaf.transmit_color.map_or(Rgb::ONE, Rgb::from);
        let numbers = [("translucency", Rgb::splat(leaf.translucency)), ("transmit_color", color)];
        let mut is_valid = true;
        for (name, value) in numbers {
            if value.min_element() < 0.0 || value.max_element() > 1.0 {
                let found = match name {
                    "translucency" => format!("the translucency is {}", leaf.translucency),
                    _ => format!("the colour is {value}"),
                };
                self.report.error(format!("{path}.{name}"), found, "numbers from 0 to 1");
                is_valid = false;
            }
        }
        is_valid.then_some(leaf)
    }

    /// Material of a primitive; the default one if it has none.
    pub(super) fn material_of(&mut self, material: Option<usize>) -> MaterialIndex {
        material.unwrap_or_else(|| {
            let default = self.source.materials.len();
            if self.scene.materials.len() == default {
                self.scene.materials.push(Material::default());
            }
            default
        })
    }
}

/// Makes a leaf of a material, with diffuse transmission.
fn become_leaf(material: &mut Material, source: &gltf::Material, leaf: &Leaf) {
    let share = leaf.translucency;
    let [r, g, b, _] = source.base_color;
    let (color, texture) = match leaf.transmit_color {
        Some(color) => (Rgb::from(color), None),
        None => (Rgb::new(r, g, b), material.base_color_texture),
    };
    let texture = texture.map(|texture| TextureMap { texture, layer: 0 });
    (material.transmission, material.transmission_texture) = (share * color, texture);
    material.base_color = (1.0 - share) * Rgb::new(r, g, b);
    material.metal_color = Some(Rgb::new(r, g, b));
    (material.mirror, material.painted) = (Rgb::ZERO, Painted::BaseColor);
}

/// Material at one moment; `keeps_coat` if its metallic factor or roughness changes.
fn material(material: &gltf::Material, keeps_coat: bool) -> Material {
    let [r, g, b, opacity] = material.base_color;
    let color = Rgb::new(r, g, b);
    let matte = Material {
        name: material.name.clone(),
        base_color: color,
        base_color_texture: material.base_color_texture,
        emission: material.emission * material.emission_strength,
        emission_texture: material.emission_texture,
        normal_map: material.normal_map,
        clearcoat: Some(material.clearcoat).filter(|coat| coat.share > 0.0),
        sheen: Some(material.sheen).filter(|sheen| sheen.color != Rgb::ZERO),
        opacity,
        alpha_mode: alpha_mode(material.alpha_mode),
        ..Material::default()
    };
    if material.unlit {
        let painted = Painted::Emission;
        return Material {
            base_color: Rgb::ZERO,
            emission: color,
            emission_texture: None,
            painted,
            clearcoat: None,
            sheen: None,
            ..matte
        };
    }
    let is_mirror = material.metallic == 1.0
        && material.roughness == 0.0
        && material.metallic_roughness_texture.is_none();
    if is_mirror && !keeps_coat {
        return Material { base_color: Rgb::ZERO, mirror: color, painted: Painted::Mirror, ..matte };
    }
    let is_shiny =
        keeps_coat || material.metallic > 0.0 || material.f0 != Rgb::ZERO || material.specular > 0.0;
    let coat = is_shiny.then_some(Coat {
        metallic: material.metallic,
        roughness: material.roughness,
        texture: material.metallic_roughness_texture,
        f0: material.f0,
        f0_texture: material.f0_texture,
        f90: material.specular,
    });
    // Transmitted light, diffuse or straight, is subtracted from the reflected light.
    let (diffuse, diffuse_color) = material.diffuse_transmission;
    let straight = material.transmission * (1.0 - material.metallic);
    let lets_through = straight > 0.0 || keeps_coat && material.transmission > 0.0;
    Material {
        base_color: (1.0 - straight) * (1.0 - diffuse) * color,
        transmission: (1.0 - straight) * diffuse * diffuse_color,
        transmission_texture: material.diffuse_transmission_texture,
        coat,
        metal_color: (diffuse > 0.0 || material.transmission > 0.0).then_some(color),
        alpha_mode: if lets_through { AlphaMode::Blend } else { matte.alpha_mode },
        filter_color: straight * color,
        // Opacity only counts with blending.
        opacity: if material.alpha_mode == gltf::AlphaMode::Blend { opacity } else { 1.0 },
        ..matte
    }
}

fn alpha_mode(mode: gltf::AlphaMode) -> AlphaMode {
    match mode {
        // Masked parts are cut out of the mesh.
        gltf::AlphaMode::Opaque | gltf::AlphaMode::Mask(_) => AlphaMode::Opaque,
        gltf::AlphaMode::Blend => AlphaMode::Blend,
    }
}

fn texture(texture: gltf::Texture) -> Texture {
    Texture {
        name: texture.name,
        width: texture.image.width,
        height: texture.image.height,
        texels: texture.image.texels,
        wrap: texture.wrap,
    }
}
