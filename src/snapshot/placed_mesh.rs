//! Placed meshes, for code that draws them one after another instead of tracing rays. In goes a snapshot, out
//! come triangles in relative space. Invariant: the triangles and vertices are those of the trees.

use super::{MeshPart, Snapshot};
use crate::accel::PrimitiveId;
use crate::scene::{Instance, Mesh, Triangle};
use glam::{DAffine3, Vec3};

/// A placed mesh, with its opaque or its blended triangles.
#[derive(Clone, Copy)]
pub struct DrawnMesh<'a> {
    /// Transform.
    pub relative_from_mesh: DAffine3,
    /// Vertices in their bent shape, in mesh space.
    pub positions: &'a [Vec3],
    /// Whether they differ from the file's.
    pub is_bent: bool,
    /// Whether these are its blended triangles.
    pub is_blended: bool,
    snapshot: &'a Snapshot<'a>,
    number: usize,
}

impl Snapshot<'_> {
    /// Number of meshes to draw.
    pub fn mesh_count(&self) -> usize {
        self.placed.len()
    }

    /// Number of a mesh that is the same at all moments of a shutter, whichever other meshes are visible;
    /// below [`Self::lasting_count`].
    pub fn lasting_number(&self, number: usize) -> usize {
        2 * self.placed[number].instance() + usize::from(number >= self.first_blended)
    }

    /// Count of lasting numbers: two for each of the scene's instances, for its opaque and its blended
    /// triangles.
    pub fn lasting_count(&self) -> usize {
        2 * self.scene.instances.len()
    }

    /// Number of the part, within its mesh, that a triangle belongs to.
    pub fn part_of(&self, primitive: PrimitiveId) -> usize {
        let mesh = self.placed[primitive.instance as usize].mesh();
        self.parts.part_of((mesh, &self.scene.meshes[mesh]), primitive.triangle)
    }

    /// Whether the camera sees a mesh.
    pub fn is_mesh_seen(&self, number: usize) -> bool {
        self.rays_of_instances().is_none_or(|rays| rays[number].visible_to_camera)
    }

    /// Mesh by its number.
    pub fn mesh(&self, number: usize) -> DrawnMesh<'_> {
        let placed = &self.placed[number];
        let mesh = &self.scene.meshes[placed.mesh()];
        DrawnMesh {
            relative_from_mesh: self.relative_from_mesh(number),
            positions: placed.bent.as_ref().map_or(&mesh.positions, |bent| &bent.shape.positions),
            is_bent: placed.bent.is_some(),
            is_blended: number >= self.first_blended,
            snapshot: self,
            number,
        }
    }
}

impl<'a> DrawnMesh<'a> {
    /// Connected parts of its unbent shape.
    pub fn parts(self) -> &'a [MeshPart] {
        self.snapshot.parts.of(self.mesh())
    }

    /// Numbers of mesh and material: equal for meshes with the same look in one snapshot, in any place.
    pub fn looks(self) -> (usize, Option<usize>) {
        let Instance { mesh, material, .. } = self.instance();
        (*mesh, *material)
    }

    /// The mesh in the scene, and its number there.
    fn mesh(self) -> (usize, &'a Mesh) {
        let number = self.instance().mesh;
        (number, &self.snapshot.scene.meshes[number])
    }

    fn instance(self) -> &'a Instance {
        &self.snapshot.scene.instances[self.snapshot.placed[self.number].instance()]
    }

    /// Whether these triangles include one of the mesh.
    fn includes(self, triangle: &Triangle) -> bool {
        let material = self.instance().material.unwrap_or(triangle.material);
        self.snapshot.is_blended[material] == self.is_blended
    }

    /// Primitive of a triangle; `None` if these triangles do not include it.
    pub fn primitive(self, triangle: u32) -> Option<PrimitiveId> {
        let is_in = self.includes(&self.mesh().1.triangles[triangle as usize]);
        is_in.then_some(PrimitiveId { instance: self.number as u32, triangle })
    }

    /// Triangles: their primitives in the snapshot, and their vertices.
    pub fn triangles(self) -> impl Iterator<Item = (PrimitiveId, [usize; 3])> + 'a {
        let triangles = self.mesh().1.triangles.iter().zip(0..);
        triangles.filter(move |(triangle, _)| self.includes(triangle)).map(move |(triangle, number)| {
            let primitive = PrimitiveId { instance: self.number as u32, triangle: number };
            (primitive, triangle.vertices.map(|vertex| vertex as usize))
        })
    }
}
