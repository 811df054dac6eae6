//! Projection from relative space to the picture, without division. In go points, out come homogeneous
//! places. Invariant: a perspective camera sees the places (x, y, 1) of the space used here at (x, y) of its
//! picture. Nothing is clipped, not even behind the eye.

use crate::scene::Size;
use crate::snapshot::View;
use glam::{DAffine3, DMat3, DVec2, DVec3};

/// A camera and a picture of some size.
#[derive(Clone, Copy)]
pub(super) struct Projection {
    /// Axes: right, up and forward.
    camera_from_relative: DMat3,
    is_orthographic: bool,
    half: DVec2,
    middle: DVec2,
    size: DVec2,
    /// Normals of the planes through the eye and the picture's sides: visible points have products of at
    /// least 0 with all of them.
    sides: [DVec3; 4],
}

/// A point, projected to the picture.
#[derive(Clone, Copy, Debug)]
pub(super) struct Vertex {
    /// Homogeneous place: `(x, y) / z` in the plane at distance 1. For parallel rays z is 1.
    pub(super) place: DVec3,
    /// Distance along the view axis, metres.
    pub(super) depth: f64,
    /// Pixel of a point in front of the eye, clamped to the picture.
    pixels: DVec2,
    /// One bit for each side of the picture that it lies beyond, and one for behind the eye. A triangle with
    /// all its vertices beyond the same side is not visible (the outcodes of Cohen and Sutherland).
    beyond: u8,
}

/// Bit of a point behind the eye.
const BEHIND: u8 = 1 << 4;

impl Projection {
    pub(super) fn new(view: &View, size: Size) -> Self {
        let (right, up, forward) = view.axes();
        let (half, middle) = (view.half_extents(), view.middle());
        let (low, high) = (middle - half, middle + half);
        Self {
            camera_from_relative: DMat3::from_cols(right, up, forward).transpose(),
            is_orthographic: view.is_orthographic,
            half,
            middle,
            size: DVec2::new(size.width as f64, size.height as f64),
            sides: [
                DVec3::new(1.0, 0.0, -low.x),
                DVec3::new(-1.0, 0.0, high.x),
                DVec3::new(0.0, 1.0, -low.y),
                DVec3::new(0.0, -1.0, high.y),
            ],
        }
    }

    pub(super) fn camera_from_mesh(&self, relative_from_mesh: DAffine3) -> DAffine3 {
        DAffine3::from_mat3(self.camera_from_relative) * relative_from_mesh
    }

    #[inline]
    pub(super) fn vertex(&self, in_camera: DVec3) -> Vertex {
        let depth = in_camera.z;
        let place = if self.is_orthographic { in_camera.truncate().extend(1.0) } else { in_camera };
        let mut beyond = if depth <= 0.0 { BEHIND } else { 0 };
        for (bit, side) in self.sides.iter().enumerate() {
            beyond |= u8::from(side.dot(place) < 0.0) << bit;
        }
        Vertex { place, depth, pixels: self.pixels_within(place), beyond }
    }

    /// Pixel of a point in front of the eye, clamped to the picture.
    fn pixels_within(&self, place: DVec3) -> DVec2 {
        let in_plane = place.truncate() / place.z;
        self.pixels(in_plane.clamp(self.middle - self.half, self.middle + self.half))
    }

    /// Place in the plane at distance 1, of a place in pixels.
    pub(super) fn place(&self, pixels: DVec2) -> DVec2 {
        let film = pixels / self.size;
        self.middle + DVec2::new(2.0 * film.x - 1.0, 1.0 - 2.0 * film.y) * self.half
    }

    /// Place in pixels, of a place in the plane at distance 1.
    pub(super) fn pixels(&self, place: DVec2) -> DVec2 {
        let film = (place - self.middle) / self.half;
        0.5 * DVec2::new(1.0 + film.x, 1.0 - film.y) * self.size
    }

    /// Bounds in pixels of the visible part of a triangle; `None` if nothing is visible.
    #[inline]
    pub(super) fn bounds(&self, triangle: [&Vertex; 3]) -> Option<(DVec2, DVec2)> {
        let [a, b, c] = triangle;
        if a.beyond & b.beyond & c.beyond != 0 {
            return None;
        }
        if a.place.z > 0.0 && b.place.z > 0.0 && c.place.z > 0.0 {
            let low = a.pixels.min(b.pixels).min(c.pixels);
            return Some((low, a.pixels.max(b.pixels).max(c.pixels)));
        }
        self.bounds_about_the_eye(triangle)
    }

    /// Bounds of a triangle that is partly behind the eye.
    #[cold]
    fn bounds_about_the_eye(&self, triangle: [&Vertex; 3]) -> Option<(DVec2, DVec2)> {
        // Its part between the picture's sides (Sutherland and Hodgman 1974) has bounds. The four sides meet
        // in the eye, so they clip away all that lies behind it, as a near plane would.
        let places = triangle.map(|vertex| vertex.place);
        let inside = self.sides.iter().fold(places.to_vec(), |polygon, side| clipped(&polygon, *side));
        match inside.as_slice() {
            [] => None,
            // The eye itself is at every place of the picture.
            polygon if polygon.iter().any(|place| place.z <= 0.0) => Some((DVec2::ZERO, self.size)),
            polygon => {
                let pixels = polygon.iter().map(|place| self.pixels_within(*place));
                Some(pixels.fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(low, high), pixels| {
                    (low.min(pixels), high.max(pixels))
                }))
            }
        }
    }
}

/// Part of a polygon where `side . place >= 0`.
fn clipped(polygon: &[DVec3], side: DVec3) -> Vec<DVec3> {
    let mut out = Vec::with_capacity(polygon.len() + 1);
    for (number, &to) in polygon.iter().enumerate() {
        let from = polygon[(number + polygon.len() - 1) % polygon.len()];
        let (before, after) = (side.dot(from), side.dot(to));
        if (before < 0.0) != (after < 0.0) {
            out.push(from.lerp(to, before / (before - after)));
        }
        if after >= 0.0 {
            out.push(to);
        }
    }
    out
}
