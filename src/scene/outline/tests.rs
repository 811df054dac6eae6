//! Tests of outlines against analytic shapes, and against the texture at points.

use super::*;
use crate::diagnostic::Loss;
use crate::math::Sampler;
use crate::scene::Wrap;
use proptest::prelude::*;
use std::collections::HashMap;
use std::f64::consts::PI;

fn cut_out(mesh: &Mesh, mask: Mask) -> Result<Mesh, Loss> {
    traced_cut_out(mesh, mask).map(|(mesh, _)| mesh)
}

fn texture(size: usize, wrap: Wrap, alpha: impl Fn(DVec2) -> f64) -> Texture {
    let texel = |index: usize| DVec2::new((index % size) as f64 + 0.5, (index / size) as f64 + 0.5);
    let texels = (0..size * size).map(|index| [1.0, 1.0, 1.0, alpha(texel(index)).clamp(0.0, 1.0) as f32]);
    Texture { name: String::new(), width: size, height: size, texels: texels.collect(), wrap: [wrap; 2] }
}

/// Triangles whose positions are their texture coordinates.
fn flat(uvs: Vec<Vec2>, triangles: &[[u32; 3]]) -> Mesh {
    Mesh {
        positions: uvs.iter().map(|uv| uv.extend(0.0)).collect(),
        uvs,
        triangles: triangles.iter().map(|&vertices| Triangle { vertices, material: 3 }).collect(),
        ..Mesh::default()
    }
}

fn card() -> Mesh {
    flat(vec![Vec2::ZERO, Vec2::X, Vec2::ONE, Vec2::Y], &[[0, 1, 2], [0, 2, 3]])
}

fn corners(mesh: &Mesh) -> impl Iterator<Item = [DVec2; 3]> {
    mesh.triangles.iter().map(|t| t.vertices.map(|v| mesh.uvs[v as usize].as_dvec2()))
}

fn area(mesh: &Mesh) -> f64 {
    corners(mesh).map(|[a, b, c]| 0.5 * (b - a).perp_dot(c - a)).sum()
}

/// Number of a mesh's triangles that hold a point.
fn covering(mesh: &Mesh, point: DVec2) -> usize {
    let holds = |[a, b, c]: [DVec2; 3]| {
        let sides = [(a, b), (b, c), (c, a)].map(|(from, to)| (to - from).perp_dot(point - from));
        sides.iter().all(|side| *side > 0.0) || sides.iter().all(|side| *side < 0.0)
    };
    corners(mesh).filter(|&triangle| holds(triangle)).count()
}

/// The farthest that any edge without a neighbour, but for the card's own, lies from a curve.
fn worst_edge(mesh: &Mesh, texels: f64, distance: impl Fn(DVec2) -> f64) -> f64 {
    let mut edges = HashMap::new();
    for [a, b, c] in mesh.triangles.iter().map(|t| t.vertices) {
        for (from, to) in [(a, b), (b, c), (c, a)] {
            assert!(edges.insert((from, to), ()).is_none(), "an edge is there twice");
        }
    }
    let open = edges.keys().filter(|(from, to)| !edges.contains_key(&(*to, *from)));
    let samples = open.flat_map(|&(from, to)| {
        let [from, to] = [from, to].map(|v| mesh.uvs[v as usize].as_dvec2());
        (0..=8).map(move |step| from.lerp(to, f64::from(step) / 8.0) * texels)
    });
    let inner = samples.filter(|p| p.min_element() > 1e-3 && p.max_element() < texels - 1e-3);
    inner.map(|point| distance(point).abs()).fold(0.0, f64::max)
}

#[test]
fn a_disc_in_a_card() {
    for (size, radius) in [(64, 20.0), (256, 100.0), (32, 3.0)] {
        let centre = DVec2::splat(0.5 * size as f64) + DVec2::new(0.3, -0.2);
        let disc = texture(size, Wrap::Clamp, |p| 0.5 + radius - p.distance(centre));
        let cut = cut_out(&card(), Mask::new(&disc, 0.5, 1.0)).unwrap();
        let texels = size as f64;
        let worst = worst_edge(&cut, texels, |point| point.distance(centre) - radius);
        assert!(worst < OUTLINE_TOLERANCE_TEXELS + 0.06, "{worst} texels off");
        let off = area(&cut) * texels * texels - PI * radius * radius;
        assert!(off.abs() < OUTLINE_TOLERANCE_TEXELS * 2.0 * PI * radius, "{off} square texels off");
        // About as many as a polygon that keeps to the tolerance needs: r (1 - cos(pi / n)) = tolerance.
        let sides = PI / (1.0 - OUTLINE_TOLERANCE_TEXELS / radius).acos();
        assert!((cut.triangles.len() as f64) < 3.0 * sides + 10.0, "{}", cut.triangles.len());
        assert!(cut.triangles.iter().all(|triangle| triangle.material == 3));
    }
}

/// A leaf with a pointed tip: |x| = w sin(pi y).
#[test]
fn a_leaf_in_a_card() {
    let inside = |p: DVec2| {
        let (x, y) = ((p.x - 64.0).abs(), (p.y / 128.0).clamp(0.0, 1.0));
        let (half, slope) = (40.0 * (PI * y).sin(), 40.0 * PI / 128.0 * (PI * y).cos());
        (half - x) / (1.0 + slope * slope).sqrt()
    };
    let leaf = texture(128, Wrap::Clamp, |p| 0.5 + inside(p));
    for opacity in [1.0, 0.7] {
        let cut = cut_out(&card(), Mask::new(&leaf, 0.5 * opacity, opacity)).unwrap();
        let worst = worst_edge(&cut, 128.0, |p| if (2.0..126.0).contains(&p.y) { inside(p) } else { 0.0 });
        assert!(worst < OUTLINE_TOLERANCE_TEXELS + 0.1, "{worst} texels off");
        let exact = 2.0 * 40.0 * 128.0 * 2.0 / PI;
        let off = area(&cut) * 128.0 * 128.0 / exact - 1.0;
        assert!(off.abs() < 0.01, "{off}");
    }
}

#[test]
fn what_nothing_hides_stays_as_it_is() {
    let half = texture(64, Wrap::Clamp, |p| if p.x < 32.0 { 1.0 } else { 0.0 });
    let left = flat(vec![Vec2::ZERO, Vec2::new(0.4, 0.0), Vec2::new(0.1, 0.9)], &[[0, 1, 2]]);
    let cut = cut_out(&left, Mask::new(&half, 0.5, 1.0)).unwrap();
    assert_eq!((&cut.uvs, &cut.triangles), (&left.uvs, &left.triangles));
    let right = flat(vec![Vec2::new(0.6, 0.0), Vec2::X, Vec2::ONE], &[[0, 1, 2]]);
    assert!(cut_out(&right, Mask::new(&half, 0.5, 1.0)).unwrap().triangles.is_empty());
    let none = Mask::new(&half, 0.5, 0.0);
    assert!(cut_out(&left, none).unwrap().triangles.is_empty());
    let all = Mask::new(&half, 0.0, 0.0);
    assert_eq!(cut_out(&right, all).unwrap().triangles, right.triangles);
}

/// Triangles without area in the texture show what the texture has there, or nothing.
#[test]
fn triangles_on_a_line_of_the_texture() {
    let half = texture(64, Wrap::Clamp, |p| if p.x < 32.0 { 1.0 } else { 0.0 });
    for (x, shown) in [(0.2, 1), (0.8, 0)] {
        let line = flat(vec![Vec2::new(x, 0.1), Vec2::new(x, 0.5), Vec2::new(x, 0.9)], &[[0, 1, 2]]);
        let cut = cut_out(&line, Mask::new(&half, 0.5, 1.0)).unwrap();
        assert_eq!(cut.triangles.len(), shown);
    }
}

#[test]
fn coordinates_without_measure_are_refused() {
    let half = texture(64, Wrap::Repeat, |p| p.x / 64.0);
    for far in [1e9, f32::MAX] {
        let mesh = flat(vec![Vec2::ZERO, Vec2::X * far, Vec2::Y], &[[0, 1, 2]]);
        assert_eq!(cut_out(&mesh, Mask::new(&half, 0.5, 1.0)).unwrap_err(), Loss::MaskTooWide);
    }
}

#[test]
fn noise_is_refused() {
    let checkers = texture(800, Wrap::Clamp, |p| (p.x + p.y + 0.5).floor() % 2.0);
    assert_eq!(cut_out(&card(), Mask::new(&checkers, 0.5, 1.0)).unwrap_err(), Loss::MaskTooFine);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    /// Bumpy textures, wrapped in all ways, on pairs of triangles anywhere: a point is covered once if the
    /// texture shows it, else not at all, except as near to the curve as the tolerance.
    #[test]
    fn outlines_show_what_the_texture_shows(
        waves in prop::array::uniform3((1..4_i32, 1..4_i32, 0.0..6.3_f64)),
        points in prop::array::uniform4(prop::array::uniform2(-1.6..2.6_f32)),
        wrap in prop::sample::select(vec![Wrap::Repeat, Wrap::Clamp, Wrap::Mirror]),
        cutoff in 0.2..0.8_f64,
        seed in 0..1000_u32,
    ) {
        let size = 48;
        let alpha = |p: DVec2| {
            let term = |(x, y, phase): (i32, i32, f64)| {
                (2.0 * PI / size as f64 * (f64::from(x) * p.x + f64::from(y) * p.y) + phase).sin()
            };
            0.5 + 0.3 * waves.into_iter().map(term).sum::<f64>()
        };
        let texture = texture(size, wrap, alpha);
        let [a, b, c, d] = points.map(Vec2::from);
        // Two triangles on either side of the edge a b.
        let side = |p: Vec2| (b - a).perp_dot(p - a);
        prop_assume!(side(c) * side(d) < -0.01);
        let mesh = flat(vec![a, b, c, d], &[[0, 1, 2], [1, 0, 3]]);
        let cut = cut_out(&mesh, Mask::new(&texture, cutoff, 1.0)).unwrap();
        let mut sampler = Sampler::new(seed, 0, 0, 0);
        let (low, high) = (a.min(b).min(c).min(d).as_dvec2(), a.max(b).max(c).max(d).as_dvec2());
        for _ in 0..400 {
            let (u, v) = sampler.next_2d();
            let point = low + DVec2::new(u, v) * (high - low);
            let at = |offset: DVec2| texture.alpha((point + offset / size as f64).as_vec2()) - cutoff;
            let near = 1.5 * OUTLINE_TOLERANCE_TEXELS;
            let around = (0..16).map(|step| at(near * DVec2::from_angle(PI / 8.0 * f64::from(step))));
            let shown = at(DVec2::ZERO) >= 0.0;
            if around.into_iter().any(|value| (value >= 0.0) != shown) {
                continue;
            }
            let expected = if shown { covering(&mesh, point) } else { 0 };
            prop_assert_eq!(covering(&cut, point), expected, "{} in {} triangles", point, cut.triangles.len());
        }
        // The edge in the middle is passed without a crack: both sides have its points in common.
        let mut edges = HashMap::new();
        for [a, b, c] in cut.triangles.iter().map(|t| t.vertices) {
            for (from, to) in [(a, b), (b, c), (c, a)] {
                prop_assert!(edges.insert((from, to), ()).is_none(), "an edge is there twice");
            }
        }
    }
}
