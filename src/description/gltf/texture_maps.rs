//! Supported textures of a material, and their texture coordinates. In goes a material, out come slots and
//! layers. Invariant: the base colour's coordinates come first, and textures share equal coordinates.

use super::json::{Material, TextureInfo, TextureTransform};
use super::textures::Look;
use crate::description::image::Encoding;
use glam::{DAffine2, DMat2, DVec2};

#[derive(Debug)]
pub(super) struct Slot {
    pub(super) purpose: Purpose,
    pub(super) look: Look,
    pub(super) info: TextureInfo,
    pub(super) path: &'static str,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Purpose {
    BaseColor,
    Clearcoat,
    ClearcoatNormal,
    ClearcoatRoughness,
    DiffuseTransmission,
    Emission,
    Glossiness,
    MetallicRoughness,
    Normal,
    SheenColor,
    SheenRoughness,
    SpecularColor,
}

impl Purpose {
    pub(super) fn encoding(self) -> Encoding {
        match self {
            Self::BaseColor
            | Self::DiffuseTransmission
            | Self::Emission
            | Self::SheenColor
            | Self::SpecularColor => Encoding::Srgb,
            Self::Clearcoat
            | Self::ClearcoatNormal
            | Self::ClearcoatRoughness
            | Self::Glossiness
            | Self::MetallicRoughness
            | Self::Normal
            | Self::SheenRoughness => Encoding::Linear,
        }
    }

    pub(super) fn is_bending(self) -> bool {
        matches!(self, Self::Normal | Self::ClearcoatNormal)
    }
}

/// Set of texture coordinates, and its transform.
pub(super) type Layer = (usize, DAffine2);

/// Supported textures of a material.
pub(super) fn slots(material: &Material) -> Vec<Slot> {
    let pbr = &material.pbr_metallic_roughness;
    let of_extension = |(purpose, path): (Purpose, &'static str)| {
        let (extension, field) = path.strip_prefix("extensions.")?.split_once('.')?;
        // A malformed texture is reported with its extension.
        let info = material.extensions.get(extension)?.get(field)?;
        Some(plain(purpose, serde_json::from_value(info.clone()).ok()?, path))
    };
    let unlit = material.extensions.contains_key("KHR_materials_unlit");
    let all = [
        (Purpose::BaseColor, pbr.base_color_texture.clone(), "pbrMetallicRoughness.baseColorTexture"),
        (Purpose::Emission, material.emissive_texture.clone(), "emissiveTexture"),
        (
            Purpose::MetallicRoughness,
            pbr.metallic_roughness_texture.clone(),
            "pbrMetallicRoughness.metallicRoughnessTexture",
        ),
        (Purpose::Normal, material.normal_texture.clone(), "normalTexture"),
    ];
    let glossiness = material.glossiness.iter().map(|glossiness| Slot {
        purpose: Purpose::Glossiness,
        look: Look::Roughness { glossiness: glossiness.factor },
        info: glossiness.texture.clone(),
        path: "extensions.KHR_materials_pbrSpecularGlossiness.specularGlossinessTexture",
    });
    all.into_iter()
        .filter_map(|(purpose, info, path)| Some(plain(purpose, info?, path)))
        .chain(glossiness)
        .chain(OF_EXTENSIONS.into_iter().filter_map(of_extension))
        .filter(|slot| !unlit || slot.purpose == Purpose::BaseColor)
        .collect()
}

/// Texture whose texels are used as they are.
fn plain(purpose: Purpose, info: TextureInfo, path: &'static str) -> Slot {
    Slot { purpose, look: Look::Plain(purpose.encoding()), info, path }
}

const OF_EXTENSIONS: [(Purpose, &str); 7] = [
    (
        Purpose::DiffuseTransmission,
        "extensions.KHR_materials_diffuse_transmission.diffuseTransmissionColorTexture",
    ),
    (Purpose::Clearcoat, "extensions.KHR_materials_clearcoat.clearcoatTexture"),
    (Purpose::ClearcoatRoughness, "extensions.KHR_materials_clearcoat.clearcoatRoughnessTexture"),
    (Purpose::ClearcoatNormal, "extensions.KHR_materials_clearcoat.clearcoatNormalTexture"),
    (Purpose::SheenColor, "extensions.KHR_materials_sheen.sheenColorTexture"),
    (Purpose::SheenRoughness, "extensions.KHR_materials_sheen.sheenRoughnessTexture"),
    (Purpose::SpecularColor, "extensions.KHR_materials_specular.specularColorTexture"),
];

/// Layers of texture coordinates that a material uses.
pub(super) fn layers(slots: &[Slot]) -> Vec<Layer> {
    let mut layers: Vec<Layer> = Vec::new();
    for layer in slots.iter().map(|slot| layer(&slot.info)) {
        if !layers.contains(&layer) {
            layers.push(layer);
        }
    }
    layers
}

pub(super) fn layer(info: &TextureInfo) -> Layer {
    match &info.extensions.transform {
        Some(transform) => (transform.tex_coord.unwrap_or(info.tex_coord), uv_transform(transform)),
        None => (info.tex_coord, DAffine2::IDENTITY),
    }
}

/// Matrix that scales, then rotates, then translates. The rotation is counter-clockwise on the screen, with v
/// down (KHR_texture_transform, "Overview").
fn uv_transform(transform: &TextureTransform) -> DAffine2 {
    let scale = transform.scale.map_or(DVec2::ONE, DVec2::from);
    let linear = DMat2::from_angle(-transform.rotation) * DMat2::from_diagonal(scale);
    DAffine2::from_mat2_translation(linear, DVec2::from(transform.offset))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texture_transform_is_that_of_blenders_mapping_node() {
        // Blender 5.0.1 exports a mapping node with location (0.1, 0.2), rotation 0.5 and scale 2 so.
        let exported = TextureTransform {
            offset: [-0.858_851_075_718_289_9, -0.955_165_126_760_977_8],
            rotation: 0.5,
            scale: Some([2.0, 2.0]),
            tex_coord: None,
        };
        let blender = DAffine2::from_scale_angle_translation(DVec2::splat(2.0), 0.5, DVec2::new(0.1, 0.2));
        let flip = |uv: DVec2| DVec2::new(uv.x, 1.0 - uv.y);
        for uv in [DVec2::ZERO, DVec2::X, DVec2::new(0.3, 0.9)] {
            let expected = flip(blender.transform_point2(flip(uv)));
            assert!((uv_transform(&exported).transform_point2(uv) - expected).length() < 1e-6);
        }
    }

    #[test]
    fn common_coordinates_are_there_once_and_a_transform_may_name_its_set() {
        let material: Material = serde_json::from_value(serde_json::json!({
            "pbrMetallicRoughness": {
                "baseColorTexture": { "index": 0, "texCoord": 1 },
                "metallicRoughnessTexture": { "index": 1, "texCoord": 1 }
            },
            "normalTexture": { "index": 2, "extensions": { "KHR_texture_transform": { "texCoord": 1 } } },
            "emissiveTexture": { "index": 3, "extensions": { "KHR_texture_transform": { "scale": [2, 2] } } }
        }))
        .expect("a material");
        let slots = slots(&material);
        let layers = layers(&slots);
        assert_eq!(layers.iter().map(|layer| layer.0).collect::<Vec<_>>(), [1, 0]);
        assert_eq!(layers[1].1.transform_point2(DVec2::new(0.25, 0.5)), DVec2::new(0.5, 1.0));
        assert_eq!(
            slots.iter().map(|slot| slot.purpose.encoding()).filter(|e| *e == Encoding::Linear).count(),
            2
        );
    }
}
