//! Fan: the half planes through camera and light, and their lines in the picture. In goes an angle about the
//! axis, out come directions and areas. Invariant: the density of a slice's samples is uniform over the
//! picture's area, wherever the light's image (the epipole) lies: in the picture, beside it, behind the
//! camera or at infinity.

use super::picture::Picture;
use super::slice::{Ring, Slice};
use crate::light::LightPlace;
use crate::scene::{Size, Window};
use crate::snapshot::View;
use glam::{DVec2, DVec3};
use std::f64::consts::{PI, TAU};

/// All slices between one point of the lens and one light.
#[derive(Clone, Copy, Debug)]
pub struct Fan {
    /// The point of the lens, in relative space.
    pub eye: DVec3,
    /// Unit vector from the eye to the light.
    pub axis: DVec3,
    /// Unit vectors at right angles to the axis, in the half planes at angles 0 and pi / 2.
    zero: DVec3,
    quarter: DVec3,
    picture: Picture,
    /// First angle and range in radians that hold all half planes through the picture.
    pub angles: (f64, f64),
}

/// Distance between two slices that are one radian apart, pixels.
#[derive(Clone, Copy, Debug)]
pub struct Separation {
    /// Mean; 0 where there is no slice.
    pub mean_px: f64,
    /// Maximum.
    pub greatest_px: f64,
    /// Area of the picture that these are taken over, pixels.
    pub area_px: f64,
}

impl Fan {
    /// Slices of a light over the whole picture, seen from a point of the lens (metres to the right and up
    /// from its centre); `None` if the light is at that point.
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

    /// Angles of all slices that meet some pixels: the first, and the range in radians.
    pub fn angles_across(&self, pixels: Window) -> (f64, f64) {
        let (low, high) = self.corners_of(pixels);
        self.angles_between(low, high)
    }

    /// Bounds of the angles from the axis of some pixels.
    pub fn extent_of(&self, pixels: Window) -> (f64, f64) {
        let (low, high) = self.corners_of(pixels);
        let picture = Picture { low, high, ..self.picture };
        let middle = picture.direction(0.5 * (low + high));
        let reach = picture.corners().map(|corner| picture.direction(corner).angle_between(middle));
        let (from_axis, reach) = (middle.angle_between(self.axis), reach.into_iter().fold(0.0, f64::max));
        (from_axis - reach, from_axis + reach)
    }

    /// The rectangle of some pixels in the image plane.
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
        // A convex rectangle without the axis subtends less than pi at it.
        let middle = self.angle(picture.direction(0.5 * (low + high)));
        let angles = picture.corners().map(|corner| {
            let from_middle = self.angle(picture.direction(corner)) - middle;
            from_middle - TAU * (from_middle / TAU).round()
        });
        let low = angles.into_iter().fold(PI, f64::min);
        let high = angles.into_iter().fold(-PI, f64::max);
        (middle + low, high - low)
    }

    /// Least and greatest angle between the axis and directions of the picture.
    pub fn extent(&self) -> (f64, f64) {
        self.picture.angles_from(self.axis)
    }

    /// Apparent angle in the picture between this fan's axis and another's, radians.
    pub fn deviation(&self, other: &Self) -> f64 {
        self.picture.reframed(&other.picture, other.axis).angle_between(self.axis)
    }

    /// Angle of this fan's slice through a place of the picture, and the radians by which it rotates for each
    /// of the place's. The place is given in another fan over the same picture, on its slice at `angle`,
    /// `from_axis` radians from its axis.
    pub fn angle_through(&self, other: &Self, angle: f64, from_axis: f64) -> (f64, f64) {
        let ((sin, cos), (far, near)) = (angle.sin_cos(), from_axis.sin_cos());
        let place = near * other.axis + far * (cos * other.zero + sin * other.quarter);
        let change = far * (cos * other.quarter - sin * other.zero);
        let [place, change] = [place, change].map(|v| self.picture.reframed(&other.picture, v));
        let components = |v: DVec3| DVec2::new(v.dot(self.zero), v.dot(self.quarter));
        let (place, change) = (components(place), components(change));
        (place.y.atan2(place.x), place.perp_dot(change) / place.length_squared())
    }

    /// Separation of slices in the part of the picture within a ring.
    pub fn separation(&self, ring: Ring) -> Separation {
        // Area per radian over length, found from a few slices.
        let probes = 64;
        let (mut area_per_rad, mut length_px, mut greatest_px) = (0.0, 0.0, 0.0_f64);
        for probe in 0..probes {
            let angle = self.angles.0 + self.angles.1 * (f64::from(probe) + 0.5) / f64::from(probes);
            if let Some(slice) = self.slice(angle, ring) {
                area_per_rad += slice.area_per_rad;
                length_px += slice.length_px();
                greatest_px = greatest_px.max(slice.greatest_separation_px_per_rad());
            }
        }
        let mean_px = if length_px > 0.0 { area_per_rad / length_px } else { 0.0 };
        Separation { mean_px, greatest_px, area_px: self.angles.1 * area_per_rad / f64::from(probes) }
    }

    /// Pixels to a radian in the middle of a picture that the camera looks straight at.
    pub fn px_per_rad(&self) -> f64 {
        self.picture.pixels_per_unit
    }

    /// The slice at an angle, within a ring; `None` if it misses the picture there.
    pub fn slice(&self, angle: f64, ring: Ring) -> Option<Slice> {
        let (sin, cos) = angle.sin_cos();
        let outward = cos * self.zero + sin * self.quarter;
        let normal = cos * self.quarter - sin * self.zero;
        Slice::new(self.picture, self.axis, [outward, normal], ring)
    }

    fn angle(&self, direction: DVec3) -> f64 {
        direction.dot(self.quarter).atan2(direction.dot(self.zero))
    }
}

#[cfg(test)]
impl Fan {
    /// Fan of a light in a direction, a unit vector, seen by a pinhole that looks along -z with a vertical
    /// field of view in radians.
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
