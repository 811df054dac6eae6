//! One half plane through camera and light, and its line in the picture. In goes a position along that line,
//! by length, area or slope, out come places and directions. Invariant: lengths and areas grow away from the
//! light, slopes fall.

use super::picture::Picture;
use glam::{DVec2, DVec3};
use std::cmp::Ordering;
use std::f64::consts::PI;

/// Minimum angle between a ray and the axis, radians: directions in double precision resolve no less.
pub(super) const LEAST_SPREAD: f64 = 1e-15;

/// Range of angles from the axis, radians in `0..=pi`, within which slices lie.
#[derive(Clone, Copy, Debug)]
pub struct Ring(pub f64, pub f64);

impl Ring {
    /// No limits.
    pub const WHOLE: Self = Self(0.0, PI);
}

/// One slice: a half plane and the part of its image that lies in the picture.
#[derive(Clone, Copy, Debug)]
pub struct Slice {
    /// Unit vector at right angles to the axis.
    pub outward: DVec3,
    /// Point of the line in the image plane, and its unit direction, away from the light's image.
    start: DVec2,
    along: DVec2,
    pub(super) length: f64,
    /// Components of its rays along the outward direction and along the axis: at the start, and the growth
    /// per unit of length.
    reach: (f64, f64),
    height: (f64, f64),
    /// Picture area per radian of rotation and unit of length, pixels^2: at the start, and its
    /// growth per unit of length.
    density: (f64, f64),
    /// Picture area per radian of rotation, pixels^2.
    pub area_per_rad: f64,
    picture: Picture,
}

/// Place of a sample in the picture.
#[derive(Clone, Copy, Debug)]
pub struct Place {
    /// Pixels of the full picture, y downwards.
    pub film_px: DVec2,
    /// Unit direction of its ray.
    pub direction: DVec3,
}

/// Line in the image plane of a half plane and its opposite, directed away from the light.
struct ImageLine {
    /// The point nearest to the centre of the image plane.
    foot: DVec2,
    /// Unit direction.
    along: DVec2,
    /// Components of its directions along the outward direction and along the axis: at the foot, and the
    /// growth per unit of length.
    reach: (f64, f64),
    height: (f64, f64),
    /// Component of the half plane's normal in the image plane.
    steepness: f64,
}

impl ImageLine {
    /// Line of a half plane, given the unit vectors outwards and normal to it; `None` if it is parallel to
    /// the image plane.
    fn new(picture: &Picture, axis: DVec3, [outward, normal]: [DVec3; 2]) -> Option<Self> {
        // normal . (x right + y up + forward) = 0.
        let across = DVec2::new(normal.dot(picture.right), normal.dot(picture.up));
        let steepness = across.length();
        let across = across.try_normalize()?;
        let foot = -normal.dot(picture.forward) / steepness * across;
        let along = across.perp();
        let components = |v: DVec3| (v.dot(picture.direction(foot)), v.dot(picture.vector(along)));
        let (height, reach) = (components(axis), components(outward));
        // Away from the light the slope, axis / outward, falls.
        let rises = height.1 * reach.0 - height.0 * reach.1 > 0.0;
        let sign = if rises { -1.0 } else { 1.0 };
        let [reach, height] = [reach, height].map(|(at_foot, growth)| (at_foot, sign * growth));
        Some(Self { foot, along: sign * along, reach, height, steepness })
    }

    /// Start and end in the picture, on this side of the axis and within a ring; `None` if no part lies
    /// there.
    fn part_in(&self, picture: &Picture, ring: Ring) -> Option<(f64, f64)> {
        let (mut from, mut to) = (f64::NEG_INFINITY, f64::INFINITY);
        let mut keep = |value: f64, growth: f64| {
            if growth > 0.0 {
                from = from.max(-value / growth);
            } else if growth < 0.0 {
                to = to.min(-value / growth);
            } else if value < 0.0 {
                to = f64::NEG_INFINITY;
            }
        };
        for i in 0..2 {
            keep(self.foot[i] - picture.low[i], self.along[i]);
            keep(picture.high[i] - self.foot[i], -self.along[i]);
        }
        let (reach, height) = (self.reach, self.height);
        keep(reach.0, reach.1);
        // At an angle from the axis, `outward cos - axis sin` grows through 0.
        for (angle, sign) in [(ring.0, 1.0), (ring.1, -1.0)] {
            let (sin, cos) = angle.sin_cos();
            keep(sign * (reach.0 * cos - height.0 * sin), sign * (reach.1 * cos - height.1 * sin));
        }
        // Not a number where the camera looks along the half plane.
        (from.partial_cmp(&to) == Some(Ordering::Less)).then_some((from, to))
    }
}

impl Slice {
    /// Slice of a half plane within a ring, given the unit vectors outwards and normal to it; `None` if it
    /// misses the picture there.
    pub(super) fn new(
        picture: Picture,
        axis: DVec3,
        [outward, normal]: [DVec3; 2],
        ring: Ring,
    ) -> Option<Self> {
        let line = ImageLine::new(&picture, axis, [outward, normal])?;
        let (from, to) = line.part_in(&picture, ring)?;
        let scale = picture.pixels_per_unit * picture.pixels_per_unit / line.steepness;
        let from_start = |(at_foot, growth): (f64, f64)| (at_foot + growth * from, growth);
        let reach = from_start(line.reach);
        let density = (reach.0.max(0.0) * scale, reach.1 * scale);
        let length = to - from;
        let area_per_rad = length * (density.0 + 0.5 * density.1 * length);
        (area_per_rad > 0.0).then_some(Self {
            outward,
            start: line.foot + from * line.along,
            along: line.along,
            length,
            reach,
            height: from_start(line.height),
            density,
            area_per_rad,
            picture,
        })
    }

    /// Length in the picture, pixels.
    pub(super) fn length_px(&self) -> f64 {
        self.length * self.picture.pixels_per_unit
    }

    /// Place at which the slice has passed so much of its [`Slice::area_per_rad`].
    pub fn place(&self, area_per_rad: f64) -> Place {
        let point = self.point(area_per_rad);
        Place { film_px: self.picture.film_px(point), direction: self.picture.direction(point).normalize() }
    }

    /// Distance to a slice that is rotated by one radian, pixels, at the given area per radian.
    pub fn separation_px_per_rad_at(&self, area_per_rad: f64) -> f64 {
        self.separation_px_per_rad(self.length_at(area_per_rad))
    }

    /// Maximum distance to such a slice.
    pub fn greatest_separation_px_per_rad(&self) -> f64 {
        self.separation_px_per_rad(0.0).max(self.separation_px_per_rad(self.length))
    }

    fn separation_px_per_rad(&self, passed: f64) -> f64 {
        let (density, growth) = self.density;
        (density + growth * passed) / self.picture.pixels_per_unit
    }

    /// Slope of the ray after a length of the slice.
    pub(super) fn slope_at(&self, passed: f64) -> f64 {
        // Rounding must not put a ray along the axis on its other side.
        let reach = (self.reach.0 + passed * self.reach.1).max(LEAST_SPREAD);
        (self.height.0 + passed * self.height.1) / reach
    }

    /// Area per radian that the slice has passed at the ray of a slope: component along the axis over outward
    /// component.
    pub(super) fn area_at_slope(&self, slope: f64) -> f64 {
        self.area_at(self.length_at_slope(slope))
    }

    /// Length of the slice at which its rays have a slope, to rounding.
    pub(super) fn length_at_slope(&self, slope: f64) -> f64 {
        let passed = (self.height.0 - slope * self.reach.0) / (slope * self.reach.1 - self.height.1);
        // Not a number only if all its rays have that slope.
        passed.max(0.0).min(self.length)
    }

    /// Length of so many pixels.
    pub(super) fn length_of_px(&self, px: f64) -> f64 {
        px / self.picture.pixels_per_unit
    }

    /// Area per radian that the slice has passed after a length.
    pub(super) fn area_at(&self, length: f64) -> f64 {
        let (density, growth) = self.density;
        length * (density + 0.5 * growth * length)
    }

    /// Start on the film, and the step for each unit of length, pixels.
    pub(super) fn line_px(&self) -> (DVec2, DVec2) {
        let along = DVec2::new(self.along.x, -self.along.y) * self.picture.pixels_per_unit;
        (self.picture.film_px(self.start), along)
    }

    /// Point in the image plane.
    fn point(&self, area_per_rad: f64) -> DVec2 {
        self.start + self.length_at(area_per_rad) * self.along
    }

    /// Length after which the slice has passed an area per radian.
    pub(super) fn length_at(&self, area_per_rad: f64) -> f64 {
        let (density, growth) = self.density;
        // density x + growth x^2 / 2 = area, in the form that does not cancel.
        let root = (density * density + 2.0 * growth * area_per_rad).max(0.0).sqrt();
        // 0 / 0 on the axis itself: the maximum with 0 is then 0.
        (2.0 * area_per_rad / (density + root)).max(0.0).min(self.length)
    }
}
