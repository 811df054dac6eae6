//! Boxes along the axes. In go points, out come their bounds; in goes a box, out come its corners. Invariant:
//! the bounds of no point are empty.

use glam::{BVec3, DVec3};

/// Smallest and largest coordinates of points.
pub fn bounds(points: impl IntoIterator<Item = DVec3>) -> (DVec3, DVec3) {
    let empty = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    points.into_iter().fold(empty, |(low, high), point| (low.min(point), high.max(point)))
}

/// The eight corners of a box.
pub fn corners((low, high): (DVec3, DVec3)) -> [DVec3; 8] {
    let is_high = |corner: usize| BVec3::new(corner & 1 != 0, corner & 2 != 0, corner & 4 != 0);
    std::array::from_fn(|corner| DVec3::select(is_high(corner), high, low))
}
