//! Velocities of a file: one vector grid, perhaps staggered, or a scalar grid for each axis. In go grids, out
//! come velocities at places. Invariant: only grids with a usual name are used.

use super::leaves::vector_voxels;
use crate::description::vdb::{Floats, Grid};
use crate::math::VectorVoxels;
use glam::{DAffine3, DMat3, DVec3, Vec3};

/// Usual names of velocity grids.
const NAMES: [&str; 3] = ["velocity", "vel", "v"];
/// Separators between such a name and an axis.
const SEPARATORS: [&str; 3] = ["_", ".", ""];
const AXES: [&str; 3] = ["x", "y", "z"];

#[derive(Debug)]
pub(super) struct Velocities {
    /// Grids whose sum it is, with transforms to their voxels.
    parts: Vec<Part>,
}

type Part = (DAffine3, VectorVoxels);

impl Velocities {
    /// Velocities of a file; `None` if it has none.
    pub(super) fn of(grids: &[Grid]) -> Option<Self> {
        let parts = NAMES.iter().find_map(|name| of_vectors(grids, name).or_else(|| by_axis(grids, name)))?;
        let inverted = |(space, voxels): (DAffine3, _)| (space.inverse(), voxels);
        Some(Self { parts: parts.into_iter().map(inverted).collect() })
    }

    /// Velocity at a place, m/s.
    pub(super) fn at(&self, place: DVec3) -> DVec3 {
        let of_part = |(voxel_from_space, voxels): &Part| {
            voxels.at(voxel_from_space.transform_point3(place)).as_dvec3()
        };
        self.parts.iter().map(of_part).sum()
    }

    /// Maximum speed along an axis, in voxels a second.
    pub(super) fn most(&self, voxel_from_space: DMat3) -> f64 {
        let most = |(_, voxels): &Part| {
            let along = |velocity: Vec3| (voxel_from_space * velocity.as_dvec3()).abs().max_element();
            voxels.all().map(along).fold(0.0, f64::max)
        };
        self.parts.iter().map(most).sum()
    }
}

fn of_vectors(grids: &[Grid], name: &str) -> Option<Vec<Part>> {
    let grid = grids.iter().find(|grid| grid.name == name)?;
    let vectors = grid.vectors.as_ref()?;
    if !grid.is_staggered {
        return Some(vec![(vectors.transform, vector_voxels(vectors, Vec3::from))]);
    }
    // Each component belongs to the lower face of its voxel.
    let of_axis = |axis: usize| {
        let before = DAffine3::from_translation(-0.5 * DVec3::AXES[axis]);
        let along = move |vector: [f32; 3]| vector[axis] * Vec3::AXES[axis];
        (vectors.transform * before, vector_voxels(vectors, along))
    };
    Some((0..3).map(of_axis).collect())
}

fn by_axis(grids: &[Grid], name: &str) -> Option<Vec<Part>> {
    let part = |separator: &str, axis: usize| {
        let name = format!("{name}{separator}{}", AXES[axis]);
        let floats: &Floats = grids.iter().find(|grid| grid.name == name)?.floats.as_ref()?;
        Some((floats.transform, vector_voxels(floats, move |number| number * Vec3::AXES[axis])))
    };
    SEPARATORS.iter().find_map(|separator| (0..3).map(|axis| part(separator, axis)).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::description::vdb::{Tree, Values};

    /// A brick whose numbers grow along each axis, on the faces before the voxels.
    #[test]
    fn staggered_velocities_are_those_of_faces() {
        let at = |place: usize| [place >> 6, place >> 3 & 7, place & 7].map(|along| along as f32);
        let mut tree = Tree::new([0.0; 3]);
        tree.push([0; 3], [255; 64], (0..512).map(at));
        let transform = DAffine3::from_scale(DVec3::splat(0.5));
        let grid = Grid {
            name: String::from("vel"),
            kind: String::new(),
            floats: None,
            vectors: Some(Values { transform, tree }),
            is_staggered: true,
        };
        let velocities = Velocities::of(&[grid]).expect("a grid of vectors");
        let found = velocities.at(DVec3::new(1.0, 2.0, 1.5));
        assert!((found - DVec3::new(2.5, 4.5, 3.5)).length() < 1e-6, "{found}");
        assert_eq!(velocities.most(DMat3::IDENTITY), 3.0 * 7.0);
    }
}
