//! Files that a scene refers to. In goes a parsed scene, out comes the same with its meshes and textures.
//! Invariant: meshes, materials and textures that the picture does not use are not read.

use super::{Animated, Light, LoadedScene, Material, NormalMap, Replacement, SceneFile, Sky, Sun, beside};
use crate::description::image::{self, Encoding};
use crate::description::{Files, LoadError, obj, vdb};
use crate::diagnostic::{Diagnostics, Place};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// Reads the files that `file` at `path` refers to; `models` are read already.
pub(super) fn load(
    path: &Path,
    file: SceneFile,
    mut models: BTreeMap<PathBuf, obj::ObjModel>,
    files: &mut Files,
) -> Result<LoadedScene, LoadError> {
    let used = Used::by(&file);
    let mut loader = Loader { path, files, problems: Diagnostics::default() };
    let (mut images, mut obj_pictures) = (BTreeMap::new(), obj::ObjPictures::new());
    let mut normal_maps = BTreeMap::new();
    for (name, mesh) in file.meshes.iter().filter(|(name, _)| used.meshes.contains(name)) {
        let Some((obj_path, replacements)) = mesh.obj() else { continue };
        let referrer = format!("meshes.{name}");
        if !models.contains_key(obj_path) {
            let Some(model) = loader.model(obj_path, &referrer)? else { continue };
            models.insert(obj_path.clone(), model);
        }
        if used.own_materials.contains(name)
            && let Some(model) = models.get_mut(obj_path)
        {
            let is_replaced = |material: &str| {
                replacements.and_then(|all| all.get(material)).is_some_and(|by| by.name().is_some())
            };
            obj::load_pictures(model, &is_replaced, loader.files, &mut obj_pictures);
        }
    }
    for (name, material) in file.materials.iter().filter(|(name, _)| used.materials.contains(name)) {
        loader.pictures(&format!("materials.{name}"), material, &mut images, &mut normal_maps)?;
    }
    for (mesh, name, replacement) in used.replacements(&file) {
        let Some(material) = replacement.inline() else { continue };
        let owner = format!("meshes.{mesh}.materials.{name}");
        loader.pictures(&owner, material, &mut images, &mut normal_maps)?;
    }
    let (sun_images, grids) = (loader.sun_images(&file)?, loader.grids(&file)?);
    let sky_image = loader.sky(file.sky.as_ref())?;
    if loader.problems.has_errors() {
        return Err(LoadError::Invalid(loader.problems));
    }
    Ok(LoadedScene {
        path: path.to_owned(),
        file,
        models,
        images,
        obj_pictures,
        sun_images,
        normal_maps,
        grids,
        sky_image,
        is_mesh_alone: false,
    })
}

/// Names that the picture uses.
#[derive(Default)]
struct Used<'a> {
    meshes: BTreeSet<&'a str>,
    /// Meshes that are visible with the materials of their own files.
    own_materials: BTreeSet<&'a str>,
    materials: BTreeSet<&'a str>,
}

impl<'a> Used<'a> {
    fn by(file: &'a SceneFile) -> Self {
        let mut used = Self::default();
        for (_, object) in file.objects.iter().filter(|(_, object)| object.visible != Animated::Still(false))
        {
            used.add(object.mesh.as_slice(), object.material.as_slice());
        }
        for (_, leaves) in file.leaves.iter() {
            used.add(&leaves.meshes, &leaves.materials);
        }
        for (_, fall) in file.fall.iter() {
            for species in &fall.species {
                used.add(&species.meshes, &species.materials);
            }
        }
        let named: Vec<_> =
            used.replacements(file).filter_map(|(.., replacement)| replacement.name()).collect();
        used.materials.extend(named);
        used
    }

    /// Replacements of OBJ files' materials: mesh, name in the file, and replacement.
    fn replacements(&self, file: &'a SceneFile) -> impl Iterator<Item = (&'a str, &'a str, &'a Replacement)> {
        let dressed = file.meshes.iter().filter(|(name, _)| self.own_materials.contains(name));
        dressed.filter_map(|(mesh, shape)| Some((mesh, shape.obj()?.1?))).flat_map(|(mesh, replacements)| {
            replacements.iter().map(move |(name, replacement)| (mesh, name, replacement))
        })
    }

    fn add(&mut self, meshes: &'a [String], materials: &'a [String]) {
        let meshes = meshes.iter().map(String::as_str);
        self.materials.extend(materials.iter().map(String::as_str));
        if materials.is_empty() {
            self.own_materials.extend(meshes.clone());
        }
        self.meshes.extend(meshes);
    }
}

/// Reads files and continues after invalid ones, so that all of them are reported.
struct Loader<'a> {
    path: &'a Path,
    files: &'a mut Files,
    problems: Diagnostics,
}

impl Loader<'_> {
    fn model(&mut self, obj_path: &Path, referrer: &str) -> Result<Option<obj::ObjModel>, LoadError> {
        let referrer = format!("{}: {referrer}", self.path.display());
        let model = obj::load(&beside(self.path, obj_path), &referrer, self.files);
        self.valid(model)
    }

    /// Result of reading; `None` for an invalid file, whose problems are kept.
    fn valid<T>(&mut self, read: Result<T, LoadError>) -> Result<Option<T>, LoadError> {
        match read {
            Ok(read) => Ok(Some(read)),
            Err(LoadError::Invalid(problems)) => {
                self.problems.0.extend(problems.0);
                Ok(None)
            }
            Err(error) => Err(error),
        }
    }

    fn sun_images(&mut self, file: &SceneFile) -> Result<BTreeMap<PathBuf, image::DecodedImage>, LoadError> {
        let mut images = BTreeMap::new();
        for (name, light) in file.lights.iter() {
            if let Light::Sun(Sun { image: Some(image), .. }) = light {
                self.image(image, Encoding::Srgb, &format!("lights.{name}.image"), &mut images)?;
            }
        }
        Ok(images)
    }

    fn grids(&mut self, file: &SceneFile) -> Result<BTreeMap<PathBuf, vdb::GridFiles>, LoadError> {
        let mut grids = BTreeMap::new();
        for (name, fog) in file.fog.iter() {
            let Some(vdb) = fog.vdb.as_ref().filter(|vdb| !grids.contains_key(*vdb)) else { continue };
            let path = beside(self.path, vdb);
            let referrer = format!("{}: fog.{name}.vdb", self.path.display());
            let found = vdb::load_files(&path, &referrer, self.files);
            grids.extend(self.valid(found)?.map(|found| (vdb.clone(), found)));
        }
        Ok(grids)
    }

    fn sky(&mut self, sky: Option<&Sky>) -> Result<Option<image::DecodedImage>, LoadError> {
        match sky {
            Some(Sky::Image { image, .. }) => self.decoded(image, Encoding::Radiance, "sky.image"),
            _ => Ok(None),
        }
    }

    fn pictures(
        &mut self,
        owner: &str,
        material: &Material,
        images: &mut BTreeMap<PathBuf, image::DecodedImage>,
        normal_maps: &mut BTreeMap<PathBuf, image::DecodedImage>,
    ) -> Result<(), LoadError> {
        let textures =
            [("texture", &material.texture), ("transmission_texture", &material.transmission_texture)];
        for (field, texture) in textures {
            let Some(texture) = texture else { continue };
            self.image(texture, Encoding::Srgb, &format!("{owner}.{field}"), images)?;
        }
        if let Some(NormalMap { texture, .. }) = &material.normal_map {
            self.image(texture, Encoding::Linear, &format!("{owner}.normal_map.texture"), normal_maps)?;
        }
        Ok(())
    }

    fn image(
        &mut self,
        texture: &Path,
        encoding: Encoding,
        referrer: &str,
        images: &mut BTreeMap<PathBuf, image::DecodedImage>,
    ) -> Result<(), LoadError> {
        if images.contains_key(texture) {
            return Ok(());
        }
        let image = self.decoded(texture, encoding, referrer)?;
        images.extend(image.map(|image| (texture.to_owned(), image)));
        Ok(())
    }

    fn decoded(
        &mut self,
        image: &Path,
        encoding: Encoding,
        referrer: &str,
    ) -> Result<Option<image::DecodedImage>, LoadError> {
        let path = beside(self.path, image);
        let bytes = self.files.read(&path, Some(&format!("{}: {referrer}", self.path.display())))?;
        self.valid(image::decode(&bytes, encoding, Place::File(path)).map_err(LoadError::from))
    }
}
