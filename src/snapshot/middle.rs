//! Places of moving surfaces in the middle of the shutter, for which light of higher orders is solved. In
//! goes the snapshot of the middle, out come points of triangles. Invariant: a point stays on the side of its
//! wall on which it is seen, however far the wall has moved.

use super::bent_mesh::BentMesh;
use super::still::Still;
use super::{Snapshot, SurfacePoint};
use glam::{DAffine3, DVec3};
use std::collections::HashMap;
use std::sync::Arc;

/// Transform of a mesh to the world, and its shape if it bends.
type Place = (DAffine3, Option<Arc<BentMesh>>);

/// Moving instances, by their numbers in the scene.
#[derive(Default)]
pub(super) struct Middle {
    places: HashMap<usize, Place>,
}

impl Middle {
    /// Places of all that moves, from the snapshot of the middle.
    pub(super) fn of(snapshot: &Snapshot, still: Option<&Still>) -> Self {
        let places = snapshot.placed.iter().enumerate().filter_map(|(number, placed)| {
            let mut world_from_mesh = snapshot.relative_from_mesh(number);
            world_from_mesh.translation += snapshot.view.eye;
            let moves = !still.is_some_and(|still| still.keeps(placed.instance()));
            moves.then(|| (placed.instance(), (world_from_mesh, placed.bent.clone())))
        });
        Self { places: places.collect() }
    }
}

impl Snapshot<'_> {
    /// Place in world space that a surface point has in the middle of the shutter; where it is now if it is
    /// not there then.
    pub fn in_the_middle(&self, point: &SurfacePoint) -> DVec3 {
        let placed = &self.placed[point.primitive.instance as usize];
        let Some((world_from_mesh, bent)) = self.middle.places.get(&placed.instance()) else {
            return self.world_from_relative(point.position);
        };
        let mesh = &self.scene.meshes[placed.mesh()];
        let positions = bent.as_ref().map_or(&mesh.positions, |bent| &bent.shape.positions);
        let corners = mesh.triangles[point.primitive.triangle as usize].vertices;
        let weights = self.facet(point.primitive).weights_at(point.position);
        let corner = |number: usize| weights[number] * positions[corners[number] as usize].as_dvec3();
        world_from_mesh.transform_point3((0..3).map(corner).sum())
    }
}
