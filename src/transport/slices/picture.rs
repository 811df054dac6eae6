//! The picture as a rectangle of the image plane at distance 1 from a point of the lens. In go points of that
//! plane, out come directions and pixels. Invariant: points in focus have the same pixel from every point of
//! the lens.

use crate::scene::Size;
use crate::snapshot::View;
use glam::{DVec2, DVec3};
use std::f64::consts::PI;

/// The image plane, and the picture in it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Picture {
    pub(super) right: DVec3,
    pub(super) up: DVec3,
    pub(super) forward: DVec3,
    /// Pixels per unit of the image plane.
    pub(super) pixels_per_unit: f64,
    /// Corner of film pixel (0, 0) in the image plane.
    pub(super) corner: DVec2,
    pub(super) low: DVec2,
    pub(super) high: DVec2,
}

impl Picture {
    pub(super) fn new(view: &View, size: Size, lens_point: DVec2) -> Self {
        let (right, up, forward) = view.axes();
        let half = view.half_extents();
        let pixels_per_unit = size.width as f64 / (2.0 * half.x);
        // Points in focus stay in their pixel: the picture shifts against the lens.
        let shift = view.middle() - lens_point / view.focus_distance_m;
        let corner = shift + DVec2::new(-half.x, half.y);
        Self { right, up, forward, pixels_per_unit, corner, low: shift - half, high: shift + half }
    }

    /// A point of the image plane in pixels, y downwards.
    pub(super) fn film_px(&self, point: DVec2) -> DVec2 {
        let film = (point - self.corner) * self.pixels_per_unit;
        DVec2::new(film.x, -film.y)
    }

    pub(super) fn vector(&self, v: DVec2) -> DVec3 {
        v.x * self.right + v.y * self.up
    }

    /// Direction towards a point of the image plane; not of unit length.
    pub(super) fn direction(&self, point: DVec2) -> DVec3 {
        self.vector(point) + self.forward
    }

    /// Direction in this picture at the place that `direction` has in another picture of the same size. The
    /// map is linear, so it extends beyond the picture and behind the camera.
    pub(super) fn reframed(&self, other: &Self, direction: DVec3) -> DVec3 {
        let depth = direction.dot(other.forward);
        let point = DVec2::new(direction.dot(other.right), direction.dot(other.up)) - depth * other.corner;
        let scale = other.pixels_per_unit / self.pixels_per_unit;
        self.vector(scale * point + depth * self.corner) + depth * self.forward
    }

    /// Least and greatest angle between a direction and those of the picture.
    pub(super) fn angles_from(&self, axis: DVec3) -> (f64, f64) {
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

    pub(super) fn corners(&self) -> [DVec2; 4] {
        let (low, high) = (self.low, self.high);
        [low, high, DVec2::new(low.x, high.y), DVec2::new(high.x, low.y)]
    }

    pub(super) fn sees(&self, direction: DVec3) -> bool {
        let depth = direction.dot(self.forward);
        let point = DVec2::new(direction.dot(self.right), direction.dot(self.up)) / depth;
        depth > 0.0 && point.cmpge(self.low).all() && point.cmple(self.high).all()
    }
}
