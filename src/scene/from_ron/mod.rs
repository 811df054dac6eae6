//! Resolution of scene files. In goes RON, out come a scene and its settings. Invariant: all problems are
//! collected, each with its field's path; unused parts are remarks.

mod cameras;
mod falls;
mod fogs;
mod hierarchy;
mod leaf_sites;
mod leaves;
mod lights;
mod masks;
mod materials;
mod mists;
mod moving;
mod normal_maps;
mod obj_models;
mod problems;
mod sequence;
mod shapes;
mod skies;
mod suns;
#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests;
mod texture_coordinates;
mod tints;
mod tracks;
mod voxel_fogs;

use super::outline::Tally;
use super::sun_picture::image_for_suns;
use super::{
    AlphaMode, Baking, Coat, Deformation, FrameRate, Instance, Material, MaterialIndex, Mesh, MeshIndex,
    Motion, NodeIndex, RenderSettings, Scene, Texture, TextureIndex, TextureMap, Triangle, Wrap, darkness,
};
use crate::description::image::DecodedImage;
use crate::description::obj::{self, ObjModel, ObjPicture};
use crate::description::ron::{self, LoadedScene, SceneFile};
use crate::description::vdb;
use crate::diagnostic::{Diagnostic, Diagnostics, Loss, Place};
use problems::Problems;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use tracks::{rotation, track};

pub(super) use sequence::{apply_sequence, frame_rate};

/// Resolves a scene. Numbered files of a mesh are frames at `rate`.
pub(super) fn resolve(
    loaded: LoadedScene,
    frame_rate: FrameRate,
    baking: &Baking,
) -> Result<(Scene, RenderSettings), Diagnostics> {
    let settings = RenderSettings { name: name_of(&loaded.path), ..RenderSettings::default() };
    let LoadedScene {
        path,
        file,
        mut models,
        images,
        obj_pictures,
        sun_images,
        normal_maps,
        grids,
        sky_image,
        is_mesh_alone,
    } = loaded;
    let mut resolver = Resolver::new(&path, (&file, &models), frame_rate);
    resolver.scene.background = file.background_w_per_m2_sr.si();
    resolver.sky_image = sky_image;
    resolver.grids = grids;
    for (image_path, image) in sun_images {
        let image = image_for_suns(&image_path.display().to_string(), image);
        resolver.sun_images.insert(image_path, image);
    }
    resolver.textures = resolver.add_textures(images);
    resolver.normal_maps = resolver.add_textures(normal_maps);
    resolver.add_obj_pictures(obj_pictures);
    resolver.materials();
    resolver.objects();
    for (name, block) in file.leaves.iter() {
        resolver.leaves(name, block);
    }
    resolver.falls(baking);
    if !is_mesh_alone {
        resolver.cameras();
        resolver.lights();
    }
    resolver.check_number_of_sun_pictures();
    resolver.fogs();
    resolver.sky();
    if !is_mesh_alone {
        resolver.remark_no_light();
    }
    let (mut scene, problems) = resolver.finish();
    for model in models.values_mut() {
        scene.remarks.0.append(&mut model.remarks.0);
    }
    if is_mesh_alone && scene.instances.is_empty() {
        let (place, found) = (Place::File(path.clone()), Loss::NothingToDraw.sentence());
        scene.remarks.push(Diagnostic::warning(Loss::NothingToDraw, place, found));
    }
    let frames = models.values().find_map(|model| model.frames()).filter(|_| is_mesh_alone);
    problems.unless_any((scene, RenderSettings { frames: frames.unwrap_or(1..=1), ..settings }))
}

fn texture(path: &Path, image: DecodedImage) -> Texture {
    let DecodedImage { width, height, texels, .. } = image;
    Texture { name: path.display().to_string(), width, height, texels, wrap: [Wrap::Repeat; 2] }
}

/// Name of a scene: its file's, or its folder's if the file is just `scene.ron`.
fn name_of(path: &Path) -> String {
    if path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("obj")) {
        return obj::name(path);
    }
    let text = |part: Option<&std::ffi::OsStr>| part.map(|part| part.to_string_lossy().into_owned());
    let folder = path.parent().and_then(|folder| text(folder.file_name()));
    match (text(path.file_stem()), folder) {
        (Some(stem), Some(folder)) if stem == "scene" => folder,
        (Some(stem), _) => stem,
        (None, _) => String::from("scene"),
    }
}

/// Resolver from names to indices.
struct Resolver<'a> {
    file: &'a SceneFile,
    models: &'a BTreeMap<PathBuf, ObjModel>,
    frame_rate: FrameRate,
    scene: Scene,
    problems: Problems,
    /// Objects placed so far.
    nodes: BTreeMap<&'a str, NodeIndex>,
    mesh_files: BTreeMap<&'a str, &'a ron::Shape>,
    meshes: BTreeMap<&'a str, MeshIndex>,
    /// Deformations of meshes with a file a frame.
    moving: BTreeMap<MeshIndex, Arc<Deformation>>,
    /// Meshes that replace each other over time, by the first of them.
    turns: BTreeMap<MeshIndex, Arc<[moving::Turn]>>,
    materials: BTreeMap<&'a str, MaterialIndex>,
    /// Materials of the scene file for a single OBJ file's material, by mesh and name.
    inline_materials: BTreeMap<(&'a str, &'a str), MaterialIndex>,
    /// First material of an OBJ model, by the file and the number of the model in its sequence.
    model_materials: BTreeMap<(&'a Path, usize), MaterialIndex>,
    textures: BTreeMap<PathBuf, TextureIndex>,
    normal_maps: BTreeMap<PathBuf, TextureIndex>,
    obj_pictures: BTreeMap<ObjPicture, TextureIndex>,
    leaf_count: u32,
    fall_count: u32,
    /// Alpha cutoffs of masked materials.
    cutoffs: BTreeMap<MaterialIndex, f64>,
    /// Meshes that masks have cut.
    cut_meshes: BTreeMap<(MeshIndex, MaterialIndex), Option<MeshIndex>>,
    /// Materials with a tint, by both.
    tinted: BTreeMap<(MaterialIndex, tints::Level), MaterialIndex>,
    outlines: Tally,
    /// Images of suns, by their paths.
    sun_images: BTreeMap<PathBuf, Arc<Texture>>,
    /// OpenVDB files, by their paths.
    grids: BTreeMap<PathBuf, vdb::GridFiles>,
    /// Image of the sky, until the sky takes it.
    sky_image: Option<DecodedImage>,
}

impl<'a> Resolver<'a> {
    fn new(
        path: &Path,
        (file, models): (&'a SceneFile, &'a BTreeMap<PathBuf, ObjModel>),
        frame_rate: FrameRate,
    ) -> Self {
        Self {
            file,
            models,
            frame_rate,
            // Material 0 is for triangles without one.
            scene: Scene { materials: vec![Material::default()], ..Scene::default() },
            problems: Problems::of(path),
            nodes: BTreeMap::new(),
            mesh_files: file.meshes.iter().collect(),
            meshes: BTreeMap::new(),
            moving: BTreeMap::new(),
            turns: BTreeMap::new(),
            materials: BTreeMap::new(),
            inline_materials: BTreeMap::new(),
            model_materials: BTreeMap::new(),
            textures: BTreeMap::new(),
            normal_maps: BTreeMap::new(),
            obj_pictures: BTreeMap::new(),
            leaf_count: 0,
            fall_count: 0,
            cutoffs: BTreeMap::new(),
            cut_meshes: BTreeMap::new(),
            tinted: BTreeMap::new(),
            outlines: Tally::default(),
            sun_images: BTreeMap::new(),
            grids: BTreeMap::new(),
            sky_image: None,
        }
    }

    /// Adds images; returns their indices by path.
    fn add_textures(&mut self, images: BTreeMap<PathBuf, DecodedImage>) -> BTreeMap<PathBuf, TextureIndex> {
        let add = |(path, image): (PathBuf, DecodedImage)| {
            self.scene.textures.push(texture(&path, image));
            (path, self.scene.textures.len() - 1)
        };
        images.into_iter().map(add).collect()
    }

    /// Parent of `owner`: `Some(None)` without one, `None` if it does not exist.
    fn parent(&mut self, owner: &str, name: Option<&str>) -> Option<Option<NodeIndex>> {
        match name {
            None => Some(None),
            Some(name) => {
                self.problems.find(&format!("{owner}.parent"), "object", name, &self.nodes).map(Some)
            }
        }
    }

    fn material(&mut self, field: &str, name: &str) -> Option<MaterialIndex> {
        self.problems.find(field, "material", name, &self.materials)
    }

    /// Mesh of that name, built on first use.
    fn mesh(&mut self, field: &str, name: &str) -> Option<MeshIndex> {
        let shape = self.problems.find(field, "mesh", name, &self.mesh_files)?;
        let (&name, _) = self.mesh_files.get_key_value(name)?;
        if let Some(&index) = self.meshes.get(name) {
            return Some(index);
        }
        let index = match shape.obj() {
            Some((path, materials)) => self.model_meshes(name, path, materials)?,
            None => {
                self.scene.meshes.push(shapes::built_in(name, shape)?);
                self.scene.meshes.len() - 1
            }
        };
        self.meshes.insert(name, index);
        Some(index)
    }

    fn remark_no_light(&mut self) {
        if self.scene.lights.is_empty() && self.scene.sky.is_none() && !darkness::emits(&self.scene, 0.0) {
            let place = self.problems.place("lights");
            let remedy = "add `lights: { \"sun\": Sun(to_sun: (0.4, 1.0, 0.6), irradiance_w_per_m2: (3.0, 3.0, 3.0)) }`";
            let remark = Diagnostic::warning(Loss::NoLight, place, "the scene has no light").remedy(remedy);
            self.scene.remarks.push(remark);
        }
    }

    fn finish(mut self) -> (Scene, Problems) {
        for name in self.file.meshes.names().filter(|name| !self.meshes.contains_key(name)) {
            let place = self.problems.place(&format!("meshes.{name}"));
            self.scene.remarks.push(Diagnostic::note(place, "nothing seen uses this mesh; skipped"));
        }
        self.scene.remarks.0.extend(self.outlines.remark(self.problems.place("meshes")));
        (self.scene, self.problems)
    }
}
