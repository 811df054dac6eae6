//! Glossy coat of a surface: glTF's metallic-roughness model for one light direction. In go unit vectors and
//! a normal, out come a BRDF and a factor for the diffuse base below it. Invariants: a coat with a white base
//! conserves energy. Both are reciprocal, except for multiple scattering of metals.
//!
//! The coat is that of the glTF 2.0 specification, appendix B.3: a GGX distribution of microfacets with
//! separable Smith shadowing and Schlick's Fresnel term. Below it the specification's example weights Lambert
//! by `1 - F(v.h)`. At grazing angles that reflects up to nearly twice the incident light; B.1 leaves
//! renderers free to do better. Here Lambert is weighted by the coat's transmission on the way in and on the
//! way out. The weight is `(1 - E(v)) (1 - E(l)) / (1 - E_mean)`, with the coat's albedo `E`. It is equation
//! 4 of Kelemen and Szirmay-Kalos 2001, "A microfacet based coupled specular-matte BRDF model".
//!
//! The model loses light that meets several microfacets: over two thirds of it on the roughest metals. Metals
//! get it back as in Cycles, tinted by further reflections: the BRDF is scaled up by the energy that its
//! albedo for the eye lacks. That is equation 16 of Turquin 2019, "Practical multiple scattering compensation
//! for microfacet models".
//!
//! The coat of Blender's Principled BSDF is that of Cycles. Fresnel's equations replace Schlick's term, and
//! shadowing is correlated. The base is weighted by the coat's transmission towards the eye alone, which is
//! not reciprocal.

use super::fresnel::{Fresnel, schlick};
use super::ggx::Shadowing;
use super::microfacets::{Microfacets, lacking};
use crate::color::Rgb;
use glam::{DVec2, DVec3};

/// A coat.
#[derive(Clone, Copy, Debug)]
pub struct Gloss {
    /// Reflectance of metal and coat together.
    all: Reflectance,
    /// Reflectance of the non-metallic part, which alone lies over a diffuse base.
    coat: Reflectance,
    /// Reflectance of multiple scattering, to be scaled by `(1 - E) / E` of a white coat's albedo `E`.
    repeated: Option<Reflectance>,
    principled: Option<Principled>,
    microfacets: Microfacets,
    /// Share of the surface that it covers, `0..=1`.
    cover: f64,
}

/// Properties of a Principled BSDF's coat beyond glTF's.
#[derive(Clone, Copy, Debug)]
struct Principled {
    /// Non-metallic share of the surface.
    share: f64,
    fresnel: Fresnel,
    /// Reflection by several microfacets in turn, as a share of the coat's.
    further: Rgb,
}

#[derive(Clone, Copy, Debug)]
struct Reflectance {
    /// Reflectance at normal incidence.
    f0: Rgb,
    /// Reflectance at grazing angles.
    f90: Rgb,
}

impl Reflectance {
    /// Reflectance at the angle of a Schlick term.
    fn at(&self, schlick: f64) -> Rgb {
        self.f0 + (self.f90 - self.f0) * schlick
    }

    /// Albedo of a rough surface, from its two factors.
    fn albedo(&self, part0: f64, part90: f64) -> Rgb {
        self.f0 * part0 + self.f90 * part90
    }
}

impl Gloss {
    /// A coat with the reflectances `f0` at normal incidence and `f90` at grazing angles; `roughness` as in
    /// glTF, `0..=1`.
    pub fn new(f0: Rgb, f90: Rgb, roughness: f64) -> Self {
        let coat = Reflectance { f0, f90 };
        let microfacets = Microfacets::new(roughness, Shadowing::Separable);
        Self { all: coat, coat, repeated: None, principled: None, microfacets, cover: 1.0 }
    }

    /// glTF's alpha, the square of its roughness.
    pub fn alpha(&self) -> f64 {
        self.microfacets.alpha
    }

    /// Coat with a lobe at least as wide as that of an alpha, for its shape alone: its BRDF no longer has the
    /// albedo [`Gloss::albedo`].
    pub fn widened(self, least_alpha: f64) -> Self {
        Self { microfacets: self.microfacets.widened(least_alpha), ..self }
    }

    /// Coat on a share of the surface, `0..=1`.
    pub fn covering(self, cover: f64) -> Self {
        Self { cover, ..self }
    }

    /// Coat of Cycles' Principled BSDF, with the index of its reflectance at normal incidence.
    pub fn principled(self) -> Self {
        let Reflectance { f0, f90 } = self.coat;
        // For a share of a surface both reflectances are multiplied by the share.
        let fresnel = Fresnel::of_reflectance(f0.max_element() / f90.max_element().max(f64::MIN_POSITIVE));
        let own = Self { microfacets: self.microfacets.under(Shadowing::Correlated), ..self };
        let further = own.further(f0 + (f90 - f0) * fresnel.mean());
        let repeated = Some(Reflectance { f0: further * f0, f90: further * f90 });
        Self { principled: Some(Principled { share: 1.0, fresnel, further }), repeated, ..own }
    }

    /// Coat with a metallic share, `0..=1`, of reflectances at normal incidence and at grazing angles.
    pub fn with_metal(self, share: f64, color: Rgb, grazing: Rgb) -> Self {
        if share <= 0.0 {
            return self;
        }
        // Schlick's term averaged over the hemisphere: 20 parts of f0 and one of f90.
        let further = self.further(color + (grazing - color) / 21.0);
        let mut repeated = Reflectance { f0: share * further * color, f90: share * further * grazing };
        if let Some(of_coat) = self.repeated {
            repeated.f0 += (1.0 - share) * of_coat.f0;
            repeated.f90 += (1.0 - share) * of_coat.f90;
        }
        let Reflectance { f0, f90 } = self.coat;
        let all = Reflectance { f0: f0.lerp(color, share), f90: f90 + share * (grazing - f90) };
        let principled = self.principled.map(|own| Principled { share: 1.0 - share, ..own });
        Self { all, repeated: Some(repeated), principled, ..self }
    }

    /// Ratio of multiple to single scattering by microfacets, for light from all directions. A share of 1 -
    /// E_mean meets another microfacet, which gives a geometric series (Kulla and Conty 2017, "Revisiting
    /// physically based shading at Imageworks", appendix; without its first bounce, which is the BRDF).
    fn further(&self, one_bounce: Rgb) -> Rgb {
        let [mean0, mean90] = self.microfacets.albedos.mean();
        let mean = mean0 + mean90;
        one_bounce * mean / (Rgb::ONE - one_bounce * (1.0 - mean))
    }

    /// The coat's BRDF, 1/sr; both directions point away from the surface, on the normal's side.
    pub fn brdf(&self, normal: DVec3, to_eye: DVec3, to_light: DVec3) -> Rgb {
        let (cos_eye, cos_light) = (normal.dot(to_eye), normal.dot(to_light));
        let Some(half) = (to_eye + to_light).try_normalize() else { return Rgb::ZERO };
        if cos_eye <= 0.0 || cos_light <= 0.0 {
            return Rgb::ZERO;
        }
        let cos_half = to_eye.dot(half);
        let schlick = schlick(cos_half);
        let mut reflected = self.all.at(schlick);
        if let Some(own) = self.principled {
            reflected += own.share * (self.coat.f90 - self.coat.f0) * (own.fresnel.at(cos_half) - schlick);
        }
        if let Some(repeated) = self.repeated {
            reflected += repeated.at(schlick) * lacking(self.microfacets.albedos.towards(cos_eye));
        }
        self.cover * reflected * self.microfacets.distribution(normal, half)
            / self.microfacets.smith(cos_eye, cos_light)
    }

    /// Samples a direction to the light by two uniform numbers, with a density close to the BRDF times the
    /// cosine: a visible microfacet mirrors the eye. It may lie below the surface.
    pub fn sample(&self, normal: DVec3, to_eye: DVec3, u: DVec2) -> DVec3 {
        self.microfacets.sample(normal, to_eye, u)
    }

    /// Probability density of [`Gloss::sample`] for a direction, 1/sr.
    pub fn pdf(&self, normal: DVec3, to_eye: DVec3, to_light: DVec3) -> f64 {
        self.microfacets.pdf(normal, to_eye, to_light)
    }

    /// Factor on the BRDF of the diffuse base, for the cosines of both directions. It belongs to the
    /// non-metallic part: metal has no base.
    pub fn beneath(&self, cos_eye: f64, cos_light: f64) -> Rgb {
        if let Some(own) = self.principled {
            return Rgb::splat(self.let_out(own, cos_eye));
        }
        let [mean0, mean90] = self.microfacets.albedos.mean();
        let left = Rgb::ONE - self.coat.albedo(mean0, mean90);
        let lets = |cos: f64| {
            let [part0, part90] = self.microfacets.albedos.towards(cos);
            Rgb::ONE - self.coat.albedo(part0, part90)
        };
        // A coat that reflects all light transmits none.
        Rgb::select(left.cmpgt(Rgb::ZERO), lets(cos_eye) * lets(cos_light) / left, Rgb::ZERO)
    }

    /// Transmission of a Principled BSDF's coat towards the eye, uncovered parts included; `None` for other
    /// coats.
    pub fn principled_lets_out(&self, cos: f64) -> Option<f64> {
        self.principled.map(|own| 1.0 - self.cover * (1.0 - self.let_out(own, cos)))
    }

    /// Factors that turn [`Gloss::beneath`] of a Principled BSDF's coat into that of a coat with so many
    /// times the absorption.
    pub fn leaves_in_turn(&self, takes: [Rgb; 2], cos_eye: f64) -> [Rgb; 2] {
        let Some(own) = self.principled.filter(|_| takes != [Rgb::ONE; 2]) else { return [Rgb::ONE; 2] };
        let left = self.let_out(own, cos_eye.max(0.0)).max(f64::MIN_POSITIVE);
        takes.map(|takes| (Rgb::ONE - takes * (1.0 - left)).max(Rgb::ZERO) / left)
    }

    /// Transmission of a Principled BSDF's coat towards the eye, for all channels that of the one with the
    /// highest reflection (Cycles 5.0, `closure_layering_weight`). As in Cycles, microfacets have equal
    /// weights, and shadowing is applied to the whole (`bsdf_microfacet_estimate_albedo`).
    fn let_out(&self, own: Principled, cos: f64) -> f64 {
        let albedos = &self.microfacets.albedos;
        let [part0, part90] = albedos.towards(cos);
        let white = part0 + part90;
        let reflected =
            self.coat.at(albedos.risen(cos, &own.fresnel)) * (white + own.further * (1.0 - white));
        (1.0 - reflected.max_element()).max(0.0)
    }

    /// Directional albedo of the coat.
    pub fn albedo(&self, cos: f64) -> Rgb {
        self.cover * self.albedo_where_it_is(cos)
    }

    /// Approximate transmission of the coat to its base.
    pub fn leaves(&self, cos: f64) -> Rgb {
        Rgb::ONE - self.albedo_where_it_is(cos)
    }

    fn albedo_where_it_is(&self, cos: f64) -> Rgb {
        let albedos = &self.microfacets.albedos;
        let parts @ [part0, part90] = albedos.towards(cos);
        let mut once = self.all.albedo(part0, part90);
        if let Some(own) = self.principled {
            let beyond = albedos.beyond_schlick(cos, &own.fresnel);
            once += own.share * (self.coat.f90 - self.coat.f0) * beyond;
        }
        self.repeated.map_or(once, |repeated| once + repeated.albedo(part0, part90) * lacking(parts))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    fn direction(cos: f64, angle: f64) -> DVec3 {
        DVec2::from_angle(angle).extend(0.0) * (1.0 - cos * cos).sqrt() + cos * DVec3::Z
    }

    /// Integral over the hemisphere of a function of the direction to the light, with fine steps near the
    /// mirror direction.
    fn over_lights(to_eye: DVec3, f: impl Fn(DVec3) -> Rgb) -> Rgb {
        // Half vectors, in angles from the normal with smaller steps near it: l = 2 (v.h) h - v, dl = 4 (v.h)
        // dh.
        let (rings, around) = (1200, 240);
        let mut sum = Rgb::ZERO;
        for ring in 0..rings {
            let s = (f64::from(ring) + 0.5) / f64::from(rings);
            let (theta, width) = (0.5 * PI * s * s * s, 0.5 * PI * 3.0 * s * s / f64::from(rings));
            for step in 0..around {
                let half = direction(theta.cos(), 2.0 * PI * (f64::from(step) + 0.5) / f64::from(around));
                let cos_half = to_eye.dot(half);
                let to_light = 2.0 * cos_half * half - to_eye;
                if cos_half > 0.0 && to_light.z > 0.0 {
                    let solid_angle = theta.sin() * width * 2.0 * PI / f64::from(around);
                    sum += f(to_light) * to_light.z * 4.0 * cos_half * solid_angle;
                }
            }
        }
        sum
    }

    /// Reflectance of white Lambert below a coat, by the root of the cosine.
    fn lambert_beneath(gloss: &Gloss, cos: f64) -> Rgb {
        let count = 2000;
        let roots = (0..count).map(|ring| (f64::from(ring) + 0.5) / f64::from(count));
        roots.map(|root| 4.0 * root.powi(3) * gloss.beneath(cos, root * root)).sum::<Rgb>() / f64::from(count)
    }

    #[test]
    fn directions_can_be_swapped() {
        for roughness in [0.1, 0.4, 0.9] {
            let gloss = Gloss::new(Rgb::new(0.04, 0.5, 0.9), Rgb::ONE, roughness);
            for (a, b) in [((0.9, 0.3), (0.2, 2.0)), ((0.5, 1.0), (0.55, 4.0)), ((0.05, 0.0), (1.0, 0.0))] {
                let (v, l) = (direction(a.0, a.1), direction(b.0, b.1));
                let (there, back) = (gloss.brdf(DVec3::Z, v, l), gloss.brdf(DVec3::Z, l, v));
                assert!((there - back).abs().max_element() <= 1e-14 * there.max_element());
                assert_eq!(gloss.beneath(v.z, l.z), gloss.beneath(l.z, v.z));
            }
        }
    }

    /// A coat on half of a surface is half as strong on all of it.
    #[test]
    fn a_coat_takes_from_its_own_share_alone() {
        let whole = Gloss::new(Rgb::splat(0.04), Rgb::ONE, 0.5).principled();
        let half = Gloss::new(Rgb::splat(0.02), Rgb::splat(0.5), 0.5).principled();
        for cos in [0.02, 0.2, 0.6, 1.0] {
            let takes = [Rgb::splat(2.0), Rgb::ZERO];
            let [own, beside] =
                half.leaves_in_turn(takes, cos).map(|factor| factor.x * half.beneath(cos, 0.5).x);
            assert!((own - whole.beneath(cos, 0.5).x).abs() < 1e-2, "{cos}: {own}");
            assert!((beside - 1.0).abs() < 1e-12, "{cos}: {beside}");
        }
    }

    #[test]
    fn the_table_is_the_integral_of_the_brdf() {
        for roughness in [0.0, 0.07, 0.2, 0.5, 0.77, 1.0] {
            let gloss = Gloss::new(Rgb::new(0.0, 0.04, 1.0), Rgb::ONE, roughness);
            // For refractive indices from 1.33 to 1.8.
            let principled =
                [0.02, 0.04, 0.08].map(|f0| Gloss::new(Rgb::splat(f0), Rgb::ONE, roughness).principled());
            for (gloss, cos) in std::iter::once(gloss)
                .chain(principled)
                .flat_map(|gloss| [0.001, 0.02, 0.1, 0.35, 0.8, 1.0].map(|cos| (gloss, cos)))
            {
                let to_eye = direction(cos, 0.4);
                let exact = over_lights(to_eye, |l| gloss.brdf(DVec3::Z, to_eye, l));
                let found = gloss.albedo(cos);
                let off = (found - exact).abs().max_element();
                assert!(off < 0.002, "{roughness} {cos}: {found} {exact}");
            }
        }
    }

    /// The mean of samples over their densities is the coat's albedo.
    #[test]
    fn directions_are_picked_as_densely_as_is_said() {
        let normal = DVec3::new(0.3, 0.8, -0.4).normalize();
        let across = normal.any_orthonormal_vector();
        for roughness in [0.2, 0.6, 1.0] {
            for cos in [0.2, 0.7, 1.0_f64] {
                let gloss = Gloss::new(Rgb::splat(0.5), Rgb::ONE, roughness);
                let to_eye = cos * normal + (1.0 - cos * cos).sqrt() * across;
                let (mut sum, count) = (0.0, 200);
                for index in 0..count * count {
                    let u = DVec2::new(f64::from(index % count), f64::from(index / count)) + 0.5;
                    let to_light = gloss.sample(normal, to_eye, u / f64::from(count));
                    let weight = normal.dot(to_light) / gloss.pdf(normal, to_eye, to_light);
                    sum += gloss.brdf(normal, to_eye, to_light).x * weight / f64::from(count * count);
                }
                assert!((sum - gloss.albedo(cos).x).abs() < 4e-3, "{roughness} {cos}: {sum}");
            }
        }
    }

    /// Known values: the albedo of a rough conductor with full reflectance, without multiple scattering.
    #[test]
    fn a_white_conductor_loses_what_scatters_twice() {
        // Both ends of GGX: a mirror loses nothing; with alpha 1, D is 1 / pi everywhere, so E at normal
        // incidence is the integral of c / (c + 1) dc.
        let white = |roughness: f64| Gloss::new(Rgb::ONE, Rgb::ONE, roughness).albedo(1.0).x;
        assert!((white(0.0) - 1.0).abs() < 1e-3);
        let exact = 1.0 - 2.0_f64.ln();
        assert!((white(1.0) - exact).abs() < 1e-3, "{} {exact}", white(1.0));
    }

    /// White metal, and a half of it beside a white diffuse surface under a leaf's coat, at every roughness
    /// and angle.
    #[test]
    fn white_metal_gives_back_all() {
        for roughness in [0.0, 0.1, 0.25, 0.4, 0.7, 0.98, 1.0] {
            let coat = Gloss::new(Rgb::splat(0.04), Rgb::ONE, roughness);
            let [half_metal, metal] = [0.5, 1.0].map(|share| coat.with_metal(share, Rgb::ONE, Rgb::ONE));
            for cos in [0.002, 0.03, 0.15, 0.5, 1.0] {
                let to_eye = direction(cos, 1.0);
                let shone = over_lights(to_eye, |l| metal.brdf(DVec3::Z, to_eye, l)).x;
                assert!((shone - 1.0).abs() < 1e-3, "{roughness} {cos}: {shone}");
                assert!((metal.albedo(cos) - 1.0).abs().max_element() < 1e-12);
                let shone = over_lights(to_eye, |l| half_metal.brdf(DVec3::Z, to_eye, l)).x;
                assert!((shone - half_metal.albedo(cos).x).abs() < 1e-3, "{roughness} {cos}: {shone}");
                let beneath = 0.5 * lambert_beneath(&half_metal, cos).x;
                assert!((shone + beneath - 1.0).abs() < 1e-3, "{roughness} {cos}: {shone} + {beneath}");
            }
        }
    }

    /// Metal's reflection as Kulla and Conty's whole series: some light is reflected once, the rest again and
    /// again, tinted each time.
    #[test]
    fn coloured_metal_is_tinted_by_what_it_reflects_again() {
        let color = Rgb::new(0.9, 0.5, 0.0);
        let plain = Gloss::new(color, Rgb::ONE, 1.0);
        let metal = Gloss::new(Rgb::splat(0.04), Rgb::ONE, 1.0).with_metal(1.0, color, Rgb::ONE);
        // With alpha 1 the mean albedo of white metal is the integral of 2 c E(c) dc.
        let white = Gloss::new(Rgb::ONE, Rgb::ONE, 1.0);
        let count = 2000;
        let mean = (0..count)
            .map(|index| (f64::from(index) + 0.5) / f64::from(count))
            .map(|cos| 2.0 * cos * white.albedo(cos).x / f64::from(count))
            .sum::<f64>();
        let [of_white, of_metal] = [white.albedo(0.6).x, plain.albedo(0.6).x];
        let bounce = 0.9 + 0.1 / 21.0;
        let further = (1..200).map(|n| bounce * mean * (bounce * (1.0 - mean)).powi(n - 1)).sum::<f64>();
        let expected = of_metal * (1.0 + further * (1.0 - of_white) / of_white);
        assert!((metal.albedo(0.6).x - expected).abs() < 1e-3, "{} {expected}", metal.albedo(0.6));
        let gain = metal.albedo(0.6) / plain.albedo(0.6);
        assert!(gain.x > gain.y && gain.y > gain.z && gain.z > 1.0, "{gain}");
    }

    /// White under a Principled BSDF's coat reflects all light, at every roughness and angle. Cycles'
    /// estimate of the coat's albedo is off by 0.2 % at normal incidence, 1 % at grazing angles, and twice
    /// that for a smooth coat.
    #[test]
    fn a_principled_coat_gives_back_about_all() {
        for roughness in [0.0, 0.1, 0.25, 0.5, 0.7, 1.0] {
            let gloss = Gloss::new(Rgb::splat(0.04), Rgb::ONE, roughness).principled();
            for cos in [0.002, 0.03, 0.15, 0.5, 1.0] {
                let to_eye = direction(cos, 1.0);
                let shone = over_lights(to_eye, |l| gloss.brdf(DVec3::Z, to_eye, l)).x;
                let beneath = lambert_beneath(&gloss, cos).x;
                let all = shone + beneath;
                let bar = if cos >= 0.5 { 2e-3 } else { 0.0225 };
                assert!((all - 1.0).abs() < bar, "{roughness} {cos}: {shone} + {beneath}");
            }
        }
    }

    /// A white surface at every roughness and angle: without reflection at normal incidence, with a leaf's
    /// coat, and with one of diamond.
    #[test]
    fn white_furnace() {
        for roughness in [0.0, 0.04, 0.06, 0.1, 0.15, 0.25, 0.4, 0.55, 0.7, 0.85, 1.0] {
            let gloss = Gloss::new(Rgb::new(0.0, 0.04, 0.17), Rgb::ONE, roughness);
            for cos in [0.0005, 0.002, 0.01, 0.03, 0.06, 0.15, 0.3, 0.5, 0.7, 0.9, 1.0] {
                let to_eye = direction(cos, 1.0);
                let shone = over_lights(to_eye, |l| gloss.brdf(DVec3::Z, to_eye, l));
                let all = shone + lambert_beneath(&gloss, cos);
                assert!((all - 1.0).abs().max_element() < 6e-4, "{roughness} {cos}: {all}");
            }
        }
    }
}
