//! Lattice of camera rays and steps on which fog is precomputed. In go a snapshot and the size of a picture,
//! out come rays and places on them. Invariant: neither depends on the wanted part of the picture.

use super::{Snapshot, View};
use crate::math::Ray;
use crate::scene::Size;
use glam::{DVec2, DVec3};

/// Distance beyond the fog and the film that the lattice covers, pixels.
const BEYOND_PX: f64 = 1.5;
/// Distance between planes, in voxels and in optical depth.
const STEP_VOXELS: f64 = 2.0;
const STEP_DEPTH: f64 = 0.2;
const MOST_STEPS: f64 = 1024.0;

/// Rays through a grid of places on the film, and planes across the view axis.
pub(super) struct FogLattice {
    pub(super) view: View,
    /// Place of the first ray on the film, and the step to the next.
    first: DVec2,
    spacing: DVec2,
    pub(super) columns: usize,
    pub(super) rows: usize,
    /// Depths along the view axis, metres.
    start_m: f64,
    step_m: f64,
    pub(super) steps: usize,
}

/// Rays around a place on the film, with their weights.
pub(super) type Between = [(usize, f32); 4];

impl FogLattice {
    /// Lattice with so many numbers at each place, and about `most` in all, or rays at the distance
    /// `closest_px`; `None` if there is no fog in the picture, or too much.
    pub(super) fn of(
        snapshot: &Snapshot,
        size: Size,
        (numbers, most, closest_px): (usize, f64, f64),
    ) -> Option<Self> {
        let (view, medium) = (snapshot.view, &snapshot.medium);
        let (mut start_m, mut end_m) = (f64::INFINITY, 0.0_f64);
        let (mut low, mut high) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
        for corner in medium.banks().iter().filter_map(|bank| bank.corners()).flatten() {
            let depth_m = view.depth(corner);
            (start_m, end_m) = (start_m.min(depth_m), end_m.max(depth_m));
            let place = view.film_place(corner);
            low = low.min(place.unwrap_or(DVec2::NEG_INFINITY));
            high = high.max(place.unwrap_or(DVec2::INFINITY));
        }
        let start_m = start_m.max(0.0);
        let (low, high) = (low.max(DVec2::ZERO), high.min(DVec2::ONE));
        if !(end_m > start_m && low.cmplt(high).all()) {
            return None;
        }
        let axis = Ray { origin: DVec3::ZERO, direction: view.axes().2 };
        let longest_m =
            (STEP_VOXELS * medium.voxel_m(&axis)?).min(STEP_DEPTH / medium.most_extinction_per_m());
        let steps = ((end_m - start_m) / longest_m).ceil();
        if steps > MOST_STEPS {
            return None;
        }
        let px = DVec2::new(size.width as f64, size.height as f64).recip();
        let area_px = ((high - low) / px + 2.0 * BEYOND_PX).element_product();
        let by_pixel = area_px * (steps + 1.0) * numbers as f64;
        let spacing_px = (by_pixel / most).sqrt().max(closest_px);
        let spacing = spacing_px * px;
        // More on each side, as some samples of the outermost pixels lie beyond them.
        let more = (BEYOND_PX / spacing_px).ceil();
        let (first, last) = ((low / spacing).floor() - more, (high / spacing).ceil() + more);
        let count = last - first + 1.0;
        Some(Self {
            view,
            first: spacing * first,
            spacing,
            columns: count.x as usize,
            rows: count.y as usize,
            start_m,
            step_m: (end_m - start_m) / steps,
            steps: steps as usize,
        })
    }

    pub(super) fn ray(&self, number: usize) -> Ray {
        let place = DVec2::new((number % self.columns) as f64, (number / self.columns) as f64);
        let place = self.first + self.spacing * place;
        self.view.ray(place.x, place.y)
    }

    /// Distances at which a ray crosses the planes.
    pub(super) fn places(&self, ray: &Ray) -> Vec<f64> {
        (0..=self.steps).map(|step| self.place(ray, step as f64)).collect()
    }

    /// Distance along a ray after a number of steps.
    pub(super) fn place(&self, ray: &Ray, step: f64) -> f64 {
        (self.start_m + self.step_m * step) / self.view.depth(ray.direction)
    }

    /// Step of a distance along a ray, the inverse of [`Self::place`].
    pub(super) fn step(&self, ray: &Ray, t: f64) -> f64 {
        ((t * self.view.depth(ray.direction) - self.start_m) / self.step_m).clamp(0.0, self.steps as f64)
    }

    /// The rays around a given one.
    pub(super) fn between(&self, ray: &Ray) -> Between {
        let place = self.view.film_place(ray.at(1.0)).unwrap_or(DVec2::splat(0.5));
        let last = DVec2::new((self.columns - 1) as f64, (self.rows - 1) as f64);
        let place = ((place - self.first) / self.spacing).clamp(DVec2::ZERO, last);
        let cell = place.floor().min(last - 1.0);
        let [across, down] = (place - cell).to_array();
        let number = cell.x as usize + self.columns * cell.y as usize;
        [
            (number, ((1.0 - across) * (1.0 - down)) as f32),
            (number + 1, (across * (1.0 - down)) as f32),
            (number + self.columns, ((1.0 - across) * down) as f32),
            (number + self.columns + 1, (across * down) as f32),
        ]
    }
}
