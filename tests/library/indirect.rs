//! Light of all orders against closed forms, and against a path tracer that others wrote.

use crate::checkout;
use crate::common::{INSTANT, add_fog, add_light, camera_at, place};
use glam::{DAffine3, DVec3, Vec3};
use std::f64::consts::PI;
use sunfleck::color::Rgb;
use sunfleck::description;
use sunfleck::film::Frame;
use sunfleck::indirect::{Indirect, KeptLight};
use sunfleck::math::{Ray, Sampler};
use sunfleck::passes::Pass;
use sunfleck::render::{Job, Method, Rendered, Watch, render};
use sunfleck::scene::{
    self, AlphaMode, Bounces, Coat, FogShape, HeightFalloff, Instance, LightKind, Material, Mesh,
    PixelFilter, Sampling, Scene, Size, Sky, SkyPicture, Triangle, Window,
};
use sunfleck::snapshot::{Exposure, MeshTrees, Snapshot};
use sunfleck::transport::{Scratch, Transport, VolumeMethod, radiance};

pub(crate) const EVEN_SKY: SkyPicture =
    SkyPicture::Gradient { zenith: Rgb::ONE, horizon: Rgb::ONE, ground: Rgb::ONE };

/// A box with its faces outwards.
pub(crate) fn add_box(scene: &mut Scene, low: DVec3, high: DVec3, material: Material) {
    scene.materials.push(material);
    let corner = |number: usize| {
        DVec3::new(
            if number & 1 == 0 { low.x } else { high.x },
            if number & 2 == 0 { low.y } else { high.y },
            if number & 4 == 0 { low.z } else { high.z },
        )
        .as_vec3()
    };
    let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let material = scene.materials.len() - 1;
    let triangles = faces.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]);
    scene.meshes.push(Mesh {
        positions: (0..8).map(corner).collect(),
        triangles: triangles.map(|vertices| Triangle { vertices, material }).collect(),
        ..Mesh::default()
    });
    add_instance(scene);
}

pub(crate) fn add_instance(scene: &mut Scene) {
    let node = place(scene, DAffine3::IDENTITY);
    let (mesh, leaf_id) = (scene.meshes.len() - 1, scene.instances.len() as u32 + 1);
    scene.instances.push(Instance { node, mesh, material: None, leaf_id, deformation: None });
}

/// Square leaves of .2 m, turned and placed by a sequence without a pattern, in a cube of
/// 4 m before the camera.
pub(crate) fn add_leaves(scene: &mut Scene, count: usize, material: Material) {
    scene.materials.push(material);
    let material = scene.materials.len() - 1;
    let mut sampler = Sampler::new(7, 0, 0, 0);
    for _ in 0..count {
        let place = 4.0 * (DVec3::from(sampler.next_3d()) - 0.5) - 5.0 * DVec3::Z;
        let normal = (DVec3::from(sampler.next_3d()) - 0.5).normalize();
        add_leaf(scene, place, normal, material);
    }
}

/// One of them, of the number of a material.
pub(crate) fn add_leaf(scene: &mut Scene, place: DVec3, normal: DVec3, material: usize) {
    let (right, up) = normal.any_orthonormal_pair();
    let corner = |x: f64, y: f64| (place + 0.1 * (x * right + y * up)).as_vec3();
    scene.meshes.push(Mesh {
        positions: vec![corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)],
        triangles: [[0, 1, 2], [0, 2, 3]].map(|vertices| Triangle { vertices, material }).to_vec(),
        ..Mesh::default()
    });
    add_instance(scene);
}

/// One leaf that nobody sees, and a puff of fog, are no reason for larger cells of all others.
#[test]
fn strays_change_nothing() {
    let mut scene = camera_at(DVec3::ZERO);
    add_leaves(&mut scene, 300, Material { base_color: Rgb::splat(0.6), ..Material::default() });
    let middle = -5.0 * DVec3::Z;
    add_fog(&mut scene, middle - 3.0, middle + 3.0, Rgb::splat(0.1), Rgb::splat(0.9), 0.4);
    add_light(&mut scene, LightKind::Sun, DVec3::ZERO, DVec3::new(0.3, -1.0, -0.4), Rgb::ONE);
    scene.sky = Sky::new(EVEN_SKY);
    let expected = radiances(&scene, Bounces::All);
    for distance_m in [60.0, 1e3, 1e5] {
        let mut with = scene.clone();
        add_leaf(&mut with, distance_m * DVec3::Z, DVec3::X, 0);
        let corner = distance_m * DVec3::new(0.6, 0.0, 0.8);
        add_fog(&mut with, corner, corner + 1.0, Rgb::splat(0.1), Rgb::splat(0.9), 0.4);
        let found = radiances(&with, Bounces::All);
        let off = expected.iter().zip(&found).map(|(expected, found)| {
            ((*found - *expected) / expected.max(Rgb::splat(1e-3))).abs().max_element()
        });
        let worst = off.fold(0.0, f64::max);
        println!("strays {distance_m} m away: worst {worst:.1e}");
        assert!(worst < 3e-3, "{distance_m}: {worst}");
    }
}

/// Radiance of camera rays on a grid over the picture.
fn radiances(scene: &Scene, bounces: Bounces) -> Vec<Rgb> {
    let trees = MeshTrees::new(scene);
    let exposure = Exposure::new(scene, &trees, 0, 1.0, INSTANT);
    let snapshot = exposure.middle();
    let indirect = Indirect::new(&exposure, bounces, 1.0, &KeptLight::default(), &|| false);
    let transport = Transport {
        volume: VolumeMethod::Segments,
        mirror_depth: 0,
        indirect: indirect.as_ref(),
        features: true,
    };
    let ray = |number: usize| -> Ray {
        let along = |index: usize| ((index % 16) as f64 + 0.5) / 16.0;
        snapshot.view.ray(along(number), along(number / 16))
    };
    // What glows is looked for by rays of chance.
    const SAMPLES: u32 = 16;
    let of_sample = |number: usize, sample: u32| {
        let mut sampler = Sampler::new(0, number as u32, 0, sample);
        radiance(snapshot, &transport, &ray(number), &mut sampler, &mut Scratch::default()).radiance
    };
    let mean = |number: usize| {
        (0..SAMPLES).map(|sample| of_sample(number, sample)).sum::<Rgb>() / f64::from(SAMPLES)
    };
    (0..256).map(mean).collect()
}

fn worst_from(radiances: &[Rgb], expected: f64) -> f64 {
    radiances.iter().map(|radiance| (*radiance - expected).abs().max_element()).fold(0.0, f64::max)
}

/// Cells about those of dense fog are large, and black ground that only they have sends nothing back into it.
#[test]
fn wide_black_ground_does_not_light_fog() {
    let means = [3.0, 20.0].map(|reach_m| {
        let mut scene = camera_at(DVec3::ZERO);
        let middle = DVec3::new(0.0, 0.5, -5.0);
        add_fog(&mut scene, middle - 1.5, middle + 1.5, Rgb::splat(2.0), Rgb::ONE, 0.0);
        add_light(&mut scene, LightKind::Sun, DVec3::ZERO, DVec3::new(0.3, -1.0, 0.4), Rgb::ONE);
        let (low, high) =
            (DVec3::new(-reach_m, -1.5, -5.0 - reach_m), DVec3::new(reach_m, -1.0, reach_m - 5.0));
        add_box(&mut scene, low, high, Material { base_color: Rgb::ZERO, ..Material::default() });
        radiances(&scene, Bounces::All).iter().map(|radiance| radiance[1]).sum::<f64>()
    });
    let ratio = means[1] / means[0];
    println!("fog on wide ground beside narrow: {ratio:.4}");
    assert!((ratio - 1.0).abs() < 0.01, "{ratio}");
}

/// What absorbs nothing, in even light from all sides, cannot be seen.
#[test]
fn white_fog_in_a_furnace_is_not_seen() {
    // The last has hundreds of orders.
    for (density, g) in [(0.1, 0.0), (0.5, 0.6), (1.5, 0.3), (8.0, 0.0)] {
        let mut scene = camera_at(DVec3::ZERO);
        let middle = -5.0 * DVec3::Z;
        add_fog(&mut scene, middle - 2.0, middle + 2.0, Rgb::splat(density), Rgb::ONE, g);
        scene.sky = Sky::new(EVEN_SKY);
        let worst = worst_from(&radiances(&scene, Bounces::All), 1.0);
        println!("fog of {density} /m, g {g}: worst {worst:.2e}");
        assert!(worst < 1e-3, "{density}: {worst}");
    }
}

#[test]
fn white_leaves_in_a_furnace_are_not_seen() {
    for (count, reflectance) in [(200, 1.0), (800, 0.5)] {
        let mut scene = camera_at(DVec3::ZERO);
        let leaf = Material {
            base_color: Rgb::splat(reflectance),
            transmission: Rgb::splat(1.0 - reflectance),
            ..Material::default()
        };
        add_leaves(&mut scene, count, leaf);
        scene.sky = Sky::new(EVEN_SKY);
        let worst = worst_from(&radiances(&scene, Bounces::All), 1.0);
        println!("{count} leaves that reflect {reflectance}: worst {worst:.2e}");
        assert!(worst < 1e-3, "{count}: {worst}");
    }
}

/// The same where fog has no bounds: nested grids reach as far as it matters, and what is beyond
/// looks like the farthest.
#[test]
fn white_fog_without_bounds_in_a_furnace_is_not_seen() {
    for (density, scale_height_m) in [(0.05, 8.0), (0.3, 3.0)] {
        let mut scene = camera_at(DVec3::ZERO);
        let leaf = Material { base_color: Rgb::ONE, ..Material::default() };
        add_leaves(&mut scene, 50, leaf);
        add_fog(&mut scene, DVec3::splat(-1.0), DVec3::splat(1.0), Rgb::splat(density), Rgb::ONE, 0.3);
        scene.fogs[0].shape =
            FogShape::Layer(HeightFalloff { base: -2.0, scale_height_m: scale_height_m.into() });
        scene.sky = Sky::new(EVEN_SKY);
        let worst = worst_from(&radiances(&scene, Bounces::All), 1.0);
        println!("fog of {density} /m without bounds, {scale_height_m} m: worst {worst:.2e}");
        assert!(worst < 0.02, "{density}: {worst}");
    }
}

/// Metal sees an uneven sky by its lobe: as rays do that sample the lobe.
#[test]
fn metal_reflects_the_sky_as_sampled_rays_find_it() {
    for roughness in [1.0, 0.6, 0.3] {
        let mut scene = camera_at(DVec3::ZERO);
        let metal = Material {
            base_color: Rgb::ONE,
            coat: Some(Coat {
                metallic: 1.0,
                roughness,
                texture: None,
                f0: Rgb::splat(0.04),
                f0_texture: None,
                f90: 1.0,
            }),
            ..Material::default()
        };
        // Leant back by 45 degrees, so that the camera sees what is overhead in it.
        scene.materials.push(metal);
        let material = scene.materials.len() - 1;
        let corner = |x: f32, y: f32| glam::Vec3::new(4.0 * x, 3.0 * y, -6.0 - 3.0 * y);
        scene.meshes.push(Mesh {
            positions: vec![corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)],
            triangles: [[0, 1, 2], [0, 2, 3]].map(|vertices| Triangle { vertices, material }).to_vec(),
            ..Mesh::default()
        });
        add_instance(&mut scene);
        scene.sky = Sky::new(SkyPicture::Gradient {
            zenith: Rgb::new(1.0, 2.0, 3.0),
            horizon: Rgb::new(3.0, 2.0, 2.0),
            ground: Rgb::splat(0.5),
        });
        let mean = |bounces| {
            let frame = picture(&scene, bounces, Method::Segments);
            let pixels = (50..85).flat_map(|y| (80..160).map(move |x| (x, y)));
            let sum: Rgb = pixels.clone().map(|(x, y)| beauty(&frame, x, y)).sum();
            sum / pixels.count() as f64
        };
        let (field, sampled) = (mean(Bounces::All), mean(Bounces::NONE));
        let worst = (field / sampled - 1.0).abs().max_element();
        println!("metal of roughness {roughness}: {:.3}", field / sampled);
        assert!(worst < 0.12, "{roughness}: {worst}");
    }
}

/// Leaves that lie in one plane see nothing of each other, and none sees itself. On the grid each of them is
/// spread over cells; without a word about that they would get .033, of .4 and .3 that they send on.
#[test]
fn a_leaf_does_not_light_itself() {
    let translucent =
        Material { base_color: Rgb::splat(0.4), transmission: Rgb::splat(0.3), ..Material::default() };
    let glowing = Material { emission: Rgb::splat(0.5), ..translucent.clone() };
    let normal = DVec3::new(0.36, 0.48, 0.8);
    let (right, up) = normal.any_orthonormal_pair();
    for (name, material, sunlight) in [("sunlit", translucent, PI), ("glowing", glowing, 0.0)] {
        let mut scene = camera_at(DVec3::ZERO);
        scene.materials.push(material);
        let material = scene.materials.len() - 1;
        for leaf in 0..25 {
            let step = |index: i32| 0.83 * f64::from(index - 2);
            let place = step(leaf % 5) * right + step(leaf / 5) * up - 5.0 * DVec3::Z;
            add_leaf(&mut scene, place, normal, material);
        }
        add_light(&mut scene, LightKind::Sun, DVec3::ZERO, -normal, Rgb::splat(sunlight));
        let trees = MeshTrees::new(&scene);
        let exposure = Exposure::new(&scene, &trees, 0, 1.0, INSTANT);
        let snapshot = exposure.middle();
        for bounces in [Bounces::UpTo(1), Bounces::All] {
            let indirect = Indirect::new(&exposure, bounces, 1.0, &KeptLight::default(), &|| false)
                .expect("leaves scatter");
            let (mut most, mut seen) = (0.0_f64, 0);
            for number in 0..4096 {
                let along = |index: usize| ((index % 64) as f64 + 0.5) / 64.0;
                let ray = snapshot.view.ray(along(number), along(number / 64));
                let Some(hit) = snapshot.tree.nearest_hit(&ray, f64::INFINITY, None) else { continue };
                let light = indirect.scattered(snapshot, &snapshot.surface(&ray, &hit), 1.0);
                most = most.max(light.max_element());
                seen += 1;
            }
            println!("{name}, {bounces}: a leaf has {most:.5} of its own light");
            assert!(seen > 20 && most < 0.004, "{name}, {bounces}: {most} of {seen}");
        }
    }
}

/// What appears while the shutter is open changes the numbers of what is drawn, and no leaf's light.
#[test]
fn a_leaf_keeps_its_light_where_another_is_hidden() {
    let mut scene = camera_at(DVec3::ZERO);
    let leaf = Material { base_color: Rgb::splat(0.5), ..Material::default() };
    add_leaves(&mut scene, 500, leaf);
    scene.sky = Sky::new(SkyPicture::Gradient {
        zenith: Rgb::new(1.0, 2.0, 3.0),
        horizon: Rgb::ONE,
        ground: Rgb::splat(0.2),
    });
    let trees = MeshTrees::new(&scene);
    let exposure = Exposure::new(&scene, &trees, 0, 1.0, INSTANT);
    let middle = exposure.middle();
    let indirect = Indirect::new(&exposure, Bounces::All, 1.0, &KeptLight::default(), &|| false)
        .expect("leaves scatter");
    let mut fewer = scene.clone();
    for instance in [0, 7, 20] {
        let node = fewer.instances[instance].node;
        fewer.nodes[node].visible = false.into();
    }
    let trees = MeshTrees::new(&fewer);
    let moment = Snapshot::new(&fewer, &trees, 0, 1.0, INSTANT);
    let mut seen = 0;
    for number in 0..1024 {
        let along = |index: usize| ((index % 32) as f64 + 0.5) / 32.0;
        let ray = middle.view.ray(along(number), along(number / 32));
        let light = |snapshot: &Snapshot| {
            let hit = snapshot.tree.nearest_hit(&ray, f64::INFINITY, None)?;
            Some((hit.t, indirect.scattered(snapshot, &snapshot.surface(&ray, &hit), 1.0)))
        };
        if let (Some((t, one)), Some((u, other))) = (light(middle), light(&moment))
            && t == u
        {
            assert_eq!(one, other);
            seen += 1;
        }
    }
    assert!(seen > 50, "{seen} rays meet leaves");
}

/// Walls of 2 cm about the camera, a sky and a sun outside, fog inside and out.
pub(crate) fn dark_room(half_m: f64) -> Scene {
    let mut scene = camera_at(DVec3::ZERO);
    let (low, high, thick) = (DVec3::splat(-half_m), DVec3::splat(half_m), 0.02);
    add_box(&mut scene, low, high, Material::default());
    add_box(&mut scene, low + thick, high - thick, Material::default());
    add_fog(&mut scene, 2.0 * low, 2.0 * high, Rgb::splat(0.1), Rgb::splat(0.9), 0.2);
    scene.sky = Sky::new(EVEN_SKY);
    add_light(&mut scene, LightKind::Sun, DVec3::ZERO, DVec3::new(0.3, -1.0, -0.4), Rgb::splat(10.0));
    scene
}

#[test]
fn no_light_gets_through_the_walls_of_a_closed_room() {
    // Round ones too: cells are as wide as powers of two.
    for half_m in [1.5, 1.75, 2.0, 2.25, 2.3] {
        let worst = worst_from(&radiances(&dark_room(half_m), Bounces::All), 0.0);
        println!("in the dark room of {half_m} m: {worst:.2e}");
        assert!(worst < 1e-3, "{half_m}: {worst}");
    }
}

/// Posts side by side close a shed as walls do, though each is but twice as wide as thick.
#[test]
fn no_light_gets_through_the_posts_of_a_closed_shed() {
    let mut scene = camera_at(DVec3::ZERO);
    scene.sky = Sky::new(EVEN_SKY);
    let mut add = |low: [f64; 3], high: [f64; 3]| {
        add_box(&mut scene, low.into(), high.into(), Material::default());
    };
    for y in [-1.65, 1.5] {
        add([-0.75, y, -0.75], [0.75, y + 0.15, 0.75]);
    }
    for along in [-0.75, -0.45, -0.15, 0.15, 0.45] {
        for z in [-0.75, 0.6] {
            add([along, -1.5, z], [along + 0.3, 1.5, z + 0.15]);
        }
    }
    for along in [-0.6, -0.3, 0.0, 0.3] {
        for x in [-0.75, 0.6] {
            add([x, -1.5, along], [x + 0.15, 1.5, along + 0.3]);
        }
    }
    // Leaves outside of it have cells of their own size.
    for leaves in [0, 100] {
        add_leaves(&mut scene, leaves, Material::default());
        let worst = worst_from(&radiances(&scene, Bounces::All), 0.0);
        println!("in the dark shed, {leaves} leaves outside: {worst:.2e}");
        assert!(worst < 1e-3, "{leaves}: {worst}");
    }
}

/// A lamp lights a spot on the wall behind the camera, and the spot lights the wall before it as a point does
/// by Lambert's cosines. Along ordinates it would light a few places of that.
#[test]
fn a_spot_on_a_wall_lights_another_evenly() {
    let mut scene = camera_at(DVec3::ZERO);
    for (low, high, reflectance) in [
        ([-2.0, -2.0, 2.0], [2.0, 2.0, 2.2], 0.5),
        ([-2.0, -2.0, -2.2], [2.0, 2.0, -2.0], 0.5),
        ([-2.0, -2.2, -2.0], [2.0, -2.0, 2.0], 0.0),
    ] {
        let wall = Material { base_color: Rgb::splat(reflectance), ..Material::default() };
        add_box(&mut scene, low.into(), high.into(), wall);
    }
    let spot = DVec3::new(0.3, 0.2, 2.0);
    add_light(&mut scene, LightKind::Point, spot - 0.01 * DVec3::Z, DVec3::NEG_Z, Rgb::splat(10.0));
    let trees = MeshTrees::new(&scene);
    let exposure = Exposure::new(&scene, &trees, 0, 1.0, INSTANT);
    let snapshot = exposure.middle();
    let indirect = Indirect::new(&exposure, Bounces::UpTo(1), 1.0, &KeptLight::default(), &|| false)
        .expect("walls scatter");
    let mut worst = 0.0_f64;
    for number in 0..256 {
        let along = |index: usize| 0.1 + 0.8 * ((index % 16) as f64 + 0.5) / 16.0;
        let ray = snapshot.view.ray(along(number), along(number / 16));
        let hit = snapshot.tree.nearest_hit(&ray, f64::INFINITY, None).expect("a wall is before it");
        let way = ray.at(hit.t) - spot;
        let cos_by_m = way.z / way.length_squared();
        // The spot sends half of the half of the lamp's light that it gets: 10 W/sr along its normal.
        let expected = 0.5 / PI * 10.0 * cos_by_m * cos_by_m;
        let found = indirect.scattered(snapshot, &snapshot.surface(&ray, &hit), 1.0).x;
        worst = worst.max((found / expected - 1.0).abs());
    }
    println!("a wall lit by a spot: worst {worst:.3}");
    assert!(worst < 0.05, "{worst}");
}

/// A sheet that takes nothing of light, half of it through, in even light from all sides.
#[test]
fn light_comes_through_walls_that_transmit() {
    let mut scene = camera_at(DVec3::ZERO);
    scene.sky = Sky::new(EVEN_SKY);
    let half = Rgb::splat(0.5);
    scene.materials.push(Material { base_color: half, transmission: half, ..Material::default() });
    let corner = |x: f32, y: f32| Vec3::new(x, y, -4.1);
    scene.meshes.push(Mesh {
        positions: vec![corner(-3.0, -3.0), corner(3.0, -3.0), corner(3.0, 3.0), corner(-3.0, 3.0)],
        triangles: [[0, 1, 2], [0, 2, 3]].map(|vertices| Triangle { vertices, material: 0 }).to_vec(),
        ..Mesh::default()
    });
    add_instance(&mut scene);
    let worst = worst_from(&radiances(&scene, Bounces::All), 1.0);
    println!("before a white sheet: {worst:.2e}");
    assert!(worst < 2e-3, "{worst}");
}

/// Glass that lets nine tenths of all light pass and scatters a fiftieth is a veil that covers a tenth: a
/// wall behind either has the same light.
#[test]
fn glass_is_as_clear_as_a_veil() {
    let seen_through = |surface: Material| {
        let mut scene = camera_at(DVec3::ZERO);
        scene.sky = Sky::new(EVEN_SKY);
        let wall = Material { base_color: Rgb::splat(0.5), ..Material::default() };
        add_box(&mut scene, DVec3::new(-3.0, -3.0, -5.0), DVec3::new(3.0, 3.0, -4.5), wall);
        let pane = Material { alpha_mode: AlphaMode::Blend, ..surface };
        add_box(&mut scene, DVec3::new(-3.0, -3.0, -4.1), DVec3::new(3.0, 3.0, -4.0), pane);
        radiances(&scene, Bounces::All).iter().sum::<Rgb>().x
    };
    let glass = seen_through(Material {
        base_color: Rgb::splat(0.02),
        filter_color: Rgb::splat(0.9),
        ..Material::default()
    });
    let veil = seen_through(Material { base_color: Rgb::splat(0.2), opacity: 0.1, ..Material::default() });
    println!("light by glass and by a veil: {glass:.3}, {veil:.3}");
    assert!((glass / veil - 1.0).abs() < 1e-3, "{glass} {veil}");
}

/// A sheet 3 cm before a panel that glows hides it, and lets half of its light through: to a wall, by
/// Lambert's cosines.
#[test]
fn light_comes_through_a_sheet_close_before_a_panel() {
    let mut scene = camera_at(DVec3::ZERO);
    let wall = Material { base_color: Rgb::splat(0.5), ..Material::default() };
    add_box(&mut scene, DVec3::new(-2.0, -2.0, -2.2), DVec3::new(2.0, 2.0, -2.0), wall);
    let sheet = Material { base_color: Rgb::ZERO, transmission: Rgb::splat(0.5), ..Material::default() };
    let panel = Material { base_color: Rgb::ZERO, emission: Rgb::splat(10.0), ..Material::default() };
    for (half_m, z, surface) in [(0.7, 1.5, sheet), (0.4, 1.53, panel)] {
        scene.materials.push(surface);
        let material = scene.materials.len() - 1;
        let corner = |x: f32, y: f32| Vec3::new(half_m * x, half_m * y, z);
        scene.meshes.push(Mesh {
            positions: vec![corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)],
            triangles: [[0, 1, 2], [0, 2, 3]].map(|vertices| Triangle { vertices, material }).to_vec(),
            ..Mesh::default()
        });
        add_instance(&mut scene);
    }
    let trees = MeshTrees::new(&scene);
    let exposure = Exposure::new(&scene, &trees, 0, 1.0, INSTANT);
    let snapshot = exposure.middle();
    let indirect = Indirect::new(&exposure, Bounces::UpTo(1), 1.0, &KeptLight::default(), &|| false)
        .expect("walls scatter");
    let (mut found, mut expected) = (0.0, 0.0);
    for number in 0..256 {
        let along = |index: usize| 0.1 + 0.8 * ((index % 16) as f64 + 0.5) / 16.0;
        let ray = snapshot.view.ray(along(number), along(number / 16));
        let hit = snapshot.tree.nearest_hit(&ray, f64::INFINITY, None).expect("a wall is before it");
        found += indirect.scattered(snapshot, &snapshot.surface(&ray, &hit), 1.0).x;
        for place in 0..64 {
            let on_sheet = |index: usize| 0.1 * ((index % 8) as f64 - 3.5);
            let way = DVec3::new(on_sheet(place), on_sheet(place / 8), 1.5) - ray.at(hit.t);
            let cos_by_m = way.z / way.length_squared();
            expected += 0.5 / PI * 0.5 * 10.0 * cos_by_m * cos_by_m * 0.64 / 64.0;
        }
    }
    println!("a wall lit through a sheet: {:.3}", found / expected);
    assert!((found / expected - 1.0).abs() < 0.1, "{found} of {expected}");
}

/// Walls that glow and reflect .9 about white leaves, without fog: all is ten times as bright as walls glow.
#[test]
fn a_room_that_holds_leaves_alone_has_walls() {
    let mut scene = camera_at(DVec3::ZERO);
    add_leaves(&mut scene, 100, Material { base_color: Rgb::ONE, ..Material::default() });
    let glowing = Material { base_color: Rgb::splat(0.9), emission: Rgb::ONE, ..Material::default() };
    // No ray of the camera meets an edge.
    add_box(&mut scene, DVec3::new(-2.4, -2.6, -7.5), DVec3::new(2.7, 2.5, 2.5), glowing);
    let radiances = radiances(&scene, Bounces::All);
    let mean = radiances.iter().sum::<Rgb>().x / radiances.len() as f64;
    let worst = worst_from(&radiances, 10.0);
    println!("in the room that glows: mean {mean:.3}, worst {worst:.2}");
    assert!((mean - 10.0).abs() < 0.5, "{mean}");
    assert!(worst < 2.0, "{worst}");
}

const SIZE: Size = Size { width: 240, height: 135 };

pub(crate) fn leaves500() -> Scene {
    let path = checkout::file("tests/data/leaves500/leaves500.glb");
    scene::resolve(description::load(&path).expect("a good file"), None).expect("a good scene").0
}

pub(crate) fn picture(scene: &Scene, bounces: Bounces, method: Method) -> Frame {
    rendered(scene, bounces, method, vec![]).frame
}

fn rendered(scene: &Scene, bounces: Bounces, method: Method, passes: Vec<Pass>) -> Rendered {
    let aspect = SIZE.width as f64 / SIZE.height as f64;
    let trees = MeshTrees::new(scene);
    let exposure = Exposure::new(scene, &trees, 0, aspect, INSTANT);
    let job = Job {
        size: SIZE,
        window: Window::whole(SIZE),
        passes,
        sampling: Sampling::Exactly(4),
        filter: PixelFilter::Box,
        seed: 0,
        mirror_depth: 0,
        bounces,
        method,
    };
    render(&exposure, &job, &Watch::NOBODY)
}

/// Blocks of this scene are within 1 % of the truth, see below: what is told is of that size, and in
/// the pass.
#[test]
fn the_grids_error_is_told() {
    let scene = leaves500();
    let with_error = |bounces| rendered(&scene, bounces, Method::Slices, vec![Pass::Error]);
    let all = with_error(Bounces::All);
    let told = all.statistics.grid_error.expect("errors are asked for");
    println!("told: {told:.4}");
    assert!((0.003..0.03).contains(&told), "{told}");
    let none = with_error(Bounces::NONE);
    assert_eq!(none.statistics.grid_error, None);
    assert_eq!(rendered(&scene, Bounces::All, Method::Slices, vec![]).statistics.grid_error, None);
    // The pass has the grid's error beside the noise: it is nowhere below what the noise alone is.
    let pass = &all.frame.channel("error.Y").expect("it was asked for").pixels;
    let mean = pass.iter().map(|&error| f64::from(error)).sum::<f64>() / pass.len() as f64;
    let worst = all.statistics.error.expect("judged");
    assert!(pass.iter().any(|&error| f64::from(error) >= worst), "{worst}");
    assert!(mean > 0.3 * told, "{mean} {told}");
}

/// The error is told as a share of the whole picture, also where only the sky lights it, whose light the grid
/// has: a lamp that adds nothing changes little.
#[test]
fn error_is_a_share_of_pictures_without_lights_too() {
    let told = |has_lamp: bool| {
        let mut scene = camera_at(DVec3::ZERO);
        add_leaves(&mut scene, 60, Material { base_color: Rgb::splat(0.5), ..Material::default() });
        scene.sky = Sky::new(EVEN_SKY);
        if has_lamp {
            add_light(&mut scene, LightKind::Point, DVec3::Y, DVec3::NEG_Y, Rgb::splat(1e-9));
        }
        rendered(&scene, Bounces::All, Method::Segments, vec![Pass::Error]).statistics.grid_error
    };
    let [without, with] = [false, true].map(|has_lamp| told(has_lamp).expect("errors are asked for"));
    println!("told: {without:.4} without a lamp, {with:.4} with one");
    assert!((0.67..1.5).contains(&(without / with)), "{without} {with}");
}

/// Means of blocks of 10x10 pixels, and the standard errors of those.
pub(crate) struct Truth {
    blocks: Vec<(Rgb, Rgb)>,
}

/// The orders of which the file's columns from `first` on tell.
pub(crate) fn truth(first: usize) -> Truth {
    let text = include_str!("../data/leaves500/orders.txt");
    let lines = text.lines().filter(|line| !line.starts_with('#'));
    let blocks = lines.map(|line| {
        let numbers: Vec<f64> = line.split(' ').map(|number| number.parse().expect("a number")).collect();
        (Rgb::from_slice(&numbers[first..]), Rgb::from_slice(&numbers[first + 3..]))
    });
    Truth { blocks: blocks.collect() }
}

impl Truth {
    /// Mean ratio, and the root mean square of what blocks differ by, as a share of the mean, without
    /// the truth's own noise.
    fn judge(&self, frame: &Frame) -> (f64, f64) {
        let columns = SIZE.width / 10;
        let (mut ours, mut theirs, mut square) = (Rgb::ZERO, Rgb::ZERO, Rgb::ZERO);
        for (number, (truth, error)) in self.blocks.iter().enumerate() {
            let (x, y) = (10 * (number % columns), 10 * (number / columns));
            let pixels = (0..100).map(|pixel| beauty(frame, x + pixel % 10, y + pixel / 10));
            let block = pixels.sum::<Rgb>() / 100.0;
            ours += block;
            theirs += *truth;
            square += (block - truth) * (block - truth) - *error * *error;
        }
        let mean = theirs.element_sum() / (3 * self.blocks.len()) as f64;
        let error = (square.element_sum() / (3 * self.blocks.len()) as f64).max(0.0).sqrt();
        (ours.element_sum() / theirs.element_sum(), error / mean)
    }

    /// By how much blocks are brighter on the mean, as a share of the truth's mean, and the standard error of
    /// that, by the spread of the blocks.
    pub(crate) fn difference(&self, frame: &Frame) -> (f64, f64) {
        let columns = SIZE.width / 10;
        let luminance = |color: Rgb| color.element_sum() / 3.0;
        let difference = |(number, (truth, _)): (usize, &(Rgb, Rgb))| {
            let (x, y) = (10 * (number % columns), 10 * (number / columns));
            let pixels = (0..100).map(|pixel| beauty(frame, x + pixel % 10, y + pixel / 10));
            luminance(pixels.sum::<Rgb>() / 100.0 - truth)
        };
        let differences: Vec<f64> = self.blocks.iter().enumerate().map(difference).collect();
        let count = differences.len() as f64;
        let truth = self.blocks.iter().map(|(truth, _)| luminance(*truth)).sum::<f64>() / count;
        let mean = differences.iter().sum::<f64>() / count;
        let square: f64 = differences.iter().map(|difference| (difference - mean).powi(2)).sum();
        (mean / truth, (square / (count * (count - 1.0))).sqrt() / truth)
    }
}

fn beauty(frame: &Frame, x: usize, y: usize) -> Rgb {
    let channel =
        |name: &str| f64::from(frame.channel(name).expect("there is a beauty").pixels[y * SIZE.width + x]);
    Rgb::new(channel("R"), channel("G"), channel("B"))
}

#[test]
fn leaves500_is_what_mitsuba_makes_of_it() {
    let scene = leaves500();
    for (name, bounces, first) in [("depth 3", Bounces::UpTo(1), 0), ("depth 16", Bounces::All, 6)] {
        let (ratio, error) = truth(first).judge(&picture(&scene, bounces, Method::Auto));
        println!("{name}: mean {ratio:.4}, blocks {:.2} %", 100.0 * error);
        assert!((ratio - 1.0).abs() < 0.01, "{name}: {ratio}");
        assert!(error < 0.015, "{name}: {error}");
    }
}

#[test]
fn slices_and_rays_see_the_same_light() {
    let scene = leaves500();
    let mean = |method| {
        let frame = picture(&scene, Bounces::All, method);
        let pixels =
            (0..SIZE.width * SIZE.height).map(|pixel| beauty(&frame, pixel % SIZE.width, pixel / SIZE.width));
        pixels.sum::<Rgb>().element_sum()
    };
    let ratio = mean(Method::Slices) / mean(Method::Segments);
    assert!((ratio - 1.0).abs() < 2e-3, "{ratio}");
}

/// Leaves that are a line or a point have no light and are in no light's way.
#[test]
fn leaves_without_an_area_change_nothing() {
    let mut scene = camera_at(DVec3::ZERO);
    add_leaves(&mut scene, 100, Material::default());
    add_fog(
        &mut scene,
        DVec3::new(-2.0, -2.0, -7.0),
        DVec3::new(2.0, 2.0, -3.0),
        Rgb::splat(0.1),
        Rgb::ONE,
        0.3,
    );
    scene.sky = Sky::new(EVEN_SKY);
    let before = radiances(&scene, Bounces::All);
    let material = scene.materials.len() - 1;
    let place = -5.0 * Vec3::Z;
    for positions in [[place; 3], [place, place + 0.1 * Vec3::X, place + 0.2 * Vec3::X]] {
        let triangles = vec![Triangle { vertices: [0, 1, 2], material }];
        scene.meshes.push(Mesh { positions: positions.to_vec(), triangles, ..Mesh::default() });
        add_instance(&mut scene);
    }
    let off = before.iter().zip(radiances(&scene, Bounces::All));
    let worst = off.map(|(before, after)| (*before - after).abs().max_element()).fold(0.0, f64::max);
    println!("leaves without an area: worst {worst:.2e}");
    assert!(worst < 1e-6, "{worst}");
}

#[test]
fn threads_do_not_reach_it() {
    let scene = leaves500();
    let by = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(|| picture(&scene, Bounces::All, Method::Auto))
    };
    assert_eq!(by(1), by(3));
}

/// Leaves beyond any number get the same light as all others: 200,000 once were all whose light was kept.
#[test]
fn one_leaf_more_changes_no_light_however_many_there_are() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.ron");
    let red = |count: u32| {
        let text = format!(
            r#"Scene(version: 1, meshes: {{ "leaf": Leaf(length_m: 0.1, width_m: 0.07) }},
            materials: {{ "gold": (base_color: (0.5, 0.25, 0.02), transmission: (0.4, 0.2, 0.01)) }},
            leaves: {{ "crown": (count: {count}, seed: 3, meshes: ["leaf"], materials: ["gold"],
                min_m: (-15.0, -8.0, -15.0), max_m: (15.0, 8.0, 15.0)) }},
            cameras: {{ "main": (position_m: (0.0, 0.0, 30.0), look_at_m: (0.0, 0.0, 0.0), fov_deg: 40.0) }},
            lights: {{ "sun": Sun(to_sun: (0.5, 1.0, 0.4), irradiance_w_per_m2: 10.0) }})"#
        );
        std::fs::write(&path, text).unwrap();
        let scene = scene::resolve(description::load(&path).unwrap(), None).unwrap().0;
        let trees = MeshTrees::new(&scene);
        let exposure = Exposure::new(&scene, &trees, 0, 16.0 / 9.0, INSTANT);
        let size = Size { width: 32, height: 18 };
        let job = Job {
            size,
            window: Window::whole(size),
            passes: vec![Pass::Indirect],
            sampling: Sampling::Exactly(4),
            filter: PixelFilter::Box,
            seed: 0,
            mirror_depth: 0,
            bounces: Bounces::UpTo(2),
            method: Method::Auto,
        };
        let frame = render(&exposure, &job, &Watch::NOBODY).frame;
        let pixels = &frame.channel("indirect.R").expect("a pass").pixels;
        pixels.iter().map(|red| f64::from(*red)).sum::<f64>()
    };
    let (fewer, more) = (red(199_999), red(200_001));
    assert!(fewer > 0.0 && (more / fewer - 1.0).abs() < 1e-3, "{fewer} {more}");
}
