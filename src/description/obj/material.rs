//! MTL files in, diffuse materials out. Invariant: `diffuse` is in `0..=1`, `emission` is finite
//! and not negative; everything else that the file asks for is a remark.

use super::{LineCounter, at_line, locate};
use crate::color::Rgb;
use crate::description::{Files, LoadError};
use crate::diagnostic::{Diagnostic, Diagnostics, Loss, Place};
use std::path::{Path, PathBuf};

/// A material of an MTL file.
#[derive(Clone, Debug, PartialEq)]
pub struct ObjMaterial {
    /// Its name.
    pub name: String,
    /// `Kd`, linear; 0.8 if there is none, white under a texture.
    pub diffuse: Rgb,
    /// `map_Kd`, relative to the OBJ file.
    pub diffuse_texture: Option<PathBuf>,
    /// `Ke`.
    pub emission: Rgb,
}

/// Materials of one or more MTL files.
#[derive(Default)]
pub(super) struct Library {
    pub(super) materials: Vec<ObjMaterial>,
    pub(super) remarks: Diagnostics,
}

impl Library {
    pub(super) fn append(&mut self, mut other: Self) {
        self.materials.append(&mut other.materials);
        self.remarks.0.append(&mut other.remarks.0);
    }
}

/// What tobj makes of an MTL file.
type Parsed = (Vec<tobj::Material>, std::collections::HashMap<String, usize>);

/// Reads an MTL file: for tobj as it stands, for us checked.
pub(super) fn load(path: &Path, referrer: &str, files: &mut Files) -> Result<(Parsed, Library), LoadError> {
    let bytes = files.read(path, Some(referrer))?;
    let text = String::from_utf8_lossy(&bytes);
    // tobj panics at a colour with fewer than three numbers.
    let is_color = |keyword: &str| ["Ka", "Kd", "Ks", "Ke"].contains(&keyword);
    let mut colors = locate::statements(&text).filter(|(_, keyword, _)| is_color(keyword));
    if let Some((line, keyword, _)) = colors.find(|(_, _, numbers)| numbers.clone().count() < 3) {
        let found = format!("`{keyword}` has fewer than three numbers");
        return Err(Diagnostic::error(at_line(path, line), found)
            .expected("red, green and blue, such as `Kd 0.5 0.4 0.2`")
            .remedy("correct the line, or export the materials again")
            .into());
    }
    let mut lines = LineCounter::new(&bytes);
    let parsed = tobj::load_mtl_buf(&mut lines).map_err(|error| {
        Diagnostic::error(at_line(path, lines.line()), format!("the line cannot be understood ({error})"))
            .expected("a material library (MTL): `newmtl name`, `Kd r g b`, `map_Kd file`, `Ke r g b`")
            .remedy("correct the line, or export the materials again")
    })?;
    let mut library = Library::default();
    for material in &parsed.0 {
        library.materials.push(checked(path, &text, material)?);
        remark(path, material, &mut library.remarks);
    }
    Ok((parsed, library))
}

fn checked(path: &Path, text: &str, material: &tobj::Material) -> Result<ObjMaterial, Diagnostic> {
    let color = |value: [f32; 3]| Rgb::from_array(value.map(f64::from));
    let diffuse_texture =
        material.diffuse_texture.as_deref().map(|texture| PathBuf::from(file_name(texture)));
    let diffuse = match material.diffuse {
        Some(diffuse) => color(diffuse),
        None => Rgb::splat(if diffuse_texture.is_some() { 1.0 } else { 0.8 }),
    };
    let emission = color(material.emissive.unwrap_or_default());
    if !diffuse.to_array().iter().all(|reflectance| (0.0..=1.0).contains(reflectance)) {
        return Err(refuse(path, text, &material.name, "Kd", diffuse, "reflectances from 0 to 1"));
    }
    if !emission.to_array().iter().all(|radiance| radiance.is_finite() && *radiance >= 0.0) {
        return Err(refuse(path, text, &material.name, "Ke", emission, "finite radiances, 0 or more"));
    }
    Ok(ObjMaterial { name: material.name.clone(), diffuse, diffuse_texture, emission })
}

fn refuse(path: &Path, text: &str, name: &str, keyword: &str, value: Rgb, expected: &str) -> Diagnostic {
    let mut inside = false;
    let line = locate::statements(text).find_map(|(line, word, mut words)| {
        if word == "newmtl" {
            inside = words.next().is_some_and(|first| name.starts_with(first));
        }
        (inside && word == keyword).then_some(line)
    });
    let Rgb { x, y, z } = value;
    Diagnostic::error(at_line(path, line.unwrap_or(1)), format!("`{keyword}` of `{name}` is ({x}, {y}, {z})"))
        .expected(expected)
        .remedy("correct the line, or export the materials again")
}

/// A texture's file name without the options that may stand before it.
fn file_name(texture: &str) -> &str {
    if texture.starts_with('-') { texture.split_whitespace().last().unwrap_or(texture) } else { texture }
}

fn remark(path: &Path, material: &tobj::Material, remarks: &mut Diagnostics) {
    let textures = [
        (&material.ambient_texture, "map_Ka"),
        (&material.specular_texture, "map_Ks"),
        (&material.normal_texture, "map_Bump"),
        (&material.shininess_texture, "map_Ns"),
        (&material.dissolve_texture, "map_d"),
    ];
    let mut not_used: Vec<&str> =
        textures.iter().filter(|(texture, _)| texture.is_some()).map(|(_, keyword)| *keyword).collect();
    if material.dissolve.is_some_and(|dissolve| dissolve < 1.0) {
        not_used.push("d");
    }
    if material.specular.is_some_and(|specular| specular != [0.0; 3]) {
        not_used.push("Ks");
    }
    if material.diffuse_texture.as_deref().is_some_and(|texture| texture.starts_with('-')) {
        not_used.push("options of map_Kd");
    }
    // tobj reads `Ke`, so what is left here is what neither of us knows.
    let mut unknown: Vec<&str> = material.unknown_param.keys().map(String::as_str).collect();
    unknown.sort_unstable();
    not_used.extend(unknown);
    if !not_used.is_empty() {
        let found = format!("material `{}`: {} not used", material.name, not_used.join(", "));
        remarks.push(Diagnostic::warning(Loss::MtlStatement, Place::File(path.to_owned()), found));
    }
}
