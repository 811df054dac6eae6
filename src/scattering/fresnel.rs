//! Fresnel term of a microfacet: the rise of its reflectance from normal incidence to grazing angles. In goes
//! a cosine, out comes a share: 0 at normal incidence, 1 at grazing. Invariant: the share is Schlick's or
//! that of a dielectric.

/// Refractive indices with tabulated shares for rough surfaces, over all directions.
pub(super) const INDICES: [f64; 4] = [1.15, 1.4, 1.5, 2.1];
/// Means of [`Fresnel::rise`] over the hemisphere, weighted by cosine.
const MEANS: [f64; 4] = [0.030_402, 0.050_435, 0.053_935, 0.054_358];
/// Fourth roots of their reflectances at normal incidence, `sqrt((eta - 1) / (eta + 1))`.
const PLACES: [f64; 4] = [0.264_135_271_898, 0.408_248_290_464, 0.447_213_595_500, 0.595_683_397_181];
/// Range of the square root of the reflectance, to which others are clamped: for indices of 1.05, as one of 1
/// reflects nothing, to 3.
const ROOTS: [f64; 2] = [0.05 / 2.05, 0.5];

/// Fresnel reflectance of a dielectric.
#[derive(Clone, Copy, Debug)]
pub(super) struct Fresnel {
    /// Refractive index.
    eta: f64,
    /// Weights of [`INDICES`] in its interpolation.
    shares: [f64; INDICES.len()],
}

impl Fresnel {
    /// Dielectric with a reflectance at normal incidence, `0..=1`.
    pub(super) fn of_reflectance(f0: f64) -> Self {
        let root = f0.max(0.0).sqrt().clamp(ROOTS[0], ROOTS[1]);
        // Lagrange polynomials in the fourth root of the reflectance: shares are accurate to 0.0016 from 1.15
        // to 2.2.
        let place = root.sqrt();
        let share = |of: usize| {
            let others = (0..INDICES.len()).filter(|other| *other != of);
            others.map(|other| (place - PLACES[other]) / (PLACES[of] - PLACES[other])).product()
        };
        let eta = (1.0 + root) / (1.0 - root);
        Self { eta, shares: std::array::from_fn(share) }
    }

    /// Term at the cosine of the angle to a microfacet's normal.
    pub(super) fn at(&self, cos: f64) -> f64 {
        Self::rise(self.eta, cos)
    }

    /// Mean over the hemisphere, weighted by cosine.
    pub(super) fn mean(&self) -> f64 {
        self.mix(MEANS)
    }

    /// Interpolates a value between those of [`INDICES`].
    pub(super) fn mix(&self, each: [f64; INDICES.len()]) -> f64 {
        self.shares.iter().zip(each).map(|(share, value)| share * value).sum()
    }

    /// Fresnel term to replace Schlick's, `(F - f0) / (1 - f0)`, for a refractive index (Pharr, Jakob and
    /// Humphreys 2023, "Physically based rendering", 9.3.5).
    pub(super) fn rise(eta: f64, cos: f64) -> f64 {
        let f0 = ((eta - 1.0) / (eta + 1.0)).powi(2);
        let cos = cos.clamp(0.0, 1.0);
        let cos_within = (1.0 - (1.0 - cos * cos) / (eta * eta)).sqrt();
        let parallel = (eta * cos - cos_within) / (eta * cos + cos_within);
        let perpendicular = (cos - eta * cos_within) / (cos + eta * cos_within);
        (0.5 * (parallel * parallel + perpendicular * perpendicular) - f0) / (1.0 - f0)
    }
}

/// `(1 - cos)^5`.
pub(super) fn schlick(cos: f64) -> f64 {
    (1.0 - cos).clamp(0.0, 1.0).powi(5)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::gauss_legendre;

    /// Known values: Fresnel's equations at normal incidence, at Brewster's angle, and at grazing.
    #[test]
    fn rises_from_none_to_all() {
        for eta in [1.2, 1.33, 1.5, 2.0_f64] {
            let f0 = ((eta - 1.0) / (eta + 1.0)).powi(2);
            let rise = |cos: f64| Fresnel::rise(eta, cos);
            assert!(rise(1.0).abs() < 1e-12 && (rise(0.0) - 1.0).abs() < 1e-12);
            let perpendicular = ((1.0 - eta * eta) / (1.0 + eta * eta)).powi(2);
            let found = f0 + (1.0 - f0) * rise(eta.atan().cos());
            assert!((found - 0.5 * perpendicular).abs() < 1e-12);
            assert!((Fresnel::of_reflectance(f0).eta - eta).abs() < 1e-12);
        }
    }

    /// By quadrature; the mean reflectance at 1.5 is 0.0918.
    #[test]
    fn means_are_those_of_the_equations() {
        let over_hemisphere = |f: &dyn Fn(f64) -> f64| -> f64 {
            let nodes = gauss_legendre(64).iter();
            nodes.map(|(x, weight)| weight * 0.5 * (x + 1.0) * f(0.5 * (x + 1.0))).sum()
        };
        for (place, eta) in PLACES.into_iter().zip(INDICES) {
            assert!((place * place - (eta - 1.0) / (eta + 1.0)).abs() < 1e-11);
        }
        for (eta, mean) in INDICES.into_iter().zip(MEANS) {
            let exact = over_hemisphere(&|cos| Fresnel::rise(eta, cos));
            assert!((mean - exact).abs() < 1e-5, "{eta}: {mean} {exact}");
        }
        assert!((0.04 + 0.96 * MEANS[2] - 0.0918).abs() < 5e-5);
        for eta in [1.15, 1.25, 1.33, 1.45, 1.6, 1.8, 2.1_f64] {
            let fresnel = Fresnel::of_reflectance(((eta - 1.0) / (eta + 1.0)).powi(2));
            let exact = over_hemisphere(&|cos| fresnel.at(cos));
            assert!((fresnel.mean() - exact).abs() < 1e-4, "{eta}: {} {exact}", fresnel.mean());
            for cos in [0.0, 0.02, 0.07, 0.15, 0.3, 0.6, 1.0] {
                let mixed = fresnel.mix(INDICES.map(|eta| Fresnel::rise(eta, cos)));
                assert!((mixed - fresnel.at(cos)).abs() < 1.6e-3, "{eta} {cos}: {mixed} {}", fresnel.at(cos));
            }
        }
    }
}
