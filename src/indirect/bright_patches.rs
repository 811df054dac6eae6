//! Bright patches of walls: a spot beneath a lamp, a ceiling over a panel that glows. In go patches with the
//! radiance that they send, out comes the irradiance on all patches by the brightest of them. Invariant: such
//! light arrives along rays from point to point. Ordinates would spread it in beams (ray effects, Lewis &
//! Miller 1984, section 4-6).

use super::lit_square::Square;
use super::wall_light::{LitWalls, Target, WallLight};
use crate::accel::PrimitiveId;
use crate::color::{Rgb, luminance};
use crate::light::{Emission, FrozenLight, LampShape};
use crate::math::{Ray, kronecker};
use crate::ordinates::first_collision_source::BrightWalls;
use glam::DVec3;
use rayon::prelude::*;
use std::f64::consts::FRAC_1_PI;

/// Radiance relative to the mean of all patches from which a patch is bright. Only the excess goes by rays,
/// so that nothing jumps where a patch becomes bright.
const BRIGHT: f64 = 16.0;
/// Share of a patch's light that other patches get, below which less of it goes by rays.
const FACING: f64 = 0.1;
/// Minimum share of the light of all patches that goes by rays: with less, all goes along ordinates. From
/// twice that share on nothing is taken back, so that nothing jumps.
const LEAST_BY_RAYS: f64 = 1e-3;
/// Minimum component of a bright patch's normal along an axis of the grid. An oblique wall has more or fewer
/// patches than areas of a cell, so its light goes along ordinates.
const ALONG_AXIS: f64 = 0.99;
/// Distance in cells at which a square lies before its own surface.
const BEFORE: f64 = 0.1;
/// Distance in cells up to which all points of a bright patch light a patch; farther ones are sampled.
const NEAR: f64 = 2.0;

/// A bright patch.
struct Sender {
    number: usize,
    /// Radiance that goes by rays.
    radiance: Rgb,
    /// Centre in relative space.
    middle: DVec3,
    normal: DVec3,
    /// Luminance of its radiance times its area.
    power: f64,
    /// Points in the middle of its squares, each with the power of those up to it.
    points: Vec<(FrozenLight, f64)>,
}

/// Middle of a patch in relative space, and its normal.
type Place = (DVec3, DVec3);

impl Sender {
    /// Estimate of its irradiance at a place, with nothing between.
    fn weight(&self, (middle, normal): Place) -> f64 {
        let way = self.middle - middle;
        let cosines = normal.dot(way).max(0.0) * self.normal.dot(-way).max(0.0);
        if cosines > 0.0 { self.power * cosines / way.length_squared().powi(2) } else { 0.0 }
    }

    fn scale(&mut self, factor: f64) {
        self.radiance *= factor;
        self.power *= factor;
        for (point, up_to) in &mut self.points {
            *up_to *= factor;
            if let FrozenLight::Point { intensity, .. } = point {
                *intensity *= factor;
            }
        }
    }
}

impl WallLight<'_> {
    /// Light of the bright patches, by the radiances that all send and the light of lamps on them. `None` if
    /// they send next to nothing by rays.
    pub(super) fn bright(&self, sent: &[Rgb], lit: &LitWalls) -> Option<BrightWalls> {
        let all_sent = sent.iter().copied().map(luminance).sum::<f64>();
        let least = BRIGHT * all_sent / sent.len() as f64;
        let excess = |number: usize| {
            let all = luminance(sent[number]);
            let normal = self.walls.walls.patches[number].normal;
            let is_bright = all > least && normal.abs().max_element() > ALONG_AXIS;
            is_bright.then(|| (number, (1.0 - least / all) * sent[number]))
        };
        let bright: Vec<(usize, Rgb)> = (0..sent.len()).filter_map(excess).collect();
        if bright.is_empty() {
            return None;
        }
        let targets = || (0..sent.len()).into_par_iter().map(|number| self.open_target(number, lit));
        let places: Vec<Place> = targets().map(|target| (target.middle, target.patch.normal)).collect();
        let mut senders: Vec<Sender> =
            bright.into_par_iter().filter_map(|sent| self.sender(sent, lit, &places)).collect();
        let by_rays: f64 = senders.iter().map(|sender| luminance(sender.radiance)).sum();
        let much = (by_rays / (LEAST_BY_RAYS * all_sent) - 1.0).min(1.0);
        if much <= 0.0 {
            return None;
        }
        senders.iter_mut().for_each(|sender| sender.scale(much));
        let mut radiances = vec![Rgb::ZERO; sent.len()];
        senders.iter().for_each(|sender| radiances[sender.number] = sender.radiance);
        let irradiances = targets().map(|target| self.by_senders(&senders, &target)).collect();
        Some(BrightWalls { radiances, irradiances })
    }

    fn open_target(&self, number: usize, lit: &LitWalls) -> Target<'_> {
        let mut target = self.target(number);
        target.squares.retain(|(square, _)| lit.squares[number] >> square & 1 == 1);
        target
    }

    /// A patch as a sender of a radiance, as far as other patches get its light. Each of its squares sends as
    /// much as its own irradiance asks for. `None` if it lights no patch.
    fn sender(&self, (number, radiance): (usize, Rgb), lit: &LitWalls, places: &[Place]) -> Option<Sender> {
        let target = self.open_target(number, lit);
        let (normal, all) = (target.patch.normal, luminance(lit.irradiances[number]));
        // A patch that is lit from behind alone sends as much everywhere.
        let share = |of_square: Rgb| if all > 0.0 { luminance(of_square) / all } else { 1.0 };
        let (mut middle, mut power, mut points) = (DVec3::ZERO, 0.0, Vec::new());
        for (square, of_square) in self.sending(&target) {
            let position = square.middle + 1e-4 * self.grid.cell_m * normal;
            let intensity = square.area_m2() * share(of_square) * radiance;
            power += luminance(intensity);
            middle += luminance(intensity) * position;
            let emission = Emission::Flat { normal };
            points
                .push((FrozenLight::Point { position, intensity, emission, shape: LampShape::NONE }, power));
        }
        if power <= 0.0 {
            return None;
        }
        let mut sender = Sender { number, radiance, middle: middle / power, normal, power, points };
        let weights: f64 = places.iter().map(|&place| sender.weight(place)).sum();
        let share = FRAC_1_PI * self.grid.cell_m.powi(2) * weights / power;
        sender.scale((share / FACING).min(1.0));
        (share > 0.0).then_some(sender)
    }

    /// Squares of a patch with the irradiance on each by lamps, suns and what glows.
    fn sending(&self, target: &Target) -> Vec<(Square, Rgb)> {
        let mut squares: Vec<(Square, Rgb)> =
            target.squares.iter().map(|(_, square)| (*square, Rgb::ZERO)).collect();
        for light in self.lights.iter().chain(self.emissive) {
            let mut sums = squares.iter_mut();
            self.lit(light, target, |irradiance| {
                sums.next().into_iter().for_each(|(_, sum)| *sum += irradiance);
            });
        }
        // Planks of a wall share a cell, and some squares hang in the air beyond an edge.
        let is_own = |square: &Square| self.is_before_own(square, target.patch.normal, target.primitive);
        if squares.iter().any(|(square, _)| is_own(square)) {
            squares.retain(|(square, _)| is_own(square));
        }
        squares
    }

    /// Whether a square of a wall lies close before the instance of a primitive.
    fn is_before_own(&self, square: &Square, normal: DVec3, primitive: PrimitiveId) -> bool {
        let off_m = BEFORE * self.grid.cell_m;
        let ray = Ray { origin: square.middle + off_m * normal, direction: -normal };
        let hit = self.snapshot.tree.nearest_hit(&ray, 2.0 * off_m, None);
        hit.is_some_and(|hit| hit.primitive.instance == primitive.instance)
    }

    /// Irradiance on a patch by bright ones: by all points of near ones, and on each of its squares by one
    /// point of the others, picked by its estimated light, evenly over all squares.
    fn by_senders(&self, senders: &[Sender], target: &Target) -> Rgb {
        let place = (target.middle, target.patch.normal);
        let near_m = NEAR * self.grid.cell_m;
        let is_near = |sender: &Sender| sender.middle.distance(target.middle) < near_m;
        let mut all = 0.0;
        let up_to: Vec<f64> = senders
            .iter()
            .map(|sender| {
                all += if is_near(sender) { 0.0 } else { sender.weight(place) };
                all
            })
            .collect();
        let near = senders.iter().filter(|sender| is_near(sender)).flat_map(|sender| &sender.points);
        let near: Vec<&FrozenLight> = near.map(|(point, _)| point).collect();
        let mut sum = Rgb::ZERO;
        let shift = kronecker(0.5, target.node);
        for (number, (_, square)) in target.squares.iter().enumerate() {
            sum += near.iter().map(|point| self.on_square(square, point, target).1).sum::<Rgb>();
            let u = (number as f64 + shift) / target.squares.len() as f64;
            let chosen = up_to.partition_point(|sum| *sum <= u * all);
            let Some(sender) = senders.get(chosen) else { continue };
            let before = chosen.checked_sub(1).map_or(0.0, |before| up_to[before]);
            let share = (up_to[chosen] - before) / all;
            let within = (u - before / all) / share * sender.power;
            let chosen = sender.points.partition_point(|(_, sum)| *sum <= within);
            let (point, _) = &sender.points[chosen.min(sender.points.len() - 1)];
            if let FrozenLight::Point { intensity, .. } = point {
                let share = share * luminance(*intensity) / sender.power;
                // Rounding may pick a dark point.
                if share > 0.0 {
                    sum += self.on_square(square, point, target).1 / share;
                }
            }
        }
        sum / target.squares.len().max(1) as f64
    }
}
