//! How dense fog and leaves are to light, by node and direction. In go densities, out comes extinction, 1/m.
//! Invariant: `|n.w|` is taken by harmonics up to l = 2, here as everywhere else.

use glam::DVec3;

/// Extinction of a node's leaves, by direction.
pub(super) struct Shade([f32; 8]);

impl Shade {
    /// Of leaf area by volume, 1/m, and the same by outer products of normals: `3/16` and `15/16` of them.
    pub(super) fn of(density: f32, density_by_normal: [f32; 6]) -> Self {
        let [xx, yy, zz, xy, yz, zx] = density_by_normal.map(|density| 15.0 / 16.0 * density);
        Self([3.0 / 16.0 * density, xx, yy, zz, 2.0 * xy, 2.0 * yz, 2.0 * zx, 0.0])
    }

    /// What a direction of travel makes of them; see [`Shade::along`].
    pub(super) fn products(DVec3 { x, y, z }: DVec3) -> [f32; 8] {
        [1.0, x * x, y * y, z * z, x * y, y * z, z * x, 0.0].map(|product| product as f32)
    }

    /// Extinction of light, 1/m, by the products of its direction of travel.
    #[inline]
    pub(super) fn along(&self, products: &[f32; 8]) -> f32 {
        let [a, b, c, d, e, f, g, h]: [f32; 8] = std::array::from_fn(|index| self.0[index] * products[index]);
        (a + e) + (b + f) + ((c + g) + (d + h))
    }
}

/// Of all nodes of a grid.
pub(super) struct Extinction {
    /// Of fog, by channel.
    fog: [Vec<f32>; 3],
    /// Which of `shades` a node has, if any.
    shade_of: Vec<u32>,
    shades: Vec<Shade>,
}

impl Extinction {
    pub(super) fn new(fog: [Vec<f32>; 3], shade_of: Vec<u32>, shades: Vec<Shade>) -> Self {
        Self { fog, shade_of, shades }
    }

    /// Of fog at a node, 1/m by channel, and what its leaves are.
    pub(super) fn at(&self, node: usize) -> ([f32; 3], Option<&Shade>) {
        let fog = [0, 1, 2].map(|channel: usize| self.fog[channel][node]);
        (fog, self.shades.get(self.shade_of[node] as usize))
    }
}
