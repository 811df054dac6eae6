//! Light of the ground itself and of fog above it, on the ground: against nothing, and against quadrature.

use crate::common::{INSTANT, add_fog, add_light, camera_at, coat, place};
use glam::{DAffine3, DVec3, Vec3};
use std::f64::consts::{FRAC_1_PI, PI};
use sunfleck::color::Rgb;
use sunfleck::indirect::{Indirect, KeptLight};
use sunfleck::math::Ray;
use sunfleck::scene::{Bounces, Instance, LightKind, Material, Mesh, Scene, Triangle};
use sunfleck::snapshot::{Exposure, MeshTrees};

const TO_SUN: DVec3 = DVec3::new(0.28, 0.77, 0.574);
const IRRADIANCE: f64 = 50.0;
const ALBEDO: f64 = 0.6;

/// A square that faces up.
fn add_square(scene: &mut Scene, middle: Vec3, half_m: f32, material: Material) {
    scene.materials.push(material);
    let material = scene.materials.len() - 1;
    let corner = |x: f32, z: f32| middle + half_m * Vec3::new(x, 0.0, z);
    scene.meshes.push(Mesh {
        positions: vec![corner(-1.0, 1.0), corner(1.0, 1.0), corner(1.0, -1.0), corner(-1.0, -1.0)],
        triangles: [[0, 1, 2], [0, 2, 3]].map(|vertices| Triangle { vertices, material }).to_vec(),
        ..Mesh::default()
    });
    let node = place(scene, DAffine3::IDENTITY);
    let (mesh, leaf_id) = (scene.meshes.len() - 1, scene.instances.len() as u32 + 1);
    scene.instances.push(Instance { node, mesh, material: None, leaf_id, deformation: None });
}

/// Ground in the sun under a black sky.
fn ground(half_m: f32, material: Material) -> Scene {
    let mut scene = camera_at(DVec3::new(0.0, 1.6, 8.0));
    add_square(&mut scene, Vec3::ZERO, half_m, Material { base_color: Rgb::splat(ALBEDO), ..material });
    add_light(&mut scene, LightKind::Sun, DVec3::ZERO, -TO_SUN, Rgb::splat(IRRADIANCE));
    scene
}

/// Indirect light that the ground sends towards the camera from places of it, W m^-2 sr^-1.
fn scattered(scene: &Scene, places: impl Iterator<Item = DVec3>) -> Vec<f64> {
    let trees = MeshTrees::new(scene);
    let exposure = Exposure::new(scene, &trees, 0, 1.0, INSTANT);
    let snapshot = exposure.middle();
    let indirect = Indirect::new(&exposure, Bounces::UpTo(1), 1.0, &KeptLight::default(), &|| false)
        .expect("there is ground");
    let of_place = |place: DVec3| {
        let ray = Ray { origin: DVec3::ZERO, direction: (place - snapshot.view.eye).normalize() };
        let hit = snapshot.tree.nearest_hit(&ray, f64::INFINITY, None).expect("ground is seen");
        indirect.scattered(snapshot, &snapshot.surface(&ray, &hit), 1.0).x
    };
    places.map(of_place).collect()
}

fn over_the_ground() -> impl Iterator<Item = DVec3> {
    (0..121).map(|number| DVec3::new(f64::from(number % 11) - 5.0, 0.0, f64::from(number / 11) - 5.0))
}

/// Black leaves above and below make finer grids about them, through which the ground goes.
#[test]
fn ground_does_not_light_itself() {
    for coat in [None, Some(coat(0.3)), Some(coat(0.7))] {
        let is_glossy = coat.is_some();
        let mut scene = ground(6.0, Material { coat, ..Material::default() });
        for middle in [Vec3::new(2.0, 3.4, 1.0), Vec3::new(-2.0, 3.9, -1.0), Vec3::new(0.0, -5.0, 0.0)] {
            add_square(&mut scene, middle, 0.15, Material { base_color: Rgb::ZERO, ..Material::default() });
        }
        let direct = FRAC_1_PI * ALBEDO * IRRADIANCE * TO_SUN.y;
        let worst = scattered(&scene, over_the_ground()).into_iter().fold(0.0, f64::max) / direct;
        println!("ground by its own light, glossy {is_glossy}: {worst:.1e}");
        assert!(worst < 2e-3, "{worst}");
    }
}

/// Fog ends where the ground does, as people put it: half a cell of it is beneath.
#[test]
fn fog_lights_the_ground() {
    let (density, half_m, height_m) = (0.02, 2.0, 2.0);
    let mut scene = ground(4.0, Material::default());
    let (low, high) = (DVec3::new(-half_m, 0.0, -half_m), DVec3::new(half_m, height_m, half_m));
    add_fog(&mut scene, low, high, Rgb::splat(density), Rgb::ONE, 0.0);
    for place in [DVec3::ZERO, DVec3::new(1.0, 0.0, -0.5), DVec3::new(-0.4, 0.0, 1.2)] {
        let found = scattered(&scene, std::iter::once(place))[0];
        let expected = FRAC_1_PI * ALBEDO * irradiance_of_fog(place, density, (low, high));
        println!("fog on the ground at {place}: {:.3}", found / expected);
        assert!((found / expected - 1.0).abs() < 0.06, "{found} {expected}");
    }
}

/// Of what even fog scatters once, by the middles of many small cubes: `sigma E e^-tau / 4 pi cos / r^2`.
fn irradiance_of_fog(place: DVec3, density: f64, (low, high): (DVec3, DVec3)) -> f64 {
    const STEPS: usize = 100;
    let step = (high - low) / STEPS as f64;
    let to_sun = TO_SUN.normalize();
    let of_cube = |number: usize| {
        let index = [number % STEPS, number / STEPS % STEPS, number / STEPS / STEPS];
        let middle = low + step * (DVec3::from_array(index.map(|index| index as f64)) + 0.5);
        let (way, up) = (middle - place, middle.y - place.y);
        let to_sky = ((high - middle) / to_sun).min_element();
        let through = (-density * (way.length() + to_sky)).exp();
        density * IRRADIANCE * through / (4.0 * PI) * up / way.length().powi(3) * step.element_product()
    };
    (0..STEPS.pow(3)).map(of_cube).sum()
}
