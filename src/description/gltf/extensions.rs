//! Support of glTF extensions. In goes a document, out come warnings and errors. Invariant: a required
//! extension that would change the meaning of the file's data is refused by name, with the exporter's setting
//! as the remedy.

use super::json::Document;
use super::report::Report;
use crate::diagnostic::{Diagnostic, Loss};

enum Support {
    /// Fully supported.
    Honoured,
    /// Ignored, as the rest of the file keeps its meaning; each use is reported where it is read.
    Reported,
    /// Ignored, as it has no effect on pictures.
    Aside,
    /// Refused, as the data are unreadable without it; the text is how to export without it.
    Refused(&'static str),
}

const HONOURED: &[&str] = &[
    "EXT_mesh_gpu_instancing",
    "EXT_meshopt_compression",
    "EXT_texture_webp",
    "KHR_animation_pointer",
    "KHR_draco_mesh_compression",
    "KHR_lights_punctual",
    "KHR_materials_clearcoat",
    "KHR_materials_diffuse_transmission",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_pbrSpecularGlossiness",
    "KHR_materials_sheen",
    "KHR_materials_specular",
    "KHR_materials_unlit",
    "KHR_mesh_quantization",
    "KHR_meshopt_compression",
    "KHR_node_visibility",
    "KHR_texture_basisu",
    "KHR_texture_transform",
];

/// Unsupported formats of textures, which are reported one by one, and other models of materials, whose core
/// values are used.
const REPORTED: &[&str] = &[
    "EXT_texture_astc",
    "EXT_texture_avif",
    "EXT_texture_heic",
    "GOOGLE_texture_basis",
    "KHR_technique_webgl",
    "KHR_techniques_webgl",
    "KHR_texture_ktx",
    "KHR_materials_common",
    "KHR_materials_anisotropy",
    "KHR_materials_dispersion",
    "KHR_materials_iridescence",
    "KHR_materials_transmission",
    "KHR_materials_variants",
    "KHR_materials_volume",
    "MSFT_texture_dds",
];

/// Metadata, sound, interaction and physics without a simulation.
const ASIDE: &[&str] = &[
    "AGI_articulations",
    "AGI_stk_metadata",
    "CESIUM_primitive_outline",
    "EXT_instance_features",
    "EXT_mesh_features",
    "EXT_mesh_manifold",
    "EXT_mesh_primitive_edge_visibility",
    "EXT_structural_metadata",
    "FB_geometry_metadata",
    "FB_ngon_encoding",
    "GODOT_single_root",
    "KHR_audio_emitter",
    "KHR_audio_graph",
    "KHR_collision_shapes",
    "KHR_implicit_shapes",
    "KHR_interactivity",
    "KHR_node_hoverability",
    "KHR_node_selectability",
    "KHR_physics_rigid_bodies",
    "KHR_xmp",
    "KHR_xmp_json_ld",
    "MPEG_audio_spatial",
    "MPEG_viewport_recommended",
    "MSFT_lod",
];

/// Support of the registry's extensions (KhronosGroup/glTF, extensions/README.md, July 2026), ratified, in
/// progress and archived, and of other common ones. `None` for unknown ones.
fn support(extension: &str) -> Option<Support> {
    Some(if HONOURED.contains(&extension) {
        Support::Honoured
    } else if REPORTED.contains(&extension) {
        Support::Reported
    } else if ASIDE.contains(&extension) || extension.starts_with("OMI_") || extension.starts_with("VRMC_") {
        Support::Aside
    } else {
        Support::Refused(remedy(extension)?)
    })
}

/// Remedy: an export without an extension that changes the meaning of the data.
fn remedy(extension: &str) -> Option<&'static str> {
    Some(match extension {
        "KHR_texture_video" | "MPEG_media" | "MPEG_texture_video" => {
            "export a still image in place of the video: textures do not change here"
        }
        "KHR_texture_procedurals" | "EXT_texture_procedurals_mx_1_39" | "NV_materials_mdl" => {
            "bake the material's nodes to images, and export those with plain metallic-roughness"
        }
        "ADOBE_materials_clearcoat_specular"
        | "ADOBE_materials_clearcoat_tint"
        | "ADOBE_materials_thin_transparency"
        | "KHR_materials_subsurface"
        | "KHR_materials_volume_scatter"
        | "MSFT_packing_normalRoughnessMetallic"
        | "MSFT_packing_occlusionRoughnessMetallic" => {
            "export the materials without it: plain metallic-roughness, with light through leaves as `sunfleck_leaf`"
        }
        "EXT_lights_image_based" | "KHR_environment_map" | "KHR_lights_environment" => {
            "export without it, and give the scene its sky in the custom property `sunfleck_env`: colours, or a .hdr or .exr image"
        }
        "EXT_lights_ies" => "export lights without their profiles, as points and spots",
        "KHR_gaussian_splatting"
        | "KHR_gaussian_splatting_compression_spz"
        | "KHR_gaussian_splatting_compression_spz_2" => {
            "export triangles: splats have no surface that could cast a shadow"
        }
        "EXT_implicit_cylinder_region" | "EXT_implicit_ellipsoid_region" | "EXT_primitive_voxels" => {
            "export triangles, and fog as boxes with the custom property `sunfleck_fog_volume`"
        }
        "EXT_mesh_primitive_restart" => "export strips and fans one by one, or as plain triangles",
        "KHR_accessor_float64" => "export in single precision, and move the scene near the origin first",
        "CESIUM_RTC" | "WEB3D_quantized_attributes" | "KHR_binary_glTF" => {
            "convert the file to glTF 2.0, with KHR_mesh_quantization or without compression"
        }
        "MPEG_accessor_timed"
        | "MPEG_animation_timing"
        | "MPEG_buffer_circular"
        | "MPEG_mesh_linking"
        | "MPEG_scene_dynamic" => {
            "export the scene as a file that is whole, with its motion as animations: nothing is streamed here"
        }
        "GRIFFEL_bim_data" => "export without data of buildings",
        _ => return None,
    })
}

/// Refuses required extensions that are not supported, and reports others that are ignored.
pub(super) fn check(document: &Document, report: &mut Report) {
    for (index, name) in document.extensions_required.iter().enumerate() {
        let remedy = match support(name) {
            Some(Support::Honoured | Support::Reported | Support::Aside) => continue,
            Some(Support::Refused(remedy)) => remedy,
            None => {
                "export without this extension: look for it among the exporter's options, or for its vendor's converter"
            }
        };
        let place = report.at(format!("extensionsRequired[{index}]"));
        report.push(
            Diagnostic::error(place, format!("the file requires the extension `{name}`, which is not read"))
                .expected("a file that can be read without it")
                .remedy(remedy),
        );
    }
    for name in &document.extensions_used {
        let is_required = document.extensions_required.contains(name);
        match support(name) {
            None if !is_required => report.not_honoured(Loss::UnknownExtension, name),
            Some(Support::Refused(_)) => report.not_honoured(Loss::ExtensionPassedOver, name),
            Some(Support::Aside) if is_required => {
                report.not_honoured(Loss::ExtensionWithoutPicture, name);
            }
            _ => {}
        }
    }
}

/// Loss for a material's extension that is not supported, which names its replacement.
pub(super) fn material_extension(extension: &str) -> Option<Loss> {
    Some(match extension {
        honoured if HONOURED.contains(&honoured) => return None,
        "KHR_materials_transmission" => Loss::TransmissionRough,
        "KHR_materials_volume" | "KHR_materials_dispersion" => Loss::TransmissionVolume,
        "KHR_materials_variants" => Loss::MaterialVariants,
        "KHR_materials_anisotropy" => Loss::Anisotropy,
        "KHR_materials_iridescence" => Loss::Iridescence,
        _ => Loss::UnknownMaterialExtension,
    })
}
