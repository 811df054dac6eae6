//! Triangulation of planar polygons. In go corners, out come triangles. Invariant: they use all corners, do
//! not overlap, and keep the orientation, so neighbouring polygons still share whole edges.
//!
//! The method is ear clipping (Meisters 1975) of the polygon's projection along its Newell normal. Collinear
//! corners are kept: dropping them would open cracks towards the neighbours.

use glam::{DVec2, DVec3};

/// Triangles as indices into a polygon's corners.
pub(super) struct Triangulated {
    pub(super) triangles: Vec<[usize; 3]>,
    /// False if the outline crosses itself, so that no triangulation is right.
    pub(super) simple: bool,
}

/// Triangulates a polygon of at least three corners; `None` if it has no area.
pub(super) fn triangulate(corners: &[DVec3]) -> Option<Triangulated> {
    let normal = newell_normal(corners);
    normal.try_normalize()?;
    if corners.len() == 3 {
        return Some(Triangulated { triangles: vec![[0, 1, 2]], simple: true });
    }
    let flat: Vec<DVec2> = corners.iter().map(|corner| drop_longest_axis(*corner, normal)).collect();
    Some(clip_ears(&flat))
}

/// Twice the polygon's area along its normal (Sutherland et al. 1974), about its first corner.
pub(super) fn newell_normal(corners: &[DVec3]) -> DVec3 {
    let first = corners.first().copied().unwrap_or_default();
    corners.windows(2).map(|edge| (edge[0] - first).cross(edge[1] - first)).sum()
}

/// Projects along the axis nearest to `normal`, and keeps the orientation.
fn drop_longest_axis(point: DVec3, normal: DVec3) -> DVec2 {
    let size = normal.abs();
    if size.x >= size.y && size.x >= size.z {
        DVec2::new(point.y, point.z * normal.x.signum())
    } else if size.y >= size.z {
        DVec2::new(point.z, point.x * normal.y.signum())
    } else {
        DVec2::new(point.x, point.y * normal.z.signum())
    }
}

/// Twice the signed area of a triangle.
fn area(a: DVec2, b: DVec2, c: DVec2) -> f64 {
    (b - a).perp_dot(c - a)
}

fn clip_ears(points: &[DVec2]) -> Triangulated {
    let mut left: Vec<usize> = (0..points.len()).collect();
    let mut triangles = Vec::with_capacity(points.len() - 2);
    let mut simple = true;
    let mut start = 0;
    while left.len() > 3 {
        let ear =
            (0..left.len()).map(|step| (start + step) % left.len()).find(|&at| is_ear(points, &left, at));
        // Without an ear the outline crosses itself: any corner is cut, and the author gets a warning.
        simple &= ear.is_some();
        let at = ear.unwrap_or(0);
        triangles.push(around(&left, at));
        left.remove(at);
        // Continuing after the ear gives rounder triangles than a fan from one corner.
        start = (at + 1) % left.len();
    }
    triangles.push([left[0], left[1], left[2]]);
    Triangulated { triangles, simple }
}

/// Corner at `at` between its neighbours.
fn around(left: &[usize], at: usize) -> [usize; 3] {
    let count = left.len();
    [left[(at + count - 1) % count], left[at], left[(at + 1) % count]]
}

fn is_ear(points: &[DVec2], left: &[usize], at: usize) -> bool {
    let corners @ [a, b, c] = around(left, at).map(|index| points[index]);
    area(a, b, c) > 0.0
        && !left.iter().map(|&index| points[index]).any(|point| {
            !corners.contains(&point)
                && area(a, b, point) >= 0.0
                && area(b, c, point) >= 0.0
                && area(c, a, point) >= 0.0
        })
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Sum of the triangles' areas against the polygon's, all triangles facing the same way:
    /// only then do they neither overlap nor leave a gap.
    fn assert_exact_cover(corners: &[DVec3]) {
        let normal = newell_normal(corners);
        let Triangulated { triangles, simple } = triangulate(corners).unwrap();
        assert!(simple);
        assert_eq!(triangles.len(), corners.len() - 2);
        let mut covered = 0.0;
        for triangle in triangles {
            let part = newell_normal(&triangle.map(|index| corners[index])).dot(normal.normalize());
            assert!(part > 0.0, "{triangle:?} is turned over or has no area");
            covered += part;
        }
        assert!((covered / normal.length() - 1.0).abs() < 1e-9);
    }

    fn on_a_tilted_plane(outline: &[(f64, f64)]) -> Vec<DVec3> {
        let (u, v) = (DVec3::new(2.0, 1.0, 0.5), DVec3::new(-0.3, 1.0, 3.0));
        outline.iter().map(|&(x, y)| u * x + v * y + DVec3::new(5.0, -7.0, 1.0)).collect()
    }

    #[test]
    fn an_arrowhead_is_not_cut_across_its_notch() {
        assert_exact_cover(&on_a_tilted_plane(&[(0.0, 0.0), (2.0, 1.0), (0.0, 2.0), (0.5, 1.0)]));
    }

    #[test]
    fn corners_on_a_straight_edge_are_all_used() {
        let square = [(0.0, 0.0), (1.0, 0.0), (2.0, 0.0), (2.0, 2.0), (1.0, 2.0), (0.0, 2.0), (0.0, 1.0)];
        let corners = square.map(|(x, y)| DVec3::new(x, y, 0.0));
        assert_exact_cover(&corners);
    }

    #[test]
    fn a_comb_with_many_teeth_is_covered() {
        let mut outline = vec![(0.0, 0.0), (40.0, 0.0)];
        for tooth in (0..20).rev() {
            let x = 2.0 * f64::from(tooth);
            outline.extend([(x + 1.0, 5.0), (x, 1.0)]);
        }
        outline.pop();
        assert_exact_cover(&on_a_tilted_plane(&outline));
    }

    #[test]
    fn a_bow_tie_is_told_and_a_line_has_no_triangles() {
        let bow = [(0.0, 0.0), (1.0, 1.0), (1.0, 0.0), (0.0, 2.0), (-1.0, -3.0), (4.0, 0.5)];
        assert!(!triangulate(&bow.map(|(x, y)| DVec3::new(x, y, 0.0))).unwrap().simple);
        assert!(triangulate(&[DVec3::ZERO, DVec3::X, 2.0 * DVec3::X, 3.0 * DVec3::X]).is_none());
    }

    proptest! {
        #[test]
        fn star_shaped_polygons_are_covered_exactly(radii in prop::collection::vec(0.1_f64..1.0, 4..40)) {
            let count = radii.len() as f64;
            let outline: Vec<_> = radii.iter().enumerate().map(|(index, radius)| {
                let (sin, cos) = (std::f64::consts::TAU * index as f64 / count).sin_cos();
                (radius * cos, radius * sin)
            }).collect();
            assert_exact_cover(&on_a_tilted_plane(&outline));
        }
    }
}
