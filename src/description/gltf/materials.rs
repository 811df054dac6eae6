//! Materials and the textures they need. Invariant: only images that a mesh shows are opened.

use super::buffers::{Buffers, fetch};
use super::extensions::material_extension;
use super::json::{self, Document};
use super::report::Report;
use super::texture_maps::{Purpose, Slot, layer, layers, slots};
use super::{
    AlphaMode, Clearcoat, Files, LoadError, Material, Sheen, Texture, TextureMap, Wrap, invalid, named,
};
use crate::description::image::{self, Encoding};
use crate::diagnostic::{Diagnostic, Loss};
use glam::DVec3;
use serde_json::Value;
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::path::Path;

/// Most texels that the textures of one file may have together; 2 GiB once decoded.
pub(super) const MAX_TEXELS: usize = 1 << 27;

/// Of smoother sheens the extension's fitted shadowing gives more than there is (`scattering/sheen.rs`).
const LEAST_HONOURED_SHEEN: f64 = 0.3;

/// All materials, and the textures of those that a mesh uses.
pub(super) fn read(
    document: &Document,
    buffers: &Buffers<'_>,
    file: &Path,
    files: &mut Files,
    report: &mut Report,
) -> Result<(Vec<Material>, Vec<Texture>), LoadError> {
    let mut used = vec![false; document.materials.len()];
    for primitive in document.meshes.iter().flat_map(|mesh| &mesh.primitives) {
        if let Some(used) = primitive.material.and_then(|material| used.get_mut(material)) {
            *used = true;
        }
    }
    let mut textures: Vec<Texture> = Vec::new();
    let mut texture_numbers = BTreeMap::new();
    let mut materials = Vec::with_capacity(document.materials.len());
    for (index, material) in document.materials.iter().enumerate() {
        let mut converted = convert(index, material, report);
        if used[index] {
            report_unused(material, &converted.name, report);
            let slots = slots(material);
            let layers = layers(&slots);
            for Slot { purpose, info, path } in &slots {
                let user = format!("materials[{index}].{path}.index");
                let key = (info.index, purpose.encoding());
                let number = match texture_numbers.get(&key) {
                    Some(number) => *number,
                    None => {
                        let texels = textures.iter().map(|texture| texture.image.texels.len()).sum::<usize>();
                        if texels > MAX_TEXELS {
                            report.error(user, "the textures are too large together", "2^27 texels in all");
                            break;
                        }
                        let texture = read_texture(document, key, &user, buffers, file, files, report)?;
                        let number = report.keep(texture).map(|texture| {
                            textures.push(texture);
                            textures.len() - 1
                        });
                        texture_numbers.insert(key, number);
                        number
                    }
                };
                let layer = layers.iter().position(|known| *known == layer(info)).unwrap_or_default();
                let map = number.map(|texture| TextureMap { texture, layer });
                match purpose {
                    Purpose::BaseColor => converted.base_color_texture = number,
                    Purpose::Clearcoat => converted.clearcoat.texture = map,
                    Purpose::ClearcoatNormal => {
                        converted.clearcoat.normal_map = map.map(|map| (map, info.scale));
                    }
                    Purpose::ClearcoatRoughness => converted.clearcoat.roughness_texture = map,
                    Purpose::SheenColor => converted.sheen.color_texture = map,
                    Purpose::SheenRoughness => converted.sheen.roughness_texture = map,
                    Purpose::DiffuseTransmission => converted.diffuse_transmission_texture = map,
                    Purpose::Emission => converted.emission_texture = map,
                    Purpose::MetallicRoughness => converted.metallic_roughness_texture = map,
                    Purpose::Normal => converted.normal_map = map.map(|map| (map, info.scale)),
                }
            }
        }
        materials.push(converted);
    }
    Ok((materials, textures))
}

fn convert(index: usize, material: &json::Material, report: &mut Report) -> Material {
    let path = format!("materials[{index}]");
    let pbr = &material.pbr_metallic_roughness;
    let in_unit_range = |report: &mut Report, at: &str, values: &[f64]| {
        if let Some(value) = values.iter().find(|value| !(0.0..=1.0).contains(*value)) {
            report.error(format!("{path}.{at}"), format!("{value} is out of range"), "numbers from 0 to 1");
        }
    };
    in_unit_range(report, "pbrMetallicRoughness.baseColorFactor", &pbr.base_color_factor);
    in_unit_range(report, "pbrMetallicRoughness.metallicFactor", &[pbr.metallic_factor]);
    in_unit_range(report, "pbrMetallicRoughness.roughnessFactor", &[pbr.roughness_factor]);
    in_unit_range(report, "emissiveFactor", &material.emissive_factor);
    let extensions = Extensions { material, path: &path };
    let specular = extensions.number("KHR_materials_specular", "specularFactor", 1.0, 1.0, report);
    let specular_color =
        extensions.color("KHR_materials_specular", "specularColorFactor", 1.0, f64::MAX, report);
    let ior = extensions.number("KHR_materials_ior", "ior", 1.5, f64::MAX, report);
    let through = "KHR_materials_diffuse_transmission";
    let share = extensions.number(through, "diffuseTransmissionFactor", 0.0, 1.0, report);
    let through_color = extensions.color(through, "diffuseTransmissionColorFactor", 1.0, 1.0, report);
    let (clearcoat, sheen) = ("KHR_materials_clearcoat", "KHR_materials_sheen");
    let clearcoat = Clearcoat {
        factor: extensions.number(clearcoat, "clearcoatFactor", 0.0, 1.0, report),
        roughness: extensions.number(clearcoat, "clearcoatRoughnessFactor", 0.0, 1.0, report),
        ..Clearcoat::default()
    };
    let sheen = Sheen {
        color: extensions.color(sheen, "sheenColorFactor", 0.0, 1.0, report),
        roughness: extensions.number(sheen, "sheenRoughnessFactor", 0.0, 1.0, report),
        ..Sheen::default()
    };
    if sheen.color.max_element() > 0.0 && sheen.roughness < LEAST_HONOURED_SHEEN {
        report.not_honoured(Loss::SheenMadeWeaker, &named(&material.name, "material", index));
    }
    let transmission =
        extensions.number("KHR_materials_transmission", "transmissionFactor", 0.0, 1.0, report);
    let strength =
        extensions.number("KHR_materials_emissive_strength", "emissiveStrength", 1.0, f64::MAX, report);
    let alpha_mode = match material.alpha_mode.as_deref() {
        None | Some("OPAQUE") => AlphaMode::Opaque,
        Some("BLEND") => AlphaMode::Blend,
        Some("MASK") => {
            let cutoff = material.alpha_cutoff.unwrap_or(0.5);
            in_unit_range(report, "alphaCutoff", &[cutoff]);
            AlphaMode::Mask(cutoff)
        }
        Some(other) => {
            let found = format!("`{other}` is no alpha mode");
            report.error(format!("{path}.alphaMode"), found, "OPAQUE, MASK or BLEND");
            AlphaMode::Opaque
        }
    };
    Material {
        name: named(&material.name, "material", index),
        base_color: pbr.base_color_factor,
        base_color_texture: None,
        metallic: pbr.metallic_factor,
        roughness: pbr.roughness_factor,
        metallic_roughness_texture: None,
        // The specification of KHR_materials_specular, with F0 of KHR_materials_ior; its 0 means infinite.
        f0: (specular_color * if ior == 0.0 { 1.0 } else { ((ior - 1.0) / (ior + 1.0)).powi(2) })
            .min(DVec3::ONE)
            * specular,
        specular,
        clearcoat,
        sheen,
        normal_map: None,
        emission: DVec3::from(material.emissive_factor),
        emission_strength: strength,
        emission_texture: None,
        unlit: material.extensions.contains_key("KHR_materials_unlit"),
        diffuse_transmission: (share, through_color),
        diffuse_transmission_texture: None,
        transmission,
        alpha_mode,
        double_sided: material.double_sided,
        extras: material.extras.clone(),
    }
}

/// Numbers of a material's extensions.
struct Extensions<'a> {
    material: &'a json::Material,
    path: &'a str,
}

impl Extensions<'_> {
    /// A number from 0 to `most`, `default` if there is none.
    fn number(&self, extension: &str, field: &str, default: f64, most: f64, report: &mut Report) -> f64 {
        let Some(value) = self.material.extensions.get(extension).and_then(|values| values.get(field)) else {
            return default;
        };
        let number = value.as_f64().filter(|number| (0.0..=most).contains(number));
        number.unwrap_or_else(|| {
            self.report(extension, field, value, most, report);
            default
        })
    }

    /// Three such numbers.
    fn color(&self, extension: &str, field: &str, default: f64, most: f64, report: &mut Report) -> DVec3 {
        let default = DVec3::splat(default);
        let Some(value) = self.material.extensions.get(extension).and_then(|values| values.get(field)) else {
            return default;
        };
        let color = serde_json::from_value::<[f64; 3]>(value.clone()).ok();
        let color = color.filter(|color| color.iter().all(|number| (0.0..=most).contains(number)));
        color.map(DVec3::from).unwrap_or_else(|| {
            self.report(extension, field, value, most, report);
            default
        })
    }

    fn report(&self, extension: &str, field: &str, value: &Value, most: f64, report: &mut Report) {
        let expected = if most < f64::MAX {
            format!("numbers from 0 to {most}")
        } else {
            String::from("numbers of at least 0")
        };
        let at = format!("{}.extensions.{extension}.{field}", self.path);
        report.error(at, format!("{value} is out of range"), &expected);
    }
}

fn report_unused(material: &json::Material, name: &str, report: &mut Report) {
    if material.occlusion_texture.is_some() {
        report.not_honoured(Loss::OcclusionMap, name);
    }
    for (extension, values) in &material.extensions {
        if let Some(loss) = material_extension(extension) {
            report.not_honoured(loss, name);
        }
        let has = |field: &str| values.get(field).is_some();
        if ["specularTexture", "specularColorTexture", "diffuseTransmissionTexture", "transmissionTexture"]
            .into_iter()
            .any(has)
        {
            report.not_honoured(Loss::SpecularTextures, name);
        }
    }
}

fn read_texture(
    document: &Document,
    (index, encoding): (usize, Encoding),
    user: &str,
    buffers: &Buffers<'_>,
    file: &Path,
    files: &mut Files,
    report: &mut Report,
) -> Result<Result<Texture, Diagnostic>, LoadError> {
    let Some(texture) = document.textures.get(index) else {
        return Ok(Err(invalid(file, user, format!("texture {index} does not exist"))));
    };
    let path = format!("textures[{index}].source");
    // The plain image is the same picture, and every reader's first choice.
    let webp = texture.extensions.webp.as_ref().map(|webp| webp.source);
    let Some(source) = texture.source.or(webp) else {
        return Ok(Err(invalid(file, path, "the texture has no image that can be read")
            .expected("an image in PNG, JPEG or WebP")
            .remedy("export images as PNG or JPEG (Blender: Material > Images)")));
    };
    let Some(image) = document.images.get(source) else {
        return Ok(Err(invalid(file, path, format!("image {source} does not exist"))));
    };
    let place = format!("images[{source}]");
    let bytes = match (&image.buffer_view, &image.uri) {
        (Some(view), _) => {
            buffers.view(*view, &format!("{place}.bufferView")).map(|(bytes, _)| Cow::Borrowed(bytes))
        }
        (None, Some(uri)) => {
            let referrer = format!("{}: {place}.uri", file.display());
            fetch(uri, file, files, &referrer)?.map_err(|found| invalid(file, format!("{place}.uri"), found))
        }
        (None, None) => Err(invalid(file, place.as_str(), "the image has neither data nor a file")),
    };
    let name = named(&image.name, "image", source);
    if let Some(sampler) = texture.sampler {
        report.index_exists(
            format!("textures[{index}].sampler"),
            sampler,
            document.samplers.len(),
            "sampler",
        );
    }
    let sampler = texture.sampler.and_then(|sampler| document.samplers.get(sampler));
    let wrap = sampler.map_or([Wrap::Repeat; 2], |sampler| [sampler.wrap_s, sampler.wrap_t].map(wrap));
    if sampler.is_some_and(|sampler| sampler.mag_filter == Some(9728)) {
        report.not_honoured(Loss::TextureFilter, &name);
    }
    let decoded = bytes.and_then(|bytes| image::decode(&bytes, encoding, report.at(place)));
    Ok(decoded.map(|image| Texture { name, image, wrap }))
}

fn wrap(code: Option<u32>) -> Wrap {
    match code {
        Some(33071) => Wrap::Clamp,
        Some(33648) => Wrap::Mirror,
        _ => Wrap::Repeat,
    }
}
