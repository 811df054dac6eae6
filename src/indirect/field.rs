//! Indirect light at every place: solved once for a shutter, queried by every ray. In goes a snapshot, out
//! comes a [`Field`]: nested grids around objects, and layers around these where unbounded fog lies over
//! plain ground. Invariant: grids and layers have light of the same orders.

use super::contents::Context;
use super::gathered::Gathered;
use super::layers::Layers;
use super::level::Level;
use super::lobe::Lobe;
use super::towards::Towards;
use crate::canopy::clumps::Clump;
use crate::canopy::fluence::Peak;
use crate::canopy::surroundings::Leaf;
use crate::color::Rgb;
use crate::ordinates::boundary::Surrounding;
use crate::ordinates::grid::Grid;
use crate::ordinates::high_degrees::SEEN_DEGREES;
use glam::DVec3;

/// Grids, the innermost first, and the layers around them.
pub(super) struct Field {
    pub(super) levels: Vec<Level>,
    pub(super) layers: Option<Layers>,
}

/// The finest part of a field that has a place: a grid or the layers.
enum Finest<'a> {
    Grid(&'a Level),
    Layers(&'a Layers),
}

impl Field {
    /// Solves on grids, which are given the innermost first, from the outermost inwards. Layers lie beyond.
    pub(super) fn on(grids: &[Grid], layers: Option<Layers>, context: &Context) -> Option<Self> {
        let mut levels: Vec<Level> = Vec::new();
        for (number, grid) in grids.iter().enumerate().rev() {
            let inner = number.checked_sub(1).map(|number| &grids[number]);
            let around = match (levels.last_mut(), &layers) {
                (Some(outer), _) => outer.around(grid),
                (None, Some(layers)) => layers.around(grid, context.snapshot.sky),
                (None, None) => Surrounding::default(),
            };
            levels.push(Level::new(*grid, (inner, around), layers.as_ref(), context));
        }
        levels.reverse();
        (!levels.is_empty() || layers.is_some()).then_some(Self { levels, layers })
    }

    /// Weight of a level at a place; without layers the outermost has the whole remainder.
    fn share(&self, number: usize, world: DVec3) -> f64 {
        let is_last = number + 1 == self.levels.len() && self.layers.is_none();
        if is_last { 1.0 } else { self.levels[number].share(world) }
    }

    /// Mean over the parts of the field that have a place, where one blends into another.
    fn mixed(
        &self,
        world: DVec3,
        of_level: impl Fn(&Level) -> Rgb,
        of_layers: impl Fn(&Layers) -> Rgb,
    ) -> Rgb {
        let (mut sum, mut left) = (Rgb::ZERO, 1.0);
        for (number, level) in self.levels.iter().enumerate() {
            let share = self.share(number, world);
            if share > 0.0 {
                sum += left * share * of_level(level);
            }
            left *= 1.0 - share;
            if left == 0.0 {
                return sum;
            }
        }
        self.layers.as_ref().map_or(sum, |layers| sum + left * of_layers(layers))
    }

    /// The finest part that has a place; `None` if there is none.
    fn at(&self, world: DVec3) -> Option<Finest<'_>> {
        let has_place = |number: &usize| self.share(*number, world) >= 0.5;
        let level = (0..self.levels.len()).find(has_place).map(|number| Finest::Grid(&self.levels[number]));
        level.or(self.layers.as_ref().map(Finest::Layers))
    }

    /// Light that a lobe gathers at a place in world space; for a cosine lobe, irradiance, W/m^2.
    pub(super) fn gathered_by(&self, world: DVec3, lobe: &Lobe) -> Rgb {
        self.mixed(world, |level| level.gathered_by(world, lobe), |layers| layers.gathered_by(world, lobe))
    }

    /// Radiance on the two sides of a leaf, without the leaf's own contribution.
    pub(super) fn gather_leaf(&self, number: usize, leaf: &Leaf) -> [Gathered; 2] {
        match self.at(leaf.position) {
            Some(Finest::Grid(level)) => level.gather_leaf(number, leaf),
            Some(Finest::Layers(layers)) => [0, 1].map(|_| layers.gathered(leaf.position)),
            None => [0, 1].map(|_| Gathered::NOTHING),
        }
    }

    /// Irradiance in a clump on a leaf with the albedo `sent`, from that on a single one.
    pub(super) fn in_clump(&self, clump: Clump, by_itself: Rgb, sent: Rgb) -> Rgb {
        self.levels.first().map_or(by_itself, |level| level.in_clump(clump, by_itself, sent))
    }

    /// Calls back with the forward peak of each sun at a place in world space.
    pub(super) fn for_each_peak(&self, world: DVec3, mut tell: impl FnMut(Peak)) {
        match self.at(world) {
            Some(Finest::Grid(level)) => level.peaks(world).for_each(&mut tell),
            Some(Finest::Layers(layers)) => layers.peaks(world).for_each(&mut tell),
            None => {}
        }
    }

    /// Prepares a direction of travel, a unit vector, for [`Field::scattered`].
    pub(super) fn towards(&self, travel: DVec3) -> Towards {
        Towards::new(travel, self.layers.as_ref().map(|layers| layers.harmonics_towards(travel)))
    }

    /// Radiance that fog at a place in world space scatters into a direction of travel, from coefficients by
    /// degree. Coefficients in 1/m give W m^-3 sr^-1, shares of extinction give radiance.
    pub(super) fn scattered(&self, world: DVec3, towards: &Towards, scattering: &[Rgb; SEEN_DEGREES]) -> Rgb {
        let layers = self.layers.as_ref();
        self.mixed(
            world,
            |level| level.scattered((world, layers), towards, scattering),
            |layers| layers.scattered(world, towards, scattering),
        )
    }

    /// Whether a wall stands between two places in world space that are less than a cell apart.
    pub(super) fn has_wall_between(&self, a: DVec3, b: DVec3) -> bool {
        match self.at(b) {
            Some(Finest::Grid(level)) => level.has_wall_between(a, b),
            Some(Finest::Layers(_)) | None => false,
        }
    }
}
