//! Materials and the textures they need. Invariant: only images that a mesh shows are opened.

use super::buffers::{Buffers, fetch};
use super::extensions::material_extension;
use super::json::{self, Document};
use super::report::Report;
use super::{AlphaMode, Files, LoadError, Material, Texture, Wrap, invalid, named};
use crate::description::image;
use crate::diagnostic::Diagnostic;
use glam::DVec3;
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::path::Path;

/// Most texels that the textures of one file may have together; 2 GiB once decoded.
const MAX_TEXELS: usize = 1 << 27;

/// All materials, and the base colour textures of those that a mesh uses.
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
            if let Some(info) = &material.pbr_metallic_roughness.base_color_texture {
                let user = format!("materials[{index}].pbrMetallicRoughness.baseColorTexture.index");
                let number = match texture_numbers.get(&info.index) {
                    Some(number) => *number,
                    None => {
                        let texels = textures.iter().map(|texture| texture.image.texels.len()).sum::<usize>();
                        if texels > MAX_TEXELS {
                            report.error(user, "the textures are too large together", "2^27 texels in all");
                            break;
                        }
                        let texture =
                            read_texture(document, info.index, &user, buffers, file, files, report)?;
                        let number = report.keep(texture).map(|texture| {
                            textures.push(texture);
                            textures.len() - 1
                        });
                        texture_numbers.insert(info.index, number);
                        number
                    }
                };
                converted.base_color_texture = number;
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
    let number = |extension: &str, field: &str| material.extensions.get(extension)?.get(field)?.as_f64();
    let specular = number("KHR_materials_specular", "specularFactor").unwrap_or(1.0);
    in_unit_range(report, "extensions.KHR_materials_specular.specularFactor", &[specular]);
    let strength = number("KHR_materials_emissive_strength", "emissiveStrength").unwrap_or(1.0);
    if strength < 0.0 {
        let at = format!("{path}.extensions.KHR_materials_emissive_strength.emissiveStrength");
        report.error(at, format!("the strength is {strength}"), "a number of at least 0");
    }
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
        specular,
        emission: DVec3::from(material.emissive_factor) * strength,
        alpha_mode,
        double_sided: material.double_sided,
        extras: material.extras.clone(),
    }
}

fn report_unused(material: &json::Material, name: &str, report: &mut Report) {
    let textures = [
        (&material.normal_texture, "normal maps are not honoured"),
        (&material.occlusion_texture, "occlusion maps are not honoured"),
        (&material.emissive_texture, "emissive textures are not honoured, the plain emissive factor is used"),
        (
            &material.pbr_metallic_roughness.metallic_roughness_texture,
            "metallic-roughness textures are not honoured, the plain factors are used",
        ),
    ];
    for (texture, message) in textures {
        if texture.is_some() {
            report.not_honoured(message, name);
        }
    }
    for message in material.extensions.keys().filter_map(|extension| material_extension(extension)) {
        report.not_honoured(message, name);
    }
}

fn read_texture(
    document: &Document,
    index: usize,
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
    let wrap = wrap(document, texture.sampler, &name, report);
    let decoded = bytes.and_then(|bytes| image::decode(&bytes, report.at(place)));
    Ok(decoded.map(|image| Texture { name, image, wrap }))
}

fn wrap(document: &Document, sampler: Option<usize>, image: &str, report: &mut Report) -> Wrap {
    let sampler = sampler.and_then(|sampler| document.samplers.get(sampler));
    let (across, down) = sampler.map_or((None, None), |sampler| (sampler.wrap_s, sampler.wrap_t));
    if across.unwrap_or(10497) != down.unwrap_or(10497) {
        report.not_honoured("textures that wrap differently in u and v wrap both ways as in u", image);
    }
    match across {
        Some(33071) => Wrap::Clamp,
        Some(33648) => Wrap::Mirror,
        _ => Wrap::Repeat,
    }
}
