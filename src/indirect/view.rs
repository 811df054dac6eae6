//! Indirect light that fog scatters towards the eye, ready to be looked up. In go a field and a snapshot, out comes the light of any part of any ray of the camera. Invariant:
//! what a ray's start and end have is the prefix sum of the same steps, so parts of a ray add up to the whole.

use super::Field;
use crate::color::Rgb;
use crate::math::Ray;
use crate::snapshot::Snapshot;
use glam::{DVec2, DVec3};
use rayon::prelude::*;

/// Rays across the picture.
const COLUMNS: usize = 64;
/// Most steps of one.
const MOST_STEPS: usize = 160;

/// Prefix sums along a coarse grid of camera rays.
pub struct ViewedFog {
    columns: usize,
    rows: usize,
    /// Of each ray.
    steps: usize,
    start_m: f64,
    step_m: f64,
    /// By ray, then by step.
    sums: Vec<[f32; 3]>,
}

impl ViewedFog {
    /// `aspect` is width / height of the picture; `None` where there is no fog.
    pub fn new(field: &Field, snapshot: &Snapshot, aspect: f64) -> Option<Self> {
        if snapshot.medium.is_empty() {
            return None;
        }
        let (columns, rows) = (COLUMNS, ((COLUMNS as f64 / aspect).round() as usize).clamp(2, 4 * COLUMNS));
        let (low, high) = field.volume();
        let eye = snapshot.view.eye;
        let (low, high) = (low - eye, high - eye);
        // Nearest and farthest place of the grid.
        let start_m = low.max(-high).max(DVec3::ZERO).length();
        let end_m = low.abs().max(high.abs()).length();
        let steps = (2.0 * (end_m - start_m) / field.cell_m()).ceil().clamp(1.0, MOST_STEPS as f64) as usize;
        let step_m = (end_m - start_m) / steps as f64;
        let mut fog = Self {
            columns,
            rows,
            steps,
            start_m,
            step_m,
            sums: vec![[0.0; 3]; (columns + 1) * (rows + 1) * (steps + 1)],
        };
        let (columns, rows) = (columns as f64, rows as f64);
        fog.sums.par_chunks_mut(steps + 1).enumerate().for_each(|(number, sums)| {
            let (column, row) = (number % (COLUMNS + 1), number / (COLUMNS + 1));
            let ray = snapshot.view.ray(column as f64 / columns, row as f64 / rows);
            let mut sum = Rgb::ZERO;
            for step in 0..steps {
                let (from, to) = (start_m + step as f64 * step_m, start_m + (step + 1) as f64 * step_m);
                sum += in_scattered(field, snapshot, &ray, from, to);
                sums[step + 1] = sum.to_array().map(|value| value as f32);
            }
        });
        Some(fog)
    }

    /// Radiance that is scattered into a camera ray before it has gone `distance` metres, W m^-2 sr^-1.
    pub fn before(&self, snapshot: &Snapshot, ray: &Ray, distance: f64) -> Rgb {
        let place = if distance.is_finite() {
            snapshot.view.film_place(ray.at(distance))
        } else {
            snapshot.view.film_place_of_direction(ray.direction)
        };
        let place = place.or_else(|| snapshot.view.film_place(ray.at(1.0))).unwrap_or(DVec2::splat(0.5));
        let (columns, rows) = (self.columns as f64, self.rows as f64);
        let at = DVec2::new(place.x * columns, place.y * rows).clamp(DVec2::ZERO, DVec2::new(columns, rows));
        let depth = ((distance - self.start_m) / self.step_m).clamp(0.0, self.steps as f64);
        let cell = [(at.x as usize).min(self.columns - 1), (at.y as usize).min(self.rows - 1)];
        let step = (depth as usize).min(self.steps - 1);
        let beyond =
            [at.x - cell[0] as f64, at.y - cell[1] as f64, depth - step as f64].map(|value| value as f32);
        let mut sum = [0.0_f32; 3];
        for corner in 0..4 {
            let (far_x, far_y) = (corner & 1, corner >> 1);
            let share = (if far_x == 1 { beyond[0] } else { 1.0 - beyond[0] })
                * (if far_y == 1 { beyond[1] } else { 1.0 - beyond[1] });
            let ray = cell[0] + far_x + (self.columns + 1) * (cell[1] + far_y);
            let at = ray * (self.steps + 1) + step;
            for channel in 0..3 {
                let (near, far) = (self.sums[at][channel], self.sums[at + 1][channel]);
                sum[channel] += share * (near + beyond[2] * (far - near));
            }
        }
        Rgb::from_array(sum.map(f64::from))
    }
}

/// The light of one step of a ray, by what the fog's middle scatters.
fn in_scattered(field: &Field, snapshot: &Snapshot, ray: &Ray, from: f64, to: f64) -> Rgb {
    let medium = &snapshot.medium;
    let middle = ray.at(0.5 * (from + to));
    let scattering = [0, 1, 2].map(|degree| medium.scattering_by_degree_at(middle, degree));
    if scattering[0] == Rgb::ZERO {
        return Rgb::ZERO;
    }
    let source = field.scattered(snapshot.world_from_relative(middle), -ray.direction, &scattering);
    let seen = medium.transmittance(ray.origin, ray.direction, 0.5 * (from + to));
    source * seen * (to - from)
}

/// The same along a ray from anywhere, such as a mirror.
pub(super) fn along(field: &Field, snapshot: &Snapshot, ray: &Ray, distance: f64) -> Rgb {
    const STEPS: usize = 24;
    let Some((start, end)) = snapshot.medium.range(ray, distance) else { return Rgb::ZERO };
    let step = (end - start) / STEPS as f64;
    (0..STEPS)
        .map(|number| start + number as f64 * step)
        .map(|from| in_scattered(field, snapshot, ray, from, from + step))
        .sum()
}
