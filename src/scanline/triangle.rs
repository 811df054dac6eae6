//! One triangle to the samples that it covers (Olano and Greer 1997, "Triangle scan conversion using 2D homogeneous
//! coordinates"). Invariant: two triangles that share an edge agree, but for the sign, on which side of it every sample
//! lies, so no sample falls between them.

use super::projection::Vertex;
use glam::{DVec2, DVec3};

/// A triangle, ready to be asked about places of the picture.
pub(super) struct EdgeForms {
    /// With the place as `d = (x, y, 1)`, `d . edges[i]` has the weight of vertex i: all three have the sign of their sum
    /// where the triangle is, in front of the eye. Positive inside.
    edges: [DVec3; 3],
    depths: [f64; 3],
}

impl EdgeForms {
    /// `None` if it is seen edge-on, or has no area.
    pub(super) fn new([a, b, c]: &[Vertex; 3]) -> Option<Self> {
        // The cross product of b and a is, to the last bit, minus that of a and b.
        let edges = [b.place.cross(c.place), c.place.cross(a.place), a.place.cross(b.place)];
        let volume = a.place.dot(edges[0]);
        let depths = [a.depth, b.depth, c.depth];
        match volume {
            v if v > 0.0 => Some(Self { edges, depths }),
            v if v < 0.0 => Some(Self { edges: edges.map(|edge| -edge), depths }),
            _ => None,
        }
    }

    /// The range of x, in the picture's plane, within which a row may be covered, but for rounding. `None` if it is
    /// not.
    pub(super) fn span(&self, y: f64) -> Option<(f64, f64)> {
        let (mut low, mut high) = (f64::NEG_INFINITY, f64::INFINITY);
        for edge in &self.edges {
            let rest = edge.y * y + edge.z;
            if edge.x > 0.0 {
                low = low.max(-rest / edge.x);
            } else if edge.x < 0.0 {
                high = high.min(-rest / edge.x);
            } else if rest < 0.0 {
                return None;
            }
        }
        Some((low, high))
    }

    /// Distance along the view axis where it is seen at a place; `None` if it is not.
    #[inline]
    pub(super) fn depth_at(&self, place: DVec2) -> Option<f64> {
        let weights = self.edges.map(|edge| edge.x * place.x + (edge.y * place.y + edge.z));
        let sum = weights[0] + weights[1] + weights[2];
        if !(weights[0] >= 0.0 && weights[1] >= 0.0 && weights[2] >= 0.0 && sum > 0.0) {
            return None;
        }
        // Weights of a perspective picture are already those of the triangle in space.
        let depths = self.depths;
        let depth = (weights[0] * depths[0] + weights[1] * depths[1] + weights[2] * depths[2]) / sum;
        (depth > 0.0).then_some(depth)
    }
}
