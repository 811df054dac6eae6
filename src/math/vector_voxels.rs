//! Vectors at integer places of a grid, trilinear between them. In go bricks of 8 x 8 x 8 and uniform cubes,
//! out come vectors. Invariant: outside of all bricks and cubes the vector is the background.

use super::brick_rows::BRICK;
use glam::{DVec3, IVec3, Vec3};
use std::collections::{BTreeMap, HashMap};

/// Grid of velocities or colours.
#[derive(Debug)]
pub struct VectorVoxels {
    background: Vec3,
    /// Index of each brick's vectors, by the brick's place.
    bricks: HashMap<IVec3, usize>,
    vectors: Vec<Vec3>,
    /// Cubes of a uniform vector by their first voxel, for each edge.
    even: BTreeMap<i32, HashMap<IVec3, Vec3>>,
}

impl VectorVoxels {
    /// Only a background.
    pub fn new(background: Vec3) -> Self {
        Self { background, bricks: HashMap::new(), vectors: Vec::new(), even: BTreeMap::new() }
    }

    /// Adds a brick, z fastest; `first` is a multiple of 8.
    pub fn add(&mut self, first: IVec3, vectors: impl IntoIterator<Item = Vec3>) {
        let number = self.vectors.len() / BRICK;
        self.vectors.extend(vectors.into_iter().take(BRICK));
        self.vectors.resize((number + 1) * BRICK, self.background);
        self.bricks.insert(first >> 3, number);
    }

    /// Adds a uniform cube of `edge` voxels; `first` is a multiple of that.
    pub fn add_even(&mut self, first: IVec3, edge: i32, vector: Vec3) {
        self.even.entry(edge).or_default().insert(first, vector);
    }

    /// All vectors of the grid.
    pub fn all(&self) -> impl Iterator<Item = Vec3> + '_ {
        let even = self.even.values().flat_map(|cubes| cubes.values());
        std::iter::once(&self.background).chain(&self.vectors).chain(even).copied()
    }

    /// Vector at an integer place.
    pub fn voxel(&self, voxel: IVec3) -> Vec3 {
        if let Some(number) = self.bricks.get(&(voxel >> 3)) {
            let within = voxel & 7;
            let place = (within.x << 6 | within.y << 3 | within.z) as usize;
            return self.vectors[number * BRICK + place];
        }
        let even = |(edge, cubes): (&i32, &HashMap<IVec3, Vec3>)| {
            let edge = IVec3::splat(*edge);
            cubes.get(&(voxel.div_euclid(edge) * edge)).copied()
        };
        self.even.iter().find_map(even).unwrap_or(self.background)
    }

    /// Vector at a place.
    pub fn at(&self, place: DVec3) -> Vec3 {
        // Range in which places convert to integers.
        if place.is_nan() || place.abs().max_element() >= 1e9 {
            return self.background;
        }
        let cell = place.floor();
        let share = (place - cell).as_vec3();
        let cell = cell.as_ivec3();
        let corner = |x, y, z| self.voxel(cell + IVec3::new(x, y, z));
        let along_z = |x, y| corner(x, y, 0).lerp(corner(x, y, 1), share.z);
        let along_y = |x| along_z(x, 0).lerp(along_z(x, 1), share.y);
        along_y(0).lerp(along_y(1), share.x)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_linear_stays_so_and_beyond_is_the_background() {
        let mut voxels = VectorVoxels::new(Vec3::splat(-1.0));
        for brick in 0..8 {
            let first = 8 * (IVec3::new(brick & 1, brick >> 1 & 1, brick >> 2) - 1);
            let vector = |place: i32| (first + IVec3::new(place >> 6, place >> 3 & 7, place & 7)).as_vec3();
            voxels.add(first, (0..BRICK as i32).map(vector));
        }
        for place in [DVec3::new(-7.5, 0.25, 6.9), DVec3::new(-0.1, -0.6, 3.0)] {
            assert!((voxels.at(place).as_dvec3() - place).length() < 1e-5, "{place}");
        }
        assert_eq!(voxels.at(DVec3::splat(20.0)), Vec3::splat(-1.0));
        assert_eq!(voxels.at(DVec3::splat(f64::NAN)), Vec3::splat(-1.0));
    }
}
