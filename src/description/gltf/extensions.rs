//! Which glTF extensions are understood. Invariant: a required extension that would change what
//! the file's data mean is refused by name, with the exporter's setting that avoids it.

use super::json::Document;
use super::report::Report;
use crate::diagnostic::Diagnostic;

/// What becomes of an extension.
enum Support {
    /// Done as it says.
    Honoured,
    /// The rest of the file means the same without it; each use is reported where it is read.
    Reported,
    /// Nothing can be read without it; how to export without it.
    Refused(&'static str),
}

fn support(extension: &str) -> Option<Support> {
    Some(match extension {
        "EXT_mesh_gpu_instancing"
        | "EXT_meshopt_compression"
        | "EXT_texture_webp"
        | "KHR_animation_pointer"
        | "KHR_draco_mesh_compression"
        | "KHR_lights_punctual"
        | "KHR_materials_clearcoat"
        | "KHR_materials_diffuse_transmission"
        | "KHR_materials_emissive_strength"
        | "KHR_materials_ior"
        | "KHR_materials_sheen"
        | "KHR_materials_specular"
        | "KHR_materials_unlit"
        | "KHR_mesh_quantization"
        | "KHR_meshopt_compression"
        | "KHR_node_visibility"
        | "KHR_texture_transform" => Support::Honoured,
        "KHR_materials_anisotropy"
        | "KHR_materials_dispersion"
        | "KHR_materials_iridescence"
        | "KHR_materials_transmission"
        | "KHR_materials_variants"
        | "KHR_materials_volume" => Support::Reported,
        "KHR_texture_basisu" => Support::Refused("export images as PNG or JPEG, not KTX2"),
        _ => return None,
    })
}

/// Refuses required extensions that are not understood, and says which others are passed over.
pub(super) fn check(document: &Document, report: &mut Report) {
    for (index, name) in document.extensions_required.iter().enumerate() {
        let remedy = match support(name) {
            Some(Support::Honoured | Support::Reported) => continue,
            Some(Support::Refused(remedy)) => remedy,
            None => "export without this extension",
        };
        let place = report.at(format!("extensionsRequired[{index}]"));
        report.push(
            Diagnostic::error(place, format!("the file requires the extension `{name}`, which is not read"))
                .expected("a file that can be read without it")
                .remedy(remedy),
        );
    }
    for name in &document.extensions_used {
        if !document.extensions_required.contains(name) && support(name).is_none() {
            report.not_honoured("extensions that are not known are passed over", name);
        } else if matches!(support(name), Some(Support::Refused(_))) {
            report.not_honoured(
                "what these extensions add is passed over, the file's plain data are used",
                name,
            );
        }
    }
}

/// What a material's extension asks for that is not honoured, and what is done instead.
pub(super) fn material_extension(extension: &str) -> Option<&'static str> {
    Some(match extension {
        "KHR_materials_clearcoat"
        | "KHR_materials_diffuse_transmission"
        | "KHR_materials_emissive_strength"
        | "KHR_materials_ior"
        | "KHR_materials_sheen"
        | "KHR_materials_specular"
        | "KHR_materials_unlit" => return None,
        "KHR_materials_transmission" => {
            "what transparent materials let through goes straight on, neither bent nor blurred"
        }
        "KHR_materials_volume" | "KHR_materials_dispersion" => {
            "the inside of transparent materials is not honoured, light goes straight through"
        }
        "KHR_materials_variants" => "material variants are not honoured, the default one is drawn",
        "KHR_materials_anisotropy" => "anisotropy of highlights is not honoured",
        "KHR_materials_iridescence" => "iridescence is not honoured",
        _ => "extensions of materials that are not known are passed over",
    })
}
