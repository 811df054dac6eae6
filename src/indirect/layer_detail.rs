//! Vertical detail of layers within the cells of a grid. In go a grid and the layers around it, out comes the
//! ratio of the light at a height to the mean that nodes have. Invariant: the ratio is 1 where cells are
//! small beside layers.
//!
//! Cells for leaves are often higher than a layer of mist. A node has the mean over the fog of its cell; the
//! plane-parallel solution gives the profile within the cell.

use super::layers::{FogLight, Layers};
use super::towards::Towards;
use crate::color::Rgb;
use crate::ordinates::grid::Grid;
use crate::ordinates::high_degrees::SEEN_DEGREES;
use glam::DVec3;

/// Maximum ratio, and the inverse of the minimum.
const MOST: f64 = 4.0;
/// Number of heights sampled in a cell.
const PLACES: usize = 16;

/// Detail for each row of nodes.
pub(super) struct LayerDetail {
    rows: Vec<Row>,
    lowest_m: f64,
    cell_m: f64,
}

/// Light of layers as nodes at a height have it; `None` below the ground.
type Row = Option<FogLight>;

impl LayerDetail {
    /// Detail of a grid; `None` where layers are not level, or change little within a cell.
    pub(super) fn new(grid: &Grid, layers: &Layers) -> Option<Self> {
        /// Size in scale heights below which a cell is small.
        const SMALL: f64 = 0.1;
        if !layers.are_level() || grid.cell_m < SMALL * layers.heights.scale_m {
            return None;
        }
        let (low, _) = grid.bounds();
        let rows = (0..grid.size[1]).map(|row| {
            let height_m = low.y + row as f64 * grid.cell_m;
            let is_above = layers.heights.ground_m().is_none_or(|ground_m| height_m > ground_m);
            is_above.then(|| mean_light(layers, height_m, grid.cell_m))
        });
        Some(Self { rows: rows.collect(), lowest_m: low.y, cell_m: grid.cell_m })
    }

    /// Ratio of the light scattered at a place to that interpolated from nodes.
    pub(super) fn ratio(
        &self,
        layers: &Layers,
        (world, towards): (DVec3, &Towards),
        scattering: &[Rgb; SEEN_DEGREES],
    ) -> Rgb {
        let last = self.rows.len() - 1;
        let along = ((world.y - self.lowest_m) / self.cell_m).clamp(0.0, last as f64);
        let row = (along as usize).min(last - 1);
        let Some(in_layers) = &towards.in_layers else { return Rgb::ONE };
        let [below, above] = [0, 1].map(|next| self.rows[row + next].as_ref());
        let as_nodes_tell = match (below, above) {
            (Some(below), Some(above)) => {
                let [below, above] = [below, above].map(|light| light.scattered(in_layers, scattering));
                below.lerp(above, along - row as f64)
            }
            (Some(only), None) | (None, Some(only)) => only.scattered(in_layers, scattering),
            (None, None) => return Rgb::ONE,
        };
        let true_light = layers.scattered(world, towards, scattering);
        let share = |channel: usize| match as_nodes_tell[channel] {
            estimate if estimate > 0.0 => (true_light[channel] / estimate).clamp(1.0 / MOST, MOST),
            _ => 1.0,
        };
        Rgb::new(share(0), share(1), share(2))
    }
}

/// Mean over the fog that a node represents: that of its cell, extended down to the ground where the next
/// node lies below it.
fn mean_light(layers: &Layers, height_m: f64, cell_m: f64) -> FogLight {
    let ground_m = layers.heights.ground_m().unwrap_or(f64::NEG_INFINITY);
    let low = if height_m - cell_m <= ground_m { ground_m } else { height_m - 0.5 * cell_m };
    let size = height_m + 0.5 * cell_m - low;
    let (mut sum, mut all) = (FogLight::ZERO, 0.0);
    for number in 0..PLACES {
        let at = low + size * (number as f64 + 0.5) / PLACES as f64;
        let weight = layers.heights.extinction_per_m(at * DVec3::Y);
        sum.add(&layers.fog_light(at * DVec3::Y), weight);
        all += weight;
    }
    if all > 0.0 { sum.scaled(1.0 / all) } else { layers.fog_light(height_m * DVec3::Y) }
}
