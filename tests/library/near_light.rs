//! What a near light scatters into a ray, part by part and all parts together. It is held against a dense
//! quadrature along the ray.

use glam::{DAffine3, DVec3};
use proptest::prelude::*;
use sunfleck::color::Rgb;
use sunfleck::fog::{FogBank, LitSegments, Medium, exp_minus, henyey_greenstein};
use sunfleck::math::{IntervalSet, Ray, gauss_legendre};
use sunfleck::snapshot::{Cone, Emission, FrozenLight, LampShape};

/// The project's bar for near lights, relative to the whole ray.
const BAR: f64 = 2e-6;

struct Case {
    medium: Medium,
    ray: Ray,
    light: FrozenLight,
    sigma: f64,
    g: f64,
}

fn case(sigma: f64, g: f64, light: DVec3, direction: DVec3, emission: Emission) -> Case {
    let relative_from_cube = DAffine3::from_translation(DVec3::new(0.0, 1.0, -5.0))
        * DAffine3::from_scale(DVec3::new(6.0, 2.0, 6.0));
    let fog = FogBank::in_box(relative_from_cube, Rgb::splat(sigma), Rgb::ONE, g).expect("real fog");
    Case {
        medium: Medium::new(vec![fog]),
        ray: Ray { origin: DVec3::ZERO, direction: direction.normalize() },
        light: FrozenLight::Point { position: light, intensity: Rgb::ONE, emission, shape: LampShape::NONE },
        sigma,
        g,
    }
}

impl Case {
    fn range(&self) -> (f64, f64) {
        self.medium.range(&self.ray, f64::INFINITY).expect("the ray meets the fog")
    }

    /// What the renderer finds with these shadows.
    fn found(&self, shadows: &IntervalSet) -> f64 {
        let lit = LitSegments::from_shadows(shadows.clone(), self.range());
        self.medium.passage(&self.ray, f64::INFINITY, &lit, &self.light).scattered.x
    }

    /// 16 nodes on each of so many pieces of each lit part, in the distance along the ray.
    fn dense(&self, shadows: &IntervalSet, pieces: u32) -> f64 {
        let (start, end) = self.range();
        let mut sum = 0.0;
        shadows.for_each_gap(start, end, |from, to| {
            let half = 0.5 * (to - from) / f64::from(pieces);
            for piece in 0..pieces {
                let middle = from + f64::from(2 * piece + 1) * half;
                for (node, weight) in gauss_legendre(16) {
                    let t = middle + node * half;
                    let (to_light, distance, arriving) = self.light.arriving_at(self.ray.at(t));
                    let tau = self.medium.optical_depth(self.ray.at(t), to_light, distance)
                        + self.medium.optical_depth(self.ray.origin, self.ray.direction, t);
                    let phase = henyey_greenstein(to_light.dot(self.ray.direction), self.g);
                    sum += half * weight * self.sigma * phase * (arriving * exp_minus(tau)).x;
                }
            }
        });
        sum
    }
}

/// A shadow over every second of `count` equal parts, and one.
fn comb((start, end): (f64, f64), count: u32) -> IntervalSet {
    let mut shadows = IntervalSet::default();
    let tooth = (end - start) / f64::from(2 * count - 1);
    for index in 0..count.saturating_sub(1) {
        let from = start + f64::from(2 * index + 1) * tooth;
        shadows.insert(from, from + tooth);
    }
    shadows
}

#[test]
fn every_anisotropy_every_place_of_the_light_and_any_number_of_parts() {
    // In the fog, above it, hardly above it, beside it, behind the eye.
    let lights = [(0.5, 1.5, -4.0), (1.0, 6.0, -3.0), (0.3, 3.001, -4.0), (8.0, 1.0, -5.0), (0.4, 0.7, 2.0)];
    for light in lights.map(DVec3::from) {
        for g in [0.0, 0.5, -0.5, 0.9, 0.99, -0.99, 0.999] {
            for sigma in [0.01, 0.3, 3.0] {
                for direction in [DVec3::new(0.1, 0.2, -1.0), DVec3::new(-0.2, 0.5, -1.0)] {
                    let case = case(sigma, g, light, direction, Emission::Even);
                    for parts in [1, 3, 40] {
                        let shadows = comb(case.range(), parts);
                        // Narrow lobes want short pieces.
                        let pieces = if g.abs() < 0.95 { 800 } else { 4000 };
                        let expected = case.dense(&shadows, pieces / parts);
                        let error = (case.found(&shadows) / expected - 1.0).abs();
                        assert!(
                            error < BAR,
                            "{light} g {g} sigma {sigma} {direction} {parts} parts: {error:.1e}"
                        );
                    }
                }
            }
        }
    }
}

#[test]
fn spots_and_flat_lights_too() {
    let axis = DVec3::new(0.2, -1.0, -0.1).normalize();
    let cone = Cone { axis, cos_outer: 0.6, cos_inner: 0.8 };
    for emission in [Emission::Spot(cone), Emission::Flat { normal: axis }] {
        let case = case(0.3, 0.8, DVec3::new(0.3, 2.5, -4.0), DVec3::new(0.05, 0.05, -1.0), emission);
        for parts in [1, 5, 60] {
            let mut shadows = comb(case.range(), parts);
            // As `find` does it: what lies outside is shadow.
            let FrozenLight::Point { position, .. } = case.light else { panic!("a near light") };
            let mut start = case.range().0;
            for end in emission.borders(&case.ray, position).into_iter().flatten().chain([case.range().1]) {
                if !emission.reaches(case.ray.at(0.5 * (start + end)) - position) {
                    shadows.insert(start, end);
                }
                start = end;
            }
            let error = (case.found(&shadows) / case.dense(&shadows, 4000) - 1.0).abs();
            assert!(error < BAR, "{emission:?} {parts} parts: {error:.1e}");
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    /// All parts together are the sum of each alone, whichever way each is found.
    #[test]
    fn together_as_one_by_one(
        x in -8.0..8.0_f64, y in -3.0..9.0_f64, z in -14.0..3.0_f64, g in -0.99..0.99_f64, log_sigma in -3.0..1.0_f64,
        dx in -0.5..0.5_f64, dy in 0.01..0.5_f64, parts in 17_u32..100
    ) {
        let case = case(10_f64.powf(log_sigma), g, DVec3::new(x, y, z), DVec3::new(dx, dy, -1.0), Emission::Even);
        let range = case.range();
        let all = comb(range, parts);
        let mut sum = 0.0;
        all.for_each_gap(range.0, range.1, |from, to| {
            let mut others = IntervalSet::default();
            others.insert(range.0, from);
            others.insert(to, range.1);
            sum += case.found(&others);
        });
        let whole = case.found(&IntervalSet::default());
        let together = case.found(&all);
        // Each way is allowed the bar.
        prop_assert!((together - sum).abs() < 2.0 * BAR * sum.max(1e-3 * whole), "{together} {sum} of {whole}");
    }
}
