//! What a near light's lit parts cost, few and many, and how exact they are. The scene is one box of
//! fog with a lamp in it. Rays go in all directions of a picture, and every second of equal parts
//! lies in shadow. One thread.

use glam::{DAffine3, DVec3};
use std::hint::black_box;
use std::time::Instant;
use sunfleck::color::Rgb;
use sunfleck::fog::{FogBank, LitSegments, Medium, exp_minus, henyey_greenstein};
use sunfleck::math::{IntervalSet, Ray, Sampler, gauss_legendre};
use sunfleck::snapshot::{Emission, FrozenLight, LampShape};

const RAYS: u32 = 200;

/// Prints a row for each anisotropy and number of parts; the shortest of `rounds` alternated runs counts.
pub fn run(rounds: usize) {
    println!("{:>5} {:>6} {:>10} {:>10} {:>12}", "g", "parts", "ns a ray", "ns a part", "largest err");
    for g in [0.0, 0.5, 0.99] {
        let medium = fog(g);
        let cases = [1, 2, 4, 8, 12, 15, 16, 24, 32, 64, 128].map(|parts| (parts, rays(&medium, parts)));
        let mut shortest = [f64::INFINITY; 11];
        for _ in 0..rounds {
            for ((_, rays), shortest) in cases.iter().zip(&mut shortest) {
                let started = Instant::now();
                for ray in rays {
                    black_box(ray.found(&medium));
                }
                *shortest = shortest.min(started.elapsed().as_secs_f64() * 1e9 / f64::from(RAYS));
            }
        }
        for ((parts, rays), ns) in cases.iter().zip(shortest) {
            let error = |ray: &LitRay| (ray.found(&medium) / ray.dense(&medium, g) - 1.0).abs();
            let largest = rays.iter().map(error).fold(0.0, f64::max);
            println!("{g:>5} {parts:>6} {ns:>10.0} {:>10.0} {largest:>12.1e}", ns / f64::from(*parts));
        }
    }
}

const LAMP: FrozenLight = FrozenLight::Point {
    position: DVec3::new(1.5, 2.0, -5.0),
    intensity: Rgb::ONE,
    emission: Emission::Even,
    shape: LampShape::NONE,
};

fn fog(g: f64) -> Medium {
    let relative_from_cube = DAffine3::from_translation(DVec3::new(0.0, 0.0, -4.0))
        * DAffine3::from_scale(DVec3::new(9.0, 4.0, 9.0));
    Medium::new(FogBank::in_box(relative_from_cube, Rgb::splat(0.15), Rgb::ONE, g).into_iter().collect())
}

/// A ray and what is lit of it.
struct LitRay {
    ray: Ray,
    shadows: IntervalSet,
    range: (f64, f64),
}

fn rays(medium: &Medium, parts: u32) -> Vec<LitRay> {
    let ray = |index: u32| {
        let (x, y) = Sampler::new(4, 0, 0, index).next_2d();
        let ray = Ray {
            origin: DVec3::ZERO,
            direction: DVec3::new(1.6 * x - 0.8, 0.9 * y - 0.45, -1.0).normalize(),
        };
        let range = medium.range(&ray, f64::INFINITY)?;
        let mut shadows = IntervalSet::default();
        let tooth = (range.1 - range.0) / f64::from(2 * parts - 1);
        for index in 0..parts - 1 {
            let from = range.0 + f64::from(2 * index + 1) * tooth;
            shadows.insert(from, from + tooth);
        }
        Some(LitRay { ray, shadows, range })
    };
    (0..RAYS).filter_map(ray).collect()
}

impl LitRay {
    fn found(&self, medium: &Medium) -> f64 {
        let lit = LitSegments::from_shadows(self.shadows.clone(), self.range);
        medium.passage(&self.ray, f64::INFINITY, &lit, &LAMP).scattered.x
    }

    /// 16 nodes on each of 100 pieces of each lit part.
    fn dense(&self, medium: &Medium, g: f64) -> f64 {
        let sigma_s = medium.banks()[0].sigma_s;
        let mut sum = Rgb::ZERO;
        self.shadows.for_each_gap(self.range.0, self.range.1, |from, to| {
            let half = 0.5 * (to - from) / 100.0;
            for piece in 0..100 {
                for (node, weight) in gauss_legendre(16) {
                    let t = from + (f64::from(2 * piece + 1) + node) * half;
                    let point = self.ray.at(t);
                    let (to_light, distance, arriving) = LAMP.arriving_at(point);
                    let tau = medium.optical_depth(point, to_light, distance)
                        + medium.optical_depth(self.ray.origin, self.ray.direction, t);
                    let phase = henyey_greenstein(to_light.dot(self.ray.direction), g);
                    sum += half * *weight * phase * sigma_s * arriving * exp_minus(tau);
                }
            }
        });
        sum.x
    }
}
