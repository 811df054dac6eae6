//! The half planes through camera and light, and the lines that they are in the picture. In goes
//! an angle about the axis, out come directions and areas. Invariant: the density of a slice's
//! samples is uniform over the picture's area, wherever the light's image (the epipole) lies: in the
//! picture, beside it, behind the camera or at infinity.

use crate::light::LightPlace;
use crate::scene::{Size, Window};
use crate::snapshot::View;
use glam::{DVec2, DVec3};
use std::cmp::Ordering;
use std::f64::consts::{PI, TAU};

/// No ray counts as nearer to the axis than this, in radians: directions in double precision do not say more.
pub(super) const LEAST_SPREAD: f64 = 1e-15;

/// All slices between one point of the lens and one light.
#[derive(Clone, Copy, Debug)]
pub struct Fan {
    /// The point of the lens, in relative space.
    pub eye: DVec3,
    /// Unit vector from there to the light.
    pub axis: DVec3,
    /// Unit vectors at right angles to the axis: the half planes at angle 0 and a quarter turn.
    zero: DVec3,
    quarter: DVec3,
    picture: Picture,
    /// First angle and how many radians, so that every half plane that meets the picture is there.
    pub angles: (f64, f64),
}

/// Between which angles from the axis, radians in `0..=pi`, slices are wanted.
#[derive(Clone, Copy, Debug)]
pub struct Ring(pub f64, pub f64);

impl Ring {
    /// No limits.
    pub const WHOLE: Self = Self(0.0, PI);
}

/// How far apart two slices that differ by one radian lie, pixels.
#[derive(Clone, Copy, Debug)]
pub struct Separation {
    /// On average; 0 where there is no slice.
    pub mean_px: f64,
    /// At most.
    pub greatest_px: f64,
    /// How much of the picture this is of, pixels.
    pub area_px: f64,
}

/// The image plane at distance 1 from a point of the lens, and the picture in it.
#[derive(Clone, Copy, Debug)]
struct Picture {
    right: DVec3,
    up: DVec3,
    forward: DVec3,
    /// Pixels per unit of the image plane.
    pixels_per_unit: f64,
    /// Film pixel (0, 0)'s corner in the image plane.
    corner: DVec2,
    low: DVec2,
    high: DVec2,
}

/// One slice: a half plane and the part of its image that lies in the picture.
#[derive(Clone, Copy, Debug)]
pub struct Slice {
    /// Unit vector at right angles to the axis.
    pub outward: DVec3,
    /// In the image plane: a point of the line, and its unit direction, away from the light's image.
    start: DVec2,
    along: DVec2,
    pub(super) length: f64,
    /// What its rays have of the outward direction and of the axis: at the start, and the growth per unit of length.
    reach: (f64, f64),
    height: (f64, f64),
    /// Picture area per radian of turn and unit of length, pixels^2: at the start, and its growth per unit of length.
    density: (f64, f64),
    /// Picture area per radian of turn, pixels^2.
    pub area_per_rad: f64,
    picture: Picture,
}

impl Fan {
    /// The slices of a light over the whole picture, seen from a point of the lens (metres to the
    /// right and up from its middle); `None` if the light is there.
    pub fn new(view: &View, size: Size, lens_point: DVec2, light: LightPlace) -> Option<Self> {
        let picture = Picture::new(view, size, lens_point);
        let eye = picture.vector(lens_point);
        let axis = match light {
            LightPlace::Towards(to_light) => to_light,
            LightPlace::At(position) => (position - eye).try_normalize()?,
        };
        let zero = axis.any_orthonormal_vector();
        let quarter = axis.cross(zero);
        let mut fan = Self { eye, axis, zero, quarter, picture, angles: (0.0, TAU) };
        fan.angles = fan.angles_between(picture.low, picture.high);
        Some(fan)
    }

    /// The angles of all slices that meet some pixels: the first, and how many radians.
    pub fn angles_across(&self, pixels: Window) -> (f64, f64) {
        let (low, high) = self.corners_of(pixels);
        self.angles_between(low, high)
    }

    /// Least and greatest angle from the axis of those pixels, or a little less and more.
    pub fn extent_of(&self, pixels: Window) -> (f64, f64) {
        let (low, high) = self.corners_of(pixels);
        let picture = Picture { low, high, ..self.picture };
        let middle = picture.direction(0.5 * (low + high));
        let reach = picture.corners().map(|corner| picture.direction(corner).angle_between(middle));
        let (from_axis, reach) = (middle.angle_between(self.axis), reach.into_iter().fold(0.0, f64::max));
        (from_axis - reach, from_axis + reach)
    }

    /// The rectangle of the image plane that pixels are.
    fn corners_of(&self, pixels: Window) -> (DVec2, DVec2) {
        let [x, y] = [(pixels.x, pixels.width), (pixels.y, pixels.height)]
            .map(|(from, count)| [from, from + count].map(|px| px as f64 / self.picture.pixels_per_unit));
        let corner = self.picture.corner;
        (corner + DVec2::new(x[0], -y[1]), corner + DVec2::new(x[1], -y[0]))
    }

    /// The angles of all slices that meet a rectangle of the image plane.
    fn angles_between(&self, low: DVec2, high: DVec2) -> (f64, f64) {
        let picture = Picture { low, high, ..self.picture };
        if picture.sees(self.axis) || picture.sees(-self.axis) {
            return (0.0, TAU);
        }
        // A convex rectangle that does not hold the axis is seen from it under less than half a turn.
        let middle = self.angle(picture.direction(0.5 * (low + high)));
        let turns = picture.corners().map(|corner| {
            let turn = self.angle(picture.direction(corner)) - middle;
            turn - TAU * (turn / TAU).round()
        });
        let low = turns.into_iter().fold(PI, f64::min);
        let high = turns.into_iter().fold(-PI, f64::max);
        (middle + low, high - low)
    }

    /// Least and greatest angle between the axis and what the picture shows.
    pub fn extent(&self) -> (f64, f64) {
        self.picture.angles_from(self.axis)
    }

    /// How far from this fan's axis another's appears to be in the picture, radians.
    pub fn deviation(&self, other: &Self) -> f64 {
        self.picture.reframed(&other.picture, other.axis).angle_between(self.axis)
    }

    /// The angle of this fan's slice that passes through a place of the picture, and how many radians
    /// it turns for each that the place turns. The place lies in another fan over the same picture, on
    /// its slice at `angle`, `from_axis` radians from its axis.
    pub fn angle_through(&self, other: &Self, angle: f64, from_axis: f64) -> (f64, f64) {
        let ((sin, cos), (far, near)) = (angle.sin_cos(), from_axis.sin_cos());
        let place = near * other.axis + far * (cos * other.zero + sin * other.quarter);
        let change = far * (cos * other.quarter - sin * other.zero);
        let [place, change] = [place, change].map(|v| self.picture.reframed(&other.picture, v));
        let components = |v: DVec3| DVec2::new(v.dot(self.zero), v.dot(self.quarter));
        let (place, change) = (components(place), components(change));
        (place.y.atan2(place.x), place.perp_dot(change) / place.length_squared())
    }

    /// How far apart slices lie in the part of the picture in a ring.
    pub fn separation(&self, ring: Ring) -> Separation {
        // Area per radian over length, found from a few slices.
        let probes = 64;
        let (mut area_per_rad, mut length_px, mut greatest_px) = (0.0, 0.0, 0.0_f64);
        for probe in 0..probes {
            let angle = self.angles.0 + self.angles.1 * (f64::from(probe) + 0.5) / f64::from(probes);
            if let Some(slice) = self.slice(angle, ring) {
                area_per_rad += slice.area_per_rad;
                length_px += slice.length * self.picture.pixels_per_unit;
                let (density, growth) = slice.density;
                let widest = density.max(density + growth * slice.length);
                greatest_px = greatest_px.max(widest / self.picture.pixels_per_unit);
            }
        }
        let mean_px = if length_px > 0.0 { area_per_rad / length_px } else { 0.0 };
        Separation { mean_px, greatest_px, area_px: self.angles.1 * area_per_rad / f64::from(probes) }
    }

    /// Pixels to a radian in the middle of a picture that the camera looks straight at.
    pub fn px_per_rad(&self) -> f64 {
        self.picture.pixels_per_unit
    }

    /// The slice at an angle, as far as it lies in a ring; `None` if it misses the picture there.
    pub fn slice(&self, angle: f64, ring: Ring) -> Option<Slice> {
        let (sin, cos) = angle.sin_cos();
        let outward = cos * self.zero + sin * self.quarter;
        let normal = cos * self.quarter - sin * self.zero;
        let picture = self.picture;
        // The image line: normal . (x right + y up + forward) = 0.
        let across = DVec2::new(normal.dot(picture.right), normal.dot(picture.up));
        let steepness = across.length();
        let across = across.try_normalize()?;
        let foot = -normal.dot(picture.forward) / steepness * across;
        let mut along = across.perp();
        // Away from the light: the slope axis / outward falls along the line.
        let components = |v: DVec3| (v.dot(picture.direction(foot)), v.dot(picture.vector(along)));
        let (a0, mut a1) = components(self.axis);
        let (o0, mut o1) = components(outward);
        if a1 * o0 - a0 * o1 > 0.0 {
            (along, a1, o1) = (-along, -a1, -o1);
        }
        // The part within the picture and on this side of the axis.
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
            keep(foot[i] - picture.low[i], along[i]);
            keep(picture.high[i] - foot[i], -along[i]);
        }
        keep(o0, o1);
        // At an angle from the axis, `outward cos - axis sin` grows through 0.
        for (angle, sign) in [(ring.0, 1.0), (ring.1, -1.0)] {
            let (sin, cos) = angle.sin_cos();
            keep(sign * (o0 * cos - a0 * sin), sign * (o1 * cos - a1 * sin));
        }
        // Not a number where the camera stares along the slice's edge.
        if from.partial_cmp(&to) != Some(Ordering::Less) {
            return None;
        }
        let scale = picture.pixels_per_unit * picture.pixels_per_unit / steepness;
        let density = ((o0 + o1 * from).max(0.0) * scale, o1 * scale);
        let length = to - from;
        let area_per_rad = length * (density.0 + 0.5 * density.1 * length);
        let start = foot + from * along;
        (area_per_rad > 0.0).then_some(Slice {
            outward,
            start,
            along,
            length,
            reach: (o0 + o1 * from, o1),
            height: (a0 + a1 * from, a1),
            density,
            area_per_rad,
            picture,
        })
    }

    fn angle(&self, direction: DVec3) -> f64 {
        direction.dot(self.quarter).atan2(direction.dot(self.zero))
    }
}

impl Slice {
    /// The place at which the slice has passed so much of its [`Slice::area_per_rad`].
    pub fn place(&self, area_per_rad: f64) -> Place {
        let point = self.point(area_per_rad);
        Place { film_px: self.picture.film_px(point), direction: self.picture.direction(point).normalize() }
    }

    /// How far away a slice lies that is turned by one radian, pixels, where this one has passed so much of its area per radian.
    pub fn separation_px_per_rad_at(&self, area_per_rad: f64) -> f64 {
        self.separation_px_per_rad(self.length_at(area_per_rad))
    }

    /// How far away such a slice lies at most.
    pub fn greatest_separation_px_per_rad(&self) -> f64 {
        self.separation_px_per_rad(0.0).max(self.separation_px_per_rad(self.length))
    }

    fn separation_px_per_rad(&self, passed: f64) -> f64 {
        let (density, growth) = self.density;
        (density + growth * passed) / self.picture.pixels_per_unit
    }

    /// The slope of the ray after a length of the slice.
    pub(super) fn slope_at(&self, passed: f64) -> f64 {
        // Rounding must not put a ray along the axis on the other side of it.
        let reach = (self.reach.0 + passed * self.reach.1).max(LEAST_SPREAD);
        (self.height.0 + passed * self.height.1) / reach
    }

    /// How much of its area the slice has passed, per radian, where its rays have a slope: of those of its axis by those outward.
    pub(super) fn area_at_slope(&self, slope: f64) -> f64 {
        self.area_at(self.length_at_slope(slope))
    }

    /// After which length of the slice its rays have a slope, or nearly.
    pub(super) fn length_at_slope(&self, slope: f64) -> f64 {
        let passed = (self.height.0 - slope * self.reach.0) / (slope * self.reach.1 - self.height.1);
        // Not a number only if all its rays have that slope.
        passed.max(0.0).min(self.length)
    }

    /// So many pixels in the unit of its length.
    pub(super) fn length_of_px(&self, px: f64) -> f64 {
        px / self.picture.pixels_per_unit
    }

    /// How much of its area the slice has passed, per radian, after a length of it.
    pub(super) fn area_at(&self, length: f64) -> f64 {
        let (density, growth) = self.density;
        length * (density + 0.5 * growth * length)
    }

    /// Where it begins on the film, and how far it leads there for each unit of length, pixels.
    pub(super) fn line_px(&self) -> (DVec2, DVec2) {
        let along = DVec2::new(self.along.x, -self.along.y) * self.picture.pixels_per_unit;
        (self.picture.film_px(self.start), along)
    }

    /// In the image plane.
    fn point(&self, area_per_rad: f64) -> DVec2 {
        self.start + self.length_at(area_per_rad) * self.along
    }

    /// After which length the slice has passed so much of its area per radian.
    pub(super) fn length_at(&self, area_per_rad: f64) -> f64 {
        let (density, growth) = self.density;
        // density x + growth x^2 / 2 = area, in the form that does not cancel.
        let root = (density * density + 2.0 * growth * area_per_rad).max(0.0).sqrt();
        // 0 / 0 on the axis itself: the maximum with 0 takes what is a number.
        (2.0 * area_per_rad / (density + root)).max(0.0).min(self.length)
    }
}

/// Where a sample lies in the picture.
#[derive(Clone, Copy, Debug)]
pub struct Place {
    /// In pixels of the full picture, y downwards.
    pub film_px: DVec2,
    /// Unit direction of its ray.
    pub direction: DVec3,
}

/// The pixel that a place of the film lies in; the picture's far edges belong to the last pixels.
pub fn pixel(film_px: DVec2, size: Size) -> (usize, usize) {
    let index = |coordinate: f64, count: usize| (coordinate.max(0.0) as usize).min(count - 1);
    (index(film_px.x, size.width), index(film_px.y, size.height))
}

impl Picture {
    fn new(view: &View, size: Size, lens_point: DVec2) -> Self {
        let (right, up, forward) = view.axes();
        let half = view.half_extents();
        let pixels_per_unit = size.width as f64 / (2.0 * half.x);
        // What is in focus stays in its pixel: the picture shifts against the lens.
        let shift = view.middle() - lens_point / view.focus_distance_m();
        let corner = shift + DVec2::new(-half.x, half.y);
        Self { right, up, forward, pixels_per_unit, corner, low: shift - half, high: shift + half }
    }

    /// A point of the image plane in pixels, y downwards.
    fn film_px(&self, point: DVec2) -> DVec2 {
        let film = (point - self.corner) * self.pixels_per_unit;
        DVec2::new(film.x, -film.y)
    }

    fn vector(&self, v: DVec2) -> DVec3 {
        v.x * self.right + v.y * self.up
    }

    /// Towards a point of the image plane; not of unit length.
    fn direction(&self, point: DVec2) -> DVec3 {
        self.vector(point) + self.forward
    }

    /// The direction that lies in this picture where `direction` lies in another of the same size;
    /// linear, so that it goes on beyond the picture and behind the camera.
    fn reframed(&self, other: &Self, direction: DVec3) -> DVec3 {
        let depth = direction.dot(other.forward);
        let point = DVec2::new(direction.dot(other.right), direction.dot(other.up)) - depth * other.corner;
        let scale = other.pixels_per_unit / self.pixels_per_unit;
        self.vector(scale * point + depth * self.corner) + depth * self.forward
    }

    /// Least and greatest angle between a direction and those of the picture.
    fn angles_from(&self, axis: DVec3) -> (f64, f64) {
        let steps = 32;
        let border = self.corners().into_iter().zip([1.0, -1.0, -1.0, 1.0]).zip([
            DVec2::X,
            DVec2::X,
            DVec2::Y,
            DVec2::Y,
        ]);
        let size = self.high - self.low;
        let points = border.flat_map(|((corner, sign), side)| {
            (0..=steps).map(move |step| corner + sign * f64::from(step) / f64::from(steps) * side * size)
        });
        let (mut least, mut greatest) = (PI, 0.0_f64);
        for point in points {
            let angle = self.direction(point).angle_between(axis);
            (least, greatest) = (least.min(angle), greatest.max(angle));
        }
        (if self.sees(axis) { 0.0 } else { least }, if self.sees(-axis) { PI } else { greatest })
    }

    fn corners(&self) -> [DVec2; 4] {
        let (low, high) = (self.low, self.high);
        [low, high, DVec2::new(low.x, high.y), DVec2::new(high.x, low.y)]
    }

    fn sees(&self, direction: DVec3) -> bool {
        let depth = direction.dot(self.forward);
        let point = DVec2::new(direction.dot(self.right), direction.dot(self.up)) / depth;
        depth > 0.0 && point.cmpge(self.low).all() && point.cmple(self.high).all()
    }
}

#[cfg(test)]
impl Fan {
    /// Of a light in a direction, unit length, seen by a pinhole that looks along -z, its picture so many radians high.
    pub(crate) fn of_pinhole(fov_y_rad: f64, size: Size, to_light: DVec3) -> Self {
        use crate::scene::{Camera, Clip, Lens, Track};
        let lens = Lens::Perspective { fov_y: Track::from(fov_y_rad) };
        let camera = Camera {
            name: String::new(),
            node: 0,
            lens,
            shift: DVec2::ZERO,
            aperture: None,
            clip: Clip::NONE,
        };
        let aspect = size.width as f64 / size.height as f64;
        let view = View::new(&camera, glam::DAffine3::IDENTITY, aspect, 0.0);
        Self::new(&view, size, DVec2::ZERO, LightPlace::Towards(to_light)).expect("not at the eye")
    }
}
