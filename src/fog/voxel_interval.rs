//! An interval of a ray through voxels under a sun. In go cells and the depths towards the sun, out comes the
//! light scattered on lit parts. Invariant: optical depths to the eye are exact; every cell has its own Gauss
//! rule for the product with transmittance.

use super::FogBank;
use super::bank::OPAQUE;
use super::beer_lambert::exp_minus;
use super::phase::henyey_greenstein;
use super::ray_interval::RayInterval;
use super::voxel_cells::VoxelCells;
use super::voxel_fog::MetresToSun;
use crate::color::Rgb;
use crate::math::{Ray, gauss_legendre};
use glam::DVec3;

/// Maximum optical depth of the densest fog for one rule, and the minimum share of a voxel.
const DEEPEST: f64 = 2.0;
const THINNEST: f64 = 1.0 / 64.0;

/// An interval, with values that are constant on it.
pub(super) struct VoxelInterval<'a> {
    interval: &'a RayInterval<'a>,
    cos: f64,
    inside: Vec<Bank<'a>>,
    /// Banks of voxels between the ray and the sun.
    to_sun: Vec<ToSun<'a>>,
    /// All other banks, and whether they scatter here.
    others: Others,
    others_scatter: bool,
    /// Length over which the depth to the sun is nearly a cubic, where no cell limits it, metres.
    longest_m: f64,
    /// Length over which light may fall strongly, metres.
    steepest_m: f64,
    /// Whether the interval is so deep that part of it may be invisible.
    is_deep: bool,
}

/// Voxels between the ray and a sun.
struct ToSun<'a> {
    fog: &'a FogBank,
    /// Lattice of depths; `None` for a direction without one.
    lattice: Option<MetresToSun>,
}

/// Banks without voxels: optical depth to the eye and the sun, and scattering towards the eye, 1/(m sr).
enum Others {
    /// As dense all over: depth at the start, and its growth per metre.
    Even { tau: (Rgb, Rgb), scattering: Rgb },
    /// Some thin out. By a mask of numbers.
    Thinning(u64),
}

impl Others {
    fn new(interval: &RayInterval, banks: u64, cos: f64) -> Self {
        let of_banks = |t: f64| interval.of_banks(banks, t, cos);
        if !interval.are_even(banks) {
            return Self::Thinning(banks);
        }
        Self::Even { tau: interval.line(|t| of_banks(t).0), scattering: of_banks(interval.middle()).1 }
    }
}

struct Bank<'a> {
    cells: &'a VoxelCells,
    sigma_t: Rgb,
    /// Scattering towards the eye at maximum density, 1/(m sr).
    scattering: Rgb,
    metres_at_start: f64,
    /// Number of the cell or gap that the integral has come to.
    cursor: usize,
}

impl Bank<'_> {
    /// Metres since the start, and the density, as of the densest.
    fn at(&self, t: f64) -> (f64, f64) {
        let (metres, density) = self.cells.at(self.cursor, t);
        (metres - self.metres_at_start, density)
    }
}

impl<'a> VoxelInterval<'a> {
    /// `None` where no voxels affect the scattered light.
    pub(super) fn new(interval: &'a RayInterval, to_light: DVec3) -> Option<Self> {
        let RayInterval { medium, ray, start, .. } = *interval;
        let cos = to_light.dot(ray.direction);
        let (mut inside, mut to_sun, mut others) = (Vec::new(), Vec::new(), 0);
        let (mut longest_m, mut voxel_m) = (f64::INFINITY, f64::INFINITY);
        let way = Ray { origin: ray.at(interval.middle()), direction: to_light };
        for (number, fog) in medium.banks().iter().enumerate() {
            let Some(voxels) = fog.voxels() else {
                others |= 1 << number;
                continue;
            };
            if let Some(cells) = interval.along.cells(number).filter(|_| interval.is_inside(number)) {
                let scattering = fog.sigma_s * henyey_greenstein(cos, fog.g);
                let metres_at_start = cells.metres(start);
                inside.push(Bank { cells, sigma_t: fog.sigma_t, scattering, metres_at_start, cursor: 0 });
                voxel_m = voxels.voxel_m(ray).min(voxel_m);
            }
            if fog.lies_on(&way) {
                to_sun.push(ToSun { fog, lattice: voxels.towards_sun(ray, to_light) });
                longest_m = voxels.voxel_m(ray).min(longest_m);
            }
        }
        let others_scatter = interval.is_inside_of(others);
        let others = Others::new(interval, others, cos);
        let changes = !inside.is_empty() || !to_sun.is_empty();
        let steepest_m = (DEEPEST / medium.most_extinction_per_m()).max(THINNEST * voxel_m);
        let is_deep = medium.most_extinction_per_m() * (interval.end - start) > OPAQUE;
        changes.then_some(Self {
            interval,
            cos,
            inside,
            to_sun,
            others,
            others_scatter,
            longest_m,
            steepest_m,
            is_deep,
        })
    }

    /// Integral over a lit part, 1/sr.
    pub(super) fn integral(&mut self, start: f64, end: f64) -> Rgb {
        let mut sum = Rgb::ZERO;
        self.inside.iter_mut().for_each(|bank| bank.cursor = bank.cells.cursor(start));
        let mut from = start;
        while from < end && !self.is_opaque(from) {
            let (mut to, mut is_in_a_cell) = (end, false);
            for bank in &mut self.inside {
                let (border, is_cell) = bank.cells.next_border(&mut bank.cursor, from);
                to = border.min(to);
                is_in_a_cell |= is_cell;
            }
            if self.others_scatter {
                to = to.min((from + self.longest_m).max(from.next_up()));
            }
            if is_in_a_cell {
                to = to.min((from + self.steepest_m).max(from.next_up()));
            }
            if is_in_a_cell || self.others_scatter {
                sum += self.within_cells(from, to);
            }
            from = to;
        }
        sum
    }

    /// Whether the voxels before a place are opaque.
    fn is_opaque(&self, t: f64) -> bool {
        let depth = |bank: &Bank| bank.sigma_t.min_element() * bank.at(t).0;
        self.is_deep && self.inside.iter().map(depth).sum::<f64>() > OPAQUE
    }

    /// Integral between two places without a border of a cell between them.
    fn within_cells(&self, start: f64, end: f64) -> Rgb {
        let half = 0.5 * (end - start);
        // Two nodes are exact for a cubic, and a small depth hardly bends it.
        let nodes = if self.interval.medium.most_extinction_per_m() * half < 0.05 { 2 } else { 3 };
        let mut sum = Rgb::ZERO;
        for (node, weight) in gauss_legendre(nodes) {
            let t = start + half * (1.0 + node);
            let (mut tau, mut scattering) = match self.others {
                Others::Even { tau: (at_start, per_m), scattering } => {
                    (at_start + (t - self.interval.start) * per_m, scattering)
                }
                Others::Thinning(banks) => self.interval.of_banks(banks, t, self.cos),
            };
            for bank in &self.inside {
                let (metres, density) = bank.at(t);
                tau += bank.sigma_t * metres;
                scattering += bank.scattering * density;
            }
            for ToSun { fog, lattice } in &self.to_sun {
                let exact = || fog.metres_to(self.interval.ray.at(t), self.interval.light);
                tau += fog.sigma_t * lattice.as_ref().map_or_else(exact, |lattice| lattice.at(t));
            }
            sum += *weight * scattering * exp_minus(tau);
        }
        half * sum
    }
}
