//! Masked cards as they are rendered: rays against the texture's own alpha.

use crate::common::{EXACT, INSTANT};
use glam::{DVec2, DVec3, Vec2};
use std::collections::BTreeSet;
use std::f64::consts::TAU;
use std::path::Path;
use sunfleck::math::{Ray, Sampler};
use sunfleck::scene::{OUTLINE_TOLERANCE_TEXELS, Scene};
use sunfleck::snapshot::{MeshTrees, Snapshot};
use sunfleck::transport::{Scratch, radiance};
use sunfleck::{description, scene};

const SIZE: u32 = 96;

/// A heart with soft edges and a hole.
fn alpha(p: DVec2) -> f64 {
    let q = (p / f64::from(SIZE) - DVec2::new(0.5, 0.55)) * DVec2::new(2.6, -2.6);
    let heart = (q.length_squared() - 1.0).powi(3) - q.x * q.x * q.y.powi(3);
    let hole = (p - DVec2::new(40.0, 52.0)).length() - 9.0;
    (0.5 - 6.0 * heart).min(0.5 + 0.5 * hole).clamp(0.0, 1.0)
}

/// The scene of a card from -2 to 2 on the ground, seen from 5 m above it.
fn card(folder: &Path, material: &str) -> Scene {
    card_showing(folder, alpha, material)
}

/// The same with any alpha, of places in texels.
fn card_showing(folder: &Path, alpha: impl Fn(DVec2) -> f64, material: &str) -> Scene {
    let image = image::RgbaImage::from_fn(SIZE, SIZE, |x, y| {
        let texel = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
        image::Rgba([200, 120, 40, (255.0 * alpha(texel)).round() as u8])
    });
    image.save(folder.join("heart.png")).unwrap();
    let text = format!(
        "Scene(version: 1, meshes: {{ \"card\": Quad(size_m: 4.0) }}, materials: {{ \"heart\": (texture: \"heart.png\", {material}) }},
        objects: {{ \"card\": (mesh: \"card\", material: \"heart\"), \"again\": (mesh: \"card\", material: \"heart\", translation_m: (9.0, 0.0, 0.0)) }},
        lights: {{ \"sun\": Sun(to_sun: (0.0, 1.0, 0.0), irradiance_w_per_m2: 1.0) }},
        cameras: {{ \"main\": (position_m: (0.0, 5.0, 0.0), rotation_deg: (-90.0, 0.0, 0.0)) }})"
    );
    let path = folder.join("scene.ron");
    std::fs::write(&path, text).unwrap();
    let description = description::load(&path).map_err(|error| error.diagnostics().to_string()).unwrap();
    scene::resolve(description, None).map_err(|error| error.to_string()).unwrap().0
}

#[test]
fn rays_meet_what_the_texture_shows() {
    let folder = tempfile::tempdir().unwrap();
    for (material, cutoff) in [("alpha_cutoff: 0.5", 0.5), ("alpha_cutoff: 0.3, opacity: 0.5", 0.6)] {
        let scene = card(folder.path(), material);
        assert_eq!(scene.instances[0].mesh, scene.instances[1].mesh, "cut once");
        assert!(scene.remarks.to_string().contains("`card` from 2 triangles to "), "{}", scene.remarks);
        let snapshot = Snapshot::new(&scene, &MeshTrees::new(&scene), 0, 1.0, INSTANT);
        assert!(!snapshot.has_blended());
        let (mut scratch, mut sampler) = (Scratch::default(), Sampler::new(3, 0, 0, 0));
        let (mut shown, mut near) = (0, 0);
        let count = 20_000;
        for _ in 0..count {
            let (u, v) = sampler.next_2d();
            let place = DVec3::new(4.0 * u - 2.0, -5.0, 4.0 * v - 2.0);
            let ray = Ray { origin: DVec3::ZERO, direction: place.normalize() };
            let found = radiance(&snapshot, &EXACT, &ray, &mut sampler, &mut scratch).surface.is_some();
            let texel = DVec2::new(u, v) * f64::from(SIZE);
            let value = |texel: DVec2| {
                let uv: Vec2 = (texel / f64::from(SIZE)).as_vec2();
                scene.textures[0].alpha(uv)
            };
            let expected = value(texel) >= cutoff;
            let around = (0..12).map(|step| DVec2::from_angle(f64::from(step) * std::f64::consts::PI / 6.0));
            if around
                .into_iter()
                .any(|to| (value(texel + 1.2 * OUTLINE_TOLERANCE_TEXELS * to) >= cutoff) != expected)
            {
                near += 1;
                continue;
            }
            assert_eq!(found, expected, "at texel {texel}");
            shown += usize::from(found);
        }
        assert!(shown > count / 5 && near < count / 20, "{shown} shown, {near} near the edge");
    }
}

/// A closed curve: how far inside a point is, in texels (negative outside, exact near the curve), and
/// points all along it.
struct Shape {
    name: &'static str,
    inside: fn(DVec2) -> f64,
    curve: fn(f64) -> DVec2,
}

const MIDDLE: DVec2 = DVec2::new(48.3, 47.8);

/// Half axes of the ellipse, which is turned.
const HALF_AXES: DVec2 = DVec2::new(38.0, 14.0);
const TURN: DVec2 = DVec2::new(0.8, 0.6);

/// By Newton's steps along the gradient of the implicit function: exact to second order in the distance.
fn inside_ellipse(p: DVec2) -> f64 {
    let q = DVec2::new(TURN.x, -TURN.y).rotate(p - MIDDLE);
    let value = (q / HALF_AXES).length_squared() - 1.0;
    let gradient = 2.0 * q / (HALF_AXES * HALF_AXES);
    -value / gradient.length().max(1e-9)
}

/// A leaf of five lobes between notches: its radius by angle, and how that changes.
fn lobes(angle: f64) -> (f64, f64) {
    (30.0 + 9.0 * (5.0 * angle).cos(), -45.0 * (5.0 * angle).sin())
}

fn inside_leaf(p: DVec2) -> f64 {
    let away = p - MIDDLE;
    let (radius, slope) = lobes(away.to_angle());
    (radius - away.length()) / (1.0 + (slope / radius).powi(2)).sqrt()
}

const SHAPES: [Shape; 3] = [
    Shape {
        name: "disc",
        inside: |p| 30.0 - p.distance(MIDDLE),
        curve: |turn| MIDDLE + 30.0 * DVec2::from_angle(TAU * turn),
    },
    Shape {
        name: "ellipse",
        inside: inside_ellipse,
        curve: |turn| MIDDLE + TURN.rotate(HALF_AXES * DVec2::from_angle(TAU * turn)),
    },
    Shape {
        name: "leaf of five lobes",
        inside: inside_leaf,
        curve: |turn| MIDDLE + lobes(TAU * turn).0 * DVec2::from_angle(TAU * turn),
    },
];

/// Alpha of an edge one texel wide in 8 bits: how far the outline is from the shape and the shape
/// from the outline, and how much area it has more, all in texels. What the bilinear texture
/// itself is off by is in it.
#[test]
fn outlines_keep_to_shapes_in_area_and_edge() {
    let folder = tempfile::tempdir().unwrap();
    for Shape { name, inside, curve } in SHAPES {
        let scene = card_showing(folder.path(), |p| (0.5 + inside(p)).clamp(0.0, 1.0), "alpha_cutoff: 0.5");
        let mesh = &scene.meshes[scene.instances[0].mesh];
        let corner = |vertex: u32| mesh.uvs[vertex as usize].as_dvec2() * f64::from(SIZE);
        let triangles: Vec<[u32; 3]> = mesh.triangles.iter().map(|triangle| triangle.vertices).collect();
        let area: f64 = triangles
            .iter()
            .map(|triangle| triangle.map(corner))
            .map(|[a, b, c]| 0.5 * (b - a).perp_dot(c - a))
            .sum::<f64>()
            .abs();
        let edges: BTreeSet<(u32, u32)> =
            triangles.iter().flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)]).collect();
        let outline: Vec<[DVec2; 2]> = edges
            .iter()
            .filter(|(from, to)| !edges.contains(&(*to, *from)))
            .map(|&(from, to)| [corner(from), corner(to)])
            .collect();
        let count = 4000;
        let points: Vec<DVec2> = (0..count).map(|i| curve(f64::from(i) / f64::from(count))).collect();
        let to_segment = |p: DVec2, [from, to]: [DVec2; 2]| {
            let share = ((p - from).dot(to - from) / (to - from).length_squared()).clamp(0.0, 1.0);
            p.distance(from.lerp(to, share))
        };
        let to_outline =
            |p: &DVec2| outline.iter().map(|edge| to_segment(*p, *edge)).fold(f64::MAX, f64::min);
        let to_shape = |p: DVec2| points.iter().map(|point| p.distance(*point)).fold(f64::MAX, f64::min);
        let along =
            |[from, to]: &[DVec2; 2]| (0..=8).map(|i| from.lerp(*to, f64::from(i) / 8.0)).collect::<Vec<_>>();
        let shape_off = points.iter().step_by(5).map(to_outline).fold(0.0, f64::max);
        let outline_off = outline.iter().flat_map(along).map(to_shape).fold(0.0, f64::max);
        let pairs = || (0..points.len()).map(|i| (points[i], points[(i + 1) % points.len()]));
        let exact: f64 = 0.5 * pairs().map(|(a, b)| a.perp_dot(b)).sum::<f64>();
        let length: f64 = pairs().map(|(a, b)| a.distance(b)).sum();
        let wider = (area - exact) / length;
        println!(
            "{name}: outline off by {outline_off:.3} texels at most, shape by {shape_off:.3}; area {area:.1}, exact {exact:.1}: \
             wider by {wider:+.4} texels all around; {} triangles",
            triangles.len()
        );
        let farthest = OUTLINE_TOLERANCE_TEXELS + OF_THE_TEXTURE;
        assert!(outline_off < farthest && shape_off < farthest, "{name}");
        assert!(wider < 0.01 && wider > -NARROWER, "{name}: {wider}");
    }
}

/// How far the curve where the bilinear 8-bit alpha is 1/2 may lie from the shape, texels.
const OF_THE_TEXTURE: f64 = 0.07;
/// How much narrower an outline may be all around, texels: chords of a curve lie within it.
const NARROWER: f64 = 0.06;

#[test]
fn masks_that_show_all_or_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let all = card(folder.path(), "alpha_cutoff: 0.0");
    assert_eq!(all.meshes[all.instances[0].mesh].triangles.len(), 2);
    assert!(!all.remarks.to_string().contains("masked meshes"));
    let nothing = card(folder.path(), "alpha_cutoff: 0.5, opacity: 0.2");
    assert!(nothing.instances.is_empty());
    assert!(nothing.remarks.to_string().contains("`card` from 2 triangles to 0"), "{}", nothing.remarks);
}
