//! Flow noise: gradient noise with rotating gradients. In go places and the turn of the gradients, out come
//! numbers. Invariant: a number is a function of seed, place and turn alone, and periodic in whole turns.

use super::{Chance, sphere_from_square};
use glam::{DVec2, DVec3, IVec3};
use std::f64::consts::TAU;

/// Noise of one scale, with random extrema around integer places.
#[derive(Clone, Copy, Debug)]
pub struct FlowNoise {
    /// Seed of the noise.
    pub seed: u32,
    /// Rotation of all gradients in turns, each in a plane of its own (Perlin & Neyret 2001, "Flow noise").
    pub turns: f64,
}

/// Root mean square of the noise: gradients have unit length.
pub const FLOW_NOISE_DEVIATION: f64 = 0.191;

/// The noise within a box.
pub struct NoiseWithin {
    first: IVec3,
    size: IVec3,
    gradients: Vec<DVec3>,
}

impl FlowNoise {
    /// Prepares the noise for places between two corners.
    pub fn within(&self, low: DVec3, high: DVec3) -> NoiseWithin {
        let first = low.floor().as_ivec3();
        let size = high.floor().as_ivec3() - first + 2;
        let mut gradients = Vec::with_capacity((size.x * size.y * size.z) as usize);
        for x in 0..size.x {
            for y in 0..size.y {
                gradients.extend((0..size.z).map(|z| self.gradient(first + IVec3::new(x, y, z))));
            }
        }
        NoiseWithin { first, size, gradients }
    }

    fn gradient(&self, node: IVec3) -> DVec3 {
        // Teschner et al. 2003, "Optimized spatial hashing", section 4.
        let item = node.x.wrapping_mul(73_856_093)
            ^ node.y.wrapping_mul(19_349_663)
            ^ node.z.wrapping_mul(83_492_791);
        let chance = Chance::of(self.seed, item as u32);
        let from = sphere_from_square(DVec2::new(chance.at(0), chance.at(1)));
        let (right, up) = from.any_orthonormal_pair();
        let across = DVec2::from_angle(TAU * chance.at(2));
        let turned = DVec2::from_angle(TAU * self.turns.fract());
        turned.x * from + turned.y * (across.x * right + across.y * up)
    }
}

impl NoiseWithin {
    /// Noise at a place between the corners; mostly from -0.5 to 0.5. Perlin 2002, "Improving noise".
    pub fn at(&self, place: DVec3) -> f64 {
        let node = place.floor();
        let share = place - node;
        let fade = share * share * share * (share * (6.0 * share - 15.0) + 10.0);
        let start = node.as_ivec3() - self.first;
        let start = ((start.x * self.size.y + start.y) * self.size.z + start.z) as usize;
        let (step_x, step_y) = ((self.size.y * self.size.z) as usize, self.size.z as usize);
        let corner = |x: usize, y: usize, z: usize| {
            let gradient = self.gradients[start + x * step_x + y * step_y + z];
            gradient.dot(share - DVec3::new(x as f64, y as f64, z as f64))
        };
        let along_z = |x: usize, y: usize| {
            let (near, far) = (corner(x, y, 0), corner(x, y, 1));
            near + fade.z * (far - near)
        };
        let along_y = |x: usize| {
            let (near, far) = (along_z(x, 0), along_z(x, 1));
            near + fade.y * (far - near)
        };
        let (near, far) = (along_y(0), along_y(1));
        near + fade.x * (far - near)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn places() -> impl Iterator<Item = DVec3> {
        let along = |index: u32, draw: u64| 40.0 * (Chance::of(5, index).at(draw) - 0.5);
        (0..20_000).map(move |index| DVec3::new(along(index, 0), along(index, 1), along(index, 2)))
    }

    #[test]
    fn its_mean_is_nothing_and_its_deviation_is_known_at_every_turn() {
        for turns in [0.0, 0.3, 0.75] {
            let noise = FlowNoise { seed: 3, turns }.within(DVec3::splat(-20.0), DVec3::splat(20.0));
            let (mut sum, mut squares) = (0.0, 0.0);
            places().for_each(|place| {
                let value = noise.at(place);
                (sum, squares) = (sum + value, squares + value * value);
            });
            let deviation = (squares / 20_000.0_f64).sqrt();
            assert!((sum / 20_000.0_f64).abs() < 0.006, "{sum}");
            assert!((deviation / FLOW_NOISE_DEVIATION - 1.0).abs() < 0.02, "{deviation}");
        }
    }

    /// For any box, a whole turn later, and without jumps.
    #[test]
    fn it_is_a_smooth_function_of_place_and_turn() {
        let at = |place: DVec3, turns: f64| FlowNoise { seed: 8, turns }.within(place, place).at(place);
        let all = FlowNoise { seed: 8, turns: 0.2 }.within(DVec3::splat(-20.0), DVec3::splat(20.0));
        for place in places().take(400) {
            let value = all.at(place);
            assert_eq!(at(place, 0.2), value);
            assert!((at(place, 3.2) - value).abs() < 1e-12);
            assert!((at(place + DVec3::splat(1e-5), 0.2) - value).abs() < 1e-4);
            assert!((at(place, 0.2 + 1e-5) - value).abs() < 2e-4);
        }
        assert!(places().any(|place| (at(place, 0.7) - at(place, 0.2)).abs() > 0.2));
    }
}
