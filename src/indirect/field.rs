//! Indirect light everywhere: solved once for a shutter, asked by every ray. In goes a snapshot, out comes a [`Field`] that tells irradiance on surfaces and
//! light that fog scatters. Invariant: what it holds has been scattered at least once, or comes from the sky; never straight from a lamp or a sun.

use super::first_light::FirstLight;
use super::fluence::Glow;
use super::grid::Grid;
use super::harmonics::{COUNT, DEGREE, basis, irradiance_lobe};
use super::matter::Matter;
use super::moments::{Moments, NodeMoments};
use super::ordinates::Ordinates;
use super::surroundings::Surroundings;
use super::sweep::{Sources, Sweeper};
use super::swept_fog::SweptFog;
use super::wall_light::WallLight;
use super::walls::Walls;
use crate::color::Rgb;
use crate::math::kronecker;
use crate::scene::Bounces;
use crate::snapshot::Snapshot;
use glam::DVec3;
use std::f64::consts::{PI, TAU};

/// Nodes of a grid, about.
const NODES: f64 = 30_000.0;
/// A cell is no smaller than so many leaves: else a leaf that moves is now in one cell, now in another.
const LEAVES_PER_CELL: f64 = 2.0;
/// Along the longest side, however large leaves are.
const FEWEST_CELLS: f64 = 16.0;
/// Things at least so many cells wide are walls.
const WALL_CELLS: f64 = 2.0;
/// Rounds when all of them are wanted.
const MOST_ROUNDS: u32 = 24;
const FEWEST_ROUNDS: u32 = 3;
/// What is left after the last round, as a share of all light: a geometric series tells the rest well when it is small.
const REST: f64 = 0.003;
/// Of light that goes on and on: a closed scene that absorbs nothing has no end.
const MOST_RATIO: f64 = 0.98;

/// Light of all orders at the nodes of a world grid.
pub struct Field {
    grid: Grid,
    walls: Walls,
    /// All that surfaces get.
    light: NodeMoments,
    /// What fog gets: the same unless the sky lights surfaces alone.
    light_in_fog: Option<NodeMoments>,
    glows: Vec<Glow>,
}

impl Field {
    /// `None` where there is nothing that could scatter light. Once `cancelled` says true, what comes is of no use.
    pub fn new(snapshot: &Snapshot, bounces: Bounces, cancelled: &(dyn Fn() -> bool + Sync)) -> Option<Self> {
        let surroundings = Surroundings::of(snapshot);
        let grid = grid(snapshot, &surroundings)?;
        let width = WALL_CELLS * grid.cell_m;
        let surfels = surroundings.surfels(width);
        let wall_triangles = surroundings.walls(width);
        let are_walls = wall_triangles.iter().map(|triangle| triangle.primitive).collect();
        let walls = Walls::new(&grid, snapshot, wall_triangles).introduce();
        let fog = SweptFog::new(&snapshot.medium, bounces);
        let matter = Matter::new(&grid, &walls, snapshot.view.eye, &fog, &surfels);
        let first = FirstLight {
            snapshot,
            fog: &fog,
            grid: &grid,
            matter: &matter,
            cancelled,
            walls: &walls,
            are_walls,
        };
        let ordinates = Ordinates::new();
        let sweeper =
            Sweeper { grid: &grid, matter: &matter, walls: &walls, ordinates: &ordinates, cancelled };
        let (first_sources, glows) = first.sources();
        let wall_light = WallLight { snapshot, grid: &grid, fog: &fog, walls: &walls };
        let (light, unseen_by_fog) = Rounds { sweeper, wall_light, first_sources, snapshot }.run(bounces);
        let light_in_fog = unseen_by_fog.map(|unseen| {
            let mut seen = light.clone();
            seen.add(&unseen, [-1.0; 3]);
            NodeMoments::of(&seen)
        });
        Some(Self { grid, walls, light: NodeMoments::of(&light), light_in_fog, glows })
    }

    /// The irradiance on a surface at a place of world space on the side that `normal` faces, W/m^2.
    pub fn irradiance(&self, world: DVec3, normal: DVec3) -> Rgb {
        /// Away from the surface, so that what it sends out itself does not light it.
        const AWAY: f64 = 0.25;
        let place = world + AWAY * self.grid.cell_m * normal;
        let corners = self.walls.corners(&self.grid, place, world + 1e-3 * self.grid.cell_m * normal);
        let mut irradiance = by_lobe(&irradiance_lobe(normal), &self.light.mean(&corners));
        for glow in &self.glows {
            let cos = -glow.travel.dot(normal);
            if cos > 0.0 {
                irradiance += cos * glow.mean(&corners);
            }
        }
        irradiance
    }

    /// What of suns goes on nearly straight at a place of world space: directions of travel, and the irradiance on planes that face them.
    pub(super) fn glows(&self, world: DVec3) -> impl Iterator<Item = (DVec3, Rgb)> {
        let corners = self.walls.corners(&self.grid, world, world);
        self.glows.iter().map(move |glow| (glow.travel, glow.mean(&corners)))
    }

    /// What fog at a place of world space scatters into a direction of travel, for a coefficient by degree of harmonics: of 1/m W m^-3 sr^-1, of a share of extinction
    /// radiance.
    pub(super) fn scattered(&self, world: DVec3, travel: DVec3, scattering: &[Rgb; 3]) -> Rgb {
        let moments = self.about(world, world, self.light_in_fog.as_ref().unwrap_or(&self.light));
        let basis = basis(travel);
        let of_channel = |channel: usize| -> f64 {
            let harmonic = |index: usize| {
                scattering[DEGREE[index]][channel] * basis[index] * f64::from(moments[channel][index])
            };
            (0..COUNT).map(harmonic).sum()
        };
        Rgb::new(of_channel(0), of_channel(1), of_channel(2)).max(Rgb::ZERO)
    }

    /// Whether a wall stands between two places of world space that are less than a cell apart.
    pub(super) fn has_wall_between(&self, a: DVec3, b: DVec3) -> bool {
        let lowest = [a, b].map(|place| self.grid.corners(place).nodes[0]);
        self.walls.hide(lowest[0], a, b) || lowest[0] != lowest[1] && self.walls.hide(lowest[1], a, b)
    }

    /// The distance of nodes, metres.
    pub(super) fn cell_m(&self) -> f64 {
        self.grid.cell_m
    }

    /// Where it ends, in world space.
    pub(super) fn volume(&self) -> (DVec3, DVec3) {
        self.grid.volume()
    }

    /// Moments about a place, of the nodes that no wall hides from `seen_from`.
    #[inline]
    fn about(&self, place: DVec3, seen_from: DVec3, moments: &NodeMoments) -> [[f32; COUNT]; 3] {
        moments.mean(&self.walls.corners(&self.grid, place, seen_from))
    }
}

/// What a lobe gathers of moments, by channel; nothing where harmonics cut short would have less.
#[inline]
fn by_lobe(lobe: &[f64; COUNT], moments: &[[f32; COUNT]; 3]) -> Rgb {
    let lobe = lobe.map(|value| value as f32);
    let of_channel =
        |channel: usize| -> f32 { (0..COUNT).map(|index| lobe[index] * moments[channel][index]).sum() };
    Rgb::new(f64::from(of_channel(0)), f64::from(of_channel(1)), f64::from(of_channel(2))).max(Rgb::ZERO)
}

/// The nodes: about all fog that has bounds and all leaves; without either, about everything.
fn grid(snapshot: &Snapshot, surroundings: &Surroundings) -> Option<Grid> {
    let world =
        |(low, high): (DVec3, DVec3)| (snapshot.world_from_relative(low), snapshot.world_from_relative(high));
    let union = |a: (DVec3, DVec3), b: (DVec3, DVec3)| (a.0.min(b.0), a.1.max(b.1));
    let all = surroundings.bounds(0.0..f64::INFINITY);
    let fog = snapshot.medium.banks().iter().filter_map(|bank| bank.bounds()).map(world).reduce(union);
    let diagonal = |(low, high): (DVec3, DVec3)| (high - low).length();
    let widest = 0.1 * all.map_or(0.0, diagonal).max(fog.map_or(0.0, diagonal));
    let leaves = surroundings.bounds(0.0..widest);
    let (low, high) = [fog, leaves].into_iter().flatten().reduce(union).or(all)?;
    let side = (high - low).max(DVec3::splat(1e-3 * (high - low).max_element()));
    let fine = (side.element_product() / NODES).cbrt();
    let coarse = side.max_element() / FEWEST_CELLS;
    let of_leaves = LEAVES_PER_CELL * surroundings.leaf_width_m(widest);
    let cell_m = rung(fine.max(of_leaves.min(coarse)));
    (cell_m > 0.0 && cell_m.is_finite()).then(|| Grid::covering(low, high, cell_m))
}

/// The next of the sizes that cells may have: they change rarely where bounds move.
fn rung(cell_m: f64) -> f64 {
    2.0_f64.powf((2.0 * cell_m.log2()).ceil() / 2.0)
}

/// What is done from round to round.
struct Rounds<'a> {
    sweeper: Sweeper<'a>,
    wall_light: WallLight<'a>,
    first_sources: Moments,
    snapshot: &'a Snapshot<'a>,
}

impl Rounds<'_> {
    /// All light, and that part of it that fog is not to see.
    fn run(&self, bounces: Bounces) -> (Moments, Option<Moments>) {
        let Sweeper { grid, matter, walls, ordinates, .. } = self.sweeper;
        let dark = vec![Rgb::ZERO; ordinates.as_slice().len()];
        let patches = walls.patches.len();
        let mut sources = Moments::zero(grid.count());
        let mut of_walls = vec![Rgb::ZERO; patches];
        let mut light = Moments::zero(grid.count());
        let mut unseen_by_fog = None;
        if let Some(inflow) = self.inflow() {
            let no_walls = by_channel(&of_walls);
            let sky =
                self.sweeper.sweep(&Sources { of_matter: &sources, of_walls: &no_walls, inflow: &inflow });
            sources = matter.scatter(&sky);
            of_walls = self.reflected(&sky);
            light.add(&sky, [1.0; 3]);
            unseen_by_fog = self.snapshot.sky.filter(|sky| !sky.lights_fog()).map(|_| sky);
        }
        sources.add(&self.first_sources, [1.0; 3]);
        matter.emit(&mut sources);
        for ((sum, patch), irradiance) in
            of_walls.iter_mut().zip(&walls.patches).zip(self.wall_light.irradiances())
        {
            *sum += radiance(patch.scatters.reflectance * irradiance) + patch.scatters.emission;
        }
        let rounds = match bounces {
            Bounces::UpTo(count) => count,
            Bounces::All => MOST_ROUNDS,
        };
        let mut before: Option<[f64; 3]> = None;
        for round in 0..rounds {
            if (self.sweeper.cancelled)() {
                break;
            }
            let patches = by_channel(&of_walls);
            let next =
                self.sweeper.sweep(&Sources { of_matter: &sources, of_walls: &patches, inflow: &dark });
            light.add(&next, [1.0; 3]);
            let total = next.total();
            let rest = before.filter(|_| bounces == Bounces::All).map(|before| rest(before, total));
            before = Some(total);
            if let Some(rest) = rest {
                let all = light.total();
                let left = (0..3)
                    .map(|channel| rest[channel] * total[channel] / all[channel].max(f64::MIN_POSITIVE));
                if round + 1 >= FEWEST_ROUNDS && (left.fold(0.0, f64::max) < REST || round + 1 == rounds) {
                    light.add(&next, rest.map(|rest| rest as f32));
                    break;
                }
            }
            sources = matter.scatter(&next);
            of_walls = self.reflected(&next);
        }
        (light, unseen_by_fog)
    }

    /// What walls send back of light, as radiance.
    fn reflected(&self, light: &Moments) -> Vec<Rgb> {
        let walls = self.sweeper.walls;
        let irradiances = walls.irradiances(|node, normal| {
            by_lobe(&irradiance_lobe(normal), &[0, 1, 2].map(|channel| light.at(channel, node)))
        });
        let patches = walls.patches.iter().zip(irradiances);
        patches.map(|(patch, irradiance)| radiance(patch.scatters.reflectance * irradiance)).collect()
    }

    /// The sky's radiance along each ordinate, on the mean of the directions that are nearest to it.
    fn inflow(&self) -> Option<Vec<Rgb>> {
        const DIRECTIONS: usize = 6000;
        let sky = self.snapshot.sky.filter(|sky| sky.lights_surfaces())?;
        let ordinates = self.sweeper.ordinates;
        let mut sums = vec![(Rgb::ZERO, 0.0); ordinates.as_slice().len()];
        for number in 0..DIRECTIONS {
            let y = 1.0 - 2.0 * (number as f64 + 0.5) / DIRECTIONS as f64;
            let (sin, cos) = (TAU * kronecker(0.0, number)).sin_cos();
            let across = (1.0 - y * y).sqrt();
            let direction = DVec3::new(across * cos, y, across * sin);
            let (sum, count) = &mut sums[ordinates.nearest(-direction)];
            let radiance = sky.along(direction);
            if radiance.is_finite() {
                *sum += radiance;
            }
            *count += 1.0;
        }
        Some(sums.into_iter().map(|(sum, count)| sum / f64::max(count, 1.0)).collect())
    }
}

/// What follows a round, in units of it, if it goes on as from the round before.
fn rest(before: [f64; 3], total: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|channel| {
        let ratio = if before[channel] > 0.0 {
            (total[channel] / before[channel]).clamp(0.0, MOST_RATIO)
        } else {
            0.0
        };
        ratio / (1.0 - ratio)
    })
}

fn by_channel(colors: &[Rgb]) -> [Vec<f32>; 3] {
    [0, 1, 2].map(|channel| colors.iter().map(|color| color[channel] as f32).collect())
}

/// A wall's radiosity, as radiance.
fn radiance(radiosity: Rgb) -> Rgb {
    radiosity / PI
}
