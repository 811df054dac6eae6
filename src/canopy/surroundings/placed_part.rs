//! A part of a placed mesh, and whether it is a leaf or a wall. In go its sides, out comes its kind.
//! Invariant: the kind depends on the part and on the width of cells alone, not on neighbours.

use crate::snapshot::MeshPart;

/// Minimum width and length of a panel, as shares of a width that suffices by itself.
const NARROWEST: f64 = 0.25;
const SHORTEST: f64 = 2.0;

/// Minimum exposed share: a rolled leaf shades nearly all of itself.
const LEAST_EXPOSED: f64 = 0.1;

/// A part of a placed mesh. There may be a million.
pub(super) struct PlacedPart<'a> {
    pub(super) mesh_number: u32,
    pub(super) part: &'a MeshPart,
    pub(super) number: u32,
    /// Number of its look. Parts with the same look in all places share it: those with the same mesh,
    /// material and part number, blended or not.
    pub(super) looks: u32,
    /// The shortest side of its bounds, metres.
    pub(super) thickness_m: f64,
    /// The second longest side: the width of a leaf, a trunk or a wall, metres.
    pub(super) width_m: f64,
    /// The longest side, metres.
    pub(super) length_m: f64,
    pub(super) is_blended: bool,
    /// Whether it is plain ground below layers of fog, which end at it.
    pub(super) is_plain: bool,
}

impl PlacedPart<'_> {
    /// Whether it stops light as a wall does: transparent parts are surfels at any size.
    pub(super) fn is_wall(&self, width_m: f64) -> bool {
        self.stands_alone(width_m) && !self.is_blended
    }

    /// Whether it is no leaf among leaves of that width.
    pub(super) fn stands_alone(&self, width_m: f64) -> bool {
        self.is_large(width_m) || self.is_post(width_m)
    }

    pub(super) fn is_large(&self, width_m: f64) -> bool {
        self.width_m >= width_m || self.is_panel(width_m)
    }

    /// Whether it is a panel, such as the narrow wall above a window, which closes a room as a wall does.
    fn is_panel(&self, width_m: f64) -> bool {
        /// Maximum thickness, as a share of the width.
        const THICKEST: f64 = 0.25;
        let is_flat = self.thickness_m <= THICKEST * self.width_m;
        is_flat && self.width_m >= NARROWEST * width_m && self.length_m >= SHORTEST * width_m
    }

    /// Whether it is a solid half as long as a panel, and half as thick as a panel is wide: a post, a step.
    fn is_post(&self, width_m: f64) -> bool {
        /// Minimum area, as a share of its bounds' area. A thin twig on a diagonal has wide bounds.
        const FULL: f64 = 0.75;
        let [x, y, z] = (self.part.high - self.part.low).to_array();
        let of_bounds = 2.0 * (x * y + y * z + z * x);
        let area = || self.part.places.iter().map(|place| place.area).sum::<f64>();
        self.part.is_closed
            && self.thickness_m >= 0.5 * NARROWEST * width_m
            && self.length_m >= 0.5 * SHORTEST * width_m
            && area() >= FULL * of_bounds
    }

    /// Factor of its emission that leaves its light outside as it is, though the part is spread over cells
    /// and so shades itself. Of even sources in a thin ball, 9/16 of the optical depth of its mean chord is
    /// lost (Case, de Hoffmann & Placzek 1953). That depth is the area of the part over that of the cells.
    pub(super) fn emits(&self, cell_m: f64) -> f64 {
        let area_m2 = |margin_m: f64| {
            let [x, y, z] = [self.thickness_m, self.width_m, self.length_m].map(|side| side + margin_m);
            x * y + y * z + z * x
        };
        1.0 + 9.0 / 16.0 * area_m2(0.0) / area_m2(cell_m)
    }

    /// Share of light from all sides that it does not shade itself from; 1 for a closed body.
    pub(super) fn exposed(&self) -> f64 {
        if self.part.is_closed { 1.0 } else { self.part.exposed.max(LEAST_EXPOSED) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    /// A body much smaller than a cell keeps its emission. One as wide as its cell is spread over twice the
    /// width: a quarter of the depth, of which 9/16 are lost.
    #[test]
    fn emission_makes_up_for_what_the_body_takes() {
        let (low, high) = (DVec3::ZERO, DVec3::ONE);
        let (places, few_places) = (Vec::new(), Vec::new());
        let part =
            MeshPart { triangles: Vec::new(), low, high, is_closed: true, exposed: 0.5, places, few_places };
        let placed = PlacedPart {
            mesh_number: 0,
            part: &part,
            number: 0,
            looks: 0,
            thickness_m: 1.0,
            width_m: 1.0,
            length_m: 1.0,
            is_blended: false,
            is_plain: false,
        };
        assert!((placed.emits(1.0) - (1.0 + 9.0 / 64.0)).abs() < 1e-12);
        assert!((placed.emits(1e4) - 1.0).abs() < 1e-7);
    }
}
