//! The scan line and the ray tracer see the same: two ways to the same picture that share no code.

use crate::checkout;
use crate::common::{INSTANT, add_light, camera_at, place};
use glam::{DAffine3, DQuat, DVec2, DVec3, Vec3};
use sunfleck::color::Rgb;
use sunfleck::description;
use sunfleck::math::Sampler;
use sunfleck::scanline;
use sunfleck::scene::{self, Instance, Lens, LightKind, Material, Mesh, Scene, Size, Track, Triangle};
use sunfleck::snapshot::{MeshTrees, Snapshot};

/// What two pictures have in common.
#[derive(Debug, Default)]
struct Agreement {
    pixels: usize,
    covered: usize,
    /// Pixels that see something else, by the scan line and by a ray.
    different: Vec<(usize, usize, Option<f64>, Option<f64>)>,
    largest_error: f64,
}

/// Every pixel's centre by the scan line and by a ray.
fn agreement(scene: &Scene, size: Size) -> Agreement {
    let trees = MeshTrees::new(scene);
    let snapshot = Snapshot::new(scene, &trees, 0, size.width as f64 / size.height as f64, INSTANT);
    let mut agreement = Agreement::default();
    for (index, drawn) in scanline::depths(&snapshot, size).into_iter().enumerate() {
        let (x, y) = (index % size.width, index / size.width);
        let ray =
            snapshot.view.ray((x as f64 + 0.5) / size.width as f64, (y as f64 + 0.5) / size.height as f64);
        let hit = snapshot.tree.nearest_hit(&ray, f64::INFINITY, None);
        let traced = hit.map(|hit| snapshot.view.depth(ray.at(hit.t)));
        agreement.pixels += 1;
        agreement.covered += usize::from(traced.is_some());
        let error = match (drawn, traced) {
            (None, None) => 0.0,
            (Some(drawn), Some(traced)) => (drawn - traced).abs() / traced,
            _ => f64::INFINITY,
        };
        if error <= 1e-9 {
            agreement.largest_error = agreement.largest_error.max(error);
        } else {
            agreement.different.push((x, y, drawn, traced));
        }
    }
    agreement
}

#[track_caller]
fn assert_same(what: &str, scene: &Scene, size: Size, least_covered: f64) {
    let found = agreement(scene, size);
    println!(
        "{what}: {} pixels, {} covered, {} differ; depths within {:.0e}",
        found.pixels,
        found.covered,
        found.different.len(),
        found.largest_error
    );
    assert!(found.different.is_empty(), "{what}: {:?}", &found.different[..found.different.len().min(5)]);
    assert!(found.covered as f64 >= least_covered * found.pixels as f64, "{what}: {} covered", found.covered);
}

fn load(path: &str) -> Scene {
    let path = checkout::file(path);
    scene::resolve(description::load(&path).unwrap(), None).unwrap().0
}

fn add_mesh(scene: &mut Scene, positions: Vec<Vec3>, triangles: &[[u32; 3]], world_from_mesh: DAffine3) {
    if scene.materials.is_empty() {
        scene.materials.push(Material::default());
    }
    let triangles = triangles.iter().map(|&vertices| Triangle { vertices, material: 0 }).collect();
    scene.meshes.push(Mesh { positions, triangles, ..Mesh::default() });
    let node = place(scene, world_from_mesh);
    let mesh = scene.meshes.len() - 1;
    scene.instances.push(Instance {
        node,
        mesh,
        material: None,
        leaf_id: mesh as u32 + 1,
        deformation: None,
    });
}

/// A ball of triangles that share their vertices.
fn ball(rings: u32, around: u32, bump: f32) -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let mut positions = Vec::new();
    for ring in 0..=rings {
        for step in 0..around {
            let (polar, azimuth) = (
                std::f32::consts::PI * ring as f32 / rings as f32,
                std::f32::consts::TAU * step as f32 / around as f32,
            );
            let radius = 1.0 + bump * (5.0 * azimuth).sin() * polar.sin();
            positions.push(
                radius * Vec3::new(polar.sin() * azimuth.cos(), polar.cos(), polar.sin() * azimuth.sin()),
            );
        }
    }
    let mut triangles = Vec::new();
    for ring in 0..rings {
        for step in 0..around {
            let (next, below) = ((step + 1) % around, around);
            let at = |ring: u32, step: u32| ring * below + step;
            triangles.push([at(ring, step), at(ring + 1, step), at(ring, next)]);
            triangles.push([at(ring, next), at(ring + 1, step), at(ring + 1, next)]);
        }
    }
    (positions, triangles)
}

const SIZE: Size = Size { width: 240, height: 160 };

#[test]
fn five_hundred_leaves() {
    assert_same(
        "leaves500",
        &load("tests/data/leaves500/leaves500.glb"),
        Size { width: 480, height: 270 },
        0.3,
    );
}

#[test]
fn closed_meshes_from_outside_and_from_within() {
    for eye in [DVec3::new(0.1, 0.2, 2.5), DVec3::new(0.1, 0.2, 0.3)] {
        let mut scene = camera_at(eye);
        let (positions, triangles) = ball(24, 32, 0.3);
        add_mesh(&mut scene, positions, &triangles, DAffine3::from_rotation_y(0.3));
        // From within there is surface everywhere: not one pixel is missing between two triangles.
        let within = eye.length() < 0.5;
        assert_same(
            if within { "within a ball" } else { "a ball" },
            &scene,
            SIZE,
            if within { 1.0 } else { 0.1 },
        );
    }
}

/// The camera stands on a ground that reaches to the horizon in front of it and behind, and in a thicket.
#[test]
fn triangles_that_reach_behind_the_eye() {
    let mut scene = camera_at(DVec3::new(0.0, 0.4, 0.0));
    let corner = |x: f32, z: f32| Vec3::new(3000.0 * x, 0.0, 3000.0 * z);
    let corners = vec![corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
    add_mesh(&mut scene, corners, &[[0, 1, 2], [0, 2, 3]], DAffine3::IDENTITY);
    let mut sampler = Sampler::new(5, 0, 0, 0);
    let mut soup = |count: u32, size: f64| -> Vec<Vec3> {
        let mut point = |scale: f64| {
            let ((x, y), z) = (sampler.next_2d(), sampler.next_1d());
            scale * (2.0 * DVec3::new(x, y, z) - 1.0)
        };
        (0..count)
            .flat_map(|_| {
                let middle = point(3.0);
                [0; 3].map(|_| (middle + point(size)).as_vec3())
            })
            .collect()
    };
    let positions = soup(60, 2.0);
    let triangles: Vec<[u32; 3]> =
        (0..60).map(|number| [3 * number, 3 * number + 1, 3 * number + 2]).collect();
    add_mesh(&mut scene, positions, &triangles, DAffine3::from_translation(DVec3::new(0.0, 1.0, 0.0)));
    assert_same("a thicket about the eye", &scene, SIZE, 0.9);
}

#[test]
fn needles() {
    let mut scene = camera_at(DVec3::new(0.0, 0.0, 3.0));
    let mut sampler = Sampler::new(9, 0, 0, 0);
    let mut positions = Vec::new();
    for _ in 0..300 {
        let ((x, y), (u, v)) = (sampler.next_2d(), sampler.next_2d());
        let from = DVec3::new(4.0 * x - 2.0, 4.0 * y - 2.0, 0.0);
        let along = DVec3::new(u - 0.5, v - 0.5, sampler.next_1d() - 0.5).normalize() * 3.0;
        positions
            .extend([from, from + along, from + along + DVec3::new(0.0, 3e-3, 1e-3)].map(|p| p.as_vec3()));
    }
    let triangles: Vec<[u32; 3]> =
        (0..300).map(|number| [3 * number, 3 * number + 1, 3 * number + 2]).collect();
    add_mesh(&mut scene, positions, &triangles, DAffine3::IDENTITY);
    assert_same("needles", &scene, SIZE, 0.01);
}

#[test]
fn a_scene_a_thousand_kilometres_from_the_origin() {
    let far = DVec3::new(1e6, -3e5, 7e5);
    let mut scene = camera_at(far + DVec3::new(0.0, 0.0, 2.5));
    for number in 0..8 {
        let (positions, triangles) = ball(12, 18, 0.2);
        let turn = DQuat::from_scaled_axis(DVec3::splat(f64::from(number)));
        let at = far
            + DVec3::new(
                0.4 * f64::from(number) - 1.4,
                0.1 * f64::from(number) - 0.3,
                -0.2 * f64::from(number),
            );
        add_mesh(
            &mut scene,
            positions,
            &triangles,
            DAffine3::from_scale_rotation_translation(DVec3::new(0.5, 0.4, 0.6), turn, at),
        );
    }
    assert_same("far away", &scene, SIZE, 0.05);
}

#[test]
fn parallel_rays_and_a_shifted_lens() {
    for (what, lens) in [
        ("orthographic", Lens::Orthographic { height_m: Track::from(2.5) }),
        ("shifted", Lens::Perspective { fov_y: Track::from(0.9) }),
    ] {
        let mut scene = camera_at(DVec3::new(0.3, 0.2, 0.6));
        scene.cameras[0].lens = lens;
        scene.cameras[0].shift = DVec2::new(0.15, -0.1);
        // Part of it is behind the camera's plane.
        for at in [DVec3::ZERO, DVec3::new(-0.6, 0.3, -2.0)] {
            let (positions, triangles) = ball(20, 28, 0.2);
            add_mesh(&mut scene, positions, &triangles, DAffine3::from_translation(at));
        }
        assert_same(what, &scene, SIZE, 0.3);
    }
}

/// Edges that run through pixels' centres: the centre belongs to the triangle, for both.
#[test]
fn edges_through_centres() {
    let mut scene = camera_at(DVec3::ZERO);
    let corner = |x: f32, y: f32| Vec3::new(x, y, -1.0);
    let corners = vec![corner(-0.5, -0.5), corner(0.0, -0.5), corner(0.0, 0.5), corner(-0.5, 0.5)];
    add_mesh(&mut scene, corners, &[[0, 1, 2], [0, 2, 3]], DAffine3::IDENTITY);
    // In these the upright edge, and in the second the others too, lie on centres.
    for (width, height) in [(5, 4), (6, 6), (9, 9), (7, 7), (33, 33)] {
        assert_same("edges through centres", &scene, Size { width, height }, 0.1);
    }
    let trees = MeshTrees::new(&scene);
    let snapshot = Snapshot::new(&scene, &trees, 0, 1.0, INSTANT);
    let drawn = scanline::depths(&snapshot, Size { width: 9, height: 9 });
    let middle: Vec<bool> = drawn[4 * 9..5 * 9].iter().map(Option::is_some).collect();
    assert_eq!(middle, [false, false, true, true, true, false, false, false, false]);
}

/// A square that the sun shines on straight: its radiance is albedo / pi of the irradiance, times the fog's
/// transmittance; and a half-covered pixel is half of it.
#[test]
fn colours_are_those_of_the_light_and_edges_are_smooth() {
    let mut scene = camera_at(DVec3::ZERO);
    let corners = [(-1.0, -1.0), (0.0, -1.0), (0.0, 1.0), (-1.0, 1.0)].map(|(x, y)| Vec3::new(x, y, -1.0));
    add_mesh(&mut scene, corners.to_vec(), &[[0, 1, 2], [0, 2, 3]], DAffine3::IDENTITY);
    scene.materials[0].base_color = Rgb::new(0.5, 0.25, 0.75);
    add_light(&mut scene, LightKind::Sun, DVec3::ZERO, DVec3::NEG_Z, Rgb::splat(2.0));
    let draw = |scene: &Scene| {
        let trees = MeshTrees::new(scene);
        let snapshot = Snapshot::new(scene, &trees, 0, 1.0, INSTANT);
        scanline::draw(&snapshot, Size { width: 5, height: 5 })
    };
    let frame = draw(&scene);
    for (name, albedo) in [("R", 0.5), ("G", 0.25), ("B", 0.75)] {
        let row: Vec<f64> =
            frame.channel(name).unwrap().pixels[10..15].iter().map(|&value| f64::from(value)).collect();
        let full = 2.0 * albedo / std::f64::consts::PI;
        for (value, share) in row.iter().zip([1.0, 1.0, 0.5, 0.0, 0.0]) {
            assert!((value - share * full).abs() < 1e-6, "{name}: {row:?}");
        }
    }
    assert_eq!(frame.channel("A").unwrap().pixels[10..15], [1.0, 1.0, 0.5, 0.0, 0.0]);
    crate::common::add_fog(
        &mut scene,
        DVec3::splat(-9.0),
        DVec3::splat(9.0),
        Rgb::splat(0.7),
        Rgb::ZERO,
        0.0,
    );
    let dimmed = draw(&scene).channel("R").unwrap().pixels[11];
    let way = (1.0 + 0.4_f64.powi(2)).sqrt();
    let expected = (-0.7 * way).exp() / std::f64::consts::PI;
    // Shaded at the pixel's first sample, a little off its centre.
    assert!((f64::from(dimmed) / expected - 1.0).abs() < 0.05, "{dimmed} {expected}");
}

/// Panes before one another, in any order of drawing: the farthest is weakened by all before it.
#[test]
fn blended_surfaces_are_sorted() {
    let mut scene = camera_at(DVec3::ZERO);
    let corners = |z: f32| {
        [(-9.0, -9.0), (9.0, -9.0), (9.0, 9.0), (-9.0, 9.0)].map(|(x, y)| Vec3::new(x, y, z)).to_vec()
    };
    let shine = [(2.0, 0.25, Rgb::X), (1.0, 0.5, Rgb::Y), (3.0, 1.0, Rgb::Z)];
    for (number, (distance, alpha, emission)) in shine.into_iter().enumerate() {
        add_mesh(&mut scene, corners(-distance), &[[0, 1, 2], [0, 2, 3]], DAffine3::IDENTITY);
        let alpha_mode = if alpha < 1.0 { scene::AlphaMode::Blend } else { scene::AlphaMode::Opaque };
        scene.materials.push(Material { emission, opacity: alpha, alpha_mode, ..Material::default() });
        scene.instances[number].material = Some(number + 1);
    }
    let trees = MeshTrees::new(&scene);
    let snapshot = Snapshot::new(&scene, &trees, 0, 1.0, INSTANT);
    let frame = scanline::draw(&snapshot, Size { width: 3, height: 3 });
    let seen = ["R", "G", "B"].map(|name| frame.channel(name).unwrap().pixels[4]);
    assert_eq!(seen, [0.5 * 0.25, 0.5, 0.5 * 0.75]);
}

#[test]
fn threads_do_not_show() {
    let scene = load("scenes/first_leaf/scene.ron");
    let trees = MeshTrees::new(&scene);
    let snapshot = Snapshot::new(&scene, &trees, 0, 1.5, INSTANT);
    let draw = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| scanline::draw(&snapshot, SIZE))
    };
    assert_eq!(draw(1), draw(3));
}
