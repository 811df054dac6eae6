//! Suns from a point to a quarter of the sky. Each point of the disc is held against the slow truth, and all
//! of it against quadrature over the disc.

use crate::common::{EXACT, INSTANT, add_light};
use crate::numerics::compare::{SlicePlan, by_slices_through};
use crate::numerics::pictures::{mean, picture};
use crate::numerics::scenes::{Frame, HIGH_SUN, Lamp, empty, fog, grove, light};
use glam::DVec3;
use sunfleck::math::Sampler;
use sunfleck::render::Method;
use sunfleck::scene::{LightKind, Scene, Size, SunDisc, Track};
use sunfleck::snapshot::{FrozenLight, MeshTrees, Snapshot};
use sunfleck::transport::{Scratch, radiance};

const DIAMETERS_DEG: [f64; 5] = [1e-6, 1e-3, 0.53, 10.0, 90.0];

fn with_diameter(mut scene: Scene, diameter_deg: f64) -> Scene {
    let disc = SunDisc::even(Track::from(diameter_deg.to_radians()));
    scene.lights[0].kind = LightKind::SunDisc(disc);
    scene
}

/// The middle, the rim, and places between.
const POINTS: [[f64; 3]; 5] =
    [[0.5, 0.5, 0.0], [0.0, 0.0, 0.0], [1.0 - 1e-12, 0.5, 0.9], [0.5, 1e-9, 0.5], [0.2, 0.7, 0.3]];

#[test]
fn points_of_the_disc() {
    let into_the_sun = Lamp::Sun { to_sun: DVec3::new(0.1, 0.2, -1.0) };
    for lamp in [HIGH_SUN, into_the_sun] {
        for diameter_deg in DIAMETERS_DEG {
            let scene = with_diameter(grove(&Frame::HERE, lamp), diameter_deg);
            for u in POINTS {
                let plan = SlicePlan::even(Size { width: 64, height: 64 }, 7, 11);
                by_slices_through(&scene, &plan, |sun| sun.point(u))
                    .hold(&format!("disc of {diameter_deg} degrees at {u:?}, {lamp:?}"), 1e-6);
            }
        }
    }
}

/// Fog alone, where light changes smoothly over the disc.
#[test]
fn the_whole_disc() {
    const PLACES: u32 = 32 * 18;
    let size = Size { width: 16, height: 9 };
    for to_sun in [DVec3::new(0.35, 0.9, -0.4), DVec3::new(0.1, 0.2, -1.0)] {
        let mut open = empty(&Frame::HERE);
        fog(&mut open, &Frame::HERE, DVec3::new(-6.0, -1.5, -10.0), DVec3::new(6.0, 4.0, 1.0), 0.15, 0.6);
        light(&mut open, &Frame::HERE, Lamp::Sun { to_sun });
        for diameter_deg in DIAMETERS_DEG {
            let scene = with_diameter(open.clone(), diameter_deg);
            // Cells of the disc are at most four degrees wide.
            let grid: u32 = if diameter_deg > 10.0 { 24 } else { 4 };
            let middle = |index: u32| (f64::from(index) + 0.5) / f64::from(grid);
            let mut expected = 0.0;
            let trees = MeshTrees::new(&scene);
            let of_disc = Snapshot::new(&scene, &trees, 0, 16.0 / 9.0, INSTANT);
            for index in 0..grid * grid {
                // A delta sun at a point of the disc.
                let point = of_disc.lights[0].point([middle(index % grid), middle(index / grid), 0.5]);
                let FrozenLight::Sun { to_light, irradiance } = point else { panic!("a sun is a sun") };
                let mut lit = open.clone();
                lit.lights.clear();
                lit.nodes.pop();
                add_light(&mut lit, LightKind::Sun, DVec3::ZERO, -to_light, irradiance);
                let snapshot = Snapshot::new(&lit, &MeshTrees::new(&lit), 0, 16.0 / 9.0, INSTANT);
                for place in 0..PLACES {
                    let (x, y) = (f64::from(place % 32) + 0.5, f64::from(place / 32) + 0.5);
                    let ray = snapshot.view.ray(x / 32.0, y / 18.0);
                    let mut sampler = Sampler::new(0, 0, 0, 0);
                    expected +=
                        radiance(&snapshot, &EXACT, &ray, &mut sampler, &mut Scratch::default()).shafts.x;
                }
            }
            expected /= f64::from(PLACES * grid * grid);
            for method in [Method::Slices, Method::Segments] {
                // Of 256 samples so few pixels under a quarter of the sky still differ by
                // 3e-3 from seed to seed.
                let samples = if diameter_deg > 10.0 { 1024 } else { 256 };
                let found = mean(&picture(&scene, size, samples, method).0);
                let error = (found / expected - 1.0).abs();
                println!("whole disc of {diameter_deg} degrees, {to_sun}, {method:?}: {error:.1e}");
                assert!(error < 5e-3, "{diameter_deg} degrees, {to_sun}, {method:?}: {found} {expected}");
            }
        }
    }
}
