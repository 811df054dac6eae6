//! A thin sheet of a rough dielectric, such as a pane of frosted glass. In go directions and the normal on
//! the side of the eye, out comes a BSDF. Invariant: without a colour a sheet conserves energy.
//!
//! It is that of Cycles since Blender 5.2, after OpenPBR 1.1, section "Thin-walled case". Both albedos
//! include reflections within the sheet, by the angle to the sheet's own normal (Pharr, Jakob and Humphreys
//! 2023, section 9.5.1). Fully reflecting microfacets spread them. Only the eye's angle counts, so they are
//! not reciprocal.
//!
//! Transmitted light is refracted twice. It is represented by a mirror image of the reflection, with a
//! roughness of its own (Kulla and Conty 2017, "Revisiting physically based shading at Imageworks", page 40).
//! Its factor is 3.4 in Cycles, and 3.7 there.

use super::fresnel::Fresnel;
use super::ggx::Shadowing;
use super::microfacets::{Microfacets, lacking};
use crate::color::Rgb;
use glam::{DVec2, DVec3};

/// A thin dielectric on a share of a surface.
#[derive(Clone, Copy, Debug)]
pub struct ThinDielectric {
    /// Share of the surface that is this sheet, `0..=1`.
    share: f64,
    /// Transmittance of its inside at normal incidence.
    color: Rgb,
    /// Refractive index, 1 or more.
    eta: f64,
    reflecting: Microfacets,
    transmitting: Microfacets,
}

impl ThinDielectric {
    /// Sheet of glTF's roughness, `0..=1`.
    pub fn new(share: f64, color: Rgb, eta: f64, roughness: f64) -> Self {
        let widened = 3.4 * (eta - 1.0) * (eta - 0.5).powi(2) / eta.powi(3);
        let through = (roughness * roughness * widened).min(1.0).sqrt();
        let [reflecting, transmitting] =
            [roughness, through].map(|roughness| Microfacets::new(roughness, Shadowing::Correlated));
        Self { share, color, eta, reflecting, transmitting }
    }

    /// glTF's alpha of its reflection, and of its transmission.
    pub fn alphas(&self) -> [f64; 2] {
        [self.reflecting.alpha, self.transmitting.alpha]
    }

    /// Albedos of reflection and transmission, for the cosine of the eye.
    pub fn albedos(&self, cos: f64) -> [Rgb; 2] {
        if cos <= 0.0 {
            return [Rgb::ZERO; 2];
        }
        let f0 = ((self.eta - 1.0) / (self.eta + 1.0)).powi(2);
        let fresnel = f0 + (1.0 - f0) * Fresnel::rise(self.eta, cos);
        // Absorption along the path within (Beer and Lambert).
        let cos_within = (1.0 - (1.0 - cos * cos) / (self.eta * self.eta)).max(0.0).sqrt();
        let inside = self.color.powf(1.0 / cos_within);
        let within = fresnel * inside;
        let through = inside * (1.0 - fresnel).powi(2) / (Rgb::ONE - within * within);
        [fresnel + through * within, through].map(|share| self.share * share)
    }

    /// BSDF, 1/sr; both directions point away from the surface, `to_eye` on the normal's side.
    pub fn bsdf(&self, normal: DVec3, to_eye: DVec3, to_light: DVec3) -> Rgb {
        let [reflected, through] = self.albedos(normal.dot(to_eye));
        if normal.dot(to_light) > 0.0 {
            return reflected * white(&self.reflecting, normal, to_eye, to_light);
        }
        through * white(&self.transmitting, -normal, mirrored(normal, to_eye), to_light)
    }

    /// Samples a direction to the light by two uniform numbers, in transmission if `is_through`, otherwise in
    /// reflection.
    pub fn sample(&self, normal: DVec3, to_eye: DVec3, is_through: bool, u: DVec2) -> DVec3 {
        if is_through {
            return self.transmitting.sample(-normal, mirrored(normal, to_eye), u);
        }
        self.reflecting.sample(normal, to_eye, u)
    }

    /// Probability densities of [`ThinDielectric::sample`] for a direction, 1/sr: in reflection and in
    /// transmission.
    pub fn pdf(&self, normal: DVec3, to_eye: DVec3, to_light: DVec3) -> [f64; 2] {
        let through = self.transmitting.pdf(-normal, mirrored(normal, to_eye), to_light);
        [self.reflecting.pdf(normal, to_eye, to_light), through]
    }
}

/// Direction to the eye mirrored to the other side.
fn mirrored(normal: DVec3, to_eye: DVec3) -> DVec3 {
    to_eye - 2.0 * normal.dot(to_eye) * normal
}

/// BRDF of fully reflecting microfacets, with multiple scattering.
fn white(of: &Microfacets, normal: DVec3, to_eye: DVec3, to_light: DVec3) -> f64 {
    let (cos_eye, cos_light) = (normal.dot(to_eye), normal.dot(to_light));
    let Some(half) = (to_eye + to_light).try_normalize() else { return 0.0 };
    if cos_eye <= 0.0 || cos_light <= 0.0 {
        return 0.0;
    }
    let all = 1.0 + lacking(of.albedos.towards(cos_eye));
    all * of.distribution(normal, half) / of.smith(cos_eye, cos_light)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn direction(cos: f64, angle: f64) -> DVec3 {
        (DVec2::from_angle(angle) * (1.0 - cos * cos).sqrt()).extend(cos)
    }

    /// Reflectance of light from one side of the surface to the eye: samples over their densities.
    fn sent(sheet: &ThinDielectric, to_eye: DVec3, is_through: bool) -> Rgb {
        let count = 300;
        let weigh = |index: i32| {
            let u = DVec2::new(f64::from(index % count), f64::from(index / count)) + 0.5;
            let to_light = sheet.sample(DVec3::Z, to_eye, is_through, u / f64::from(count));
            if (to_light.z < 0.0) != is_through {
                return Rgb::ZERO;
            }
            let density = sheet.pdf(DVec3::Z, to_eye, to_light)[usize::from(is_through)];
            sheet.bsdf(DVec3::Z, to_eye, to_light) * to_light.z.abs() / density
        };
        (0..count * count).map(weigh).sum::<Rgb>() / f64::from(count * count)
    }

    #[test]
    fn a_sheet_without_a_colour_gives_back_all() {
        for (eta, roughness) in [(1.0, 0.5), (1.33, 0.2), (1.5, 0.05), (1.5, 0.6), (2.0, 1.0)] {
            let sheet = ThinDielectric::new(1.0, Rgb::ONE, eta, roughness);
            for cos in [0.1, 0.5, 1.0] {
                let to_eye = direction(cos, 0.7);
                let [before, behind] = [false, true].map(|is_through| sent(&sheet, to_eye, is_through));
                let [reflected, through] = sheet.albedos(cos);
                assert!((before - reflected).abs().max_element() < 4e-3, "{eta} {roughness} {cos}: {before}");
                assert!((behind - through).abs().max_element() < 4e-3, "{eta} {roughness} {cos}: {behind}");
                assert!((reflected + through - 1.0).abs().max_element() < 1e-12);
            }
        }
    }

    /// Known values: at normal incidence a face of index 1.5 reflects 0.04.
    #[test]
    fn a_pane_of_glass_reflects_a_thirteenth() {
        let [reflected, through] = ThinDielectric::new(0.5, Rgb::ONE, 1.5, 0.3).albedos(1.0);
        assert!((reflected - 0.5 * 0.08 / 1.04).abs().max_element() < 1e-12);
        assert!((through - 0.5 * 0.96 / 1.04).abs().max_element() < 1e-12);
        let [_, through] = ThinDielectric::new(1.0, Rgb::new(0.5, 0.1, 0.0), 1.0, 0.3).albedos(1.0);
        assert!((through - Rgb::new(0.5, 0.1, 0.0)).abs().max_element() < 1e-12);
    }

    /// Except for the albedos, which depend on the eye, and for multiple scattering.
    #[test]
    fn directions_can_be_swapped() {
        let sheet = ThinDielectric::new(0.7, Rgb::new(0.9, 0.5, 0.1), 1.5, 0.4);
        let once = |from: DVec3, to: DVec3| {
            let lobe = |normal: DVec3, mirrored: DVec3| {
                let again = 1.0 + lacking(sheet.transmitting.albedos.towards(mirrored.dot(normal)));
                white(&sheet.transmitting, normal, mirrored, to) / again
            };
            let normal = DVec3::Z * from.z.signum();
            lobe(-normal, mirrored(normal, from))
        };
        for (a, b) in [((0.9, 0.3), (0.2, 2.0)), ((0.5, 1.0), (0.55, 4.0)), ((0.05, 0.0), (1.0, 0.0))] {
            let (v, l) = (direction(a.0, a.1), -direction(b.0, b.1));
            let (there, back) = (once(v, l), once(l, v));
            assert!((there - back).abs() <= 1e-13 * there, "{there} {back}");
        }
    }
}
