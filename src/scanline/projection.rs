//! From relative space to the picture, without dividing. Invariant: what a perspective camera sees at a place (x, y) of its
//! picture lies along (x, y, 1) in the space used here; nothing is clipped, not even behind the eye.

use crate::scene::Size;
use crate::snapshot::View;
use glam::{DAffine3, DMat3, DVec2, DVec3};

/// A camera and a picture of some size.
#[derive(Clone, Copy)]
pub(super) struct Projection {
    /// Right, up and forward.
    camera_from_relative: DMat3,
    is_orthographic: bool,
    half: DVec2,
    middle: DVec2,
    size: DVec2,
}

/// A point as the picture sees it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Vertex {
    /// Homogeneous: the place in the plane at distance 1 is `(x, y) / z`. Of parallel rays z is 1.
    pub(super) place: DVec3,
    /// Along the view axis, metres.
    pub(super) depth: f64,
}

impl Projection {
    pub(super) fn new(view: &View, size: Size) -> Self {
        let (right, up, forward) = view.axes();
        Self {
            camera_from_relative: DMat3::from_cols(right, up, forward).transpose(),
            is_orthographic: view.is_orthographic(),
            half: view.half_extents(),
            middle: view.middle(),
            size: DVec2::new(size.width as f64, size.height as f64),
        }
    }

    pub(super) fn camera_from_mesh(&self, relative_from_mesh: DAffine3) -> DAffine3 {
        DAffine3::from_mat3(self.camera_from_relative) * relative_from_mesh
    }

    pub(super) fn vertex(&self, in_camera: DVec3) -> Vertex {
        let depth = in_camera.z;
        let place = if self.is_orthographic { in_camera.truncate().extend(1.0) } else { in_camera };
        Vertex { place, depth }
    }

    /// The place in the plane at distance 1 of a place in pixels.
    pub(super) fn place(&self, pixels: DVec2) -> DVec2 {
        let film = pixels / self.size;
        self.middle + DVec2::new(2.0 * film.x - 1.0, 1.0 - 2.0 * film.y) * self.half
    }

    /// And back.
    pub(super) fn pixels(&self, place: DVec2) -> DVec2 {
        let film = (place - self.middle) / self.half;
        0.5 * DVec2::new(1.0 + film.x, 1.0 - film.y) * self.size
    }

    /// A box in pixels around what is seen of a triangle; `None` if nothing is.
    pub(super) fn bounds(&self, triangle: &[Vertex; 3]) -> Option<(DVec2, DVec2)> {
        if triangle.iter().all(|vertex| vertex.depth <= 0.0) {
            return None;
        }
        let low = self.middle - self.half;
        let high = self.middle + self.half;
        let around = |places: &[DVec3]| {
            let pixels =
                places.iter().map(|place| self.pixels((place.truncate() / place.z).clamp(low, high)));
            pixels.fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(min, max), p| (min.min(p), max.max(p)))
        };
        let places = triangle.map(|vertex| vertex.place);
        let sides = [
            DVec3::new(1.0, 0.0, -low.x),
            DVec3::new(-1.0, 0.0, high.x),
            DVec3::new(0.0, 1.0, -low.y),
            DVec3::new(0.0, -1.0, high.y),
        ];
        if sides.iter().any(|side| places.iter().all(|place| side.dot(*place) < 0.0)) {
            return None;
        }
        if places.iter().all(|place| place.z > 0.0) {
            return Some(around(&places));
        }
        // Part of it is behind the eye: its part between the picture's sides (Sutherland and Hodgman 1974) has a box. The
        // four sides meet in the eye, so nothing behind it is left, and they take the place of a near plane.
        let inside = sides.iter().fold(places.to_vec(), |polygon, side| clipped(&polygon, *side));
        match inside.as_slice() {
            [] => None,
            // The very eye is seen everywhere.
            polygon if polygon.iter().any(|place| place.z <= 0.0) => Some((DVec2::ZERO, self.size)),
            polygon => Some(around(polygon)),
        }
    }
}

/// The part of a polygon where `side . place >= 0`.
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
