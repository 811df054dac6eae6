//! Materials and their textures. In goes JSON, out come materials. Invariant: only images of visible meshes
//! are opened, and every number of a material is in its range.

use super::extensions::material_extension;
use super::json::{self, Document};
use super::report::Report;
use super::texture_maps::{Purpose, Slot, layer, layers, slots};
use super::textures::Textures;
use super::{AlphaMode, Clearcoat, Material, Sheen, Texture, TextureMap, named};
use crate::diagnostic::Loss;
use glam::DVec3;
use serde_json::Value;
use std::collections::BTreeSet;

/// Minimum roughness of sheen: below it the extension's fitted shadowing is inaccurate
/// (`scattering/sheen.rs`).
const LEAST_HONOURED_SHEEN: f64 = 0.3;

/// Reads all materials, and the textures of those that a visible mesh uses.
pub(super) fn read(
    document: &Document,
    shown: &BTreeSet<usize>,
    mut textures: Textures,
    report: &mut Report,
) -> (Vec<Material>, Vec<Texture>) {
    let mut used = vec![false; document.materials.len()];
    let shown = shown.iter().filter_map(|&mesh| document.meshes.get(mesh));
    for primitive in shown.flat_map(|mesh| &mesh.primitives) {
        if let Some(used) = primitive.material.and_then(|material| used.get_mut(material)) {
            *used = true;
        }
    }
    let mut materials = Vec::with_capacity(document.materials.len());
    for (index, material) in document.materials.iter().enumerate() {
        let mut converted = convert(index, material, report);
        if used[index] {
            report_unused(material, &converted.name, report);
            let slots = slots(material);
            let layers = layers(&slots);
            for slot in &slots {
                let user = format!("materials[{index}].{}.index", slot.path);
                let texture = textures.number(slot.info.index, slot.look, &user, report);
                let layer = layers.iter().position(|known| *known == layer(&slot.info)).unwrap_or_default();
                let map = texture.map(|texture| TextureMap { texture, layer });
                put(&mut converted, slot, map);
            }
        }
        materials.push(converted);
    }
    (materials, textures.read)
}

fn put(material: &mut Material, slot: &Slot, map: Option<TextureMap>) {
    let bending = map.map(|map| (map, slot.info.scale.unwrap_or(1.0)));
    match slot.purpose {
        Purpose::BaseColor => material.base_color_texture = map.map(|map| map.texture),
        Purpose::Clearcoat => material.clearcoat.texture = map,
        Purpose::ClearcoatNormal => material.clearcoat.normal_map = bending,
        Purpose::ClearcoatRoughness => material.clearcoat.roughness_texture = map,
        Purpose::SheenColor => material.sheen.color_texture = map,
        Purpose::SheenRoughness => material.sheen.roughness_texture = map,
        Purpose::DiffuseTransmission => material.diffuse_transmission_texture = map,
        Purpose::Emission => material.emission_texture = map,
        Purpose::MetallicRoughness => material.metallic_roughness_texture = map,
        Purpose::Glossiness => {
            material.metallic_roughness_texture = map;
            // The texture then holds the whole roughness.
            material.roughness = if map.is_some() { 1.0 } else { material.roughness };
        }
        Purpose::SpecularColor => material.f0_texture = map,
        Purpose::Normal => material.normal_map = bending,
    }
}

fn convert(index: usize, material: &json::Material, report: &mut Report) -> Material {
    let path = format!("materials[{index}]");
    let pbr = &material.pbr_metallic_roughness;
    let base_color =
        in_unit_range(pbr.base_color_factor, &path, "pbrMetallicRoughness.baseColorFactor", report);
    let [metallic] =
        in_unit_range([pbr.metallic_factor], &path, "pbrMetallicRoughness.metallicFactor", report);
    let [roughness] =
        in_unit_range([pbr.roughness_factor], &path, "pbrMetallicRoughness.roughnessFactor", report);
    let emission = in_unit_range(material.emissive_factor, &path, "emissiveFactor", report);
    let mut extensions = Extensions { material, path: &path, report };
    let specular = extensions.number("KHR_materials_specular", "specularFactor", 1.0, 1.0);
    let specular_color = extensions.color("KHR_materials_specular", "specularColorFactor", 1.0, f64::MAX);
    let ior = extensions.number("KHR_materials_ior", "ior", 1.5, f64::MAX);
    let through = "KHR_materials_diffuse_transmission";
    let share = extensions.number(through, "diffuseTransmissionFactor", 0.0, 1.0);
    let through_color = extensions.color(through, "diffuseTransmissionColorFactor", 1.0, 1.0);
    let (clearcoat, sheen) = extensions.layers();
    if sheen.color.max_element() > 0.0 && sheen.roughness < LEAST_HONOURED_SHEEN {
        extensions.report.not_honoured(Loss::SheenMadeWeaker, &named(&material.name, "material", index));
    }
    let transmission = extensions.number("KHR_materials_transmission", "transmissionFactor", 0.0, 1.0);
    let strength = extensions.number("KHR_materials_emissive_strength", "emissiveStrength", 1.0, f64::MAX);
    let alpha_mode = alpha_mode(material, &path, report);
    Material {
        name: named(&material.name, "material", index),
        base_color,
        metallic,
        roughness,
        // The specification of KHR_materials_specular, with F0 of KHR_materials_ior; its 0 means infinite.
        f0: (specular_color * if ior == 0.0 { 1.0 } else { ((ior - 1.0) / (ior + 1.0)).powi(2) })
            .min(DVec3::ONE)
            * specular,
        specular,
        clearcoat,
        sheen,
        emission: DVec3::from(emission),
        emission_strength: strength,
        unlit: material.extensions.contains_key("KHR_materials_unlit"),
        diffuse_transmission: (share, through_color),
        transmission,
        alpha_mode,
        double_sided: material.double_sided,
        extras: material.extras.clone(),
        ..Material::default()
    }
}

fn alpha_mode(material: &json::Material, path: &str, report: &mut Report) -> AlphaMode {
    match material.alpha_mode.as_deref() {
        None | Some("OPAQUE") => AlphaMode::Opaque,
        Some("BLEND") => AlphaMode::Blend,
        Some("MASK") => {
            let cutoff = material.alpha_cutoff.unwrap_or(0.5);
            if cutoff < 0.0 {
                report.put_right(Loss::ValueOutOfRange, &format!("{path}.alphaCutoff"), cutoff);
            }
            // A cutoff above 1 hides everything (specification, 5.19.9).
            AlphaMode::Mask(cutoff.max(0.0))
        }
        Some(other) => {
            let found = format!("`{other}` is no alpha mode, OPAQUE is meant");
            report.put_right(Loss::ValueOutOfRange, &format!("{path}.alphaMode"), found);
            AlphaMode::Opaque
        }
    }
}

/// Clamps numbers to `0..=1`, and reports those outside.
fn in_unit_range<const N: usize>(values: [f64; N], path: &str, at: &str, report: &mut Report) -> [f64; N] {
    let within = values.map(|value| value.clamp(0.0, 1.0));
    if within != values {
        let found = match values.as_slice() {
            [value] => value.to_string(),
            values => format!("{values:?}"),
        };
        report.put_right(Loss::ValueOutOfRange, &format!("{path}.{at}"), found);
    }
    within
}

struct Extensions<'a> {
    material: &'a json::Material,
    path: &'a str,
    report: &'a mut Report,
}

impl Extensions<'_> {
    /// Clear coat and sheen.
    fn layers(&mut self) -> (Clearcoat, Sheen) {
        let (clearcoat, sheen) = ("KHR_materials_clearcoat", "KHR_materials_sheen");
        let clearcoat = Clearcoat {
            share: self.number(clearcoat, "clearcoatFactor", 0.0, 1.0),
            roughness: self.number(clearcoat, "clearcoatRoughnessFactor", 0.0, 1.0),
            ..Clearcoat::default()
        };
        let sheen = Sheen {
            color: self.color(sheen, "sheenColorFactor", 0.0, 1.0),
            roughness: self.number(sheen, "sheenRoughnessFactor", 0.0, 1.0),
            ..Sheen::default()
        };
        (clearcoat, sheen)
    }

    /// Number clamped to `0..=most`; `default` if it is missing.
    fn number(&mut self, extension: &str, field: &str, default: f64, most: f64) -> f64 {
        self.numbers(extension, field, [default], most, |value| Some([value.as_f64()?]))[0]
    }

    /// Color of three such numbers.
    fn color(&mut self, extension: &str, field: &str, default: f64, most: f64) -> DVec3 {
        let three = |value: &Value| serde_json::from_value(value.clone()).ok();
        DVec3::from(self.numbers(extension, field, [default; 3], most, three))
    }

    fn numbers<const N: usize>(
        &mut self,
        extension: &str,
        field: &str,
        default: [f64; N],
        most: f64,
        read: impl Fn(&Value) -> Option<[f64; N]>,
    ) -> [f64; N] {
        let Some(value) = self.material.extensions.get(extension).and_then(|values| values.get(field)) else {
            return default;
        };
        let numbers = read(value).filter(|numbers| numbers.iter().all(|number| number.is_finite()));
        let within = numbers.map_or(default, |numbers| numbers.map(|number| number.clamp(0.0, most)));
        if numbers != Some(within) {
            let at = format!("{}.extensions.{extension}.{field}", self.path);
            self.report.put_right(Loss::ValueOutOfRange, &at, value);
        }
        within
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
        if ["specularTexture", "diffuseTransmissionTexture", "transmissionTexture"].into_iter().any(has) {
            report.not_honoured(Loss::SpecularTextures, name);
        }
    }
}
