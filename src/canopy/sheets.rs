//! Large sheets that light passes straight through: curtains, panes of glass. In go the optics of a sheet,
//! out come those of leaf area that stands for it. Invariant: the leaf area reflects as much light from all
//! sides as the sheet does, and lets as much through.

use crate::color::Rgb;
use crate::ordinates::surface_optics::SurfaceOptics;

/// Minimum share of light that passes: leaf area stops no light altogether.
const LEAST_PASSING: f64 = 0.02;
/// Share of light below which there is none.
const NONE: f64 = 1e-6;

/// Optics of leaf area spread over cells along a sheet, with its leaf area index as coverage. Light meets
/// some of it several times, and the sheet once.
pub(super) fn spread(sheet: &SurfaceOptics) -> SurfaceOptics {
    let passing = sheet.cover * sheet.through() + (1.0 - sheet.cover);
    let passing = passing.clamp(Rgb::splat(LEAST_PASSING), Rgb::ONE);
    let reflected = (sheet.cover * sheet.reflectance).min(Rgb::ONE - passing);
    let by_channel = [0, 1, 2].map(|channel| depths(reflected[channel], passing[channel]));
    let [all, back] = [0, 1].map(|which| Rgb::from_array(by_channel.map(|depths| depths[which])));
    let index = all.max_element();
    if index < NONE {
        return *sheet;
    }
    let [kept, of_sheet] = [(all - back) / index, (Rgb::ONE - reflected - passing).max(Rgb::splat(NONE))];
    SurfaceOptics {
        reflectance: back / index,
        transmittance: Rgb::ONE - all / index,
        emission: sheet.cover * sheet.emission * kept.max(Rgb::splat(NONE / index)) / of_sheet,
        straight: Rgb::ZERO,
        cover: index,
    }
}

/// Optical depths of extinction and of backscattering, from shares that are reflected and that pass, by
/// two-flux theory (Kubelka 1948, "New contributions to the optics of intensely light-scattering materials",
/// part I): `a = (1 + R^2 - T^2) / 2 R`, `b = sqrt(a^2 - 1)`, `b S X = artanh(b R / (1 - a R))`.
fn depths(reflected: f64, passing: f64) -> [f64; 2] {
    if reflected < NONE {
        return [-passing.ln(), 0.0];
    }
    let a = (1.0 + reflected.powi(2) - passing.powi(2)) / (2.0 * reflected);
    let b = (a * a - 1.0).max(0.0).sqrt();
    let tangent = reflected / (1.0 - a * reflected);
    let back = if b < NONE { tangent } else { (b * tangent).atanh() / b };
    [a * back, back]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of `n` leaf areas in a row, each an `n`th as dense, the whole reflects and passes what the sheet does.
    #[test]
    fn leaf_area_in_thin_slices_is_the_sheet() {
        for (cover, reflectance, transmittance) in
            [(0.5, 0.7, 0.1), (0.1, 0.2, 0.0), (0.8, 0.6, 0.4), (0.7, 0.0, 0.0)]
        {
            let [reflectance, transmittance] = [reflectance, transmittance].map(Rgb::splat);
            let sheet = SurfaceOptics { reflectance, transmittance, cover, ..SurfaceOptics::default() };
            let spread = spread(&sheet);
            let slice = spread.cover / 1e4;
            let (back, through) =
                (slice * spread.reflectance.x, 1.0 - slice * (1.0 - spread.transmittance.x));
            // Adding of layers (Stokes 1862).
            let (mut reflected, mut passing) = (0.0, 1.0);
            for _ in 0..10_000 {
                let again = 1.0 / (1.0 - back * reflected);
                reflected = back + through * through * reflected * again;
                passing *= through * again;
            }
            assert!((reflected - cover * reflectance.x).abs() < 1e-3, "{reflected}");
            assert!((passing - (1.0 - cover * (1.0 - transmittance.x))).abs() < 1e-3, "{passing}");
        }
    }
}
