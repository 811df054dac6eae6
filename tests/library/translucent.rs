//! Light through leaves: against closed forms, in a white furnace, and slices against rays.

use crate::checkout;
use crate::common::{EXACT, INSTANT, add_fog, add_light, place, sheet};
use glam::{DAffine3, DVec2, DVec3};
use std::f64::consts::{FRAC_1_PI, PI, TAU};
use sunfleck::color::Rgb;
use sunfleck::math::{Ray, Sampler};
use sunfleck::scene::{Instance, LightKind, Material, Scene, Size};
use sunfleck::snapshot::{MeshTrees, Snapshot};
use sunfleck::transport::slices::{Fan, Piece, Ring, SliceJob, SliceScratch};
use sunfleck::transport::{Scratch, radiance};
use sunfleck::{description, scene};

const ALBEDO: Rgb = Rgb::new(0.3, 0.2, 0.1);
const TRANSMISSION: Rgb = Rgb::new(0.5, 0.7, 0.2);

fn leaf() -> Material {
    Material { base_color: ALBEDO, transmission: TRANSMISSION, ..Material::default() }
}

/// What a ray from the camera sees.
fn seen(scene: &Scene, direction: DVec3) -> Rgb {
    let snapshot = Snapshot::new(scene, &MeshTrees::new(scene), 0, 1.0, INSTANT);
    let ray = Ray { origin: DVec3::ZERO, direction };
    radiance(&snapshot, &EXACT, &ray, &mut Sampler::new(0, 0, 0, 0), &mut Scratch::default()).radiance
}

fn assert_close(found: Rgb, expected: Rgb, tolerance: f64) {
    let error = ((found - expected) / expected).abs().max_element();
    assert!(error <= tolerance, "{found} {expected}: {error:.1e}");
}

/// The sun behind the leaf and before it: each side in its own colour.
#[test]
fn sun_through_a_leaf_and_on_it() {
    for (beam, color) in [(DVec3::new(0.3, -0.5, 1.0), TRANSMISSION), (DVec3::new(0.3, -0.5, -1.0), ALBEDO)] {
        let mut scene = sheet(leaf());
        add_light(&mut scene, LightKind::Sun, DVec3::ZERO, beam, Rgb::splat(7.0));
        let cos = beam.z.abs() / beam.length();
        let toward = DVec3::new(0.1, 0.05, -1.0).normalize();
        assert_close(seen(&scene, toward), FRAC_1_PI * color * cos * 7.0, 1e-12);
    }
}

/// A lamp behind the leaf, in fog: what comes through is weakened on both ways.
#[test]
fn lamp_through_a_leaf_in_fog() {
    let mut scene = sheet(leaf());
    let sigma_t = Rgb::new(0.1, 0.2, 0.3);
    let (low, high) = (DVec3::new(-20.0, -20.0, -20.0), DVec3::new(20.0, 20.0, 20.0));
    add_fog(&mut scene, low, high, sigma_t, Rgb::ZERO, 0.0);
    let lamp = DVec3::new(0.5, 1.0, -5.0);
    add_light(&mut scene, LightKind::Point, lamp, DVec3::X, Rgb::splat(40.0));
    let place = 3.0 * DVec3::NEG_Z;
    let way = lamp - place;
    let (distance, cos) = (way.length(), -way.z / way.length());
    let fog = (-sigma_t * (3.0 + distance)).exp();
    let expected = FRAC_1_PI * TRANSMISSION * cos * 40.0 / (distance * distance) * fog;
    assert_close(seen(&scene, DVec3::NEG_Z), expected, 1e-12);
}

/// Nothing comes through what has no transmission, nor through a leaf in the shadow of another thing.
#[test]
fn dark_behind() {
    let mut scene = sheet(Material { transmission: Rgb::ZERO, ..leaf() });
    add_light(&mut scene, LightKind::Sun, DVec3::ZERO, DVec3::Z, Rgb::splat(7.0));
    assert_eq!(seen(&scene, DVec3::NEG_Z), Rgb::ZERO);
    let mut scene = sheet(leaf());
    add_light(&mut scene, LightKind::Sun, DVec3::ZERO, DVec3::Z, Rgb::splat(7.0));
    assert!(seen(&scene, DVec3::NEG_Z).min_element() > 0.0);
    let node = place(&mut scene, DAffine3::from_translation(4.0 * DVec3::NEG_Z));
    scene.instances.push(Instance { node, mesh: 0, material: None, leaf_id: 2, deformation: None });
    assert_eq!(seen(&scene, DVec3::NEG_Z), Rgb::ZERO);
}

/// A leaf that takes nothing away, in light from everywhere, cannot be told from that light.
#[test]
fn white_furnace() {
    let (count, surroundings) = (4000, 2.0);
    for share in [0.0, 0.35, 1.0] {
        let (base_color, transmission) = (Rgb::splat(share), Rgb::splat(1.0 - share));
        let mut scene = sheet(Material { base_color, transmission, ..Material::default() });
        // Suns on a Fibonacci lattice of the sphere, each for the same solid angle.
        for number in 0..count {
            let y = 1.0 - (2.0 * f64::from(number) + 1.0) / f64::from(count);
            let (sin, cos) = (f64::from(number) * TAU * 0.618_033_988_749_895).sin_cos();
            let beam = DVec3::new(cos, 0.0, sin) * (1.0 - y * y).sqrt() + y * DVec3::Y;
            let irradiance = Rgb::splat(surroundings * 4.0 * PI / f64::from(count));
            add_light(&mut scene, LightKind::Sun, DVec3::ZERO, beam, irradiance);
        }
        assert_close(seen(&scene, DVec3::new(0.2, 0.1, -1.0).normalize()), Rgb::splat(surroundings), 1e-3);
    }
}

/// Leaves before the sun, without fog: what is seen is direct light alone, most of it from behind.
#[test]
fn slices_see_the_same_light_as_rays() {
    let path = checkout::file("tests/data/leaves500/leaves500.glb");
    let mut scene = scene::resolve(description::load(&path).expect("a good file"), None).expect("a scene").0;
    scene.fogs.clear();
    scene.lights.clear();
    for material in &mut scene.materials {
        (material.base_color, material.transmission) = (ALBEDO, TRANSMISSION);
    }
    let size = Size { width: 160, height: 90 };
    for (kind, position) in [(LightKind::Sun, DVec3::ZERO), (LightKind::Point, DVec3::new(0.5, 3.0, -1.0))] {
        scene.lights.clear();
        add_light(&mut scene, kind, position, DVec3::new(0.1, -0.6, 0.8), Rgb::splat(10.0));
        let snapshot = Snapshot::new(&scene, &MeshTrees::new(&scene), 0, 16.0 / 9.0, INSTANT);
        let light = snapshot.lights[0].centre();
        let fan = Fan::new(&snapshot.view, size, DVec2::ZERO, light.place()).expect("a fan");
        let job = SliceJob {
            snapshot: &snapshot,
            transport: &EXACT,
            light: &light,
            hue: Rgb::ONE,
            has_rest: true,
            fan: &fan,
        };
        let (mut rays, mut slices) = (Scratch::default(), SliceScratch::default());
        let (mut lit, mut differ, mut squares, mut sum) = (0, 0, 0.0, 0.0);
        for number in 0..29 {
            let angle = fan.angles.0 + fan.angles.1 * (f64::from(number) + 0.4) / 29.0;
            let Some(slice) = fan.slice(angle, Ring::WHOLE) else { continue };
            let areas = (0..100).map(|index| slice.area_per_rad * (f64::from(index) + 0.5) / 100.0);
            let chords = areas.map(|area| slice.ray(area));
            job.solve(&slice, chords, None, &mut slices, |Piece { place, .. }, value| {
                let film = place.film_px / DVec2::new(160.0, 90.0);
                let ray = snapshot.view.ray(film.x, film.y);
                let mut sampler = Sampler::new(0, 0, 0, 0);
                let truth = radiance(&snapshot, &EXACT, &ray, &mut sampler, &mut rays).radiance;
                let error = (value.radiance - truth).length();
                lit += usize::from(truth != Rgb::ZERO);
                if error > 1e-3 {
                    differ += 1;
                } else {
                    squares += error * error;
                    sum += truth.length();
                }
            });
        }
        // Rays through the very edge of a triangle or of a shadow may be on either side of it.
        assert!(lit > 500 && differ * 1000 <= lit, "{differ} of {lit}");
        let error = (squares * lit as f64).sqrt() / sum;
        assert!(error <= 1e-6, "{error:.1e}");
    }
}
