//! Fog of voxels along camera rays. In go a snapshot and the size of a picture, out come optical depths and
//! in-scattered light. A lattice of camera rays has prefix sums of optical depth and of suns' scattered light
//! by step, of which lit intervals take differences. Invariant: depths along its rays are exact at steps, to
//! a 65,535th of the ray's whole. Between these all is linear, with an error within a tolerance.

use super::fog_lattice::{Between, FogLattice};
use super::{FrozenLight, Snapshot};
use crate::color::Rgb;
use crate::fog::{LitSegments, Passage, exp_minus, henyey_greenstein};
use crate::math::{Ray, close_up};
use crate::scene::Size;
use glam::DVec3;
use rayon::prelude::*;

/// Wanted root mean square error of a ray between those of the lattice: of transmittance, and of sunlight
/// relative to its own root mean square.
const WANTED: f64 = 0.005;
/// Number of values of a first lattice, 2 MB, whose error tells how many a finer one needs.
const FIRST_NUMBERS: f64 = (1 << 20) as f64;
/// Minimum distance of its rays, pixels.
const FIRST_SPACING_PX: f64 = 1.5;
/// Minimum distance of any rays: where even these err by more, single rays are about as fast.
const SPACING_PX: f64 = 1.0;
/// Margin of the number of values, as errors of edges fall more slowly.
const MARGIN: f64 = 1.5;
/// Minimum growth of the number of values that counts as finer.
const FINER: f64 = 1.2;
/// Maximum number of values, 32 MB, and maximum error where these are too few.
const MOST_NUMBERS: f64 = (1 << 24) as f64;
const TOLERANCE: f64 = 0.02;
/// Number of parts of a ray's whole: two bytes a value, as in `math::VoxelDepths`.
const PARTS: f64 = u16::MAX as f64;
/// Minimum cosine between a point of a sun's disc and its centre, for which light was computed: a degree.
const NEAR: f64 = 0.999_85;

/// Optical depths and light of suns on a lattice of camera rays.
pub struct SeenFog {
    lattice: FogLattice,
    /// Directions towards suns.
    suns: Vec<DVec3>,
    /// Henyey-Greenstein g of all voxels.
    g: f64,
    /// Number of channels that differ: 1 or 3.
    channels: usize,
    lines: Vec<Line>,
    /// Values of one ray's line after the other, by step, then quantity, then channel, in parts of the value
    /// behind all fog. Quantities are optical depth, and for each sun the scattered light without the phase
    /// function.
    parts: Vec<u16>,
    /// Value of a part, by ray, then quantity, then channel.
    of_part: Vec<f32>,
}

/// Values, parts and lines of a row of rays.
type Row<'a> = ((&'a mut [u16], &'a mut [f32]), &'a mut [Line]);

/// Location of a ray's values: from the last step at which all are 0 to the first at which none grows any
/// more.
#[derive(Clone, Copy, Default)]
struct Line {
    /// Index of its first value.
    first: u32,
    /// Number of the lattice's steps before it.
    skipped: u16,
    /// Number of steps from the first to the last.
    steps: u16,
}

impl Line {
    /// Its first index, and its number of values.
    fn span(&mut self, of_step: usize) -> (&mut u32, usize) {
        (&mut self.first, of_step * (usize::from(self.steps) + 1))
    }

    /// Index of the first value at one of the lattice's steps, of which each has so many.
    #[inline]
    fn place(self, step: usize, of_step: usize) -> usize {
        self.first as usize + of_step * step.saturating_sub(self.skipped.into()).min(self.steps.into())
    }
}

impl SeenFog {
    /// Precomputes the fog; `None` where single rays are better.
    pub(super) fn new(snapshot: &Snapshot, size: Size) -> Option<Self> {
        let (view, medium) = (&snapshot.view, &snapshot.medium);
        let g = medium.anisotropy_of_voxels()?;
        if view.has_lens() {
            return None;
        }
        let suns: Vec<DVec3> = snapshot
            .lights
            .iter()
            .filter_map(|light| match light.centre() {
                FrozenLight::Sun { to_light, .. } => Some(to_light),
                FrozenLight::Point { .. } => None,
            })
            .collect();
        let is_grey = |color: Rgb| color == Rgb::splat(color.x);
        let are_grey = medium.banks().iter().all(|bank| is_grey(bank.sigma_t) && is_grey(bank.sigma_s));
        let channels = if are_grey { 1 } else { 3 };
        let of_step = channels * (1 + suns.len());
        let on = |most: f64, closest_px: f64| {
            let lattice = FogLattice::of(snapshot, size, (of_step, most, closest_px))?;
            Some(Self::on(lattice, snapshot, (&suns, g, channels)))
        };
        let mut fog = on(FIRST_NUMBERS, FIRST_SPACING_PX)?;
        let mut error = fog.error();
        while error > WANTED {
            let numbers = fog.numbers();
            drop(fog);
            // Between rays the error goes as their distance squared.
            fog = on((MARGIN * error / WANTED * numbers).min(MOST_NUMBERS), SPACING_PX)?;
            error = fog.error();
            let is_finest = fog.numbers() <= FINER * numbers;
            if is_finest {
                let is_large = fog.numbers() > 0.5 * MOST_NUMBERS;
                return (is_large && error <= TOLERANCE).then_some(fog);
            }
        }
        Some(fog)
    }

    fn on(lattice: FogLattice, snapshot: &Snapshot, (suns, g, channels): (&[DVec3], f64, usize)) -> Self {
        let (of_step, columns) = (channels * (1 + suns.len()), lattice.columns);
        let (rays, of_ray) = (lattice.rows * columns, of_step * (lattice.steps + 1));
        // What no line comes to write takes no memory.
        let (mut parts, mut of_part) = (vec![0; rays * of_ray], vec![0.0; rays * of_step]);
        let mut lines = vec![Line::default(); rays];
        let row = |(row, ((parts, of_part), lines)): (usize, Row)| {
            let (mut all, mut end) = (vec![0; of_ray], 0);
            for (column, (of_part, line)) in of_part.chunks_exact_mut(of_step).zip(lines).enumerate() {
                let ray = lattice.ray(row * columns + column);
                put(&mut all, of_part, &sums(&lattice, &ray, snapshot, suns), channels);
                let (skipped, steps) = changing(&all, of_step);
                let kept = &all[of_step * skipped..][..of_step * (steps + 1)];
                let first = (row * columns * of_ray + end) as u32;
                parts[end..][..kept.len()].copy_from_slice(kept);
                end += kept.len();
                *line = Line { first, skipped: skipped as u16, steps: steps as u16 };
            }
        };
        let by_row = parts.par_chunks_mut(columns * of_ray).zip(of_part.par_chunks_mut(columns * of_step));
        by_row.zip(lines.par_chunks_mut(columns)).enumerate().for_each(row);
        close_up(&mut parts, lines.iter_mut().map(|line| line.span(of_step)));
        Self { lattice, suns: suns.to_vec(), g, channels, lines, parts, of_part }
    }

    /// Root mean square error of a ray between those of the lattice. Where values are smooth it is a third of
    /// the difference between a ray and the mean of its four neighbours.
    fn error(&self) -> f64 {
        let FogLattice { columns, rows, .. } = self.lattice;
        let at_end = |ray: usize, quantity: usize| {
            let value = self.number(ray, self.lattice.steps, quantity);
            f64::from(if quantity == 0 { (-value).exp() } else { value })
        };
        let of_quantity = |quantity: usize| {
            let (mut errors, mut squares, mut count) = (0.0, 0.0, 0.0);
            for ray in
                (1..rows - 1).flat_map(|row| (1..columns - 1).map(move |column| row * columns + column))
            {
                let beside = [ray - 1, ray + 1, ray - columns, ray + columns];
                let mean = 0.25 * beside.map(|ray| at_end(ray, quantity)).iter().sum::<f64>();
                let value = at_end(ray, quantity);
                errors += (value - mean).powi(2) / 9.0;
                squares += value * value;
                count += 1.0;
            }
            if errors == 0.0 { 0.0 } else { (errors / if quantity == 0 { count } else { squares }).sqrt() }
        };
        (0..=self.suns.len()).map(of_quantity).fold(0.0, f64::max)
    }

    /// Number of values of all rays at all steps.
    fn numbers(&self) -> f64 {
        (self.lines.len() * (self.lattice.steps + 1) * self.of_step()) as f64
    }

    /// Number of values of a step.
    fn of_step(&self) -> usize {
        self.channels * (1 + self.suns.len())
    }

    fn number(&self, ray: usize, step: usize, quantity: usize) -> f32 {
        let (of_step, at) = (self.of_step(), quantity * self.channels);
        let part = self.parts[self.lines[ray].place(step, of_step) + at];
        self.of_part[ray * of_step + at] * f32::from(part)
    }

    /// A camera ray through it.
    pub fn along<'a>(&'a self, ray: &'a Ray) -> SeenRay<'a> {
        let between = self.lattice.between(ray);
        SeenRay { fog: self, ray, lines: between.map(|(ray, _)| self.lines[ray]), between }
    }
}

/// Optical depth and sunlight up to each step of a ray, and to the middle between each two.
fn sums(lattice: &FogLattice, ray: &Ray, snapshot: &Snapshot, suns: &[DVec3]) -> Vec<Vec<Rgb>> {
    // Steps are clamped to the fog's range, as its density may be anything at the ends.
    let (enter, leave) = snapshot.medium.range(ray, f64::INFINITY).unwrap_or_default();
    let steps = lattice.places(ray).into_iter().map(|place| place.min(leave).max(enter));
    let places = with_middles(&steps.collect::<Vec<f64>>());
    let before = snapshot.medium.before_each(ray, &places);
    let depths = before.depths();
    let of_suns: Vec<_> = suns.iter().map(|to_light| before.sunlight(*to_light, &depths)).collect();
    std::iter::once(depths).chain(of_suns).collect()
}

/// Puts a ray's sums at all steps, by step, as parts of the last.
fn put(parts: &mut [u16], of_part: &mut [f32], sums: &[Vec<Rgb>], channels: usize) {
    let of_step = of_part.len();
    for (at, of_part) in of_part.iter_mut().enumerate() {
        let (values, channel) = (&sums[at / channels], at % channels);
        let part = values.last().map_or(0.0, |whole| whole[channel]) / PARTS;
        *of_part = part as f32;
        for (step, value) in parts.chunks_exact_mut(of_step).zip(values.iter().step_by(2)) {
            // On a ray without fog 0 / 0, which is cast to 0.
            step[at] = (value[channel] / part).round() as u16;
        }
    }
}

/// Last step at which all values are 0, and number of steps from there to the first of those that stay as
/// they are.
fn changing(values: &[u16], of_step: usize) -> (usize, usize) {
    let steps: Vec<&[u16]> = values.chunks_exact(of_step).collect();
    let last = steps.len() - 1;
    let empty = steps.iter().take_while(|step| step.iter().all(|value| *value == 0)).count();
    let whole = steps.iter().rev().take_while(|step| **step == steps[last]).count();
    let skipped = empty.saturating_sub(1);
    (skipped, (last + 1 - whole).saturating_sub(skipped))
}

/// Places, with the middle between each two: depths to a sun count as linear between places, and half a step
/// has a quarter of the error.
fn with_middles(places: &[f64]) -> Vec<f64> {
    let pairs = places.windows(2).flat_map(|pair| [pair[0], 0.5 * (pair[0] + pair[1])]);
    pairs.chain(places.last().copied()).collect()
}

/// A camera ray between those of the lattice.
pub struct SeenRay<'a> {
    fog: &'a SeenFog,
    ray: &'a Ray,
    /// The rays around it, with their weights, and their lines.
    between: Between,
    lines: [Line; 4],
}

impl SeenRay<'_> {
    /// A quantity up to a place, which is given in steps.
    fn before(&self, step: f64, quantity: usize) -> Rgb {
        let SeenFog { lattice, channels, parts, of_part, .. } = self.fog;
        let first = (step as usize).min(lattice.steps - 1);
        let (later, of_step) = ((step - first as f64) as f32, self.fog.of_step());
        let channel = |channel: usize| {
            let (at, mut sum) = (quantity * channels + channel, 0.0);
            for (&(ray, weight), line) in self.between.iter().zip(&self.lines) {
                let [here, next] =
                    [first, first + 1].map(|step| f32::from(parts[line.place(step, of_step) + at]));
                sum += weight * of_part[ray * of_step + at] * (here + later * (next - here));
            }
            f64::from(sum)
        };
        if *channels == 1 { Rgb::splat(channel(0)) } else { Rgb::from_array([0, 1, 2].map(channel)) }
    }

    fn step(&self, t: f64) -> f64 {
        self.fog.lattice.step(self.ray, t)
    }

    /// Optical depth up to a distance.
    pub fn optical_depth(&self, t: f64) -> Rgb {
        self.before(self.step(t), 0)
    }

    /// Transmittance up to a distance.
    pub fn transmittance(&self, t: f64) -> Rgb {
        exp_minus(self.optical_depth(t))
    }

    /// Passage up to a distance with the parts that a sun lights; `None` for any other light.
    pub fn passage(&self, distance: f64, lit: &LitSegments, light: &FrozenLight) -> Option<Passage> {
        let FrozenLight::Sun { to_light, irradiance } = *light else { return None };
        let sun = self.fog.suns.iter().position(|sun| sun.dot(to_light) > NEAR)?;
        // Within fog alone, as fog begins or ends within a step.
        let fog = lit.within(0.0, f64::INFINITY);
        let ends = fog.end < distance;
        let before = |t: f64| {
            let step = self.step(t);
            let step = if t <= fog.start { step.floor() } else { step };
            self.before(if ends && t >= fog.end { step.ceil() } else { step }, 1 + sun)
        };
        let mut sum = Rgb::ZERO;
        lit.for_each_part(&lit.within(0.0, distance), |start, end, share| {
            sum += share * (before(end) - before(start));
        });
        let phase = henyey_greenstein(to_light.dot(self.ray.direction), self.fog.g);
        Some(Passage { scattered: phase * sum * irradiance, transmittance: self.transmittance(distance) })
    }

    /// Distance within a range at which a given share of its loss is reached, and the density there per
    /// metre: proportional to the extinction of light from the eye. `None` where nothing is lost.
    pub fn place_by_depth(&self, (start, end): (f64, f64), u: f64) -> Option<(f64, f64)> {
        let mean = |step: f64| self.before(step, 0).element_sum() / 3.0;
        let (first, last) = (self.step(start), self.step(end));
        let (before, all) = (mean(first), mean(last));
        let lost = -(before - all).exp_m1();
        if lost <= 0.0 {
            return None;
        }
        let wanted = before - (-u * lost).ln_1p();
        // Between steps depth is linear.
        let (mut low, mut high) = (first.floor(), last.ceil());
        while high - low > 1.0 {
            let middle = (0.5 * (low + high)).floor();
            if mean(middle) > wanted { high = middle } else { low = middle }
        }
        let (at_low, growth) = (mean(low), mean(high) - mean(low));
        let place = |step: f64| self.fog.lattice.place(self.ray, step);
        let t = place(low + ((wanted - at_low) / growth).clamp(0.0, 1.0));
        let density_per_m = growth / (place(high) - place(low)) * (before - wanted).exp() / lost;
        (density_per_m > 0.0).then_some((t, density_per_m))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_begins_before_the_fog_and_ends_behind_it() {
        assert_eq!(changing(&[0, 0, 0, 0, 1, 0, 2, 5, 2, 5], 2), (1, 2));
        assert_eq!(changing(&[0, 1, 2], 1), (0, 2));
        assert_eq!(changing(&[0, 0, 0], 1), (2, 0));
    }
}
