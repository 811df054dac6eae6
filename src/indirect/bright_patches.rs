//! Bright patches of walls: a spot beneath a lamp, a ceiling over a panel that glows. In go patches with the
//! radiance that they send, out comes the irradiance on all patches by the brightest of them. Invariant: such
//! light arrives along rays from point to point. Ordinates would spread it in beams (ray effects, Lewis &
//! Miller 1984, section 4-6).

use super::lit_square::Square;
use super::wall_light::WallLight;
use crate::accel::PrimitiveId;
use crate::color::{Rgb, luminance};
use crate::light::{Emission, FrozenLight, LampShape};
use crate::math::{Ray, kronecker};
use crate::ordinates::first_collision_source::BrightWalls;
use crate::ordinates::walls::Patch;
use crate::snapshot::Luminaire;
use glam::DVec3;
use rayon::prelude::*;

/// Radiance relative to the mean of all patches from which a patch is bright. Only the excess goes by rays,
/// so that nothing jumps where a patch becomes bright.
const BRIGHT: f64 = 16.0;
/// Minimum component of a bright patch's normal along an axis of the grid. An oblique wall has more or fewer
/// patches than areas of a cell, so its light goes along ordinates.
const ALONG_AXIS: f64 = 0.99;
/// Distance in cells at which a square lies before its own surface.
const BEFORE: f64 = 0.1;

/// A square that sends light.
struct Sending {
    square: Square,
    normal: DVec3,
    radiance: Rgb,
}

impl WallLight<'_> {
    /// Light of the bright patches, by the radiances that all send and the irradiances that they get. `None`
    /// if none is bright.
    pub(super) fn bright(&self, sent: &[Rgb], irradiances: &[Rgb]) -> Option<BrightWalls> {
        let all: f64 = sent.iter().copied().map(luminance).sum();
        let least = BRIGHT * all / sent.len() as f64;
        let of_bright = |(sent, patch): (&Rgb, &Patch)| match luminance(*sent) {
            all if all > least && patch.normal.abs().max_element() > ALONG_AXIS => {
                *sent * (1.0 - least / all)
            }
            _ => Rgb::ZERO,
        };
        let radiances: Vec<Rgb> = sent.iter().zip(&self.walls.walls.patches).map(of_bright).collect();
        let numbers: Vec<usize> = (0..sent.len()).filter(|number| radiances[*number] != Rgb::ZERO).collect();
        let of_patch = |&number: &usize| self.sending(number, radiances[number], irradiances[number]);
        let squares: Vec<Sending> = numbers.par_iter().flat_map_iter(of_patch).collect();
        let luminaire = luminaire(&squares, 1e-4 * self.grid.cell_m)?;
        let light = WallLight { emissive: &[], ..*self };
        let patches = self.walls.walls.patches.par_iter().zip(&self.walls.primitives);
        let lit = patches.map(|(patch, &primitive)| {
            let arriving = light.arriving(&luminaire, (patch, primitive), |_, _| ());
            arriving.map_or(Rgb::ZERO, |arriving| arriving.irradiance)
        });
        Some(BrightWalls { radiances, irradiances: lit.collect() })
    }

    /// Squares of a patch, each with the radiance that its own irradiance asks for.
    fn sending(&self, number: usize, radiance: Rgb, irradiance: Rgb) -> Vec<Sending> {
        let (patch, primitive) = (&self.walls.walls.patches[number], self.walls.primitives[number]);
        let mut squares: Vec<(Square, Rgb)> = Vec::new();
        for light in self.lights.iter().chain(self.emissive) {
            let mut place = 0;
            self.arriving(light, (patch, primitive), |square, irradiance| {
                match squares.get_mut(place) {
                    Some((_, sum)) => *sum += irradiance,
                    None => squares.push((*square, irradiance)),
                }
                place += 1;
            });
        }
        // Planks of a wall share a cell, and some squares hang in the air beyond an edge.
        if squares.iter().any(|(square, _)| self.is_before_own(square, patch.normal, primitive)) {
            squares.retain(|(square, _)| self.is_before_own(square, patch.normal, primitive));
        }
        let all = luminance(irradiance);
        // A patch that is lit from behind alone sends as much everywhere.
        let share = |of_square: Rgb| if all > 0.0 { luminance(of_square) / all } else { 1.0 };
        let sending = |(square, of_square)| Sending {
            square,
            normal: patch.normal,
            radiance: share(of_square) * radiance,
        };
        squares.into_iter().map(sending).collect()
    }

    /// Whether a square of a wall lies close before the instance of a primitive.
    fn is_before_own(&self, square: &Square, normal: DVec3, primitive: PrimitiveId) -> bool {
        let off_m = BEFORE * self.grid.cell_m;
        let ray = Ray { origin: square.middle + off_m * normal, direction: -normal };
        let hit = self.snapshot.tree.nearest_hit(&ray, 2.0 * off_m, None);
        hit.is_some_and(|hit| hit.primitive.instance == primitive.instance)
    }
}

/// Luminaire of points on squares, `off_m` before them, as many on each as its power asks for.
fn luminaire(squares: &[Sending], off_m: f64) -> Option<Luminaire> {
    const POINTS: usize = 256;
    let mut all = 0.0;
    let up_to: Vec<f64> = squares
        .iter()
        .map(|Sending { square, radiance, .. }| {
            all += square.area_m2() * luminance(*radiance);
            all
        })
        .collect();
    let point = |number: usize| {
        let power = all * (number as f64 + 0.5) / POINTS as f64;
        let Sending { square, normal, radiance } = &squares[up_to.partition_point(|sum| *sum <= power)];
        let [x, y] = [kronecker(0.25, number), kronecker(0.5, 7 * number)].map(|u| 2.0 * u - 1.0);
        FrozenLight::Point {
            position: square.middle + x * square.half[0] + y * square.half[1] + off_m * *normal,
            intensity: all / luminance(*radiance) * *radiance,
            emission: Emission::Flat { normal: *normal },
            shape: LampShape::NONE,
        }
    };
    if all > 0.0 { Luminaire::of_points((0..POINTS).map(point).collect()) } else { None }
}
