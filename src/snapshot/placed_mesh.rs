//! Placed meshes as they stand, for who draws them one after another instead of following rays. In goes a
//! snapshot, out come triangles in relative space. Invariant: the triangles are those of the trees, taken
//! from the same vertices.

use super::{MeshPart, Snapshot};
use crate::accel::PrimitiveId;
use crate::scene::{Mesh, Triangle};
use glam::{DAffine3, Vec3};

/// Mesh where it is placed; its opaque triangles, or its blended ones.
#[derive(Clone, Copy)]
pub struct DrawnMesh<'a> {
    /// Transform.
    pub relative_from_mesh: DAffine3,
    /// Vertices as they are bent, in its own space.
    pub positions: &'a [Vec3],
    /// Whether they are not where they are in the file.
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

    /// The number of a mesh that it has at all moments of a shutter, whatever else appears or is hidden in
    /// it; below [`Self::lasting_count`].
    pub fn lasting_number(&self, number: usize) -> usize {
        2 * self.placed[number].instance + usize::from(number >= self.first_blended)
    }

    /// Number of lasting numbers: two for each of the scene's instances, its opaque and its blended
    /// triangles.
    pub fn lasting_count(&self) -> usize {
        2 * self.scene.instances.len()
    }

    /// Number of the part, within its mesh, that a triangle belongs to.
    pub fn part_of(&self, primitive: PrimitiveId) -> usize {
        let mesh = self.scene.instances[self.placed[primitive.instance as usize].instance].mesh;
        self.parts.part_of((mesh, &self.scene.meshes[mesh]), primitive.triangle)
    }

    /// Whether the camera sees one of them.
    pub fn is_mesh_seen(&self, number: usize) -> bool {
        self.rays_of_instances().is_none_or(|rays| rays.of_instance(number).visible_to_camera)
    }

    /// Mesh by its number.
    pub fn mesh(&self, number: usize) -> DrawnMesh<'_> {
        let placed = &self.placed[number];
        let mesh = &self.scene.meshes[self.scene.instances[placed.instance].mesh];
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
    /// Connected parts, by its shape before it is bent.
    pub fn parts(self) -> &'a [MeshPart] {
        self.snapshot.parts.of(self.mesh())
    }

    /// Numbers of mesh and material: equal for meshes that look the same in one snapshot, wherever they
    /// are.
    pub fn looks(self) -> (usize, Option<usize>) {
        let instance = &self.snapshot.scene.instances[self.snapshot.placed[self.number].instance];
        (instance.mesh, instance.material)
    }

    /// The mesh as it is in the scene, and its number there.
    fn mesh(self) -> (usize, &'a Mesh) {
        let scene = self.snapshot.scene;
        let number = scene.instances[self.snapshot.placed[self.number].instance].mesh;
        (number, &scene.meshes[number])
    }

    /// Primitive of one of its triangles; `None` if that is not among these.
    pub fn primitive(self, triangle: u32) -> Option<PrimitiveId> {
        let (instance, mesh) =
            (&self.snapshot.scene.instances[self.snapshot.placed[self.number].instance], self.mesh().1);
        let material = instance.material.unwrap_or(mesh.triangles[triangle as usize].material);
        let is_in = self.snapshot.is_blended[material] == self.is_blended;
        is_in.then_some(PrimitiveId { instance: self.number as u32, triangle })
    }

    /// Triangles: the primitives that the snapshot knows them by, and their vertices.
    pub fn triangles(self) -> impl Iterator<Item = (PrimitiveId, [usize; 3])> + 'a {
        let instance = &self.snapshot.scene.instances[self.snapshot.placed[self.number].instance];
        let scene = self.snapshot.scene;
        let is_in = move |triangle: &Triangle| {
            let material = instance.material.unwrap_or(triangle.material);
            self.snapshot.is_blended[material] == self.is_blended
        };
        let triangles = scene.meshes[instance.mesh].triangles.iter().zip(0..);
        triangles.filter(move |(triangle, _)| is_in(triangle)).map(move |(triangle, number)| {
            let primitive = PrimitiveId { instance: self.number as u32, triangle: number };
            (primitive, triangle.vertices.map(|vertex| vertex as usize))
        })
    }
}
