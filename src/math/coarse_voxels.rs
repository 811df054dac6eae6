//! Voxels of several times the size: means of cubes. In go voxels, out come integrals along lines at a part
//! of the cost. Invariant: the sum over all voxels stays the same.

use super::brick_rows::BRICK;
use super::voxels::VoxelsBuilder;
use super::{Ray, VoxelDepths, Voxels, sphere_from_square, square_from_sphere};
use glam::{DVec2, DVec3, IVec3};
use std::collections::HashMap;
use std::sync::OnceLock;

/// Number of directions towards the sky along each side of the square that is mapped to the sphere.
const SKY_SIDE: usize = 12;
/// Maximum number of coarse voxels with depths in all directions: 80 MB.
const MOST_UNDER_SKY: f64 = (1 << 17) as f64;

/// Voxels that are means of finer ones.
#[derive(Debug)]
pub(super) struct CoarseVoxels {
    voxels: Voxels,
    /// Number of fine voxels along the edge of a coarse one.
    times: f64,
    /// Depths towards the sky, by direction, computed on first use.
    sky: Vec<OnceLock<VoxelDepths>>,
}

impl CoarseVoxels {
    /// Means of cubes of `times` voxels along each edge, a power of two up to 8; `None` where means are
    /// negligible.
    pub(super) fn new(fine: &Voxels, times: i32) -> Option<Self> {
        let mut bricks: HashMap<IVec3, [f32; BRICK]> = HashMap::new();
        let per_voxel = (times as f32).powi(-3);
        fine.for_each_brick(|first, values| {
            // A fine brick lies within a single coarse one.
            let first = first.div_euclid(IVec3::splat(times));
            let coarse = bricks.entry(first >> 3).or_insert([0.0; BRICK]);
            for (place, value) in values.iter().enumerate() {
                let along = IVec3::new(place as i32 >> 6, place as i32 >> 3 & 7, place as i32 & 7) / times;
                let at = (first + along) & 7;
                coarse[(at.x << 6 | at.y << 3 | at.z) as usize] += per_voxel * value;
            }
        });
        let mut builder = VoxelsBuilder::default();
        bricks.into_iter().for_each(|(brick, values)| builder.add(brick << 3, values));
        let voxels = builder.built().ok()?;
        let (low, high) = voxels.bounds();
        let directions =
            if (high - low).element_product() <= MOST_UNDER_SKY { SKY_SIDE * SKY_SIDE } else { 0 };
        let sky = std::iter::repeat_with(OnceLock::new).take(directions).collect();
        Some(Self { voxels, times: f64::from(times), sky })
    }

    /// Integral over a range of a line in the fine voxels' space, in units of `t`.
    pub(super) fn integral(&self, line: &Ray, range: (f64, f64)) -> f64 {
        self.voxels.integral(&self.line(line), range)
    }

    /// Integral from a line's origin towards the sky, in the nearest of the precomputed directions.
    pub(super) fn integral_to_sky(&self, line: &Ray) -> f64 {
        let line = self.line(line);
        let per_t = line.direction.length();
        let place = square_from_sphere(line.direction / per_t) * SKY_SIDE as f64;
        let [column, row] = place.to_array().map(|along| (along as usize).min(SKY_SIDE - 1));
        let Some(depths) = self.sky.get(row * SKY_SIDE + column) else {
            return self.voxels.integral(&line, (0.0, f64::INFINITY));
        };
        // Computed outside of the lock, as threads that help may need them, too.
        let made = || {
            let middle = (DVec2::new(column as f64, row as f64) + 0.5) / SKY_SIDE as f64;
            VoxelDepths::new(&self.voxels, sphere_from_square(middle), (1.0, f64::INFINITY))
        };
        let depths = depths.get().unwrap_or_else(|| {
            let made = made();
            depths.get_or_init(|| made)
        });
        depths.of(depths.line(&line).origin) * self.voxels.most() / per_t
    }

    /// A line of the fine voxels' space in that of the coarse ones.
    fn line(&self, &Ray { origin, direction }: &Ray) -> Ray {
        // Centre of a cube, in the space of its voxels.
        let middle = DVec3::splat(0.5 * (self.times - 1.0));
        Ray { origin: (origin - middle) / self.times, direction: direction / self.times }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Lines through all of it have the same integral as through the fine voxels, and towards the sky nearly
    /// so.
    #[test]
    fn means_hold_as_much() {
        let mut builder = VoxelsBuilder::default();
        for brick in 0..27 {
            let first = 8 * (IVec3::new(brick % 3, brick / 3 % 3, brick / 9) - 1);
            let value = |place: usize| 0.5 + 0.5 * (0.37 * (place + 91 * brick as usize) as f32).sin();
            builder.add(first, (0..BRICK).map(value));
        }
        let fine = builder.built().expect("it holds something");
        let direction = DVec3::new(0.3, 0.8, -0.4).normalize();
        let (right, across) = direction.any_orthonormal_pair();
        for times in [2, 4, 8] {
            let coarse = CoarseVoxels::new(&fine, times).expect("it holds something");
            let [mut all, mut found, mut to_sky] = [0.0; 3];
            for number in 0..80 * 80 {
                let [i, j] = [number / 80, number % 80].map(|index| f64::from(index) - 39.5);
                let origin = DVec3::splat(3.5) + i * right + j * across - 60.0 * direction;
                let line = Ray { origin, direction };
                all += fine.integral(&line, (0.0, 120.0));
                found += coarse.integral(&line, (0.0, 120.0));
                to_sky += coarse.integral_to_sky(&line);
            }
            assert!((found / all - 1.0).abs() < 2e-3, "{times}: {found} {all}");
            assert!((to_sky / all - 1.0).abs() < 2e-2, "{times}: {to_sky} {all}");
        }
    }
}
