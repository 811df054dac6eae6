//! Light of lamps and suns on its way through the grid. In go rays' places, directions and powers, out comes what each node has of them. Invariant: what a place has is
//! shared out among the nodes about it, and none of it is lost.

use super::grid::Corners;
use super::harmonics::{COUNT, basis};
use crate::color::Rgb;
use glam::DVec3;

/// A sun's light that fog has scattered, but nearly straight ahead: it still goes as the sun's own does.
#[derive(Clone, Debug)]
pub(super) struct Glow {
    /// Direction of travel.
    pub(super) travel: DVec3,
    /// Irradiance on a plane that faces it, by node, W/m^2.
    pub(super) irradiance: Vec<[f32; 3]>,
}

impl Glow {
    /// On the mean of eight nodes.
    pub(super) fn mean(&self, corners: &Corners) -> Rgb {
        let at =
            |(&node, &weight): (&usize, &f64)| weight * Rgb::from_array(self.irradiance[node].map(f64::from));
        corners.nodes.iter().zip(&corners.weights).map(at).sum()
    }
}

/// Power times way, by node: of one direction alone, or by harmonics of the direction.
pub(super) struct Fluence {
    nodes: usize,
    harmonics: usize,
    values: Vec<f32>,
    /// Of one direction, that part of it that fog has scattered nearly straight ahead.
    glow: Vec<f32>,
}

impl Fluence {
    pub(super) fn zero(nodes: usize, has_directions: bool) -> Self {
        let harmonics = if has_directions { COUNT } else { 1 };
        let glow = if has_directions { Vec::new() } else { vec![0.0; 3 * nodes] };
        Self { nodes, harmonics, values: vec![0.0; 3 * harmonics * nodes], glow }
    }

    pub(super) fn glow(&self, channel: usize) -> &[f32] {
        &self.glow[channel * self.nodes..][..self.nodes]
    }

    pub(super) fn of(&self, channel: usize, index: usize) -> &[f32] {
        &self.values[(channel * self.harmonics + index) * self.nodes..][..self.nodes]
    }

    pub(super) fn add(&mut self, corners: &Corners, direction: DVec3, amount: Rgb, glow: Rgb) {
        let basis = if self.harmonics == 1 { [1.0; COUNT] } else { basis(direction) };
        for (node, weight) in corners.nodes.into_iter().zip(corners.weights) {
            for channel in 0..3 {
                for (index, value) in basis[..self.harmonics].iter().enumerate() {
                    let place = (channel * self.harmonics + index) * self.nodes + node;
                    self.values[place] += (weight * amount[channel] * value) as f32;
                }
                if let Some(sum) = self.glow.get_mut(channel * self.nodes + node) {
                    *sum += (weight * glow[channel]) as f32;
                }
            }
        }
    }
}
