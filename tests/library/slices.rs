//! Slices against the per-ray method: the same rays, two independent ways to their values.

use crate::checkout;
use crate::common::{EXACT, INSTANT, add_fog, add_layer, add_light, camera_at};
use crate::indirect::{add_box, picture};
use glam::{DAffine3, DVec3};
use sunfleck::color::Rgb;
use sunfleck::math::Sampler;
use sunfleck::render::Method;
use sunfleck::scene::{
    AlphaMode, Aperture, Bounces, Clip, FogShape, HeightFalloff, Light, LightKind, Material, Motion, Node,
    RayVisibility, Scene, Size, Track,
};
use sunfleck::snapshot::{MeshTrees, Snapshot};
use sunfleck::transport::slices::{Fan, Piece, Ring, SliceJob, SliceScratch};
use sunfleck::transport::{Scratch, radiance};
use sunfleck::{description, scene};

const SIZE: Size = Size { width: 160, height: 90 };

fn leaves500() -> Scene {
    let path = checkout::file("tests/data/leaves500/leaves500.glb");
    scene::resolve(description::load(&path).expect("a good file"), None).expect("a good scene").0
}

fn with_light(kind: LightKind, world_from_light: DAffine3, power: f64) -> Scene {
    let mut scene = leaves500();
    scene.nodes.push(Node {
        name: "lamp".into(),
        parent: None,
        motion: Motion::Still(world_from_light),
        visible: Track::from(true),
    });
    let node = scene.nodes.len() - 1;
    scene.lights = vec![Light { name: "lamp".into(), node, power: Track::from(Rgb::splat(power)), kind }];
    scene
}

/// Compares some hundred samples of each of some slices; returns how many rays differ in what they
/// meet, how many were compared, and the relative RMSE of the others.
fn compare(scene: &Scene) -> (usize, usize, f64) {
    let trees = MeshTrees::new(scene);
    let snapshot = Snapshot::new(scene, &trees, 0, 16.0 / 9.0, INSTANT);
    let light = snapshot.lights[0].centre();
    let lens_point = snapshot.view.lens_point([0.9, 0.3]);
    let fan = Fan::new(&snapshot.view, SIZE, lens_point, light.place()).expect("a fan");
    let job = SliceJob {
        snapshot: &snapshot,
        transport: &EXACT,
        light: &light,
        hue: Rgb::ONE,
        has_rest: true,
        fan: &fan,
    };
    let (mut scratch, mut ray_scratch) = (SliceScratch::default(), Scratch::default());
    let (mut differ, mut count, mut squares, mut sum) = (0, 0, 0.0, 0.0);
    for number in 0..41 {
        let angle = fan.angles.0 + fan.angles.1 * (f64::from(number) + 0.4) / 41.0;
        let Some(slice) = fan.slice(angle, Ring::WHOLE) else { continue };
        let areas = (0..100).map(|index| slice.area_per_rad * (f64::from(index) + 0.5) / 100.0);
        let chords = areas.map(|area| slice.ray(area));
        job.solve(&slice, chords, None, &mut scratch, |Piece { place, .. }, value| {
            let film = place.film_px;
            let (x, y) = (film.x / SIZE.width as f64, film.y / SIZE.height as f64);
            let ray = snapshot.view.ray_from(lens_point, x, y);
            let mut sampler = Sampler::new(0, 0, 0, 0);
            let truth = radiance(&snapshot, &EXACT, &ray, &mut sampler, &mut ray_scratch);
            assert!((0.0..=160.0).contains(&film.x) && (0.0..=90.0).contains(&film.y), "{film}");
            count += 1;
            let same = match (value.surface, truth.surface) {
                (None, None) => true,
                (Some(a), Some(b)) => (a.depth_m - b.depth_m).abs() < 1e-4 * b.depth_m,
                _ => false,
            };
            if same {
                squares += (value.shafts - truth.shafts).length_squared();
                sum += truth.shafts.length();
                differ += usize::from((value.radiance - truth.radiance).length() > 1e-3);
            } else {
                differ += 1;
            }
        });
    }
    (differ, count, (squares / count as f64).sqrt() / (sum / count as f64))
}

fn assert_equal(scene: &Scene) {
    let (differ, count, error) = compare(scene);
    assert!(count > 2000, "{count}");
    // Rays through the very edge of a triangle may meet it in one way and miss it in the other.
    assert!(differ * 1000 <= count, "{differ} of {count}");
    assert!(error <= 1e-6, "{error:.2e}");
}

#[test]
fn sun_above_the_picture() {
    assert_equal(&leaves500());
}

/// Thinner with height without bounds, beside the scene's own box.
#[test]
fn sun_through_height_fog() {
    let mut scene = leaves500();
    add_layer(&mut scene, 0.5, 1.5, Rgb::new(0.2, 0.3, 0.4), Rgb::splat(0.9), 0.7);
    assert_equal(&scene);
    scene.fogs.remove(0);
    assert_equal(&scene);
}

/// A box of it with its base in the middle, alone and beside a layer without bounds, under suns from all
/// sides: high, level with the base, low before the camera, and below the base.
#[test]
fn suns_all_round_height_fog() {
    for (towards, layer) in [
        (DVec3::new(0.3, 1.0, -0.6), false),
        (DVec3::new(1.0, 0.0, -0.4), false),
        (DVec3::new(-0.2, 0.05, -1.0), true),
        (DVec3::new(0.4, -0.3, 1.0), false),
    ] {
        let turn = glam::DQuat::from_rotation_arc(DVec3::Z, towards.normalize());
        let mut scene = with_light(LightKind::Sun, DAffine3::from_quat(turn), 10.0);
        scene.fogs[0].shape =
            FogShape::ThinningBox(HeightFalloff { base: -0.2, scale_height_m: Track::from(1.5) });
        if layer {
            add_layer(&mut scene, 0.0, 0.8, Rgb::new(0.05, 0.1, 0.2), Rgb::splat(0.9), -0.4);
        }
        assert_equal(&scene);
    }
}

#[test]
fn lamp_in_height_fog() {
    let place = DAffine3::from_translation(DVec3::new(0.5, 3.0, 1.0));
    let mut scene = with_light(LightKind::Point, place, 50.0);
    scene.fogs[0].shape =
        FogShape::ThinningBox(HeightFalloff { base: -0.8, scale_height_m: Track::from(1.5) });
    assert_equal(&scene);
}

#[test]
fn sun_in_the_middle_of_the_picture() {
    // The camera looks from (0, 1.7, 9) to (0, 2.6, 0).
    let towards = DVec3::new(0.02, 0.9, -9.0).normalize();
    let turn = glam::DQuat::from_rotation_arc(DVec3::NEG_Z, -towards);
    assert_equal(&with_light(LightKind::Sun, DAffine3::from_quat(turn), 10.0));
}

#[test]
fn sun_behind_the_camera() {
    let beam = DVec3::new(0.1, -0.4, -1.0).normalize();
    let turn = glam::DQuat::from_rotation_arc(DVec3::NEG_Z, beam);
    assert_equal(&with_light(LightKind::Sun, DAffine3::from_quat(turn), 10.0));
}

#[test]
fn sun_at_right_angles_to_the_view() {
    let view = DVec3::new(0.0, 0.9, -9.0).normalize();
    let beam = -view.any_orthonormal_vector();
    let beam = if beam.y > 0.0 { -beam } else { beam };
    let turn = glam::DQuat::from_rotation_arc(DVec3::NEG_Z, beam);
    assert_equal(&with_light(LightKind::Sun, DAffine3::from_quat(turn), 10.0));
}

/// A wide lens: the eye is some 4 cm beside the middle.
#[test]
fn sun_and_lamp_seen_from_the_edge_of_a_lens() {
    let lamp = DAffine3::from_translation(DVec3::new(0.5, 3.0, 1.0));
    for mut scene in [leaves500(), with_light(LightKind::Point, lamp, 50.0)] {
        scene.cameras[0].aperture = Some(Aperture {
            f_stop: Track::from(0.4),
            sensor_width_m: 0.036,
            focus_distance_m: Track::from(5.0),
            blades: 0,
        });
        assert_equal(&scene);
    }
}

/// Planes through the leaves, from everywhere in the lens: what they hide shadows leaves and fog as before.
#[test]
fn clipping_planes() {
    let lamp = DAffine3::from_translation(DVec3::new(0.5, 3.0, 1.0));
    for mut scene in [leaves500(), with_light(LightKind::Point, lamp, 50.0)] {
        scene.cameras[0].clip = Clip { start_m: 6.5, end_m: 9.0 };
        assert_equal(&scene);
        scene.cameras[0].aperture = Some(Aperture {
            f_stop: Track::from(0.4),
            sensor_width_m: 0.036,
            focus_distance_m: Track::from(5.0),
            blades: 0,
        });
        assert_equal(&scene);
    }
}

/// Every few leaves one that the camera does not see, one without a shadow, and a hole, of which some
/// are blended.
#[test]
fn leaves_that_not_all_rays_meet() {
    let lamp = DAffine3::from_translation(DVec3::new(0.5, 3.0, 1.0));
    for mut scene in [leaves500(), with_light(LightKind::Point, lamp, 50.0)] {
        let nodes: Vec<usize> = scene.instances.iter().map(|instance| instance.node).collect();
        for (number, node) in nodes.into_iter().enumerate() {
            let rays = RayVisibility {
                visible_to_camera: number % 3 != 0,
                casts_shadow: number % 5 != 0,
                holdout: number % 7 == 0,
            };
            scene.set_ray_visibility(node, rays);
        }
        assert_equal(&scene);
        let veil = Material { alpha_mode: AlphaMode::Blend, opacity: 0.5, ..Material::default() };
        scene.materials.push(veil);
        let veil = scene.materials.len() - 1;
        for instance in scene.instances.iter_mut().step_by(11) {
            instance.material = Some(veil);
        }
        assert_equal(&scene);
    }
}

#[test]
fn lamp_in_the_picture() {
    assert_equal(&with_light(LightKind::Point, DAffine3::from_translation(DVec3::new(0.5, 3.0, 1.0)), 50.0));
}

#[test]
fn lamp_beside_the_picture() {
    assert_equal(&with_light(LightKind::Point, DAffine3::from_translation(DVec3::new(1.5, 7.0, 3.0)), 50.0));
}

#[test]
fn lamp_behind_the_camera() {
    assert_equal(&with_light(LightKind::Point, DAffine3::from_translation(DVec3::new(-1.0, 3.0, 9.9)), 50.0));
}

#[test]
fn spot() {
    let turn = glam::DQuat::from_rotation_arc(DVec3::NEG_Z, DVec3::new(-0.3, -1.0, -0.2).normalize());
    let place = DAffine3::from_rotation_translation(turn, DVec3::new(1.5, 6.0, 3.0));
    let kind =
        LightKind::Spot { outer_angle: Track::from(0.6), blend: Track::from(0.3), radius: Track::from(0.0) };
    assert_equal(&with_light(kind, place, 200.0));
}

/// Every seventh leaf lets half of the light through: rays that it touches are followed by
/// themselves, and no other.
#[test]
fn some_leaves_blended() {
    let lamp = DAffine3::from_translation(DVec3::new(0.5, 3.0, 1.0));
    for mut scene in [leaves500(), with_light(LightKind::Point, lamp, 50.0)] {
        let veil = Material { alpha_mode: AlphaMode::Blend, opacity: 0.5, ..Material::default() };
        scene.materials.push(veil);
        let veil = scene.materials.len() - 1;
        for instance in scene.instances.iter_mut().step_by(7) {
            instance.material = Some(veil);
        }
        assert_equal(&scene);
    }
}

/// Ground that goes to the horizon is as bright as a smaller one: single precision knows it to half a metre.
#[test]
fn ground_of_ten_thousand_kilometres_is_whole() {
    let light = |half_m: f64| {
        let mut scene = camera_at(DVec3::new(0.3, 1.1, 4.5));
        let half = DVec3::new(half_m, 0.0, half_m);
        let soil = Material { base_color: Rgb::splat(0.3), ..Material::default() };
        add_box(&mut scene, -half - 1.0 * DVec3::Y, half, soil);
        let sunbeam = DVec3::new(-0.5, -1.0, 0.4);
        add_light(&mut scene, LightKind::Sun, DVec3::ZERO, sunbeam, Rgb::splat(9.0));
        let frame = picture(&scene, Bounces::NONE, Method::Slices);
        frame.channel("R").unwrap().pixels.iter().map(|&value| f64::from(value)).sum::<f64>()
    };
    let (wide, narrow) = (light(5e6), light(5e4));
    assert!(narrow > 0.0 && (wide / narrow - 1.0).abs() < 1e-3, "{wide} {narrow}");
}

/// A lamp in a wall is as bright as one just before it, wherever in the wall it is, slanting or not.
#[test]
fn a_lamp_in_a_wall_shines_into_the_room() {
    let grey = Material { base_color: Rgb::splat(0.5), ..Material::default() };
    for turned in [DAffine3::IDENTITY, DAffine3::from_rotation_z(0.4) * DAffine3::from_rotation_x(0.7)] {
        for lamp in [DVec3::new(0.0, 2.0, -1.0), DVec3::new(0.37, 2.0, -0.7), DVec3::new(2.0, 0.3, -0.4)] {
            let light = |lamp: DVec3, method| {
                let mut scene = camera_at(DVec3::ZERO);
                let (low, high) = (DVec3::splat(-2.0), DVec3::splat(2.0));
                add_box(&mut scene, low, high, grey.clone());
                add_fog(&mut scene, low, high, Rgb::splat(0.1), Rgb::ONE, 0.3);
                for node in &mut scene.nodes[1..] {
                    let Motion::Still(placed) = &mut node.motion else { unreachable!("all are still") };
                    *placed = turned * *placed;
                }
                let position = turned.transform_point3(lamp);
                add_light(&mut scene, LightKind::Point, position, DVec3::Z, Rgb::splat(3.0));
                let frame = picture(&scene, Bounces::NONE, method);
                frame.channel("R").unwrap().pixels.iter().map(|&value| f64::from(value)).sum::<f64>()
            };
            let before = light((1.0 - 1e-5) * lamp, Method::Segments);
            for method in [Method::Slices, Method::Segments] {
                let within = light(lamp, method);
                println!("{lamp}: {:.5}", within / before);
                assert!(before > 0.0 && (within / before - 1.0).abs() < 2e-3, "{lamp}: {within} {before}");
            }
        }
    }
}
