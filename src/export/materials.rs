//! Materials and their images. In go materials, out come glTF's materials and textures. Invariant: everything
//! beyond Lambert, smooth metal, emission and alpha is in the custom property `sunfleck_material`.

use super::Writer;
use super::layers::{self, texture_info};
use super::material_changes::Written;
use crate::color::{Rgb, srgb_from_linear};
use crate::diagnostic::{Diagnostic, Loss, Place};
use crate::scene::{AlphaMode, Coat, Dielectric, Material, Painted, Texture, TextureMap, Wrap};
use image::codecs::png::PngEncoder;
use image::{ExtendedColorType, ImageEncoder};
use serde_json::{Value, json};

/// Textures with their images and samplers.
#[derive(Default)]
pub(super) struct Images {
    pub(super) textures: Vec<Value>,
    pub(super) images: Vec<Value>,
    pub(super) samplers: Vec<Value>,
}

impl Writer<'_> {
    /// All materials by the scene's indices, and all textures.
    pub(super) fn materials(&mut self) -> Result<(Vec<Value>, Images), Diagnostic> {
        let scene = self.scene;
        let mut tinted = scene.materials.iter().filter(|material| is_tinted_by_another(material));
        if let Some(first) = tinted.next() {
            let others = match tinted.count() {
                0 => String::new(),
                count => format!(" (and {count} more materials)"),
            };
            let found = format!(
                "light through `{}`{others} takes the colours of the base colour's texture",
                first.name
            );
            self.lost(Loss::ExportMaterial, found);
        }
        let numbered = scene.materials.iter().enumerate();
        let materials = numbered.map(|(index, material)| self.material(index, material)).collect();
        let mut images = Images::default();
        for (number, texture) in scene.textures.iter().enumerate() {
            let holds_data = scene.materials.iter().any(|material| {
                let coat = material.coat.and_then(|coat| coat.texture);
                let maps = [coat, material.normal_map.map(|(map, _)| map)];
                maps.into_iter().flatten().any(|map| map.texture == number)
                    || layers::is_data(material, number)
            });
            let view = self.binary.view(png(texture, holds_data)?, None);
            images.images.push(json!({ "name": texture.name, "bufferView": view, "mimeType": "image/png" }));
            images.samplers.push(json!({ "wrapS": wrap(texture.wrap[0]), "wrapT": wrap(texture.wrap[1]) }));
            images.textures.push(json!({ "source": number, "sampler": number }));
        }
        Ok((materials, images))
    }

    fn material(&mut self, index: usize, material: &Material) -> Value {
        let is_unlit = is_unlit(material);
        let is_metal = material.mirror != Rgb::ZERO
            && material.base_color == Rgb::ZERO
            && (material.base_color_texture.is_none() || material.painted == Painted::Mirror);
        let pbr = pbr(material, is_metal, is_unlit);
        let mut extensions = json!({});
        if is_unlit {
            self.extensions.insert("KHR_materials_unlit");
            extensions["KHR_materials_unlit"] = json!({});
        } else if !is_metal {
            self.extensions.insert("KHR_materials_specular");
            extensions["KHR_materials_specular"] =
                material.coat.map_or(json!({ "specularFactor": 0.0 }), specular);
        }
        self.add_layers(material, &mut extensions);
        // glTF limits the factor to 1.
        let times_s = material.changes.iter().flat_map(|changes| changes.times_s().into_owned());
        let brightest = times_s.map(|time_s| material.at(time_s).emission.max_element());
        let emission = if is_unlit { Rgb::ZERO } else { material.emission };
        let strength = brightest.fold(emission.max_element().max(1.0), f64::max);
        self.carry_changes(index, material, &Written { is_metal, is_unlit, emission_strength: strength });
        if strength > 1.0 {
            self.extensions.insert("KHR_materials_emissive_strength");
            extensions["KHR_materials_emissive_strength"] = json!({ "emissiveStrength": strength });
        }
        let mut written = json!({
            "name": material.name,
            "pbrMetallicRoughness": pbr,
            "doubleSided": true,
            "emissiveFactor": (emission / strength).to_array(),
            "extensions": extensions,
        });
        if let Some(map) = material.emission_texture {
            written["emissiveTexture"] = texture_info(map);
        }
        if let Some((map, scale)) = material.normal_map {
            written["normalTexture"] = texture_info(map);
            written["normalTexture"]["scale"] = json!(scale);
        }
        if material.alpha_mode == AlphaMode::Blend {
            written["alphaMode"] = json!("BLEND");
        }
        let ours = self.properties(material, is_metal);
        if ours != json!({}) {
            written["extras"] = json!({ "sunfleck_material": ours });
        }
        written
    }

    /// Properties that glTF lacks.
    fn properties(&mut self, material: &Material, is_metal: bool) -> Value {
        let mut ours = json!({});
        if material.mirror != Rgb::ZERO && !is_metal {
            ours["mirror"] = json!(material.mirror.to_array());
        }
        if material.is_principled {
            ours["principled"] = json!(true);
        }
        if material.coat_takes != [Rgb::ONE; 2] {
            ours["coat_takes"] = json!(material.coat_takes.map(|takes| takes.to_array()));
        }
        if material.has_even_metal {
            ours["even_metal"] = json!(true);
        }
        if material.has_bump_shadows {
            ours["bump_map_correction"] = json!(true);
        }
        let textures = [material.base_color_texture, material.emission_texture.map(|map| map.texture)];
        if textures.into_iter().flatten().any(|texture| self.scene.textures[texture].texels.mixes_codes) {
            ours["encoded_filtering"] = json!(true);
        }
        if let (Some(metal), Some(_)) = (material.metal_color, material.coat) {
            ours["metal"] = json!(metal.to_array());
            if material.has_plain_metal {
                ours["plain_metal"] = json!(true);
            }
        }
        if let Some(Dielectric { share, ior, has_one_face }) = material.dielectric {
            ours["thin_dielectric"] = json!({ "share": share, "ior": ior });
            if has_one_face {
                ours["thin_dielectric"]["one_face"] = json!(true);
            }
        }
        if material.filter_color != Rgb::ZERO {
            ours["filter_color"] = json!(material.filter_color.to_array());
        }
        if material.transmission != Rgb::ZERO {
            ours["transmission"] = json!(material.transmission.to_array());
            ours["transmission_textured"] = json!(material.transmission_texture.is_some());
        }
        ours
    }
}

/// Whether light through a material takes the colours of a texture that is not its base colour's.
fn is_tinted_by_another(material: &Material) -> bool {
    let of_base = material.base_color_texture.map(|texture| TextureMap { texture, layer: 0 });
    let own = material.transmission_texture.is_some() && material.transmission_texture != of_base;
    own && material.transmission != Rgb::ZERO
}

/// Metallic-roughness part of a material.
fn pbr(material: &Material, is_metal: bool, is_unlit: bool) -> Value {
    let color = match material.painted {
        Painted::Emission if is_unlit => material.emission,
        _ if is_metal => material.mirror,
        _ => material.base_color,
    };
    let [red, green, blue] = color.to_array();
    let mut pbr = json!({
        "baseColorFactor": [red, green, blue, material.opacity],
        "metallicFactor": if is_metal { 1.0 } else { material.coat.map_or(0.0, |coat| coat.metallic) },
        "roughnessFactor": if is_metal { 0.0 } else { material.coat.map_or(1.0, |coat| coat.roughness) },
    });
    if let Some(map) = material.coat.and_then(|coat| coat.texture) {
        pbr["metallicRoughnessTexture"] = texture_info(map);
    }
    if let Some(texture) = material.base_color_texture {
        pbr["baseColorTexture"] = json!({ "index": texture });
    }
    pbr
}

/// Whether a material only emits, in colours that glTF keeps in 0 to 1.
fn is_unlit(material: &Material) -> bool {
    let shares = [material.base_color, material.transmission, material.mirror, material.filter_color];
    material.painted == Painted::Emission
        && shares.iter().all(|share| *share == Rgb::ZERO)
        && material.coat.is_none()
        && material.emission.max_element() <= 1.0
}

/// Specular extension. Non-metal reflects 0.04 along the normal, times a colour that may be above 1, times a
/// factor. The factor alone counts at grazing angles (KHR_materials_specular, "Implementation").
fn specular(coat: Coat) -> Value {
    let color = if coat.f90 > 0.0 { coat.f0 / (0.04 * coat.f90) } else { Rgb::ONE };
    let mut written = json!({ "specularFactor": coat.f90, "specularColorFactor": color.to_array() });
    if let Some(map) = coat.f0_texture {
        written["specularColorTexture"] = texture_info(map);
    }
    written
}

fn wrap(wrap: Wrap) -> u32 {
    match wrap {
        Wrap::Repeat => 10497,
        Wrap::Clamp => 33071,
        Wrap::Mirror => 33648,
    }
}

/// Encodes a texture as PNG, with 8 bits where they decode to the same texels, else with 16.
///
/// Normal maps and roughness are linear already.
pub(super) fn png(texture: &Texture, holds_data: bool) -> Result<Vec<u8>, Diagnostic> {
    let code = |value: f32, is_alpha: bool| {
        let value = f64::from(value);
        let encoded = if is_alpha || holds_data { value } else { srgb_from_linear(value) };
        (encoded * f64::from(u16::MAX)).round() as u16
    };
    let codes: Vec<u16> = texture
        .texels
        .iter()
        .flat_map(|[red, green, blue, alpha]| {
            [code(red, false), code(green, false), code(blue, false), code(alpha, true)]
        })
        .collect();
    let eight_bits = codes.iter().all(|code| code.is_multiple_of(257));
    let (bytes, kind): (Vec<u8>, _) = if eight_bits {
        (codes.iter().map(|code| (code / 257) as u8).collect(), ExtendedColorType::Rgba8)
    } else {
        (codes.iter().flat_map(|code| code.to_ne_bytes()).collect(), ExtendedColorType::Rgba16)
    };
    let mut png = Vec::new();
    let (width, height) = (texture.width as u32, texture.height as u32);
    let written = PngEncoder::new(&mut png).write_image(&bytes, width, height, kind);
    written.map(|()| png).map_err(|error| {
        let found = format!("the texture `{}` cannot be stored as PNG: {error}", texture.name);
        Diagnostic::error(Place::Nowhere, found)
            .expected("an image that PNG can hold")
            .remedy("make the image smaller")
    })
}
