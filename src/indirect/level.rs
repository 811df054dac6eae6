//! Indirect light on one grid of several. In go a snapshot and the radiance around the grid. Out comes a
//! [`Level`] with irradiance on surfaces and radiance that fog scatters. Invariant: its light was scattered
//! at least once, or comes straight from the sky or from emissive surfaces and fog. Direct light of lamps and
//! suns is not part of it.

use super::contents::{Contents, Context};
use super::fog_edges::FogEdges;
use super::gathered::{Gathered, with_peaks};
use super::layer_detail::LayerDetail;
use super::layers::Layers;
use super::lobe::Lobe;
use super::sky::sky_of;
use super::towards::Towards;
use super::walls::SnapshotWalls;
use crate::canopy::clumps::{Clump, Clumps};
use crate::canopy::delta_scaled_fog::scatters_ahead;
use crate::canopy::fluence::{ForwardPeak, Peak};
use crate::canopy::leaf_power::LeafPower;
use crate::canopy::self_interaction::{Alone, Arriving, SelfInteraction};
use crate::canopy::surroundings::Leaf;
use crate::color::Rgb;
use crate::ordinates::angular_radiance::AngularRadiance;
use crate::ordinates::boundary::{IncidentRadiance, Surrounding, rim_places};
use crate::ordinates::cross_sections::Extinction;
use crate::ordinates::grid::{Corners, Grid};
use crate::ordinates::harmonics::{COUNT, DEGREE, product};
use crate::ordinates::high_degrees::{HighMoments, SEEN_DEGREES};
use crate::ordinates::moments::{Moments, NodeMoments};
use crate::ordinates::occluders::{CutGrid, OFF_WALL};
use crate::ordinates::quadrature::Quadrature;
use crate::ordinates::source_iteration::{Problem, Solution};
use crate::ordinates::sweep::Swept;
use crate::ordinates::walls::Walls;
use crate::snapshot::{FrozenSky, Snapshot};
use glam::DVec3;
use rayon::prelude::*;
use std::mem::take;

/// Distance from a surface, in cells, at which light is gathered.
const AWAY: f64 = 0.25;

/// Optical depth from which fog is deep along a side of a grid. If it is so along some sides alone and
/// scatters forward, the first order has fine ordinates: those of all orders are too few along these sides.
const DEEP: f64 = 4.0;

/// Light of all orders on one grid.
pub(super) struct Level {
    pub(super) grid: Grid,
    walls: Walls,
    /// Light for surfaces, at nodes and towards walls.
    light: Light,
    /// Moments for fog, where the sky lights surfaces alone.
    light_in_fog: Option<NodeMoments>,
    /// Moments of degrees 5 and 6, for fog that scatters forward.
    high: Option<HighMoments>,
    /// Light straight from emitters, for fog alone, where surfaces sample emitters by rays.
    of_emission: Option<Light>,
    /// Irradiance on each face of a wall by harmonics, W/m^2.
    on_faces: Vec<[f32; 3]>,
    /// Radiance at a finer grid's rim, until that is solved; without light straight from the sky.
    radiances: Vec<AngularRadiance>,
    sky_radiances: Option<AngularRadiance>,
    emitted_radiances: Option<AngularRadiance>,
    forward_peaks: Vec<ForwardPeak>,
    clumps: Clumps,
    extinction: Extinction,
    self_interaction: SelfInteraction,
    /// Vertical detail within cells, where layers lie around the grid.
    detail: Option<LayerDetail>,
    /// Edges of dense fog, where no layers lie around the grid.
    edges: Option<FogEdges>,
    on_leaves: LeafPower,
    /// Whether its orders hardly grow darker, so that the series was cut short.
    pub(super) is_endless: bool,
}

/// Moments up to degree 4.
struct Light {
    low: NodeMoments,
    /// Moments of degree 3, for glossy surfaces and for fog that scatters forward.
    third: Option<NodeMoments>,
    /// Moments of degree 4, which a cosine lobe gathers, too; orders of scattering do without.
    fourth: NodeMoments,
}

impl Light {
    fn of(low: &Moments, Swept { third, fourth, .. }: &Swept) -> Self {
        let third = third.as_ref().map(NodeMoments::of);
        Self { low: NodeMoments::of(low), third, fourth: NodeMoments::of(fourth) }
    }
}

/// Visible corners of each place around a finer grid. In clear air nodes within that grid are left out: their
/// radiance comes from its contents, which do not light themselves.
fn seen_about(inner: &Grid, grid: &Grid, walls: &Walls, snapshot: &Snapshot) -> Vec<Corners> {
    let seen_from = |place: DVec3| {
        let seen = walls.occluders.corners(grid, place, place);
        let is_clear = snapshot.medium.extinction_at(place - snapshot.view.eye) == Rgb::ZERO;
        let outside = if is_clear { seen.only(|node| !inner.holds(grid.position(node))) } else { None };
        outside.unwrap_or(seen)
    };
    rim_places(inner).into_par_iter().map(seen_from).collect()
}

/// Whether fog that scatters forward is deep along some of its sides within a grid, and not along others.
fn is_flat(grid: &Grid, snapshot: &Snapshot) -> bool {
    let (low, high) = grid.volume();
    let eye = snapshot.view.eye;
    snapshot.medium.banks().iter().filter(|bank| scatters_ahead(bank)).any(|bank| {
        let within = |(least, most): (DVec3, DVec3)| (low.max(least + eye), high.min(most + eye));
        let (low, high) = bank.bounds().map_or((low, high), within);
        is_deep_along_some((high - low) * bank.most_ever_per_m())
    })
}

/// Whether optical depths along axes are deep along some and not along others; fog beyond a grid has none.
fn is_deep_along_some(depths: DVec3) -> bool {
    depths.min_element() > 0.0 && depths.max_element() > DEEP && depths.min_element() < DEEP
}

impl Level {
    /// Solves a level with its incident radiance, and with the next finer grid within it.
    pub(super) fn new(
        grid: Grid,
        (inner, surrounding): (Option<&Grid>, Surrounding),
        layers: Option<&Layers>,
        context: &Context,
    ) -> Self {
        let &Context { snapshot, bounces, .. } = context;
        let contents = Contents::new(&grid, context);
        let walls = &contents.walls.walls;
        let next_to_inner = inner.map(|inner| seen_about(inner, &grid, walls, snapshot));
        let needs_fine = walls.are_at_angles() || surrounding.is_fine() || is_flat(&grid, snapshot);
        let (quadrature, fine) = (Quadrature::new(), needs_fine.then(Quadrature::fine));
        let self_interaction = SelfInteraction::new(&grid, &quadrature, bounces);
        let along = fine.as_ref().unwrap_or(&quadrature);
        let first = contents.first_light(context, along, &self_interaction);
        let sees_high = snapshot.medium.banks().iter().any(scatters_ahead);
        let sky = sky_of(snapshot.sky);
        let problem = Problem {
            domain: contents.domain(),
            quadrature: &quadrature,
            fine: fine.as_ref(),
            sky: sky.as_ref(),
            surrounding: &surrounding,
            bodies: &contents.bodies,
            orders: bounces.orders(),
            next_to_inner: next_to_inner.as_deref(),
            sees_third: snapshot.has_gloss() || sees_high,
            sees_high,
            cancelled: context.cancelled,
        };
        let mut solution = problem.solved(first.source);
        let emitted = solution.emitted.take();
        emitted.iter().for_each(|emitted| solution.last.add_high(emitted));
        let Contents { medium, walls: SnapshotWalls { walls, .. }, .. } = contents;
        let (clumps, extinction) = medium.for_gathering(&first.met_again);
        let light = Light::of(&solution.all, &solution.last);
        Self {
            on_faces: walls.on_faces(&light.low, solution.on_walls.as_ref()),
            walls,
            light,
            light_in_fog: light_in_fog(&solution, snapshot.sky),
            high: solution.last.high.as_ref().map(HighMoments::of),
            emitted_radiances: solution.emitted_radiances,
            of_emission: emitted.as_ref().map(|swept| Light::of(&swept.moments, swept)),
            radiances: solution.radiances,
            sky_radiances: solution.sky_radiances,
            forward_peaks: first.forward_peaks,
            clumps,
            extinction,
            self_interaction,
            detail: layers.and_then(|layers| LayerDetail::new(&grid, layers)),
            edges: if layers.is_none() { FogEdges::of(&grid, snapshot) } else { None },
            on_leaves: first.on_leaves,
            grid,
            is_endless: solution.is_endless,
        }
    }

    /// Incident radiance on the finer grid within it; it may be taken once.
    pub(super) fn around(&mut self, grid: &Grid) -> Surrounding {
        let of_things = |radiances| IncidentRadiance::without_ends(grid, radiances);
        Surrounding {
            scattered: take(&mut self.radiances).into_iter().map(of_things).collect(),
            of_sky: self.sky_radiances.take().map(|radiances| IncidentRadiance::new(grid, radiances)),
            emitted: self.emitted_radiances.take().map(of_things),
        }
    }

    /// Weight of the level at a place, where a larger grid or layers lie beyond.
    pub(super) fn share(&self, world: DVec3) -> f64 {
        self.grid.share(world)
    }

    /// Light that a lobe gathers at a place of the grid; for a cosine lobe, irradiance, W/m^2.
    pub(super) fn gathered_by(&self, world: DVec3, lobe: &Lobe) -> Rgb {
        let corners = self.corners_before(world, lobe.normal());
        let lit = self.walls.faces.of_corners(&corners, lobe.normal());
        let is_asked = |normal| lobe.is_cosine_of(normal);
        let on_faces = || self.walls.faces.mean(&lit, is_asked, &self.on_faces);
        let irradiance = on_faces().unwrap_or_else(|| {
            product(&lobe.of_travel(), &self.light.low.mean(&lit)) + self.beyond(&lit, lobe)
        });
        let peaks = self.forward_peaks.iter().map(|peak| peak.about(&corners).beam());
        with_peaks(irradiance, peaks, lobe)
    }

    /// Radiance on the two sides of a leaf, without the leaf's own contribution.
    pub(super) fn gather_leaf(&self, number: usize, leaf: &Leaf) -> [Gathered; 2] {
        // Its own emission is not in the light where that of all emitters is kept apart.
        let dark = self.of_emission.as_ref().and_then(|_| leaf.dark());
        let leaf = dark.as_ref().unwrap_or(leaf);
        let unmet = self.on_leaves.scattered(number, leaf);
        let alone = Alone::new(
            CutGrid { grid: &self.grid, occluders: &self.walls.occluders },
            (&self.extinction, &self.clumps.clumping),
            (leaf, unmet),
        );
        let clump = self.clumps.at(&self.grid, leaf.position);
        let mut sides = [0, 1].map(|side| {
            let corners = &alone.nodes[side][0];
            Gathered {
                moments: self.light.low.mean(corners),
                fourth: self.light.fourth.mean(corners),
                peaks: self.forward_peaks.iter().map(|peak| peak.about(corners)).collect(),
                clump: self.clumps.of_leaf(clump, leaf, unmet[side].all()),
            }
        });
        if !self.grid.holds(leaf.position) {
            return sides;
        }
        let arriving = sides.each_mut().map(|side| Arriving(&mut side.moments, &mut side.fourth));
        self.self_interaction.take(&alone, arriving);
        sides
    }

    /// Irradiance in a clump on a leaf with the albedo `sent`, from that on a single one.
    pub(super) fn in_clump(&self, clump: Clump, by_itself: Rgb, sent: Rgb) -> Rgb {
        self.clumps.gathered(clump, by_itself, sent)
    }

    /// Corners of a place slightly off a surface, so that its own radiance does not light it.
    fn corners_before(&self, world: DVec3, normal: DVec3) -> Corners {
        let cell_m = self.grid.cell_m;
        self.walls.occluders.corners(
            &self.grid,
            world + AWAY * cell_m * normal,
            world + OFF_WALL * cell_m * normal,
        )
    }

    /// Light that a lobe gathers from degrees 3 and 4.
    fn beyond(&self, lit: &Corners, lobe: &Lobe) -> Rgb {
        let of = |factors: Option<[f64; COUNT]>, moments: Option<&NodeMoments>| {
            factors.zip(moments).map_or(Rgb::ZERO, |(factors, moments)| product(&factors, &moments.mean(lit)))
        };
        of(lobe.of_third_of_travel(), self.light.third.as_ref())
            + of(lobe.of_fourth_of_travel(), Some(&self.light.fourth))
    }

    /// Forward peaks of suns at a place in world space.
    pub(super) fn peaks(&self, world: DVec3) -> impl Iterator<Item = Peak> {
        let corners = self.corners_seen_from(world);
        self.forward_peaks.iter().map(move |peak| peak.about(&corners))
    }

    /// Radiance that fog at a place of the grid scatters into a direction of travel, from coefficients by
    /// degree. Coefficients in 1/m give W m^-3 sr^-1, shares of extinction give radiance.
    pub(super) fn scattered(
        &self,
        (world, layers): (DVec3, Option<&Layers>),
        towards: &Towards,
        scattering: &[Rgb; SEEN_DEGREES],
    ) -> Rgb {
        let occluders = &self.walls.occluders;
        let moved = self.edges.as_ref().map(|edges| edges.place(&self.grid, world));
        let place =
            moved.filter(|place| occluders.is_free_between(&self.grid, world, *place)).unwrap_or(world);
        let corners = occluders.corners(&self.grid, place, world);
        let mut moments = self.light_in_fog.as_ref().unwrap_or(&self.light.low).mean(&corners);
        if let Some(emissive) = &self.of_emission {
            let added = emissive.low.mean(&corners);
            let sums = moments.as_flattened_mut().iter_mut();
            sums.zip(added.as_flattened()).for_each(|(sum, value)| *sum += value);
        }
        let of_channel = |channel: usize| -> f64 {
            let harmonic = |index: usize| {
                scattering[DEGREE[index]][channel] * towards.low[index] * f64::from(moments[channel][index])
            };
            (0..COUNT).map(harmonic).sum()
        };
        let mut by_harmonics = Rgb::new(of_channel(0), of_channel(1), of_channel(2));
        let is_whole = self.light.third.is_some() && self.light_in_fog.is_none();
        for light in is_whole.then_some(&self.light).into_iter().chain(&self.of_emission) {
            if let Some(third) = &light.third {
                by_harmonics += scattering[3] * product(&towards.third, &third.mean(&corners));
            }
            by_harmonics += scattering[4] * product(&towards.fourth, &light.fourth.mean(&corners));
        }
        let high = self.high.as_ref();
        let high = high.map_or(Rgb::ZERO, |high| high.scattered(&corners, &towards.high, scattering));
        let ratio =
            |(detail, layers): (&LayerDetail, &Layers)| detail.ratio(layers, (world, towards), scattering);
        let detail = self.detail.as_ref().zip(layers).map_or(Rgb::ONE, ratio);
        detail * (by_harmonics + high).max(Rgb::ZERO)
    }

    /// Corners of a place in world space without those that walls hide.
    fn corners_seen_from(&self, world: DVec3) -> Corners {
        self.walls.occluders.corners(&self.grid, world, world)
    }

    /// Whether a wall stands between two places in world space that are less than a cell apart.
    pub(super) fn has_wall_between(&self, a: DVec3, b: DVec3) -> bool {
        let Self { grid, walls, .. } = self;
        let lowest = [a, b].map(|place| grid.corners(place).nodes[0]);
        walls.occluders.hide(grid, lowest[0], a, b)
            || lowest[0] != lowest[1] && walls.occluders.hide(grid, lowest[1], a, b)
    }
}

/// Moments for fog where the sky lights surfaces alone: without light straight from the sky.
fn light_in_fog(lit: &Solution, sky: Option<FrozenSky>) -> Option<NodeMoments> {
    let of_sky = lit.of_sky.as_ref().filter(|_| sky.is_some_and(|sky| !sky.lights_fog()))?;
    let mut seen = lit.all.clone();
    seen.add(of_sky, [-1.0; 3]);
    Some(NodeMoments::of(&seen))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slabs_are_flat_and_cubes_are_not() {
        for (depths, is_flat) in [
            ([12.0, 0.8, 12.0], true),
            ([0.8, 12.0, 0.8], true),
            ([12.0, 12.0, 12.0], false),
            ([0.8, 0.8, 0.8], false),
            ([12.0, -1.0, 12.0], false),
        ] {
            assert_eq!(is_deep_along_some(depths.into()), is_flat, "{depths:?}");
        }
    }
}
