//! Faces of walls as seen from the nodes next to them. In go the patches that nodes see, out come the sides
//! of walls about each node, and light that travels towards each. Invariant: what a wall sends out itself is
//! never among the light that it gets, however coarse the ordinates are.
//!
//! Faces are numbered after the nodes of a grid, so that moments of both lie in one list.

use super::grid::Corners;
use super::harmonics::{COUNT, basis, flux_lobe, fourth_basis, product, third_basis};
use super::moments::NodeMoments;
use super::quadrature::Ordinate;
use super::wanted::Wanted;
use crate::color::Rgb;
use glam::DVec3;
use std::sync::Arc;

/// Patches whose normals differ by less than this cosine's angle are one face.
const SAME: f64 = 0.95;
/// A normal belongs to a face within this cosine's angle.
const PART: f64 = 0.7;

/// Sides of walls, by node.
pub(crate) struct Faces {
    nodes: usize,
    all: Vec<Face>,
    /// Begin of each node's faces; those of the last end with the list.
    starts: Vec<u32>,
}

/// A side of a wall about a node.
#[derive(Clone, Copy)]
pub(crate) struct Face {
    node: usize,
    normal: DVec3,
}

impl Faces {
    /// Faces of a grid with so many nodes. `seen` has the nodes next to walls, each with the normals of
    /// all patches that it sees.
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

    /// All of them; `laid` has the place of a node's values.
    pub(crate) fn laid(&self, laid: impl Fn(usize) -> usize) -> Arc<[Face]> {
        self.all.iter().map(|face| Face { node: laid(face.node), ..*face }).collect()
    }

    /// Number of nodes and faces together.
    pub(crate) fn count_with_nodes(&self) -> usize {
        self.nodes + self.all.len()
    }

    /// The number of the face of a node that what faces `normal` is part of; the node's own if there is none.
    pub(crate) fn of(&self, node: usize, normal: DVec3) -> usize {
        let (first, end) = (self.starts[node] as usize, self.starts[node + 1] as usize);
        let likest = (first..end).map(|number| (self.all[number].normal.dot(normal), number));
        let likest = likest.filter(|(cos, _)| *cos > PART).max_by(|a, b| a.0.total_cmp(&b.0));
        likest.map_or(node, |(_, number)| self.nodes + number)
    }

    /// Irradiance on each face, W/m^2.
    pub(crate) fn irradiances(&self, light: &NodeMoments) -> Vec<[f32; 3]> {
        let of_face = |(face, number): (&Face, usize)| {
            let irradiance = product(&flux_lobe(face.normal), &light.at(number));
            irradiance.to_array().map(|channel| channel as f32)
        };
        self.all.iter().zip(self.nodes..).map(of_face).collect()
    }

    /// The mean of `values`, by face, where all that is about a place are faces whose normal `is_asked`.
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

    /// Nodes about a place, or what of their light travels towards a wall that faces `normal`.
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

    /// Nothing, with room for what is wanted.
    pub(crate) fn clear(&mut self, wanted: &Wanted) {
        let count = self.faces.len();
        let room = |is_wanted: bool| vec![[0.0; COUNT]; if is_wanted { count } else { 0 }];
        self.moments = room(wanted.moments);
        self.third = room(wanted.third);
        self.fourth = room(wanted.last);
    }

    /// Adds radiance along an ordinate.
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
