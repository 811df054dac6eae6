//! Lights with an extent against what is known of them in closed form, and against brute force.

use crate::common::{EXACT, add_fog, add_light, camera_at, look, place};
use glam::{DAffine3, DVec3};
use std::f64::consts::PI;
use std::sync::Arc;
use sunfleck::color::Rgb;
use sunfleck::math::{Ray, Sampler};
use sunfleck::scene::{
    AreaShape, Julia, LampTraits, Light, LightKind, SunDisc, SunPicture, SunShows, Texture, Track, Wrap,
};
use sunfleck::snapshot::{Luminaire, Watcher};

/// A light of power 1 at the origin that shines along -Z.
fn luminaire(kind: LightKind) -> Luminaire {
    let light = Light { name: String::new(), node: 0, power: Track::from(Rgb::ONE), kind };
    Luminaire::new(&light, DAffine3::IDENTITY, 0.0)
}

/// Irradiance of a plane with that normal, averaged over the light's points.
fn irradiance(luminaire: &Luminaire, at: DVec3, normal: DVec3) -> f64 {
    let count = 1 << 15;
    let mut sum = 0.0;
    for sample in 0..count {
        let point = luminaire.point(Sampler::new(11, 0, 0, sample).next_3d());
        let (to_light, _, arriving) = point.arriving_at(at);
        sum += arriving.x * to_light.dot(normal).max(0.0);
    }
    sum / f64::from(count)
}

fn assert_close(found: f64, expected: f64, tolerance: f64) {
    assert!((found / expected - 1.0).abs() < tolerance, "{found} instead of {expected}");
}

fn area(shape: AreaShape, width: f64, height: f64) -> LightKind {
    gridded(shape, [width, height], PI)
}

fn gridded(shape: AreaShape, size: [f64; 2], spread: f64) -> LightKind {
    let [width, height] = size.map(Track::from);
    LightKind::Area { shape, width, height, spread: Track::from(spread) }
}

fn sun_disc(angular_diameter: f64) -> LightKind {
    LightKind::SunDisc(SunDisc::even(Track::from(angular_diameter)))
}

/// `E = pi L R^2 / (R^2 + h^2)` on the axis of a disc of radiance `L = 1 W / (pi A)`.
#[test]
fn disc_on_its_axis() {
    let (radius, height): (f64, f64) = (0.7, 0.5);
    let light = luminaire(area(AreaShape::Ellipse, 2.0 * radius, 2.0 * radius));
    let radiance = 1.0 / (PI * PI * radius * radius);
    let expected = PI * radiance * radius * radius / (radius * radius + height * height);
    assert_close(irradiance(&light, DVec3::NEG_Z * height, DVec3::Z), expected, 1e-4);
    assert_eq!(irradiance(&light, DVec3::Z * height, DVec3::NEG_Z), 0.0, "it shines from one side");
}

/// Soft falloff: a disc that faces what it lights gives `I / (r^2 + d^2)`, on a plane that faces it.
#[test]
fn soft_falloff_is_a_disc_s() {
    let radius = 0.3;
    let soft = LampTraits { soft_falloff: true, ..LampTraits::default() };
    let light = luminaire(LightKind::Sphere { radius: Track::from(radius) }).with(soft);
    for distance in [0.4, 0.7, 2.0] {
        let expected = 1.0 / (radius * radius + distance * distance);
        assert_close(irradiance(&light, DVec3::X * distance, DVec3::NEG_X), expected, 3e-3);
    }
}

/// What is seen of a lamp is what it lights with: radiances over its outline add up to its irradiance.
#[test]
fn lamps_are_seen_as_bright_as_they_light() {
    let seen = LampTraits { visible_to_camera: true, ..LampTraits::default() };
    let sphere = LightKind::Sphere { radius: Track::from(0.3) };
    let kinds = [sphere, area(AreaShape::Ellipse, 0.5, 0.8), gridded(AreaShape::Rectangle, [0.5, 0.3], 1.5)];
    for (kind, soft_falloff) in kinds.into_iter().flat_map(|kind| [(kind.clone(), false), (kind, true)]) {
        let light = luminaire(kind).with(LampTraits { soft_falloff, ..seen });
        let (eye, count) = (DVec3::new(0.2, -0.1, -1.5), 1 << 15);
        let mut sum = 0.0;
        for sample in 0..count {
            let (x, y) = Sampler::new(11, 0, 0, sample).next_2d();
            let way = DVec3::new(x - 0.5, y - 0.5, 1.0);
            let ray = Ray { origin: eye, direction: way.normalize() };
            assert_eq!(light.met_by(Watcher::Mirror, &ray), None, "only the camera sees it");
            if let Some((t, radiance)) = light.met_by(Watcher::Camera, &ray) {
                assert!((1.0..1.8).contains(&t), "{t}");
                // A plane's cosine, and the solid angle of a square metre at one metre.
                sum += radiance.x / way.length().powi(4) / f64::from(count);
            }
        }
        assert_close(sum, irradiance(&light, eye, DVec3::Z), 1e-2);
    }
}

/// Under a corner of a rectangle (Howell, "A Catalog of Radiation Heat Transfer Configuration Factors", B-3).
#[test]
fn rectangle_over_its_corner() {
    let (width, length, height): (f64, f64, f64) = (1.2, 0.6, 0.4);
    let light = luminaire(area(AreaShape::Rectangle, width, length));
    let (a, b) = (width / height, length / height);
    let half = |a: f64, b: f64| a / (1.0 + a * a).sqrt() * (b / (1.0 + a * a).sqrt()).atan();
    let factor = (half(a, b) + half(b, a)) / (2.0 * PI);
    let corner = DVec3::new(0.5 * width, -0.5 * length, -height);
    assert_close(irradiance(&light, corner, DVec3::Z), factor / (width * length), 2e-4);
}

/// A grid narrows the beam and keeps its power: `int I dw = 1 W`, of which none is beyond the angle.
#[test]
fn a_grid_before_a_flat_light_keeps_its_power() {
    for spread in [0.01, 0.1, 1.0, 2.5, PI - 1e-4, PI] {
        let light = luminaire(gridded(AreaShape::Rectangle, [1e-9; 2], spread));
        let intensity =
            |angle: f64| light.centre().arriving_at(DVec3::new(angle.sin(), 0.0, -angle.cos())).2.x;
        let steps = 20_000;
        let width = 0.5 * spread / f64::from(steps);
        let ring = |step: u32| (f64::from(step) + 0.5) * width;
        let power: f64 = (0..steps).map(ring).map(|a| 2.0 * PI * a.sin() * intensity(a) * width).sum();
        assert_close(power, 1.0, 1e-6);
        assert_eq!(intensity(0.5 * spread + 1e-6), 0.0);
    }
}

/// A sphere lights what it stands wholly above like a point, and what it stands half above as its
/// form factor says (Howell, B-17 and B-18): both hold of a surface of one radiance only.
#[test]
fn sphere_above_and_on_the_horizon() {
    let (radius, distance): (f64, f64) = (0.8, 1.3);
    let light = luminaire(LightKind::Sphere { radius: Track::from(radius) });
    let at = DVec3::new(0.0, -distance, 0.0);
    assert_close(irradiance(&light, at, DVec3::Y), 1.0 / (distance * distance), 3e-4);
    let tilted = DVec3::new(0.3, 1.0, 0.1).normalize();
    assert_close(irradiance(&light, at, tilted), tilted.y / (distance * distance), 3e-4);
    let d = distance / radius;
    let root = (d * d - 1.0).sqrt();
    let factor = ((1.0 / root).atan() - root / (d * d)) / PI;
    let radiance = 1.0 / (PI * radius * radius);
    assert_close(irradiance(&light, at, DVec3::X), PI * radiance * factor, 1e-3);
}

/// The sun's irradiance is what the author wrote, also at 90 degrees across, and half a sun on the
/// horizon gives `L (alpha - sin alpha cos alpha)`.
#[test]
fn sun_disc_above_and_on_the_horizon() {
    for diameter in [0.00925, 0.5, PI / 2.0] {
        let light = luminaire(sun_disc(diameter));
        assert_close(irradiance(&light, DVec3::ZERO, DVec3::Z), 1.0, 1e-12);
        let alpha: f64 = 0.5 * diameter;
        let expected = (alpha - alpha.sin() * alpha.cos()) / (PI * alpha.sin().powi(2));
        assert_close(irradiance(&light, DVec3::ZERO, DVec3::X), expected, 1e-3);
    }
}

/// A fractal with a darker limb on a wide disc that the camera sees.
fn fractal_sun(angular_diameter: f64, picture_rotation: f64) -> LightKind {
    let julia = Julia { real: Track::from(-0.012375), imaginary: Track::from(0.56805), iterations: 100 };
    LightKind::SunDisc(SunDisc {
        picture: SunPicture::new(SunShows::Julia(julia), 0.5),
        picture_rotation: Track::from(picture_rotation),
        visible_to_camera: true,
        ..SunDisc::even(Track::from(angular_diameter))
    })
}

/// What the points of a sun give, quarter by quarter, is the integral of what the camera sees of it.
/// (A Julia set's opposite quarters are alike.)
#[test]
fn what_is_seen_of_a_sun_is_what_lights() {
    let alpha: f64 = 0.3;
    let sun = luminaire(fractal_sun(2.0 * alpha, 0.7));
    let count = 1 << 14;
    let (mut lit, mut seen) = ([Rgb::ZERO; 2], [Rgb::ZERO; 2]);
    for sample in 0..count {
        let u = Sampler::new(8, 0, 0, sample).next_3d();
        let (to_sun, _, arriving) = sun.point(u).arriving_at(DVec3::ZERO);
        lit[usize::from(to_sun.x * to_sun.y > 0.0)] += arriving * to_sun.z / f64::from(count);
        // The same integral with directions that know nothing of the picture.
        let (sin, angle) = (alpha.sin() * u[0].sqrt(), 2.0 * PI * u[1]);
        let direction = DVec3::new(sin * angle.cos(), sin * angle.sin(), (1.0 - sin * sin).sqrt());
        seen[usize::from(direction.x * direction.y > 0.0)] +=
            sun.seen_along(direction) * PI * alpha.sin().powi(2) / f64::from(count);
    }
    assert!((lit[0] + lit[1] - 1.0).abs().max_element() < 5e-3, "{lit:?}");
    for quarter in 0..2 {
        assert!((lit[quarter] - seen[quarter]).abs().max_element() < 5e-3, "{lit:?} {seen:?}");
    }
    assert!((lit[0] - lit[1]).length() > 0.05, "the quarters are too alike to tell them apart: {lit:?}");
    for outside in [DVec3::new(alpha.sin() + 1e-6, 0.0, alpha.cos()), DVec3::NEG_Z] {
        assert_eq!(sun.seen_along(outside.normalize()), Rgb::ZERO);
    }
}

/// An image on the sun stands upright to someone who faces it, and turns anticlockwise.
#[test]
fn pictures_stand_upright() {
    let size = 200;
    let bright = |texel: usize| if texel / size < size / 20 { [1.0; 4] } else { [1e-6; 4] };
    let texels = (0..size * size).map(bright).collect();
    let image = Texture { name: String::new(), width: size, height: size, texels, wrap: [Wrap::Clamp; 2] };
    let picture = SunPicture::new(SunShows::Image(Arc::new(image)), 0.0);
    for (rotation, brightest) in [(0.0, DVec3::Y), (PI / 2.0, DVec3::NEG_X)] {
        let disc = SunDisc {
            picture: picture.clone(),
            picture_rotation: Track::from(rotation),
            visible_to_camera: true,
            ..SunDisc::even(Track::from(0.2))
        };
        let mut scene = camera_at(DVec3::ZERO);
        add_light(&mut scene, LightKind::SunDisc(disc), DVec3::ZERO, DVec3::Z, Rgb::ONE);
        // The camera looks along -Z, where the sun is: x of the film is x of the world, y is -y.
        let at = |p: DVec3| look(&scene, &EXACT, 0.5 + 0.5 * p.x, 0.5 - 0.5 * p.y).radiance.x;
        let reach = 0.1_f64.tan() * 0.97;
        for side in [DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Y] {
            assert_eq!(at(side * reach) > 1.0, side == brightest, "{rotation}: {side}");
        }
    }
}

/// Seen through fog and in a mirror the sun's disc has the radiance `E / (pi sin^2)`, weakened.
#[test]
fn a_sun_that_is_seen_is_weakened_by_fog_and_mirrors() {
    let disc = SunDisc { visible_to_camera: true, ..SunDisc::even(Track::from(0.2)) };
    let mut scene = camera_at(DVec3::ZERO);
    add_fog(&mut scene, DVec3::splat(-2.0), DVec3::splat(2.0), Rgb::splat(0.3), Rgb::ZERO, 0.0);
    add_light(&mut scene, LightKind::SunDisc(disc.clone()), DVec3::ZERO, DVec3::Z, Rgb::splat(3.0));
    let radiance = 3.0 / (PI * 0.1_f64.sin().powi(2));
    let through = (-0.6_f64).exp();
    assert_close(look(&scene, &EXACT, 0.5, 0.5).radiance.x, radiance * through, 1e-12);
    assert_eq!(look(&scene, &EXACT, 0.6, 0.5).radiance.x, 0.0);
    // A mirror 1 m before the eye shows the sun behind it.
    let mut mirrored = camera_at(DVec3::ZERO);
    add_fog(&mut mirrored, DVec3::splat(-2.0), DVec3::splat(2.0), Rgb::splat(0.3), Rgb::ZERO, 0.0);
    add_light(&mut mirrored, LightKind::SunDisc(disc), DVec3::ZERO, DVec3::NEG_Z, Rgb::splat(3.0));
    add_quad(&mut mirrored, DVec3::NEG_Z, DVec3::X, DVec3::Y);
    mirrored.materials[0].mirror = Rgb::splat(0.5);
    mirrored.materials[0].base_color = Rgb::ZERO;
    let expected = 0.5 * radiance * (-0.3 * 4.0_f64).exp();
    assert_close(look(&mirrored, &EXACT, 0.5, 0.5).radiance.x, expected, 1e-9);
}

/// Every point of the light is within it.
#[test]
fn points_lie_on_their_light() {
    let sun = luminaire(sun_disc(0.4));
    let sphere = luminaire(LightKind::Sphere { radius: Track::from(0.5) });
    for sample in 0..1000 {
        let u = Sampler::new(1, 0, 0, sample).next_3d();
        let (to_sun, ..) = sun.point(u).arriving_at(DVec3::ZERO);
        assert!(to_sun.is_normalized() && to_sun.z.acos() <= 0.2 + 1e-7);
        let (direction, distance, _) = sphere.point(u).arriving_at(DVec3::Y);
        assert!((DVec3::Y + direction * distance).length() <= 0.5 + 1e-12);
    }
}

/// Under an edge far to both sides the sun's visible part is a circle without a segment.
#[test]
fn penumbra_of_an_edge() {
    let diameter = 0.04;
    let edge_height = 10.0;
    let half_width = edge_height * (0.5_f64 * diameter).tan();
    for offset in [-0.9, -0.4, 0.0, 0.3, 0.8] {
        let mut scene = camera_at(DVec3::new(0.0, 1.0, 0.0));
        // The ground 2 m before the eye, facing it, and a roof over all x below the edge.
        add_quad(&mut scene, DVec3::new(0.0, 1.0, -2.0), DVec3::X * 50.0, DVec3::Y * 50.0);
        let edge = offset * half_width;
        let roof = DVec3::new(edge - 30.0, 1.0, -2.0 + edge_height);
        add_quad(&mut scene, roof, DVec3::X * 30.0, DVec3::Y * 50.0);
        add_light(&mut scene, sun_disc(diameter), DVec3::ZERO, DVec3::NEG_Z, Rgb::splat(PI / 0.8));
        let found = mean(&scene, |sample| sample.radiance.x);
        // With the edge at c radii to the left of the middle, 1 - (acos(c) - c sqrt(1 - c^2)) / pi.
        let c: f64 = -offset;
        let expected = 1.0 - (c.acos() - c * (1.0 - c * c).sqrt()) / PI;
        assert!((found - expected).abs() < 3e-3, "{offset}: {found} {expected}");
    }
}

/// The mean of the ray through the middle of the picture over the light's points.
fn mean(scene: &sunfleck::scene::Scene, value: impl Fn(&sunfleck::transport::Sample) -> f64) -> f64 {
    use sunfleck::snapshot::{MeshTrees, Snapshot};
    let snapshot = Snapshot::new(scene, &MeshTrees::new(scene), 0, 1.0, crate::common::INSTANT);
    let ray = snapshot.view.ray(0.5, 0.5);
    let mut scratch = sunfleck::transport::Scratch::default();
    let count = 1 << 12;
    let mut sum = 0.0;
    for index in 0..count {
        let mut sampler = Sampler::new(5, 0, 0, index);
        sum += value(&sunfleck::transport::radiance(&snapshot, &EXACT, &ray, &mut sampler, &mut scratch));
    }
    sum / f64::from(count)
}

/// Two triangles about `centre`, 0.8 grey.
fn add_quad(scene: &mut sunfleck::scene::Scene, centre: DVec3, half_x: DVec3, half_y: DVec3) {
    use sunfleck::scene::{Instance, Material, Mesh, Triangle};
    let corners = [-half_x - half_y, half_x - half_y, half_x + half_y, half_y - half_x];
    scene.meshes.push(Mesh {
        positions: corners.map(DVec3::as_vec3).to_vec(),
        triangles: [[0, 1, 2], [0, 2, 3]].map(|vertices| Triangle { vertices, material: 0 }).to_vec(),
        ..Mesh::default()
    });
    if scene.materials.is_empty() {
        scene.materials.push(Material { base_color: Rgb::splat(0.8), ..Material::default() });
    }
    let node = place(scene, DAffine3::from_translation(centre));
    let (mesh, leaf_id) = (scene.meshes.len() - 1, scene.instances.len() as u32 + 1);
    scene.instances.push(Instance { node, mesh, material: None, leaf_id, deformation: None });
}

/// A card in the fog under a wide sun, against steps along the ray and rings and spokes of the sun's disc.
#[test]
fn soft_shafts_equal_brute_force() {
    let (sigma, far) = (0.3, 6.0);
    let (diameter, card_height) = (0.3_f64, 0.8);
    let mut scene = camera_at(DVec3::ZERO);
    add_fog(
        &mut scene,
        DVec3::new(-9.0, -9.0, -far),
        DVec3::new(9.0, 9.0, 0.0),
        Rgb::splat(sigma),
        Rgb::ONE,
        0.0,
    );
    add_quad(&mut scene, DVec3::new(0.0, card_height, -3.0), DVec3::X * 0.15, DVec3::Z * 0.2);
    add_light(&mut scene, sun_disc(diameter), DVec3::ZERO, DVec3::NEG_Y, Rgb::ONE);
    let found = mean(&scene, |sample| sample.shafts.x);

    let (rings, spokes, steps) = (100, 100, 3000);
    let mut expected = 0.0;
    for ring in 0..rings {
        let sin = (0.5 * diameter).sin() * ((f64::from(ring) + 0.5) / f64::from(rings)).sqrt();
        let cos = (1.0 - sin * sin).sqrt();
        for spoke in 0..spokes {
            let angle = 2.0 * PI * (f64::from(spoke) + 0.5) / f64::from(spokes);
            let to_sun = DVec3::new(sin * angle.cos(), cos, sin * angle.sin());
            for step in 0..steps {
                let t = far * (f64::from(step) + 0.5) / f64::from(steps);
                let at_card =
                    DVec3::NEG_Z * t + to_sun * (card_height / cos) - DVec3::new(0.0, card_height, -3.0);
                if at_card.x.abs() < 0.15 && at_card.z.abs() < 0.2 {
                    continue;
                }
                // Out of the fog at its top or its ends.
                let to_end = if to_sun.z > 0.0 { t / to_sun.z } else { (t - far) / to_sun.z };
                let way = (9.0 / cos).min(to_end);
                expected += (-sigma * (t + way)).exp() / cos;
            }
        }
    }
    expected *= sigma / (4.0 * PI) * far / f64::from(steps) / f64::from(rings * spokes);
    assert_close(found, expected, 1e-3);
}

/// A flat light so small that it is a point: its plane, or its grid's cone, bounds the light along the ray.
#[test]
fn flat_light_in_fog_equals_dense_quadrature() {
    let sigma = 0.2;
    let position = DVec3::new(0.4, 0.9, -3.0);
    for (beam, half_angle) in [
        (DVec3::new(0.3, -0.4, -1.0), 0.5 * PI),
        (DVec3::new(-1.0, 0.05, 0.2), 0.5 * PI),
        (DVec3::NEG_Y, 0.5 * PI),
        (DVec3::NEG_Y, 0.6),
        // Rays go past the axis closely.
        (DVec3::new(-0.4, -0.9, 0.001), 0.2),
    ] {
        let beam = beam.normalize();
        let mut scene = camera_at(DVec3::ZERO);
        let (low, high) = (DVec3::splat(-9.0), DVec3::splat(9.0));
        add_fog(&mut scene, low, high, Rgb::splat(sigma), Rgb::ONE, 0.5);
        let light = gridded(AreaShape::Rectangle, [1e-9; 2], 2.0 * half_angle);
        add_light(&mut scene, light, position, beam, Rgb::splat(PI));
        let narrowed = 1.0 - half_angle / half_angle.tan();
        for (x, y) in [(0.5, 0.5), (0.45, 0.35), (0.9, 0.2)] {
            let direction = DVec3::new(2.0 * x - 1.0, 1.0 - 2.0 * y, -1.0).normalize();
            let (end, count) = (9.0 / -direction.z, 1_000_000);
            let mut expected = 0.0;
            for index in 0..count {
                let t = end * (f64::from(index) + 0.5) / f64::from(count);
                let way = position - direction * t;
                let (distance, to_light) = (way.length(), way.normalize());
                let phase = 0.75 / (4.0 * PI * (1.25 - to_light.dot(direction)).powf(1.5));
                let angle = (-to_light.dot(beam)).clamp(-1.0, 1.0).acos();
                let share = (half_angle - angle).sin().max(0.0) / half_angle.sin() / narrowed;
                expected += share * phase * (-sigma * (t + distance)).exp() / (distance * distance);
            }
            expected *= sigma * end / f64::from(count);
            let found = look(&scene, &EXACT, x, y).shafts.x;
            // Some rays pass a grid's cone by.
            assert!((found - expected).abs() <= 1e-6 * expected, "{found} instead of {expected}");
        }
    }
}

/// Surfaces and fog in and on a light: finite, whatever the points.
#[test]
fn nothing_is_undefined_on_a_light() {
    let kinds = [
        area(AreaShape::Rectangle, 1.0, 1.0),
        area(AreaShape::Ellipse, 1.0, 1.0),
        gridded(AreaShape::Ellipse, [1.0, 1.0], 0.1),
        LightKind::Sphere { radius: Track::from(1.0) },
        LightKind::Spot {
            outer_angle: Track::from(PI / 2.0),
            blend: Track::from(1.0),
            radius: Track::from(1.0),
        },
    ];
    for kind in kinds {
        // The light stands in the surface that the ray meets, and once more in the eye.
        for position in [DVec3::new(0.0, 0.0, -2.0), DVec3::ZERO] {
            let mut scene = camera_at(DVec3::ZERO);
            add_fog(&mut scene, DVec3::splat(-4.0), DVec3::splat(4.0), Rgb::ONE, Rgb::ONE, 0.9);
            add_quad(&mut scene, DVec3::new(0.0, 0.0, -2.0), DVec3::X, DVec3::Y);
            add_light(&mut scene, kind.clone(), position, DVec3::Z, Rgb::ONE);
            let found = mean(&scene, |sample| sample.radiance.x);
            assert!(found.is_finite() && found >= 0.0, "{kind:?}: {found}");
        }
    }
    let light = luminaire(area(AreaShape::Rectangle, 1.0, 1.0));
    let ray = Ray { origin: DVec3::new(-2.0, 0.0, 0.0), direction: DVec3::X };
    let (_, _, arriving) = light.point([0.5, 0.5, 0.5]).arriving_at(ray.at(2.0));
    assert_eq!(arriving, Rgb::ZERO);
}

/// A sphere's surface in even fog, from its radiance over the part of it that is seen.
#[test]
fn fog_takes_a_spheres_light_from_its_surface_on() {
    let (radius, distance) = (0.4, 2.0);
    // Exact from afar; five radii away its chords fan out, which shows the more the thicker the fog is.
    for (extinction, tolerance) in [(0.0, 1e-5), (0.05, 1e-4), (0.5, 1e-3), (2.0, 5e-3)] {
        let sphere = luminaire(LightKind::Sphere { radius: Track::from(radius) });
        let sphere = sphere.in_fog(Rgb::splat(extinction));
        let count = 1 << 15;
        let arriving = |sample| {
            let light = sphere.point(Sampler::new(5, 0, 0, sample).next_3d());
            let (_, distance, arriving) = light.arriving_at(DVec3::new(0.0, 0.0, distance));
            arriving.x * (-extinction * distance).exp()
        };
        let found = (0..count).map(arriving).sum::<f64>() / f64::from(count);

        let radiance = 1.0 / (PI * radius * radius);
        let steps = 20_000;
        let edge = (radius / distance).asin();
        let ring = |step: i32| {
            let angle = edge * (f64::from(step) + 0.5) / f64::from(steps);
            let beside = distance * angle.sin();
            let way = distance * angle.cos() - (radius * radius - beside * beside).max(0.0).sqrt();
            2.0 * PI * angle.sin() * radiance * (-extinction * way).exp() * edge / f64::from(steps)
        };
        assert_close(found, (0..steps).map(ring).sum(), tolerance);
    }
}
