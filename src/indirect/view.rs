//! Indirect light that fog scatters towards the eye, precomputed for look-up. In go a field and a snapshot,
//! out comes the in-scattered radiance of any part of a camera ray. Invariant: both ends of a part read
//! prefix sums of the same steps, so parts of a ray add up to the whole.

use super::Field;
use super::towards::Towards;
use crate::color::Rgb;
use crate::math::Ray;
use crate::ordinates::high_degrees::SEEN_DEGREES;
use crate::snapshot::Snapshot;
use glam::{DVec2, DVec3, Vec4};
use rayon::prelude::*;

/// Number of rays across the picture.
const COLUMNS: usize = 48;
/// Maximum number of a ray's steps through the innermost grid, and before and beyond it.
const MOST_STEPS: usize = 160;
const FAR_STEPS: usize = 48;
/// Length of the first step before the innermost grid, in its cells.
const FIRST_CELLS: f64 = 0.5;

/// Prefix sums along a coarse grid of camera rays.
///
/// A look-up gives the mean radiance of all fog before a distance, weighted by its visibility. The ray itself
/// computes its optical depth. So edges of fog stay sharp, and fog in uniform light has the same radiance
/// everywhere.
pub(super) struct ViewedFog {
    columns: usize,
    rows: usize,
    depths: Depths,
    /// Sums by ray, then by step.
    sums: Vec<Seen>,
}

/// Fog before a distance: its mean radiance by channel times a weight, and the weight. The weight is 1 minus
/// its transmittance.
#[derive(Clone, Copy, Default)]
struct Seen(Vec4);

impl ViewedFog {
    /// Precomputes the sums; `aspect` is width / height of the picture. `None` where there is no fog.
    pub(super) fn new(field: &Field, snapshot: &Snapshot, aspect: f64) -> Option<Self> {
        if snapshot.medium.is_empty() {
            return None;
        }
        let (columns, rows) = (COLUMNS, ((COLUMNS as f64 / aspect).round() as usize).clamp(2, 4 * COLUMNS));
        let depths = Depths::of(field, snapshot);
        let steps = depths.count();
        let mut sums = vec![Seen::default(); (columns + 1) * (rows + 1) * (steps + 1)];
        sums.par_chunks_mut(steps + 1).enumerate().for_each(|(number, sums)| {
            let place = [number % (columns + 1), number / (columns + 1)].map(|index| index as f64);
            let ray = snapshot.view.ray(place[0] / columns as f64, place[1] / rows as f64);
            let mut walk = Walk::new(field, snapshot, ray);
            for (step, sum) in sums.iter_mut().enumerate() {
                // In two halves, as light varies within a cell.
                walk.to(depths.distance(step as f64 - 0.5));
                *sum = walk.to(depths.distance(step as f64));
            }
        });
        Some(Self { columns, rows, depths, sums })
    }

    /// Radiance that is scattered into a camera ray within `distance` metres, W m^-2 sr^-1. `through` is the
    /// transmittance of that fog.
    pub(super) fn before(&self, snapshot: &Snapshot, ray: &Ray, distance: f64, through: Rgb) -> Rgb {
        let place = if distance.is_finite() {
            snapshot.view.film_place(ray.at(distance))
        } else {
            snapshot.view.film_place_of_direction(ray.direction)
        };
        let place = place.or_else(|| snapshot.view.film_place(ray.at(1.0))).unwrap_or(DVec2::splat(0.5));
        let (columns, rows) = (self.columns as f64, self.rows as f64);
        let at = DVec2::new(place.x * columns, place.y * rows).clamp(DVec2::ZERO, DVec2::new(columns, rows));
        let steps = self.depths.count();
        let depth = self.depths.step(distance).clamp(0.0, steps as f64);
        let cell = [(at.x as usize).min(self.columns - 1), (at.y as usize).min(self.rows - 1)];
        let step = (depth as usize).min(steps - 1);
        let [across, down] = [0, 1].map(|axis| (at[axis] - cell[axis] as f64) as f32);
        let later = (depth - step as f64) as f32;
        let of_ray = |ray: usize| {
            let seen = &self.sums[ray * (steps + 1) + step..][..2];
            seen[0].0.lerp(seen[1].0, later)
        };
        let of_row = |row: usize| {
            let ray = cell[0] + (self.columns + 1) * row;
            of_ray(ray).lerp(of_ray(ray + 1), across)
        };
        let seen = of_row(cell[1]).lerp(of_row(cell[1] + 1), down);
        let [red, green, blue, weight] = seen.to_array().map(f64::from);
        if weight <= 0.0 {
            return Rgb::ZERO;
        }
        (Rgb::ONE - through) * Rgb::new(red, green, blue) / weight
    }
}

/// Distances from the camera, by step: growing steps up to the innermost grid, equal steps through it,
/// growing steps beyond.
struct Depths {
    /// The first distance, up to which light counts as uniform.
    first_m: f64,
    start_m: f64,
    step_m: f64,
    /// Number of steps before the innermost grid, in it, and beyond.
    before: usize,
    near: usize,
    far: usize,
    /// Ratio of successive distances before the grid, and beyond.
    growth_before: f64,
    growth_beyond: f64,
}

impl Depths {
    fn of(field: &Field, snapshot: &Snapshot) -> Self {
        let eye = snapshot.view.eye;
        let about_eye = |(low, high): (DVec3, DVec3)| (low - eye, high - eye);
        let outermost_m = field.levels.last().map_or(0.0, |level| farthest_m(about_eye(level.grid.volume())));
        let slabs_m = snapshot.medium.all_bounds().map(farthest_m).fold(outermost_m, f64::max);
        let all_m = field.layers.as_ref().map_or(outermost_m, |_| farthest_seen_m(snapshot).max(slabs_m));
        let (start_m, end_m, step_m) = match field.levels.first() {
            Some(level) => {
                let (low, high) = about_eye(level.grid.volume());
                (low.max(-high).max(DVec3::ZERO).length(), farthest_m((low, high)), level.grid.cell_m)
            }
            None => {
                let scale_m = field.layers.as_ref().map_or(1.0, |layers| layers.heights.scale_m);
                (0.0, 2.0 * scale_m, 0.125 * scale_m)
            }
        };
        let is_more = field.levels.len() > 1 || field.layers.as_ref().is_some();
        let first_m = start_m.min(FIRST_CELLS * step_m);
        let steps = |from: f64, to: f64| if is_more && to > from { FAR_STEPS } else { 0 };
        let (before, far) = (steps(first_m, start_m), steps(end_m, all_m));
        let near = ((end_m - start_m) / step_m).ceil().clamp(1.0, MOST_STEPS as f64) as usize;
        let growth = |from: f64, to: f64, steps: usize| (to / from).max(1.0).powf(1.0 / steps.max(1) as f64);
        Self {
            first_m,
            start_m,
            step_m: (end_m - start_m) / near as f64,
            before,
            near,
            far,
            growth_before: growth(first_m, start_m, before),
            growth_beyond: growth(end_m, all_m, far),
        }
    }

    fn count(&self) -> usize {
        self.before + self.near + self.far
    }

    fn end_m(&self) -> f64 {
        self.start_m + self.near as f64 * self.step_m
    }

    fn distance(&self, step: f64) -> f64 {
        let before = self.before as f64;
        if step < before {
            return if step < 0.0 { 0.0 } else { self.first_m * self.growth_before.powf(step) };
        }
        match step - before - self.near as f64 {
            beyond if beyond > 0.0 => self.end_m() * self.growth_beyond.powf(beyond),
            _ => self.start_m + (step - before) * self.step_m,
        }
    }

    /// Step of a distance, the inverse of [`Depths::distance`]; past the last step it exceeds the count.
    fn step(&self, distance: f64) -> f64 {
        let before = self.before as f64;
        if self.before > 0 && distance < self.start_m {
            return ((distance / self.first_m).ln() / self.growth_before.ln()).max(0.0);
        }
        if self.far > 0 && distance > self.end_m() {
            return before + self.near as f64 + (distance / self.end_m()).ln() / self.growth_beyond.ln();
        }
        before + (distance - self.start_m) / self.step_m
    }
}

/// Distance to which unbounded fog is visible from the eye, in any direction, metres.
fn farthest_seen_m(snapshot: &Snapshot) -> f64 {
    /// Optical depth to which it counts, or the share of all of it.
    const DEPTH: f64 = 5.0;
    const SHARE: f64 = 0.99;
    /// Number of rays across and down.
    const SIDE: usize = 9;
    let medium = &snapshot.medium;
    let of_ray = |number: usize| {
        let place = |index: usize| index as f64 / (SIDE - 1) as f64;
        let ray = snapshot.view.ray(place(number % SIDE), place(number / SIDE));
        let Some((start, end)) = medium.range(&ray, f64::INFINITY) else { return 0.0 };
        let along = medium.along(&ray, end);
        let depth = |t: f64| along.optical_depth(t).max_element();
        let enough = DEPTH.min(SHARE * depth(end));
        let (mut near, mut far) = (start, end);
        for _ in 0..48 {
            let middle = 0.5 * (near + far);
            if depth(middle) < enough { near = middle } else { far = middle }
        }
        far
    };
    (0..SIDE * SIDE).map(of_ray).fold(0.0, f64::max)
}

/// Distance to the farthest corner of a box, from the origin.
fn farthest_m((low, high): (DVec3, DVec3)) -> f64 {
    low.abs().max(high.abs()).length()
}

/// A ray through fog, step by step.
struct Walk<'a> {
    field: &'a Field,
    snapshot: &'a Snapshot<'a>,
    ray: Ray,
    /// Direction of light, against the ray.
    towards: Towards,
    /// Range of the ray that has fog.
    fog: Option<(f64, f64)>,
    at: f64,
    through: Rgb,
    light: Rgb,
    /// Source of the last step, per unit of extinction, and its distance.
    source: Rgb,
    middle: f64,
    /// Number of steps left behind a wall that the ray just passed.
    behind_wall: u32,
    has_passed_wall: bool,
}

/// Rays that end at a wall read up to two steps beyond it, as neighbouring rays may end later.
const STEPS_BEHIND_WALL: u32 = 2;
/// Weight of steps farther behind it, relative to rays that no wall has stopped.
const BEHIND_WALL: f32 = 1e-3;

impl<'a> Walk<'a> {
    fn new(field: &'a Field, snapshot: &'a Snapshot, ray: Ray) -> Self {
        let fog = snapshot.medium.range(&ray, f64::INFINITY);
        let [light, source] = [Rgb::ZERO; 2];
        Self {
            field,
            snapshot,
            ray,
            towards: field.towards(-ray.direction),
            fog,
            at: 0.0,
            through: Rgb::ONE,
            light,
            source,
            middle: 0.0,
            behind_wall: 0,
            has_passed_wall: false,
        }
    }

    /// Fog before a distance; distances must grow from call to call.
    fn to(&mut self, distance: f64) -> Seen {
        if let Some((start, end)) = self.fog {
            let (from, to) = (self.at.max(start), distance.min(end));
            if from < to {
                let start = self.ray.at(from);
                let through =
                    self.through * self.snapshot.medium.transmittance(start, self.ray.direction, to - from);
                self.look(0.5 * (from + to));
                self.light += (self.through - through) * self.source;
                self.through = through;
            }
        }
        self.at = self.at.max(distance);
        let lost = Rgb::ONE - self.through;
        let weight = lost.element_sum() / 3.0;
        let weighed = |channel: usize| {
            if lost[channel] > 0.0 { (weight * self.light[channel] / lost[channel]) as f32 } else { 0.0 }
        };
        let is_behind = self.has_passed_wall && self.behind_wall == 0;
        let say = if is_behind { BEHIND_WALL } else { 1.0 };
        Seen(say * Vec4::new(weighed(0), weighed(1), weighed(2), weight as f32))
    }

    /// Evaluates the source in the middle of a step; just behind a wall it keeps that before the wall.
    fn look(&mut self, middle: f64) {
        let world = |t: f64| self.snapshot.world_from_relative(self.ray.at(t));
        if self.middle > 0.0 && self.field.has_wall_between(world(self.middle), world(middle)) {
            (self.behind_wall, self.has_passed_wall) = (STEPS_BEHIND_WALL, true);
        }
        self.middle = middle;
        if self.behind_wall > 0 {
            self.behind_wall -= 1;
            return;
        }
        let medium = &self.snapshot.medium;
        let place = self.ray.at(middle);
        let (extinction, scattering) = medium.coefficients_at::<SEEN_DEGREES>(place);
        let per_extinction = |color: Rgb| {
            let share = |channel: usize| {
                if extinction[channel] > 0.0 { color[channel] / extinction[channel] } else { 0.0 }
            };
            Rgb::new(share(0), share(1), share(2))
        };
        let shares = scattering.map(per_extinction);
        let mut source = self.field.scattered(world(middle), &self.towards, &shares);
        self.field.for_each_peak(world(middle), |peak| {
            let cos = -peak.travel.dot(self.ray.direction);
            source += peak.irradiance * per_extinction(medium.scattering_again_at(place, cos, peak.times));
        });
        self.source = source.max(Rgb::ZERO);
    }
}

/// Radiance along a ray from any origin, such as a mirror, in a number of steps: the first are the shortest.
pub(super) fn along(field: &Field, snapshot: &Snapshot, ray: &Ray, (distance, steps): (f64, u32)) -> Rgb {
    let origin = snapshot.world_from_relative(ray.origin);
    let to_end = |(low, high): (DVec3, DVec3)| farthest_m((low - origin, high - origin));
    let outermost_m = field.levels.last().map_or(0.0, |level| to_end(level.grid.volume()));
    let distance = if field.layers.as_ref().is_some() { distance } else { distance.min(outermost_m) };
    let Some((start, end)) = snapshot.medium.range(ray, distance) else { return Rgb::ZERO };
    let is_even = field.layers.as_ref().is_none();
    let mut walk = Walk::new(field, snapshot, *ray);
    for step in 1..=steps {
        let share = f64::from(step) / f64::from(steps);
        walk.to(start + (end - start) * if is_even { share } else { share * share });
    }
    walk.light
}
