//! How large a scene may be. In goes a resolved scene, out come errors with places. Invariant: in a scene that passes,
//! products of three lengths stay finite in single precision wherever a tree or a triangle forms them.

use super::Scene;
use crate::diagnostic::{Diagnostic, Diagnostics, Place};
use std::path::Path;

/// As far from a mesh's origin as a vertex may be, metres: a tenth of a light year.
const FARTHEST_VERTEX_M: f32 = 1e15;

/// Refuses meshes that reach too far.
pub(super) fn check(scene: &Scene, file: &Path) -> Result<(), Diagnostics> {
    let errors: Vec<Diagnostic> =
        scene
            .meshes
            .iter()
            .filter_map(|mesh| {
                let is_far = |position: &&glam::Vec3| position.abs().max_element() > FARTHEST_VERTEX_M;
                let (index, position) =
                    mesh.positions.iter().enumerate().find(|(_, position)| is_far(position))?;
                let place = Place::Field { file: file.to_owned(), path: format!("mesh `{}`", mesh.name) };
                let found =
                    format!("vertex {index} is {:e} m away from the origin", position.abs().max_element());
                let error = Diagnostic::error(place, found);
                Some(error.expected(format!("coordinates of at most {FARTHEST_VERTEX_M:e} m")).remedy(
                    "correct the vertex; one flipped bit of a file can send it there, so export again",
                ))
            })
            .collect();
    if errors.is_empty() { Ok(()) } else { Err(Diagnostics(errors)) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Mesh;
    use glam::Vec3;

    fn scene_with(farthest: f32) -> Scene {
        let positions = vec![Vec3::ZERO, Vec3::new(0.0, -farthest, 0.0)];
        let mesh = Mesh { name: String::from("leaf"), positions, ..Mesh::default() };
        Scene { meshes: vec![mesh], ..Scene::default() }
    }

    #[test]
    fn only_meshes_that_reach_too_far_are_refused() {
        assert!(check(&scene_with(1e15), Path::new("a.glb")).is_ok());
        let refused = check(&scene_with(3e38), Path::new("a.glb")).expect_err("too far").to_string();
        for part in ["a.glb: mesh `leaf`: error: vertex 1 is 3e38 m away", "expected: ", "remedy: "] {
            assert!(refused.contains(part), "{refused}");
        }
    }
}
