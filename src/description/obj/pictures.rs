//! Images of MTL files. In go paths, out come the images that materials use. Invariant: an image is made
//! once, and a missing or damaged one is reported and replaced by a colour.

use super::ObjModel;
use super::material::ObjMaterial;
use super::tally::Tally;
use super::texture::ObjTexture;
use crate::description::Files;
use crate::description::image::{self, DecodedImage, Encoding};
use crate::diagnostic::{Loss, Place};
use std::collections::btree_map::Entry;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// Replacement of a missing texture: the default material's colour.
const STAND_IN: f32 = 0.8;

/// Key of an image: its sources.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct ObjPicture {
    texels: Texels,
    /// Whether it is clamped at its edges, or repeats.
    pub is_clamped: bool,
}

#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Texels {
    /// Colours, and alpha from another image.
    Color(Option<PathBuf>, Option<PathBuf>),
    /// Emitted colours.
    Emission(PathBuf),
    /// Metallic-roughness texture of glTF: blue is metallic, green is roughness.
    MetallicRoughness(Option<PathBuf>, Option<PathBuf>),
    /// Normal map; whether it may be a height map.
    Normals(PathBuf, bool),
}

/// Images made so far; `None` if one cannot be made.
pub type ObjPictures = BTreeMap<ObjPicture, Option<DecodedImage>>;

impl ObjPicture {
    fn new(texels: Texels, textures: [&Option<ObjTexture>; 2]) -> Self {
        Self {
            texels,
            is_clamped: textures.into_iter().flatten().next().is_some_and(|texture| texture.is_clamped),
        }
    }

    /// Name of the first file.
    pub fn name(&self) -> String {
        let path = match &self.texels {
            Texels::Color(first, second) | Texels::MetallicRoughness(first, second) => {
                first.as_ref().or(second.as_ref())
            }
            Texels::Normals(path, _) | Texels::Emission(path) => Some(path),
        };
        path.map(|path| path.display().to_string()).unwrap_or_default()
    }
}

fn path(texture: &Option<ObjTexture>) -> Option<PathBuf> {
    texture.as_ref().map(|texture| texture.path.clone())
}

impl ObjMaterial {
    /// Diffuse colours with opacity as alpha.
    pub fn color_picture(&self) -> Option<ObjPicture> {
        let textures = [&self.diffuse_texture, &self.opacity_texture];
        let [color, alpha] = textures.map(path);
        let is_there = color.is_some() || alpha.is_some();
        is_there.then(|| ObjPicture::new(Texels::Color(color, alpha), textures))
    }

    /// Emitted colours.
    pub fn emission_picture(&self) -> Option<ObjPicture> {
        let image = path(&self.emission_texture)?;
        Some(ObjPicture::new(Texels::Emission(image), [&self.emission_texture, &None]))
    }

    /// Metallic factor and roughness in glTF's channels.
    pub fn coat_picture(&self) -> Option<ObjPicture> {
        let coat = self.coat.as_ref()?;
        let textures = [&coat.metallic_texture, &coat.roughness_texture];
        let [metallic, roughness] = textures.map(path);
        let is_there = metallic.is_some() || roughness.is_some();
        is_there.then(|| ObjPicture::new(Texels::MetallicRoughness(metallic, roughness), textures))
    }

    /// Normal map.
    pub fn normal_picture(&self) -> Option<ObjPicture> {
        let image = path(&self.normal_map)?;
        Some(ObjPicture::new(Texels::Normals(image, self.normal_map_is_sure), [&self.normal_map, &None]))
    }
}

/// Makes the images of materials that triangles use, unless the scene replaces the material.
pub(in crate::inside::description) fn load(
    model: &mut ObjModel,
    is_replaced: &dyn Fn(&str) -> bool,
    files: &mut Files,
    pictures: &mut ObjPictures,
) {
    for later in &mut model.later {
        load(later, is_replaced, files, pictures);
        model.remarks.0.append(&mut later.remarks.0);
    }
    let mut maker = Maker { files, tally: Tally::default() };
    let used: BTreeSet<usize> = model.triangles.iter().filter_map(|triangle| triangle.material).collect();
    let materials = used.into_iter().map(|material| &model.materials[material]);
    for material in materials.filter(|material| !is_replaced(&material.name)) {
        let asked = [
            material.color_picture(),
            material.emission_picture(),
            material.coat_picture(),
            material.normal_picture(),
        ];
        for picture in asked.into_iter().flatten() {
            if let Entry::Vacant(missing) = pictures.entry(picture) {
                let made = maker.made(&missing.key().texels);
                missing.insert(made);
            }
        }
    }
    model.remarks.0.extend(maker.tally.into_remarks().0);
}

struct Maker<'a> {
    files: &'a mut Files,
    tally: Tally,
}

impl Maker<'_> {
    fn made(&mut self, texels: &Texels) -> Option<DecodedImage> {
        match texels {
            Texels::Color(color, alpha) => {
                let color = color.as_ref().map(|path| {
                    self.image(path, Encoding::Srgb)
                        .unwrap_or_else(|| plain([STAND_IN, STAND_IN, STAND_IN, 1.0]))
                });
                let alpha = alpha.as_ref().and_then(|path| self.image(path, Encoding::Linear));
                with_alpha(color, alpha)
            }
            // Missing emission is black, and not grey.
            Texels::Emission(path) => self.image(path, Encoding::Srgb),
            Texels::MetallicRoughness(metallic, roughness) => {
                let [metallic, roughness] =
                    [metallic, roughness].map(|path| self.image(path.as_ref()?, Encoding::Linear));
                packed(metallic, roughness)
            }
            Texels::Normals(path, is_sure) => {
                let image = self.image(path, Encoding::Linear)?;
                if !is_sure && is_grey(&image) {
                    self.tally.add(Loss::MtlBumpMap, &path.display().to_string(), Place::File(path.clone()));
                    return None;
                }
                Some(image)
            }
        }
    }

    fn image(&mut self, path: &Path, encoding: Encoding) -> Option<DecodedImage> {
        let bytes = self.files.read_if_there(path);
        let place = Place::File(path.to_owned());
        let image = bytes.and_then(|bytes| image::decode(&bytes, encoding, place.clone()).ok());
        if image.is_none() {
            let name = path.file_name().map(|name| name.to_string_lossy().into_owned());
            self.tally.add(Loss::MtlTexture, &name.unwrap_or_default(), place);
        }
        image
    }
}

fn plain(texel: [f32; 4]) -> DecodedImage {
    DecodedImage::new(1, 1, vec![texel].into())
}

/// Colours with the alpha channel of another image, or its luminance if it is opaque.
fn with_alpha(color: Option<DecodedImage>, alpha: Option<DecodedImage>) -> Option<DecodedImage> {
    let Some(alpha) = alpha else {
        // The alpha of a colour texture counts only with `map_d`.
        return color.map(|color| DecodedImage {
            texels: color.texels.into_iter().map(|[r, g, b, _]| [r, g, b, 1.0]).collect(),
            ..color
        });
    };
    let color = color.unwrap_or_else(|| plain([1.0; 4]));
    let has_alpha = alpha.texels.iter().any(|texel| texel[3] < 1.0);
    let opacity = |[r, g, b, a]: [f32; 4]| if has_alpha { a } else { (r + g + b) / 3.0 };
    Some(joined(&color, &alpha, |[r, g, b, _], alpha| [r, g, b, opacity(alpha)]))
}

/// Packs grey images as in glTF, with 1 for a missing one.
fn packed(metallic: Option<DecodedImage>, roughness: Option<DecodedImage>) -> Option<DecodedImage> {
    if metallic.is_none() && roughness.is_none() {
        return None;
    }
    let [metallic, roughness] = [metallic, roughness].map(|image| image.unwrap_or_else(|| plain([1.0; 4])));
    Some(joined(&metallic, &roughness, |metallic, roughness| [1.0, roughness[0], metallic[0], 1.0]))
}

/// Joins two images, at the larger one's size.
fn joined(
    first: &DecodedImage,
    second: &DecodedImage,
    texel: impl Fn([f32; 4], [f32; 4]) -> [f32; 4],
) -> DecodedImage {
    let larger = if first.texels.len() >= second.texels.len() { first } else { second };
    let (width, height) = (larger.width, larger.height);
    let nearest = |image: &DecodedImage, column: usize, row: usize| {
        image.texels.get(row * image.height / height * image.width + column * image.width / width)
    };
    let texels = (0..width * height).map(|index| {
        let (column, row) = (index % width, index / width);
        texel(nearest(first, column, row), nearest(second, column, row))
    });
    DecodedImage::new(width, height, texels.collect())
}

/// Whether an image is grey, as height maps are; normal maps are blue.
fn is_grey(image: &DecodedImage) -> bool {
    let colorful = image.texels.iter().filter(|[r, g, b, _]| (r - g).abs().max((g - b).abs()) > 0.1);
    colorful.count() * 20 < image.texels.len()
}
