//! Sheen of cloth: glTF's KHR_materials_sheen for one light direction. In go unit vectors and a normal, out
//! come a BRDF and its albedo. Invariant: it is reciprocal and never reflects more than the incident light.
//!
//! Fibres stand up and catch light from the side: the "Charlie" distribution with its fitted shadowing
//! (Estevez and Kulla 2017, "Production friendly microfacet sheen BRDF"). Below a roughness of 0.3 the fit
//! reflects up to 2.5 times the incident light at grazing angles; there it is divided by its albedo.

use super::albedos::split;
use crate::color::Rgb;
use glam::{DVec2, DVec3};
use std::f64::consts::PI;
use std::sync::LazyLock;

/// Factor on the table's albedos: true ones are up to 3.5 % larger at grazing angles.
const SAFETY: f64 = 1.04;

/// Minimum roughness: the distribution has no limit at 0.
const LEAST_ROUGHNESS: f64 = 0.1;

/// Sheen.
#[derive(Clone, Copy, Debug)]
pub struct Sheen {
    color: Rgb,
    /// Square of its roughness.
    alpha: f64,
    /// Row of the table of albedos for its roughness.
    row: f64,
}

impl Sheen {
    /// A sheen of this colour and roughness, both `0..=1`.
    pub fn new(color: Rgb, roughness: f64) -> Self {
        let roughness = roughness.clamp(LEAST_ROUGHNESS, 1.0);
        Self { color, alpha: roughness * roughness, row: roughness * LAST as f64 }
    }

    /// BRDF, 1/sr; both directions point away from the surface, on the normal's side.
    pub fn brdf(&self, normal: DVec3, to_eye: DVec3, to_light: DVec3) -> Rgb {
        let (cos_eye, cos_light) = (normal.dot(to_eye), normal.dot(to_light));
        let Some(half) = (to_eye + to_light).try_normalize() else { return Rgb::ZERO };
        if cos_eye <= 0.0 || cos_light <= 0.0 {
            return Rgb::ZERO;
        }
        let most = self.uncolored(cos_eye).max(self.uncolored(cos_light)).max(1.0);
        self.color * charlie(self.alpha, normal.cross(half).length(), cos_eye, cos_light) / most
    }

    /// Directional albedo in its brightest channel.
    pub fn albedo(&self, cos: f64) -> f64 {
        self.color.max_element() * self.uncolored(cos).min(1.0)
    }

    /// Albedo of a white sheen, or slightly more, before it is clamped to 1.
    fn uncolored(&self, cos: f64) -> f64 {
        let (above, down) = split(self.row, LAST);
        let (left, across) = split(cos.clamp(0.0, 1.0).sqrt() * LAST as f64, LAST);
        let between =
            |row: usize| ALBEDOS[row][left] + across * (ALBEDOS[row][left + 1] - ALBEDOS[row][left]);
        SAFETY * (between(above) + down * (between(above + 1) - between(above)))
    }
}

/// Distribution times visibility (KHR_materials_sheen, "Sheen distribution" and "Sheen visibility").
fn charlie(alpha: f64, sin_half: f64, cos_eye: f64, cos_light: f64) -> f64 {
    let distribution = (2.0 + 1.0 / alpha) * sin_half.powf(1.0 / alpha) / (2.0 * PI);
    let shadowing = 1.0 + shadow(alpha, cos_eye) + shadow(alpha, cos_light);
    distribution / (shadowing * 4.0 * cos_eye * cos_light)
}

/// Lambda of Smith's shadowing, as fitted by Estevez and Kulla (their equation 3 and table 1).
fn shadow(alpha: f64, cos: f64) -> f64 {
    let smooth = (1.0 - alpha) * (1.0 - alpha);
    let fitted = |rough: f64, of_smooth: f64| rough + smooth * (of_smooth - rough);
    let (a, b, c) = (fitted(21.5473, 25.3245), fitted(3.82987, 3.32435), fitted(0.19823, 0.16801));
    let (d, e) = (fitted(-1.97760, -1.27393), fitted(-4.32054, -4.85967));
    let curve = |x: f64| a / (1.0 + b * x.powf(c)) + d * x + e;
    if cos < 0.5 { curve(cos).exp() } else { (2.0 * curve(0.5) - curve(1.0 - cos)).exp() }
}

/// Index of the last row and column of the table.
const LAST: usize = 31;

/// Albedos of a white sheen, by roughness and by the root of the cosine, as they change most at grazing
/// angles.
static ALBEDOS: LazyLock<Vec<[f64; LAST + 1]>> = LazyLock::new(|| {
    let at = |index: usize| index as f64 / LAST as f64;
    let row = |row: usize| {
        let roughness = at(row).max(LEAST_ROUGHNESS);
        // It has a limit at grazing angles.
        std::array::from_fn(|column| directional_albedo(roughness * roughness, at(column).powi(2).max(1e-3)))
    };
    (0..=LAST).map(row).collect()
});

/// Integral of the BRDF times the cosine for a viewer at `cos`.
fn directional_albedo(alpha: f64, cos: f64) -> f64 {
    const RINGS: usize = 48;
    const AROUND: usize = 48;
    let to_eye = DVec3::new((1.0 - cos * cos).sqrt(), 0.0, cos);
    let mut sum = 0.0;
    for index in 0..RINGS * AROUND {
        let root = ((index / AROUND) as f64 + 0.5) / RINGS as f64;
        let cos_light = root * root;
        // Half of the circle, as the other half is its mirror image.
        let around = DVec2::from_angle(PI * ((index % AROUND) as f64 + 0.5) / AROUND as f64);
        let to_light = ((1.0 - cos_light * cos_light).sqrt() * around).extend(cos_light);
        let half = (to_eye + to_light).normalize();
        sum += charlie(alpha, half.truncate().length(), cos, cos_light) * cos_light * 2.0 * root;
    }
    sum * 2.0 * PI / (RINGS * AROUND) as f64
}
