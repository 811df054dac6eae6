//! Height map of a ground. In go triangles, out come heights. Invariant: the highest triangle over a place
//! counts.

use glam::{DVec2, DVec3};

/// Heights on a regular grid; `None` where there is no ground.
#[derive(Debug)]
pub struct GroundHeights {
    low: DVec2,
    spacing_m: f64,
    /// Number of points along x and along z.
    size: [usize; 2],
    heights_m: Vec<Option<f64>>,
}

impl GroundHeights {
    /// Heights of the triangles within a box.
    pub(crate) fn new([low, high]: [DVec3; 2], spacing_m: f64, triangles: &[[DVec3; 3]]) -> Self {
        let flat = |point: DVec3| DVec2::new(point.x, point.z);
        let (low, size) = (flat(low), (flat(high) - flat(low)) / spacing_m);
        let size = size.to_array().map(|count| count.ceil() as usize + 1);
        let mut ground = Self { low, spacing_m, size, heights_m: vec![None; size[0] * size[1]] };
        for triangle in triangles {
            ground.add(triangle.map(|point| ((flat(point) - low) / spacing_m, point.y)));
        }
        ground
    }

    /// Adds a triangle: its corners in grid steps from the first point, and their heights.
    fn add(&mut self, [(a, height_a), (b, height_b), (c, height_c)]: [(DVec2, f64); 3]) {
        let area = (b - a).perp_dot(c - a);
        if area == 0.0 || !area.is_finite() {
            return;
        }
        let last = DVec2::from_array(self.size.map(|count| (count - 1) as f64));
        let (first, last) = (a.min(b).min(c).ceil().max(DVec2::ZERO), a.max(b).max(c).floor().min(last));
        if first.cmpgt(last).any() {
            return;
        }
        for x in first.x as usize..=last.x as usize {
            for z in first.y as usize..=last.y as usize {
                let place = DVec2::new(x as f64, z as f64);
                let share_b = (place - a).perp_dot(c - a) / area;
                let share_c = (b - a).perp_dot(place - a) / area;
                if share_b < 0.0 || share_c < 0.0 || share_b + share_c > 1.0 {
                    continue;
                }
                let height = height_a + share_b * (height_b - height_a) + share_c * (height_c - height_a);
                let known = &mut self.heights_m[x * self.size[1] + z];
                *known = Some(known.map_or(height, |known| known.max(height)));
            }
        }
    }

    /// Height at a place, or at the nearest known point.
    pub fn at(&self, place: DVec3) -> Option<f64> {
        let at = ((DVec2::new(place.x, place.z) - self.low) / self.spacing_m).round();
        let at = at.clamp(DVec2::ZERO, DVec2::from_array(self.size.map(|count| (count - 1) as f64)));
        self.heights_m[at.x as usize * self.size[1] + at.y as usize]
    }
}
