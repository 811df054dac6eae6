//! Fog that thins out with height, alone or with uniform fog, along a range of a ray. In go the ways of eye
//! and light through it, and the lit parts. Out comes the integral of scattering times transmittance.
//! Invariant: every piece is so short that ten terms of its series are accurate to 1e-8.
//!
//! The optical depth's series is given at the centre of a piece (`thinning_fog.rs`). Those of `exp(-tau)` and
//! of its product with the density follow by the rules for power series (Knuth, "The Art of Computer
//! Programming" 2, section 4.7).

use super::depth_line::DepthLine;
use super::lit_cells::{FACTORIALS, Lit, MOST_PIECES, Moments, ORDER, Piece};
use super::thinning_fog::{Series, ThinningFog};
use crate::color::Rgb;
use crate::math::fast_exp;

/// Fog on an interval of a ray.
pub(super) struct DepthSeries<'a> {
    /// Optical depth without that of thinning fog from the start on and towards the light.
    pub(super) even: DepthLine,
    /// Scattering of the uniform fog, per metre and irradiance, 1/(m sr).
    pub(super) scattering: Rgb,
    pub(super) thinning: &'a [ThinningFog],
}

impl DepthSeries<'_> {
    /// Light scattered on the lit parts of a range, per unit of irradiance and per metre of reach, as the
    /// integral is over reach: see [`Lit::for_each_piece`]. Pieces follow the sum of the exponents of density
    /// and transmittance. `None` if the fog changes too fast along the range. The truncation error is below
    /// 1e-8 of the light that an unshadowed piece scatters (see the tests).
    pub(super) fn lit_integral(&self, end: f64, lit: &Lit) -> Option<Rgb> {
        let start = self.even.start;
        let range = start..end;
        let width = range.end - range.start;
        let fastest = |most: f64, fog: &ThinningFog| most.max(fog.exponents_change());
        let even = self.even.steepest() + self.thinning.iter().fold(0.0, fastest);
        let log_bound = |reach: f64| {
            let sum: f64 = self.thinning.iter().map(|fog| fog.depth_change(start, reach, &range)).sum();
            sum.max(f64::MIN_POSITIVE).ln()
        };
        // A function with a convex logarithm lies below the exponential through its ends.
        let (first, last) = (log_bound(range.start), log_bound(range.end));
        let growth = (last - first) / width;
        let change = |reach: f64| even + fast_exp(first + growth * (reach - start));
        let pieces = width * (change(range.start) + change(range.end));
        if pieces > MOST_PIECES {
            return None;
        }
        let mut sum = Rgb::ZERO;
        lit.for_each_piece(range, change, |piece, moments| {
            sum += self.integral(piece, moments);
        });
        Some(sum)
    }

    fn integral(&self, piece: &Piece, moments: &Moments) -> Rgb {
        let DepthLine { start, at_start, per_reach } = self.even;
        let offset = piece.middle - start;
        let mut tau = [Rgb::ZERO; ORDER];
        tau[0] = Rgb::from(at_start) + Rgb::from(per_reach) * offset;
        tau[1] = Rgb::from(per_reach) * piece.half_width;
        for fog in self.thinning {
            for (tau, metres) in tau.iter_mut().zip(fog.metres(start, piece)) {
                *tau += fog.sigma_t * metres;
            }
        }
        let through = exp_of_minus(&tau);
        let powers = std::array::from_fn(|j| FACTORIALS[j] * moments[j]);
        let mut sum = self.scattering * dot(&through, &powers);
        for fog in self.thinning {
            if let Some(ascent) = fog.along_ray {
                let density = ascent.density(offset, piece.half_width);
                sum += fog.scattering * dot(&through, &weighted(&density, &powers));
            }
        }
        sum
    }
}

fn dot(coefficients: &[Rgb; ORDER], powers: &[f64; ORDER]) -> Rgb {
    coefficients.iter().zip(powers).fold(Rgb::ZERO, |sum, (coefficient, power)| sum + coefficient * *power)
}

/// Coefficients of `exp(-tau)` by powers of the distance from the centre: as `f' = -tau' f`, `n f_n` is the
/// sum of `-j tau_j f_(n - j)` over j.
fn exp_of_minus(tau: &[Rgb; ORDER]) -> [Rgb; ORDER] {
    let slopes: [Rgb; ORDER] = std::array::from_fn(|j| -tau[j] * (j as f64 / FACTORIALS[j]));
    let mut f = [Rgb::ZERO; ORDER];
    f[0] = Rgb::new(fast_exp(-tau[0].x), fast_exp(-tau[0].y), fast_exp(-tau[0].z));
    for n in 1..ORDER {
        let sum = (1..=n).fold(Rgb::ZERO, |sum, j| sum + slopes[j] * f[n - j]);
        f[n] = sum * (n as f64).recip();
    }
    f
}

/// Integrals of powers, weighted with a density.
fn weighted(density: &Series, powers: &[f64; ORDER]) -> [f64; ORDER] {
    let coefficients: Series = std::array::from_fn(|j| density[j] * (1.0 / FACTORIALS[j]));
    std::array::from_fn(|k| (0..ORDER - k).map(|j| coefficients[j] * powers[k + j]).sum())
}

#[cfg(test)]
mod tests {
    use super::super::lit_cells::LitCells;
    use super::super::section::{LightWay, Line, Linear};
    use super::super::thinning_fog::{Ascent, Column};
    use super::*;
    use crate::math::{IntervalSet, PlanarRay, gauss_legendre};
    use glam::DVec2;
    use proptest::prelude::*;

    /// Quadrature with the textbook's closed forms for the two ways, over the lit parts.
    struct Truth {
        start: f64,
        ray: PlanarRay,
        way: LightWay,
        heights: Linear,
        sigma_t: Rgb,
    }

    impl Truth {
        fn integrand(&self, reach: f64) -> Rgb {
            let mean_of_exp = |x: f64| if x.abs() < 1e-6 { 1.0 - 0.5 * x } else { -(-x).exp_m1() / x };
            let along = self.heights.along(&Line { at_axis: 0.0, growth: self.ray.slope });
            let (width, low) = (reach - self.start, along.at(reach));
            let metres = (-along.at(self.start)).exp() * mean_of_exp(along.growth * width) * width;
            let length = self.way.upper.at(reach) - self.way.lower.at(reach);
            let per_height = self.heights.per_height;
            let column = if length.is_infinite() {
                (-low).exp() / per_height
            } else {
                (-low).exp() * length * mean_of_exp(per_height * length)
            };
            let tau =
                self.sigma_t * (metres / self.ray.direction.x + column) + Rgb::splat(0.1 + 0.03 * width);
            let through = Rgb::new((-tau.x).exp(), (-tau.y).exp(), (-tau.z).exp());
            (Rgb::splat(0.02) + Rgb::new(0.1, 0.2, 0.3) * (-low).exp()) * through
        }

        fn integral(&self, from: f64, to: f64) -> Rgb {
            const PIECES: usize = 60;
            let half = 0.5 * (to - from) / PIECES as f64;
            let middles = (0..PIECES).map(|piece| from + (2 * piece + 1) as f64 * half);
            let nodes = middles.flat_map(|middle| gauss_legendre(6).iter().map(move |node| (middle, node)));
            nodes.map(|(middle, (x, weight))| half * *weight * self.integrand(middle + x * half)).sum()
        }
    }

    /// Ten thousand kilometres below the base, where the light's way through the layer has the same depth
    /// everywhere.
    #[test]
    fn far_below_the_base() {
        let heights = Linear { at_eye: -3.0, per_reach: 0.3, per_height: 0.8 };
        let base = Line { at_axis: 3.0 / 0.8, growth: -0.3 / 0.8 };
        let way = LightWay { upper: Line { at_axis: f64::INFINITY, growth: 0.0 }, lower: base };
        let series = DepthSeries {
            even: DepthLine { start: 10.0, at_start: [0.0; 3], per_reach: [1e-6; 3] },
            scattering: Rgb::splat(1e-6),
            thinning: &[ThinningFog {
                sigma_t: Rgb::splat(1e-6),
                scattering: Rgb::ZERO,
                along_ray: None,
                to_light: Column::new(way, heights),
            }],
        };
        let (cells, none) = <(LitCells, IntervalSet)>::default();
        let lit = Lit { cells: &cells, shadows: &none, more_shadows: &none };
        let found = series.lit_integral(1e7, &lit).expect("few pieces");
        let expected = -(-1e-6 * (1e7 - 10.0_f64)).exp_m1() * (-1e-6_f64 / 0.8).exp();
        assert!((found / expected - 1.0).abs().max_element() < 1e-8, "{found} {expected}");
    }

    proptest! {
        #[test]
        fn equals_quadrature(
            scale_height in 0.5..8.0_f64, tilt in -1.5..1.5_f64, level in prop::bool::weighted(0.1),
            at_eye in 0.0..2.0_f64, slope in -2.0..2.0_f64, start in 0.0..3.0_f64, width in 0.01..40.0_f64,
            top in prop::option::of((0.0..20.0_f64, 0.0..1.0_f64)), density in 0.001..0.5_f64,
            inserted in prop::collection::vec((0.0..1.0_f64, 0.0..1.5_f64), 0..12),
        ) {
            let per_height = tilt.cos() / scale_height * if level && top.is_some() { 1e-9 } else { 1.0 };
            let heights = Linear { at_eye, per_reach: tilt.sin() / scale_height, per_height };
            let ray = PlanarRay::new(DVec2::new(1.0, slope).normalize());
            let along = heights.along(&Line { at_axis: 0.0, growth: slope });
            // The ray is above the base, and not too far above it.
            let limit = if along.growth < 0.0 { 0.0 } else { 30.0 };
            let end = (start + width).min((limit - along.at_axis) / along.growth);
            prop_assume!(end > start + 1e-3);
            let upper = match top {
                None => Line { at_axis: f64::INFINITY, growth: 0.0 },
                Some((above, growth)) => Line { at_axis: slope.abs() * end + above, growth },
            };
            let way = LightWay { upper, lower: Line { at_axis: 0.0, growth: slope } };
            let sigma_t = density * Rgb::new(0.5, 1.0, 1.5);
            let series = DepthSeries {
                even: DepthLine { start, at_start: [0.1; 3], per_reach: [0.03; 3] },
                scattering: Rgb::splat(0.02),
                thinning: &[ThinningFog {
                    sigma_t,
                    scattering: Rgb::new(0.1, 0.2, 0.3),
                    along_ray: Some(Ascent::new(&heights, &ray, start)),
                    to_light: Column::new(way, heights),
                }],
            };
            let mut cells = LitCells::default();
            cells.start(&[start, 0.5 * (start + end)], end, 0.3);
            let mut shadows = IntervalSet::default();
            for (place, width) in inserted {
                let from = start + place * (end - start);
                shadows.for_each_gap(from, from + width, |a, b| cells.darken(a, b));
                shadows.insert(from, from + width);
            }
            let lit = Lit { cells: &cells, shadows: &shadows, more_shadows: &IntervalSet::default() };
            let found = series.lit_integral(end, &lit);
            // Left to the per-ray method if it would take too many pieces, which is rare.
            prop_assume!(found.is_some());
            let found = found.unwrap_or_default();

            let truth = Truth { start, ray, way, heights, sigma_t };
            let mut expected = Rgb::ZERO;
            shadows.for_each_gap(start, end, |a, b| expected += truth.integral(a, b));
            let error = ((found - expected) / truth.integral(start, end)).abs().max_element();
            prop_assert!(error <= 1e-8, "{error:.2e}: {found} {expected}");
        }
    }
}
