//! Faces of walls as seen from the nodes next to them. In go the patches that nodes see, out come the sides
//! of walls around each node, and moments of the radiance towards each. Invariant: a wall's own radiance is
//! never part of its irradiance, however coarse the ordinates are.
//!
//! Faces are numbered after the nodes of a grid, so one list has the moments of both.

use super::grid::Corners;
use super::harmonics::{COUNT, basis, flux_lobe, fourth_basis, product, third_basis};
use super::moments::NodeMoments;
use super::quadrature::Ordinate;
use super::wanted::Wanted;
use crate::color::Rgb;
use glam::DVec3;
use std::sync::Arc;

/// Cosine of the angle between normals within which patches are one face.
const SAME: f64 = 0.95;
/// Cosine of the angle within which a normal belongs to a face.
const PART: f64 = 0.7;

/// Sides of walls, by node.
pub(crate) struct Faces {
    nodes: usize,
    all: Vec<Face>,
    /// Index of each node's first face; one more entry ends the last node's.
    starts: Vec<u32>,
}

/// A side of a wall next to a node.
#[derive(Clone, Copy)]
pub(crate) struct Face {
    node: usize,
    normal: DVec3,
}

impl Faces {
    /// Faces of a grid with so many nodes. `seen` has the nodes next to walls, each with the normals of its
    /// patches.
    pub(crate) fn new(nodes: usize, seen: impl Iterator<Item = (usize, Vec<DVec3>)>) -> Self {
        let mut all: Vec<Face> = Vec::new();
        for (node, normals) in seen {
            let first = all.len();
            for normal in normals {
                if !all[first..].iter().any(|face| face.normal.dot(normal) > SAME) {
                    all.push(Face { node, normal });
                }
            }
        }
        all.sort_by_key(|face| face.node);
        let starts = (0..=nodes).map(|node| all.partition_point(|face| face.node < node) as u32).collect();
        Self { nodes, all, starts }
    }

    /// All faces; `laid` maps a node to its index in a layout.
    pub(crate) fn laid(&self, laid: impl Fn(usize) -> usize) -> Arc<[Face]> {
        self.all.iter().map(|face| Face { node: laid(face.node), ..*face }).collect()
    }

    /// Number of nodes and faces together.
    pub(crate) fn count_with_nodes(&self) -> usize {
        self.nodes + self.all.len()
    }

    /// Number of the face of a node that a normal belongs to; that of the node itself if there is none.
    pub(crate) fn of(&self, node: usize, normal: DVec3) -> usize {
        let (first, end) = (self.starts[node] as usize, self.starts[node + 1] as usize);
        let likest = (first..end).map(|number| (self.all[number].normal.dot(normal), number));
        let likest = likest.filter(|(cos, _)| *cos > PART).max_by(|a, b| a.0.total_cmp(&b.0));
        likest.map_or(node, |(_, number)| self.nodes + number)
    }

    /// Number among faces alone of the face of a node that a normal belongs to.
    pub(super) fn number(&self, node: usize, normal: DVec3) -> Option<usize> {
        self.of(node, normal).checked_sub(self.nodes)
    }

    /// Irradiance on each face, W/m^2.
    pub(crate) fn irradiances(&self, light: &NodeMoments) -> Vec<[f32; 3]> {
        let of_face = |(face, number): (&Face, usize)| {
            let irradiance = product(&flux_lobe(face.normal), &light.at(number));
            irradiance.to_array().map(|channel| channel as f32)
        };
        self.all.iter().zip(self.nodes..).map(of_face).collect()
    }

    /// Mean of `values`, by face; `None` unless all corners around a place are faces whose normals `is_asked`
    /// accepts.
    pub(crate) fn mean(
        &self,
        lit: &Corners,
        is_asked: impl Fn(DVec3) -> bool,
        values: &[[f32; 3]],
    ) -> Option<Rgb> {
        let mut mean = [0.0; 3];
        for (number, weight) in lit.iter().filter(|(_, weight)| *weight != 0.0) {
            let face = number.checked_sub(self.nodes)?;
            if !is_asked(self.all[face].normal) {
                return None;
            }
            mean.iter_mut().zip(values[face]).for_each(|(sum, value)| *sum += weight * f64::from(value));
        }
        Some(Rgb::from_array(mean))
    }

    /// Nodes around a place, with those replaced by faces whose walls face `normal`.
    pub(crate) fn of_corners(&self, corners: &Corners, normal: DVec3) -> Corners {
        Corners { nodes: corners.nodes.map(|node| self.of(node, normal)), weights: corners.weights }
    }
}

/// Moments of radiance that travels towards each face.
pub(crate) struct TowardsFaces {
    /// Faces in the order of the nodes.
    faces: Arc<[Face]>,
    pub(crate) moments: Vec<[f32; COUNT]>,
    /// Moments of degrees 3 and 4.
    pub(crate) third: Vec<[f32; COUNT]>,
    pub(crate) fourth: Vec<[f32; COUNT]>,
}

impl TowardsFaces {
    pub(crate) fn new(faces: Arc<[Face]>) -> Self {
        Self { faces, moments: Vec::new(), third: Vec::new(), fourth: Vec::new() }
    }

    /// Sets all moments to 0, with room for those that are wanted.
    pub(crate) fn clear(&mut self, wanted: &Wanted) {
        let count = self.faces.len();
        let room = |is_wanted: bool| vec![[0.0; COUNT]; if is_wanted { count } else { 0 }];
        self.moments = room(wanted.moments);
        self.third = room(wanted.third);
        self.fourth = room(wanted.last);
    }

    /// Adds radiance along an ordinate to the moments of each face that it travels towards.
    pub(crate) fn add(&mut self, ordinate: Ordinate, radiance: &[f32], wanted: &Wanted) {
        let weighted = |basis: [f64; COUNT]| basis.map(|value| (ordinate.weight * value) as f32);
        let factors = weighted(basis(ordinate.direction));
        let of_third = wanted.third.then(|| weighted(third_basis(ordinate.direction)));
        let of_fourth = wanted.last.then(|| weighted(fourth_basis(ordinate.direction)));
        for (number, face) in self.faces.iter().enumerate() {
            if face.normal.dot(ordinate.direction) < 0.0 {
                let radiance = radiance[face.node];
                if wanted.moments {
                    add(&mut self.moments[number], radiance, &factors);
                }
                if let Some(factors) = &of_third {
                    add(&mut self.third[number], radiance, factors);
                }
                if let Some(factors) = &of_fourth {
                    add(&mut self.fourth[number], radiance, factors);
                }
            }
        }
    }
}

fn add(sums: &mut [f32; COUNT], radiance: f32, factors: &[f32; COUNT]) {
    for (sum, factor) in sums.iter_mut().zip(factors) {
        *sum += radiance * factor;
    }
}
