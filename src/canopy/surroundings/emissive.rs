//! Short closed parts that emit. In go parts, out come facets, places and surfels of each. Invariant: parts
//! that emit apart are few, and shorter than two cells; all others emit by their surfels.

use super::placed_part::PlacedPart;
use super::{SMALL_CELLS, Surroundings, middle};
use crate::canopy::surface_optics::optics_at;
use crate::canopy::surfels::Surfel;
use crate::color::{Rgb, luminance};
use crate::ordinates::emissive_bodies::{Facet, merged};
use crate::ordinates::surface_optics::SurfaceOptics;
use glam::DVec3;

/// Length in cells from which parts emit by their surfels, each where it is.
const LONGEST_CELLS: f64 = 2.0;

/// Maximum number of parts that emit apart, which limits memory and time: beyond it none does.
const MOST_BODIES: usize = 2048;

/// A short closed part that emits.
pub(crate) struct EmissivePart {
    pub(crate) facets: Vec<Facet>,
    /// Positions and normals, with shares of its emission.
    pub(crate) places: Vec<(DVec3, DVec3, f64)>,
    /// What stands for its extinction.
    pub(crate) surfels: Vec<Surfel>,
}

/// A triangle of a part.
struct Piece {
    position: DVec3,
    normal: DVec3,
    area: f64,
    /// Radiance at its centre.
    radiance: Rgb,
}

impl Surroundings<'_> {
    /// Whether the parts that could emit apart are few.
    pub(crate) fn has_few_bodies(&self, sizes_m: (f64, f64)) -> bool {
        self.find_means(self.parts.iter().filter(|part| is_short(part, sizes_m)));
        self.parts.iter().filter(|part| self.emits_apart(part, sizes_m)).nth(MOST_BODIES).is_none()
    }

    /// Whether a part is short and closed, and emits.
    pub(super) fn emits_apart(&self, part: &PlacedPart, sizes_m: (f64, f64)) -> bool {
        is_short(part, sizes_m) && self.mean(part).emission != Rgb::ZERO
    }

    /// Short closed parts that emit: those narrower than a width.
    pub(crate) fn emissive_bodies(&self, sizes_m: (f64, f64)) -> impl Iterator<Item = EmissivePart> {
        let emissive = self.parts.iter().filter(move |part| self.emits_apart(part, sizes_m));
        emissive.map(move |part| self.emissive(part, part.length_m < SMALL_CELLS * sizes_m.1))
    }

    fn emissive(&self, part: &PlacedPart, is_small: bool) -> EmissivePart {
        let optics = self.mean(part);
        let pieces = self.pieces(part, is_small, &optics);
        let exposed = f64::from(part.part.exposed as f32);
        let facet = |piece: &Piece| Facet {
            normal: piece.normal.as_vec3(),
            emission: (exposed * piece.area * optics.emission).as_vec3().to_array(),
        };
        let all_m2: f64 = pieces.iter().map(|piece| piece.area).sum();
        let sent = |piece: &Piece| piece.area * luminance(piece.radiance);
        let all: f64 = pieces.iter().map(sent).sum();
        // What glows between centres glows evenly.
        let share = |piece: &Piece| if all > 0.0 { sent(piece) / all } else { piece.area / all_m2 };
        let places = if is_small {
            let middle = middle(pieces.iter().map(|piece| (piece.area, piece.position)));
            pieces.first().map(|piece| (middle, piece.normal, 1.0)).into_iter().collect()
        } else {
            pieces.iter().map(|piece| (piece.position, piece.normal, share(piece))).collect()
        };
        EmissivePart {
            facets: merged(pieces.iter().map(facet)),
            places,
            surfels: self.surfels_of(part, is_small, (|_| 0, &[optics])),
        }
    }

    /// Triangles of a part; those of a small one have its mean radiance.
    fn pieces(&self, part: &PlacedPart, is_small: bool, mean: &SurfaceOptics) -> Vec<Piece> {
        let piece = |&triangle: &u32| {
            let primitive = self.mesh(part).primitive(triangle)?;
            let [a, b, c] = self.world_corners(primitive);
            let area_normal = 0.5 * (b - a).cross(c - a);
            let (position, normal) = ((a + b + c) / 3.0, area_normal.try_normalize()?);
            let radiance = || optics_at(self.snapshot, primitive, position, normal).emission;
            let radiance = if is_small { mean.emission } else { radiance() };
            Some(Piece { position, normal, area: area_normal.length() * mean.cover, radiance })
        };
        part.part.triangles.iter().filter_map(piece).collect()
    }
}

fn is_short(part: &PlacedPart, (width_m, cell_m): (f64, f64)) -> bool {
    part.part.is_closed
        && part.length_m < LONGEST_CELLS * cell_m
        && !part.is_wall(width_m)
        && !part.is_large(width_m)
}
