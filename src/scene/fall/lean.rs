//! Lean of a stiff leaf. In go lower bounds of its points' heights, out comes the plane that rests on them:
//! on three contacts around its centre of mass. Invariant: it uses only sums, products and quotients.

use glam::{DVec2, DVec3};

/// Maximum number of exchanges of a contact for a higher one.
const MOST_EXCHANGES: usize = 100;
/// Initial contacts, so far away and so deep that they are soon exchanged; relative to the reach.
const FAR: f64 = 100.0;
const STEEPEST: f64 = 3.0;

/// Slopes along x and z of the plane above all points (x, height, z) that is lowest at the origin.
///
/// It contains a face of the points' convex hull, above the origin. Starting from any three contacts around
/// the origin, the point farthest above the plane replaces one of them. Each exchange raises the plane at the
/// origin.
pub(super) fn slopes(points: &[DVec3]) -> DVec2 {
    let flat = |point: DVec3| DVec2::new(point.x, point.z);
    let reach = points.iter().map(|&point| flat(point).length()).fold(f64::MIN_POSITIVE, f64::max);
    let far = |x: f64, z: f64| DVec3::new(FAR * reach * x, -FAR * reach * STEEPEST, FAR * reach * z);
    // In order around the origin, from x towards z.
    let mut contacts = [far(1.0, 0.0), far(-0.5, 0.75), far(-0.5, -0.75)];
    let mut slopes = DVec2::ZERO;
    for _ in 0..MOST_EXCHANGES {
        let [a, b, c] = contacts;
        let (ab, ac) = (b - a, c - a);
        let area = flat(ab).perp_dot(flat(ac));
        if area <= 1e-12 * reach * reach {
            break;
        }
        slopes = DVec2::new(ab.y * ac.z - ac.y * ab.z, ab.x * ac.y - ac.x * ab.y) / area;
        let above = |point: DVec3| point.y - a.y - slopes.dot(flat(point - a));
        let farthest = points.iter().copied().max_by(|&p, &q| above(p).total_cmp(&above(q)));
        let Some(farthest) = farthest.filter(|&point| above(point) > 1e-9 * reach) else { break };
        let to = flat(farthest);
        // Edge beyond which the origin lies, seen from the new contact.
        let sides = [(a, b, c), (b, c, a), (c, a, b)];
        let kept = sides
            .into_iter()
            .find(|&(from, next, _)| to.perp_dot(flat(from)) >= 0.0 && flat(next).perp_dot(to) >= 0.0);
        let Some((from, next, _)) = kept else { break };
        contacts = [farthest, from, next];
    }
    slopes
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::math::Chance;

    #[test]
    fn the_plane_lies_on_all_points_and_no_other_lies_lower() {
        for item in 0..300 {
            let chance = Chance::of(3, item);
            let point = |at: u64| {
                let [x, y, z] = [0, 1, 2].map(|axis| 2.0 * chance.at(3 * at + axis) - 1.0);
                DVec3::new(x, 0.5 * y, z)
            };
            let points: Vec<DVec3> = (0..60).map(point).collect();
            let height = |slopes: DVec2| {
                let over = points.iter().map(|point| point.y - slopes.dot(DVec2::new(point.x, point.z)));
                over.fold(f64::NEG_INFINITY, f64::max)
            };
            let found = slopes(&points);
            let least = height(found);
            for other in 0..200 {
                let off = DVec2::new(chance.at(1000 + 2 * other) - 0.5, chance.at(1001 + 2 * other) - 0.5);
                for size in [1e-3, 0.1, 1.0] {
                    assert!(height(found + size * off) >= least - 1e-9, "{item}: {found}");
                }
            }
        }
    }

    #[test]
    fn a_leaf_on_the_edge_of_another_leans_on_it() {
        // A step of 1 under the points with x > 0.5.
        let points: Vec<DVec3> = (-10..=10)
            .flat_map(|x| (-10..=10).map(move |z| (0.1 * f64::from(x), 0.1 * f64::from(z))))
            .map(|(x, z)| DVec3::new(x, if x > 0.45 { 1.0 } else { 0.0 }, z))
            .collect();
        // From its far edge at -1 to the step's at 0.5.
        assert!((slopes(&points) - DVec2::new(1.0 / 1.5, 0.0)).length() < 1e-9, "{}", slopes(&points));
        assert_eq!(slopes(&[]), DVec2::ZERO);
    }
}
