//! Fluence of lamps' and suns' light in the grid. In go places, directions and powers of rays, out comes the
//! fluence at each node. Invariant: a ray's contribution at a place is distributed over the corners around it
//! without loss.

use crate::color::Rgb;
use crate::ordinates::grid::Corners;
use crate::ordinates::harmonics::{COUNT, basis};
use glam::DVec3;

/// Forward peak at a place: a sun's light that fog has scattered nearly straight ahead. It still travels as
/// the sun's own light does.
#[derive(Clone, Copy)]
pub(crate) struct Peak {
    pub(crate) travel: DVec3,
    /// Irradiance on a plane at right angles, W/m^2.
    pub(crate) irradiance: Rgb,
    /// Mean number of scatterings; at least one.
    pub(crate) times: f64,
}

impl Peak {
    /// Its direction of travel, and its irradiance.
    pub(crate) fn beam(self) -> (DVec3, Rgb) {
        (self.travel, self.irradiance)
    }

    /// Interpolates towards another peak of the same sun.
    pub(crate) fn lerp(&self, other: &Self, share: f64) -> Self {
        let times = self.times + share * (other.times - self.times);
        Self { irradiance: self.irradiance.lerp(other.irradiance, share), times, ..*self }
    }
}

/// Forward peak of a sun at all nodes.
#[derive(Clone, Debug)]
pub(crate) struct ForwardPeak {
    pub(crate) travel: DVec3,
    pub(crate) irradiance: Vec<[f32; 3]>,
    pub(crate) times: Vec<f32>,
}

impl ForwardPeak {
    /// Weighted mean of eight nodes.
    pub(crate) fn about(&self, corners: &Corners) -> Peak {
        let at =
            |(&node, &weight): (&usize, &f64)| weight * Rgb::from_array(self.irradiance[node].map(f64::from));
        let irradiance = corners.nodes.iter().zip(&corners.weights).map(at).sum();
        let times = corners.iter().map(|(node, weight)| weight * f64::from(self.times[node])).sum();
        Peak { travel: self.travel, irradiance, times }
    }
}

/// Power times path length, by node: of one direction alone, or by harmonics of the direction. All numbers of
/// a node are contiguous.
pub(crate) struct Fluence {
    harmonics: usize,
    values: Vec<f32>,
}

/// Numbers of each node for one direction: by channel all light, then its forward peak.
const OF_BEAM: usize = 6;
const OF_ALL: usize = 3 * COUNT;

impl Fluence {
    pub(crate) fn zero(nodes: usize, has_directions: bool) -> Self {
        let harmonics = if has_directions { COUNT } else { 1 };
        let per_node = if has_directions { OF_ALL } else { OF_BEAM };
        Self { harmonics, values: vec![0.0; per_node * nodes] }
    }

    /// Forward peak of one direction, by node.
    pub(crate) fn peak(&self, channel: usize) -> impl Iterator<Item = f32> {
        self.values.chunks_exact(OF_BEAM).map(move |node| node[3 + channel])
    }

    /// Fluence by node; for one direction alone there is one harmonic.
    pub(crate) fn of(&self, channel: usize, index: usize) -> impl Iterator<Item = f32> {
        let (per_node, place) = match self.harmonics {
            1 => (OF_BEAM, channel),
            _ => (OF_ALL, channel * COUNT + index),
        };
        self.values.chunks_exact(per_node).map(move |node| node[place])
    }

    pub(crate) fn add(
        &mut self,
        shares: impl Iterator<Item = (usize, f64)>,
        direction: DVec3,
        amount: Rgb,
        peak: Rgb,
    ) {
        if self.harmonics == 1 {
            let of_beam: [f64; OF_BEAM] =
                std::array::from_fn(|place| if place < 3 { amount[place] } else { peak[place - 3] });
            self.add_to_nodes(shares, &of_beam);
        } else {
            let basis = basis(direction);
            let of_all: [f64; OF_ALL] =
                std::array::from_fn(|place| amount[place / COUNT] * basis[place % COUNT]);
            self.add_to_nodes(shares, &of_all);
        }
    }

    fn add_to_nodes<const N: usize>(
        &mut self,
        shares: impl Iterator<Item = (usize, f64)>,
        values: &[f64; N],
    ) {
        let values = values.map(|value| value as f32);
        let (nodes, _) = self.values.as_chunks_mut::<N>();
        for (node, weight) in shares {
            for (sum, value) in nodes[node].iter_mut().zip(&values) {
                *sum += weight as f32 * value;
            }
        }
    }
}
