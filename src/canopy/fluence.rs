//! Fluence of lamps' and suns' light in the grid. In go places, directions and powers of rays, out comes the
//! fluence at each node. Invariant: a ray's contribution at a place is distributed over the corners around it
//! without loss.

use crate::color::Rgb;
use crate::ordinates::grid::Corners;
use crate::ordinates::harmonics::{COUNT, basis};
use glam::DVec3;

/// Forward peak at a place: light of a sun or lamp that fog has scattered nearly straight ahead. It still
/// travels as the sun's or lamp's own light does.
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

/// Where light comes from.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Origin {
    /// A sun, along a direction of travel.
    Sun(DVec3),
    /// A lamp at a place in world space; its light does not grow within a distance.
    Lamp(DVec3, f64),
}

impl Origin {
    /// Direction of travel at a place, and the distance that the irradiance of a forward peak falls off with:
    /// next to a lamp, light scattered on the way is as much as the way is long.
    pub(crate) fn at(self, place: DVec3) -> (DVec3, f64) {
        match self {
            Self::Sun(travel) => (travel, 1.0),
            Self::Lamp(position, least_m) => {
                let way = place - position;
                (way.normalize_or(DVec3::Y), way.length().max(least_m))
            }
        }
    }
}

/// Forward peak of a sun or a lamp at all nodes.
#[derive(Clone, Debug)]
pub(crate) struct ForwardPeak {
    pub(crate) origin: Origin,
    /// Irradiance times the distance of [`Origin::at`].
    pub(crate) irradiance: Vec<[f32; 3]>,
    pub(crate) times: Vec<f32>,
}

impl ForwardPeak {
    /// Forward peak from the fluence of rays. `irradiance` is that of all light at a node, times the
    /// distance.
    pub(crate) fn of<'a>(
        origin: Origin,
        fluences: impl Iterator<Item = &'a Fluence>,
        per_volume: &[f32],
        irradiance: impl Fn(usize) -> f32,
    ) -> Self {
        let mut peak = vec![[0.0; 3]; per_volume.len()];
        for fluence in fluences {
            for channel in 0..3 {
                for (node, value) in fluence.peak(channel).enumerate() {
                    peak[node][channel] += per_volume[node] * value;
                }
            }
        }
        let times = |(node, peak): (usize, &[f32; 3])| mean_times(peak.iter().sum(), irradiance(node));
        Self { origin, times: peak.iter().enumerate().map(times).collect(), irradiance: peak }
    }

    /// Weighted mean of eight nodes about a place.
    pub(crate) fn about(&self, corners: &Corners, place: DVec3) -> Peak {
        let at =
            |(&node, &weight): (&usize, &f64)| weight * Rgb::from_array(self.irradiance[node].map(f64::from));
        let (travel, distance) = self.origin.at(place);
        let irradiance = corners.nodes.iter().zip(&corners.weights).map(at).sum::<Rgb>() / distance;
        let times = corners.iter().map(|(node, weight)| weight * f64::from(self.times[node])).sum();
        Peak { travel, irradiance, times }
    }
}

/// Power times path length, by node: of one direction alone, or by harmonics of the direction. All numbers of
/// a node are contiguous.
pub(crate) struct Fluence {
    harmonics: usize,
    values: Vec<f32>,
}

/// Numbers of each node for one direction, and for many: by channel all light, then its forward peak.
const OF_BEAM: usize = 6;
const OF_LAMP: usize = 3 * COUNT + 3;

impl Fluence {
    pub(crate) fn zero(nodes: usize, has_directions: bool) -> Self {
        let harmonics = if has_directions { COUNT } else { 1 };
        Self { harmonics, values: vec![0.0; 3 * (harmonics + 1) * nodes] }
    }

    /// Forward peak by node.
    pub(crate) fn peak(&self, channel: usize) -> impl Iterator<Item = f32> {
        let all = 3 * self.harmonics;
        self.values.chunks_exact(all + 3).map(move |node| node[all + channel])
    }

    /// Fluence by node; for one direction alone there is one harmonic.
    pub(crate) fn of(&self, channel: usize, index: usize) -> impl Iterator<Item = f32> {
        let place = channel * self.harmonics + index;
        self.values.chunks_exact(3 * (self.harmonics + 1)).map(move |node| node[place])
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
            let of_lamp: [f64; OF_LAMP] = std::array::from_fn(|place| match place.checked_sub(3 * COUNT) {
                Some(channel) => peak[channel],
                None => amount[place / COUNT] * basis[place % COUNT],
            });
            self.add_to_nodes(shares, &of_lamp);
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

/// Mean number of scatterings of light that was scattered at least once, where `peak` of `all` was: a Poisson
/// process (van de Hulst 1980, "Multiple Light Scattering").
pub(crate) fn mean_times(peak: f32, all: f32) -> f32 {
    let share = if all > 0.0 { (peak / all).clamp(0.0, 1.0 - 1e-6) } else { 0.0 };
    let depth = -(1.0 - share).ln();
    if depth > 1e-3 { depth / share } else { 1.0 }
}
