//! Outline of a leaf's mesh for falling. In go vertices and triangles, out come points for contacts, the two
//! poses at rest, and the blade. Invariant: all are relative to the centre of their box.

use super::ground::height_in;
use glam::{DVec2, DVec3};
use std::collections::BTreeSet;

/// Maximum number of vertices; larger meshes are replaced by their box.
const MOST_POINTS: usize = 400;
/// Maximum slope of a leaf that rests on its own points.
const STEEPEST: f64 = 3.0;

/// Outline of a flat mesh, with its length along z.
#[derive(Clone, Debug)]
pub(in crate::inside::scene) struct Outline {
    pub(super) points: Vec<DVec3>,
    pub(super) triangles: Vec<[DVec3; 3]>,
    pub(super) middle: DVec3,
    pub(super) size: DVec3,
    /// Up directions at rest, with its upper side up, and down.
    pub(super) rests: [DVec3; 2],
}

impl Outline {
    /// Outline of a mesh; `None` without length or width.
    pub(in crate::inside::scene) fn new(vertices: &[DVec3], triangles: &[[u32; 3]]) -> Option<Self> {
        let low = vertices.iter().copied().fold(DVec3::INFINITY, DVec3::min);
        let high = vertices.iter().copied().fold(DVec3::NEG_INFINITY, DVec3::max);
        let (middle, size) = (0.5 * (low + high), high - low);
        let corner = |vertex: u32| vertices[vertex as usize] - middle;
        let triangles = triangles.iter().map(|corners| corners.map(corner)).collect();
        let points: Vec<DVec3> = if vertices.len() <= MOST_POINTS {
            vertices.iter().map(|&vertex| vertex - middle).collect()
        } else {
            let corner = |number: u32, bit: u32| if number >> bit & 1 == 0 { -0.5 } else { 0.5 };
            let corner = |number| DVec3::new(corner(number, 0), corner(number, 1), corner(number, 2));
            (0..8).map(|number| corner(number) * size).collect()
        };
        let rests = [support(&points, 1.0), -support(&points, -1.0)];
        (size.x > 0.0 && size.z > 0.0).then_some(Self { points, triangles, middle, size, rests })
    }

    /// Ratio of its width or thickness to its length.
    pub(in crate::inside::scene) fn width_to_length(&self) -> f64 {
        self.size.x.max(self.size.y) / self.size.z
    }

    /// Points all over the blade, `spacing` apart along x and z, and one of its vertices in every cube of
    /// that size.
    pub(super) fn sampled(&self, spacing: f64) -> Vec<DVec3> {
        let cube = |point: DVec3| (point / spacing).to_array().map(|along| along.floor() as i64);
        let mut taken = BTreeSet::new();
        let corners = self.triangles.iter().flatten().copied();
        let mut points: Vec<DVec3> = corners.filter(|&corner| taken.insert(cube(corner))).collect();
        for triangle in &self.triangles {
            let flat = triangle.map(|corner| DVec2::new(corner.x, corner.z) / spacing);
            let low = flat[0].min(flat[1]).min(flat[2]).ceil().as_i64vec2();
            let high = flat[0].max(flat[1]).max(flat[2]).floor().as_i64vec2();
            for at in (low.x..=high.x).flat_map(|x| (low.y..=high.y).map(move |z| [x, z])) {
                let [x, z] = at.map(|at| at as f64 * spacing);
                points.extend(height_in(*triangle, DVec2::new(x, z)).map(|y| DVec3::new(x, y, z)));
            }
        }
        points
    }
}

/// Normal of the plane below the points (`side` 1) or above them (-1) that is nearest to their mean. This is
/// the rest of a rigid body: three contacts around its centre of mass.
fn support(points: &[DVec3], side: f64) -> DVec3 {
    let mean = points.iter().sum::<DVec3>() / points.len() as f64;
    let depth = |slope: DVec2| {
        let below = points.iter().map(|&point| {
            let from_mean = point - mean;
            slope.x * from_mean.x + slope.y * from_mean.z - side * from_mean.y
        });
        below.fold(f64::NEG_INFINITY, f64::max)
    };
    // Convex in both slopes, so ternary search applies.
    let best_y = |x: f64| least(|y| depth(DVec2::new(x, y)));
    let x = least(|x| depth(DVec2::new(x, best_y(x))));
    DVec3::new(-side * x, 1.0, -side * best_y(x)).normalize()
}

/// Minimum of a convex function.
fn least(of: impl Fn(f64) -> f64) -> f64 {
    let (mut low, mut high) = (-STEEPEST, STEEPEST);
    for _ in 0..40 {
        let (left, right) = (low + (high - low) / 3.0, high - (high - low) / 3.0);
        if of(left) <= of(right) { high = right } else { low = left }
    }
    0.5 * (low + high)
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn a_leaf_with_a_stalk_lies_on_its_end_and_two_tips() {
        // A square blade with a stalk that hangs down behind it.
        let points =
            [(-1.0, 0.0, -1.0), (1.0, 0.0, -1.0), (-1.0, 0.0, 1.0), (1.0, 0.0, 1.0), (0.0, -1.0, 2.0)];
        let outline = Outline::new(&points.map(|(x, y, z)| DVec3::new(x, y, z)), &[]).unwrap();
        let [upright, upside_down] = outline.rests;
        // On the stalk's end and the tips at z = -1: down by 1 over 3.
        assert!((upright - DVec3::new(0.0, 3.0, 1.0).normalize()).length() < 1e-6, "{upright}");
        assert!((upside_down - DVec3::NEG_Y).length() < 1e-6, "{upside_down}");
        let touching = |up: DVec3| {
            let low = outline.points.iter().map(|point| point.dot(up)).fold(f64::INFINITY, f64::min);
            outline.points.iter().filter(|point| point.dot(up) < low + 1e-5).count()
        };
        assert!(touching(upright) == 3 && touching(upside_down) == 4);
    }

    #[test]
    fn samples_are_all_over_the_blade() {
        // A roof: down to both sides of its ridge along z.
        let corners = [
            (-1.0, 0.0, -2.0),
            (0.0, 0.5, -2.0),
            (1.0, 0.0, -2.0),
            (-1.0, 0.0, 2.0),
            (0.0, 0.5, 2.0),
            (1.0, 0.0, 2.0),
        ];
        let triangles = [[0, 1, 3], [1, 4, 3], [1, 2, 4], [2, 5, 4]];
        let outline = Outline::new(&corners.map(|(x, y, z)| DVec3::new(x, y, z)), &triangles).unwrap();
        let points = outline.sampled(0.125);
        for point in &points {
            assert!((point.y - (0.25 - 0.5 * point.x.abs())).abs() < 1e-9, "{point}");
        }
        let near = |x: f64, z: f64| {
            points.iter().any(|point| (point.x - x).abs() < 0.0626 && (point.z - z).abs() < 0.0626)
        };
        assert!(
            (0..=100)
                .all(|at| (0..=100).all(|row| near(0.02 * f64::from(at) - 1.0, 0.04 * f64::from(row) - 2.0)))
        );
        assert!(points.len() < 700, "{}", points.len());
    }
}
