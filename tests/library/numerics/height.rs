//! Fog that thins out within a millimetre or a thousand kilometres, against closed forms of their own. It is
//! seen from below its base and from a hundred kilometres above, along level rays and others.

use crate::common::{EXACT, INSTANT, add_layer, add_light, camera_at};
use glam::{DVec2, DVec3};
use std::f64::consts::PI;
use sunfleck::color::Rgb;
use sunfleck::math::{Ray, Sampler};
use sunfleck::scene::{LightKind, Scene, Size};
use sunfleck::snapshot::{MeshTrees, Snapshot};
use sunfleck::transport::slices::{Fan, Piece, Ring, SliceJob, SliceScratch};
use sunfleck::transport::{Sample, Scratch, radiance};

const ALBEDO: f64 = 0.8;
const G: f64 = 0.4;
const IRRADIANCE: f64 = 20.0;

/// Above the plane y = 0.
#[derive(Clone, Copy, Debug)]
struct Layer {
    scale_height_m: f64,
    /// At the base, 1/m.
    sigma_t: f64,
}

/// `(1 - exp(-x)) / x`.
fn mean_of_exp(x: f64) -> f64 {
    if x == 0.0 { 1.0 } else { -(-x).exp_m1() / x }
}

impl Layer {
    /// What a ray from height `y` scatters of a sun of height `sun_y`, and what it lets through. With
    /// `q = exp(-height / scale height)` for the variable, depths are linear in it:
    /// `dq = -+ density dt |dy| / H`.
    fn look(&self, y: f64, direction: DVec3, to_sun: DVec3) -> (f64, f64) {
        let cos = direction.dot(to_sun);
        let phase = (1.0 - G * G) / (4.0 * PI * (1.0 + G * G - 2.0 * G * cos).powf(1.5));
        let (steep, sun_y) = (direction.y.abs(), to_sun.y);
        let column = self.sigma_t * self.scale_height_m;
        // Depth of the whole layer along the ray and towards the sun.
        let (a, b) = (column / steep, column / sun_y);
        let q = (-y.max(0.0) / self.scale_height_m).exp();
        // 1 - q
        let p = -(-y.max(0.0) / self.scale_height_m).exp_m1();
        let (share, through) = if direction.y == 0.0 {
            // The same density for ever.
            let above = if y < 0.0 { -y * self.sigma_t / sun_y } else { 0.0 };
            if q == 0.0 { (0.0, 1.0) } else { ((-b * q - above).exp(), 0.0) }
        } else if direction.y > 0.0 {
            // Below the base first.
            let below = (-y).max(0.0) * self.sigma_t / steep;
            let excess = below * (1.0 - steep / sun_y);
            let first =
                below * (-b - below * (steep / sun_y) - excess.min(0.0)).exp() * mean_of_exp(excess.abs());
            // a (q - q') + b q', from q' = q to 0.
            let above = a * q * (-below - a.min(b) * q).exp() * mean_of_exp((a - b).abs() * q);
            (first + above, (-below - a * q).exp())
        } else if y < 0.0 {
            ((-b + y * self.sigma_t / sun_y).exp() / (1.0 + steep / sun_y), 0.0)
        } else {
            // a (q' - q) + b q', from q' = q to 1, and on below the base.
            let above = a * p * (-b * q).exp() * mean_of_exp((a + b) * p);
            (above + (-a * p - b).exp() / (1.0 + steep / sun_y), 0.0)
        };
        (ALBEDO * phase * IRRADIANCE * share, through)
    }

    /// Whether a ray leaves the fog, or leaves nothing to see, within a hundred thousand million kilometres.
    fn ends_in_sight(&self, y: f64, direction: DVec3) -> bool {
        let out_m = 60.0 * y.max(self.scale_height_m) / direction.y.abs();
        let dark_m = 40.0 / (self.sigma_t * (-y.max(0.0) / self.scale_height_m).exp());
        out_m.min(dark_m) < 1e14
    }

    fn scene(&self, y: f64, to_sun: DVec3) -> Scene {
        let mut scene = camera_at(DVec3::new(0.0, y, 0.0));
        let (sigma_t, albedo) = (Rgb::splat(self.sigma_t), Rgb::splat(ALBEDO));
        add_layer(&mut scene, 0.0, self.scale_height_m, sigma_t, albedo, G);
        add_light(&mut scene, LightKind::Sun, DVec3::ZERO, -to_sun, Rgb::splat(IRRADIANCE));
        scene
    }
}

/// Camera heights, metres, and layers, of optical depths from next to nothing to far too much.
fn each_place(mut check: impl FnMut(f64, Layer)) {
    for scale_height_m in [1e-3, 1.0, 8e3, 1e6] {
        for column in [1e-6, 1.0, 1e3] {
            for y in [-3.0, 0.0, 1e-3, 2.0, 1e5] {
                check(y, Layer { scale_height_m, sigma_t: column / scale_height_m });
            }
        }
    }
}

/// The largest error, relative to the light, but where hardly any is left: rays end behind 40 optical depths.
fn error(found: &Sample, (shafts, through): (f64, f64)) -> f64 {
    let shafts = (found.shafts.x - shafts).abs() / shafts.max(1e-9 * IRRADIANCE);
    shafts.max((found.transmittance.x - through).abs())
}

#[test]
fn per_ray() {
    let mut worst = (0.0, String::new());
    for to_sun in [DVec3::new(0.3, 0.5, -0.2), DVec3::Y, DVec3::new(0.6, 1e-3, -0.8)].map(DVec3::normalize) {
        each_place(|y, layer| {
            let scene = layer.scene(y, to_sun);
            let snapshot = Snapshot::new(&scene, &MeshTrees::new(&scene), 0, 1.0, INSTANT);
            for slope in [0.0, 1e-12, -1e-12, 1e-6, -1e-6, 0.1, -0.1, 1.0, -1.0, 1e6, -1e6] {
                let direction = DVec3::new(0.6, slope, -0.8).normalize();
                if !layer.ends_in_sight(y, direction) {
                    continue;
                }
                let ray = Ray { origin: DVec3::ZERO, direction };
                let mut sampler = Sampler::new(0, 0, 0, 0);
                let found = radiance(&snapshot, &EXACT, &ray, &mut sampler, &mut Scratch::default());
                let error = error(&found, layer.look(y, direction, to_sun));
                if error > worst.0 || error.is_nan() {
                    worst = (error, format!("{layer:?} from {y} m, {direction}, {to_sun}: {found:?}"));
                }
            }
        });
    }
    println!("height fog, per ray: {:.1e}", worst.0);
    assert!(worst.0 <= 1e-8, "{worst:?}");
}

#[test]
fn slices() {
    let size = Size { width: 64, height: 64 };
    let mut worst = (0.0, String::new());
    for to_sun in [DVec3::new(0.3, 0.5, -0.2), DVec3::new(0.6, 1e-3, -0.8)].map(DVec3::normalize) {
        each_place(|y, layer| {
            let scene = layer.scene(y, to_sun);
            let snapshot = Snapshot::new(&scene, &MeshTrees::new(&scene), 0, 1.0, INSTANT);
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
            let mut scratch = SliceScratch::default();
            for number in 0..9 {
                let angle = fan.angles.0 + fan.angles.1 * (f64::from(number) + 0.5) / 9.0;
                let Some(slice) = fan.slice(angle, Ring::WHOLE) else { continue };
                let areas = (0..9).map(|index| slice.area_per_rad * (f64::from(index) + 0.5) / 9.0);
                let chords = areas.map(|area| slice.ray(area));
                job.solve(&slice, chords, None, &mut scratch, |Piece { place, .. }, value| {
                    let direction = place.direction;
                    let error = error(value, layer.look(y, direction, to_sun));
                    if error > worst.0 || error.is_nan() {
                        worst = (error, format!("{layer:?} from {y} m, {direction}, {to_sun}: {:?}", value));
                    }
                });
            }
        });
    }
    println!("height fog, slices: {:.1e}", worst.0);
    assert!(worst.0 <= 1e-8, "{worst:?}");
}
