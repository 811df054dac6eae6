//! OBJ models. In go models, out come meshes with materials of their own. Invariant: the materials of an OBJ
//! file exist once, however many meshes show it.

use super::{AlphaMode, Coat, Material, MaterialIndex, Mesh, Resolver, TextureMap, Triangle, Wrap};
use crate::color::Rgb;
use crate::description::obj::{ObjMaterial, ObjModel, ObjPicture, ObjPictures};
use crate::description::ron::{Named, Replacement};
use crate::scene::Clearcoat;
use std::collections::BTreeMap;
use std::path::Path;

impl<'a> Resolver<'a> {
    /// Adds the images of MTL files.
    pub(super) fn add_obj_pictures(&mut self, pictures: ObjPictures) {
        for (picture, image) in pictures {
            let Some(image) = image else { continue };
            let mut texture = super::texture(Path::new(&picture.name()), image);
            if picture.is_clamped {
                texture.wrap = [Wrap::Clamp; 2];
            }
            self.obj_pictures.insert(picture, self.scene.textures.len());
            self.scene.textures.push(texture);
        }
    }

    /// Mesh of a model, whose materials are appended, except for replaced ones. `key` is the model's file and
    /// its number in a sequence.
    pub(super) fn model_mesh(
        &mut self,
        name: &'a str,
        key: (&'a Path, usize),
        model: &ObjModel,
        replaced: Option<&'a Named<Replacement>>,
    ) -> Option<Mesh> {
        let replaced = self.replaced(name, model, replaced)?;
        let first_material = self.model_materials.get(&key).copied().unwrap_or_else(|| {
            let first = self.scene.materials.len();
            let materials: Vec<Material> =
                model.materials.iter().map(|material| self.obj_material(material)).collect();
            self.scene.materials.extend(materials);
            self.model_materials.insert(key, first);
            first
        });
        Some(Mesh {
            name: name.to_owned(),
            positions: model.positions.clone(),
            normals: model.normals.clone(),
            uvs: model.uvs.clone(),
            colors: model.colors.clone(),
            triangles: model
                .triangles
                .iter()
                .map(|triangle| Triangle {
                    vertices: triangle.vertices,
                    material: triangle.material.map_or(0, |material: MaterialIndex| {
                        replaced.get(&material).copied().unwrap_or(first_material + material)
                    }),
                })
                .collect(),
            ..Mesh::default()
        })
    }

    /// Replacements, by the indices of the model's materials.
    fn replaced(
        &mut self,
        mesh: &'a str,
        model: &ObjModel,
        replaced: Option<&'a Named<Replacement>>,
    ) -> Option<BTreeMap<usize, MaterialIndex>> {
        let theirs = model.materials.iter().enumerate();
        let theirs: BTreeMap<&str, usize> =
            theirs.map(|(number, material)| (material.name.as_str(), number)).collect();
        let pairs = replaced.into_iter().flat_map(Named::iter);
        let found: Vec<_> = pairs
            .map(|(name, replacement)| {
                let field = format!("meshes.{mesh}.materials");
                let number = self.problems.find(&field, "material of the OBJ file", name, &theirs)?;
                let field = format!("{field}.{name}");
                let material = match replacement {
                    Replacement::Named(ours) => self.material(&field, ours)?,
                    Replacement::Inline(ours) => {
                        self.inline_materials.get(&(mesh, name)).copied().unwrap_or_else(|| {
                            let beneath = self.obj_material(&model.materials[number]);
                            let index = self.add_material(&field, ours, beneath);
                            self.inline_materials.insert((mesh, name), index);
                            index
                        })
                    }
                };
                if self.cutoffs.contains_key(&material) {
                    let found = "a material with `alpha_cutoff` cuts the whole mesh out";
                    let remedy = "give it to an object with a mesh of its own, by `material`";
                    let expected = "a material without `alpha_cutoff`";
                    self.problems.error(&field, found, expected, remedy);
                }
                Some((number, material))
            })
            .collect();
        found.into_iter().collect()
    }

    fn obj_material(&self, source: &ObjMaterial) -> Material {
        let map = |picture: Option<ObjPicture>| {
            let texture = *self.obj_pictures.get(&picture?)?;
            Some(TextureMap { texture, layer: 0 })
        };
        let color = map(source.color_picture());
        let emission_texture = map(source.emission_picture());
        let is_blended = source.opacity < 1.0 || source.opacity_texture.is_some();
        Material {
            name: source.name.clone(),
            base_color: source.diffuse,
            base_color_texture: color.map(|map| map.texture),
            emission: match emission_texture {
                // Without `Ke`, an image has its own brightness.
                Some(_) if source.emission == Rgb::ZERO => Rgb::ONE,
                _ => source.emission,
            },
            emission_texture,
            coat: self.obj_coat(source),
            clearcoat: source.clearcoat.map(|(share, roughness)| Clearcoat {
                share,
                roughness,
                ..Clearcoat::default()
            }),
            normal_map: map(source.normal_picture())
                .map(|map| (map, source.normal_map.as_ref().map_or(1.0, |texture| f64::from(texture.bump)))),
            alpha_mode: if is_blended { AlphaMode::Blend } else { AlphaMode::Opaque },
            opacity: source.opacity,
            ..Material::default()
        }
    }

    fn obj_coat(&self, source: &ObjMaterial) -> Option<Coat> {
        let coat = source.coat.as_ref()?;
        let texture = source.coat_picture().and_then(|picture| self.obj_pictures.get(&picture).copied());
        // An image replaces the plain number.
        let factor = |number: f64, has_image: bool| if texture.is_some() && has_image { 1.0 } else { number };
        Some(Coat {
            metallic: factor(coat.metallic, coat.metallic_texture.is_some()),
            roughness: factor(coat.roughness, coat.roughness_texture.is_some()),
            texture: texture.map(|texture| TextureMap { texture, layer: 0 }),
            f0: Rgb::splat(coat.f0),
            f0_texture: None,
            f90: if coat.f0 > 0.0 { 1.0 } else { 0.0 },
        })
    }
}
