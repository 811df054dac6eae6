//! Surfaces that the camera does not see, that throw no shadow, and holes in the picture: what each of them
//! does to a ray, and that files carry them.

use crate::common::{EXACT, INSTANT, add_fog, add_light, camera_at, look, place};
use glam::{DAffine3, DVec2, DVec3};
use std::path::Path;
use sunfleck::color::Rgb;
use sunfleck::scene::{
    AlphaMode, Instance, LightKind, Material, Mesh, RayVisibility, Scene, Size, Sky, SkyLight, SkyPicture,
    Track, Triangle,
};
use sunfleck::snapshot::{MeshTrees, Snapshot};
use sunfleck::transport::Sample;
use sunfleck::{description, export, scanline, scene};

const UNSEEN: RayVisibility = RayVisibility { visible_to_camera: false, ..RayVisibility::USUAL };
const SHADOWLESS: RayVisibility = RayVisibility { casts_shadow: false, ..RayVisibility::USUAL };
const HOLE: RayVisibility = RayVisibility { holdout: true, ..RayVisibility::USUAL };

/// Adds a square of this half width across the view axis.
fn add_square(scene: &mut Scene, depth_m: f64, half_width_m: f64, material: Material, rays: RayVisibility) {
    let node = place(scene, DAffine3::from_translation(depth_m * DVec3::NEG_Z));
    scene.materials.push(material);
    let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(|(x, y)| DVec2::new(x, y));
    let material = scene.materials.len() - 1;
    scene.meshes.push(Mesh {
        positions: corners.map(|corner| (half_width_m * corner).extend(0.0).as_vec3()).to_vec(),
        triangles: [[0, 1, 2], [0, 2, 3]].map(|vertices| Triangle { vertices, material }).to_vec(),
        ..Mesh::default()
    });
    let (mesh, leaf_id) = (scene.meshes.len() - 1, scene.meshes.len() as u32);
    scene.instances.push(Instance { node, mesh, material: None, leaf_id, deformation: None });
    scene.set_ray_visibility(node, rays);
}

fn shining(color: Rgb) -> Material {
    Material { base_color: Rgb::ZERO, emission: color, ..Material::default() }
}

fn veil(color: Rgb, opacity: f64) -> Material {
    Material { alpha_mode: AlphaMode::Blend, opacity, ..shining(color) }
}

/// A preview's middle pixel: red, green, blue and alpha.
fn previewed(scene: &Scene) -> [f64; 4] {
    let snapshot = Snapshot::new(scene, &MeshTrees::new(scene), 0, 1.0, INSTANT);
    let frame = scanline::draw(&snapshot, Size { width: 101, height: 101 });
    [0, 1, 2, 3].map(|channel| f64::from(frame.channels[channel].pixels[50 * 101 + 50]))
}

fn is_near(found: f64, expected: f64) -> bool {
    (found - expected).abs() < 1e-9
}

/// What lies behind is seen in its place, by rays and by previews.
#[test]
fn the_camera_looks_past_what_it_does_not_see() {
    let mut scene = camera_at(DVec3::ZERO);
    for (depth_m, color, rays) in [
        (1.0, DVec3::X, UNSEEN),
        (2.0, DVec3::X, UNSEEN),
        (3.0, DVec3::Y, RayVisibility::USUAL),
        (9.0, DVec3::Z, RayVisibility::USUAL),
    ] {
        add_square(&mut scene, depth_m, 20.0, shining(color), rays);
    }
    let Sample { radiance, surface, .. } = look(&scene, &EXACT, 0.4, 0.6);
    assert_eq!(radiance, DVec3::Y);
    assert!(is_near(surface.unwrap().depth_m, 3.0));
    assert_eq!(previewed(&scene), [0.0, 1.0, 0.0, 1.0]);

    // Blended ones are looked past too, even if they let nothing through.
    let mut scene = camera_at(DVec3::ZERO);
    add_square(&mut scene, 1.0, 20.0, veil(DVec3::X, 1.0 - 1e-15), UNSEEN);
    add_square(&mut scene, 2.0, 20.0, veil(DVec3::Y, 0.5), RayVisibility::USUAL);
    add_square(&mut scene, 3.0, 20.0, shining(DVec3::Z), RayVisibility::USUAL);
    assert_eq!(look(&scene, &EXACT, 0.4, 0.6).radiance, DVec3::new(0.0, 0.5, 0.5));
    assert_eq!(previewed(&scene), [0.0, 0.5, 0.5, 1.0]);
}

/// Mirrors show it, and it throws its shadow on surfaces and in fog.
#[test]
fn what_the_camera_does_not_see_is_there() {
    let mut scene = camera_at(DVec3::ZERO);
    add_square(&mut scene, 2.0, 20.0, shining(DVec3::X), UNSEEN);
    let mirror = Material { base_color: Rgb::ZERO, mirror: Rgb::ONE, ..Material::default() };
    add_square(&mut scene, 5.0, 20.0, mirror, RayVisibility::USUAL);
    assert_eq!(look(&scene, &EXACT, 0.3, 0.6).radiance, DVec3::X);

    let lit = |rays: Option<RayVisibility>| {
        let mut scene = camera_at(DVec3::ZERO);
        if let Some(rays) = rays {
            add_square(&mut scene, 2.0, 0.5, Material::default(), rays);
        }
        add_square(&mut scene, 6.0, 50.0, Material::default(), RayVisibility::USUAL);
        add_light(&mut scene, LightKind::Sun, DVec3::ZERO, DVec3::NEG_Z, Rgb::ONE);
        let (low, high) = (DVec3::new(-4.0, -4.0, -6.0), DVec3::new(4.0, 4.0, -1.0));
        add_fog(&mut scene, low, high, Rgb::splat(0.2), Rgb::ONE, 0.0);
        look(&scene, &EXACT, 0.51, 0.51)
    };
    let [without, unseen] = [None, Some(UNSEEN)].map(lit);
    // The sun is behind the camera: fog beyond the square is dark, and so is the wall.
    assert!(unseen.shafts.x > 0.0 && unseen.shafts.x < 0.4 * without.shafts.x, "{unseen:?} {without:?}");
    assert!(is_near(unseen.radiance.x, unseen.shafts.x) && without.radiance.x > 1.2 * without.shafts.x);
    assert!(is_near(unseen.transmittance.x, without.transmittance.x));

    // Without a shadow the wall and the fog behind it are as if it were not there; it is seen itself.
    let shadowless = lit(Some(RayVisibility { casts_shadow: false, ..UNSEEN }));
    assert!(is_near(shadowless.radiance.x, without.radiance.x), "{shadowless:?} {without:?}");
    let seen = lit(Some(SHADOWLESS));
    assert!(is_near(seen.surface.unwrap().depth_m, 2.0) && seen.radiance.x > seen.shafts.x);
}

/// Nor does it throw one under the sky, or dim light if it is blended; many blended ones are another way.
#[test]
fn what_throws_no_shadow_lets_all_light_pass() {
    let brightness = |depths_m: &[f64], rays: RayVisibility| {
        let mut scene = camera_at(DVec3::ZERO);
        let white = Material { alpha_mode: AlphaMode::Blend, opacity: 0.1, ..Material::default() };
        for &depth_m in depths_m {
            add_square(&mut scene, depth_m, 30.0, white.clone(), rays);
        }
        add_square(&mut scene, 6.0, 50.0, Material::default(), RayVisibility::USUAL);
        add_light(&mut scene, LightKind::Sun, DVec3::ZERO, DVec3::NEG_Z, Rgb::ONE);
        look(&scene, &EXACT, 0.4, 0.6).radiance.x
    };
    let bare = brightness(&[], SHADOWLESS);
    assert!(is_near(brightness(&[-1.0], SHADOWLESS), bare) && is_near(brightness(&[-1.0], HOLE), 0.9 * bare));
    // Before the eye all are as bright as the wall, so that it is no matter how many there are.
    let many: Vec<f64> = (0..40).map(|number| 1.0 + 0.01 * f64::from(number)).collect();
    assert!(
        is_near(brightness(&many, SHADOWLESS), bare) && is_near(brightness(&many[..3], SHADOWLESS), bare)
    );
    assert!(brightness(&many, RayVisibility::USUAL) < 0.6 * bare);

    let mut scene = camera_at(DVec3::ZERO);
    add_square(&mut scene, -1.0, 1e4, Material::default(), SHADOWLESS);
    add_square(&mut scene, 6.0, 50.0, Material::default(), RayVisibility::USUAL);
    let (even, still) = (Sky::new(SkyPicture::Even(Rgb::ONE)).unwrap(), Track::from(Rgb::ONE));
    scene.sky = Some(even.with(still, Track::from(0.0), SkyLight::Surfaces));
    let of_sky = look(&scene, &EXACT, 0.5, 0.5).radiance.x;
    assert!(is_near(of_sky, 0.8), "{of_sky}");
}

/// It hides what lies behind it, keeps the fog before it, and leaves the share of what it hides to whoever
/// puts another picture there.
#[test]
fn a_holdout_is_a_hole_in_the_picture() {
    let seen = |rays: RayVisibility| {
        let mut scene = camera_at(DVec3::ZERO);
        scene.background = Rgb::ONE;
        add_square(&mut scene, 3.0, 20.0, shining(DVec3::X), rays);
        add_square(&mut scene, 9.0, 20.0, shining(DVec3::Y), RayVisibility::USUAL);
        add_light(&mut scene, LightKind::Sun, DVec3::ZERO, DVec3::NEG_Z, Rgb::ONE);
        let (low, high) = (DVec3::new(-9.0, -9.0, -2.0), DVec3::new(9.0, 9.0, -1.0));
        add_fog(&mut scene, low, high, Rgb::splat(0.7), Rgb::ONE, 0.0);
        (look(&scene, &EXACT, 0.5, 0.5), previewed(&scene))
    };
    let ((hole, preview), (usual, _)) = (seen(HOLE), seen(RayVisibility::USUAL));
    assert_eq!(hole.shafts, usual.shafts);
    assert_eq!(hole.radiance, usual.shafts);
    assert!(
        is_near(hole.alpha, 1.0 - hole.transmittance.x) && is_near(hole.transmittance.x, (-0.7_f64).exp())
    );
    assert!(hole.surface.is_none());
    assert!(preview[..3] == [0.0; 3] && (preview[3] - hole.alpha).abs() < 1e-3, "{preview:?}");

    // Through one that is blended by 0.3: 0.7 of what lies behind, and alpha 0.7.
    let mut scene = camera_at(DVec3::ZERO);
    add_square(&mut scene, 2.0, 20.0, veil(DVec3::X, 0.3), HOLE);
    add_square(&mut scene, 3.0, 20.0, shining(DVec3::Y), RayVisibility::USUAL);
    let sample = look(&scene, &EXACT, 0.5, 0.5);
    assert!(is_near(sample.alpha, 0.7) && is_near(sample.radiance.y, 0.7) && sample.radiance.x == 0.0);
    assert!(is_near(sample.surface.unwrap().depth_m, 3.0));

    // A mirror shows what it is.
    let mut scene = camera_at(DVec3::ZERO);
    add_square(&mut scene, -1.0, 20.0, shining(DVec3::X), HOLE);
    let mirror = Material { base_color: Rgb::ZERO, mirror: Rgb::ONE, ..Material::default() };
    add_square(&mut scene, 5.0, 20.0, mirror, RayVisibility::USUAL);
    let sample = look(&scene, &EXACT, 0.4, 0.5);
    assert_eq!((sample.radiance, sample.alpha), (DVec3::X, 1.0));
}

/// RON to a scene, and by way of glTF again.
#[test]
fn files_carry_it() {
    let folder = tempfile::tempdir().unwrap();
    let (ron, glb) = (folder.path().join("scene.ron"), folder.path().join("scene.glb"));
    let load = |path: &Path| {
        let description = description::load(path).map_err(|error| error.diagnostics().to_string()).unwrap();
        scene::resolve(description, None).map_err(|error| error.to_string()).unwrap()
    };
    let said = |scene: &Scene| -> Vec<(String, RayVisibility)> {
        let by_node = scene.ray_visibility.iter();
        by_node.map(|(node, rays)| (scene.nodes[*node].name.clone(), *rays)).collect()
    };
    let text =
        "Scene(version: 1, cameras: { \"main\": () }, meshes: { \"quad\": Quad(size_m: 1.0) }, objects: {
        \"gobo\": (mesh: \"quad\", visible_to_camera: false), \"usual\": (mesh: \"quad\", casts_shadow: true),
        \"fill\": (mesh: \"quad\", casts_shadow: false), \"hole\": (mesh: \"quad\", holdout: true) })";
    std::fs::write(&ron, text).unwrap();
    let (scene, settings) = load(&ron);
    let expected =
        [("gobo", UNSEEN), ("fill", SHADOWLESS), ("hole", HOLE)].map(|(name, rays)| (name.to_owned(), rays));
    assert_eq!(said(&scene), expected);
    let exported = export::glb(&scene, &settings, Path::new("")).unwrap();
    std::fs::write(&glb, [exported.head, exported.binary].concat()).unwrap();
    let (again, _) = load(&glb);
    assert_eq!(said(&again), expected);
    assert_eq!(again.remarks.0.len(), scene.remarks.0.len(), "{}", again.remarks);
}
