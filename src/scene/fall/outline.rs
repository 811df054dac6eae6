//! What falling needs to know of a leaf's mesh. In go vertices, out come points that may touch the ground
//! and the two ways in which they lie on it. Invariant: relative to the middle of their box.

use glam::{DVec2, DVec3};

/// A mesh with more vertices than this is taken for its box.
const MOST_POINTS: usize = 400;
/// No leaf lies steeper on its own points than this slope.
const STEEPEST: f64 = 3.0;

/// Of a mesh that lies flat, its length along z.
#[derive(Clone, Debug)]
pub(in crate::scene) struct Outline {
    pub(super) points: Vec<DVec3>,
    pub(super) middle: DVec3,
    pub(super) size: DVec3,
    /// What points up when it lies with its upper side up, and with it down.
    pub(super) rests: [DVec3; 2],
}

impl Outline {
    /// `None` of a mesh without length or width.
    pub(in crate::scene) fn new(vertices: impl Iterator<Item = DVec3> + Clone) -> Option<Self> {
        let low = vertices.clone().fold(DVec3::INFINITY, DVec3::min);
        let high = vertices.clone().fold(DVec3::NEG_INFINITY, DVec3::max);
        let (middle, size) = (0.5 * (low + high), high - low);
        let points: Vec<DVec3> = if vertices.clone().nth(MOST_POINTS).is_none() {
            vertices.map(|vertex| vertex - middle).collect()
        } else {
            let corner = |number: u32, bit: u32| if number >> bit & 1 == 0 { -0.5 } else { 0.5 };
            let corner = |number| DVec3::new(corner(number, 0), corner(number, 1), corner(number, 2));
            (0..8).map(|number| corner(number) * size).collect()
        };
        let rests = [support(&points, 1.0), -support(&points, -1.0)];
        (size.x > 0.0 && size.z > 0.0).then_some(Self { points, middle, size, rests })
    }
}

/// Normal of the plane under the points (`side` 1) or over them (-1) that is nearest to their mean: what a
/// body comes to rest on, three of its points with its weight between them.
fn support(points: &[DVec3], side: f64) -> DVec3 {
    let mean = points.iter().sum::<DVec3>() / points.len() as f64;
    let depth = |slope: DVec2| {
        let below = points.iter().map(|&point| {
            let from_mean = point - mean;
            slope.x * from_mean.x + slope.y * from_mean.z - side * from_mean.y
        });
        below.fold(f64::NEG_INFINITY, f64::max)
    };
    // Convex in both slopes, so that thirds may be thrown away one after another.
    let best_y = |x: f64| least(|y| depth(DVec2::new(x, y)));
    let x = least(|x| depth(DVec2::new(x, best_y(x))));
    DVec3::new(-side * x, 1.0, -side * best_y(x)).normalize()
}

/// Where a convex function is least.
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
        let outline = Outline::new(points.into_iter().map(|(x, y, z)| DVec3::new(x, y, z))).unwrap();
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
}
