//! Scenes written as glTF and read back. They give the same pictures and the same places. An independent
//! reader (the `gltf` crate's own JSON types and validation) takes the file too.

use crate::checkout;
use glam::{DAffine3, DMat3, DMat4, DVec3};
use std::collections::BTreeMap;
use std::path::Path;
use sunfleck::color::Rgb;
use sunfleck::description;
use sunfleck::diagnostic::Severity;
use sunfleck::export;
use sunfleck::film::Frame;
use sunfleck::render::{Job, Method, Watch, render};
use sunfleck::scene::{
    self, AlphaMode, Light, LightKind, Material, Motion, Node, RenderSettings, Sampling, Scene, SunShows,
    Track, Window,
};
use sunfleck::snapshot::{Exposure, MeshTrees, Shutter};

fn load(path: &Path) -> (Scene, RenderSettings) {
    let description = description::load(path).unwrap();
    scene::resolve(description, None).unwrap_or_else(|problems| panic!("{problems}"))
}

fn repository(path: &str) -> std::path::PathBuf {
    checkout::file(path)
}

/// The file's bytes; nothing may be lost.
fn written(scene: &Scene, settings: &RenderSettings) -> Vec<u8> {
    let exported = export::glb(scene, settings, Path::new("")).unwrap();
    assert!(exported.remarks.0.is_empty(), "{}", exported.remarks);
    [exported.head, exported.binary].concat()
}

/// The scene as it is after a journey through a file; our own reader must have nothing to say, nor
/// must the `gltf` crate.
fn through_gltf(scene: &Scene, settings: &RenderSettings) -> (Scene, RenderSettings) {
    let bytes = written(scene, settings);
    gltf::Gltf::from_slice(&bytes).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.glb");
    std::fs::write(&path, bytes).unwrap();
    let (again, settings) = load(&path);
    // Beyond what it said of the scene itself.
    let is_new = |found: &str| scene.remarks.0.iter().all(|remark| remark.found != found);
    let loud =
        again.remarks.0.iter().filter(|remark| remark.severity > Severity::Note && is_new(&remark.found));
    let loud: Vec<_> = loud.collect();
    assert!(loud.is_empty(), "{loud:?}");
    (again, settings)
}

pub(crate) fn picture(scene: &Scene, settings: &RenderSettings, frame: i64) -> Frame {
    let trees = MeshTrees::new(scene);
    rendered(&exposure(scene, &trees, settings, frame), settings)
}

fn exposure<'a>(
    scene: &'a Scene,
    trees: &'a MeshTrees,
    settings: &RenderSettings,
    frame: i64,
) -> Exposure<'a> {
    let camera =
        scene.cameras.iter().position(|camera| settings.camera.as_ref() == Some(&camera.name)).unwrap_or(0);
    let aspect = settings.size.width as f64 / settings.size.height as f64;
    Exposure::new(scene, trees, camera, aspect, Shutter::of(settings, frame as f64))
}

fn rendered(exposure: &Exposure, settings: &RenderSettings) -> Frame {
    let job = Job {
        size: settings.size,
        window: Window::whole(settings.size),
        passes: Vec::new(),
        sampling: Sampling::Exactly(4),
        filter: settings.filter,
        seed: settings.seed,
        mirror_depth: settings.mirror_depth,
        bounces: sunfleck::scene::Bounces::NONE,
        method: Method::Auto,
    };
    render(exposure, &job, &Watch::NOBODY).frame
}

/// How one picture differs from another.
#[derive(Default)]
struct Difference {
    pixels: usize,
    /// Pixels that differ by more than [`EDGE`]: each with the largest difference of a
    /// channel, over the mean.
    apart: Vec<f64>,
    /// How many of them there are, those that touch one before counted with it.
    groups: usize,
    /// Of all others: sum of squares over the square of the mean, and the number of values.
    squares: f64,
    values: usize,
}

impl Difference {
    fn add(&mut self, a: &Frame, b: &Frame) {
        let width = a.window.width;
        let [a, b] = [a, b].map(|frame| ["R", "G", "B"].map(|name| &frame.channel(name).unwrap().pixels));
        let values = || a.iter().flat_map(|channel| channel.iter()).map(|value| f64::from(*value));
        let mean = values().sum::<f64>() / values().count() as f64;
        let mut apart: Vec<(usize, usize)> = Vec::new();
        for pixel in 0..a[0].len() {
            let differences = [0, 1, 2].map(|c| f64::from(a[c][pixel] - b[c][pixel]).abs() / mean);
            let largest = differences.into_iter().fold(0.0, f64::max);
            self.pixels += 1;
            if largest > EDGE {
                let (x, y) = (pixel % width, pixel / width);
                let is_near = apart.iter().any(|at| at.0.abs_diff(x) <= 1 && at.1.abs_diff(y) <= 1);
                self.groups += usize::from(!is_near);
                self.apart.push(largest);
                apart.push((x, y));
            } else {
                self.squares +=
                    differences.into_iter().map(|difference| difference * difference).sum::<f64>();
                self.values += 3;
            }
        }
    }

    /// Of the pixels that are not apart.
    fn relative_rmse(&self) -> f64 {
        (self.squares / self.values as f64).sqrt()
    }
}

/// Places and pictures of a scene before and after, at some frames, with several seeds.
fn check(input: &str, size_percent: f64, frames: &[i64], bar: f64) {
    let (scene, settings) = load(&repository(input));
    check_scene(input, scene, settings, size_percent, frames, bar);
}

fn check_scene(
    input: &str,
    scene: Scene,
    mut settings: RenderSettings,
    size_percent: f64,
    frames: &[i64],
    bar: f64,
) {
    let side = |side: usize| (side as f64 * size_percent / 100.0).round() as usize;
    (settings.size.width, settings.size.height) = (side(settings.size.width), side(settings.size.height));
    // Without a choice it is the first; the file names it.
    settings.camera.get_or_insert_with(|| scene.cameras[0].name.clone());
    let (again, settings_again) = through_gltf(&scene, &settings);
    assert_eq!(RenderSettings { name: settings.name.clone(), ..settings_again.clone() }, settings);
    let mut difference = Difference::default();
    for &frame in frames {
        let time_s = settings.frame_rate.seconds(frame as f64);
        let (before, after) = (scene.placements(time_s), again.placements(time_s));
        let mut named: BTreeMap<&str, Vec<_>> = BTreeMap::new();
        for (node, placement) in again.nodes.iter().zip(&after) {
            named.entry(&node.name).or_default().push(placement);
        }
        for (node, placement) in scene.nodes.iter().zip(&before) {
            let near = named.get(node.name.as_str()).into_iter().flatten().any(|other| {
                let size = placement.world_from_node.translation.abs().max_element().max(1.0);
                other.world_from_node.abs_diff_eq(placement.world_from_node, 1e-6 * size)
            });
            assert!(near, "{input}: `{}` at frame {frame}", node.name);
        }
        let trees = [&again, &scene].map(MeshTrees::new);
        let exposures = [
            exposure(&again, &trees[0], &settings_again, frame),
            exposure(&scene, &trees[1], &settings, frame),
        ];
        for seed in SEEDS {
            let of = |exposure: &Exposure, settings: &RenderSettings| {
                rendered(exposure, &RenderSettings { seed, ..settings.clone() })
            };
            difference.add(&of(&exposures[0], &settings_again), &of(&exposures[1], &settings));
        }
    }
    let Difference { pixels, apart, groups, .. } = &difference;
    let error = difference.relative_rmse();
    println!("{input}: relative RMSE {error:.1e}, of {pixels} pixels apart in {groups} places: {apart:.4?}");
    assert!(error < bar, "{input}: relative RMSE {error}");
    let most = (MOST_APART * *pixels as f64).ceil() as usize;
    assert!(*groups <= most, "{input}: of {pixels} pixels apart in {groups} places: {apart:.4?}");
}

const SEEDS: std::ops::Range<u32> = 0..3;

// Keys in single precision move leaves by up to a millionth of a metre.
const SAME: f64 = 3e-5;

/// A pixel that differs by more, over the mean, has a sample on the other side of an edge. With four
/// samples a pixel, one slice to its width, such a sample shows whole; where there is none no pixel
/// differs by a third of this.
const EDGE: f64 = 1e-3;

/// How many pixels may have one; a sample counts in up to a few, side by side, as swaths of slices reach
/// beyond a pixel. A sample has one if an edge is as near to it as a leaf has moved: in an earlier
/// `falling_leaves` the shadow of a leaf ended on the ground 0.15 micrometres from one, which the file moved
/// by 0.29. With all keys moved by one micrometre there were 60 such pixels, and the others missed [`SAME`].
const MOST_APART: f64 = 5e-5;

#[test]
fn falling_leaves_look_the_same() {
    check("sequences/falling_leaves.ron", 15.0, &[1, 24], SAME);
}

#[test]
fn first_leaf_looks_the_same() {
    check("sequences/first_leaf.ron", 75.0, &[1, 7, 48], SAME);
}

#[test]
fn a_scene_from_blender_looks_the_same() {
    check("tests/data/blender/a_leaves40_sampled.glb", 10.0, &[1, 21, 60], SAME);
}

/// Coats, normal maps, maps with coordinates of their own, vertex colours, light through glass.
#[test]
fn blenders_materials_look_the_same() {
    check("tests/data/blender/g_pbr.glb", 25.0, &[1], SAME);
}

#[test]
fn skins_and_morph_targets_look_the_same() {
    for input in ["tests/data/blender/d_skin.glb", "tests/data/blender/c_morph.glb"] {
        let (mut scene, settings) = load(&repository(input));
        assert!(scene.instances.iter().any(|instance| instance.deformation.is_some()));
        // These files have no lights.
        let down = DAffine3::from_rotation_x(-1.0);
        let visible = Track::from(true);
        scene.nodes.push(Node { name: "sun".into(), parent: None, motion: Motion::Still(down), visible });
        let (node, power) = (scene.nodes.len() - 1, Track::from(Rgb::splat(3.0)));
        scene.lights.push(Light { name: "sun".into(), node, power, kind: LightKind::Sun });
        let mut small = settings.clone();
        (small.size.width, small.size.height) = (settings.size.width / 2, settings.size.height / 2);
        let [first, later] = [28, 36].map(|frame| picture(&scene, &small, frame));
        let mut moved = Difference::default();
        moved.add(&first, &later);
        assert!(moved.apart.len() > 100, "{input}: {} pixels change", moved.apart.len());
        check_scene(input, scene, settings, 15.0, &[28, 36, 44], SAME);
    }
}

/// An image all around that lights, turned and tinted; its texels come back to the last bit.
#[test]
fn an_image_sky_looks_the_same() {
    let folder = tempfile::tempdir().unwrap();
    let texel = |x: usize, y: usize| {
        let glow = 1.0 / (0.1 + (x as f32 - 3.0).abs() + y as f32);
        (glow, 0.3 + 0.01 * x as f32, 1e-3 + 0.02 * y as f32)
    };
    exr::prelude::write_rgb_file(folder.path().join("sky.exr"), 16, 8, texel).unwrap();
    let path = folder.path().join("scene.ron");
    std::fs::write(
        &path,
        r#"Scene(version: 1, meshes: { "ground": Quad(size_m: 4.0) }, objects: { "ground": (mesh: "ground") },
            cameras: { "main": (position_m: (0.0, 1.0, 3.0), look_at_m: (0.0, 0.8, 0.0)) },
            sky: Image(image: "sky.exr", strength_w_per_m2_sr: (1.0, 0.5, 2.0), rotation_deg: 40.0))"#,
    )
    .unwrap();
    let (scene, mut settings) = load(&path);
    (settings.size.width, settings.size.height) = (48, 27);
    let (again, _) = through_gltf(&scene, &settings);
    let (found, expected) = (again.sky.as_ref().unwrap(), scene.sky.as_ref().unwrap());
    let (scene::SkyPicture::Image(a), scene::SkyPicture::Image(b)) = (found.picture(), expected.picture())
    else {
        panic!("{found:?}");
    };
    assert_eq!((a.width, a.height), (b.width, b.height));
    assert!(a.texels.iter().zip(b.texels.iter()).all(|(a, b)| a[..3] == b[..3]));
    assert_eq!(found.lights, expected.lights);
    let mut difference = Difference::default();
    difference.add(&picture(&scene, &settings, 1), &picture(&again, &settings, 1));
    assert!(difference.apart.is_empty() && difference.relative_rmse() < 1e-6);
}

/// An image, a fractal that turns and changes under a disc that grows, and a darker limb,
/// on suns that are seen.
#[test]
fn pictures_on_suns_look_the_same() {
    let folder = tempfile::tempdir().unwrap();
    let texel = |x: u32, y: u32| image::Rgb([(x * 999) as u16, (y * 2500) as u16, 65_535 - (x * y) as u16]);
    image::ImageBuffer::<image::Rgb<u16>, Vec<u16>>::from_fn(40, 24, texel)
        .save(folder.path().join("sun.png"))
        .unwrap();
    let path = folder.path().join("scene.ron");
    std::fs::write(
        &path,
        r#"Scene(version: 1, meshes: { "ground": Quad(size_m: 4.0) }, objects: { "ground": (mesh: "ground") },
            cameras: { "main": (position_m: (0.0, 1.0, 3.0), look_at_m: (0.0, 1.6, 0.0), fov_deg: 60.0) },
            lights: {
                "image": Sun(to_sun: (-0.5, 0.3, -1.0), irradiance_w_per_m2: (3.0, 2.0, 1.0),
                    angular_diameter_deg: 15.0, image: "sun.png", picture_rotation_deg: 40.0, visible_to_camera: true),
                "fractal": Sun(to_sun: (0.0, 0.4, -1.0), irradiance_w_per_m2: 2.0, visible_to_camera: true,
                    angular_diameter_deg: Keyed(keys: [(at_s: 0.0, value: 0.0), (at_s: 1.0, value: 20.0)]),
                    fractal: (real: Keyed(keys: [(at_s: 0.0, value: -0.5), (at_s: 1.0, value: 0.1)]),
                        imaginary: 0.56805, iterations: 40),
                    limb_darkening: 0.3,
                    picture_rotation_deg: Keyed(keys: [(at_s: 0.0, value: 0.0), (at_s: 1.0, value: 90.0)])),
                "limb": Sun(to_sun: (0.5, 0.3, -1.0), irradiance_w_per_m2: 1.0, angular_diameter_deg: 10.0,
                    limb_darkening: 0.6, visible_to_camera: true),
            })"#,
    )
    .unwrap();
    let (scene, mut settings) = load(&path);
    (settings.size.width, settings.size.height) = (64, 36);
    settings.frames = 0..=24;
    let (again, _) = through_gltf(&scene, &settings);
    for (light, expected) in again.lights.iter().zip(&scene.lights) {
        let (LightKind::SunDisc(disc), LightKind::SunDisc(expected)) = (&light.kind, &expected.kind) else {
            panic!("{light:?}");
        };
        let (picture, expected_picture) =
            (disc.picture.as_ref().unwrap(), expected.picture.as_ref().unwrap());
        assert_eq!(picture.limb_darkening(), expected_picture.limb_darkening());
        match (picture.shows(), expected_picture.shows()) {
            (SunShows::Even, SunShows::Even) => {}
            (SunShows::Image(a), SunShows::Image(b)) => {
                assert_eq!((a.width, a.height, &a.texels, a.wrap), (b.width, b.height, &b.texels, b.wrap));
            }
            (SunShows::Julia(a), SunShows::Julia(b)) => {
                assert_eq!(a.iterations, b.iterations);
                assert!((a.real.at(0.7) - b.real.at(0.7)).abs() < 1e-6);
                assert_eq!(a.imaginary.at(0.7), b.imaginary.at(0.7));
            }
            (found, expected) => panic!("{found:?} in place of {expected:?}"),
        }
        for time_s in [0.0, 0.4, 1.0] {
            let turned = disc.picture_rotation.at(time_s) - expected.picture_rotation.at(time_s);
            let grown = disc.angular_diameter.at(time_s) - expected.angular_diameter.at(time_s);
            assert!(turned.abs() < 1e-6 && grown.abs() < 1e-6, "{} at {time_s}", light.name);
        }
        assert_eq!(disc.visible_to_camera, expected.visible_to_camera);
    }
    let mut difference = Difference::default();
    for frame in [0, 11, 24] {
        difference.add(&picture(&scene, &settings, frame), &picture(&again, &settings, frame));
    }
    let (apart, error) = (difference.apart.len(), difference.relative_rmse());
    println!("pictures on suns: relative RMSE {error:.1e}, {apart} of {} pixels apart", difference.pixels);
    assert!(apart == 0 && error < SAME, "{:?}", difference.apart);
}

#[test]
fn sheared_mirrored_and_flat_places_stay() {
    let mut scene = Scene::default();
    let shear = DMat3::from_cols(DVec3::X, DVec3::new(0.7, 1.0, 0.1), DVec3::new(0.0, -0.4, 2.0));
    let mirrored = DMat3::from_diagonal(DVec3::new(1.0, -2.0, 1.0)) * shear;
    let flat = DMat3::from_cols(DVec3::X, DVec3::new(0.5, 1.0, 0.0), DVec3::ZERO);
    for (index, matrix) in [shear, mirrored, flat, -DMat3::IDENTITY].into_iter().enumerate() {
        scene.nodes.push(Node {
            name: format!("place {index}"),
            parent: index.checked_sub(1).filter(|_| index == 1),
            motion: Motion::Still(DAffine3::from_mat3_translation(matrix, DVec3::new(1.0, 2.0, 3.0))),
            visible: Track::from(true),
        });
    }
    let bytes = written(&scene, &RenderSettings::default());
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.glb");
    std::fs::write(&path, bytes).unwrap();
    let (again, _) = load(&path);
    let (before, after) = (scene.placements(0.0), again.placements(0.0));
    for (node, placement) in scene.nodes.iter().zip(before) {
        let found = again.nodes.iter().position(|other| other.name == node.name).unwrap();
        let difference = after[found].world_from_node.abs_diff_eq(placement.world_from_node, 1e-12);
        assert!(difference, "{}: {} {}", node.name, placement.world_from_node, after[found].world_from_node);
    }
}

#[test]
fn lights_fog_and_surfaces_that_gltf_cannot_say_come_back() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.ron");
    std::fs::write(&path, SCENE).unwrap();
    let (scene, settings) = load(&path);
    let (again, settings_again) = through_gltf(&scene, &settings);
    assert_eq!(format!("{:?}", settings_again.sampling), format!("{:?}", settings.sampling));
    let near = |a: Rgb, b: Rgb| (a - b).abs().max_element() <= 1e-12 * a.abs().max_element();
    for light in &scene.lights {
        let other = again.lights.iter().find(|other| other.name == light.name).unwrap();
        assert!(near(other.power.at(0.0), light.power.at(0.0)), "{}", light.name);
        let numbers = |light: &scene::Light| -> Vec<f64> {
            light.kind.numbers().iter().map(|(_, number)| number.at(0.0)).collect()
        };
        assert_eq!(
            std::mem::discriminant(&other.kind),
            std::mem::discriminant(&light.kind),
            "{}",
            light.name
        );
        let pairs = numbers(other).into_iter().zip(numbers(light));
        for (found, expected) in pairs {
            assert!((found - expected).abs() < 1e-8, "{}: {found} {expected}", light.name);
        }
    }
    for fog in &scene.fogs {
        let other = again.fogs.iter().find(|other| other.name == fog.name).unwrap();
        assert_eq!(format!("{:?}", other.shape), format!("{:?}", fog.shape));
        assert!(near(other.density_per_m.at(0.0), fog.density_per_m.at(0.0)));
        assert!(near(other.albedo.at(0.0), fog.albedo.at(0.0)));
        assert_eq!(other.anisotropy.at(0.0), fog.anisotropy.at(0.0));
    }
    assert_eq!(again.background, scene.background);
    let described = |material: &Material| {
        let alpha = match material.alpha_mode {
            AlphaMode::Blend => material.opacity,
            _ => -1.0,
        };
        format!(
            "{} {} {} {} {alpha}",
            material.base_color, material.mirror, material.filter_color, material.emission
        )
    };
    for material in &scene.materials {
        let other = again.materials.iter().find(|other| other.name == material.name).unwrap();
        assert_eq!(described(other), described(material), "{}", material.name);
    }
    let focus = |scene: &Scene| {
        let aperture = scene.cameras[1].aperture.as_ref().unwrap();
        (aperture.f_stop.at(0.0), aperture.focus_distance_m.at(0.0), aperture.blades)
    };
    assert_eq!(focus(&again), focus(&scene));
    let projections = |scene: &Scene| -> Vec<DMat4> {
        scene.cameras.iter().map(|camera| camera.projection(16.0 / 9.0, 0.0)).collect()
    };
    for (found, expected) in projections(&again).into_iter().zip(projections(&scene)) {
        assert!(found.abs_diff_eq(expected, 1e-12), "{found} {expected}");
    }
}

const SCENE: &str = r#"Scene(
    version: 1,
    meshes: { "quad": Quad(size_m: 1.0) },
    materials: {
        "pond": (base_color: (0.02, 0.03, 0.04), mirror: 0.6),
        "mirror": (base_color: 0.0, mirror: (0.9, 0.8, 0.7)),
        "window": (base_color: 0.0, filter_color: (0.8, 0.3, 0.1)),
        "birch": (base_color: 0.5, transmission: (0.4, 0.5, 0.1)),
        "veil": (base_color: 0.5, opacity: 0.25),
        "lamp": (base_color: 0.0, emission_w_per_m2_sr: (8.0, 4.0, 2.0)),
    },
    objects: {
        "a": (mesh: "quad", material: "pond"), "g": (mesh: "quad", material: "birch"), "b": (mesh: "quad", material: "mirror"),
        "c": (mesh: "quad", material: "window"), "d": (mesh: "quad", material: "veil"),
        "e": (mesh: "quad", material: "lamp"), "f": (rotation_deg: (0.0, 0.0, 20.0)),
    },
    cameras: { "plan": (position_m: (0.0, 9.0, 0.0), orthographic_height_m: 4.0), "main": (position_m: (0.0, 1.2, 4.0), aperture: (f_stop: 2.8, focus_distance_m: 3.5, blades: 6)) },
    lights: {
        "sun": Sun(to_sun: (0.4, 1.0, -0.6), irradiance_w_per_m2: (8.0, 7.2, 6.0), angular_diameter_deg: 0.53, visible_to_camera: true),
        "glow": Point(position_m: (0.0, 1.0, 0.0), intensity_w_per_sr: 2.0),
        "bulb": Point(position_m: (1.0, 2.0, 0.0), intensity_w_per_sr: (2.0, 0.0, 1.0), radius_m: 0.03),
        "lamp": Spot(position_m: (2.0, 3.0, 0.0), target_m: (0.0, 0.0, 0.0), outer_deg: 90.0, blend: 0.0, intensity_w_per_sr: 20.0, radius_m: 0.1),
        "soft": Spot(position_m: (2.0, 3.0, 0.0), target_m: (0.0, 0.0, 0.0), outer_deg: 30.0, blend: 1.0, intensity_w_per_sr: 0.0),
        "window": Rectangle(position_m: (-3.0, 2.0, 0.0), target_m: (0.0, 1.0, 0.0), width_m: 2.0, height_m: 1.0, power_w: (40.0, 10.0, 0.0)),
        "porthole": Disc(position_m: (3.0, 2.0, 0.0), target_m: (0.0, 1.0, 0.0), diameter_m: 0.5, power_w: 10.0),
    },
    fog: {
        "haze": (min_m: (-4.0, 0.0, -4.0), max_m: (4.0, 3.0, 4.0), density_per_m: (0.1, 0.2, 0.3), anisotropy: 0.5),
        "thin": (parent: "f", min_m: (-1.0, 0.0, -1.0), max_m: (1.0, 1.0, 1.0), density_per_m: 0.5, scale_height_m: 2.0),
        "mist": (scale_height_m: 1.5, base_m: 0.2, density_per_m: 0.08, albedo: (0.9, 0.8, 0.7)),
    },
    background_w_per_m2_sr: (0.3, 0.16, 0.06),
)"#;

#[test]
fn values_that_change_come_back() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.ron");
    std::fs::write(&path, CHANGING).unwrap();
    let (scene, mut settings) = load(&path);
    settings.frames = 0..=24;
    let (again, _) = through_gltf(&scene, &settings);
    let near = |found: f64, expected: f64| (found - expected).abs() <= 1e-6 * expected.abs().max(1e-3);
    for frame in [0.0, 3.0, 8.0, 12.0, 24.0] {
        let time_s = settings.frame_rate.seconds(frame);
        for light in &scene.lights {
            let other = again.lights.iter().find(|other| other.name == light.name).unwrap();
            let (found, expected) = (other.power.at(time_s), light.power.at(time_s));
            assert!((0..3).all(|channel| near(found[channel], expected[channel])), "{} {frame}", light.name);
            for (found, expected) in other.kind.numbers().into_iter().zip(light.kind.numbers()) {
                assert!(near(found.1.at(time_s), expected.1.at(time_s)), "{} {frame}", light.name);
            }
        }
        for fog in &scene.fogs {
            let other = again.fogs.iter().find(|other| other.name == fog.name).unwrap();
            assert!(near(other.density_per_m.at(time_s).y, fog.density_per_m.at(time_s).y), "{frame}");
            assert!(near(other.albedo.at(time_s).z, fog.albedo.at(time_s).z), "{frame}");
            assert!(near(other.anisotropy.at(time_s), fog.anisotropy.at(time_s)), "{frame}");
            let height = |fog: &scene::Fog| fog.shape.falloff().unwrap().scale_height_m.at(time_s);
            assert!(near(height(other), height(fog)), "{frame}");
        }
        let (lens, other) = (&scene.cameras[0], &again.cameras[0]);
        assert!(near(other.lens.number().at(time_s), lens.lens.number().at(time_s)), "{frame}");
        let focus = |camera: &scene::Camera| {
            let aperture = camera.aperture.as_ref().unwrap();
            (aperture.f_stop.at(time_s), aperture.focus_distance_m.at(time_s))
        };
        let (found, expected) = (focus(other), focus(lens));
        assert!(near(found.0, expected.0) && near(found.1, expected.1), "{frame}");
        let shown = |scene: &Scene| {
            let node = scene.nodes.iter().position(|node| node.name == "blinking").unwrap();
            scene.placements(time_s)[node].visible
        };
        assert_eq!(shown(&again), shown(&scene), "{frame}");
    }
}

const CHANGING: &str = r#"Scene(
    version: 1,
    meshes: { "quad": Quad(size_m: 1.0) },
    objects: { "blinking": (mesh: "quad", visible: Keyed(keys: [(at_s: 0.0, value: true), (at_s: 0.5, value: false)])) },
    cameras: { "main": (fov_deg: Keyed(keys: [(at_s: 0.0, value: 30.0), (at_s: 1.0, value: 60.0)]), aperture: (
        f_stop: Keyed(keys: [(at_s: 0.0, value: 2.0), (at_s: 1.0, value: 4.0)]),
        focus_distance_m: Keyed(keys: [(at_s: 0.0, value: 1.0), (at_s: 1.0, value: 3.0)]))) },
    lights: {
        "sun": Sun(to_sun: (0.4, 1.0, -0.6), irradiance_w_per_m2: Keyed(keys: [(at_s: 0.0, value: (8.0, 7.0, 6.0)), (at_s: 1.0, value: (1.0, 2.0, 9.0))]),
            angular_diameter_deg: Keyed(keys: [(at_s: 0.0, value: 0.5), (at_s: 1.0, value: 2.0)])),
        "bulb": Point(position_m: (1.0, 2.0, 0.0), intensity_w_per_sr: Keyed(keys: [(at_s: 0.0, value: 2.0, to_next: Step), (at_s: 0.5, value: 5.0)]),
            radius_m: Keyed(keys: [(at_s: 0.0, value: 0.1), (at_s: 1.0, value: 0.2)])),
        "lamp": Spot(position_m: (2.0, 3.0, 0.0), target_m: (0.0, 0.0, 0.0), outer_deg: Keyed(keys: [(at_s: 0.0, value: 20.0), (at_s: 1.0, value: 40.0)]),
            blend: Keyed(keys: [(at_s: 0.0, value: 0.1), (at_s: 1.0, value: 0.9)]), intensity_w_per_sr: 20.0),
        "window": Rectangle(position_m: (-3.0, 2.0, 0.0), target_m: (0.0, 1.0, 0.0), width_m: Keyed(keys: [(at_s: 0.0, value: 1.0), (at_s: 1.0, value: 2.0)]),
            height_m: Keyed(keys: [(at_s: 0.0, value: 3.0), (at_s: 1.0, value: 4.0)]), power_w: Keyed(keys: [(at_s: 0.0, value: 40.0), (at_s: 1.0, value: (10.0, 20.0, 30.0))])),
    },
    fog: { "thin": (min_m: (-1.0, 0.0, -1.0), max_m: (1.0, 1.0, 1.0), density_per_m: Keyed(keys: [(at_s: 0.0, value: 0.1), (at_s: 1.0, value: 0.5)]),
        albedo: Keyed(keys: [(at_s: 0.0, value: 0.9), (at_s: 1.0, value: (0.1, 0.2, 0.3))]), anisotropy: Keyed(keys: [(at_s: 0.0, value: -0.5), (at_s: 1.0, value: 0.5)]),
        scale_height_m: Keyed(keys: [(at_s: 0.0, value: 1.0), (at_s: 1.0, value: 2.0)])) },
)"#;
