//! Conversion of materials. In goes KHR_materials_pbrSpecularGlossiness, out come metallic-roughness and
//! KHR_materials_specular. Invariant: the reflectance along the normal is the same, texel by texel.
//!
//! KHR_materials_specular describes a diffuse colour under a specular one with an index of refraction of 0.
//! That means an infinite index (KHR_materials_ior), so the specular colour is the reflectance along the
//! normal itself. No metalness has to be guessed, as by the quadratic in Khronos' three.pbrUtilities. A metal
//! has a black diffuse colour under the specular one.

use super::json::{Document, Glossiness, Material, SpecularGlossiness, TextureInfo};
use super::named;
use super::report::Report;
use crate::diagnostic::{Diagnostic, Loss};
use serde_json::json;

const EXTENSION: &str = "KHR_materials_pbrSpecularGlossiness";

/// Converts every material that has the extension, and reports it.
pub(super) fn convert(document: &mut Document, report: &mut Report) {
    let mut converted = 0;
    for (index, material) in document.materials.iter_mut().enumerate() {
        let Some(value) = material.extensions.remove(EXTENSION) else { continue };
        match serde_json::from_value::<SpecularGlossiness>(value) {
            Ok(source) => {
                rewrite(material, source);
                converted += 1;
            }
            Err(error) => {
                let path = format!("materials[{index}].extensions.{EXTENSION}");
                let found =
                    format!("{error}; `{}` is drawn without it", named(&material.name, "material", index));
                report.put_right(Loss::ValueOutOfRange, &path, found);
            }
        }
    }
    if converted > 0 {
        let found = format!(
            "{converted} of {} materials describe specular colour and glossiness: they are converted to metallic-roughness",
            document.materials.len()
        );
        report.push(Diagnostic::choice(report.at("materials"), found).counting(converted));
    }
}

/// Replaces the material's numbers and textures by the converted ones.
fn rewrite(material: &mut Material, source: SpecularGlossiness) {
    // An unlit base colour stays as it is.
    if material.extensions.contains_key("KHR_materials_unlit") {
        return;
    }
    let gloss_map: Option<TextureInfo> =
        source.specular_glossiness_texture.clone().and_then(|info| serde_json::from_value(info).ok());
    let [red, green, blue, alpha] = source.diffuse_factor;
    let pbr = &mut material.pbr_metallic_roughness;
    pbr.roughness_factor = 1.0 - source.glossiness_factor;
    pbr.metallic_roughness_texture = None;
    let is_metal = [red, green, blue] == [0.0; 3] && source.diffuse_texture.is_none() && gloss_map.is_none();
    if is_metal {
        let [red, green, blue] = source.specular_factor;
        pbr.base_color_factor = [red, green, blue, alpha];
        (pbr.base_color_texture, pbr.metallic_factor) = (None, 1.0);
        return;
    }
    pbr.base_color_factor = source.diffuse_factor;
    (pbr.base_color_texture, pbr.metallic_factor) = (source.diffuse_texture, 0.0);
    let mut specular = json!({ "specularColorFactor": source.specular_factor });
    if let Some(info) = source.specular_glossiness_texture.filter(|_| gloss_map.is_some()) {
        specular["specularColorTexture"] = info;
    }
    material.extensions.insert(String::from("KHR_materials_specular"), specular);
    material.extensions.insert(String::from("KHR_materials_ior"), json!({ "ior": 0 }));
    let factor = source.glossiness_factor.clamp(0.0, 1.0);
    material.glossiness = gloss_map.map(|texture| Glossiness { factor, texture });
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::Value;

    fn rewritten(extension: Value) -> Material {
        let mut material = Material::default();
        rewrite(&mut material, serde_json::from_value(extension).expect("the extension"));
        material
    }

    #[test]
    fn a_diffuse_colour_lies_under_its_specular_one() {
        let material = rewritten(json!({
            "diffuseFactor": [0.0, 1.0, 0.0, 0.5], "specularFactor": [0.1, 0.2, 0.3], "glossinessFactor": 0.25,
            "specularGlossinessTexture": { "index": 3 }
        }));
        let pbr = &material.pbr_metallic_roughness;
        assert_eq!(pbr.base_color_factor, [0.0, 1.0, 0.0, 0.5]);
        assert_eq!((pbr.metallic_factor, pbr.roughness_factor), (0.0, 0.75));
        let specular = &material.extensions["KHR_materials_specular"];
        assert_eq!(specular["specularColorFactor"], json!([0.1, 0.2, 0.3]));
        assert_eq!(specular["specularColorTexture"]["index"], json!(3));
        assert_eq!(material.glossiness.map(|glossiness| glossiness.factor), Some(0.25));
    }

    #[test]
    fn black_beneath_a_specular_colour_is_a_metal() {
        let material = rewritten(json!({ "diffuseFactor": [0, 0, 0, 1], "specularFactor": [1.0, 0.8, 0.3] }));
        let pbr = &material.pbr_metallic_roughness;
        assert_eq!((pbr.base_color_factor, pbr.metallic_factor), ([1.0, 0.8, 0.3, 1.0], 1.0));
        assert_eq!(pbr.roughness_factor, 0.0);
    }
}
