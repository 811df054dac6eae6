//! Layers over a surface: the sheen of cloth, and a clear coat over all. In goes the BSDF without them, out
//! comes the BSDF with them. Invariant: layers keep reciprocity and conservation of energy if the surface has
//! them, except that a Principled BSDF's clear coat is not reciprocal.
//!
//! A layer with the albedo `E` reduces the light below it by the larger of `E(v)` and `E(l)`, as
//! KHR_materials_sheen defines for sheen ("Albedo scaling"). KHR_materials_clearcoat reduces it by `F(v)`,
//! which is not reciprocal. So does Blender's Principled BSDF.

use super::{Gloss, Sheen};
use crate::color::Rgb;
use glam::DVec3;

/// Layers of a surface point, from below.
#[derive(Clone, Copy, Debug)]
pub struct Layers {
    /// Sheen of cloth.
    pub sheen: Option<Sheen>,
    /// Clear coat over all.
    pub clearcoat: Option<Clearcoat>,
}

/// A clear coat.
#[derive(Clone, Copy, Debug)]
pub struct Clearcoat {
    /// Normal of the coat, on the side of the eye.
    pub normal: DVec3,
    /// Reflection of the coat.
    pub gloss: Gloss,
}

impl Clearcoat {
    /// A coat with the refractive index of 1.5 that covers `share` of the surface.
    pub fn new(normal: DVec3, share: f64, roughness: f64) -> Self {
        Self { normal, gloss: Gloss::new(Rgb::splat(0.04 * share), Rgb::splat(share), roughness) }
    }

    /// Clear coat of Blender's Principled BSDF.
    pub fn principled(normal: DVec3, share: f64, roughness: f64) -> Self {
        let gloss = Gloss::new(Rgb::splat(0.04), Rgb::ONE, roughness).principled();
        Self { normal, gloss: gloss.covering(share) }
    }

    /// Transmission to the layers below.
    fn leaves(&self, to_eye: DVec3, to_light: DVec3) -> f64 {
        let of_principled = self.gloss.principled_lets_out(self.normal.dot(to_eye).abs());
        of_principled.unwrap_or_else(|| 1.0 - self.albedo(to_eye).max(self.albedo(to_light)))
    }

    /// Approximate albedo of the coat.
    pub fn albedo(&self, direction: DVec3) -> f64 {
        self.gloss.albedo(self.normal.dot(direction).abs()).x
    }
}

impl Layers {
    /// BSDF times cosine of the surface with its layers, 1/sr, from that without them. `normal` is the
    /// sheen's; the light is on the side of the eye if `is_before`.
    pub fn over(
        &self,
        mut scattered: Rgb,
        normal: DVec3,
        to_eye: DVec3,
        to_light: DVec3,
        is_before: bool,
    ) -> Rgb {
        if let Some(sheen) = &self.sheen {
            let albedo = |direction: DVec3| sheen.albedo(normal.dot(direction).abs());
            scattered *= 1.0 - albedo(to_eye).max(albedo(to_light));
            if is_before {
                scattered += normal.dot(to_light).max(0.0) * sheen.brdf(normal, to_eye, to_light);
            }
        }
        if let Some(coat) = &self.clearcoat {
            scattered *= coat.leaves(to_eye, to_light);
            if is_before {
                scattered +=
                    coat.normal.dot(to_light).max(0.0) * coat.gloss.brdf(coat.normal, to_eye, to_light);
            }
        }
        scattered
    }

    /// Transmission of the surface's emission and mirror reflection to the eye: a coat attenuates them,
    /// fibres do not.
    pub fn lets_out(&self, to_eye: DVec3) -> f64 {
        self.clearcoat.as_ref().map_or(1.0, |coat| coat.leaves(to_eye, to_eye))
    }

    /// Approximate albedo of the layers.
    pub fn albedo(&self, normal: DVec3, to_eye: DVec3) -> f64 {
        self.sheen_albedo(normal, to_eye) + self.clearcoat.as_ref().map_or(0.0, |coat| coat.albedo(to_eye))
    }

    /// Approximate albedo of the sheen alone.
    pub fn sheen_albedo(&self, normal: DVec3, to_eye: DVec3) -> f64 {
        self.sheen.as_ref().map_or(0.0, |sheen| sheen.albedo(normal.dot(to_eye).abs()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec2;
    use std::f64::consts::{FRAC_1_PI, PI};

    fn direction(cos: f64, angle: f64) -> DVec3 {
        (DVec2::from_angle(angle) * (1.0 - cos * cos).sqrt()).extend(cos)
    }

    /// Integral over the hemisphere, with smaller steps near the horizon, where a coat reflects into a narrow
    /// range of azimuths.
    fn over_lights(f: impl Fn(DVec3) -> f64) -> f64 {
        let (rings, around) = (400, 512);
        let mut sum = 0.0;
        for ring in 0..rings {
            let s = (f64::from(ring) + 0.5) / f64::from(rings);
            let (cos, width) = (s * s, 2.0 * s / f64::from(rings));
            for step in 0..around {
                let angle = 2.0 * PI * (f64::from(step) + 0.5) / f64::from(around);
                sum += f(direction(cos, angle)) * width * 2.0 * PI / f64::from(around);
            }
        }
        sum
    }

    /// Cycles 5.0: reflection of a diffuse surface of .8 below it, lit at 80 degrees and seen from above.
    #[test]
    fn a_principled_coat_takes_on_the_way_out_alone() {
        let coat = Clearcoat::principled(DVec3::Z, 1.0, 0.03);
        let grazing = direction(10_f64.to_radians().sin(), 0.0);
        assert!((coat.leaves(DVec3::Z, grazing) - 0.96).abs() < 1e-3);
        let plain = Clearcoat::new(DVec3::Z, 1.0, 0.03);
        assert!(plain.leaves(DVec3::Z, grazing) < 0.7);
    }

    fn each() -> impl Iterator<Item = Layers> {
        let tilted = DVec3::new(0.2, -0.1, 1.0).normalize();
        let sheens = [None, Some(0.0), Some(0.12), Some(0.25), Some(0.6), Some(1.0)];
        let coats = [None, Some((DVec3::Z, 1.0, 0.5)), Some((tilted, 0.7, 0.3))];
        sheens.into_iter().flat_map(move |sheen| {
            coats.map(|coat| Layers {
                sheen: sheen.map(|roughness| Sheen::new(Rgb::new(1.0, 0.5, 0.1), roughness)),
                clearcoat: coat.map(|(normal, share, roughness)| Clearcoat::new(normal, share, roughness)),
            })
        })
    }

    #[test]
    fn directions_can_be_swapped() {
        for layers in each() {
            for (a, b) in [((0.9, 0.3), (0.2, 2.0)), ((0.5, 1.0), (0.55, 4.0)), ((0.05, 0.0), (1.0, 0.0))] {
                let (v, l) = (direction(a.0, a.1), direction(b.0, b.1));
                // Sheen is reciprocal by itself; coats divide by their own cosines.
                let layers = Layers {
                    clearcoat: layers.clearcoat.map(|coat| Clearcoat { normal: DVec3::Z, ..coat }),
                    ..layers
                };
                let there = layers.over(Rgb::splat(FRAC_1_PI * l.z), DVec3::Z, v, l, true) / l.z;
                let back = layers.over(Rgb::splat(FRAC_1_PI * v.z), DVec3::Z, l, v, true) / v.z;
                assert!((there - back).abs().max_element() <= 1e-13 * there.max_element(), "{layers:?}");
            }
        }
    }

    #[test]
    fn white_furnace() {
        for layers in each() {
            for cos in [0.002, 0.01, 0.06, 0.3, 0.7, 1.0] {
                let to_eye = direction(cos, 1.0);
                let white = |l: DVec3| Rgb::splat(FRAC_1_PI * l.z);
                let all = over_lights(|l| layers.over(white(l), DVec3::Z, to_eye, l, true).x);
                assert!(all < 1.001, "{layers:?} {cos}: {all}");
                // The layers take less than the worst case of both directions.
                assert!(all > 0.3, "{layers:?} {cos}: {all}");
                let black = over_lights(|l| layers.over(Rgb::ZERO, DVec3::Z, to_eye, l, true).x);
                assert!(
                    (black - layers.albedo(DVec3::Z, to_eye)).abs() < 0.05 + 0.5 * black,
                    "{layers:?} {cos}: {black}"
                );
            }
        }
    }

    /// Coats reduce the light below by their own reflection; directions are sampled from the coats.
    #[test]
    fn coats_take_what_they_reflect() {
        for roughness in [0.03, 0.045, 0.08, 0.2, 0.5, 1.0] {
            for cos in [0.003, 0.01, 0.02, 0.045, 0.2, 0.6, 1.0] {
                let coat = Clearcoat::new(DVec3::Z, 1.0, roughness);
                let (to_eye, count) = (direction(cos, 0.4), 200);
                let mut reflected = 0.0;
                for index in 0..count * count {
                    let u = DVec2::new(f64::from(index % count), f64::from(index / count)) + 0.5;
                    let to_light = coat.gloss.sample(DVec3::Z, to_eye, u / f64::from(count));
                    if to_light.z > 0.0 {
                        let brdf = coat.gloss.brdf(DVec3::Z, to_eye, to_light).x;
                        reflected += brdf * to_light.z / coat.gloss.pdf(DVec3::Z, to_eye, to_light);
                    }
                }
                reflected /= f64::from(count * count);
                let taken = coat.albedo(to_eye);
                assert!((taken - reflected).abs() < 1e-3, "{roughness} {cos}: {taken} {reflected}");
            }
        }
    }

    /// By hand: along the normal a rough sheen is (2 + 1) sin / (2 pi) over 4 (1 +
    /// lambda(1) + lambda(l)) cos.
    #[test]
    fn a_rough_sheen_is_that_of_the_extension() {
        let to_light = direction(0.6, 0.0);
        let sin_half = ((1.0 - 0.6) / 2.0_f64).sqrt();
        let curve = |x: f64| 21.5473 / (1.0 + 3.82987 * x.powf(0.19823)) - 1.97760 * x - 4.32054;
        let lambda = |cos: f64| (2.0 * curve(0.5) - curve(1.0 - cos)).exp();
        let expected = 3.0 * sin_half / (2.0 * PI) / (4.0 * (1.0 + lambda(1.0) + lambda(0.6)) * 0.6);
        let found = Sheen::new(Rgb::ONE, 1.0).brdf(DVec3::Z, DVec3::Z, to_light).x;
        assert!((found / expected - 1.0).abs() < 1e-12, "{found} {expected}");
    }

    #[test]
    fn a_coat_alone_is_a_gloss_and_a_share_of_none_is_nothing() {
        let (v, l) = (direction(0.8, 0.0), direction(0.7, 2.5));
        let over = |share: f64, base: Rgb| {
            let layers = Layers { sheen: None, clearcoat: Some(Clearcoat::new(DVec3::Z, share, 0.4)) };
            layers.over(base, DVec3::Z, v, l, true)
        };
        let gloss = Gloss::new(Rgb::splat(0.04), Rgb::ONE, 0.4);
        assert_eq!(over(1.0, Rgb::ZERO), l.z * gloss.brdf(DVec3::Z, v, l));
        assert_eq!(over(0.0, Rgb::ONE), Rgb::ONE);
    }
}
