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

/// The number of a node's leaves that has none.
pub(super) const NO_LEAVES: u32 = u32::MAX;

/// Of all nodes of a grid.
pub(super) struct Extinction {
    /// Of fog, 1/m, by channel and node.
    pub(super) fog: [Vec<f32>; 3],
    /// Which of `shades` a node has.
    pub(super) leaves_of: Vec<u32>,
    /// Of nodes that have leaves.
    pub(super) shades: Vec<Shade>,
}

impl Extinction {
    /// Of nothing.
    pub(super) fn zero(nodes: usize) -> Self {
        let fog = [const { Vec::new() }; 3].map(|_: Vec<f32>| vec![0.0; nodes]);
        Self { fog, leaves_of: vec![NO_LEAVES; nodes], shades: Vec::new() }
    }

    /// Of fog at a node, 1/m by channel, and what its leaves are.
    pub(super) fn at(&self, node: usize) -> ([f32; 3], Option<&Shade>) {
        let fog = [0, 1, 2].map(|channel: usize| self.fog[channel][node]);
        (fog, self.shades.get(self.leaves_of[node] as usize))
    }
}
