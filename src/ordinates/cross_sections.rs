//! Cross-sections of a turbid medium by node of a grid. In go extinction and scattering, 1/m, out come losses
//! of light and the source of the next order. Invariant: harmonics up to l = 2 represent both radiance and
//! source, as everywhere between orders.
//!
//! Isotropic scatterers, such as droplets, have an extinction by channel and a phase function by degree.
//! Oriented ones, such as leaves, have an extinction by direction and a scattering matrix, stored at their
//! nodes alone.

use super::harmonics::{COUNT, DEGREE};
use super::moments::Moments;
use glam::DVec3;

/// Indices of harmonics that are equal for a direction and its opposite, and of those that change sign.
pub(crate) const EVEN: [usize; 6] = [0, 4, 5, 6, 7, 8];
pub(crate) const ODD: [usize; 3] = [1, 2, 3];
/// Number of elements of the symmetric matrix of each parity.
const EVEN_PAIRS: usize = 21;
const ODD_PAIRS: usize = 6;

/// Extinction that differs by direction: `k + w.K w`, 1/m, for a direction of travel w.
#[derive(Clone, Copy)]
pub(crate) struct OrientedExtinction([f32; 8]);

impl OrientedExtinction {
    /// Extinction of the constant `k` and the symmetric matrix `K`: xx, yy, zz, xy, yz, zx.
    pub(crate) fn new(constant: f32, [xx, yy, zz, xy, yz, zx]: [f32; 6]) -> Self {
        Self([constant, xx, yy, zz, 2.0 * xy, 2.0 * yz, 2.0 * zx, 0.0])
    }

    /// Extinction of facets that all have one normal, of an area density, 1/m: `|n.w|` by harmonics up to l =
    /// 2.
    pub(crate) fn of_facet(normal: DVec3, density: f32) -> Self {
        let [x, y, z] = normal.as_vec3().to_array();
        let by_normal = [x * x, y * y, z * z, x * y, y * z, z * x];
        Self::new(3.0 / 16.0 * density, by_normal.map(|product| 15.0 / 16.0 * density * product))
    }

    /// Products of a direction of travel; see [`OrientedExtinction::along`].
    pub(crate) fn products(DVec3 { x, y, z }: DVec3) -> [f32; 8] {
        [1.0, x * x, y * y, z * z, x * y, y * z, z * x, 0.0].map(|product| product as f32)
    }

    /// Extinction, 1/m, by the products of the direction of travel.
    #[inline]
    pub(crate) fn along(&self, products: &[f32; 8]) -> f32 {
        let [a, b, c, d, e, f, g, h]: [f32; 8] = std::array::from_fn(|index| self.0[index] * products[index]);
        (a + e) + (b + f) + ((c + g) + (d + h))
    }
}

/// Marks a node without oriented scatterers.
const NONE: u32 = u32::MAX;

/// Extinction at all nodes of a grid.
pub(crate) struct Extinction {
    /// Extinction along all directions, 1/m, by channel and node.
    pub(crate) isotropic: [Vec<f32>; 3],
    /// Index into `oriented`, by node.
    oriented_at: Vec<u32>,
    /// In the order of [`CrossSections::oriented_nodes`].
    pub(super) oriented: Vec<OrientedExtinction>,
}

/// Extinction at one node: that of isotropic scatterers, 1/m by channel, and that of oriented ones.
#[derive(Clone, Copy)]
pub(crate) struct NodeExtinction<'a> {
    pub(crate) isotropic: [f32; 3],
    pub(crate) oriented: Option<&'a OrientedExtinction>,
}

impl Extinction {
    fn zero(nodes: usize) -> Self {
        let isotropic = [const { Vec::new() }; 3].map(|_: Vec<f32>| vec![0.0; nodes]);
        Self { isotropic, oriented_at: vec![NONE; nodes], oriented: Vec::new() }
    }

    pub(crate) fn at(&self, node: usize) -> NodeExtinction<'_> {
        let isotropic = [0, 1, 2].map(|channel: usize| self.isotropic[channel][node]);
        NodeExtinction { isotropic, oriented: self.oriented.get(self.oriented_at[node] as usize) }
    }
}

/// Scattering matrix of the oriented scatterers at a node, 1/m: from moments of radiance to harmonics of the
/// source. Even and odd degrees do not mix; the matrix is symmetric, and each pair is stored once.
#[derive(Clone)]
pub(crate) struct OrientedScattering {
    pub(crate) node: usize,
    /// Elements by channel and pair of harmonics.
    even: [[f32; EVEN_PAIRS]; 3],
    odd: [[f32; ODD_PAIRS]; 3],
}

/// Outer product of a lobe with itself, as an even and an odd part.
pub(crate) struct LobePairs {
    even: [f32; EVEN_PAIRS],
    odd: [f32; ODD_PAIRS],
}

impl LobePairs {
    /// Products of a lobe's harmonics.
    pub(crate) fn of(lobe: &[f32; COUNT]) -> Self {
        Self { even: pairs(&EVEN, lobe), odd: pairs(&ODD, lobe) }
    }
}

impl OrientedScattering {
    pub(crate) fn zero(node: usize) -> Self {
        Self { node, even: [[0.0; EVEN_PAIRS]; 3], odd: [[0.0; ODD_PAIRS]; 3] }
    }

    /// Adds an outer product to the matrix of a channel, with factors for its even and odd part.
    pub(crate) fn add(&mut self, channel: usize, pairs: &LobePairs, [even, odd]: [f32; 2]) {
        for (sum, pair) in self.even[channel].iter_mut().zip(&pairs.even) {
            *sum += even * pair;
        }
        for (sum, pair) in self.odd[channel].iter_mut().zip(&pairs.odd) {
            *sum += odd * pair;
        }
    }

    /// Scales the even part and the odd part of a channel's matrix.
    pub(crate) fn scale(&mut self, channel: usize, [even, odd]: [f32; 2]) {
        self.even[channel].iter_mut().for_each(|pair| *pair *= even);
        self.odd[channel].iter_mut().for_each(|pair| *pair *= odd);
    }

    /// Adds the source that moments of radiance cause in one channel.
    fn scatter(&self, channel: usize, moments: &[f32; COUNT], source: &mut [f32; COUNT]) {
        multiply(&EVEN, &self.even[channel], moments, source);
        multiply(&ODD, &self.odd[channel], moments, source);
    }
}

/// Adds `M moments` to `source`, for a symmetric matrix of which each pair is stored once.
fn multiply<const N: usize>(
    which: &[usize; N],
    pairs: &[f32],
    moments: &[f32; COUNT],
    source: &mut [f32; COUNT],
) {
    let mut pair = 0;
    for i in 0..N {
        for j in i..N {
            source[which[i]] += pairs[pair] * moments[which[j]];
            if i != j {
                source[which[j]] += pairs[pair] * moments[which[i]];
            }
            pair += 1;
        }
    }
}

fn pairs<const N: usize, const M: usize>(which: &[usize; N], lobe: &[f32; COUNT]) -> [f32; M] {
    let mut products = [0.0; M];
    let mut pair = 0;
    for i in 0..N {
        for j in i..N {
            products[pair] = lobe[which[i]] * lobe[which[j]];
            pair += 1;
        }
    }
    products
}

/// Cross-sections of all nodes of a grid.
pub(crate) struct CrossSections {
    pub(crate) extinction: Extinction,
    /// Scattering coefficient of each degree of harmonics: `sigma_s g^l`, 1/m, by channel, degree and node.
    pub(crate) scattering: [[Vec<f32>; 3]; 3],
    oriented: Vec<OrientedScattering>,
}

impl CrossSections {
    /// Empty space.
    pub(crate) fn zero(nodes: usize) -> Self {
        let channels = || [const { Vec::new() }; 3].map(|_: Vec<f32>| vec![0.0; nodes]);
        let scattering = [channels(), channels(), channels()];
        Self { extinction: Extinction::zero(nodes), scattering, oriented: Vec::new() }
    }

    /// Sets the oriented scatterers, each at a node of its own.
    pub(crate) fn set_oriented(
        &mut self,
        of_nodes: impl Iterator<Item = (OrientedExtinction, OrientedScattering)>,
    ) {
        for ((extinction, scattering), number) in of_nodes.zip(0..) {
            self.extinction.oriented_at[scattering.node] = number;
            self.extinction.oriented.push(extinction);
            self.oriented.push(scattering);
        }
    }

    pub(crate) fn oriented_nodes(&self) -> impl Iterator<Item = usize> {
        self.oriented.iter().map(|scattering| scattering.node)
    }

    /// The scattering operator: sources from moments of radiance, per metre and steradian. If the medium
    /// `is_lit`, both kinds of scatterers scatter the light, otherwise oriented ones alone.
    pub(crate) fn scatter(&self, light: &Moments, is_lit: bool) -> Moments {
        let mut sources = Moments::zero(self.extinction.oriented_at.len());
        for channel in 0..3 {
            for (index, degree) in DEGREE.into_iter().enumerate().filter(|_| is_lit) {
                let share = &self.scattering[channel][degree];
                let into = sources.channel_mut(channel, index);
                for ((into, light), share) in into.iter_mut().zip(light.channel(channel, index)).zip(share) {
                    *into = share * light;
                }
            }
            for oriented in &self.oriented {
                let mut source = sources.at(channel, oriented.node);
                oriented.scatter(channel, &light.at(channel, oriented.node), &mut source);
                sources.set(channel, oriented.node, &source);
            }
        }
        sources
    }
}
