//! Blended surfaces: against closed forms, against brute force in double precision, and against
//! pictures without them.

use crate::common::{EXACT, INSTANT, add_fog, add_light, camera_at, place};
use glam::{DAffine3, DVec3, Vec2, Vec3};
use proptest::prelude::*;
use std::f64::consts::{FRAC_1_PI, PI};
use sunfleck::color::Rgb;
use sunfleck::math::{Ray, Sampler};
use sunfleck::scene::{AlphaMode, Instance, LightKind, Material, Mesh, Scene, Texture, Triangle, Wrap};
use sunfleck::snapshot::{MeshTrees, Snapshot};
use sunfleck::transport::{MarchSteps, Sample, Scratch, Transport, VolumeMethod, radiance};

const SIGMA_T: f64 = 0.25;
const SIGMA_S: f64 = 0.2;

/// A camera at the origin in a box of fog that reaches 4 m up and 10 m forward, under an
/// overhead sun of 7 W/m2.
fn foggy() -> Scene {
    let mut scene = camera_at(DVec3::ZERO);
    let (low, high) = (DVec3::new(-6.0, -5.0, -10.0), DVec3::new(6.0, 4.0, 1.0));
    add_fog(&mut scene, low, high, Rgb::splat(SIGMA_T), Rgb::splat(SIGMA_S / SIGMA_T), 0.0);
    scene
}

fn with_sun(mut scene: Scene) -> Scene {
    add_light(&mut scene, LightKind::Sun, DVec3::ZERO, DVec3::NEG_Y, Rgb::splat(7.0));
    scene
}

fn veil(opacity: f64) -> Material {
    Material { alpha_mode: AlphaMode::Blend, opacity, base_color: Rgb::splat(0.6), ..Material::default() }
}

/// Adds triangles of one material.
fn add_mesh(scene: &mut Scene, triangles: &[[DVec3; 3]], material: Material) {
    let node = place(scene, DAffine3::IDENTITY);
    scene.materials.push(material);
    scene.meshes.push(Mesh {
        positions: triangles.iter().flatten().map(|corner| corner.as_vec3()).collect(),
        triangles: (0..triangles.len() as u32)
            .map(|index| Triangle { vertices: [0, 1, 2].map(|corner| 3 * index + corner), material: 0 })
            .collect(),
        ..Mesh::default()
    });
    let (mesh, material) = (scene.meshes.len() - 1, Some(scene.materials.len() - 1));
    scene.instances.push(Instance { node, mesh, material, leaf_id: 1 + mesh as u32, deformation: None });
}

/// A parallelogram about `centre`.
fn sheet(centre: DVec3, u: DVec3, v: DVec3) -> [[DVec3; 3]; 2] {
    let corner = |a: f64, b: f64| centre + a * u + b * v;
    [
        [corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0)],
        [corner(-1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)],
    ]
}

fn follow(scene: &Scene, transport: &Transport, direction: DVec3) -> Sample {
    let snapshot = Snapshot::new(scene, &MeshTrees::new(scene), 0, 1.0, INSTANT);
    let ray = Ray { origin: DVec3::ZERO, direction };
    radiance(&snapshot, transport, &ray, &mut Sampler::new(0, 0, 0, 0), &mut Scratch::default())
}

const OPACITIES: [f64; 4] = [0.3, 0.55, 0.9, 0.1];

/// Lying sheets above the ray: the sun is dimmed by all of them, everywhere.
#[test]
fn a_stack_in_the_light() {
    let mut scene = with_sun(foggy());
    let clear = follow(&scene, &EXACT, DVec3::NEG_Z);
    for (index, opacity) in OPACITIES.into_iter().enumerate() {
        let triangles = sheet(DVec3::Y * (1.0 + 0.5 * index as f64), 50.0 * DVec3::X, 50.0 * DVec3::Z);
        add_mesh(&mut scene, &triangles, veil(opacity));
    }
    let dimmed = follow(&scene, &EXACT, DVec3::NEG_Z);
    let expected: f64 = OPACITIES.iter().map(|opacity| 1.0 - opacity).product();
    assert!((dimmed.shafts.x / clear.shafts.x / expected - 1.0).abs() < 1e-12, "{dimmed:?} {clear:?}");
    assert_eq!(dimmed.transmittance, clear.transmittance);
}

/// Standing sheets across the ray, with the light along them: each dims what lies behind, and shines itself.
#[test]
fn a_stack_before_the_camera() {
    let mut scene = with_sun(foggy());
    scene.background = Rgb::splat(3.0);
    let filter = Rgb::new(0.4, 0.2, 0.0);
    for (index, opacity) in OPACITIES.into_iter().enumerate() {
        let triangles = sheet(DVec3::NEG_Z * (2.0 + 1.5 * index as f64), DVec3::X, DVec3::Y);
        let material = Material { emission: Rgb::splat(1.5), filter_color: filter, ..veil(opacity) };
        add_mesh(&mut scene, &triangles, material);
    }
    let direction = DVec3::NEG_Z;
    let sample = follow(&scene, &EXACT, direction);
    for channel in 0..3 {
        // Light arrives with exp(-4 sigma), and is scattered evenly to all sides.
        let source = SIGMA_S / (4.0 * PI) * 7.0 * (-SIGMA_T * 4.0).exp();
        let (mut from, mut through, mut shafts, mut own) = (0.0_f64, 1.0, 0.0, 0.0);
        let scattered =
            |from: f64, to: f64| source * ((-SIGMA_T * from).exp() - (-SIGMA_T * to).exp()) / SIGMA_T;
        for (index, opacity) in OPACITIES.into_iter().enumerate() {
            let at = 2.0 + 1.5 * index as f64;
            shafts += through * scattered(from, at);
            own += through * (-SIGMA_T * at).exp() * opacity * 1.5;
            through *= 1.0 - opacity + opacity * filter[channel];
            from = at;
        }
        shafts += through * scattered(from, 10.0);
        let transmittance = through * (-SIGMA_T * 10.0).exp();
        assert!((sample.shafts[channel] / shafts - 1.0).abs() < 1e-9, "{sample:?} {shafts}");
        assert!((sample.transmittance[channel] / transmittance - 1.0).abs() < 1e-12);
        let radiance = shafts + own + 3.0 * transmittance;
        assert!((sample.radiance[channel] / radiance - 1.0).abs() < 1e-9, "{sample:?} {radiance}");
    }
    // The first that is half there or more.
    let surface = sample.surface.expect("the second sheet");
    assert!((surface.depth_m - 3.5).abs() < 1e-9 && surface.leaf_id == 2);
    assert_eq!(sample.alpha, 1.0);
}

/// A lit floor seen through nothing, under two sheets.
#[test]
fn direct_light_is_dimmed_and_coloured() {
    let mut scene = with_sun(camera_at(DVec3::ZERO));
    add_mesh(&mut scene, &sheet(DVec3::NEG_Y, 50.0 * DVec3::X, 50.0 * DVec3::Z), Material::default());
    let filter = Rgb::new(0.4, 0.2, 0.0);
    for height in [1.0, 2.0] {
        let triangles = sheet(DVec3::Y * height, 50.0 * DVec3::X, 50.0 * DVec3::Z);
        add_mesh(&mut scene, &triangles, Material { filter_color: filter, ..veil(0.7) });
    }
    let sample = follow(&scene, &EXACT, DVec3::new(0.3, -0.5, -1.0).normalize());
    let through = Rgb::splat(0.3) + 0.7 * filter;
    let expected = 0.8 * FRAC_1_PI * 7.0 * through * through;
    assert!((sample.radiance - expected).abs().max_element() < 1e-12, "{sample:?} {expected}");
}

/// What scatters at a place, by asking every triangle.
struct BruteForce<'a> {
    triangles: &'a [([DVec3; 3], Rgb)],
}

impl BruteForce<'_> {
    fn between(&self, from: DVec3, to: DVec3) -> Rgb {
        let way = to - from;
        self.triangles.iter().fold(Rgb::ONE, |through, ([a, b, c], see_through)| {
            let (ab, ac) = (*b - *a, *c - *a);
            let p = way.cross(ac);
            let s = from - *a;
            let q = s.cross(ab);
            let det = ab.dot(p);
            let (u, v, t) = (s.dot(p) / det, way.dot(q) / det, ac.dot(q) / det);
            let met = u >= 0.0 && v >= 0.0 && u + v <= 1.0 && 0.0 < t && t < 1.0;
            if met { through * *see_through } else { through }
        })
    }
}

fn vector(range: std::ops::Range<f64>) -> impl Strategy<Value = DVec3> {
    prop::array::uniform3(range).prop_map(DVec3::from)
}

fn leaves() -> impl Strategy<Value = Vec<([DVec3; 3], f64, Rgb)>> {
    let leaf =
        (vector(-2.0..2.0), prop::array::uniform3(vector(-1.2..1.2)), 0.05..0.95_f64, vector(0.0..0.4));
    let leaf = leaf.prop_map(|(at, corners, opacity, filter)| {
        // What single precision keeps of them.
        let corners = corners.map(|corner| (at - 4.0 * DVec3::Z + corner).as_vec3().as_dvec3());
        (corners, opacity, filter)
    });
    prop::collection::vec(leaf, 1..25)
}

fn scene_of(leaves: &[([DVec3; 3], f64, Rgb)], lamp: Option<DVec3>) -> Scene {
    let mut scene = foggy();
    match lamp {
        None => scene = with_sun(scene),
        Some(lamp) => add_light(&mut scene, LightKind::Point, lamp, DVec3::X, Rgb::splat(7.0)),
    }
    for (corners, opacity, filter) in leaves {
        add_mesh(&mut scene, &[*corners], Material { filter_color: *filter, ..veil(*opacity) });
    }
    scene
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn shafts_equal_brute_force(leaves in leaves(), x in -0.4..0.4_f64, y in -0.4..0.4_f64, lamp in prop::option::of(vector(-2.0..2.0))) {
        let lamp = lamp.map(|lamp| lamp + DVec3::new(0.0, 1.5, -4.0));
        let direction = DVec3::new(x, y, -1.0).normalize();
        if let Some(lamp) = lamp {
            prop_assume!(lamp.cross(direction).length() > 0.3);
        }
        let triangles: Vec<_> = leaves
            .iter()
            .map(|(corners, opacity, filter)| (*corners, Rgb::splat(1.0 - opacity) + *opacity * *filter))
            .collect();
        let brute = BruteForce { triangles: &triangles };
        let end = 10.0 / -direction.z;
        let count = 40_000;
        let mut expected = Rgb::ZERO;
        for index in 0..count {
            let t = (f64::from(index) + 0.5) * end / f64::from(count);
            let p = t * direction;
            let (to, arriving, fog) = match lamp {
                None => (p + 100.0 * DVec3::Y, 7.0, 4.0 - p.y),
                Some(lamp) => (lamp, 7.0 / lamp.distance_squared(p), lamp.distance(p)),
            };
            let through = brute.between(DVec3::ZERO, p) * brute.between(p, to);
            expected += through * SIGMA_S / (4.0 * PI) * arriving * (-SIGMA_T * (t + fog)).exp() * end / f64::from(count);
        }
        let found = follow(&scene_of(&leaves, lamp), &EXACT, direction).shafts;
        // The oracle finds every edge to within a step of its own.
        let error = (found / expected - 1.0).abs().max_element();
        prop_assert!(error < 2e-4, "{found} {expected}");
    }

    #[test]
    fn the_order_of_leaves_does_not_show(leaves in leaves(), x in -0.4..0.4_f64, y in -0.4..0.4_f64) {
        let direction = DVec3::new(x, y, -1.0).normalize();
        let reversed: Vec<_> = leaves.iter().rev().copied().collect();
        let [a, b] = [&leaves, &reversed].map(|leaves| follow(&scene_of(leaves, None), &EXACT, direction));
        prop_assert!((a.radiance - b.radiance).abs().max_element() <= 1e-13 * a.radiance.max_element());
        prop_assert_eq!(a.transmittance, b.transmittance);
    }

    /// Nothing at all is no leaf, and hardly anything that comes through is an opaque one.
    #[test]
    fn both_ends_of_alpha(leaves in leaves(), x in -0.4..0.4_f64, y in -0.4..0.4_f64) {
        let direction = DVec3::new(x, y, -1.0).normalize();
        let with = |opacity: f64| {
            let leaves: Vec<_> = leaves.iter().map(|(corners, ..)| (*corners, opacity, Rgb::ZERO)).collect();
            follow(&scene_of(&leaves, None), &EXACT, direction)
        };
        let none = follow(&scene_of(&[], None), &EXACT, direction);
        prop_assert!((with(0.0).radiance - none.radiance).abs().max_element() < 1e-13);
        let mut opaque = scene_of(&leaves, None);
        for material in &mut opaque.materials {
            material.alpha_mode = AlphaMode::Opaque;
        }
        let (opaque, nearly) = (follow(&opaque, &EXACT, direction), with(1.0 - 1e-9));
        prop_assert!((opaque.radiance - nearly.radiance).abs().max_element() < 1e-6, "{opaque:?} {nearly:?}");
        prop_assert_eq!(opaque.radiance, with(1.0).radiance);
    }
}

/// Looking straight into the sun through a sheet: it dims both what lies behind and the sun before it.
#[test]
fn ray_and_light_in_line() {
    let mut scene = foggy();
    add_light(&mut scene, LightKind::Sun, DVec3::ZERO, DVec3::Z, Rgb::splat(7.0));
    let clear = follow(&scene, &EXACT, DVec3::NEG_Z);
    add_mesh(&mut scene, &sheet(DVec3::NEG_Z * 3.0, DVec3::X, DVec3::Y), veil(0.6));
    let dimmed = follow(&scene, &EXACT, DVec3::NEG_Z);
    // Light is dimmed once wherever it is scattered: before the sheet or behind it.
    assert!((dimmed.shafts.x / clear.shafts.x / 0.4 - 1.0).abs() < 1e-12, "{dimmed:?} {clear:?}");
    let nearly = follow(&scene, &EXACT, DVec3::new(1e-7, 0.0, -1.0).normalize());
    assert!((dimmed.shafts.x / nearly.shafts.x - 1.0).abs() < 1e-6, "{dimmed:?} {nearly:?}");
}

/// A texture whose alpha grows from one side to the other, against small steps.
#[test]
fn textured_alpha_and_the_baselines() {
    let mut scene = with_sun(foggy());
    let texels = (0..64).map(|column| [0.5, 0.4, 0.3, column as f32 / 63.0]).collect();
    scene.textures.push(Texture {
        name: String::new(),
        width: 64,
        height: 1,
        texels,
        wrap: [Wrap::Clamp; 2],
    });
    let tilted = sheet(DVec3::new(0.0, 1.0, -4.0), DVec3::new(2.0, 0.3, 0.0), DVec3::new(0.0, 0.2, -2.5));
    add_mesh(&mut scene, &tilted, Material { base_color_texture: Some(0), ..veil(0.9) });
    add_mesh(&mut scene, &sheet(DVec3::new(0.0, 0.0, -5.0), DVec3::X, DVec3::Y), veil(0.5));
    let mesh = &mut scene.meshes[0];
    mesh.uvs = mesh.positions.iter().map(|corner: &Vec3| Vec2::new((corner.z + 6.5) / 5.0, 0.5)).collect();
    let direction = DVec3::new(0.05, 0.02, -1.0).normalize();
    let by = |volume: VolumeMethod| follow(&scene, &Transport { volume, ..EXACT }, direction).shafts.x;
    let exact = by(VolumeMethod::Segments);
    assert!((by(VolumeMethod::March(MarchSteps::Count(50_000))) / exact - 1.0).abs() < 3e-3);
    assert!((by(VolumeMethod::Equiangular { points: 50_000 }) / exact - 1.0).abs() < 3e-3);
}
