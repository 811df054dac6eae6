//! Indirect light everywhere: solved once for a shutter, asked by every ray. In goes a snapshot, out comes a
//! [`Field`]: grids where things are, the finest within the others, and layers about them where fog without
//! bounds lies over plain ground. Invariant: grids and layers know light of the same orders.

use super::gathered::Gathered;
use super::grid::Grid;
use super::halo::Around;
use super::layers::Layers;
use super::level::{Context, Level};
use super::lobe::Lobe;
use super::surroundings::Leaf;
use super::towards_eye::SEEN_DEGREES;
use crate::color::Rgb;
use crate::snapshot::Snapshot;
use glam::DVec3;

/// A grid with all that lies about it, or what lies about all grids.
pub(super) enum Field {
    Grid(Box<Level>),
    Layers(Box<Layers>),
}

/// Whether the sky's own light is part of it: not where a part of the sky is as bright as a sun, whose
/// shadows have borders.
pub(super) fn has_sky(snapshot: &Snapshot) -> bool {
    snapshot.sky.is_some_and(|sky| !sky.has_sun())
}

impl Field {
    /// Solves it on grids, the innermost first, from the outermost inwards; about that lie layers.
    pub(super) fn on(grids: &[Grid], layers: Option<Layers>, context: &Context) -> Option<Self> {
        let outermost = layers.map(|layers| Self::Layers(Box::new(layers)));
        grids.iter().enumerate().rev().fold(outermost, |outer, (number, grid)| {
            let inner = number.checked_sub(1).map(|number| &grids[number]);
            Some(Self::Grid(Box::new(Level::new(*grid, outer, inner, context))))
        })
    }

    /// What a grid within it gets from it, once.
    pub(super) fn around(&mut self, grid: &Grid, snapshot: &Snapshot) -> Around {
        match self {
            Self::Grid(level) => level.around(grid),
            Self::Layers(layers) => layers.around(grid, snapshot.sky),
        }
    }

    /// The finest part of it that has a place.
    fn at(&self, world: DVec3) -> &Self {
        match self {
            Self::Grid(level) => level.outer_at(world).map_or(self, |outer| outer.at(world)),
            Self::Layers(_) => self,
        }
    }

    /// What a surface gathers at a place of world space; by a cosine that is irradiance, W/m^2.
    pub(super) fn gathered_by(&self, world: DVec3, lobe: &Lobe) -> Rgb {
        match self {
            Self::Grid(level) => level.mixed(
                world,
                |level| level.gathered_by(world, lobe),
                |outer| outer.gathered_by(world, lobe),
            ),
            Self::Layers(layers) => layers.gathered_by(world, lobe),
        }
    }

    /// What comes to the two sides of a leaf of all light but its own.
    pub(super) fn gather_leaf(&self, number: usize, leaf: &Leaf) -> [Gathered; 2] {
        match self.at(leaf.position) {
            Self::Grid(level) => level.gather_leaf(number, leaf),
            Self::Layers(layers) => [0, 1].map(|_| layers.gathered(leaf.position)),
        }
    }

    /// What a leaf gathers of what it would by itself, where it sends a share of all light on.
    pub(super) fn within_mass(&self, world: DVec3, by_itself: Rgb, sent: Rgb) -> Rgb {
        match self.at(world) {
            Self::Grid(level) => level.within_mass(world, by_itself, sent),
            Self::Layers(_) => by_itself,
        }
    }

    /// What of it a lobe gathers on a leaf that sends a share of all light on; by a cosine that is
    /// irradiance, W/m^2.
    pub(super) fn of_gathered(&self, gathered: &Gathered, lobe: &Lobe, sent: Rgb) -> Rgb {
        match self {
            Self::Grid(level) => level.of_gathered(gathered, lobe, sent),
            Self::Layers(_) => gathered.by(lobe),
        }
    }

    /// Tells of each sun what goes on nearly straight at a place of world space: its direction of travel,
    /// irradiance on a plane that faces it, and how often it was scattered.
    pub(super) fn for_each_glow(&self, world: DVec3, mut tell: impl FnMut(DVec3, Rgb, f64)) {
        match self.at(world) {
            Self::Grid(level) => level.glows(world).for_each(|(travel, on, times)| tell(travel, on, times)),
            Self::Layers(layers) => {
                layers.glows(world).for_each(|(travel, on, times)| tell(travel, on, times))
            }
        }
    }

    /// What fog at a place of world space scatters into a direction of travel, for a coefficient
    /// by degree of harmonics: of 1/m W m^-3 sr^-1, of a share of extinction radiance. More is
    /// known of the way to the eye.
    pub(super) fn scattered(
        &self,
        world: DVec3,
        travel: (DVec3, bool),
        scattering: &[Rgb; SEEN_DEGREES],
    ) -> Rgb {
        match self {
            Self::Grid(level) => level.mixed(
                world,
                |level| level.scattered(world, travel, scattering),
                |outer| outer.scattered(world, travel, scattering),
            ),
            Self::Layers(layers) => layers.scattered(world, travel.0, scattering),
        }
    }

    /// Whether a wall stands between two places of world space that are less than a cell apart.
    pub(super) fn has_wall_between(&self, a: DVec3, b: DVec3) -> bool {
        match self.at(b) {
            Self::Grid(level) => level.has_wall_between(a, b),
            Self::Layers(_) => false,
        }
    }

    /// Whether its light goes on and on, as next to nothing absorbs it, and was cut short.
    pub(super) fn is_endless(&self) -> bool {
        self.levels().any(Level::is_endless)
    }

    fn level(&self) -> Option<&Level> {
        match self {
            Self::Grid(level) => Some(level),
            Self::Layers(_) => None,
        }
    }

    /// Its grids, the innermost first.
    pub(super) fn levels(&self) -> impl Iterator<Item = &Level> {
        std::iter::successors(self.level(), |level| level.outer().and_then(Self::level))
    }

    /// The layers about all grids, if there are any.
    pub(super) fn layers(&self) -> Option<&Layers> {
        match self {
            Self::Grid(level) => level.outer()?.layers(),
            Self::Layers(layers) => Some(layers),
        }
    }
}
