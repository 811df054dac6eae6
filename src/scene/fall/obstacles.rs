//! Obstacles of falling leaves, such as trunks. In goes the path of a ball, out comes the path around
//! obstacles. Invariant: a free ball stays free of all triangles, except in crevices narrower than itself; no
//! path leads through a surface.

use super::emitter::GRID_PER_M;
use glam::DVec3;
use std::fmt;

/// Maximum triangles in a leaf node of the tree.
const TRIANGLES_PER_LEAF: usize = 4;
/// Number of times that a ball is pushed away from the nearest triangle before it counts as stuck.
const PUSHES: usize = 4;

type Triangle = [DVec3; 3];

/// Bounding volume hierarchy of triangles.
#[derive(Clone, Default)]
pub(in crate::inside::scene) struct Obstacles {
    triangles: Vec<Triangle>,
    /// Parents before their children, the first child right after its parent.
    nodes: Vec<Node>,
}

#[derive(Clone, Copy)]
struct Node {
    low: DVec3,
    high: DVec3,
    /// First triangle of a leaf node, and their number; 0 in inner nodes.
    first: usize,
    count: usize,
    /// Node after this one's subtree.
    next: usize,
}

/// Position of a ball, and the normal at its last contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Contact {
    pub(super) place: DVec3,
    pub(super) normal: DVec3,
}

/// The triangles alone: names of bakes depend on them.
impl fmt::Debug for Obstacles {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_tuple("Obstacles").field(&self.triangles).finish()
    }
}

impl Obstacles {
    pub(in crate::inside::scene) fn new(triangles: &[Triangle]) -> Self {
        let on_grid = |corner: DVec3| (corner * GRID_PER_M).round() / GRID_PER_M;
        let mut triangles: Vec<Triangle> = triangles.iter().map(|corners| corners.map(on_grid)).collect();
        let mut nodes = Vec::new();
        if !triangles.is_empty() {
            grow(&mut nodes, &mut triangles, 0);
        }
        Self { triangles, nodes }
    }

    /// Path of a ball between two places; `None` if it is free.
    pub(super) fn slide(&self, from: DVec3, to: DVec3, radius_m: f64) -> Option<Contact> {
        let way = to - from;
        self.nearest(from, way.length() + radius_m)?;
        // In steps of half a radius, so that its centre never crosses a surface.
        let steps = (2.0 * way.length() / radius_m).ceil().max(1.0);
        let mut place = from;
        let mut touched = None;
        for _ in 0..steps as usize {
            place += way / steps;
            for _ in 0..PUSHES {
                let Some(near) = self.nearest(place, radius_m * (1.0 - 1e-9)) else { break };
                let Some(normal) = (place - near).try_normalize() else { break };
                place = near + normal * radius_m;
                touched = Some(normal);
            }
        }
        touched.map(|normal| Contact { place, normal })
    }

    /// Nearest point of the surfaces, within a distance.
    pub(super) fn nearest(&self, place: DVec3, within_m: f64) -> Option<DVec3> {
        let (mut least_squared, mut nearest) = (within_m * within_m, None);
        let mut at = 0;
        while let Some(node) = self.nodes.get(at) {
            if place.clamp(node.low, node.high).distance_squared(place) >= least_squared {
                at = node.next;
                continue;
            }
            for triangle in &self.triangles[node.first..node.first + node.count] {
                let near = nearest_in(triangle, place);
                let squared = near.distance_squared(place);
                if squared < least_squared {
                    (least_squared, nearest) = (squared, Some(near));
                }
            }
            at += 1;
        }
        nearest
    }
}

/// Appends the nodes of the triangles from `first` on, and sorts these.
fn grow(nodes: &mut Vec<Node>, triangles: &mut [Triangle], first: usize) {
    let corners = || triangles.iter().flatten().copied();
    let low = corners().fold(DVec3::INFINITY, DVec3::min);
    let high = corners().fold(DVec3::NEG_INFINITY, DVec3::max);
    let place = nodes.len();
    let is_leaf = triangles.len() <= TRIANGLES_PER_LEAF;
    let count = if is_leaf { triangles.len() } else { 0 };
    nodes.push(Node { low, high, first, count, next: 0 });
    if !is_leaf {
        let size = high - low;
        let axis = (0..3).max_by(|&a, &b| size[a].total_cmp(&size[b])).unwrap_or(0);
        let middle = |triangle: &Triangle| triangle.iter().map(|corner| corner[axis]).sum::<f64>();
        let half = triangles.len() / 2;
        triangles.select_nth_unstable_by(half, |a, b| middle(a).total_cmp(&middle(b)));
        let (left, right) = triangles.split_at_mut(half);
        grow(nodes, left, first);
        grow(nodes, right, first + half);
    }
    nodes[place].next = nodes.len();
}

/// Nearest point of a triangle (Ericson, Real-Time Collision Detection, 2005, section 5.1.5).
fn nearest_in(&[a, b, c]: &Triangle, place: DVec3) -> DVec3 {
    let (ab, ac) = (b - a, c - a);
    let from_a = place - a;
    let (d1, d2) = (ab.dot(from_a), ac.dot(from_a));
    if d1 <= 0.0 && d2 <= 0.0 {
        return a;
    }
    let from_b = place - b;
    let (d3, d4) = (ab.dot(from_b), ac.dot(from_b));
    if d3 >= 0.0 && d4 <= d3 {
        return b;
    }
    let from_c = place - c;
    let (d5, d6) = (ab.dot(from_c), ac.dot(from_c));
    if d6 >= 0.0 && d5 <= d6 {
        return c;
    }
    let (of_a, of_b, of_c) = (d3 * d6 - d5 * d4, d5 * d2 - d1 * d6, d1 * d4 - d3 * d2);
    if of_c <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        return a + ab * (d1 / (d1 - d3));
    }
    if of_b <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        return a + ac * (d2 / (d2 - d6));
    }
    if of_a <= 0.0 && d4 >= d3 && d5 >= d6 {
        let along = (d4 - d3) / ((d4 - d3) + (d5 - d6));
        return b + (c - b) * along;
    }
    let over = (of_a + of_b + of_c).recip();
    a + ab * (of_b * over) + ac * (of_c * over)
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::math::Chance;

    fn place(item: u32, size: f64) -> DVec3 {
        let chance = Chance::of(5, item);
        (DVec3::new(chance.at(0), chance.at(1), chance.at(2)) - 0.5) * size
    }

    fn triangles() -> Vec<Triangle> {
        (0..300)
            .map(|item| [0, 1, 2].map(|corner| place(item, 4.0) + place(1000 + 3 * item + corner, 0.7)))
            .collect()
    }

    #[test]
    fn the_nearest_place_is_the_nearest_of_all_triangles() {
        let triangles = triangles();
        let obstacles = Obstacles::new(&triangles);
        for item in 5000..6000 {
            let from = place(item, 5.0);
            let all = obstacles.triangles.iter().map(|triangle| nearest_in(triangle, from).distance(from));
            let least = all.fold(f64::INFINITY, f64::min);
            let found = obstacles.nearest(from, 0.3).map(|near| near.distance(from));
            assert_eq!(found, (least < 0.3).then_some(least));
        }
    }

    #[test]
    fn the_nearest_point_of_a_triangle_is_nearer_than_any_sample() {
        for (item, triangle) in (0..).zip(triangles()) {
            let from = place(9000 + item, 4.0);
            let near = nearest_in(&triangle, from).distance(from);
            let mut least = f64::INFINITY;
            for i in 0..=60 {
                for j in 0..=60 - i {
                    let (u, v) = (f64::from(i) / 60.0, f64::from(j) / 60.0);
                    let sample = triangle[0] * (1.0 - u - v) + triangle[1] * u + triangle[2] * v;
                    least = least.min(sample.distance(from));
                }
            }
            assert!(near <= least + 1e-12 && near > least - 0.03, "{near} {least}");
        }
    }

    #[test]
    fn a_ball_slides_along_a_wall_and_does_not_go_through() {
        let wall = [
            [DVec3::new(0.0, -9.0, -9.0), DVec3::new(0.0, 9.0, -9.0), DVec3::new(0.0, 9.0, 9.0)],
            [DVec3::new(0.0, -9.0, -9.0), DVec3::new(0.0, 9.0, 9.0), DVec3::new(0.0, -9.0, 9.0)],
        ];
        let obstacles = Obstacles::new(&wall);
        // However far it would go in one step.
        let from = DVec3::new(-1.0, 0.0, 0.0);
        let Contact { place, normal } = obstacles.slide(from, DVec3::new(2.0, 3.0, 0.0), 0.1).unwrap();
        assert!((place - DVec3::new(-0.1, 3.0, 0.0)).length() < 1e-9, "{place}");
        assert!((normal - DVec3::NEG_X).length() < 1e-9, "{normal}");
        assert_eq!(obstacles.slide(from, DVec3::new(-0.2, 3.0, 0.0), 0.1), None);
        assert_eq!(Obstacles::default().slide(from, -from, 0.1), None);
    }
}
