//! One interface of a rough dielectric, which reflects and refracts. The surface of a body consists of such
//! interfaces, and so does a sheet that is not declared a thin wall. In go directions and the normal on the
//! side of the eye, out comes a BSDF. Invariant: without a colour an interface conserves energy.
//!
//! It is the transmission of Cycles' Principled BSDF: microfacets that refract (Walter, Marschner, Li and
//! Torrance 2007, "Microfacet models for refraction through rough surfaces", equations 20 and 21), by
//! Fresnel's equations. Radiance is not scaled by the square of the index. Multiple scattering is compensated
//! by the albedo for the eye (Turquin 2019), in the tint. As in Cycles, directions count that no microfacet
//! refracts into, where both lie on its back.

use super::albedos::split;
use super::ggx::{self, Shadowing, visible_normal};
use super::microfacets::Microfacets;
use crate::color::Rgb;
use crate::math::GOLDEN;
use glam::{DVec2, DVec3};
use std::f64::consts::PI;
use std::sync::LazyLock;

/// Interface on a share of a surface.
#[derive(Clone, Copy, Debug)]
pub struct Interface {
    /// Share of the surface that is dielectric, `0..=1`.
    share: f64,
    /// Transmission tint: the square root of the colour, as light crosses two faces.
    tint: Rgb,
    /// Refractive index of the far side over that of the eye's side.
    eta: f64,
    roughness: f64,
    microfacets: Microfacets,
}

impl Interface {
    /// Interface of a body with a colour and a refractive index, and glTF's roughness, `0..=1`; `is_within`
    /// if the eye is on the inner side.
    pub fn new(share: f64, color: Rgb, index: f64, roughness: f64, is_within: bool) -> Self {
        let tint = color.clamp(Rgb::ZERO, Rgb::ONE).powf(0.5);
        let eta = if is_within { 1.0 / index } else { index };
        Self { share, tint, eta, roughness, microfacets: Microfacets::new(roughness, Shadowing::Correlated) }
    }

    /// glTF's alpha of its reflection, and of a reflection as wide as its refraction.
    pub fn alphas(&self) -> [f64; 2] {
        let alpha = self.microfacets.alpha;
        [alpha, 0.5 * alpha * (1.0 - 1.0 / self.eta).abs()]
    }

    /// Albedos of reflection and transmission, for the cosine of the eye.
    pub fn albedos(&self, cos: f64) -> [Rgb; 2] {
        if cos <= 0.0 {
            return [Rgb::ZERO; 2];
        }
        let [reflected, refracted] = once(self.roughness, cos, self.eta);
        let scale = self.scale(reflected + refracted);
        [scale * reflected, scale * refracted * self.tint]
    }

    /// Factor that compensates for light that meets several microfacets, each of which tints it: `once` is
    /// the share that meets one (Kulla and Conty 2017, "Revisiting physically based shading at Imageworks").
    fn scale(&self, once: f64) -> Rgb {
        let mean = mean(self.roughness, self.eta);
        let further = self.tint * mean / (Rgb::ONE - self.tint * (1.0 - mean));
        self.share * (Rgb::ONE + further * ((1.0 - once) / once))
    }

    /// BSDF, 1/sr; both directions point away from the surface, `to_eye` on the normal's side.
    pub fn bsdf(&self, normal: DVec3, to_eye: DVec3, to_light: DVec3) -> Rgb {
        let (cos_eye, cos_light) = (normal.dot(to_eye), normal.dot(to_light));
        if cos_eye <= 0.0 || cos_light == 0.0 {
            return Rgb::ZERO;
        }
        let Some((half, spread)) = self.half(to_eye, to_light, cos_light < 0.0) else { return Rgb::ZERO };
        let reflected = reflectance(self.eta, to_eye.dot(half));
        let sent = if cos_light < 0.0 { (1.0 - reflected) * self.tint } else { Rgb::splat(reflected) };
        let parts: f64 = once(self.roughness, cos_eye, self.eta).iter().sum();
        let facets = self.microfacets.distribution(normal, half);
        // G / (4 n.v n.l) times four times the Jacobian from a microfacet's normal to the direction.
        let seen = 4.0 * spread * to_eye.dot(half).abs() / self.microfacets.smith(cos_eye, cos_light.abs());
        facets * seen * sent * self.scale(parts)
    }

    /// Normal of the microfacet that maps one direction to the other, on either of its sides, and the
    /// Jacobian `d half / d light`.
    fn half(&self, to_eye: DVec3, to_light: DVec3, is_through: bool) -> Option<(DVec3, f64)> {
        let sum = if is_through { to_eye + self.eta * to_light } else { to_eye + to_light };
        let length = sum.length();
        let half = sum / length;
        let spread = if is_through {
            (self.eta / length).powi(2) * half.dot(to_light).abs()
        } else {
            0.25 / to_eye.dot(half).abs()
        };
        (half.is_finite() && spread.is_finite()).then_some((half, spread))
    }

    /// Samples a direction to the light by two uniform numbers, in transmission if `is_through`, otherwise in
    /// reflection. It may lie on the other side.
    pub fn sample(&self, normal: DVec3, to_eye: DVec3, is_through: bool, u: DVec2) -> DVec3 {
        if !is_through {
            return self.microfacets.sample(normal, to_eye, u);
        }
        let half = self.microfacets.sample_facet(normal, to_eye, u);
        refracted(self.eta, half, to_eye).unwrap_or_else(|| {
            let reflected = 2.0 * to_eye.dot(half) * half - to_eye;
            if reflected.dot(normal) < 0.0 { mirrored(normal, reflected) } else { reflected }
        })
    }

    /// Probability densities of [`Interface::sample`] for a direction, 1/sr: reflection and transmission.
    pub fn pdf(&self, normal: DVec3, to_eye: DVec3, to_light: DVec3) -> [f64; 2] {
        let cos_eye = normal.dot(to_eye);
        if cos_eye <= 0.0 {
            return [0.0; 2];
        }
        let reflected = self.microfacets.pdf(normal, to_eye, to_light);
        // Facets with total reflection are sampled for transmission, too, and reflect upwards.
        let of_total = |to_light: DVec3| {
            let half = (to_eye + to_light).try_normalize().unwrap_or(normal);
            let is_total = reflectance(self.eta, to_eye.dot(half)) >= 1.0;
            if is_total { self.microfacets.pdf(normal, to_eye, to_light) } else { 0.0 }
        };
        let is_above = normal.dot(to_light) >= 0.0;
        let total = if is_above { of_total(to_light) + of_total(mirrored(normal, to_light)) } else { 0.0 };
        let Some((half, spread)) = self.half(to_eye, to_light, true) else { return [reflected, total] };
        let half = if half.dot(normal) < 0.0 { -half } else { half };
        if to_eye.dot(half) <= 0.0 || to_light.dot(half) >= 0.0 {
            return [reflected, total];
        }
        let alpha2 = self.microfacets.alpha * self.microfacets.alpha;
        let facets = 2.0 * self.microfacets.distribution(normal, half) / ggx::smith(alpha2, cos_eye);
        [reflected, total + facets * to_eye.dot(half) * spread]
    }

    /// Direction from which a smooth interface transmits light.
    pub fn straight(&self, normal: DVec3, to_eye: DVec3) -> DVec3 {
        refracted(self.eta, normal, to_eye).unwrap_or(-to_eye)
    }
}

/// A direction mirrored to the other side.
fn mirrored(normal: DVec3, direction: DVec3) -> DVec3 {
    direction - 2.0 * normal.dot(direction) * normal
}

/// Direction to the light that a facet refracts to the eye; `None` for total reflection.
fn refracted(eta: f64, half: DVec3, to_eye: DVec3) -> Option<DVec3> {
    let cos = to_eye.dot(half);
    let cos_beyond2 = 1.0 - (1.0 - cos * cos) / (eta * eta);
    (cos_beyond2 > 0.0).then(|| (cos / eta - cos_beyond2.sqrt()) * half - to_eye / eta)
}

/// Reflectance of a facet by Fresnel's equations, for unpolarised light.
fn reflectance(eta: f64, cos: f64) -> f64 {
    let beyond2 = eta * eta - 1.0 + cos * cos;
    if beyond2 <= 0.0 {
        return 1.0;
    }
    let (cos, beyond) = (cos.abs(), beyond2.sqrt());
    let perpendicular = (cos - beyond) / (cos + beyond);
    let parallel = (eta * eta * cos - beyond) / (eta * eta * cos + beyond);
    0.5 * (perpendicular * perpendicular + parallel * parallel)
}

/// Number of steps of roughness, cosine and index in the table, as in Cycles.
const STEPS: usize = 15;
/// Last row of indices, for an index of 3.3.
const LAST: usize = 11;
/// Number of microfacets in the mean of an entry.
const FACETS: usize = 1200;

/// Shares of single scattering, by row of the index, of the roughness, and of the cosine.
type Table = [[[[f64; 2]; STEPS + 1]; STEPS + 1]; LAST + 1];

/// Table from outside, and from within.
static TABLES: LazyLock<[Table; 2]> = LazyLock::new(|| {
    [false, true].map(|is_within| {
        std::array::from_fn(|row| {
            // Rows are equally spaced in the fourth root of the reflectance at normal incidence.
            let root = (row as f64 / STEPS as f64).powi(2);
            let index = (1.0 + root) / (1.0 - root);
            let eta = if is_within { 1.0 / index } else { index };
            std::array::from_fn(|rough| std::array::from_fn(|cos| entry(eta, share(rough), share(cos))))
        })
    })
});

fn share(step: usize) -> f64 {
    (step as f64 / STEPS as f64).max(1e-3)
}

/// Mean shares over all directions, by row of the index and of the roughness; from outside, and from within.
static MEANS: LazyLock<[[[f64; STEPS + 1]; LAST + 1]; 2]> =
    LazyLock::new(|| TABLES.map(|table| table.map(|row| row.map(mean_of))));

/// Mean over all directions, weighted by cosine: linear between steps, so Simpson's rule is exact.
fn mean_of(by_cos: [[f64; 2]; STEPS + 1]) -> f64 {
    let step = 1.0 / STEPS as f64;
    let once = |place: usize| by_cos[place].iter().sum::<f64>();
    let piece = |from: usize| {
        let (cos, a, b) = (from as f64 * step, once(from), once(from + 1));
        step / 3.0 * (cos * a + 2.0 * (cos + 0.5 * step) * (a + b) + (cos + step) * b)
    };
    (0..STEPS).map(piece).sum()
}

/// Shares of light that single microfacets reflect and refract, interpolated linearly.
fn once(roughness: f64, cos: f64, eta: f64) -> [f64; 2] {
    let table = &TABLES[usize::from(eta < 1.0)];
    between(row_of(eta), LAST, &|row| {
        between(step_of(roughness), STEPS, &|rough| {
            between(step_of(cos), STEPS, &|cos| table[row][rough][cos])
        })
    })
}

/// Mean share of single scattering over all directions, for one roughness.
fn mean(roughness: f64, eta: f64) -> f64 {
    let means = &MEANS[usize::from(eta < 1.0)];
    let [mean] =
        between(row_of(eta), LAST, &|row| between(step_of(roughness), STEPS, &|rough| [means[row][rough]]));
    mean
}

fn row_of(eta: f64) -> f64 {
    ((eta - 1.0) / (eta + 1.0)).abs().sqrt() * STEPS as f64
}

fn step_of(share: f64) -> f64 {
    share.clamp(0.0, 1.0) * STEPS as f64
}

fn between<const PARTS: usize>(place: f64, last: usize, at: &dyn Fn(usize) -> [f64; PARTS]) -> [f64; PARTS] {
    let (first, way) = split(place, last);
    let (a, b) = (at(first), at(first + 1));
    std::array::from_fn(|part| a[part] + way.min(1.0) * (b[part] - a[part]))
}

/// Integral over visible microfacets, of reflection and of refraction.
fn entry(eta: f64, roughness: f64, cos: f64) -> [f64; 2] {
    // With an index of 1 nothing is refracted or lost.
    if eta == 1.0 {
        return [0.0, 1.0];
    }
    let (alpha, to_eye) = (roughness * roughness, DVec3::new((1.0 - cos * cos).sqrt(), 0.0, cos));
    let sent = |to_light: DVec3| {
        2.0 * to_light.z.abs() / Shadowing::Correlated.smith_of_light(alpha * alpha, cos, to_light.z.abs())
    };
    let mut sums = [0.0; 2];
    for facet in 0..FACETS {
        // A lattice: no two have the same distance from the rim (Niederreiter 1992, chapter 5).
        let around = (facet as f64 + 0.5) / FACETS as f64;
        let to_rim = (facet as f64 * GOLDEN).fract();
        let half = visible_normal(alpha, to_eye, DVec2::from_angle(PI * around), to_rim);
        let reflected = reflectance(eta, to_eye.dot(half));
        let mirrored = 2.0 * to_eye.dot(half) * half - to_eye;
        if mirrored.z > 0.0 {
            sums[0] += reflected * sent(mirrored);
        }
        if let Some(through) = refracted(eta, half, to_eye).filter(|through| through.z < 0.0) {
            sums[1] += (1.0 - reflected) * sent(through);
        }
    }
    sums.map(|sum| sum / FACETS as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Known values: 0.04 for glass at normal incidence, and 1 beyond the critical angle.
    #[test]
    fn reflects_as_fresnel_says() {
        assert!((reflectance(1.5, 1.0) - 0.04).abs() < 1e-12);
        assert!((reflectance(1.0 / 1.5, 1.0) - 0.04).abs() < 1e-12);
        assert_eq!(reflectance(1.0 / 1.5, 0.7), 1.0);
        assert!((reflectance(1.5, 0.0) - 1.0).abs() < 1e-12);
    }

    /// By samples over their densities; light that no microfacet can refract is not among them.
    #[test]
    fn a_face_without_a_colour_gives_back_all() {
        // Roughnesses of the table: in between it is as coarse as Cycles'.
        for (roughness, is_within) in [(0.2, false), (0.6, true), (1.0, false)] {
            let (index, count) = ((225.0 + 49.0) / (225.0 - 49.0), 300);
            let face = Interface::new(1.0, Rgb::ONE, index, roughness, is_within);
            for cos in [0.2_f64, 0.6, 1.0] {
                let to_eye = DVec3::new((1.0 - cos * cos).sqrt(), 0.0, cos);
                let sums = [false, true].map(|is_through| {
                    let sent = |index: i32| {
                        let u = DVec2::new(f64::from(index % count), f64::from(index / count)) + 0.5;
                        let to_light = face.sample(DVec3::Z, to_eye, is_through, u / f64::from(count));
                        let density = face.pdf(DVec3::Z, to_eye, to_light)[usize::from(is_through)];
                        let weight = face.bsdf(DVec3::Z, to_eye, to_light) * to_light.z.abs() / density;
                        if density > 0.0 && (to_light.z < 0.0) == is_through { weight.x } else { 0.0 }
                    };
                    (0..count * count).map(sent).sum::<f64>() / f64::from(count * count)
                });
                let [reflected, through] = face.albedos(cos).map(|share| share.x);
                assert!((sums[0] - reflected).abs() < 0.01, "{roughness} {cos}: {sums:?} {reflected}");
                assert!((sums[1] - through).abs() < 0.01, "{roughness} {cos}: {sums:?} {through}");
                assert!((reflected + through - 1.0).abs() < 1e-12);
            }
        }
    }
}
