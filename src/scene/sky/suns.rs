//! Suns in an image of the sky. In goes the image, out come suns and their excess in its texels. Invariant:
//! the rest of the image and the suns together have the vector irradiance of the image.
//!
//! A sun is a spot that is small, much brighter than the rest of the sky, about as wide as high, and a large
//! part of all light. Its disc has the solid angle `(integral L)^2 / integral L^2`, which is exact for a
//! uniform disc. The rest in its place is as bright as the surrounding texels.

use super::footprint::Footprints;
use super::table::direction_of;
use crate::color::{Rgb, luminance};
use crate::scene::Texture;
use glam::{DMat3, DVec2, DVec3, Vec2};
use rayon::prelude::*;
use std::collections::{HashMap, HashSet};
use std::f64::consts::{PI, TAU};

/// Sun in an image of the sky.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SkySun {
    /// Unit vector towards its centre.
    pub to_sun: DVec3,
    /// Irradiance on a perpendicular plane, W/m^2.
    pub irradiance: Rgb,
    /// Full angle of its disc, radians.
    pub angular_diameter: f64,
}

/// All suns of an unrotated image, at a strength of 1, and their part of it.
#[derive(Clone, Debug, Default)]
pub(super) struct SkySuns {
    pub(super) suns: Vec<SkySun>,
    /// Cosine of the angular radius beyond which no texel belongs to a sun.
    cos_reaches: Vec<f64>,
    /// Radiance of the suns' texels above their surroundings.
    excess: HashMap<usize, Rgb>,
}

/// Maximum number of suns, as each is rendered with slices of its own.
const MOST_SUNS: usize = 4;
/// Maximum number of spots to examine, the brightest first: some are single texels with little light.
const MOST_SPOTS: usize = 16;
/// Maximum angular radius of a sun; lamps in rooms and windows are wider.
const MOST_RADIUS: f64 = 2.5 * PI / 180.0;
/// Minimum brightness of a sun relative to the mean of the remaining sky.
const BRIGHT: f64 = 16.0;
/// Number of levels: the last is a millionth of the peak, which ends a spot on a black sky.
const LEVELS: usize = 20;
/// Minimum light of a sun, relative to the light of the rest.
const MUCH: f64 = 0.02;
/// Maximum ratio of the standard deviations along and across; a half disc has 1.9.
const LONGEST: f64 = 2.5;

impl SkySuns {
    /// Suns of an image, the brightest first.
    pub(super) fn of(image: &Texture) -> Self {
        let footprints = Footprints::new(image.width, image.height);
        let mut finder =
            Finder { image, footprints, found: Self::default(), passed: HashSet::new(), all: 0.0 };
        finder.all = finder.all_light();
        for _ in 0..MOST_SPOTS {
            let Some(spot) = finder.brightest().and_then(|peak| finder.spot(peak)) else { break };
            finder.take(spot);
            if finder.found.suns.len() == MOST_SUNS {
                break;
            }
        }
        finder.found
    }

    /// Radiance in a direction, at its point of the image, without suns.
    pub(super) fn beside(&self, image: &Texture, direction: DVec3, uv: Vec2) -> Rgb {
        let seen = image.color(uv);
        let is_near = |(sun, cos): (&SkySun, &f64)| sun.to_sun.dot(direction) > *cos;
        if !self.suns.iter().zip(&self.cos_reaches).any(is_near) {
            return seen;
        }
        let (texels, DVec2 { x, y }) = image.between(uv);
        let [a, b, c, d] = texels.map(|texel| self.excess.get(&texel).copied().unwrap_or(Rgb::ZERO));
        // Both are linear in the texels, up to rounding.
        (seen - a.lerp(b, x).lerp(c.lerp(d, x), y)).max(Rgb::ZERO)
    }
}

/// Search for suns in an image.
struct Finder<'a> {
    image: &'a Texture,
    footprints: Footprints,
    found: SkySuns,
    /// Texels of rejected spots.
    passed: HashSet<usize>,
    /// Luminance outside suns, integrated over the sphere.
    all: f64,
}

/// Texels around a local maximum, in the order in which they were found.
#[derive(Default)]
struct Spot {
    texels: Vec<usize>,
    /// Texels of the spot, and their neighbours.
    known: HashSet<usize>,
    /// Known texels below the current level.
    waiting: Vec<usize>,
    /// Luminance, integrated over the sphere.
    light: f64,
    /// Vector irradiance.
    directions: DVec3,
}

impl Finder<'_> {
    fn color(&self, texel: usize) -> Rgb {
        let [red, green, blue, _] = self.image.texels.get(texel).map(f64::from);
        Rgb::new(red, green, blue)
    }

    fn is_free(&self, texel: usize) -> bool {
        !self.found.excess.contains_key(&texel) && !self.passed.contains(&texel)
    }

    fn direction(&self, texel: usize) -> DVec3 {
        let Texture { width, height, .. } = *self.image;
        let place = DVec2::new((texel % width) as f64, (texel / width) as f64) + 0.5;
        direction_of(place / DVec2::new(width as f64, height as f64))
    }

    fn all_light(&self) -> f64 {
        let Texture { width, height, .. } = *self.image;
        let of_row = |row: usize| -> f64 {
            let texels = row * width..(row + 1) * width;
            let sum: f64 = texels.map(|texel| luminance(self.color(texel))).sum();
            sum * self.footprints.solid_angle(row * width)
        };
        // In a fixed order, so that the sum does not depend on threads.
        let rows: Vec<f64> = (0..height).into_par_iter().map(of_row).collect();
        rows.iter().sum()
    }

    /// First of the brightest texels that are not yet examined.
    fn brightest(&self) -> Option<usize> {
        let Texture { width, height, .. } = *self.image;
        let of_row = |row: usize| {
            let mut most = (0.0, 0);
            for texel in row * width..(row + 1) * width {
                let bright = luminance(self.color(texel));
                if bright > most.0 && self.is_free(texel) {
                    most = (bright, texel);
                }
            }
            most
        };
        let rows: Vec<_> = (0..height).into_par_iter().map(of_row).collect();
        let brighter = |a: (f64, usize), b: (f64, usize)| if b.0 > a.0 { b } else { a };
        let (bright, texel) = rows.into_iter().fold((0.0, 0), brighter);
        (bright > 0.0).then_some(texel)
    }

    /// Texels of the largest spot around a peak that is small and bright enough; `None` if there is none.
    /// Levels are halved one by one, so the glow around a sun belongs to it while it is bright.
    fn spot(&self, peak: usize) -> Option<Vec<usize>> {
        let mut spot = Spot { known: HashSet::from([peak]), waiting: vec![peak], ..Spot::default() };
        let (mut count, mut level) = (0, luminance(self.color(peak)));
        for _ in 0..LEVELS {
            level *= 0.5;
            // Mean over the sphere.
            let is_small = self.grow(&mut spot, level);
            if !is_small || level < BRIGHT * (self.all - spot.light) / (4.0 * PI) {
                break;
            }
            count = spot.texels.len();
        }
        spot.texels.truncate(count);
        (count > 0).then_some(spot.texels)
    }

    /// Adds connected texels above a level to a spot; returns whether it is still small enough.
    fn grow(&self, spot: &mut Spot, level: f64) -> bool {
        let is_bright = |texel: &usize| luminance(self.color(*texel)) > level;
        let mut rim;
        (rim, spot.waiting) = std::mem::take(&mut spot.waiting).into_iter().partition(is_bright);
        let texel_radius = PI / self.image.height as f64;
        while let Some(texel) = rim.pop() {
            spot.texels.push(texel);
            let bright = luminance(self.color(texel));
            spot.light += bright * self.footprints.solid_angle(texel);
            spot.directions += bright * self.footprints.directions(texel);
            let away = self.direction(texel).angle_between(self.direction(spot.texels[0]));
            if away > 2.0 * MOST_RADIUS + texel_radius {
                return false;
            }
            for next in self.around(texel) {
                if self.is_free(next) && spot.known.insert(next) {
                    if is_bright(&next) { rim.push(next) } else { spot.waiting.push(next) }
                }
            }
        }
        let middle = spot.directions.normalize_or_zero();
        let away = |texel: &usize| self.direction(*texel).angle_between(middle);
        spot.texels.iter().all(|texel| away(texel) < MOST_RADIUS + texel_radius)
    }

    /// Neighbours of a texel, also across the seam and the poles.
    fn around(&self, texel: usize) -> impl Iterator<Item = usize> {
        let Texture { width, height, .. } = *self.image;
        let (column, row) = (texel % width, texel / width);
        [-1, 0, 1].into_iter().flat_map(move |down: isize| {
            let (row, turn) = match row.checked_add_signed(down) {
                Some(row) if row < height => (row, 0),
                _ => (row, width / 2),
            };
            [width - 1, 0, 1].map(|across| row * width + (column + across + turn) % width)
        })
    }

    /// Makes a sun of a spot, or rejects it.
    fn take(&mut self, spot: Vec<usize>) {
        let mut known: HashSet<usize> = spot.iter().copied().collect();
        let around: Vec<usize> = spot.iter().flat_map(|texel| self.around(*texel)).collect();
        let weighed = around.into_iter().filter(|texel| known.insert(*texel)).map(|texel| {
            let solid_angle = self.footprints.solid_angle(texel);
            (solid_angle * self.color(texel), solid_angle)
        });
        let (sum, weight) =
            weighed.fold((Rgb::ZERO, 0.0), |(sum, all), (color, weight)| (sum + color, all + weight));
        let beneath = if weight > 0.0 { sum / weight } else { Rgb::ZERO };
        let excess = |texel: &usize| (*texel, (self.color(*texel) - beneath).max(Rgb::ZERO));
        let excess: Vec<(usize, Rgb)> = spot.iter().map(excess).collect();
        match self.sun(&excess) {
            Some(sun) => {
                let texel_radius = (PI / self.image.height as f64).hypot(TAU / self.image.width as f64);
                let away = |(texel, _): &(usize, Rgb)| self.direction(*texel).angle_between(sun.to_sun);
                let reach = texel_radius + excess.iter().map(away).fold(0.0, f64::max);
                self.all -= self.light_of(&excess);
                self.found.suns.push(sun);
                self.found.cos_reaches.push(reach.min(PI).cos());
                self.found.excess.extend(excess);
            }
            None => self.passed.extend(spot),
        }
    }

    /// Luminance of texels integrated over the sphere.
    fn light_of(&self, texels: &[(usize, Rgb)]) -> f64 {
        texels.iter().map(|(texel, color)| luminance(*color) * self.footprints.solid_angle(*texel)).sum()
    }

    /// Sun with the light of these texels, if they look like one.
    fn sun(&self, texels: &[(usize, Rgb)]) -> Option<SkySun> {
        let light = self.light_of(texels);
        // Vector irradiance of each channel, a column each.
        let irradiance = |(texel, color): &(usize, Rgb)| {
            let directions = self.footprints.directions(*texel);
            DMat3::from_cols(color.x * directions, color.y * directions, color.z * directions)
        };
        let irradiance = texels.iter().map(irradiance).fold(DMat3::ZERO, |sum, one| sum + one);
        let to_sun = (0..3).map(|channel| irradiance.col(channel)).sum::<DVec3>().try_normalize()?;
        let squared =
            |(texel, color): &(usize, Rgb)| luminance(*color).powi(2) * self.footprints.solid_angle(*texel);
        let solid_angle = light * light / texels.iter().map(squared).sum::<f64>();
        let radius = (1.0 - solid_angle / TAU).max(-1.0).acos();
        let is_sun = radius <= MOST_RADIUS
            && light >= MUCH * (self.all - light)
            && self.elongation(texels, to_sun) <= LONGEST;
        is_sun.then(|| SkySun {
            to_sun,
            irradiance: irradiance.transpose() * to_sun,
            angular_diameter: 2.0 * radius,
        })
    }

    /// Ratio of the standard deviations of their light along and across.
    fn elongation(&self, texels: &[(usize, Rgb)], to_sun: DVec3) -> f64 {
        let (x_axis, y_axis) = to_sun.any_orthonormal_pair();
        // Variance of a single texel's footprint, a hat function.
        let own = (PI / self.image.height as f64).powi(2) / 6.0;
        let (mut xx, mut xy, mut yy, mut all) = (0.0, 0.0, 0.0, 0.0);
        for (texel, color) in texels {
            let (weight, direction) =
                (luminance(*color) * self.footprints.solid_angle(*texel), self.direction(*texel));
            let (x, y) = (direction.dot(x_axis), direction.dot(y_axis));
            all += weight;
            xx += weight * x * x;
            xy += weight * x * y;
            yy += weight * y * y;
        }
        let (xx, xy, yy) = (xx / all + own, xy / all, yy / all + own);
        // Eigenvalues of the matrix of second moments.
        let (mean, half_difference) = (0.5 * (xx + yy), (0.25 * (xx - yy).powi(2) + xy * xy).sqrt());
        ((mean + half_difference) / (mean - half_difference)).sqrt()
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::math::gauss_legendre;
    use crate::scene::{Sky, SkyLight, SkyPicture, Wrap};

    /// Radiance by direction, at the middles of texels.
    fn image([width, height]: [usize; 2], radiance: impl Fn(DVec3) -> Rgb) -> SkyPicture {
        let texel = |index: usize| {
            let place = DVec2::new((index % width) as f64, (index / width) as f64) + 0.5;
            let [r, g, b] =
                radiance(direction_of(place / DVec2::new(width as f64, height as f64))).as_vec3().to_array();
            [r, g, b, 1.0]
        };
        let texels = (0..width * height).map(texel).collect::<Vec<_>>().into();
        let wrap = [Wrap::Repeat, Wrap::Clamp];
        SkyPicture::Image(Texture { name: String::new(), width, height, texels, wrap })
    }

    fn apart(picture: SkyPicture) -> Sky {
        Sky::new(picture).unwrap().with_suns_apart()
    }

    fn suns(picture: SkyPicture) -> Vec<SkySun> {
        apart(picture).suns_at(0.0).collect()
    }

    /// A clear sky, brighter towards one direction.
    fn clear(direction: DVec3, to_sun: DVec3) -> Rgb {
        let glow = (4.0 * (direction.dot(to_sun) - 1.0)).exp();
        Rgb::new(0.2, 0.3, 0.5) + 2.0 * glow * Rgb::new(1.0, 0.9, 0.7) - 0.1 * direction.y
    }

    fn disc(direction: DVec3, to_sun: DVec3, diameter_deg: f64) -> bool {
        direction.angle_between(to_sun) < (0.5 * diameter_deg).to_radians()
    }

    /// Vector irradiance by channel of what is not beside suns, as the program looks both up: by a rule
    /// on each quarter of a texel, on which look-ups are bilinear.
    fn taken_out(sky: &Sky, [width, height]: [usize; 2], to_sun: DVec3) -> [DVec3; 3] {
        let mut sums = [DVec3::ZERO; 3];
        let (columns, rows) = (2 * width, 2 * height);
        let part = |index: usize, node: f64, count: usize| (index as f64 + 0.5 + 0.5 * node) / count as f64;
        for (row, column) in (0..rows).flat_map(|row| (0..columns).map(move |column| (row, column))) {
            let middle = direction_of(DVec2::new(part(column, 0.0, columns), part(row, 0.0, rows)));
            if middle.dot(to_sun) < 0.95 {
                continue;
            }
            for (x, of_x) in gauss_legendre(3) {
                for (y, of_y) in gauss_legendre(3) {
                    let place = DVec2::new(part(column, *x, columns), part(row, *y, rows));
                    let direction = direction_of(place);
                    let area = 0.25 * of_x * of_y * 2.0 * PI * PI / (columns * rows) as f64;
                    let taken = sky.along(direction) - sky.along_beside_suns(direction);
                    for (sum, radiance) in sums.iter_mut().zip(taken.to_array()) {
                        *sum += radiance * area * (PI * place.y).sin() * direction;
                    }
                }
            }
        }
        sums
    }

    /// From one texel to hundreds, across the seam and on the poles.
    #[test]
    fn a_sun_gives_the_irradiance_that_the_picture_loses() {
        let places = [
            (DVec3::new(0.35, 0.42, -0.84), 1.2),
            (DVec3::new(0.002, 0.3, 1.0), 2.0),
            (DVec3::new(0.01, 1.0, 0.004), 2.4),
            (DVec3::new(0.0, -1.0, 0.0), 1.5),
            (DVec3::new(-1.0, 0.1, 0.2), 0.53),
            (DVec3::new(0.2, 0.9, 0.1), 4.5),
        ];
        for size in [[360, 180], [720, 360]] {
            for (to_sun, diameter_deg) in places {
                // At least one texel's middle is within.
                let (to_sun, diameter_deg) =
                    (to_sun.normalize(), f64::max(diameter_deg, 270.0 / size[1] as f64));
                let color = 2e4 * Rgb::new(1.0, 0.8, 0.5);
                let sky = apart(image(size, |direction| {
                    clear(direction, to_sun)
                        + if disc(direction, to_sun, diameter_deg) { color } else { Rgb::ZERO }
                }));
                let what = format!("{to_sun}, {diameter_deg} deg, {size:?}");
                let suns: Vec<_> = sky.suns_at(0.0).collect();
                let [sun] = suns[..] else { panic!("{what}: {suns:?}") };
                for (channel, taken) in taken_out(&sky, size, to_sun).into_iter().enumerate() {
                    let given = sun.irradiance[channel] * sun.to_sun;
                    assert!((given - taken).length() < 1e-4 * taken.length(), "{what}: {given} {taken}");
                }
                let texel_deg = 180.0 / size[1] as f64;
                let off_deg = sun.to_sun.angle_between(to_sun).to_degrees();
                assert!(off_deg < 0.5 * texel_deg, "{what}: {off_deg} deg away");
                let wider_deg = sun.angular_diameter.to_degrees() - diameter_deg;
                assert!(wider_deg.abs() < 0.8 * texel_deg, "{what}: {wider_deg} deg wider");
                assert!(!sky.has_sun(), "{what}");
            }
        }
    }

    #[test]
    fn what_is_wide_or_long_or_dim_is_no_sun() {
        let size = [512, 256];
        let to_light = DVec3::new(0.3, 0.5, -0.8).normalize();
        let (x, y) = to_light.any_orthonormal_pair();
        // A rectangle of so many degrees across, so many times as bright as an even sky.
        let rectangle = |wide_deg: f64, high_deg: f64, times: f64| {
            image(size, |direction| {
                let within =
                    |axis: DVec3, deg: f64| direction.dot(axis).abs() < (0.5 * deg).to_radians().sin();
                let is_in = direction.dot(to_light) > 0.0 && within(x, wide_deg) && within(y, high_deg);
                Rgb::splat(if is_in { times } else { 1.0 })
            })
        };
        let skies = [
            ("a gradient", image(size, |direction| Rgb::splat(1.0 + direction.y))),
            ("a clear sky", image(size, |direction| clear(direction, to_light))),
            (
                "a horizon",
                image(size, |direction| Rgb::splat(0.01 + 50.0 * (-200.0 * direction.y.powi(2)).exp())),
            ),
            ("a bright cloud", rectangle(6.0, 4.0, 12.0)),
            ("a softbox", rectangle(20.0, 20.0, 300.0)),
            ("a window", rectangle(8.0, 12.0, 100.0)),
            ("a strip", rectangle(0.8, 4.5, 1000.0)),
            ("a star", rectangle(0.8, 0.8, 100.0)),
            (
                "a sun that is cut off at 1",
                image(
                    size,
                    |direction| {
                        if disc(direction, to_light, 1.5) { Rgb::ONE } else { Rgb::splat(0.4) }
                    },
                ),
            ),
        ];
        for (what, sky) in skies {
            assert_eq!(suns(sky), [], "{what}");
        }
        assert_eq!(suns(rectangle(2.0, 2.0, 1000.0)).len(), 1, "a lamp");
    }

    /// Two suns stay two, even where a texel is brighter than both and gives nothing.
    #[test]
    fn two_suns_are_two() {
        let (first, second) = (DVec3::new(0.5, 0.4, 0.3).normalize(), DVec3::new(-0.5, 0.2, 0.1).normalize());
        let SkyPicture::Image(mut texture) = image([1024, 512], |direction| {
            let of_first = if disc(direction, first, 1.0) { 1e4 } else { 0.0 };
            let of_second = if disc(direction, second, 2.0) { 400.0 } else { 0.0 };
            Rgb::splat(0.3 + of_first + of_second)
        }) else {
            unreachable!("it is an image")
        };
        let mut texels = texture.texels.into_floats();
        texels[5 * 1024 + 700] = [3e4, 3e4, 3e4, 1.0];
        texture.texels = texels.into();
        let found = suns(SkyPicture::Image(texture));
        let far_deg: Vec<f64> = found
            .iter()
            .zip([first, second])
            .map(|(sun, expected)| sun.to_sun.angle_between(expected).to_degrees())
            .collect();
        assert!(found.len() == 2 && far_deg.iter().all(|far| *far < 0.2), "{far_deg:?} {found:?}");
    }

    /// A glow around a sun is a part of it while it is bright, and its disc is as wide as the core.
    #[test]
    fn a_glow_does_not_make_a_sun_wide() {
        let to_sun = DVec3::new(0.1, 0.5, -0.6).normalize();
        let sky = apart(image([2048, 1024], |direction| {
            let away_deg = direction.angle_between(to_sun).to_degrees();
            Rgb::splat(1.0 + 2e4 / (1.0 + (away_deg / 0.3).powi(4)))
        }));
        let suns: Vec<_> = sky.suns_at(0.0).collect();
        assert_eq!(suns.len(), 1);
        let diameter_deg = suns[0].angular_diameter.to_degrees();
        assert!((0.5..1.1).contains(&diameter_deg), "{diameter_deg}");
        assert!(!sky.has_sun());
    }

    #[test]
    fn a_sun_turns_with_its_sky_and_is_as_strong() {
        let picture =
            image([512, 256], |direction| Rgb::splat(if disc(direction, DVec3::Z, 2.0) { 1e4 } else { 1.0 }));
        let sky = Sky::new(picture).unwrap();
        let strength = Rgb::new(1.0, 2.0, 0.0);
        let turned = sky.clone().with(strength.into(), 0.5.into(), SkyLight::default());
        let still = sky.clone().with_suns_apart().suns_at(0.0).next().unwrap();
        let sun = turned.with_suns_apart().suns_at(0.0).next().unwrap();
        // Anticlockwise from above +z goes towards +x.
        assert!(sun.to_sun.angle_between(DVec3::new(0.5_f64.sin(), 0.0, 0.5_f64.cos())) < 1e-3);
        assert!((sun.irradiance - strength * still.irradiance).length() < 1e-12);
        for lights in [SkyLight::Nothing, SkyLight::Surfaces] {
            let sky = sky.clone().with(Rgb::ONE.into(), 0.0.into(), lights).with_suns_apart();
            assert_eq!(sky.suns_apart(), 0, "{lights:?}");
        }
    }
}
