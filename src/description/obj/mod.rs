//! Reader of Wavefront OBJ and MTL. In go files, out come indexed triangles. Invariant: every index is in
//! range, every number is finite, and every triangle has an area.
//!
//! Faulty statements are dropped and reported, so that the rest is rendered; tobj gets the text without them.

mod library;
mod material;
mod normalize;
mod part;
mod pictures;
mod sequence;
mod tally;
mod text;
mod texture;
mod triangles;
mod triangulate;

use super::numbered::Numbered;
use super::{Files, LoadError};
use crate::diagnostic::{Diagnostic, Diagnostics, Loss, Place, shown};
use glam::{Vec2, Vec3};
use library::Library;
use normalize::{Groups, Vertices};
use part::Part;
use std::mem;
use std::path::Path;
use tally::Tally;

pub use material::{ObjCoat, ObjMaterial};
pub(super) use pictures::load as load_pictures;
pub use pictures::{ObjPicture, ObjPictures};
pub use sequence::{Shape, Shapes};
pub use texture::{ObjTexture, Placement};
pub use triangles::Triangles;

/// OBJ file as one mesh.
#[derive(Clone, Debug, Default)]
pub struct ObjModel {
    /// Vertex positions.
    pub positions: Vec<Vec3>,
    /// One unit normal a vertex; empty if the file has none.
    pub normals: Vec<Vec3>,
    /// One texture coordinate a vertex; empty if the file has none. `v` points down.
    pub uvs: Vec<Vec2>,
    /// One linear colour a vertex; empty if the file has none.
    pub colors: Vec<Vec3>,
    /// The triangles, counter-clockwise seen from the front.
    pub triangles: Vec<ObjTriangle>,
    /// Materials of the MTL files.
    pub materials: Vec<ObjMaterial>,
    /// Shapes of later frames, in a sequence of files.
    pub shapes: Shapes,
    /// Models that replace this one at later frames, in a sequence whose faces change.
    pub later: Vec<ObjModel>,
    /// Requests of the files that are not honoured.
    pub remarks: Diagnostics,
}

/// Three vertices and a material.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ObjTriangle {
    /// Indices into the model's vertices.
    pub vertices: [u32; 3],
    /// Index into the model's materials; `None` if the file names no existing one.
    pub material: Option<usize>,
}

/// Reads an OBJ file and the MTL files that it names; all files of a sequence, if the path has a placeholder
/// and is not a file.
///
/// # Errors
/// [`LoadError`] if the file cannot be read, or holds no triangle; of a sequence also if a number is missing.
pub fn load(path: &Path, referrer: &str, files: &mut Files) -> Result<ObjModel, LoadError> {
    if let Some(numbered) = Numbered::of(path) {
        return sequence::read(&numbered, referrer, files);
    }
    let model = read(path, Some(referrer), files)?;
    if model.triangles.is_empty() { Err(nothing_left(path, &model.remarks).into()) } else { Ok(model) }
}

/// Loads a file that is the whole input. It may have no triangle, only points and lines.
pub fn load_alone(path: &Path, files: &mut Files) -> Result<ObjModel, LoadError> {
    match Numbered::of(path) {
        Some(numbered) => sequence::read(&numbered, "the command line", files),
        None => {
            let mut model = read(path, None, files)?;
            if let Some(sequence) = Numbered::around(path) {
                let found = format!(
                    "this file alone is drawn, in every frame: `{}` is all that are numbered so",
                    shown(&sequence)
                );
                model.remarks.push(Diagnostic::choice(Place::File(path.to_owned()), found));
            }
            Ok(model)
        }
    }
}

/// Name of the mesh of a path: the file's, or the common one of its sequence.
pub fn name(path: &Path) -> String {
    match Numbered::of(path) {
        Some(numbered) if !numbered.name().is_empty() => numbered.name().to_owned(),
        _ => path.file_stem().unwrap_or_default().to_string_lossy().into_owned(),
    }
}

fn read(path: &Path, referrer: Option<&str>, files: &mut Files) -> Result<ObjModel, LoadError> {
    let mut tally = Tally::default();
    let Opened { mut model, parts, .. } = open(path, referrer, files, &mut tally)?;
    part::merge(parts, &mut model);
    model.remarks.0.extend(tally.into_remarks().0);
    Ok(model)
}

/// File with triangulated faces, not yet joined to one mesh.
struct Opened {
    model: ObjModel,
    common: Common,
    parts: Vec<Part>,
}

/// Common part of a sequence's files: names of materials, and faces.
struct Common {
    library: Library,
    groups: Groups,
}

fn open(
    path: &Path,
    referrer: Option<&str>,
    files: &mut Files,
    tally: &mut Tally,
) -> Result<Opened, LoadError> {
    let text = text::decoded(files.read(path, referrer)?);
    let vertices = Vertices::of(&text, path, tally);
    let mut library = Library::of(&text, path, files, tally);
    let groups = normalize::faces(&text, path, &vertices, |name| library.find(name), tally);
    drop(text);
    let mut model = ObjModel { materials: mem::take(&mut library.materials), ..ObjModel::default() };
    let (mut parts, mut without_area) = (Vec::new(), 0);
    for (tobj::Model { mesh, .. }, group) in indexed(path, vertices, &groups)?.into_iter().zip(groups.keys())
    {
        let material = model.materials.get(group.material);
        if let Some(material) = material.filter(|material| material.has_textures() && !group.has_uvs) {
            tally.add(Loss::TextureCoordinatesMissing, &material.name, Place::File(path.to_owned()));
        }
        let mut part = Part::new(&mesh, *group, material);
        without_area += part.cut(&mesh, path, tally);
        parts.push(part);
    }
    if without_area > 0 {
        let found = format!("{without_area} faces have no area; left out");
        model.remarks.push(Diagnostic::note(Place::File(path.to_owned()), found));
    }
    Ok(Opened { model, common: Common { library, groups }, parts })
}

/// Indexes one mesh a group, in the groups' order.
fn indexed(path: &Path, vertices: Vertices, groups: &Groups) -> Result<Vec<tobj::Model>, Diagnostic> {
    let mut text = vertices.text;
    for faces in groups.values() {
        text.push_str("g\n");
        text.push_str(faces);
    }
    let options = tobj::LoadOptions { single_index: true, ..Default::default() };
    let no_materials = |_: &Path| Err(tobj::LoadError::MaterialParseError);
    let (models, _) = tobj::load_obj_buf(&mut text.as_bytes(), &options, no_materials).map_err(|error| {
        Diagnostic::error(Place::File(path.to_owned()), format!("the mesh cannot be understood ({error})"))
            .expected(EXPECTED)
            .remedy(REMEDY)
    })?;
    Ok(models)
}

const EXPECTED: &str = "Wavefront OBJ: `v x y z`, `vt u v`, `vn x y z`, and at least one face (`f v/vt/vn ..`) with three corners and an area";
const REMEDY: &str = "correct the file, or export the mesh again with its faces";

/// Error of a file without triangles. It lists dropped statements first, as they may be the cause.
fn nothing_left(path: &Path, remarks: &Diagnostics) -> Diagnostic {
    let is_of_geometry = |loss: Loss| {
        matches!(
            loss,
            Loss::ObjNumbers
                | Loss::ObjFaceIndex
                | Loss::ObjFaceVertex
                | Loss::ObjFaceCorners
                | Loss::ObjThinFace
        )
    };
    let (place, found) = match remarks.losses().find(|(loss, _)| is_of_geometry(*loss)) {
        Some((_, loss)) => {
            (loss.place.clone(), format!("the mesh has no triangles that can be used: {}", loss.found))
        }
        None => (Place::File(path.to_owned()), String::from("the mesh has no triangles with an area")),
    };
    Diagnostic::error(place, found).expected(EXPECTED).remedy(REMEDY)
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use glam::DVec3;

    fn load_text(obj: &str) -> ObjModel {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("mesh.obj");
        std::fs::write(&path, obj).unwrap();
        load(&path, "test", &mut Files::default()).unwrap()
    }

    fn area(model: &ObjModel) -> f64 {
        let corner = |index: u32| model.positions[index as usize].as_dvec3();
        let twice = |t: &ObjTriangle| triangulate::newell_normal(&t.vertices.map(corner)).length();
        model.triangles.iter().map(twice).sum::<f64>() / 2.0
    }

    const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

    #[test]
    fn all_forms_of_a_face_are_read() {
        let path = crate::checkout::file("tests/data/valid/obj/all_forms.obj");
        let model = load(&path, "test", &mut Files::default()).unwrap();
        // A square, two halves, a third half by negative indices, and the arrow.
        assert!((area(&model) - (1.0 + 0.5 + 0.5 + 0.5 + 1.5)).abs() < 1e-6);
        assert_eq!(model.normals.len(), model.positions.len());
        assert_eq!(model.uvs.len(), model.positions.len());
        let materials: Vec<_> = model.triangles.iter().map(|triangle| triangle.material).collect();
        assert_eq!(materials, [Some(0), Some(0), Some(0), Some(0), Some(1), None, None]);
        assert_eq!(model.materials[0].emission, DVec3::Z);
        let texture = model.materials[1].diffuse_texture.as_ref().unwrap();
        assert!(texture.path.ends_with("tests/data/valid/obj/checker.ppm"));
    }

    #[test]
    fn negative_indices_count_back_from_where_they_stand() {
        let model = load_text(&format!("{SQUARE}f -4 -3 -2 -1\nv 9 9 9\n"));
        assert!((area(&model) - 1.0).abs() < 1e-6);
    }

    #[test]
    fn texture_coordinates_point_down() {
        let model = load_text(&format!("{SQUARE}vt 0.25 0.75\nf 1/1 2/1 3/1\n"));
        assert_eq!(model.uvs, [Vec2::new(0.25, 0.25); 3]);
    }

    #[test]
    fn lines_of_three_points_are_no_face() {
        let model = load_text(&format!("{SQUARE}l 1 2 3\nf 1 2 3\n"));
        assert_eq!(model.triangles.len(), 1);
        assert_eq!(model.remarks.0.len(), 1);
    }

    #[test]
    fn line_ends_of_windows_and_faces_without_area_do_no_harm() {
        let flat = "usemtl a\nf 1 2 1\nusemtl b\nf 2 3 2\n";
        let model = load_text(&format!("{SQUARE}f 1 2 3 4\n{flat}").replace('\n', "\r\n"));
        assert_eq!(model.triangles.len(), 2);
        let notes: Vec<_> =
            model.remarks.0.iter().filter(|remark| remark.found.contains("no area")).collect();
        assert_eq!(notes.len(), 1);
        assert!(notes[0].found.starts_with("2 faces"));
    }
}
