//! OBJ files of a sequence, one a frame. In go files, out comes the first one's model with the shapes of
//! those that have its faces, and a model more wherever others come. Invariant: every shape has a position,
//! and a normal if there are any, for every vertex of its model.

use super::library::Library;
use super::normalize::{self, Vertices};
use super::part::{self, Part};
use super::tally::Tally;
use super::{Common, Files, LoadError, ObjModel, Opened, indexed, nothing_left, open, text};
use crate::description::numbered::Numbered;
use glam::Vec3;
use std::ops::RangeInclusive;
use std::path::Path;

/// The shapes of a mesh from frame to frame.
#[derive(Clone, Debug, Default)]
pub struct Shapes {
    /// The frame of the model itself.
    pub first_frame: i64,
    /// Shapes of the frames that follow, one each.
    pub after: Vec<Shape>,
}

/// Vertices of a model in one frame.
#[derive(Clone, Debug)]
pub struct Shape {
    /// One a vertex.
    pub positions: Vec<Vec3>,
    /// One unit normal a vertex; empty if the model has none.
    pub normals: Vec<Vec3>,
}

impl ObjModel {
    /// The frames that there are; none of a mesh that keeps its shape.
    pub fn frames(&self) -> Option<RangeInclusive<i64>> {
        let Shapes { first_frame, after } = &self.later.last().unwrap_or(self).shapes;
        let last = first_frame.checked_add(after.len() as i64)?;
        (last > self.shapes.first_frame).then_some(self.shapes.first_frame..=last)
    }
}

pub(super) fn read(
    numbered: &Numbered<'_>,
    referrer: &str,
    files: &mut Files,
) -> Result<ObjModel, LoadError> {
    let numbers = numbered.numbers(referrer)?;
    let first_path = numbered.file(*numbers.start());
    let mut reader = Reader { referrer, files, tally: Tally::default() };
    let mut runs = vec![reader.begin(*numbers.start(), &first_path)?];
    for number in numbers.skip(1) {
        let path = numbered.file(number);
        let shape = match runs.last() {
            Some(run) => reader.shape(run, &path)?,
            None => None,
        };
        match (shape, runs.last_mut()) {
            (Some(shape), Some(run)) => run.model.shapes.after.push(shape),
            _ => runs.push(reader.begin(number, &path)?),
        }
    }
    let mut models: Vec<ObjModel> = runs.into_iter().map(|run| run.model).collect();
    let remarks = reader.tally.into_remarks().0;
    let remarks = models.iter_mut().flat_map(|model| model.remarks.0.drain(..)).chain(remarks).collect();
    let mut models = models.into_iter();
    let mut model = models.next().unwrap_or_default();
    (model.remarks.0, model.later) = (remarks, models.collect());
    if model.triangles.is_empty() && model.later.iter().all(|later| later.triangles.is_empty()) {
        return Err(nothing_left(&first_path, &model.remarks).into());
    }
    Ok(model)
}

/// Files in a row that have the same faces.
struct Run {
    model: ObjModel,
    common: Common,
    /// Triangles that the faces of each group were cut into.
    triangles: Vec<Vec<[u32; 3]>>,
}

struct Reader<'a> {
    referrer: &'a str,
    files: &'a mut Files,
    tally: Tally,
}

impl Reader<'_> {
    fn begin(&mut self, first_frame: i64, path: &Path) -> Result<Run, LoadError> {
        let Opened { mut model, common, parts } =
            open(path, Some(self.referrer), self.files, &mut self.tally)?;
        let triangles = parts.iter().map(|part| part.triangles.clone()).collect();
        part::merge(parts, &mut model);
        model.shapes.first_frame = first_frame;
        Ok(Run { model, common, triangles })
    }

    /// The shape of the next file, of faces that are cut as the first one's; `None` if the file differs in
    /// more than shape.
    fn shape(&mut self, run: &Run, path: &Path) -> Result<Option<Shape>, LoadError> {
        let Run { model: first, common, triangles } = run;
        let text = text::decoded(self.files.read(path, Some(self.referrer))?);
        // What is lost of a file is told when it begins a run, or was of the one that did.
        let mut unsaid = Tally::default();
        let vertices = Vertices::of(&text, path, &mut unsaid);
        let materials = Library::of(&text, path, self.files, &mut unsaid).materials;
        let find = |name: &str| common.library.find(name);
        let groups = normalize::faces(&text, path, &vertices, find, &mut unsaid);
        drop(text);
        if groups != common.groups || materials != first.materials {
            return Ok(None);
        }
        let mut model = ObjModel::default();
        let meshes = indexed(path, vertices, &groups)?;
        let parts = meshes.iter().zip(groups.keys()).zip(triangles).map(|((mesh, group), triangles)| {
            let mut part = Part::new(&mesh.mesh, *group, first.materials.get(group.material));
            part.triangles.clone_from(triangles);
            part
        });
        part::merge(parts.collect(), &mut model);
        let is_like_it = model.positions.len() == first.positions.len()
            && model.normals.len() == first.normals.len()
            && model.uvs == first.uvs
            && model.colors == first.colors;
        Ok(is_like_it.then_some(Shape { positions: model.positions, normals: model.normals }))
    }
}
