//! Wavefront OBJ and MTL files in, indexed triangles out. Invariant: every index is in range,
//! every number finite, there is at least one triangle, and no triangle is without area.

mod locate;
mod material;
mod triangulate;

use super::{Files, LoadError};
use crate::diagnostic::{Diagnostic, Diagnostics, Loss, Place};
use glam::{DVec3, Vec2, Vec3};
use locate::{Census, LineCounter};
use std::cell::RefCell;
use std::path::Path;

pub use material::ObjMaterial;

/// A polygon with more corners is refused: cutting it up would take too long.
const MAX_CORNERS: usize = 2048;

/// An OBJ file as one mesh.
#[derive(Clone, Debug, Default)]
pub struct ObjModel {
    /// Vertex positions.
    pub positions: Vec<Vec3>,
    /// One unit normal a vertex; empty if the file has none.
    pub normals: Vec<Vec3>,
    /// One texture coordinate a vertex; empty if the file has none. `v` points down.
    pub uvs: Vec<Vec2>,
    /// The triangles, counter-clockwise seen from the front.
    pub triangles: Vec<ObjTriangle>,
    /// Materials of the MTL files.
    pub materials: Vec<ObjMaterial>,
    /// What the files ask for and is not honoured.
    pub remarks: Diagnostics,
}

/// Three vertices and a material.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ObjTriangle {
    /// Indices into the model's vertices.
    pub vertices: [u32; 3],
    /// Index into the model's materials; `None` if the file names none that exists.
    pub material: Option<usize>,
}

/// Reads an OBJ file and the MTL files beside it.
///
/// # Errors
/// [`LoadError`] if a file cannot be read or does not hold a valid mesh.
pub fn load(path: &Path, referrer: &str, files: &mut Files) -> Result<ObjModel, LoadError> {
    let mut bytes = files.read(path, Some(referrer))?;
    let text = String::from_utf8_lossy(&bytes).into_owned();
    locate::comment_out_lines_and_points(&mut bytes);
    let files = RefCell::new(files);
    let material_problem = RefCell::new(None);
    let mut materials = RefCell::new(material::Library::default());
    let options = tobj::LoadOptions {
        single_index: true,
        ignore_points: true,
        ignore_lines: true,
        ..Default::default()
    };
    let mut lines = LineCounter::new(&bytes);
    let parsed = tobj::load_obj_buf(&mut lines, &options, |name| {
        let mtl_path = path.parent().map_or_else(|| name.to_owned(), |folder| folder.join(name));
        material::load(&mtl_path, &path.display().to_string(), *files.borrow_mut())
            .map(|(parsed, library)| {
                materials.borrow_mut().append(library);
                parsed
            })
            .map_err(|problem| {
                material_problem.borrow_mut().get_or_insert(problem);
                tobj::LoadError::MaterialParseError
            })
    });
    if let Some(problem) = material_problem.into_inner() {
        return Err(problem);
    }
    let models = match parsed {
        Ok((models, Ok(_))) => models,
        Ok((_, Err(error))) | Err(error) => return Err(parse_error(path, &text, error, lines.line()).into()),
    };
    let library = std::mem::take(materials.get_mut());
    let mut model =
        ObjModel { materials: library.materials, remarks: library.remarks, ..ObjModel::default() };
    remark_census(path, &text, &mut model);
    let mut parts = Vec::new();
    for tobj::Model { mesh, .. } in models {
        if mesh.positions.iter().chain(&mesh.normals).chain(&mesh.texcoords).any(|number| !number.is_finite())
        {
            let line = locate::not_finite(&text, &["v", "vt", "vn"]).unwrap_or(1);
            return Err(Diagnostic::error(at_line(path, line), "this is not a finite number")
                .expected("finite numbers within the range of 32 bits")
                .remedy("correct the line, or export the mesh again")
                .into());
        }
        parts.push(Part::new(path, &mesh, &mut model.remarks)?);
    }
    merge(parts, &mut model);
    if model.triangles.is_empty() {
        return Err(Diagnostic::error(Place::File(path.to_owned()), "the mesh has no triangles")
            .expected("at least one face (`f`) with three corners and an area")
            .remedy("export the mesh with its faces")
            .into());
    }
    Ok(model)
}

fn at_line(path: &Path, line: usize) -> Place {
    Place::Text { file: path.to_owned(), line, column: 1 }
}

fn parse_error(path: &Path, text: &str, error: tobj::LoadError, line: usize) -> Diagnostic {
    use tobj::LoadError as E;
    // tobj looks at indices when a group ends, so the line that it has reached says nothing.
    let (line, found) = match locate::face_out_of_range(text) {
        Some(located) => located,
        None if matches!(
            error,
            E::FaceVertexOutOfBounds | E::FaceNormalOutOfBounds | E::FaceTexCoordOutOfBounds
        ) =>
        {
            (line, String::from("a face refers to something that the file does not have"))
        }
        None => (line, format!("the line cannot be understood ({error})")),
    };
    Diagnostic::error(at_line(path, line), found)
        .expected("Wavefront OBJ: `v x y z`, `vt u v`, `vn x y z`, `f v/vt/vn ..` with indices from 1, or negative ones that count back")
        .remedy("correct the line, or export the mesh again")
}

fn remark_census(path: &Path, text: &str, model: &mut ObjModel) {
    let census = Census::of(text);
    for (keyword, (count, line)) in &census.ignored {
        let found = format!("`{keyword}` is not used ({count} in all)");
        model.remarks.push(match keyword.as_str() {
            "s" => Diagnostic::note(
                at_line(path, *line),
                format!("{found}; normals (`vn`) make surfaces smooth"),
            ),
            _ => Diagnostic::warning(Loss::ObjStatement, at_line(path, *line), found),
        });
    }
    if let Some((count, line)) = census.thin_faces {
        let found = format!("{count} faces have fewer than three corners; left out");
        model.remarks.push(Diagnostic::warning(Loss::ObjThinFace, at_line(path, line), found));
    }
    for name in census.material_names {
        if !model.materials.iter().any(|material| material.name == name) {
            let found =
                format!("no MTL file has the material `{name}`; the default material takes its place");
            model.remarks.push(Diagnostic::warning(
                Loss::ObjMaterialMissing,
                Place::File(path.to_owned()),
                found,
            ));
        }
    }
}

/// One group of the file: vertices of its own, one material.
struct Part {
    positions: Vec<Vec3>,
    normals: Vec<Vec3>,
    uvs: Vec<Vec2>,
    triangles: Vec<[u32; 3]>,
    material: Option<usize>,
}

impl Part {
    fn new(path: &Path, mesh: &tobj::Mesh, remarks: &mut Diagnostics) -> Result<Self, Diagnostic> {
        let file = || Place::File(path.to_owned());
        let positions: Vec<Vec3> = mesh.positions.chunks_exact(3).map(Vec3::from_slice).collect();
        let unit: Option<Vec<Vec3>> =
            mesh.normals.chunks_exact(3).map(|normal| Vec3::from_slice(normal).try_normalize()).collect();
        let mut normals = unit.unwrap_or_default();
        if normals.len() != positions.len() && !mesh.normals.is_empty() {
            normals.clear();
            remarks.push(Diagnostic::warning(
                Loss::ObjNormals,
                file(),
                "some corners have no normal; the group is shaded flat",
            ));
        }
        let mut uvs: Vec<Vec2> =
            mesh.texcoords.chunks_exact(2).map(|uv| Vec2::new(uv[0], 1.0 - uv[1])).collect();
        if uvs.len() != positions.len() && !uvs.is_empty() {
            uvs.clear();
            let found = "some corners have no texture coordinates; the group has none";
            remarks.push(Diagnostic::warning(Loss::ObjTextureCoordinates, file(), found));
        }
        if !mesh.vertex_color.is_empty() {
            remarks.push(Diagnostic::warning(
                Loss::ObjVertexColors,
                file(),
                "colours of vertices are not used",
            ));
        }
        let triangles = triangles(path, mesh, &positions, remarks)?;
        Ok(Self { positions, normals, uvs, triangles, material: mesh.material_id })
    }

    /// Gives every triangle corners of its own that carry the triangle's normal.
    fn shade_flat(&mut self) {
        let corners: Vec<u32> = self.triangles.iter().flatten().copied().collect();
        let positions: Vec<Vec3> = corners.iter().map(|&corner| self.positions[corner as usize]).collect();
        self.normals = positions
            .chunks_exact(3)
            .flat_map(|corner| {
                let corner = [corner[0], corner[1], corner[2]].map(|position| position.as_dvec3());
                [triangulate::newell_normal(&corner).normalize_or(DVec3::Y).as_vec3(); 3]
            })
            .collect();
        if !self.uvs.is_empty() {
            self.uvs = corners.iter().map(|&corner| self.uvs[corner as usize]).collect();
        }
        self.positions = positions;
        self.triangles =
            (0..corners.len() as u32 / 3).map(|index| [3 * index, 3 * index + 1, 3 * index + 2]).collect();
    }
}

fn triangles(
    path: &Path,
    mesh: &tobj::Mesh,
    positions: &[Vec3],
    remarks: &mut Diagnostics,
) -> Result<Vec<[u32; 3]>, Diagnostic> {
    let file = || Place::File(path.to_owned());
    let (mut triangles, mut without_area, mut crossing) = (Vec::new(), 0, 0);
    let all_triangles = vec![3; if mesh.face_arities.is_empty() { mesh.indices.len() / 3 } else { 0 }];
    let mut rest = mesh.indices.as_slice();
    for &arity in mesh.face_arities.iter().chain(&all_triangles) {
        let (polygon, after) = rest.split_at((arity as usize).min(rest.len()));
        rest = after;
        if polygon.len() > MAX_CORNERS {
            return Err(Diagnostic::error(file(), format!("a face has {} corners", polygon.len()))
                .expected(format!("faces of at most {MAX_CORNERS} corners"))
                .remedy("triangulate the mesh when exporting it"));
        }
        let corners: Vec<DVec3> = polygon.iter().map(|&index| positions[index as usize].as_dvec3()).collect();
        let Some(cut) = triangulate::triangulate(&corners) else {
            without_area += 1;
            continue;
        };
        crossing += usize::from(!cut.simple);
        let has_area = |triangle: &[usize; 3]| {
            triangulate::newell_normal(&triangle.map(|corner| corners[corner])).try_normalize().is_some()
        };
        triangles
            .extend(cut.triangles.iter().filter(|t| has_area(t)).map(|t| t.map(|corner| polygon[corner])));
    }
    if without_area > 0 {
        let found = format!("{without_area} faces have no area; left out");
        remarks.push(Diagnostic::note(file(), found));
    }
    if crossing > 0 {
        let found =
            format!("{crossing} faces have outlines that cross themselves; their triangles may overlap");
        remarks.push(Diagnostic::warning(Loss::ObjCrossingFace, file(), found));
    }
    Ok(triangles)
}

/// Joins the groups; if any has normals or texture coordinates, all get them.
fn merge(mut parts: Vec<Part>, model: &mut ObjModel) {
    parts.retain(|part| !part.triangles.is_empty());
    let with_normals = parts.iter().any(|part| !part.normals.is_empty());
    let with_uvs = parts.iter().any(|part| !part.uvs.is_empty());
    for mut part in parts {
        if with_normals && part.normals.is_empty() {
            part.shade_flat();
        }
        if with_uvs && part.uvs.is_empty() {
            part.uvs = vec![Vec2::ZERO; part.positions.len()];
        }
        let base = model.positions.len() as u32;
        model.positions.append(&mut part.positions);
        model.normals.append(&mut part.normals);
        model.uvs.append(&mut part.uvs);
        model.triangles.extend(part.triangles.iter().map(|triangle| ObjTriangle {
            vertices: triangle.map(|vertex| base + vertex),
            material: part.material,
        }));
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

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
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/valid/obj/all_forms.obj");
        let model = load(&path, "test", &mut Files::default()).unwrap();
        // A square, two halves, a third half by negative indices, and the arrow.
        assert!((area(&model) - (1.0 + 0.5 + 0.5 + 0.5 + 1.5)).abs() < 1e-6);
        assert_eq!(model.normals.len(), model.positions.len());
        assert_eq!(model.uvs.len(), model.positions.len());
        let materials: Vec<_> = model.triangles.iter().map(|triangle| triangle.material).collect();
        assert_eq!(materials, [Some(0), Some(0), Some(0), Some(0), Some(1), None, None]);
        assert_eq!(model.materials[0].emission, DVec3::Z);
        assert_eq!(model.materials[1].diffuse_texture.as_deref(), Some(Path::new("checker.ppm")));
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
        let model = load_text(&format!("{SQUARE}f 1 2 3 4\nf 1 2 1\n").replace('\n', "\r\n"));
        assert_eq!(model.triangles.len(), 2);
    }
}
