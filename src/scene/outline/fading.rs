//! Cutting of triangles by vertex alphas. In go triangles, out come their parts with at least a threshold.
//! Invariant: alpha is linear on a triangle, so the cut is straight and exact; neighbours share the vertices
//! on their common edge.

use super::{Between, Outlined};
use std::collections::BTreeMap;

/// Rests of triangles after the cut.
pub(super) fn outlined(alphas: &[f32], threshold: f64, triangles: &[[u32; 3]]) -> Outlined {
    let mut edges = Edges { alphas, threshold, numbers: BTreeMap::new(), added: Vec::new() };
    let mut kept = Vec::with_capacity(triangles.len());
    for &triangle in triangles {
        let polygon = edges.clipped(triangle);
        let fan = polygon.windows(2).skip(1).map(|side| [polygon[0], side[0], side[1]]);
        kept.extend(fan);
    }
    Outlined { added: edges.added, triangles: kept }
}

struct Edges<'a> {
    alphas: &'a [f32],
    threshold: f64,
    /// Indices by the ends of the edge, the smaller first.
    numbers: BTreeMap<[u32; 2], u32>,
    added: Vec<Between>,
}

impl Edges<'_> {
    /// Corners of a triangle's rest, in its order (Sutherland and Hodgman 1974).
    fn clipped(&mut self, triangle: [u32; 3]) -> Vec<u32> {
        let mut polygon = Vec::with_capacity(4);
        for (from, to) in [(0, 1), (1, 2), (2, 0)].map(|(a, b)| (triangle[a], triangle[b])) {
            if self.is_shown(from) {
                polygon.push(from);
            }
            if self.is_shown(from) != self.is_shown(to) {
                polygon.push(self.on_edge(from, to));
            }
        }
        polygon
    }

    fn is_shown(&self, vertex: u32) -> bool {
        f64::from(self.alphas[vertex as usize]) >= self.threshold
    }

    /// Vertex where an edge crosses the threshold.
    fn on_edge(&mut self, from: u32, to: u32) -> u32 {
        let ends = [from.min(to), from.max(to)];
        let next = (self.alphas.len() + self.added.len()) as u32;
        *self.numbers.entry(ends).or_insert_with(|| {
            let [a, b] = ends.map(|vertex| f64::from(self.alphas[vertex as usize]));
            let share = (self.threshold - a) / (b - a);
            self.added
                .push(Between { corners: [ends[0], ends[1], ends[1]], weights: [1.0 - share, share, 0.0] });
            next
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec2;

    /// A unit square of two triangles, alpha 0 at the left and 1 at the right.
    const CORNERS: [DVec2; 4] = [DVec2::ZERO, DVec2::X, DVec2::ONE, DVec2::Y];
    const ALPHAS: [f32; 4] = [0.0, 1.0, 1.0, 0.0];

    fn area(left: &Outlined) -> f64 {
        let added = left.added.iter().map(|between| {
            (0..3).map(|corner| between.weights[corner] * CORNERS[between.corners[corner] as usize]).sum()
        });
        let points: Vec<DVec2> = CORNERS.into_iter().chain(added).collect();
        let area = |triangle: &[u32; 3]| {
            let [a, b, c] = triangle.map(|vertex| points[vertex as usize]);
            0.5 * (b - a).perp_dot(c - a)
        };
        left.triangles.iter().map(area).sum()
    }

    #[test]
    fn the_part_above_the_threshold_is_left() {
        for threshold in [0.25, 0.5, 0.9] {
            let left = outlined(&ALPHAS, threshold, &[[0, 1, 2], [0, 2, 3]]);
            assert!((area(&left) - (1.0 - threshold)).abs() < 1e-12, "{threshold}");
            // The diagonal's cut is one vertex for both triangles.
            assert_eq!(left.added.len(), 3);
        }
    }

    #[test]
    fn what_is_shown_or_hidden_whole_is_not_cut() {
        let all = outlined(&ALPHAS, 0.0, &[[0, 1, 2]]);
        assert_eq!((all.triangles.as_slice(), all.added.len()), (&[[0, 1, 2]][..], 0));
        assert!(outlined(&ALPHAS, 1.5, &[[0, 1, 2]]).triangles.is_empty());
    }
}
