//! Cutting of triangles along rings, in texels. In go rings and triangles, out come smaller triangles of old
//! and new vertices. Invariant: all coordinates are integers of one grid, so shared points agree to the last
//! bit.

use super::{Between, Outlined};
use glam::DVec2;
use i_triangle::i_overlay::core::fill_rule::FillRule;
use i_triangle::i_overlay::core::overlay::Overlay;
use i_triangle::i_overlay::core::overlay_rule::OverlayRule;
use i_triangle::i_overlay::i_float::int::point::IntPoint;
use i_triangle::int::triangulatable::IntTriangulatable;
use std::collections::HashMap;
use std::rc::Rc;

/// Resolution of the grid. Within `FARTHEST_TEXEL` coordinates have at most 28 bits.
const STEPS_PER_TEXEL: f64 = 1024.0;

type Point = IntPoint<i32>;

/// Rest of a triangle after cutting, in the order of its corners' grid points.
#[derive(Debug)]
enum Rest {
    All,
    Parts { points: Vec<Point>, triangles: Vec<[u32; 3]> },
}

pub(super) struct Cutter {
    rings: Vec<Ring>,
    /// Cache, as triangles at the same place of the texture have the same rest.
    known: HashMap<[Point; 3], Rc<Rest>>,
    /// New vertices on edges, by the edge's vertices.
    on_edges: HashMap<(u32, u32, Point), u32>,
    added: Vec<Between>,
    triangles: Vec<Corners>,
}

/// Corner: an old vertex, or the index of a new one.
type Corners = [Result<u32, u32>; 3];

struct Ring {
    points: Vec<Point>,
    low: Point,
    high: Point,
}

impl Cutter {
    pub(super) fn new(rings: impl Iterator<Item = Vec<DVec2>>) -> Self {
        let rings = rings.map(|ring| {
            let points: Vec<Point> = ring.into_iter().map(on_grid).collect();
            let bound = |x: fn(i32, i32) -> i32| {
                points
                    .iter()
                    .copied()
                    .reduce(|a, b| Point::new(x(a.x, b.x), x(a.y, b.y)))
                    .unwrap_or(Point::ZERO)
            };
            Ring { low: bound(i32::min), high: bound(i32::max), points }
        });
        Self {
            rings: rings.collect(),
            known: HashMap::new(),
            on_edges: HashMap::new(),
            added: Vec::new(),
            triangles: Vec::new(),
        }
    }

    /// Adds the rest of a triangle whose vertices lie at `texels`. A triangle without area there stays or
    /// goes as a whole, by `is_shown` at its centre.
    pub(super) fn cut(&mut self, vertices: [u32; 3], texels: [DVec2; 3], is_shown: impl Fn(DVec2) -> bool) {
        let corners = texels.map(on_grid);
        if twice_area(corners) == 0 {
            if is_shown((texels[0] + texels[1] + texels[2]) / 3.0) {
                self.triangles.push(vertices.map(Ok));
            }
            return;
        }
        let rest = self.known.get(&corners).map(Rc::clone).unwrap_or_else(|| {
            let rest = Rc::new(rest(&self.rings, corners));
            self.known.insert(corners, Rc::clone(&rest));
            rest
        });
        match &*rest {
            Rest::All => self.triangles.push(vertices.map(Ok)),
            Rest::Parts { points, triangles } => {
                let vertices: Vec<_> =
                    points.iter().map(|&point| self.vertex(vertices, corners, point)).collect();
                let triangles =
                    triangles.iter().map(|triangle| triangle.map(|point| vertices[point as usize]));
                self.triangles.extend(triangles.filter(|[a, b, c]| a != b && b != c && c != a));
            }
        }
    }

    fn vertex(&mut self, vertices: [u32; 3], corners: [Point; 3], point: Point) -> Result<u32, u32> {
        if let Some(corner) = corners.iter().position(|&corner| corner == point) {
            return Ok(vertices[corner]);
        }
        for (from, to) in [(0, 1), (1, 2), (2, 0)] {
            // The neighbour has the same edge in the other direction.
            let (from, to) = if vertices[from] < vertices[to] { (from, to) } else { (to, from) };
            let (a, b) = (difference(corners[from], corners[to]), difference(corners[from], point));
            let length_squared = dot(a, a);
            // Within the rounding of the grid.
            if (cross(a, b) as f64).powi(2) <= 2.0 * length_squared as f64 {
                let key = (vertices[from], vertices[to], point);
                let added = &mut self.added;
                return Err(*self.on_edges.entry(key).or_insert_with(|| {
                    let t = dot(a, b) as f64 / length_squared as f64;
                    added.push(Between {
                        corners: [vertices[from], vertices[to], vertices[to]],
                        weights: [1.0 - t, t, 0.0],
                    });
                    added.len() as u32 - 1
                }));
            }
        }
        let [a, b, c] = corners;
        let whole = twice_area(corners) as f64;
        let weights =
            [[point, b, c], [a, point, c], [a, b, point]].map(|part| twice_area(part) as f64 / whole);
        self.added.push(Between { corners: vertices, weights });
        Err(self.added.len() as u32 - 1)
    }

    /// Rests of all triangles of a mesh with `vertices` vertices.
    pub(super) fn finish(self, vertices: usize) -> Outlined {
        let number = |corner: Result<u32, u32>| corner.unwrap_or_else(|added| vertices as u32 + added);
        let triangles = self.triangles.iter().map(|corners| corners.map(number)).collect();
        Outlined { added: self.added, triangles }
    }
}

fn rest(rings: &[Ring], corners: [Point; 3]) -> Rest {
    let [a, b, c] = corners;
    let low = Point::new(a.x.min(b.x).min(c.x), a.y.min(b.y).min(c.y));
    let high = Point::new(a.x.max(b.x).max(c.x), a.y.max(b.y).max(c.y));
    let meets = |ring: &&Ring| {
        ring.low.x <= high.x && ring.high.x >= low.x && ring.low.y <= high.y && ring.high.y >= low.y
    };
    let rings: Vec<Vec<Point>> =
        rings.iter().filter(meets).map(|ring| shortened(&ring.points, low, high)).collect();
    let triangle = vec![corners.to_vec()];
    let shapes =
        Overlay::from_subj_and_clip(&rings, &triangle).overlay(OverlayRule::Intersect, FillRule::EvenOdd);
    if let [shape] = shapes.as_slice()
        && let [outline] = shape.as_slice()
        && outline.len() == 3
        && corners.iter().all(|corner| outline.contains(corner))
    {
        return Rest::All;
    }
    let mesh = shapes.triangulate().into_delaunay().into_triangulation::<u32>();
    let turn = |triangle: &[u32]| {
        let [a, b, c] = [triangle[0], triangle[1], triangle[2]];
        let same = twice_area([a, b, c].map(|point| mesh.points[point as usize])) > 0;
        // Keeps the orientation.
        if same == (twice_area(corners) > 0) { [a, b, c] } else { [a, c, b] }
    };
    let triangles = mesh.indices.chunks_exact(3).map(turn).collect();
    Rest::Parts { points: mesh.points, triangles }
}

/// Ring without its detours beyond one edge of a box. Within the box it encloses the same points, by parity.
/// So many triangles under one long ring cost only the part that each of them meets.
fn shortened(ring: &[Point], low: Point, high: Point) -> Vec<Point> {
    // Outcode: the sides of the box beyond which a point lies (Cohen and Sutherland).
    let beyond = |point: Point| {
        let sides = [point.x < low.x, point.x > high.x, point.y < low.y, point.y > high.y];
        sides.into_iter().fold(0_u8, |code, is_beyond| code << 1 | u8::from(is_beyond))
    };
    let mut kept: Vec<Point> = Vec::new();
    // Outcode bits common to all points since the last kept one, inclusive.
    let mut common = 0;
    let mut passed = None;
    for &point in ring {
        let code = beyond(point);
        if common & code == 0
            && let Some(last) = passed.take()
        {
            kept.push(last);
            common = beyond(last);
        }
        if common & code == 0 {
            kept.push(point);
            common = code;
        } else {
            passed = Some(point);
            common &= code;
        }
    }
    kept.extend(passed);
    kept
}

fn on_grid(texel: DVec2) -> Point {
    let steps = (texel * STEPS_PER_TEXEL).round();
    Point::new(steps.x as i32, steps.y as i32)
}

fn difference(from: Point, to: Point) -> [i64; 2] {
    [i64::from(to.x) - i64::from(from.x), i64::from(to.y) - i64::from(from.y)]
}

fn cross(a: [i64; 2], b: [i64; 2]) -> i64 {
    a[0] * b[1] - a[1] * b[0]
}

fn dot(a: [i64; 2], b: [i64; 2]) -> i64 {
    a[0] * b[0] + a[1] * b[1]
}

fn twice_area([a, b, c]: [Point; 3]) -> i64 {
    cross(difference(a, b), difference(a, c))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn point() -> impl Strategy<Value = Point> {
        (-9_i32..=9, -9_i32..=9).prop_map(|(x, y)| Point::new(x, y))
    }

    /// Twice the signed area that a ring has in a box: of the ring clipped at one side after the other
    /// (Sutherland and Hodgman).
    fn area_within(ring: &[Point], low: Point, high: Point) -> f64 {
        let mut polygon: Vec<DVec2> = ring.iter().map(|p| DVec2::new(p.x.into(), p.y.into())).collect();
        for (side, limit) in
            [(DVec2::X, -low.x), (-DVec2::X, high.x), (DVec2::Y, -low.y), (-DVec2::Y, high.y)]
        {
            let inside = |p: DVec2| p.dot(side) + f64::from(limit);
            let before = polygon.clone();
            polygon.clear();
            for (i, &b) in before.iter().enumerate() {
                let a = before[(i + before.len() - 1) % before.len()];
                if inside(a) * inside(b) < 0.0 {
                    polygon.push(a.lerp(b, inside(a) / (inside(a) - inside(b))));
                }
                if inside(b) >= 0.0 {
                    polygon.push(b);
                }
            }
        }
        (0..polygon.len()).map(|i| polygon[i].perp_dot(polygon[(i + 1) % polygon.len()])).sum()
    }

    proptest! {
        #[test]
        fn detours_beyond_a_box_do_not_count_in_it(
            ring in prop::collection::vec(point(), 3..60),
            low in (-4_i32..0, -4_i32..0),
            high in (0_i32..4, 0_i32..4),
        ) {
            let (low, high) = (Point::new(low.0, low.1), Point::new(high.0, high.1));
            let short = shortened(&ring, low, high);
            prop_assert!(short.len() <= ring.len());
            let (a, b) = (area_within(&short, low, high), area_within(&ring, low, high));
            prop_assert!((a - b).abs() < 1e-9, "{a} {b} {short:?}");
        }
    }

    #[test]
    fn a_long_way_round_is_left_out() {
        let ring: Vec<Point> = (0..1000)
            .map(|i| Point::new(100 + i % 7, i - 500))
            .chain([Point::new(-5, 500), Point::new(-5, -500)])
            .collect();
        let short = shortened(&ring, Point::new(-10, -10), Point::new(10, 10));
        assert!(short.len() < 10, "{short:?}");
    }
}
