//! Sites of scattered leaves. In goes a block, out comes a map from three random numbers to points.
//! Invariant: points are uniform in the volume of the box, or in the area of the surface.

use super::Resolver;
use crate::description::ron::Leaves;
use crate::scene::fall::Surface;
use crate::scene::{Mesh, NodeIndex};
use glam::DVec3;

/// Region of leaves, in the space of their parent.
pub(super) enum Site {
    /// Box between two corners.
    Box(DVec3, DVec3),
    /// Surface of triangles.
    Surface(Surface),
}

impl Site {
    /// Surface of `mesh`; `None` if it has no area.
    fn of(mesh: &Mesh) -> Option<Self> {
        let corner = |vertex: u32| mesh.positions[vertex as usize].as_dvec3();
        let triangles = mesh.triangles.iter().map(|triangle| triangle.vertices.map(corner));
        Surface::new(triangles.collect()).map(Self::Surface)
    }

    /// Point for three numbers in `[0, 1)`.
    pub(super) fn at(&self, numbers: [f64; 3]) -> DVec3 {
        match self {
            Self::Box(min, max) => min + (max - min) * DVec3::from_array(numbers),
            Self::Surface(surface) => surface.place(numbers),
        }
    }
}

impl Resolver<'_> {
    /// Site of the leaves of `block`, and their parent.
    pub(super) fn leaf_site(&mut self, owner: &str, block: &Leaves) -> Option<(Option<NodeIndex>, Site)> {
        match (&block.on, &block.min_m, &block.max_m) {
            (Some(object), None, None) => self.leaf_surface(owner, block, object),
            (None, Some(min), Some(max)) => {
                let (min, max) = (min.si(), max.si());
                let valid = min.cmple(max).all();
                if !valid {
                    let found = "`min_m` has a larger coordinate than `max_m`";
                    self.problems.error(owner, found, "min_m <= max_m in x, y and z", "exchange the two");
                }
                let parent = self.parent(owner, block.parent.as_deref())?;
                valid.then_some((parent, Site::Box(min, max)))
            }
            _ => {
                let found = "it is not clear where the leaves are";
                let remedy = "name both corners of a box, or an object that the leaves sit `on`";
                self.problems.error(owner, found, "either `min_m` and `max_m`, or `on`", remedy);
                None
            }
        }
    }

    fn leaf_surface(
        &mut self,
        owner: &str,
        block: &Leaves,
        object: &str,
    ) -> Option<(Option<NodeIndex>, Site)> {
        let field = format!("{owner}.on");
        if block.parent.is_some() {
            let found = "the leaves sit on an object, and follow another as well";
            self.problems.error(&field, found, "`on` without `parent`", "take one of the two out");
        }
        let node = self.problems.find(&field, "object", object, &self.nodes)?;
        if self.changes_shape(&field, object) {
            return None;
        }
        let instance = self.scene.instances.iter().find(|instance| instance.node == node);
        let site = instance.and_then(|instance| Site::of(&self.scene.meshes[instance.mesh]));
        if site.is_none() {
            let found = format!("`{object}` has no surface to sit on");
            let remedy = "name an object with a mesh that is seen";
            self.problems.error(&field, found, "an object with a mesh", remedy);
        }
        Some((Some(node), site?))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Triangle;
    use glam::Vec3;

    #[test]
    fn leaves_are_as_dense_on_every_triangle() {
        // A unit square cut into a small and two large triangles: moments are those of the square.
        let positions = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0), (0.25, 0.0)];
        let mesh = Mesh {
            positions: positions.map(|(x, z)| Vec3::new(x, 0.0, z)).to_vec(),
            triangles: [[0, 4, 3], [4, 1, 2], [4, 2, 3]]
                .map(|vertices| Triangle { vertices, material: 0 })
                .to_vec(),
            ..Mesh::default()
        };
        let site = Site::of(&mesh).expect("it has an area");
        let count = 64_u32;
        let numbers = || (0..count).map(|i| (f64::from(i) + 0.5) / f64::from(count));
        let (mut mean, mut square) = (DVec3::ZERO, DVec3::ZERO);
        for (u, v, w) in
            numbers().flat_map(|u| numbers().flat_map(move |v| numbers().map(move |w| (u, v, w))))
        {
            let point = site.at([u, v, w]);
            mean += point / f64::from(count.pow(3));
            square += point * point / f64::from(count.pow(3));
        }
        assert!((mean - DVec3::new(0.5, 0.0, 0.5)).length() < 2e-3, "{mean}");
        assert!((square - DVec3::new(1.0 / 3.0, 0.0, 1.0 / 3.0)).length() < 2e-3, "{square}");
    }
}
