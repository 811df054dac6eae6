//! Clear coat and sheen, as glTF's extensions. In goes a material, out come its extensions. Invariant: a
//! material without a layer has no extension for it.

use super::Writer;
use crate::scene::{Clearcoat, Material, Sheen, TextureIndex, TextureMap};
use serde_json::{Value, json};

impl Writer<'_> {
    pub(super) fn add_layers(&mut self, material: &Material, extensions: &mut Value) {
        let mut add = |name: &'static str, fields: Vec<(&str, Option<Value>)>| {
            self.extensions.insert(name);
            extensions[name] =
                fields.into_iter().filter_map(|(field, value)| Some((field.to_owned(), value?))).collect();
        };
        let info = |map: Option<TextureMap>| map.map(texture_info);
        if let Some(Clearcoat { share, texture, roughness, roughness_texture, normal_map }) =
            material.clearcoat
        {
            let normal_map = normal_map.map(|(map, scale)| {
                let mut info = texture_info(map);
                info["scale"] = json!(scale);
                info
            });
            add(
                "KHR_materials_clearcoat",
                vec![
                    ("clearcoatFactor", Some(json!(share))),
                    ("clearcoatTexture", info(texture)),
                    ("clearcoatRoughnessFactor", Some(json!(roughness))),
                    ("clearcoatRoughnessTexture", info(roughness_texture)),
                    ("clearcoatNormalTexture", normal_map),
                ],
            );
        }
        if let Some(Sheen { color, color_texture, roughness, roughness_texture }) = material.sheen {
            add(
                "KHR_materials_sheen",
                vec![
                    ("sheenColorFactor", Some(json!(color.to_array()))),
                    ("sheenColorTexture", info(color_texture)),
                    ("sheenRoughnessFactor", Some(json!(roughness))),
                    ("sheenRoughnessTexture", info(roughness_texture)),
                ],
            );
        }
    }
}

/// Whether an image of a material's layers holds numbers rather than colours.
pub(super) fn is_data(material: &Material, texture: TextureIndex) -> bool {
    let coat = material.clearcoat.iter().flat_map(|coat| {
        [coat.texture, coat.roughness_texture, coat.normal_map.map(|(map, _)| map)].into_iter().flatten()
    });
    let sheen = material.sheen.iter().filter_map(|sheen| sheen.roughness_texture);
    coat.chain(sheen).any(|map| map.texture == texture)
}

/// A material's reference to a texture.
pub(super) fn texture_info(map: TextureMap) -> Value {
    json!({ "index": map.texture, "texCoord": map.layer })
}
