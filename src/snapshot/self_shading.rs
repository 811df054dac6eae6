//! Self-shading of a part. In go triangles, out comes the share of its area that is not shaded by others of
//! them. Invariant: nothing is random, so a mesh always has the same share.
//!
//! A part much smaller than a cell is area in a turbid medium, which stops as much light as its projection
//! does. For a bent leaf the sum of its triangles' projections is larger, and for a closed body twice as
//! large.

use glam::DVec3;
use std::f64::consts::TAU;

/// Maximum number of places on a part, with two directions from each; fewer where there are many triangles.
const PLACES: usize = 256;
const FEWEST_PLACES: usize = 16;
/// Maximum number of places times triangles, over all parts of a mesh.
const MOST_TESTS: usize = 20_000_000;
/// Projected share of the area above which a part counts as flat, without self-shading.
const FLAT: f64 = 1.0 - 1e-6;

/// Share of a part's area on both sides that is not shaded, weighted by the cosine of the direction. The part
/// is one of `parts` of its mesh.
pub(super) fn exposed(triangles: &[[DVec3; 3]], areas: &[f64], parts: usize) -> f64 {
    let whole: f64 = areas.iter().sum();
    let facing: DVec3 = triangles.iter().map(|[a, b, c]| 0.5 * (b - a).cross(c - a)).sum();
    if !(whole > 0.0 && whole.is_finite()) || facing.length() >= FLAT * whole {
        return 1.0;
    }
    let count = (MOST_TESTS / parts / triangles.len()).clamp(FEWEST_PLACES, PLACES);
    let step = whole / count as f64;
    let (mut triangle, mut passed, mut open) = (0, 0.0, 0);
    for number in 0..count {
        let mark = (number as f64 + 0.5) * step;
        while triangle + 1 < triangles.len() && passed + areas[triangle] < mark {
            passed += areas[triangle];
            triangle += 1;
        }
        let (origin, direction) = look(&triangles[triangle], number);
        let is_open = |way: DVec3| {
            let mut others = triangles.iter().enumerate().filter(|(other, _)| *other != triangle);
            !others.any(|(_, other)| is_hit(other, origin, way))
        };
        open += usize::from(is_open(direction)) + usize::from(is_open(-direction));
    }
    open as f64 / (2 * count) as f64
}

/// A place on a triangle, and a cosine-distributed direction.
fn look([a, b, c]: &[DVec3; 3], number: usize) -> (DVec3, DVec3) {
    /// The root of `x^5 = x + 1`, whose powers are the steps of an additive recurrence in four dimensions
    /// (Roberts 2018, "The unreasonable effectiveness of quasirandom sequences").
    const ROOT: f64 = 1.167_303_978_261_418_7;
    let [u, v, w, angle] = [1, 2, 3, 4].map(|power| (0.5 + number as f64 * ROOT.powi(-power)).fract());
    let root = u.sqrt();
    let origin = (1.0 - root) * *a + root * (1.0 - v) * *b + root * v * *c;
    let normal = (b - a).cross(c - a).normalize_or_zero();
    let (right, up) = normal.any_orthonormal_pair();
    let (sin, cos) = (TAU * angle).sin_cos();
    (origin, w.sqrt() * (cos * right + sin * up) + (1.0 - w).sqrt() * normal)
}

/// Whether a ray meets a triangle (Möller & Trumbore 1997).
fn is_hit([a, b, c]: &[DVec3; 3], origin: DVec3, direction: DVec3) -> bool {
    let (ab, ac) = (b - a, c - a);
    let across = direction.cross(ac);
    let determinant = ab.dot(across);
    if determinant == 0.0 {
        return false;
    }
    let start = origin - a;
    let u = start.dot(across) / determinant;
    // Most rays miss already here.
    if !(0.0..=1.0).contains(&u) {
        return false;
    }
    let along = start.cross(ab);
    let v = direction.dot(along) / determinant;
    v >= 0.0 && u + v <= 1.0 && ac.dot(along) / determinant > 0.0
}

#[cfg(test)]
mod tests {
    use super::*;

    fn exposed_of(triangles: &[[DVec3; 3]]) -> f64 {
        let area = |[a, b, c]: &[DVec3; 3]| 0.5 * (b - a).cross(c - a).length();
        exposed(triangles, &triangles.iter().map(area).collect::<Vec<_>>(), 1)
    }

    /// A sheet along z, bent about it, with these points as its cross-section.
    fn sheet(across: &[(f64, f64)]) -> Vec<[DVec3; 3]> {
        let strip = |pair: &[(f64, f64)]| {
            let at = |(x, y): (f64, f64), z: f64| DVec3::new(x, y, z);
            let (a, b, c, d) = (at(pair[0], -50.0), at(pair[1], -50.0), at(pair[1], 50.0), at(pair[0], 50.0));
            [[a, b, c], [a, c, d]]
        };
        across.windows(2).flat_map(strip).collect()
    }

    #[test]
    fn what_is_flat_hides_nothing() {
        assert_eq!(exposed_of(&sheet(&[(0.0, 0.0), (1.0, 0.0), (3.0, 0.0)])), 1.0);
    }

    /// By perimeters (Crofton): a line meets a long convex trough whenever it meets the trough's hull. For
    /// half a tube of radius 1 the share is `(pi + 2) / (2 pi)`.
    #[test]
    fn half_a_tube_stops_light_as_its_hull_does() {
        let arc: Vec<(f64, f64)> =
            (0..=64).map(|step| (0.5 * TAU * f64::from(step) / 64.0).sin_cos()).collect();
        let expected = (0.5 * TAU + 2.0) / TAU;
        let found = exposed_of(&sheet(&arc));
        assert!((found - expected).abs() < 0.02, "{found} {expected}");
    }
}
