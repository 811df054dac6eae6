//! A hundred thousand slats: as many lit intervals on one ray, whose light is a series.

use crate::common::{EXACT, INSTANT, look};
use crate::numerics::scenes::{Frame, Lamp, add_instance, add_mesh, empty, fog, light};
use glam::{DAffine3, DVec2, DVec3, Vec3};
use std::f64::consts::PI;
use sunfleck::color::Rgb;
use sunfleck::math::{Ray, Sampler, gauss_legendre};
use sunfleck::scene::{Scene, Size};
use sunfleck::snapshot::{MeshTrees, Snapshot};
use sunfleck::transport::slices::{Fan, Piece, Ring, SliceJob, SliceScratch};
use sunfleck::transport::{Scratch, radiance};

const SLATS: u32 = 100_000;
/// A power of two, so that every slat lies where it should.
const PITCH_M: f64 = 1.0 / 1024.0;
const LENGTH_M: f64 = PITCH_M * SLATS as f64;
const HEIGHT_M: f64 = 1.0;
const SIGMA_T: f64 = 0.02;
const ALBEDO: f64 = 0.8;
const G: f64 = 0.3;
/// Of the fog above the ray.
const TOP_M: f64 = 2.0;

/// Level slats a metre above the ray along -Z; every second half pitch is open.
fn fence(lamp: Lamp) -> Scene {
    let mut scene = empty(&Frame::HERE);
    let (half, side) = (0.5 * PITCH_M as f32, 1.0 / 64.0);
    let corners = [[-side, 0.0], [side, 0.0], [side, -half], [-side, -half]];
    let corners = corners.map(|[x, z]| Vec3::new(x, 0.0, z));
    let slat = add_mesh(&mut scene, corners.into(), &[[0, 1, 2], [0, 2, 3]]);
    for number in 0..SLATS {
        let at = DVec3::new(0.0, HEIGHT_M, -PITCH_M * f64::from(number));
        add_instance(&mut scene, slat, &Frame::HERE, DAffine3::from_translation(at));
    }
    let (low, high) = (DVec3::new(-2.0, -1.0, -LENGTH_M), DVec3::new(2.0, TOP_M, 1.0));
    fog(&mut scene, &Frame::HERE, low, high, SIGMA_T, G);
    light(&mut scene, &Frame::HERE, lamp);
    scene
}

fn phase(cos: f64) -> f64 {
    (1.0 - G * G) / (4.0 * PI * (1.0 + G * G - 2.0 * G * cos).powf(1.5))
}

#[test]
fn under_a_sun() {
    let scene = fence(Lamp::Sun { to_sun: DVec3::Y });
    // Every gap passes its half pitch, weakened by the way to it; two metres of fog above all of them.
    let open = ((-0.5 * SIGMA_T * PITCH_M).exp() - (-SIGMA_T * PITCH_M).exp()) / SIGMA_T;
    let series = -(-SIGMA_T * LENGTH_M).exp_m1() / -(-SIGMA_T * PITCH_M).exp_m1();
    let expected = ALBEDO * SIGMA_T * phase(0.0) * 5.0 * (-TOP_M * SIGMA_T).exp() * open * series;
    let found = look(&scene, &EXACT, 0.5, 0.5).shafts.x;
    println!("{SLATS} slats under a sun: {:.1e}", (found / expected - 1.0).abs());
    assert!((found / expected - 1.0).abs() < 1e-9, "{found} {expected}");
}

/// A gap's light, gap by gap: so short that two nodes are exact to 1e-12.
#[test]
fn under_a_lamp() {
    let lamp = DVec3::new(0.0, 8.0, -0.5 * LENGTH_M);
    let scene = fence(Lamp::Point { position: lamp });
    let foot = -lamp.z;
    // Seen from the lamp the slats' shadows are spread out about its foot.
    let shadow_of = |t: f64| foot + (t - foot) * lamp.y / (lamp.y - HEIGHT_M);
    let scattered = |t: f64| {
        let way = lamp + DVec3::Z * t;
        let distance = way.length();
        let in_fog = distance * TOP_M / lamp.y;
        let cos = -way.z / distance;
        ALBEDO * SIGMA_T * phase(cos) * 5.0 * (-SIGMA_T * (t + in_fog)).exp() / (distance * distance)
    };
    let (mut expected, mut gaps) = (0.0, 0);
    for number in 0..SLATS {
        let at = PITCH_M * f64::from(number);
        let (start, end) = (shadow_of(at + 0.5 * PITCH_M).max(0.0), shadow_of(at + PITCH_M).min(LENGTH_M));
        if start < end {
            let half = 0.5 * (end - start);
            let nodes = gauss_legendre(2).iter();
            expected +=
                nodes.map(|(x, weight)| half * weight * scattered(start + half * (1.0 + x))).sum::<f64>();
            gaps += 1;
        }
    }
    let found = look(&scene, &EXACT, 0.5, 0.5).shafts.x;
    println!("{gaps} gaps under a lamp: {:.1e}", (found / expected - 1.0).abs());
    assert!(gaps > 80_000 && (found / expected - 1.0).abs() < 1e-6, "{gaps}: {found} {expected}");
}

/// The slice that holds the whole fence, against rays of their own.
#[test]
fn in_a_slice() {
    for lamp in
        [Lamp::Sun { to_sun: DVec3::Y }, Lamp::Point { position: DVec3::new(0.0, 8.0, -0.5 * LENGTH_M) }]
    {
        let scene = fence(lamp);
        let snapshot = Snapshot::new(&scene, &MeshTrees::new(&scene), 0, 1.0, INSTANT);
        let size = Size { width: 64, height: 64 };
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
        // In the middle of the picture, or nearly: the plane of the fence.
        let angle = (0..=1000).map(|index| fan.angles.0 + fan.angles.1 * f64::from(index) / 1000.0);
        let aside = |slice: &sunfleck::transport::slices::Slice| slice.place(0.5).direction.x.abs();
        let slice = angle
            .filter_map(|angle| fan.slice(angle, Ring::WHOLE))
            .min_by(|a, b| aside(a).total_cmp(&aside(b)))
            .expect("slices in the picture");
        // Off round numbers: no ray ends exactly in the edge of a slat.
        let areas = (0..7).map(|index| slice.area_per_rad * (f64::from(index) + 0.37) / 7.0);
        let (mut squares, mut sum, mut rays) = (0.0, 0.0, 0);
        let mut scratch = Scratch::default();
        let chords = areas.map(|area| slice.ray(area));
        job.solve(&slice, chords, None, &mut SliceScratch::default(), |Piece { place, .. }, value| {
            let ray = Ray { origin: DVec3::ZERO, direction: place.direction };
            let mut sampler = Sampler::new(0, 0, 0, 0);
            let own = radiance(&snapshot, &EXACT, &ray, &mut sampler, &mut scratch);
            squares += (own.shafts - value.shafts).length_squared();
            sum += own.shafts.length();
            rays += 1;
        });
        let error = (squares / f64::from(rays)).sqrt() / (sum / f64::from(rays));
        println!("{SLATS} slats in a slice, {lamp:?}: {error:.1e} of {rays} rays");
        assert!(rays == 7 && error < 1e-6, "{lamp:?}: {error:.1e} of {rays} rays");
    }
}
