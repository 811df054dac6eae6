//! Shares of a slice's piece in pixels. In goes the piece, out come its pixels and weights. Invariant: a
//! pixel gets shares only from rounds that want it, and its weight does not depend on which others are
//! wanted.

use super::lattice::PlacedSlice;
use super::rounds::Round;
use crate::film::{Splat, filter};
use crate::math::gauss_legendre;
use crate::scene::Size;
use crate::transport::slices::{Fan, Outline, Piece};
use glam::DVec2;

/// Number of points of Gauss-Legendre quadrature by which the filter's mean over a line is exact to 0.002 of
/// its peak: found by trial, for lines of up to 1.4 pixels.
fn points_of(length_px: f64) -> usize {
    1 + ((length_px - 0.1) / 0.34).ceil().clamp(0.0, 4.0) as usize
}

/// Data that the pieces of a slice share.
pub(super) struct Shares<'a> {
    pub(super) round: &'a Round<'a>,
    pub(super) size: Size,
    pub(super) placed: &'a PlacedSlice,
}

impl Shares<'_> {
    /// Adds samples weighted by area in pixels: the pieces of a slice, and its outline, count within its
    /// swath.
    pub(super) fn by_swath(
        &self,
        drawn: &Fan,
        pieces: &mut [PlacedPiece],
        outline: &mut Outline,
        mut add: impl FnMut(u32, &Splat),
    ) {
        let Self { round, size, placed } = *self;
        let is_wanted = |x: usize, y: usize| round.wanted.contains(x, y);
        let share = 1.0 / f64::from(placed.swath_lines());
        for piece in pieces.iter_mut().filter(|piece| round.may_share(piece.pixel, piece.pixel)) {
            piece.count(piece.pixel, share * piece.weight);
        }
        let weight_per_area = share * placed.weight_per_area;
        for (line, rotated_rad) in placed.swath_beside(drawn) {
            outline.parts(&line, rotated_rad, size, is_wanted, |part| {
                let piece = &mut pieces[part.piece];
                if round.may_share(piece.pixel, part.pixel) {
                    let weight = weight_per_area * part.area_per_rad;
                    if let Some((pixel, weight)) = piece.count(part.pixel, weight) {
                        add(piece.sample, &splat(piece.film_px, pixel, weight));
                    }
                }
            });
        }
        for piece in pieces {
            for &(pixel, weight) in &piece.counts[..piece.counted] {
                add(piece.sample, &splat(piece.film_px, pixel, weight));
            }
        }
    }

    /// Splats by a filter that is wider than a pixel: its mean over the area of the piece, in each pixel
    /// within its radius.
    pub(super) fn by_window(&self, piece: &Piece) -> impl Iterator<Item = Splat> {
        let &Piece { chord, range, .. } = piece;
        let (x, y) = chord.pixel;
        let centre = DVec2::new(x as f64 + 0.5, y as f64 + 0.5);
        let areas = range.map(|part| chord.start + part * (chord.end - chord.start));
        let [start, end] = areas.map(|area| self.placed.slice.place(area).film_px - centre);
        let (middle, along) = (0.5 * (start + end), 0.5 * (end - start));
        let across =
            along.perp().normalize_or_zero() * self.placed.half_swath_px(0.5 * (areas[0] + areas[1]));
        let [points_along, points_across] =
            [along, across].map(|half| gauss_legendre(points_of(2.0 * half.length())));
        let mut shares = [[0.0; 3]; 3];
        for (u, weight_along) in points_along {
            for (v, weight_across) in points_across {
                let point = middle + *u * along + *v * across;
                // Weights by axis of the pixels before, at and after the piece's own.
                let [columns, rows] =
                    point.to_array().map(|at| [-1.0, 0.0, 1.0].map(|pixel| filter::weight(at - pixel)));
                for (shares, row) in shares.iter_mut().zip(rows) {
                    for (share, column) in shares.iter_mut().zip(columns) {
                        *share += 0.25 * weight_along * weight_across * row * column;
                    }
                }
            }
        }
        let pixels = (0..9).map(move |number| (number % 3, number / 3));
        pixels.filter_map(move |(right, down)| {
            let (pixel, share) =
                (((x + right).wrapping_sub(1), (y + down).wrapping_sub(1)), shares[down][right]);
            let is_wanted = share > 0.0 && self.round.wanted.contains(pixel.0, pixel.1);
            is_wanted.then(|| splat(piece.place.film_px, pixel, share * piece.weight))
        })
    }
}

/// A piece whose sample is stored.
pub(super) struct PlacedPiece {
    /// The sample's number.
    sample: u32,
    weight: f64,
    pixel: (usize, usize),
    film_px: DVec2,
    /// Pixels in which it counts, and the weights: lines of a swath mostly lie in the same pixels.
    counts: [((usize, usize), f64); 4],
    counted: usize,
}

impl PlacedPiece {
    pub(super) fn new(piece: &Piece, sample: u32) -> Self {
        let (pixel, film_px) = (piece.chord.pixel, piece.place.film_px);
        Self { sample, weight: piece.weight, pixel, film_px, counts: Default::default(), counted: 0 }
    }

    /// Adds its weight in a pixel; returns it instead if there are too many pixels.
    fn count(&mut self, pixel: (usize, usize), weight: f64) -> Option<((usize, usize), f64)> {
        let noted = &mut self.counts[..self.counted];
        if let Some((_, sum)) = noted.iter_mut().find(|(other, _)| *other == pixel) {
            *sum += weight;
        } else if let Some(free) = self.counts.get_mut(self.counted) {
            *free = (pixel, weight);
            self.counted += 1;
        } else {
            return Some((pixel, weight));
        }
        None
    }
}

/// Splat of a sample at a place of the film, for one pixel.
fn splat(film_px: DVec2, (x, y): (usize, usize), weight: f64) -> Splat {
    let centre = DVec2::new(x as f64 + 0.5, y as f64 + 0.5);
    Splat { pixel: (x, y), weight, from_centre_px: film_px.distance(centre) }
}
