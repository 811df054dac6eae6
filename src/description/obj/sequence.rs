//! OBJ files of a sequence, one a frame. In go files, out comes the first one's model with the shapes of
//! later files with equal faces, and another model where faces change. Invariant: every shape has a position,
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

/// Shapes of a mesh, frame by frame.
#[derive(Clone, Debug, Default)]
pub struct Shapes {
    /// Frame of the model itself.
    pub first_frame: i64,
    /// Shapes of the following frames.
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
    /// Range of frames; `None` for a mesh with one shape.
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

/// Consecutive files with equal faces.
struct Run {
    model: ObjModel,
    common: Common,
    /// Triangulation of each group's faces.
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

    /// Shape of the next file, triangulated like the first one; `None` if more than positions and normals
    /// differ.
    fn shape(&mut self, run: &Run, path: &Path) -> Result<Option<Shape>, LoadError> {
        let Run { model: first, common, triangles } = run;
        let text = text::decoded(self.files.read(path, Some(self.referrer))?);
        // Not reported: these losses are those of the run's first file, or the file begins a run of its own.
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
