//! Hits: answers of ray queries. Invariant: a hit's barycentrics lie in its triangle.

/// A triangle of a placed mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct PrimitiveId {
    /// Index into the meshes from which an [`InstanceTree`](super::InstanceTree) was built.
    pub instance: u32,
    /// Index into the triangles from which its [`MeshTree`](super::MeshTree) was built.
    pub triangle: u32,
}

/// Intersection of a ray and a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Distance along the ray, in metres.
    pub t: f64,
    /// Primitive that it met.
    pub primitive: PrimitiveId,
    /// Weights of the triangle's vertices 1 and 2; both and their sum lie in `[0, 1]`.
    pub barycentrics: [f64; 2],
}
