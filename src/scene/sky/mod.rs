//! The sky: radiance from infinitely far away, by direction. In go pictures and colours, out come the sky
//! that is seen and the sky that lights. Invariant: a picture is not black all over. What the camera sees of
//! it has the same light as what lights the scene, suns that became lights included.

mod footprint;
mod suns;
mod table;

use self::suns::SkySuns;
use self::table::{CELLS, table_of};
use super::{Texture, Track, Wrap};
use crate::color::{Rgb, Texels, luminance};
pub use crate::description::ron::SkyLight;
use crate::math::{SquareDistribution, sphere_from_square, square_from_sphere};
use glam::{DQuat, DVec2, DVec3, Vec2};
use rayon::prelude::*;
use std::f64::consts::{FRAC_1_PI, TAU};
use std::sync::OnceLock;

pub use self::suns::SkySun;

/// Sky at all times.
#[derive(Clone, Debug)]
pub struct Sky {
    picture: SkyPicture,
    /// Suns of the picture that became lights.
    suns: SkySuns,
    /// Distribution of the remaining light; `None` if it is uniform.
    table: Option<SquareDistribution>,
    /// Mean radiances, computed on first use.
    means: OnceLock<Vec<Rgb>>,
    /// Whether it contains a sun, computed on first use.
    has_sun: OnceLock<bool>,
    /// Factor on the picture.
    pub strength: Track<Rgb>,
    /// Rotation about +Y, anticlockwise from above, radians.
    pub rotation: Track<f64>,
    /// Contents of the scene that it lights.
    pub lights: SkyLight,
    /// Whether camera rays see it; mirrors always do.
    pub visible_to_camera: bool,
}

/// Picture of a sky, +Y up, radiance in W m^-2 sr^-1.
#[derive(Clone, Debug)]
pub enum SkyPicture {
    /// Uniform.
    Even(Rgb),
    /// Gradient from `horizon` to `zenith` in proportion to the sine of the elevation, and `ground` below.
    Gradient {
        /// Radiance at the zenith.
        zenith: Rgb,
        /// Radiance just above the horizon.
        horizon: Rgb,
        /// Radiance everywhere below it.
        ground: Rgb,
    },
    /// Equirectangular image, from inside, with -Z in the centre and +X to its right.
    Image(Texture),
}

/// Cells for means, uniform in height and in longitude, so that all have the same solid angle.
const MEAN_ROWS: usize = 64;
const MEAN_COLUMNS: usize = 32;
/// Magnitude of negative values to which lossy codecs (B44, DWA, JPEG 2000) may round black, for pictures
/// with values up to 1.
const ROUNDING: f32 = 1.0 / 4096.0;

/// Direction of a point in a cell, `[0, 1]^2`.
fn direction_in(cell: usize, within: DVec2) -> DVec3 {
    let y = 1.0 - 2.0 * ((cell / MEAN_COLUMNS) as f64 + within.y) / MEAN_ROWS as f64;
    let (sin, cos) = (TAU * ((cell % MEAN_COLUMNS) as f64 + within.x) / MEAN_COLUMNS as f64).sin_cos();
    let across = (1.0 - y * y).sqrt();
    DVec3::new(across * sin, y, -across * cos)
}

/// The cell that contains a direction.
fn cell_of(direction: DVec3) -> usize {
    let longitude = direction.x.atan2(-direction.z) / TAU;
    let place = |share: f64, count: usize| ((share * count as f64) as usize).min(count - 1);
    let row = place(0.5 * (1.0 - direction.y), MEAN_ROWS);
    row * MEAN_COLUMNS + place(longitude - longitude.floor(), MEAN_COLUMNS)
}

impl Sky {
    /// Sky that lights everything; `None` if it is black or not finite.
    pub fn new(picture: SkyPicture) -> Option<Self> {
        let suns = SkySuns::default();
        let table = table(&picture, &suns);
        match &picture {
            SkyPicture::Even(radiance) if radiance.max_element() > 0.0 && radiance.is_finite() => {}
            SkyPicture::Even(_) => return None,
            SkyPicture::Gradient { .. } | SkyPicture::Image(_) if table.is_none() => return None,
            SkyPicture::Gradient { .. } | SkyPicture::Image(_) => {}
        }
        let (strength, rotation) = (Track::from(Rgb::ONE), Track::from(0.0));
        let (means, has_sun, lights) = (OnceLock::new(), OnceLock::new(), SkyLight::default());
        let visible_to_camera = true;
        Some(Self { picture, suns, table, means, has_sun, strength, rotation, lights, visible_to_camera })
    }

    /// Sky whose suns become lights, with sharp shadows and no noise; its appearance stays. A sky that does
    /// not light fog keeps them, as suns would light it.
    #[must_use]
    pub fn with_suns_apart(self) -> Self {
        let suns = match &self.picture {
            SkyPicture::Image(image) if self.lights == SkyLight::SurfacesAndFog => SkySuns::of(image),
            _ => SkySuns::default(),
        };
        if suns.suns.is_empty() {
            return self;
        }
        let table = table(&self.picture, &suns);
        Self { suns, table, means: OnceLock::new(), has_sun: OnceLock::new(), ..self }
    }

    /// Sky with another strength, rotation and light.
    pub fn with(self, strength: Track<Rgb>, rotation: Track<f64>, lights: SkyLight) -> Self {
        Self { strength, rotation, lights, ..self }
    }

    /// Picture of the sky.
    pub fn picture(&self) -> &SkyPicture {
        &self.picture
    }

    /// Number of its suns that became lights.
    pub fn suns_apart(&self) -> usize {
        self.suns.suns.len()
    }

    /// Suns that became lights, at a time, with the picture's rotation and strength.
    pub fn suns_at(&self, time_s: f64) -> impl Iterator<Item = SkySun> {
        let (strength, turn) = (self.strength.at(time_s), DQuat::from_rotation_y(self.rotation.at(time_s)));
        self.suns.suns.iter().map(move |sun| SkySun {
            to_sun: turn * sun.to_sun,
            irradiance: strength * sun.irradiance,
            ..*sun
        })
    }

    /// Radiance in the direction of a unit vector, in the unrotated picture.
    pub fn along(&self, direction: DVec3) -> Rgb {
        self.picture.along(direction)
    }

    /// Radiance in a direction without the suns of [`Sky::suns_at`], in the unrotated picture.
    pub fn along_beside_suns(&self, direction: DVec3) -> Rgb {
        match &self.picture {
            SkyPicture::Image(image) => self.suns.beside(image, direction, place_of(direction)),
            picture => picture.along(direction),
        }
    }

    /// Whether it is constant.
    pub fn is_constant(&self) -> bool {
        self.strength.is_constant() && self.rotation.is_constant()
    }

    /// Whether its radiance varies, so that [`Sky::sample`] samples directions.
    pub fn is_uneven(&self) -> bool {
        self.table.is_some()
    }

    /// Whether a small part of it has much of its light, so that objects cast distinct shadows.
    pub fn has_sun(&self) -> bool {
        /// Radiance of a sun relative to the mean.
        const BRIGHT: f64 = 16.0;
        const MUCH: f64 = 0.05;
        *self.has_sun.get_or_init(|| {
            let Some(table) = &self.table else { return false };
            let densities = (0..CELLS * CELLS).map(|cell| table.density(cell));
            densities.filter(|density| *density > BRIGHT).sum::<f64>() > MUCH * (CELLS * CELLS) as f64
        })
    }

    /// Mean radiances of cells of equal solid angle, with the directions of their centres, in the unrotated
    /// picture.
    pub fn means(&self) -> impl Iterator<Item = (DVec3, Rgb)> {
        let means = self.cell_means().iter().enumerate();
        means.map(|(cell, mean)| (direction_in(cell, DVec2::splat(0.5)), *mean))
    }

    /// Mean radiance of the cell around a direction, in the unrotated picture.
    pub fn mean_around(&self, direction: DVec3) -> Rgb {
        self.cell_means()[cell_of(direction)]
    }

    fn cell_means(&self) -> &[Rgb] {
        self.means.get_or_init(|| {
            let cells = 0..MEAN_ROWS * MEAN_COLUMNS;
            cells.into_par_iter().map(|cell| self.mean(cell)).collect()
        })
    }

    /// Direction sampled by two uniform numbers, with a density about proportional to radiance; `None` for a
    /// uniform picture. Directions are those of the unrotated picture.
    pub fn sample(&self, u: DVec2) -> Option<DVec3> {
        let (_, place) = self.table.as_ref()?.sample(u);
        Some(sphere_from_square(place))
    }

    /// Probability density of [`Sky::sample`] in a direction, 1/sr; 0 if it samples none.
    pub fn pdf(&self, direction: DVec3) -> f64 {
        self.table
            .as_ref()
            .map_or(0.0, |table| 0.25 * FRAC_1_PI * table.density(table.cell(square_from_sphere(direction))))
    }

    /// Mean radiance of a cell; values that are not finite are ignored.
    fn mean(&self, cell: usize) -> Rgb {
        // For images about one sample a texel.
        let side = match &self.picture {
            SkyPicture::Even(radiance) => return *radiance,
            SkyPicture::Gradient { .. } => 8,
            SkyPicture::Image(image) => (2 * image.width / MEAN_COLUMNS).clamp(4, 128),
        };
        let along = |number: usize| {
            let within = (DVec2::new((number % side) as f64, (number / side) as f64) + 0.5) / side as f64;
            self.along_beside_suns(direction_in(cell, within))
        };
        let (sum, count) = (0..side * side)
            .map(along)
            .filter(|radiance| radiance.is_finite())
            .fold((Rgb::ZERO, 0.0), |(sum, count), radiance| (sum + radiance, count + 1.0));
        sum / f64::max(count, 1.0)
    }
}

impl SkyPicture {
    /// Sky from an equirectangular image, and the number of texels with radiances below 0 by more than lossy
    /// codecs cause. Filters cause them; all become 0.
    pub fn of_image(name: String, [width, height]: [usize; 2], texels: Texels) -> (Self, usize) {
        let mut texels = texels.into_floats();
        let brightest = texels.iter().flat_map(|texel| &texel[..3]).copied().fold(0.0, f32::max);
        let least = -ROUNDING * brightest.min(1.0);
        let is_negative = |texel: &&[f32; 4]| texel[..3].iter().any(|value| *value < least);
        let negative = texels.iter().filter(is_negative).count();
        texels.iter_mut().flatten().for_each(|value| *value = value.max(0.0));
        let wrap = [Wrap::Repeat, Wrap::Clamp];
        (Self::Image(Texture { name, width, height, texels: texels.into(), wrap }), negative)
    }

    /// Radiance in the direction of a unit vector.
    pub fn along(&self, direction: DVec3) -> Rgb {
        match self {
            Self::Even(radiance) => *radiance,
            Self::Gradient { ground, .. } if direction.y < 0.0 => *ground,
            Self::Gradient { zenith, horizon, .. } => horizon.lerp(*zenith, direction.y.min(1.0)),
            Self::Image(image) => image.color(place_of(direction)),
        }
    }
}

/// Distribution of a picture's light without suns; `None` if it is uniform or black.
fn table(picture: &SkyPicture, suns: &SkySuns) -> Option<SquareDistribution> {
    match picture {
        SkyPicture::Even(_) => None,
        SkyPicture::Gradient { .. } => {
            let place = |cell: usize| DVec2::new((cell % CELLS) as f64, (cell / CELLS) as f64) + 0.5;
            let bright = |cell| luminance(picture.along(sphere_from_square(place(cell) / CELLS as f64)));
            SquareDistribution::new(CELLS, (0..CELLS * CELLS).map(bright))
        }
        SkyPicture::Image(image) => table_of([image.width, image.height], |direction, place| {
            luminance(suns.beside(image, direction, place))
        }),
    }
}

/// Point of an equirectangular image in a direction, `[0, 1]^2` from its top left corner.
fn place_of(direction: DVec3) -> Vec2 {
    let across = 0.5 + direction.x.atan2(-direction.z) / TAU;
    let down = direction.y.clamp(-1.0, 1.0).acos() * FRAC_1_PI;
    Vec2::new(across as f32, down as f32)
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::table::direction_of;
    use super::*;
    use crate::math::Sampler;
    use crate::scene::Wrap;
    use std::f64::consts::PI;

    fn image(width: usize, height: usize, texel: impl Fn(usize, usize) -> f32) -> SkyPicture {
        let pixel = |index: usize| {
            let radiance = texel(index % width, index / width);
            [radiance, radiance, radiance, 1.0]
        };
        let texels = (0..width * height).map(pixel).collect();
        let wrap = [Wrap::Repeat, Wrap::Clamp];
        SkyPicture::Image(Texture { name: String::new(), width, height, texels, wrap })
    }

    #[test]
    fn light_below_0_is_told_from_what_lossy_codecs_leave() {
        for (value, expected) in [(-1.6e-5, 0), (-1e-3, 1)] {
            let texels: Vec<[f32; 4]> = vec![[1.26, 0.5, 0.2, 1.0], [value, 0.0, 0.1, 1.0]];
            let (picture, negative) = SkyPicture::of_image(String::new(), [2, 1], texels.into());
            assert_eq!(negative, expected);
            let SkyPicture::Image(texture) = picture else { panic!("an image") };
            assert_eq!(texture.texels.into_floats()[1], [0.0, 0.0, 0.1, 1.0]);
        }
    }

    /// Irradiance of a plane that faces up, by sampled directions.
    fn irradiance(sky: &Sky, count: u32) -> f64 {
        let sample = |sample| {
            let u = DVec2::from(Sampler::new(1, 0, 0, sample).next_2d());
            let direction = sky.sample(u).unwrap_or_else(|| sphere_from_square(u));
            let density = if sky.is_uneven() { sky.pdf(direction) } else { 0.25 * FRAC_1_PI };
            sky.picture.along(direction).x * direction.y.max(0.0) / density
        };
        (0..count).map(sample).sum::<f64>() / f64::from(count)
    }

    /// The integral of (h + (z - h) y) y over the upper half: pi (h + 2 z) / 3.
    #[test]
    fn a_gradient_lights_the_ground_as_its_integral_says() {
        let (zenith, horizon, ground) = (Rgb::splat(3.0), Rgb::splat(1.5), Rgb::splat(0.2));
        let sky = Sky::new(SkyPicture::Gradient { zenith, horizon, ground }).unwrap();
        let exact = PI * (1.5 + 2.0 * 3.0) / 3.0;
        let found = irradiance(&sky, 1 << 14);
        assert!((found / exact - 1.0).abs() < 1e-3, "{found} {exact}");
        assert_eq!(sky.picture.along(DVec3::NEG_Y), ground);
        assert_eq!(sky.picture.along(DVec3::Y), zenith);
        assert_eq!(sky.picture.along(DVec3::X), horizon);
    }

    /// Seen from within: -Z in the middle, +X to the right of it, +Y on top.
    #[test]
    fn an_image_is_seen_from_within() {
        let at = |picture: &SkyPicture, direction: DVec3| picture.along(direction.normalize()).x;
        let columns = image(64, 32, |column, _| column as f32);
        let west_to_east = [DVec3::new(-1.0, 0.0, -1.0), DVec3::NEG_Z, DVec3::new(1.0, 0.0, -1.0), DVec3::X];
        let found = west_to_east.map(|direction| at(&columns, direction) + 0.5);
        assert!(found.iter().zip([24.0, 32.0, 40.0, 48.0]).all(|(a, b)| (a - b).abs() < 1e-3), "{found:?}");
        let rows = image(64, 32, |_, row| row as f32);
        assert!((at(&rows, DVec3::new(0.0, 1.0, -1.0)) + 0.5 - 8.0).abs() < 1e-3);
        for sample in 0..1000 {
            let place = DVec2::from(Sampler::new(3, 0, 0, sample).next_2d());
            let there = direction_of(place);
            let back = DVec2::new(0.5 + there.x.atan2(-there.z) / TAU, there.y.acos() / PI);
            assert!(back.distance(place) < 1e-9, "{place} {back}");
        }
    }

    #[test]
    fn means_hold_all_of_the_light_and_a_sun_is_one() {
        let sun = (12, 4);
        for (brightest, has_sun) in [(1e4, true), (2.0, false)] {
            let sky = Sky::new(image(64, 32, |x, y| if (x, y) == sun { brightest } else { 1.0 })).unwrap();
            assert_eq!(sky.has_sun(), has_sun);
            let mean = sky.means().map(|(_, mean)| mean.x).sum::<f64>() / (MEAN_ROWS * MEAN_COLUMNS) as f64;
            // Of one texel of 64 x 32, whose sides are 2 pi / 64 and pi / 32.
            let down = PI * (sun.1 as f64 + 0.5) / 32.0;
            let share = (TAU / 64.0) * (PI / 32.0) * down.sin() / (4.0 * PI);
            let exact = 1.0 + (f64::from(brightest) - 1.0) * share;
            assert!((mean / exact - 1.0).abs() < 0.02, "{mean} {exact}");
        }
    }

    /// A sun of one texel, ten thousand times as bright as the sky around: sampling finds it.
    #[test]
    fn small_suns_are_found() {
        for (width, height) in [(32, 16), (512, 256)] {
            let sun = (3 * width / 8, height / 4);
            let sky = Sky::new(image(width, height, |x, y| if (x, y) == sun { 1e4 } else { 1.0 })).unwrap();
            let found = irradiance(&sky, 1 << 13);
            // By the midpoint rule, over more places than the table's own.
            let (mut exact, columns, rows) = (0.0, 4096, 2048);
            for (row, column) in (0..rows).flat_map(|row| (0..columns).map(move |column| (row, column))) {
                let place = DVec2::new(f64::from(column) + 0.5, f64::from(row) + 0.5);
                let place = place / DVec2::new(f64::from(columns), f64::from(rows));
                let direction = direction_of(place);
                let solid_angle = 2.0 * PI * PI / f64::from(columns * rows) * (PI * place.y).sin();
                exact += solid_angle * sky.picture.along(direction).x * direction.y.max(0.0);
            }
            assert!((found / exact - 1.0).abs() < 5e-3, "{width}: {found} {exact}");
        }
    }

    #[test]
    fn black_skies_are_none() {
        assert!(Sky::new(SkyPicture::Even(Rgb::ZERO)).is_none());
        assert!(Sky::new(image(4, 2, |_, _| 0.0)).is_none());
        assert!(Sky::new(image(4, 2, |_, _| f32::INFINITY)).is_none());
        let black = Rgb::ZERO;
        assert!(Sky::new(SkyPicture::Gradient { zenith: black, horizon: black, ground: black }).is_none());
    }
}
