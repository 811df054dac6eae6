//! Indirect light on one grid, and on those about it. In goes a snapshot, out comes a [`Level`] that tells
//! irradiance on surfaces and light that fog scatters. Invariant: what it holds has been scattered at least
//! once, or comes from the sky; never straight from a lamp or a sun.

use super::cut_patches::cut_patches;
use super::extinction::Extinction;
use super::first_light::{FirstLight, Found};
use super::fluence::Glow;
use super::gathered::{Gathered, with_glows};
use super::grid::{Corners, Grid};
use super::halo::{Around, Halo, places_about};
use super::harmonics::{COUNT, DEGREE, product};
use super::high_degrees::{HighMoments, SEEN_DEGREES};
use super::layer_detail::LayerDetail;
use super::layers::Layers;
use super::leaf_index::LeafIndex;
use super::leaf_power::LeafPower;
use super::lobe::Lobe;
use super::masses::Masses;
use super::matter::Matter;
use super::moments::NodeMoments;
use super::occluders::OFF_WALL;
use super::ordinates::Ordinates;
use super::own_light::{Alone, Arriving, OwnLight};
use super::radiances::Radiances;
use super::rounds::{Light, Rounds, Scatterers, has_sky};
use super::surroundings::{Leaf, Surfels, Surroundings, WallTriangle};
use super::sweep::Sweeper;
use super::swept_fog::SweptFog;
use super::towards::Towards;
use super::wall_light::WallLight;
use super::walls::Walls;
use crate::color::Rgb;
use crate::scene::Bounces;
use crate::snapshot::{FrozenSky, Snapshot};
use glam::DVec3;
use rayon::prelude::*;

/// Things at least so many cells wide are walls.
pub(super) const WALL_CELLS: f64 = 2.0;

/// Away from a surface, in cells, light is gathered.
const AWAY: f64 = 0.25;

/// What a field is solved for.
pub(super) struct Context<'a> {
    pub(super) snapshot: &'a Snapshot<'a>,
    pub(super) surroundings: &'a Surroundings<'a>,
    pub(super) leaves: &'a LeafIndex,
    pub(super) bounces: Bounces,
    /// Once it says true, what comes is of no use.
    pub(super) cancelled: &'a (dyn Fn() -> bool + Sync),
}

/// Light of all orders at the nodes of a world grid.
pub(super) struct Level {
    grid: Grid,
    walls: Walls,
    /// All that surfaces get, at nodes and towards walls.
    light: NodeMoments,
    /// The same of degree 3, where things shine.
    third: Option<NodeMoments>,
    /// And of degree 4: a cosine gathers a share of it, orders of scattering do without.
    fourth: NodeMoments,
    /// What fog gets: the same unless the sky lights surfaces alone.
    light_in_fog: Option<NodeMoments>,
    /// And of degrees 5 and 6, where fog scatters ahead.
    high: Option<HighMoments>,
    /// Of each face of a wall the irradiance by harmonics, W/m^2.
    on_faces: Vec<[f32; 3]>,
    /// What a finer grid within it gets, until that is solved; apart from what comes straight from the sky.
    radiances: Option<Radiances>,
    sky_radiances: Option<Radiances>,
    glows: Vec<Glow>,
    masses: Masses,
    extinction: Extinction,
    own_light: OwnLight,
    /// What its cells are too large for, where layers lie about it.
    detail: Option<LayerDetail>,
    on_leaves: LeafPower,
    is_endless: bool,
}

/// Small things that a grid holds.
fn surfels_of(grid: &Grid, surroundings: &Surroundings) -> Surfels {
    let mut surfels = surroundings.surfels(WALL_CELLS * grid.cell_m, grid.cell_m);
    surfels.all.retain(|surfel| grid.holds(surfel.position));
    surfels
}

/// Walls, each patch of which knows who sees it.
fn walls_of((grid, snapshot): (&Grid, &Snapshot), triangles: &[WallTriangle]) -> Walls {
    let mut walls = Walls::new(grid, snapshot, triangles);
    cut_patches((grid, snapshot), &mut walls);
    walls.introduce()
}

/// Nodes that are seen from each place about a finer grid.
fn seen_about(inner: &Grid, grid: &Grid, walls: &Walls) -> Vec<Corners> {
    let seen_from = |place: DVec3| walls.occluders.corners(grid, place, place);
    places_about(inner).into_par_iter().map(seen_from).collect()
}

/// What leaves and fog make of lamps and suns.
fn first_light(
    (grid, walls, triangles): (&Grid, &Walls, &[WallTriangle]),
    (matter, fog): (&Matter, &SweptFog),
    &Context { snapshot, leaves, cancelled, .. }: &Context,
) -> Found {
    let are_walls = triangles.iter().map(|triangle| triangle.primitive).collect();
    FirstLight { snapshot, fog, grid, matter, cancelled, walls, leaves, are_walls }.found()
}

impl Level {
    /// With what comes in from about it, and the finer grid that lies within.
    pub(super) fn new(
        grid: Grid,
        (inner, around): (Option<&Grid>, Around),
        layers: Option<&Layers>,
        context: &Context,
    ) -> Self {
        let &Context { snapshot, surroundings, leaves, bounces, cancelled } = context;
        let (sky, eye) = (snapshot.sky, snapshot.view.eye);
        let triangles = surroundings.walls(WALL_CELLS * grid.cell_m);
        let walls = walls_of((&grid, snapshot), &triangles);
        let next_to_inner = inner.map(|inner| seen_about(inner, &grid, &walls));
        let fog = SweptFog::new(&snapshot.medium, bounces);
        let matter = Matter::new((&grid, &walls), eye, &fog, &surfels_of(&grid, surroundings), bounces);
        let needs_fine = walls.are_at_angles() || around.is_fine();
        let (ordinates, fine) = (Ordinates::new(), needs_fine.then(Ordinates::fine));
        let sweeper = Sweeper::new(&grid, &matter, &walls, &ordinates);
        let Found { sources, beams, glows, met_again, on_leaves } =
            first_light((&grid, &walls, &triangles), (&matter, &fog), context);
        let along = fine.as_ref().unwrap_or(&ordinates);
        let lit = WallLight { snapshot, grid: &grid, fog: &fog, walls: &walls, ordinates: along }.found();
        let rounds = Rounds {
            sweeper,
            scatterers: Scatterers { matter: &matter, walls: &walls },
            ordinates: &ordinates,
            grid: &grid,
            sky,
            has_sky: has_sky(sky),
            beams,
            fine: fine.as_ref(),
            highlights: lit.highlights,
            next_to_inner: next_to_inner.as_deref(),
            sees_third: snapshot.has_gloss() || HighMoments::matter(&snapshot.medium),
            sees_high: HighMoments::matter(&snapshot.medium),
            cancelled,
        };
        let own_light = OwnLight::new(&grid, &ordinates, bounces);
        let again = own_light.all_sent_again((&grid, &walls.occluders), &matter, (leaves, &on_leaves));
        let lit = rounds.run(bounces, (sources, again), &lit.irradiances, &around);
        let (masses, extinction) = matter.told(&met_again);
        let (light, fourth) = (NodeMoments::of(&lit.all), NodeMoments::of(&lit.last.fourth));
        Self {
            on_faces: walls.faces.irradiances(&light),
            walls,
            light,
            third: lit.last.third.as_ref().map(NodeMoments::of),
            fourth,
            light_in_fog: light_in_fog(&lit, sky),
            high: lit.last.high.as_ref().map(HighMoments::of),
            radiances: lit.last.radiances,
            sky_radiances: lit.sky_radiances,
            glows,
            masses,
            extinction,
            own_light,
            detail: layers.and_then(|layers| LayerDetail::new(&grid, layers)),
            on_leaves,
            grid,
            is_endless: lit.is_endless,
        }
    }

    /// What a finer grid within it gets from it, once.
    pub(super) fn around(&mut self, grid: &Grid) -> Around {
        let halo = |radiances: Option<Radiances>| Some(Halo::new(grid, radiances?));
        Around { scattered: halo(self.radiances.take()), of_sky: halo(self.sky_radiances.take()) }
    }

    /// How far a place counts as one of it, where something lies about it.
    pub(super) fn share(&self, world: DVec3) -> f64 {
        self.grid.share(world)
    }

    /// What a surface gathers at a place of the grid; by a cosine that is irradiance, W/m^2.
    pub(super) fn gathered_by(&self, world: DVec3, lobe: &Lobe) -> Rgb {
        let corners = self.corners_before(world, lobe.normal());
        let lit = self.walls.faces.of_corners(&corners, lobe.normal());
        let on_faces = || self.walls.faces.mean(&lit, lobe, &self.on_faces);
        let irradiance = on_faces()
            .unwrap_or_else(|| product(&lobe.of_travel(), &self.light.mean(&lit)) + self.beyond(&lit, lobe));
        with_glows(irradiance, self.glows.iter().map(|glow| (glow.travel, glow.mean(&corners))), lobe)
    }

    /// What comes to the two sides of a leaf of all light but its own.
    pub(super) fn gather_leaf(&self, number: usize, leaf: &Leaf) -> [Gathered; 2] {
        let unmet = self.on_leaves.scattered(number, leaf);
        let alone = Alone::new(
            (&self.grid, &self.walls.occluders),
            (&self.extinction, self.masses.clumping()),
            (leaf, unmet),
        );
        let mass = self.masses.at(&self.grid, leaf.position);
        let mut sides = [0, 1].map(|side| {
            let corners = &alone.nodes[side][0];
            Gathered {
                moments: self.light.mean(corners),
                fourth: self.fourth.mean(corners),
                glows: self.glows.iter().map(|glow| (glow.travel, glow.mean(corners))).collect(),
                mass: self.masses.of_leaf(mass, leaf, unmet[side].all()),
            }
        });
        if !self.grid.holds(leaf.position) {
            return sides;
        }
        let arriving = sides.each_mut().map(|side| Arriving(&mut side.moments, &mut side.fourth));
        self.own_light.take(&alone, arriving);
        sides
    }

    /// What of it a lobe gathers on a leaf that sends a share of all light on; by a cosine that is
    /// irradiance, W/m^2.
    pub(super) fn of_gathered(&self, gathered: &Gathered, lobe: &Lobe, sent: Rgb) -> Rgb {
        self.masses.gathered(gathered.mass, gathered.by(lobe), sent)
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

    /// What a lobe gathers by degrees 3 and 4.
    fn beyond(&self, lit: &Corners, lobe: &Lobe) -> Rgb {
        let of = |factors: Option<[f64; COUNT]>, moments: Option<&NodeMoments>| {
            factors.zip(moments).map_or(Rgb::ZERO, |(factors, moments)| product(&factors, &moments.mean(lit)))
        };
        of(lobe.of_third_of_travel(), self.third.as_ref())
            + of(lobe.of_fourth_of_travel(), Some(&self.fourth))
    }

    /// What of suns goes on nearly straight at a place of world space: its direction of travel, irradiance on
    /// a plane that faces it, and how often it was scattered.
    pub(super) fn glows(&self, world: DVec3) -> impl Iterator<Item = (DVec3, Rgb, f64)> {
        let corners = self.corners_seen_from(world);
        self.glows.iter().map(move |glow| (glow.travel, glow.mean(&corners), glow.mean_times(&corners)))
    }

    /// What fog at a place of the grid scatters into a direction of travel, for a coefficient
    /// by degree of harmonics: of 1/m W m^-3 sr^-1, of a share of extinction radiance.
    pub(super) fn scattered(
        &self,
        (world, layers): (DVec3, Option<&Layers>),
        towards: &Towards,
        scattering: &[Rgb; SEEN_DEGREES],
    ) -> Rgb {
        let corners = self.corners_seen_from(world);
        let moments = self.moments_in_fog(&corners);
        let of_channel = |channel: usize| -> f64 {
            let harmonic = |index: usize| {
                scattering[DEGREE[index]][channel] * towards.low[index] * f64::from(moments[channel][index])
            };
            (0..COUNT).map(harmonic).sum()
        };
        let mut by_harmonics = Rgb::new(of_channel(0), of_channel(1), of_channel(2));
        if let Some(third) = self.third.as_ref().filter(|_| self.light_in_fog.is_none()) {
            by_harmonics += scattering[3] * product(&towards.third, &third.mean(&corners));
            by_harmonics += scattering[4] * product(&towards.fourth, &self.fourth.mean(&corners));
        }
        let high = self.high.as_ref();
        let high = high.map_or(Rgb::ZERO, |high| high.scattered(&corners, &towards.high, scattering));
        let ratio =
            |(detail, layers): (&LayerDetail, &Layers)| detail.ratio(layers, (world, towards), scattering);
        let detail = self.detail.as_ref().zip(layers).map_or(Rgb::ONE, ratio);
        detail * (by_harmonics + high).max(Rgb::ZERO)
    }

    /// Nodes about a place of world space that no wall hides.
    fn corners_seen_from(&self, world: DVec3) -> Corners {
        self.walls.occluders.corners(&self.grid, world, world)
    }

    /// Moments of the light that fog gets of them.
    fn moments_in_fog(&self, corners: &Corners) -> [[f32; COUNT]; 3] {
        self.light_in_fog.as_ref().unwrap_or(&self.light).mean(corners)
    }

    /// Whether a wall stands between two places of world space that are less than a cell apart.
    pub(super) fn has_wall_between(&self, a: DVec3, b: DVec3) -> bool {
        let Self { grid, walls, .. } = self;
        let lowest = [a, b].map(|place| grid.corners(place).nodes[0]);
        walls.occluders.hide(grid, lowest[0], a, b)
            || lowest[0] != lowest[1] && walls.occluders.hide(grid, lowest[1], a, b)
    }

    /// Whether its light goes on and on, as next to nothing absorbs it, and was cut short.
    pub(super) fn is_endless(&self) -> bool {
        self.is_endless
    }

    /// The distance of nodes, metres.
    pub(super) fn cell_m(&self) -> f64 {
        self.grid.cell_m
    }

    /// Where the grid ends, in world space.
    pub(super) fn volume(&self) -> (DVec3, DVec3) {
        self.grid.volume()
    }
}

/// What fog gets where the sky lights surfaces alone: all but what comes straight from there.
fn light_in_fog(lit: &Light, sky: Option<FrozenSky>) -> Option<NodeMoments> {
    let of_sky = lit.of_sky.as_ref().filter(|_| sky.is_some_and(|sky| !sky.lights_fog()))?;
    let mut seen = lit.all.clone();
    seen.add(of_sky, [-1.0; 3]);
    Some(NodeMoments::of(&seen))
}
