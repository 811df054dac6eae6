//! One triangle and the samples that it covers (Olano and Greer 1997, "Triangle scan conversion using 2D
//! homogeneous coordinates"). In go vertices and places, out come depths. Invariant: two triangles that share
//! an edge have the same edge function, except for its sign, at every sample. So no sample falls between
//! them.

use super::projection::Vertex;
use glam::DVec3;

/// A triangle, prepared for queries at places of the picture.
pub(super) struct EdgeForms {
    /// Edge functions: at the place `d = (x, y, 1)`, `d . edges[i]` is the weight of vertex i. Where the
    /// triangle is visible, in front of the eye, all three have the sign of their sum. Positive inside.
    edges: [DVec3; 3],
    depths: [f64; 3],
}

/// Edge functions on a line of places.
pub(super) struct Line<'a> {
    forms: &'a EdgeForms,
    /// Parts of the three weights that are constant along it.
    rests: [f64; 3],
}

impl EdgeForms {
    /// `None` if the triangle is edge-on, or has no area.
    pub(super) fn new([a, b, c]: [&Vertex; 3]) -> Option<Self> {
        // The cross product of b and a is, to the last bit, minus that of a and b.
        let edges = [b.place.cross(c.place), c.place.cross(a.place), a.place.cross(b.place)];
        let volume = a.place.dot(edges[0]);
        let depths = [a.depth, b.depth, c.depth];
        match volume {
            v if v > 0.0 => Some(Self { edges, depths }),
            v if v < 0.0 => Some(Self { edges: [-edges[0], -edges[1], -edges[2]], depths }),
            _ => None,
        }
    }

    /// Edge functions on the places of one height in the picture's plane.
    #[inline]
    pub(super) fn at_height(&self, y: f64) -> Line<'_> {
        let [a, b, c] = &self.edges;
        Line { forms: self, rests: [a.y * y + a.z, b.y * y + b.z, c.y * y + c.z] }
    }
}

impl Line<'_> {
    /// Range of x, in the picture's plane, that the triangle may cover, to rounding; `None` if it covers
    /// none.
    pub(super) fn span(&self) -> Option<(f64, f64)> {
        let (mut low, mut high) = (f64::NEG_INFINITY, f64::INFINITY);
        for (edge, rest) in self.forms.edges.iter().zip(self.rests) {
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

    /// Distance along the view axis of the triangle at a place; `None` if it does not cover the place.
    #[inline]
    pub(super) fn depth_at(&self, x: f64) -> Option<f64> {
        let (edges, rests) = (&self.forms.edges, &self.rests);
        let (a, b, c) = (edges[0].x * x + rests[0], edges[1].x * x + rests[1], edges[2].x * x + rests[2]);
        let sum = a + b + c;
        if !(a >= 0.0 && b >= 0.0 && c >= 0.0 && sum > 0.0) {
            return None;
        }
        // Weights in a perspective picture are already those of the triangle in space.
        let depths = &self.forms.depths;
        let depth = (a * depths[0] + b * depths[1] + c * depths[2]) / sum;
        (depth > 0.0).then_some(depth)
    }
}
