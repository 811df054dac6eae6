//! Directional albedos of coats. In go a roughness and a cosine, out come the factors of `f0` and of `f90` in
//! the albedo. Together they are the albedo of a white coat by single scattering. For Cycles' shadowing, and
//! the refractive indices of [`Fresnel`], there are two more numbers. One is the share that moves from the
//! first factor to the second where Fresnel's equations replace Schlick's term. The other is the unweighted
//! mean of those equations over visible microfacets that mirror the eye upwards. Invariant: a row of a table
//! is computed once, on first use.

use super::fresnel::{Fresnel, INDICES, schlick};
use super::ggx::{Shadowing, visible_normal};
use crate::math::gauss_legendre;
use glam::{DVec2, DVec3};
use std::f64::consts::PI;
use std::sync::OnceLock;

/// Minimum roughness: a highlight of a light without extent needs some width.
pub const LEAST_ROUGHNESS: f64 = 0.03;

/// Indices of the last row and column of the table.
const LAST_ROW: usize = 111;
const LAST_COLUMN: usize = 79;
/// Numbers of microfacets in the mean of a table's entry: from the one that faces the eye to the rim, and
/// over half the circle.
const RINGS: usize = 20;
const AROUND: usize = 20;
/// Has no divisor in common with `AROUND`.
const STRIDE: usize = 7;

#[derive(Clone, Copy, Debug)]
pub(super) struct CoatAlbedos {
    shadowing: Shadowing,
    /// Roughness as in glTF.
    roughness: f64,
    /// Place of that roughness among the rows of a table.
    place: f64,
    /// Scale of the table's columns, which are equally spaced in the logarithm.
    columns: f64,
}

impl CoatAlbedos {
    /// Albedos of a roughness from [`LEAST_ROUGHNESS`] to 1.
    pub(super) fn new(roughness: f64, shadowing: Shadowing) -> Self {
        Self { shadowing, roughness, place: row_of(roughness), columns: columns_over(roughness) }
    }

    /// Albedos of the same roughness under another shadowing.
    pub(super) fn under(self, shadowing: Shadowing) -> Self {
        Self { shadowing, ..self }
    }

    fn row(self, number: usize) -> &'static Row {
        let table = match self.shadowing {
            Shadowing::Separable => &SEPARABLE,
            Shadowing::Correlated => &CORRELATED,
        };
        table[number].get_or_init(|| Box::new(Row::new(number, self.shadowing)))
    }

    /// Factors of `f0` and `f90` for light from one direction.
    pub(super) fn towards(self, cos: f64) -> [f64; 2] {
        self.between(cos, |entry| entry.once)
    }

    /// Share that moves from the first factor to the second by Fresnel's equations.
    pub(super) fn beyond_schlick(self, cos: f64, fresnel: &Fresnel) -> f64 {
        fresnel.mix(self.between(cos, |entry| entry.beyond_schlick))
    }

    /// Mean of those equations over visible microfacets.
    pub(super) fn risen(self, cos: f64, fresnel: &Fresnel) -> f64 {
        fresnel.mix(self.between(cos, |entry| entry.risen))
    }

    fn between<const PARTS: usize>(self, cos: f64, of: impl Fn(&Entry) -> [f64; PARTS]) -> [f64; PARTS] {
        let column = self.columns * (1.0 + cos.clamp(0.0, 1.0).sqrt() / self.roughness).ln();
        let (left, fraction) = split(column, LAST_COLUMN);
        self.between_rows(|row| {
            let [a, b] = [left, left + 1].map(|column| of(&row.directional[column]));
            std::array::from_fn(|part| a[part] + fraction * (b[part] - a[part]))
        })
    }

    /// Factors of `f0` and `f90`, averaged over the hemisphere.
    pub(super) fn mean(self) -> [f64; 2] {
        self.between_rows(|row| row.mean)
    }

    fn between_rows<const PARTS: usize>(self, of: impl Fn(&Row) -> [f64; PARTS]) -> [f64; PARTS] {
        let (above, fraction) = split(self.place, LAST_ROW);
        let [a, b] = [above, above + 1].map(|number| of(self.row(number)));
        std::array::from_fn(|part| a[part] + fraction * (b[part] - a[part]))
    }
}

/// The integer part, below `last`, and the remainder.
pub(super) fn split(place: f64, last: usize) -> (usize, f64) {
    let whole = (place as usize).min(last - 1);
    (whole, place - whole as f64)
}

/// Table by roughness and by cosine. A scene has few roughnesses, so rows are computed as they are needed.
///
/// Shadowing begins at cosines around alpha, for any alpha. So rows are equally spaced in the logarithm of
/// the roughness, and columns in that of 1 plus the cosine's root over the roughness.
type Table = [OnceLock<Box<Row>>; LAST_ROW + 1];

static SEPARABLE: Table = [const { OnceLock::new() }; LAST_ROW + 1];
static CORRELATED: Table = [const { OnceLock::new() }; LAST_ROW + 1];

struct Row {
    directional: [Entry; LAST_COLUMN + 1],
    /// Mean over all directions, by their cosine.
    mean: [f64; 2],
}

/// Factors for light from one direction.
#[derive(Clone, Copy, Default)]
struct Entry {
    once: [f64; 2],
    beyond_schlick: [f64; INDICES.len()],
    risen: [f64; INDICES.len()],
}

fn row_of(roughness: f64) -> f64 {
    LAST_ROW as f64 * (1.0 - roughness.ln() / LEAST_ROUGHNESS.ln())
}

fn columns_over(roughness: f64) -> f64 {
    LAST_COLUMN as f64 / (1.0 + 1.0 / roughness).ln()
}

fn cos_of(column: f64, roughness: f64) -> f64 {
    (roughness * ((column / columns_over(roughness)).exp() - 1.0)).powi(2).min(1.0)
}

impl Row {
    fn new(number: usize, shadowing: Shadowing) -> Self {
        let roughness = LEAST_ROUGHNESS.powf(1.0 - number as f64 / LAST_ROW as f64);
        // Half of the circle, as the other half is its mirror image.
        let around: [DVec2; AROUND] =
            std::array::from_fn(|step| DVec2::from_angle(PI * (step as f64 + 0.5) / AROUND as f64));
        // It has a limit at grazing angles.
        let cos = |column: usize| cos_of(column as f64, roughness).max(1e-6);
        let directional: [Entry; LAST_COLUMN + 1] = std::array::from_fn(|column| {
            directional_albedo(shadowing, roughness * roughness, cos(column), &around)
        });
        // Integral of 2 cos E(cos), that is of E over the square of the cosine, from the row's values.
        let square = |column: f64| cos_of(column, roughness).powi(2);
        let mean = [0, 1].map(|part| {
            let piece = |column: usize| {
                let [a, b] = [column, column + 1].map(|column| directional[column].once[part]);
                let (from, to) = (square(column as f64), square((column + 1) as f64));
                // By parts: the value at the end, less the integral of what the squares before it lack.
                let before = gauss_legendre(4).iter().map(|(x, weight)| {
                    let way = 0.5 * (x + 1.0);
                    0.5 * weight * (square(column as f64 + way) - from)
                });
                b * (to - from) - (b - a) * before.sum::<f64>()
            };
            (0..LAST_COLUMN).map(piece).sum()
        });
        Self { directional, mean }
    }
}

/// Integral of the BRDF times the cosine for a viewer at `cos`, over visible microfacets: each reflects `F
/// G1(l)`, or Cycles' equivalent (Heitz 2018, "Sampling the GGX distribution of visible normals", equation
/// 19).
fn directional_albedo(shadowing: Shadowing, alpha: f64, cos: f64, around: &[DVec2; AROUND]) -> Entry {
    let to_eye = DVec3::new((1.0 - cos * cos).sqrt(), 0.0, cos);
    let alpha2 = alpha * alpha;
    let mut entry = Entry::default();
    let weight = 1.0 / (RINGS * AROUND) as f64;
    for ring in 0..RINGS {
        for (step, &around) in around.iter().enumerate() {
            // Denser towards the rim, where light begins to be lost below the surface. No two have the same
            // distance from the rim (a lattice: Niederreiter 1992, chapter 5), or all would be lost at once.
            let within = (step * STRIDE % AROUND) as f64 + 0.5;
            let left = 1.0 - (ring as f64 + within / AROUND as f64) / RINGS as f64;
            let half = visible_normal(alpha, to_eye, around, 1.0 - left * left);
            let cos_half = to_eye.dot(half);
            let cos_light = 2.0 * cos_half * half.z - cos;
            if cos_light <= 0.0 {
                continue;
            }
            let seen = 2.0 * left * weight;
            let shown = seen * 2.0 * cos_light / shadowing.smith_of_light(alpha2, cos, cos_light);
            let risen = schlick(cos_half);
            entry.once[0] += shown * (1.0 - risen);
            entry.once[1] += shown * risen;
            if matches!(shadowing, Shadowing::Correlated) {
                for (index, eta) in INDICES.into_iter().enumerate() {
                    let fresnel = Fresnel::rise(eta, cos_half);
                    entry.beyond_schlick[index] += shown * (fresnel - risen);
                    entry.risen[index] += seen * fresnel;
                }
            }
        }
    }
    entry
}
