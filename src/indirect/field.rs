//! Indirect light everywhere: solved once for a shutter, asked by every ray. In goes a snapshot, out comes a
//! [`Field`] that tells irradiance on surfaces and light that fog scatters. Invariant: what it holds has been
//! scattered at least once, or comes from the sky; never straight from a lamp or a sun.

use super::first_light::FirstLight;
use super::fluence::Glow;
use super::grid::{Corners, Grid};
use super::harmonics::{COUNT, DEGREE, basis, by_lobe, irradiance_lobe};
use super::matter::Matter;
use super::moments::NodeMoments;
use super::occluders::OFF_WALL;
use super::ordinates::Ordinates;
use super::rounds::{Rounds, Scatterers};
use super::surroundings::Surroundings;
use super::sweep::Sweeper;
use super::swept_fog::SweptFog;
use super::wall_light::WallLight;
use super::walls::Walls;
use crate::color::Rgb;
use crate::scene::Bounces;
use crate::snapshot::Snapshot;
use glam::DVec3;

/// Nodes of a grid, about.
const NODES: f64 = 30_000.0;
/// A cell is no smaller than so many leaves: else a leaf that moves is now in one cell, now in another.
const LEAVES_PER_CELL: f64 = 2.0;
/// Along the longest side, however large leaves are.
const FEWEST_CELLS: f64 = 16.0;
/// Things at least so many cells wide are walls.
const WALL_CELLS: f64 = 2.0;

/// Away from a surface, in cells, light is gathered.
const AWAY: f64 = 0.25;

/// What comes to a place from all sides.
pub(super) struct Gathered {
    moments: [[f32; COUNT]; 3],
    /// Of each sun what goes on nearly straight, W/m^2 on a plane that faces it.
    glows: Vec<Rgb>,
}

/// Light of all orders at the nodes of a world grid.
pub(super) struct Field {
    grid: Grid,
    walls: Walls,
    /// All that surfaces get.
    light: NodeMoments,
    /// What fog gets: the same unless the sky lights surfaces alone.
    light_in_fog: Option<NodeMoments>,
    glows: Vec<Glow>,
    /// Whether the sky's own light is part of it.
    pub(super) has_sky: bool,
}

impl Field {
    /// `None` where there is nothing that could scatter light. Once `cancelled` says true,
    /// what comes is of no use.
    pub(super) fn new(
        snapshot: &Snapshot,
        surroundings: &Surroundings,
        bounces: Bounces,
        cancelled: &(dyn Fn() -> bool + Sync),
    ) -> Option<Self> {
        let grid = grid(snapshot, surroundings)?;
        let width = WALL_CELLS * grid.cell_m;
        let surfels = surroundings.surfels(width, grid.cell_m);
        let wall_triangles = surroundings.walls(width);
        let are_walls = wall_triangles.iter().map(|triangle| triangle.primitive).collect();
        let walls = Walls::new(&grid, snapshot, &wall_triangles).introduce();
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
        let sweeper = Sweeper::new(&grid, &matter, &walls, &ordinates);
        let (first_sources, glows) = first.sources();
        let wall_light = WallLight { snapshot, grid: &grid, fog: &fog, walls: &walls };
        let has_sky = snapshot.sky.is_some_and(|sky| !sky.has_sun());
        let scatterers = Scatterers { matter: &matter, walls: &walls };
        let rounds =
            Rounds { sweeper, scatterers, ordinates: &ordinates, sky: snapshot.sky, has_sky, cancelled };
        let (light, unseen_by_fog) = rounds.run(bounces, first_sources, &wall_light.irradiances());
        let light_in_fog = unseen_by_fog.map(|unseen| {
            let mut seen = light.clone();
            seen.add(&unseen, [-1.0; 3]);
            NodeMoments::of(&seen)
        });
        Some(Self { grid, walls, light: NodeMoments::of(&light), light_in_fog, glows, has_sky })
    }

    /// The irradiance on a surface at a place of world space on the side that `normal` faces, W/m^2.
    pub(super) fn irradiance(&self, world: DVec3, normal: DVec3) -> Rgb {
        let corners = self.corners_before(world, normal);
        self.on_surface(&self.light.mean(&corners), |glow| self.glows[glow].mean(&corners), normal)
    }

    /// What comes to a place of world space on the side that `normal` faces.
    pub(super) fn gather(&self, world: DVec3, normal: DVec3) -> Gathered {
        let corners = self.corners_before(world, normal);
        let glows = self.glows.iter().map(|glow| glow.mean(&corners)).collect();
        Gathered { moments: self.light.mean(&corners), glows }
    }

    /// The irradiance that it is on a surface that faces `normal`, W/m^2.
    pub(super) fn irradiance_of(&self, gathered: &Gathered, normal: DVec3) -> Rgb {
        self.on_surface(&gathered.moments, |glow| gathered.glows[glow], normal)
    }

    /// Nodes about a place a little away from a surface, so that what it sends out itself does not light it.
    fn corners_before(&self, world: DVec3, normal: DVec3) -> Corners {
        let cell_m = self.grid.cell_m;
        self.walls.occluders.corners(
            &self.grid,
            world + AWAY * cell_m * normal,
            world + OFF_WALL * cell_m * normal,
        )
    }

    fn on_surface(&self, moments: &[[f32; COUNT]; 3], arriving: impl Fn(usize) -> Rgb, normal: DVec3) -> Rgb {
        let mut irradiance = by_lobe(&irradiance_lobe(normal), moments);
        for (number, glow) in self.glows.iter().enumerate() {
            let cos = -glow.travel.dot(normal);
            if cos > 0.0 {
                irradiance += cos * arriving(number);
            }
        }
        irradiance
    }

    /// What of suns goes on nearly straight at a place of world space: directions of travel, and the
    /// irradiance on planes that face them.
    pub(super) fn glows(&self, world: DVec3) -> impl Iterator<Item = (DVec3, Rgb)> {
        let corners = self.walls.occluders.corners(&self.grid, world, world);
        self.glows.iter().map(move |glow| (glow.travel, glow.mean(&corners)))
    }

    /// What fog at a place of world space scatters into a direction of travel, for a coefficient by degree of
    /// harmonics: of 1/m W m^-3 sr^-1, of a share of extinction radiance.
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
        self.walls.occluders.hide(&self.grid, lowest[0], a, b)
            || lowest[0] != lowest[1] && self.walls.occluders.hide(&self.grid, lowest[1], a, b)
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
        moments.mean(&self.walls.occluders.corners(&self.grid, place, seen_from))
    }
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
