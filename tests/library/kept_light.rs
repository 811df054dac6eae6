//! Indirect light that outlives a picture: the camera's own changes keep it, all others do not, and it never
//! shows in a pixel whether it was kept.

use crate::common::{INSTANT, add_fog, add_light, camera_at};
use crate::indirect::{add_leaf, add_leaves};
use glam::{DAffine3, DVec3};
use std::sync::atomic::{AtomicUsize, Ordering};
use sunfleck::color::Rgb;
use sunfleck::indirect::{Indirect, KeptLight};
use sunfleck::render::{Job, Method, Watch, render, render_keeping};
use sunfleck::scene::{
    Bounces, Lens, LightKind, Material, Motion, PixelFilter, Sampling, Scene, Size, Sky, SkyPicture, Track,
    Window,
};
use sunfleck::snapshot::{Exposure, MeshTrees};

/// Leaves in fog that scatters ahead, a sun, a lamp and a sky.
fn grove() -> Scene {
    let mut scene = camera_at(DVec3::ZERO);
    add_leaves(&mut scene, 200, Material { base_color: Rgb::splat(0.5), ..Material::default() });
    let middle = -5.0 * DVec3::Z;
    add_fog(&mut scene, middle - 3.0, middle + 3.0, Rgb::splat(0.1), Rgb::splat(0.9), 0.7);
    add_light(&mut scene, LightKind::Sun, DVec3::ZERO, DVec3::new(0.3, -1.0, -0.4), Rgb::ONE);
    add_light(&mut scene, LightKind::Point, middle, DVec3::X, Rgb::splat(3.0));
    let [zenith, horizon, ground] = [1.0, 0.5, 0.1].map(Rgb::splat);
    scene.sky = Sky::new(SkyPicture::Gradient { zenith, horizon, ground });
    scene
}

/// How often a solver asks whether it is still wanted: never, where light is kept.
fn solved(scene: &Scene, bounces: Bounces, kept: &KeptLight) -> bool {
    let asked = AtomicUsize::new(0);
    let trees = MeshTrees::new(scene);
    let exposure = Exposure::new(scene, &trees, 0, 1.0, INSTANT);
    let cancelled = || asked.fetch_add(1, Ordering::Relaxed) > usize::MAX / 2;
    Indirect::new(&exposure, bounces, 1.0, kept, &cancelled).expect("leaves scatter");
    asked.into_inner() > 0
}

fn moved_camera(scene: &mut Scene) {
    let turned = DAffine3::from_rotation_y(0.1);
    scene.nodes[scene.cameras[0].node].motion =
        Motion::Still(DAffine3::from_translation(DVec3::new(0.37, -0.11, 0.83)) * turned);
    scene.cameras[0].lens = Lens::Perspective { fov_y: Track::from(0.9) };
}

#[test]
fn the_camera_alone_keeps_light() {
    let kept = KeptLight::default();
    let mut scene = grove();
    assert!(solved(&scene, Bounces::UpTo(2), &kept), "at first there is none");
    moved_camera(&mut scene);
    assert!(!solved(&scene, Bounces::UpTo(2), &kept), "the camera moved");
    assert!(solved(&scene, Bounces::UpTo(1), &kept), "other bounces");
    assert!(!solved(&scene, Bounces::UpTo(1), &kept), "the same");
}

#[test]
fn whatever_gives_light_or_meets_it_has_it_solved_again() {
    let shifted = Motion::Still(DAffine3::from_translation(1e-3 * DVec3::Y));
    type Change = Box<dyn Fn(&mut Scene)>;
    let changes: [(&str, Change); 9] = [
        ("a leaf moves", {
            let shifted = shifted.clone();
            Box::new(move |scene| scene.nodes[scene.instances[7].node].motion = shifted.clone())
        }),
        ("a leaf hides", Box::new(|scene| scene.nodes[scene.instances[7].node].visible = Track::from(false))),
        ("one more", Box::new(|scene| add_leaf(scene, -4.0 * DVec3::Z, DVec3::X, 0))),
        ("fog thickens", Box::new(|scene| scene.fogs[0].density_per_m = Track::from(Rgb::splat(0.101)))),
        ("fog scatters ahead", Box::new(|scene| scene.fogs[0].anisotropy = Track::from(0.71))),
        ("the sun dims", Box::new(|scene| scene.lights[0].power = Track::from(Rgb::splat(0.99)))),
        ("the lamp moves", Box::new(move |scene| scene.nodes[scene.lights[1].node].motion = shifted.clone())),
        (
            "the sky dims",
            Box::new(|scene| {
                scene.sky.as_mut().expect("there is one").strength = Track::from(Rgb::splat(0.9));
            }),
        ),
        (
            "the sky turns",
            Box::new(|scene| scene.sky.as_mut().expect("there is one").rotation = Track::from(0.1)),
        ),
    ];
    let (kept, mut scene) = (KeptLight::default(), grove());
    assert!(solved(&scene, Bounces::UpTo(1), &kept), "at first there is none");
    for (name, change) in changes {
        change(&mut scene);
        assert!(solved(&scene, Bounces::UpTo(1), &kept), "{name}");
    }
}

#[test]
fn it_does_not_show_whether_light_was_kept() {
    let size = Size { width: 32, height: 18 };
    let job = Job {
        size,
        window: Window::whole(size),
        passes: vec![],
        sampling: Sampling::Until { tolerance: 0.2, most: 8 },
        filter: PixelFilter::Box,
        seed: 0,
        mirror_depth: 0,
        bounces: Bounces::All,
        method: Method::Auto,
    };
    let kept = KeptLight::default();
    let mut scene = grove();
    for _ in 0..2 {
        let trees = MeshTrees::new(&scene);
        let exposure = Exposure::new(&scene, &trees, 0, 16.0 / 9.0, INSTANT);
        let alone = render(&exposure, &job, &Watch::NOBODY);
        assert_eq!(alone, render_keeping(&exposure, &job, &kept, &Watch::NOBODY));
        moved_camera(&mut scene);
    }
}
