//! Fog that thins out with height, alone and together with boxes. It is held against closed forms, and
//! against dense quadrature written straight from the reference model.

use crate::common::{EXACT, INSTANT, add_fog, add_layer, add_light, camera_at, place};
use glam::{DAffine3, DVec3};
use proptest::prelude::*;
use std::f64::consts::PI;
use sunfleck::color::Rgb;
use sunfleck::math::{Ray, Sampler, gauss_legendre};
use sunfleck::scene::{Fog, FogShape, HeightFalloff, LightKind, Scene, Track};
use sunfleck::snapshot::{MeshTrees, Snapshot};
use sunfleck::transport::{MarchSteps, Sample, Scratch, Transport, VolumeMethod, radiance};

/// A bank of the quadrature, in world space.
#[derive(Clone, Copy, Debug)]
struct Bank {
    bounds: Option<(DVec3, DVec3)>,
    base: f64,
    /// Infinite where density does not change.
    scale_height: f64,
    sigma_t: f64,
    albedo: f64,
    g: f64,
}

impl Bank {
    fn phase(&self, cos: f64) -> f64 {
        (1.0 - self.g * self.g) / (4.0 * PI * (1.0 + self.g * self.g - 2.0 * self.g * cos).powf(1.5))
    }

    fn sigma_t_at(&self, p: DVec3) -> f64 {
        let inside = self.bounds.is_none_or(|(low, high)| p.cmpge(low).all() && p.cmple(high).all());
        let height = (p.y - self.base).max(0.0);
        if inside { self.sigma_t * (-height / self.scale_height).exp() } else { 0.0 }
    }

    /// Where the density jumps or has a kink on a line.
    fn cuts(&self, origin: DVec3, direction: DVec3) -> Vec<f64> {
        let mut cuts = vec![(self.base - origin.y) / direction.y];
        for (corner, axis) in
            self.bounds.into_iter().flat_map(|(a, b)| [a, b]).flat_map(|c| (0..3).map(move |i| (c, i)))
        {
            cuts.push((corner[axis] - origin[axis]) / direction[axis]);
        }
        cuts
    }

    /// By quadrature, on pieces over which density changes by a factor of at most e^6: to 1e-12 by 12 nodes.
    fn depth(&self, origin: DVec3, direction: DVec3, length: f64) -> f64 {
        let mut cuts = self.cuts(origin, direction);
        cuts.retain(|t| *t > 0.0 && *t < length);
        cuts.extend([0.0, length]);
        cuts.sort_by(f64::total_cmp);
        let mut depth = 0.0;
        for pair in cuts.windows(2) {
            // Between cuts all is inside of its bounds, or nothing.
            if self.sigma_t_at(origin + direction * 0.5 * (pair[0] + pair[1])) == 0.0 {
                continue;
            }
            let folds = (pair[1] - pair[0]) * direction.y.abs() / self.scale_height;
            let pieces = (folds / 6.0).ceil().clamp(1.0, 1e3);
            let half = 0.5 * (pair[1] - pair[0]) / pieces;
            for piece in 0..pieces as usize {
                let middle = pair[0] + (2 * piece + 1) as f64 * half;
                for (x, weight) in gauss_legendre(12) {
                    depth += half * weight * self.sigma_t_at(origin + direction * (middle + x * half));
                }
            }
        }
        depth
    }
}

/// Flatter rays see further than the quadrature goes; `level_with_the_ground` has those.
const FLATTEST: f64 = 0.05;

/// Nothing shows beyond this: up the flattest ray it is 60 of the largest scale heights away, and down any
/// ray there is fog of at least 0.02 per metre on most of the way.
const FAR: f64 = 12_000.0;

/// How far to go where nothing ends: 60 scale heights up, or `far`.
fn reach(banks: &[Bank], origin: DVec3, direction: DVec3, far: f64) -> f64 {
    let height = |bank: &Bank| (bank.base - origin.y).max(0.0) + 60.0 * bank.scale_height;
    let highest = banks.iter().map(height).filter(|h| h.is_finite()).fold(1.0, f64::max);
    if direction.y > 0.0 { (highest / direction.y).min(far) } else { far }
}

/// Light that the fog scatters into a ray, `pieces` pieces between each two kinks of density.
fn dense(
    banks: &[Bank],
    eye: DVec3,
    direction: DVec3,
    more_cuts: &[f64],
    pieces: usize,
    light: impl Fn(DVec3) -> (DVec3, f64, f64),
) -> f64 {
    let end = reach(banks, eye, direction, FAR);
    let mut cuts: Vec<f64> = banks.iter().flat_map(|bank| bank.cuts(eye, direction)).collect();
    cuts.extend(more_cuts);
    cuts.retain(|t| *t > 0.0 && *t < end);
    cuts.extend([0.0, end]);
    cuts.sort_by(f64::total_cmp);
    let mut sum = 0.0;
    for pair in cuts.windows(2) {
        let half = 0.5 * (pair[1] - pair[0]) / pieces as f64;
        for piece in 0..pieces {
            let middle = pair[0] + (2 * piece + 1) as f64 * half;
            for (x, weight) in gauss_legendre(8) {
                let t = middle + x * half;
                let p = eye + t * direction;
                let (to_light, distance, irradiance) = light(p);
                let distance = distance.min(reach(banks, p, to_light, 1e5));
                let tau: f64 = banks
                    .iter()
                    .map(|bank| bank.depth(eye, direction, t) + bank.depth(p, to_light, distance))
                    .sum();
                let cos = to_light.dot(direction);
                let scattering: f64 =
                    banks.iter().map(|bank| bank.sigma_t_at(p) * bank.albedo * bank.phase(cos)).sum();
                sum += half * weight * scattering * irradiance * (-tau).exp();
            }
        }
    }
    sum
}

/// The quadrature does not know where the light's way kinks, so its pieces are short where that may be: its
/// own error is some 1e-7.
fn short_pieces() -> Vec<f64> {
    let near = (0..200).map(|index| 0.2 * f64::from(index));
    near.chain((6..14).map(|power| 2_f64.powi(power))).collect()
}

fn scene_of(banks: &[Bank], eye: DVec3) -> Scene {
    let mut scene = camera_at(eye);
    for bank in banks {
        let (sigma_t, albedo) = (Rgb::splat(bank.sigma_t), Rgb::splat(bank.albedo));
        match bank.bounds {
            None => add_layer(&mut scene, bank.base, bank.scale_height, sigma_t, albedo, bank.g),
            Some((low, high)) => {
                add_fog(&mut scene, low, high, sigma_t, albedo, bank.g);
                if bank.scale_height.is_finite() {
                    let base = 2.0 * (bank.base - low.y) / (high.y - low.y) - 1.0;
                    let scale_height_m = Track::from(bank.scale_height);
                    let fog = scene.fogs.last_mut().expect("just added");
                    fog.shape = FogShape::ThinningBox(HeightFalloff { base, scale_height_m });
                }
            }
        }
    }
    scene
}

fn follow(scene: &Scene, transport: &Transport, direction: DVec3) -> Sample {
    let snapshot = Snapshot::new(scene, &MeshTrees::new(scene), 0, 1.0, INSTANT);
    let ray = Ray { origin: DVec3::ZERO, direction };
    radiance(&snapshot, transport, &ray, &mut Sampler::new(0, 0, 0, 0), &mut Scratch::default())
}

fn under_sun(scene: &mut Scene, to_sun: DVec3) {
    add_light(scene, LightKind::Sun, DVec3::ZERO, -to_sun, Rgb::splat(20.0));
}

fn direction() -> impl Strategy<Value = DVec3> {
    prop::array::uniform3(-1.0..1.0_f64)
        .prop_map(DVec3::from)
        .prop_filter_map("too short", |v| (v.length() > 0.1).then(|| v.normalize()))
        .prop_filter("too flat", |v| v.y.abs() > FLATTEST)
}

fn sun() -> impl Strategy<Value = DVec3> {
    (-1.0..1.0_f64, 0.1..1.0_f64, -1.0..1.0_f64).prop_map(|(x, y, z)| DVec3::new(x, y, z).normalize())
}

fn layer() -> impl Strategy<Value = Bank> {
    (-2.0..2.0_f64, 0.5..10.0_f64, 0.02..0.5_f64, 0.3..1.0_f64, -0.9..0.9_f64).prop_map(
        |(base, scale_height, sigma_t, albedo, g)| Bank {
            bounds: None,
            base,
            scale_height,
            sigma_t,
            albedo,
            g,
        },
    )
}

fn even_box() -> impl Strategy<Value = Bank> {
    (prop::array::uniform3(-6.0..1.0_f64), prop::array::uniform3(2.0..8.0_f64), 0.02..0.5_f64, -0.9..0.9_f64)
        .prop_map(|(low, size, sigma_t, g)| {
            let low = DVec3::from(low);
            let bounds = Some((low, low + DVec3::from(size)));
            Bank { bounds, base: 0.0, scale_height: f64::INFINITY, sigma_t, albedo: 0.8, g }
        })
}

fn thinning_box() -> impl Strategy<Value = Bank> {
    (even_box(), 0.3..10.0_f64, -3.0..3.0_f64).prop_map(|(bank, scale_height, base)| Bank {
        scale_height,
        base,
        ..bank
    })
}

fn assert_close(found: f64, expected: f64, bar: f64) -> Result<(), TestCaseError> {
    prop_assert!((found - expected).abs() <= bar * expected.abs() + 1e-12, "{found} {expected}");
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn a_layer_under_the_sun_equals_quadrature(
        bank in layer(), height in -4.0..12.0_f64, direction in direction(), to_sun in sun(),
    ) {
        let (banks, eye) = ([bank], DVec3::new(3.0, height, -2.0));
        let mut scene = scene_of(&banks, eye);
        under_sun(&mut scene, to_sun);
        let doubling: Vec<_> = (0..14).map(|power| 2_f64.powi(power)).collect();
        let expected = dense(&banks, eye, direction, &doubling, 60, |_| (to_sun, f64::INFINITY, 20.0));
        assert_close(follow(&scene, &EXACT, direction).shafts.x, expected, 1e-8)?;
    }

    #[test]
    fn a_layer_with_boxes_in_it_equals_quadrature(
        layer in layer(), even in even_box(), thinning in thinning_box(), height in -4.0..12.0_f64,
        direction in direction(), to_sun in sun(),
    ) {
        let (banks, eye) = ([layer, even, thinning], DVec3::new(0.5, height, 0.3));
        let mut scene = scene_of(&banks, eye);
        under_sun(&mut scene, to_sun);
        let expected = dense(&banks, eye, direction, &short_pieces(), 30, |_| (to_sun, f64::INFINITY, 20.0));
        assert_close(follow(&scene, &EXACT, direction).shafts.x, expected, 1e-6)?;
    }

    #[test]
    fn a_lamp_in_a_layer_equals_quadrature(
        layer in layer(), thinning in thinning_box(), height in -4.0..12.0_f64, direction in direction(),
        lamp in prop::array::uniform3(-3.0..6.0_f64),
    ) {
        let (banks, eye, lamp) = ([layer, thinning], DVec3::new(0.5, height, 0.3), DVec3::from(lamp));
        let mut scene = scene_of(&banks, eye);
        add_light(&mut scene, LightKind::Point, lamp, DVec3::X, Rgb::splat(7.0));
        let gap = (lamp - eye).cross(direction).length();
        prop_assume!(gap > 0.5);
        let nearest = (lamp - eye).dot(direction);
        let mut around: Vec<_> = (-8..14).flat_map(|power| [-1.0, 1.0].map(|side| nearest + side * 2_f64.powi(power))).collect();
        around.extend(short_pieces());
        let expected = dense(&banks, eye, direction, &around, 30, |p| {
            let way = lamp - p;
            (way.normalize(), way.length(), 7.0 / way.length_squared())
        });
        assert_close(follow(&scene, &EXACT, direction).shafts.x, expected, 2e-6)?;
    }

    /// Whatever the numbers: finite, not negative, and never more than scattering could give.
    #[test]
    fn nothing_overflows(
        (log_depth, log_scale, g) in (-9.0..4.0_f64, -3.0..6.0_f64, -0.99..0.99_f64),
        (height, distance) in (-30.0..30.0_f64, 0.0..4.0_f64), direction in direction(), to_sun in direction(),
        steep in 0..3_u8, boxed: bool,
    ) {
        let (depth, scale_height) = (10_f64.powf(log_depth), 10_f64.powf(log_scale));
        let half = DVec3::new(30.0, 5.0, 30.0) * scale_height;
        let bank = Bank {
            bounds: boxed.then_some((-half, half)), base: 0.0, scale_height, sigma_t: depth / scale_height,
            albedo: 1.0, g,
        };
        let eye = DVec3::new(0.0, height * scale_height * 10_f64.powf(distance), 0.0);
        // All ways, nearly level, and level.
        let flatness = [1.0, 1e-9, 0.0][usize::from(steep)];
        let direction = (direction * DVec3::new(1.0, flatness, 1.0)).normalize();
        let mut scene = scene_of(&[bank], eye);
        under_sun(&mut scene, to_sun);
        let lamp = eye + 2.0 * direction + DVec3::splat(0.5);
        add_light(&mut scene, LightKind::Point, lamp, DVec3::X, Rgb::ONE);
        for (lights, most) in [(0..1, 20.0 * 200.0), (1..2, 1e4)] {
            let mut scene = scene.clone();
            scene.lights = scene.lights[lights].to_vec();
            let sample = follow(&scene, &EXACT, direction);
            prop_assert!(sample.shafts.is_finite() && sample.transmittance.is_finite(), "{sample:?}");
            prop_assert!(sample.shafts.min_element() >= 0.0 && sample.shafts.max_element() < most, "{sample:?}");
            prop_assert!((0.0..=1.0).contains(&sample.transmittance.x), "{sample:?}");
        }
    }
}

const HAZE: Bank = Bank { bounds: None, base: 1.0, scale_height: 4.0, sigma_t: 0.3, albedo: 0.7, g: 0.6 };

/// From far above straight down under an overhead sun everything that is not absorbed at the first event
/// comes back: `albedo * phase * E * integral of exp(-2 tau) dtau`, which is half.
#[test]
fn down_from_far_above() {
    for height in [10.0, 1e4, 1e7] {
        let mut scene = scene_of(&[HAZE], DVec3::new(0.0, height, 0.0));
        under_sun(&mut scene, DVec3::Y);
        let above = HAZE.sigma_t * HAZE.scale_height * (-(height - HAZE.base) / HAZE.scale_height).exp();
        let expected = 0.5 * HAZE.albedo * HAZE.phase(-1.0) * 20.0 * (-above).exp() * above.exp();
        // What lies above the eye dims the sun but is not looked through.
        let expected = expected * (-above).exp();
        let sample = follow(&scene, &EXACT, DVec3::NEG_Y);
        assert!((sample.shafts.x / expected - 1.0).abs() < 1e-9, "{height}: {} {expected}", sample.shafts.x);
        assert!(sample.transmittance.x < 1e-15);
    }
}

/// Up into the sun the depth over the ray is the same everywhere: that of the column.
#[test]
fn up_into_the_sun() {
    let to_sun = DVec3::new(0.3, 0.5, -0.2).normalize();
    let mut scene = scene_of(&[HAZE], DVec3::new(0.0, 3.0, 0.0));
    under_sun(&mut scene, to_sun);
    let column = HAZE.sigma_t * HAZE.scale_height * (-0.5_f64).exp() / to_sun.y;
    let expected = HAZE.albedo * HAZE.phase(1.0) * 20.0 * column * (-column).exp();
    let sample = follow(&scene, &EXACT, to_sun);
    assert!((sample.shafts.x / expected - 1.0).abs() < 1e-12, "{} {expected}", sample.shafts.x);
    assert!((sample.transmittance.x / (-column).exp() - 1.0).abs() < 1e-12);
    let nearly = (to_sun + DVec3::new(1e-9, -1e-9, 0.0)).normalize();
    assert!((follow(&scene, &EXACT, nearly).shafts.x / expected - 1.0).abs() < 1e-7);
}

/// A level ray never leaves the fog and sees all of it: `albedo * phase * E * exp(-column)`.
#[test]
fn level_with_the_ground() {
    let to_sun = DVec3::new(0.3, 0.5, -0.2).normalize();
    for tilt in [0.0, 1e-12, -1e-12, 1e-9, -1e-9] {
        let direction = DVec3::new(0.6, tilt, -0.8).normalize();
        let mut scene = scene_of(&[HAZE], DVec3::new(0.0, 5.0, 0.0));
        under_sun(&mut scene, to_sun);
        let column = HAZE.sigma_t * HAZE.scale_height * (-1.0_f64).exp() / to_sun.y;
        let expected = HAZE.albedo * HAZE.phase(direction.dot(to_sun)) * 20.0 * (-column).exp();
        let found = follow(&scene, &EXACT, direction).shafts.x;
        assert!((found / expected - 1.0).abs() < 1e-7, "{tilt}: {found} {expected}");
    }
}

#[test]
fn a_sun_below_the_horizon_lights_no_fog() {
    for to_sun in [DVec3::new(0.8, -0.1, 0.3).normalize(), DVec3::X] {
        let mut scene = scene_of(&[HAZE], DVec3::new(0.0, 5.0, 0.0));
        under_sun(&mut scene, to_sun);
        assert_eq!(follow(&scene, &EXACT, DVec3::new(0.6, 0.1, 0.79).normalize()).shafts, Rgb::ZERO);
    }
}

/// Three ways to the same fog: thinner without end of scale, cut in two overlapping halves, and even.
#[test]
fn a_box_whose_fog_hardly_thins_is_an_even_box() {
    let bounds = Some((DVec3::new(-5.0, -1.0, -9.0), DVec3::new(4.0, 6.0, 3.0)));
    let even = Bank { bounds, base: 0.0, scale_height: f64::INFINITY, sigma_t: 0.3, albedo: 0.7, g: 0.4 };
    let thinning = Bank { scale_height: 1e13, ..even };
    for direction in [DVec3::NEG_Z, DVec3::new(0.3, -0.4, -0.7).normalize()] {
        let [a, b] = [even, thinning].map(|bank| {
            let mut scene = scene_of(&[bank], DVec3::new(0.0, 2.0, 5.0));
            under_sun(&mut scene, DVec3::new(0.35, 0.75, -0.56).normalize());
            follow(&scene, &EXACT, direction)
        });
        assert!((a.shafts.x / b.shafts.x - 1.0).abs() < 1e-10, "{} {}", a.shafts.x, b.shafts.x);
        assert!((a.transmittance.x / b.transmittance.x - 1.0).abs() < 1e-10);
    }
}

#[test]
fn overlapping_layers_add_up() {
    let direction = DVec3::new(0.3, 0.2, -0.7).normalize();
    let halves = [0.1, 0.2].map(|sigma_t| Bank { sigma_t, ..HAZE });
    let [whole, halves] = [&[HAZE][..], &halves].map(|banks| {
        let mut scene = scene_of(banks, DVec3::new(0.0, 2.0, 5.0));
        under_sun(&mut scene, DVec3::new(0.35, 0.75, -0.56).normalize());
        follow(&scene, &EXACT, direction)
    });
    // One in closed form, the other by a fit.
    assert!((whole.shafts.x / halves.shafts.x - 1.0).abs() < 1e-10, "{} {}", whole.shafts.x, halves.shafts.x);
    assert!((whole.transmittance.x / halves.transmittance.x - 1.0).abs() < 1e-12);
}

#[test]
fn each_channel_has_its_own_layer() {
    let direction = DVec3::new(0.3, -0.02, -0.7).normalize();
    let sigma_t = Rgb::new(0.01, 0.3, 0.0);
    let sample_of = |sigma_t: Rgb| {
        let mut scene = camera_at(DVec3::new(0.0, 3.0, 0.0));
        add_layer(&mut scene, 0.0, 5.0, sigma_t, Rgb::new(0.9, 0.5, 0.3), 0.2);
        under_sun(&mut scene, DVec3::new(0.2, 1.0, 0.1).normalize());
        follow(&scene, &EXACT, direction)
    };
    let together = sample_of(sigma_t);
    for channel in 0..2 {
        let alone = sample_of(Rgb::splat(sigma_t[channel]));
        assert!((together.shafts[channel] / alone.shafts[channel] - 1.0).abs() < 1e-12);
    }
    assert_eq!((together.shafts.z, together.transmittance.z), (0.0, 1.0));
}

/// Fog follows its node: turned on its side it thins out sideways.
#[test]
fn a_layer_turns_with_its_node() {
    let layer = |node: usize| Fog {
        name: "layer".into(),
        node,
        shape: FogShape::Layer(HeightFalloff { base: 1.0, scale_height_m: Track::from(4.0) }),
        density_per_m: Track::from(Rgb::splat(0.3)),
        albedo: Track::from(Rgb::splat(0.7)),
        anisotropy: Track::from(0.6),
    };
    let turn = glam::DQuat::from_rotation_z(-1.1);
    let (direction, to_sun) = (DVec3::new(0.1, 0.2, -0.7).normalize(), DVec3::new(0.2, 0.9, 0.3).normalize());
    let [upright, turned] = [glam::DQuat::IDENTITY, turn].map(|turn| {
        let mut scene = camera_at(turn * DVec3::new(0.0, 3.0, 0.0));
        let node = place(&mut scene, DAffine3::from_quat(turn));
        scene.fogs.push(layer(node));
        under_sun(&mut scene, turn * to_sun);
        follow(&scene, &EXACT, turn * direction).shafts.x
    });
    assert!((upright / turned - 1.0).abs() < 1e-12, "{upright} {turned}");
}

#[test]
fn baselines_agree() {
    let thinning = Bank { bounds: Some((DVec3::splat(-4.0), DVec3::splat(5.0))), ..HAZE };
    for banks in [&[HAZE][..], &[HAZE, thinning]] {
        let mut scene = scene_of(banks, DVec3::new(0.0, 2.0, 0.0));
        under_sun(&mut scene, DVec3::new(0.35, 0.75, -0.56).normalize());
        let direction = DVec3::new(0.3, 0.5, -0.7).normalize();
        let by = |volume: VolumeMethod| {
            let exact = follow(&scene, &EXACT, direction).shafts.x;
            follow(&scene, &Transport { volume, ..EXACT }, direction).shafts.x / exact - 1.0
        };
        assert!(by(VolumeMethod::March(MarchSteps::Count(100_000))).abs() < 1e-4);
        assert!(by(VolumeMethod::Equiangular { points: 100_000 }).abs() < 1e-3);
    }
}
