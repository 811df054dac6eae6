//! The public face: what a program can load, build, ask for and get. Invariant: only names at the
//! crate's root are used here.

use crate::checkout;
use std::collections::BTreeSet;
use std::fs;
use std::path::Path;
use std::process::Command;
use sunfleck::{
    Animated, Aperture, Bounces, Camera, Emitter, Fall, FallGround, FallMotion, Fog, Julia, Light, Material,
    Method, Mist, MistShape, NormalMap, Object, Pass, RenderError, Renderer, Scene, SceneBuilder, Setting,
    Shape, Sky, SkyLight, Species, Sun, Triangles, Wind, Window,
};

#[test]
fn who_uses_the_library_gets_no_command_line() {
    let mut cargo = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    cargo.args(["tree", "--locked", "--no-default-features", "--edges", "normal", "--prefix", "none"]);
    let said = cargo.current_dir(checkout::file("")).output().unwrap();
    let tree = String::from_utf8_lossy(&said.stdout);
    let crates: BTreeSet<&str> = tree.lines().filter_map(|line| line.split(' ').next()).collect();
    assert!(crates.contains("glam"), "{tree}{}", String::from_utf8_lossy(&said.stderr));
    for name in ["clap", "clap_complete", "cpu-time", "csv", "indicatif", "signal-hook", "tev_client"] {
        assert!(!crates.contains(name), "{tree}");
    }
}

/// A tile before the camera that moves to the right by 0.1 m a frame, a lamp, and some fog.
fn tile() -> SceneBuilder {
    let moving = Object::of("tile", "grey").with(|object| {
        object.translation_m = Animated::keys([(0.0, [0.0, 0.0, 0.0]), (1.0, [2.4, 0.0, 0.0])])
    });
    let lamp = Light::point([0.0, 1.0, 3.0], [5.0; 3]);
    Scene::builder()
        .mesh("tile", square())
        .material("grey", Material::matte([0.5; 3]))
        .object("moving", moving)
        .camera("main", Camera::default().with(|camera| camera.position_m = [0.0, 0.0, 4.0].into()))
        .light("lamp", lamp)
        .fog("haze", Fog::in_box([-3.0; 3], [3.0; 3], 0.1))
}

/// Two metres wide, in the x-y plane, facing +z.
fn square() -> Triangles {
    Triangles::new(
        vec![[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]],
        vec![[0, 1, 2], [0, 2, 3]],
    )
}

fn built(builder: SceneBuilder) -> Scene {
    builder.build().unwrap_or_else(|error| panic!("{error}"))
}

/// What is said of a scene that cannot be built.
fn refused(builder: SceneBuilder) -> String {
    builder.build().expect_err("it cannot be built").diagnostics().to_string()
}

fn small(scene: &Scene) -> Renderer<'_> {
    Renderer::new(scene).size(16, 9).samples(4)
}

#[test]
fn every_pass_that_is_asked_for_has_its_values() {
    let scene = built(tile());
    let renderer = small(&scene).frame(2).passes(Pass::ALL.iter().copied());
    let frame = renderer.bounces(Bounces::All).render().expect("a frame");
    for &pass in Pass::ALL {
        let array = frame.pass(pass).unwrap_or_else(|| panic!("{pass:?} is there"));
        assert_eq!((array.width, array.height), (16, 9));
        assert_eq!(array.values.len(), 16 * 9 * array.channels.len(), "{pass:?}");
        assert!(array.at(8, 4).expect("a pixel").iter().any(|&value| value != 0.0), "{pass:?} is zero");
        assert_eq!(frame.channel(&array.channels[0]).expect("the first").unit, array.unit, "{pass:?}");
    }
    let value = |pass: Pass, channel: usize| {
        f64::from(frame.pass(pass).expect("there").at(8, 4).expect("a pixel")[channel])
    };
    assert!((value(Pass::Depth, 0) - 4.0).abs() < 1e-5);
    assert!((value(Pass::Normal, 2) - 1.0).abs() < 1e-5);
    // A picture 9 pixels high shows 2 * 4 * tan(22.5 degrees) metres at that depth; vectors point
    // to where things were.
    let pixels_per_m = 9.0 / (8.0 * 22.5_f64.to_radians().tan());
    assert!((value(Pass::Motion, 0) + 0.1 * pixels_per_m).abs() < 1e-4, "{}", value(Pass::Motion, 0));
    assert_eq!(frame.pass(Pass::Normal).expect("there").channels, ["Normal.X", "Normal.Y", "Normal.Z"]);
}

#[test]
fn frames_of_a_sequence_are_those_that_they_are_alone() {
    let scene = built(tile());
    let renderer = small(&scene).bounces(Bounces::All);
    let frames = renderer.sequence([2, 0, 1]).expect("frames");
    assert_eq!(frames.len(), 3);
    for (frame, number) in frames.zip([2, 0, 1]) {
        let (frame, alone) =
            (frame.expect("a frame"), renderer.clone().frame(number).render().expect("a frame"));
        assert_eq!((frame.number(), frame.beauty()), (number, alone.beauty()));
    }
    let leaf = Scene::load("sequences/first_leaf.ron").unwrap_or_else(|error| panic!("{error}"));
    let refused = small(&leaf).sequence([1, 1_000_000]).err().expect("no such frame");
    assert!(matches!(refused, RenderError::Setting { setting: Setting::Frame, .. }), "{refused}");
    let cancelled = small(&leaf).cancelled(&|| true).sequence([1]).expect("a frame").next();
    assert!(matches!(cancelled, Some(Err(RenderError::Cancelled))));
}

#[test]
fn arrays_become_images_without_a_copy() {
    let scene = built(tile());
    let beauty = small(&scene).render().expect("a frame").beauty();
    assert_eq!(beauty.shape(), [9, 16, 4]);
    let (place, pixel) = (beauty.values.as_ptr(), beauty.at(8, 4).expect("a pixel").to_vec());
    let beauty = image::Rgb32FImage::try_from(beauty).expect_err("it has alpha");
    let image = image::Rgba32FImage::try_from(beauty).expect("as many channels");
    assert_eq!((image.as_ptr(), image.get_pixel(8, 4).0.to_vec()), (place, pixel));
}

#[test]
fn passes_that_nobody_asked_for_are_not_there() {
    let scene = built(tile());
    let frame = small(&scene).passes([Pass::Depth]).render().expect("a frame");
    assert!(frame.pass(Pass::Normal).is_none());
    let names: BTreeSet<&str> = frame.channel_names().collect();
    assert_eq!(names, ["A", "B", "G", "R", "Z"].into());
    let beauty = frame.beauty();
    assert_eq!(beauty.channels, ["R", "G", "B", "A"]);
    assert_eq!(
        beauty.at(8, 4).expect("a pixel")[0],
        frame.channel("R").expect("red").at(8, 4).expect("a pixel")[0]
    );
    assert_eq!((beauty.at(16, 0), beauty.at(0, 9), beauty.at(usize::MAX, usize::MAX)), (None, None, None));
}

#[test]
fn every_method_is_the_one_that_was_asked_for() {
    let scene = built(tile());
    let frame = |method: Method| small(&scene).method(method).render().expect("a frame");
    assert!(frame(Method::Slices).statistics().from_slices);
    let exact = frame(Method::Segments);
    assert!(!exact.statistics().from_slices);
    let march = |steps: u32| frame(Method::March(sunfleck::MarchSteps::Count(steps)));
    let difference =
        |other: &sunfleck::Frame| (other.beauty().mean()[0] / exact.beauty().mean()[0] - 1.0).abs();
    let (coarse, fine) = (march(1), march(256));
    assert!(difference(&coarse) > 20.0 * difference(&fine), "{} {}", difference(&coarse), difference(&fine));
    assert!(difference(&fine) < 1e-3, "{}", difference(&fine));
}

#[test]
fn a_crop_has_the_pixels_of_the_whole() {
    let scene = built(tile());
    let whole = small(&scene).render().expect("a frame").beauty();
    let crop = Window { x: 5, y: 2, width: 6, height: 3 };
    let part = small(&scene).crop(crop).render().expect("a part").beauty();
    assert_eq!((part.width, part.height), (6, 3));
    assert_eq!(part.at(1, 2), whole.at(6, 4));
}

#[test]
fn wishes_that_cannot_be_met_are_named() {
    let scene = built(tile());
    let frames = [
        (small(&scene).camera("other"), Setting::Camera),
        (small(&scene).size(0, 9), Setting::Size),
        (small(&scene).size(1 << 40, 1 << 40), Setting::Size),
        (small(&scene).crop(Window { x: 10, y: 0, width: 7, height: 9 }), Setting::Crop),
        (small(&scene).crop(Window { x: usize::MAX, y: 0, width: 7, height: 9 }), Setting::Crop),
        (small(&scene).crop(Window { x: 0, y: 0, width: 0, height: 9 }), Setting::Crop),
        (small(&scene).samples(0), Setting::Samples),
        (small(&scene).tolerance(0.0), Setting::Tolerance),
        (small(&scene).tolerance(f64::NAN), Setting::Tolerance),
        (small(&scene).shutter(-1.0), Setting::Shutter),
        (small(&scene).method(Method::Equiangular { points: 0 }), Setting::Method),
    ];
    for (renderer, expected) in frames {
        match renderer.render() {
            Err(error @ RenderError::Setting { setting, .. }) => {
                assert_eq!(setting, expected);
                let said = error.diagnostic();
                assert!(said.expected.is_some() && said.to_string().contains(&error.to_string()), "{error}");
                assert!(error.remedy().ends_with(&setting.to_string()), "{}", error.remedy());
            }
            other => panic!("{expected:?}: {:?}", other.map(|frame| frame.number())),
        }
    }
    assert!(matches!(small(&scene).cancelled(&|| true).render(), Err(RenderError::Cancelled)));
}

#[test]
fn nothing_invalid_can_be_built() {
    let nan = Fog::in_box([-1.0; 3], [1.0; 3], f64::NAN);
    assert!(refused(tile().fog("bad", nan)).contains("SceneBuilder: fog.bad.density_per_m"));
    let said = refused(tile().material("bad", Material::matte([2.0; 3])));
    assert!(said.contains("materials.bad.base_color") && said.contains("expected: "), "{said}");
    let twice = refused(tile().camera("main", Camera::default()));
    assert!(twice.contains("cameras.main: error: the name occurs a second time"), "{twice}");
    let stray = Object::default().with(|object| object.mesh = Some("tail".into()));
    assert!(refused(tile().object("stray", stray)).contains("there is no mesh named `tail`"));
    let backwards = Animated::keys([(1.0, [0.0; 3]), (0.0, [1.0; 3])]);
    let said =
        refused(tile().object("late", Object::default().with(|object| object.translation_m = backwards)));
    assert!(said.contains("objects.late.translation_m"), "{said}");
    for (field, mesh) in [
        ("positions", square().with(|triangles| triangles.positions = vec![[f32::INFINITY; 3]; 4])),
        ("normals", square().with(|triangles| triangles.normals = vec![[0.0, 0.0, 1.0]])),
        ("normals", square().with(|triangles| triangles.normals = vec![[0.0; 3]; 4])),
        ("uvs", square().with(|triangles| triangles.uvs = vec![[0.0; 2]; 3])),
        ("triangles[1]", square().with(|triangles| triangles.triangles = vec![[0, 1, 2], [0, 1, 4]])),
        ("triangles[0]", square().with(|triangles| triangles.triangles = vec![[0, 1, 1]])),
        ("triangles", square().with(|triangles| triangles.triangles = vec![])),
    ] {
        let said = refused(tile().mesh("bad", mesh));
        assert!(said.contains(&format!("SceneBuilder: meshes.bad.{field}: error: ")), "{said}");
    }
}

#[test]
fn what_is_on_and_off_jumps() {
    let blinking =
        Object::default().with(|object| object.visible = Animated::keys([(0.0, true), (0.5, false)]));
    let scene = built(tile().object("blinking", blinking));
    let seen = [0.0, 11.9, 12.1].map(|frame| scene.place("blinking", frame).expect("a node").visible);
    assert_eq!(seen, [true, true, false]);
    assert_eq!(scene.place("nobody", 0.0), None);
    let place = scene.place("moving", 6.0).expect("a node");
    assert!((place.position_m[0] - 0.6).abs() < 1e-12, "{place:?}");
}

#[test]
fn the_shape_of_a_builder_changes_nothing_that_it_holds() {
    // The same scene, from a file and from code.
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("scene.ron");
    let text = "Scene(version: 1, meshes: { \"ball\": Sphere(radius_m: 0.5) }, materials: { \"grey\": (base_color: 0.5) },
        objects: { \"ball\": (mesh: \"ball\", material: \"grey\") }, cameras: { \"main\": (position_m: (0.0, 0.0, 4.0)) },
        lights: { \"sun\": Sun(to_sun: (0.4, 1.0, 0.6), irradiance_w_per_m2: 3.0) })";
    fs::write(&file, text).expect("written");
    let read = Scene::load(&file).unwrap_or_else(|error| panic!("{error}"));
    let sun = Light::Sun(Sun::default().with(|sun| {
        sun.to_sun = Some([0.4, 1.0, 0.6].into());
        sun.irradiance_w_per_m2 = [3.0; 3].into();
    }));
    let made = Scene::builder()
        .shape("ball", Shape::sphere(0.5))
        .material("grey", Material::matte([0.5; 3]))
        .object("ball", Object::of("ball", "grey"))
        .camera("main", Camera::default().with(|camera| camera.position_m = [0.0, 0.0, 4.0].into()))
        .light("sun", sun);
    let picture = |scene: &Scene| small(scene).render().expect("a frame").beauty();
    let beauty = picture(&read);
    assert_eq!(beauty, picture(&built(made)));
    assert!(beauty.mean()[0] > 0.0);
}

/// A ball on a floor, seen from the front, to which each test adds its own part; and the
/// same as a file's fields.
fn stage() -> SceneBuilder {
    let object = |mesh: &str| Object::of(mesh, "grey");
    Scene::builder()
        .shape("ball", Shape::sphere(0.5))
        .shape("floor", Shape::quad(6.0))
        .object("ball", object("ball").with(|object| object.translation_m = [0.0, 0.6, 0.0].into()))
        .object("floor", object("floor"))
        .camera("main", Camera::default().with(|camera| camera.position_m = [0.0, 1.0, 4.0].into()))
}

const STAGE: &str = "version: 1, meshes: { \"ball\": Sphere(radius_m: 0.5), \"floor\": Quad(size_m: 6.0) },
    objects: { \"ball\": (mesh: \"ball\", material: \"grey\", translation_m: (0.0, 0.6, 0.0)),
        \"floor\": (mesh: \"floor\", material: \"grey\") }, cameras: { \"main\": (position_m: (0.0, 1.0, 4.0)) }";

fn grey() -> Material {
    Material::matte([0.5; 3])
}

/// The picture of what a program made, which a file of the same fields has too, and which is not black.
#[track_caller]
fn assert_same_picture(made: SceneBuilder, folder: &Path, fields: &str) {
    let file = folder.join("scene.ron");
    fs::write(&file, format!("Scene({STAGE}, {fields})")).expect("written");
    let read = Scene::load(&file).unwrap_or_else(|error| panic!("{error}"));
    // Direct light has a part of all that differs.
    let direct = |scene: &Scene| small(scene).bounces(Bounces::UpTo(0)).render().expect("a frame").beauty();
    let picture = direct(&built(made));
    assert_eq!(picture, direct(&read));
    assert!(picture.mean().iter().any(|&value| value > 0.0), "nothing is seen");
}

#[test]
fn lights_of_code_are_those_of_files() {
    let folder = tempfile::tempdir().expect("a folder");
    const GREY: &str = "materials: { \"grey\": (base_color: 0.5) }";
    let disc = Light::disc([0.5, 2.0, 1.0], [0.0; 3], 0.7, [9.0, 8.0, 7.0]);
    let text =
        "lights: { \"lit\": Disc(position_m: (0.5, 2.0, 1.0), target_m: (0.0, 0.0, 0.0), diameter_m: 0.7,
        power_w: (9.0, 8.0, 7.0)) }";
    let lit = |light: Light| stage().material("grey", grey()).light("lit", light);
    assert_same_picture(lit(disc), folder.path(), &format!("{GREY}, {text}"));

    let rectangle = Light::rectangle([0.5, 2.0, 1.0], [0.0; 3], [0.2, 1.5], [9.0; 3]).with(|light| {
        if let Light::Rectangle { up, .. } = light {
            *up = [1.0, 0.0, 0.0].into();
        }
    });
    let text = "lights: { \"lit\": Rectangle(position_m: (0.5, 2.0, 1.0), target_m: (0.0, 0.0, 0.0), up: (1.0, 0.0, 0.0),
        width_m: 0.2, height_m: 1.5, power_w: 9.0) }";
    assert_same_picture(lit(rectangle), folder.path(), &format!("{GREY}, {text}"));

    let sun = Sun::default().with(|sun| {
        sun.to_sun = Some([0.1, 0.3, -1.0].into());
        sun.irradiance_w_per_m2 = [5.0; 3].into();
        sun.angular_diameter_deg = 12.0.into();
        sun.limb_darkening = 0.6.into();
        sun.fractal = Some(Julia::new(0.3, 0.5).with(|julia| julia.iterations = 40.into()));
        sun.picture_rotation_deg = 30.0.into();
        sun.visible_to_camera = true;
    });
    let text = "lights: { \"lit\": Sun(to_sun: (0.1, 0.3, -1.0), irradiance_w_per_m2: 5.0, angular_diameter_deg: 12.0,
        limb_darkening: 0.6, fractal: (real: 0.3, imaginary: 0.5, iterations: 40), picture_rotation_deg: 30.0,
        visible_to_camera: true) }";
    assert_same_picture(lit(Light::Sun(sun)), folder.path(), &format!("{GREY}, {text}"));
}

#[test]
fn skies_and_textures_of_code_are_those_of_files() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: &str| folder.path().join(name);
    fs::write(path("panes.ppm"), b"P6 2 2 255\n\xff\x20\x20\x20\xff\x20\x20\x20\xff\xff\xff\xff")
        .expect("written");
    let texels = [[128, 64, 32, 129], [32, 64, 128, 130]].concat();
    let sky = [b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 2\n".as_slice(), &texels].concat();
    fs::write(path("sky.hdr"), sky).expect("written");

    let bent = Material::default().with(|material| {
        material.texture = Some(path("panes.ppm"));
        material.transmission = [0.2; 3].into();
        material.transmission_texture = Some(path("panes.ppm"));
        material.normal_map = Some(NormalMap::new(path("panes.ppm")).with(|map| map.scale = 0.5.into()));
        material.base_color = Some([0.7; 3].into());
    });
    let gradient = Sky::gradient([0.2, 0.4, 0.8], [1.0; 3]).with(|sky| {
        if let Sky::Gradient { ground_w_per_m2_sr, strength, lights, .. } = sky {
            *ground_w_per_m2_sr = [0.1; 3].into();
            (*strength, *lights) = ([2.0; 3].into(), SkyLight::Surfaces);
        }
    });
    let text = "materials: { \"grey\": (texture: \"panes.ppm\", base_color: 0.7, transmission: 0.2,
        transmission_texture: \"panes.ppm\", normal_map: (texture: \"panes.ppm\", scale: 0.5)) },
        sky: Gradient(zenith_w_per_m2_sr: (0.2, 0.4, 0.8), horizon_w_per_m2_sr: 1.0, ground_w_per_m2_sr: 0.1, strength: 2.0,
        lights: Surfaces)";
    assert_same_picture(stage().material("grey", bent).sky(gradient), folder.path(), text);

    let image = Sky::image(path("sky.hdr")).with(|sky| {
        if let Sky::Image { strength_w_per_m2_sr, rotation_deg, .. } = sky {
            (*strength_w_per_m2_sr, *rotation_deg) = ([3.0; 3].into(), 50.0.into());
        }
    });
    let text = "materials: { \"grey\": (base_color: 0.5) },
        sky: Image(image: \"sky.hdr\", strength_w_per_m2_sr: 3.0, rotation_deg: 50.0)";
    assert_same_picture(stage().material("grey", grey()).sky(image), folder.path(), text);

    let masked = Material::default().with(|material| {
        material.texture = Some(path("panes.ppm"));
        material.alpha_cutoff = Some(0.5.into());
    });
    let even = Sky::constant([1.0; 3]).with(|sky| {
        if let Sky::Constant { lights, .. } = sky {
            *lights = SkyLight::Surfaces;
        }
    });
    let text = "materials: { \"grey\": (texture: \"panes.ppm\", alpha_cutoff: 0.5) },
        sky: Constant(radiance_w_per_m2_sr: 1.0, lights: Surfaces)";
    assert_same_picture(stage().material("grey", masked).sky(even), folder.path(), text);
}

#[test]
fn cameras_turns_and_obj_files_of_code_are_those_of_files() {
    let folder = tempfile::tempdir().expect("a folder");
    let obj = folder.path().join("tile.obj");
    fs::write(&obj, "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nf 1 2 3 4\n").expect("written");
    let text = format!(
        "Scene(version: 1, meshes: {{ \"tile\": Obj({obj:?}) }}, materials: {{ \"grey\": (base_color: 0.5) }},
        objects: {{ \"tile\": (mesh: \"tile\", material: \"grey\", rotation_quaternion: (0.0, 0.3, 0.0, 1.0)) }},
        cameras: {{ \"main\": (position_m: (0.0, 0.5, 4.0), look_at_m: (0.0, 0.0, 0.0), up: (1.0, 1.0, 0.0),
            aperture: (f_stop: 0.1, focus_distance_m: 2.5, sensor_width_mm: 20.0, blades: 5), clip_m: (0.1, 4.1)),
            \"beside\": (position_m: (1.0, 0.0, 3.0), rotation_quaternion: (0.0, 0.1, 0.0, 1.0)) }},
        lights: {{ \"sun\": Sun(to_sun: (0.0, 0.2, 1.0), irradiance_w_per_m2: 3.0) }})"
    );
    let file = folder.path().join("scene.ron");
    fs::write(&file, text).expect("written");
    let read = Scene::load(&file).unwrap_or_else(|error| panic!("{error}"));
    let lens = Aperture::new(0.1, 2.5).with(|aperture| {
        aperture.sensor_width_mm = 20.0.into();
        aperture.blades = Some(5.into());
    });
    let main = Camera::default().with(|camera| {
        camera.position_m = [0.0, 0.5, 4.0].into();
        camera.look_at_m = Some([0.0; 3].into());
        camera.up = [1.0, 1.0, 0.0].into();
        camera.aperture = Some(lens);
        camera.clip_m = Some((0.1.into(), 4.1.into()));
    });
    let beside = Camera::default().with(|camera| {
        camera.position_m = [1.0, 0.0, 3.0].into();
        camera.rotation_quaternion = Some([0.0, 0.1, 0.0, 1.0].into());
    });
    let tile = Object::of("tile", "grey")
        .with(|object| object.rotation_quaternion = Some([0.0, 0.3, 0.0, 1.0].into()));
    let sun = Sun::default().with(|sun| {
        sun.to_sun = Some([0.0, 0.2, 1.0].into());
        sun.irradiance_w_per_m2 = [3.0; 3].into();
    });
    let made = built(
        Scene::builder()
            .shape("tile", Shape::Obj(obj))
            .material("grey", grey())
            .object("tile", tile)
            .camera("main", main)
            .camera("beside", beside)
            .light("sun", Light::Sun(sun)),
    );
    for camera in ["main", "beside"] {
        let beauty = |scene: &Scene| small(scene).camera(camera).render().expect("a frame").beauty();
        let picture = beauty(&made);
        assert_eq!(picture, beauty(&read), "{camera}");
        assert!(picture.mean()[0] > 0.0, "{camera} sees nothing");
    }
}

#[test]
fn a_scene_written_as_gltf_has_the_same_picture() {
    let folder = tempfile::tempdir().expect("a folder");
    let scene = built(tile());
    let path = folder.path().join("tile.glb");
    let lost = scene.write_glb(&path, 0..=24).unwrap_or_else(|error| panic!("{error}"));
    assert!(lost.is_empty(), "{lost:?}");
    let read = Scene::load(&path).unwrap_or_else(|error| panic!("{error}"));
    let means = |scene: &Scene| small(scene).frame(12).render().expect("a frame").beauty().mean();
    let (before, after) = (means(&scene), means(&read));
    assert!(before.iter().zip(&after).all(|(a, b)| (a / b - 1.0).abs() < 1e-3), "{before:?} {after:?}");

    let error = scene.write_glb(path.join("inside.glb"), 0..=24).expect_err("a file is no folder");
    assert!(matches!(error, RenderError::Write(_)));
}

#[test]
fn leaves_of_code_fall_as_those_of_files() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("scene.ron");
    let fields = "materials: { \"grey\": (base_color: 0.5) }, fall: { \"shower\": (count: 3, seed: 5,
        species: [(meshes: [\"floor\"], materials: [\"grey\"], length_m: (0.06, 0.1), width_m: 0.04, curl_deg: (0.0, 20.0))],
        emitter: Ellipsoid(center_m: (0.0, 3.0, 0.0), radii_m: (1.0, 0.5, 1.0)),
        wind: (mean_m_per_s: (0.8, 0.0, 0.2), eddy_m_per_s: 0.3, seed: 2), motion: (flutter: 3.0, tumble: 1.0),
        ground: (height_m: 0.1), release_s: (-1.0, 1.0), attached: false, speed: 1.5) }";
    fs::write(&file, format!("Scene({STAGE}, {fields})")).expect("written");
    let read = Scene::load(&file).unwrap_or_else(|error| panic!("{error}"));
    let species = Species::new("floor", [0.06, 0.1]).with(|species| {
        species.materials = vec!["grey".into()];
        species.width_m = Some([0.04; 2].into());
        species.curl_deg = [0.0, 20.0].into();
    });
    let emitter = Emitter::Ellipsoid { center_m: [0.0, 3.0, 0.0].into(), radii_m: [1.0, 0.5, 1.0].into() };
    let shower = Fall::new(3, species, emitter).with(|fall| {
        fall.seed = 5;
        fall.wind = Wind::default().with(|wind| {
            wind.mean_m_per_s = [0.8, 0.0, 0.2].into();
            wind.eddy_m_per_s = 0.3.into();
            wind.seed = 2;
        });
        fall.motion = Some(FallMotion::default().with(|motion| {
            motion.flutter = 3.0.into();
            motion.tumble = 1.0.into();
        }));
        fall.ground = FallGround::default().with(|ground| {
            ground.height_m = 0.1.into();
            ground.object = None;
        });
        fall.release_s = [-1.0, 1.0].into();
        fall.attached = false;
        fall.speed = 1.5.into();
    });
    let made = built(stage().material("grey", grey()).fall("shower", shower));
    for (leaf, frame) in ["shower.0", "shower.1", "shower.2"].iter().zip([0.0, 20.0, 40.0]) {
        let place = made.place(leaf, frame).expect("a leaf");
        assert_eq!(Some(place), read.place(leaf, frame));
        assert_ne!(Some(place), made.place(leaf, frame + 10.0), "{leaf} stays where it is");
    }
}

/// A gust that begins, and a fall that is slowed down.
#[test]
fn keyed_wind_and_speed_of_code_are_those_of_files() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("scene.ron");
    let fields = "materials: { \"grey\": (base_color: 0.5) }, fall: { \"shower\": (count: 40,
        species: [(meshes: [\"floor\"], materials: [\"grey\"], length_m: (0.1, 0.2), tint: [(1.0, 0.5, 0.0), 0.5])],
        emitter: Box(min_m: (-1.0, 1.0, -1.0), max_m: (1.0, 2.0, 1.0)), casts_shadow: false,
        wind: (mean_m_per_s: Keyed(keys: [(at_s: 0.5, value: (0.0, 0.0, 0.0)), (at_s: 1.0, value: (3.0, 0.0, 0.0))]),
            eddy_m_per_s: Keyed(keys: [(at_s: 0.0, value: 0.1), (at_s: 1.0, value: 0.6)], extend: Cycle)),
        speed: Keyed(keys: [(at_s: 0.0, value: 1.0), (at_s: 1.0, value: 0.3)])) }";
    fs::write(&file, format!("Scene({STAGE}, {fields})")).expect("written");
    let read = Scene::load(&file).unwrap_or_else(|error| panic!("{error}"));
    let species = Species::new("floor", [0.1, 0.2]).with(|species| {
        species.materials = vec!["grey".into()];
        species.tint = vec![[1.0, 0.5, 0.0].into(), 0.5.into()];
    });
    let emitter = Emitter::Box { min_m: [-1.0, 1.0, -1.0].into(), max_m: [1.0, 2.0, 1.0].into() };
    let calm = Fall::new(40, species, emitter).with(|fall| fall.casts_shadow = false);
    let wind = Wind::default().with(|wind| {
        wind.mean_m_per_s = Animated::keys([(0.5, [0.0; 3]), (1.0, [3.0, 0.0, 0.0])]);
        wind.eddy_m_per_s = Animated::cycle([(0.0, 0.1), (1.0, 0.6)]);
    });
    let gust = calm.clone().with(|fall| {
        fall.wind = wind;
        fall.speed = Animated::keys([(0.0, 1.0), (1.0, 0.3)]);
    });
    let [made, calm] = [gust, calm].map(|fall| built(stage().material("grey", grey()).fall("shower", fall)));
    let frame = |scene: &Scene| small(scene).frame(36).shutter(0.0).render().expect("a frame").beauty();
    assert_eq!(frame(&made), frame(&read));
    assert_ne!(frame(&made), frame(&calm), "the wind changes nothing");
}

/// Over a ground, in the wind, and as defaults have it.
#[test]
fn mist_of_code_is_that_of_files() {
    let (low, high) = ([-2.0, 0.0, -2.0], [2.0, 2.0, 2.0]);
    let sun = Sun::default().with(|sun| {
        sun.to_sun = Some([0.4, 1.0, 0.6].into());
        sun.irradiance_w_per_m2 = [3.0; 3].into();
    });
    let written = "materials: { \"grey\": (base_color: 0.5) },
        lights: { \"sun\": Sun(to_sun: (0.4, 1.0, 0.6), irradiance_w_per_m2: 3.0) },
        fog: { \"mist\": (min_m: (-2.0, 0.0, -2.0), max_m: (2.0, 2.0, 2.0), density_per_m: 0.5, mist: ";
    let drifting = Mist::new(1.0).with(|mist| {
        mist.wind_m_per_s = [0.5, 0.0, 0.0].into();
        mist.ground = Some("floor".into());
        mist.shape = MistShape::Ellipsoid;
        mist.octaves = 2.into();
    });
    for (mist, fields) in [
        (Mist::new(1.0), "(size_m: 1.0)) }"),
        (
            drifting,
            "(size_m: 1.0, wind_m_per_s: (0.5, 0.0, 0.0), ground: \"floor\", shape: Ellipsoid, octaves: 2)) }",
        ),
    ] {
        let folder = tempfile::tempdir().expect("a folder");
        let fog = Fog::in_box(low, high, 0.5).with(|fog| fog.mist = Some(mist));
        let lit = stage().material("grey", grey()).light("sun", Light::Sun(sun.clone()));
        let made = lit.fog("mist", fog);
        assert_same_picture(made, folder.path(), &format!("{written}{fields}"));
    }
}

/// Where parts need some of their fields, defaults are written down twice.
#[test]
fn what_code_leaves_out_is_what_files_leave_out() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("scene.ron");
    let fields = "fall: { \"shower\": (count: 1, species: [(meshes: [\"floor\"], length_m: (0.06, 0.1))],
        emitter: Box(min_m: (0.0, 2.0, 0.0), max_m: (1.0, 3.0, 1.0)), wind: (eddy_m_per_s: 0.5, gust_m_per_s: (1.0, 0.0, 0.0))) }";
    let text = format!("Scene({STAGE}, materials: {{ \"grey\": (base_color: 0.5) }}, {fields})");
    fs::write(&file, text).expect("written");
    let read = Scene::load(&file).unwrap_or_else(|error| panic!("{error}"));
    let emitter = Emitter::Box { min_m: [0.0, 2.0, 0.0].into(), max_m: [1.0, 3.0, 1.0].into() };
    let wind = Wind::default().with(|wind| {
        wind.eddy_m_per_s = 0.5.into();
        wind.gust_m_per_s = [1.0, 0.0, 0.0].into();
    });
    let shower = Fall::new(1, Species::new("floor", [0.06, 0.1]), emitter).with(|fall| fall.wind = wind);
    let made = built(stage().material("grey", grey()).fall("shower", shower));
    assert!(made.place("shower.0", 15.0).is_some());
    assert_eq!(made.place("shower.0", 15.0), read.place("shower.0", 15.0));
}

#[test]
fn parts_keep_to_the_limits_of_files() {
    let hung = || Emitter::Surface { object: "ball".into() };
    let fall = |count: u32, species: Species| stage().fall("bad", Fall::new(count, species, hung()));
    let leaf = || Species::new("floor", [0.1; 2]);
    let sun = |sun: Sun| stage().light("bad", Light::Sun(sun));
    let disc =
        |diameter_m: f64| stage().light("bad", Light::disc([0.0, 1.0, 0.0], [0.0; 3], diameter_m, [1.0; 3]));
    let sky = |radiance: f64| Sky::constant([radiance; 3]);
    let material = |material: Material| stage().material("grey", material);
    let julia = Julia::new(0.0, 3.0).with(|julia| julia.iterations = 10.into());
    let missing = grey().with(|material| material.texture = Some("missing.png".into()));
    for (builder, path) in [
        (fall(0, leaf()), "fall.bad.count"),
        (fall(50_001, leaf()), "fall.bad.count"),
        (fall(1, Species::new("floor", [0.1, f64::NAN])), "fall.bad.species[0].length_m[1]"),
        (
            fall(1, leaf().with(|species| species.width_m = Some([f64::NAN; 2].into()))),
            "fall.bad.species[0].width_m",
        ),
        (
            sun(Sun::default().with(|sun| sun.angular_diameter_deg = 180.0.into())),
            "lights.bad.Sun.angular_diameter_deg",
        ),
        (sun(Sun::default().with(|sun| sun.fractal = Some(julia))), "lights.bad.Sun.fractal.imaginary"),
        (sun(Sun::default().with(|sun| sun.limb_darkening = 0.5.into())), "lights.bad.angular_diameter_deg"),
        (disc(0.0), "lights.bad.Disc.diameter_m"),
        (stage().sky(sky(-1.0)), "sky.Constant.radiance_w_per_m2_sr"),
        (stage().sky(sky(1.0)).background([1.0; 3]), "sky"),
        (
            material(grey().with(|material| material.opacity = Some(f64::NAN.into()))),
            "materials.grey.opacity",
        ),
        (
            material(grey().with(|material| material.base_color = Some([f64::INFINITY; 3].into()))),
            "materials.grey.base_color",
        ),
        (material(missing), "materials.grey.texture"),
        (
            stage().camera("bad", Camera::default().with(|camera| camera.fov_deg = Some(f64::NAN.into()))),
            "cameras.bad.fov_deg",
        ),
        (
            tile().fog(
                "bad",
                Fog::in_box([-1.0; 3], [1.0; 3], 0.1).with(|fog| fog.base_m = Some(f64::NAN.into())),
            ),
            "fog.bad.base_m",
        ),
    ] {
        let said = refused(builder);
        assert!(said.contains(path), "{path}: {said}");
    }
}

#[test]
fn inputs_that_cannot_be_read_say_why() {
    let error = |path: &str| Scene::load(path).expect_err("no scene");
    let nowhere = error("nowhere.ron");
    assert!(nowhere.to_string().starts_with("nowhere.ron: cannot be read: "), "{nowhere}");
    assert_eq!(nowhere.remedy(), "check the path");
    assert!(nowhere.diagnostics().to_string().contains("nowhere.ron: error: cannot be read"));
    let unknown = error("Cargo.toml");
    assert_eq!(unknown.to_string().lines().count(), 1, "{unknown}");
    assert!(unknown.diagnostics().to_string().contains("expected: a .ron, .glb, .gltf or .obj file"));
    let leaf = "scenes/first_leaf/scene.ron";
    let no_animation = Scene::options().animation("down").load(leaf).expect_err("no scene").to_string();
    assert!(no_animation.contains("there is no animation `down`"), "{no_animation}");
    let no_rate = Scene::options().frame_rate(24, 0).load(leaf).expect_err("no scene").to_string();
    assert!(no_rate.contains("24/0 frames a second"), "{no_rate}");
}

#[test]
fn a_frame_is_written_as_the_command_line_writes_it() {
    let folder = tempfile::tempdir().expect("a folder");
    let [by_program, by_library] = ["program.exr", "library.exr"].map(|name| folder.path().join(name));
    let leaf = "scenes/first_leaf/scene.ron";
    let flags =
        ["--size", "32x18", "--samples", "2", "--passes", "all", "--frames", "24", "--shutter", "0.5"];
    let status = Command::new(checkout::program())
        .args(["render", leaf, "--progress", "none", "--crop", "4,2,20,12", "--out"])
        .arg(&by_program)
        .args(flags)
        .status();
    assert!(status.expect("it runs").success());
    let scene = Scene::load(leaf).unwrap_or_else(|error| panic!("{error}"));
    let crop = Window { x: 4, y: 2, width: 16, height: 10 };
    let renderer = Renderer::new(&scene).frame(24).size(32, 18).samples(2).shutter(0.5).crop(crop);
    let frame = renderer.passes(Pass::ALL.iter().copied()).render().expect("a frame");
    frame.write(&by_library).expect("written");
    assert_eq!(fs::read(&by_program).expect("there"), fs::read(&by_library).expect("there"));

    let error = frame.write_png(by_library.join("inside.png")).expect_err("a file is no folder");
    assert!(matches!(error, RenderError::Write(_)));
    assert!(error.remedy().contains("choose a folder"), "{error}");
    assert_eq!(error.to_string().lines().count(), 1, "{error}");
}
