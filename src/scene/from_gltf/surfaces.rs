//! Materials and textures. Invariant: what a material asks for beyond Lambert, mirror and emission
//! is reported, once a kind.

use super::Builder;
use super::extras::{self, Leaf};
use crate::color::Rgb;
use crate::description::gltf;
use crate::scene::{AlphaMode, Material, MaterialIndex, Texture, Wrap};

impl Builder<'_> {
    /// Adds every material, under the file's numbers, and their textures.
    pub(super) fn add_surfaces(&mut self, textures: Vec<gltf::Texture>) {
        self.scene.textures = textures.into_iter().map(texture).collect();
        for (index, source) in self.source.materials.iter().enumerate() {
            let mut material = material(source);
            if let Some(leaf) = self.leaf(index, source) {
                let share = leaf.translucency;
                let (color, texture) = match leaf.transmit_color {
                    Some(color) => (Rgb::from(color), None),
                    None => (material.base_color, material.base_color_texture),
                };
                (material.transmission, material.transmission_texture) = (share * color, texture);
                material.base_color *= 1.0 - share;
                material.mirror *= 1.0 - share;
            }
            self.scene.materials.push(material);
        }
    }

    /// What a material's custom property says of the light that it lets through.
    fn leaf(&mut self, index: usize, material: &gltf::Material) -> Option<Leaf> {
        let path = format!("materials[{index}]");
        let leaf: Leaf = extras::read(&material.extras, "sunfleck_leaf", &path, &mut self.report)?;
        for name in leaf.unknown.keys() {
            let name = format!("sunfleck_leaf.{name}");
            self.report.not_honoured("unknown fields of sunfleck's properties are passed over", &name);
        }
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

    /// Our number of a primitive's material; the default one if it has none.
    pub(super) fn material_of(&mut self, material: Option<usize>) -> MaterialIndex {
        material.unwrap_or_else(|| {
            let default = self.source.materials.len();
            if self.scene.materials.len() == default {
                self.scene.materials.push(Material::default());
            }
            default
        })
    }

    /// Says what materials ask for that is not honoured.
    pub(super) fn report_material(&mut self, material: &gltf::Material) {
        let is_mirror = is_mirror(material);
        let asked = [
            (
                material.metallic > 0.0 && !is_mirror,
                "metals are mirrors at roughness 0 only: these are drawn matte, in their base colour",
            ),
            (
                material.metallic == 0.0 && material.specular > 0.0,
                "highlights (specular) are not honoured, these materials are drawn matte",
            ),
            (
                !material.double_sided,
                "backface culling is not honoured, these materials show from both sides",
            ),
        ];
        for (_, message) in asked.iter().filter(|(asked, _)| *asked) {
            self.report.not_honoured(message, &material.name);
        }
    }
}

fn is_mirror(material: &gltf::Material) -> bool {
    material.metallic == 1.0 && material.roughness == 0.0
}

fn material(material: &gltf::Material) -> Material {
    let [r, g, b, opacity] = material.base_color;
    let color = Rgb::new(r, g, b);
    let (base_color, mirror) = if is_mirror(material) { (Rgb::ZERO, color) } else { (color, Rgb::ZERO) };
    Material {
        name: material.name.clone(),
        base_color,
        base_color_texture: material.base_color_texture,
        transmission: Rgb::ZERO,
        transmission_texture: None,
        mirror,
        emission: material.emission,
        opacity,
        filter_color: Rgb::ZERO,
        alpha_mode: match material.alpha_mode {
            // What a mask shows is cut out.
            gltf::AlphaMode::Opaque | gltf::AlphaMode::Mask(_) => AlphaMode::Opaque,
            gltf::AlphaMode::Blend => AlphaMode::Blend,
        },
    }
}

fn texture(texture: gltf::Texture) -> Texture {
    Texture {
        name: texture.name,
        width: texture.image.width,
        height: texture.image.height,
        texels: texture.image.texels,
        wrap: match texture.wrap {
            gltf::Wrap::Repeat => Wrap::Repeat,
            gltf::Wrap::Clamp => Wrap::Clamp,
            gltf::Wrap::Mirror => Wrap::Mirror,
        },
    }
}
