//! Preview of a frame: triangles are drawn one after another into a depth buffer, without rays, trees or
//! shadows. In goes a [`Snapshot`], out comes a [`Frame`]. Invariants: a pixel is a function of snapshot and
//! size alone. Visibility is decided in double precision from the triangles' vertices. No code is shared with
//! `accel`, so each can verify the other.
//!
//! Visibility comes first, then shading (Burns and Hunt 2013, "The Visibility Buffer"). Bands of rows find
//! the triangle that each sample shows, then each pixel is shaded once for each of its triangles. Light is
//! that of `transport` without shadows and without scattering in fog; fog attenuates surfaces behind it.

mod bands;
mod projection;
mod shade;
mod triangle;

use crate::film::{Channel, Frame, Precision};
use crate::scene::{Size, Window};
use crate::snapshot::Snapshot;
use bands::{Bands, Visible};
use glam::DVec2;
use rayon::prelude::*;
use shade::Shader;

/// Offsets of a pixel's samples from its upper left corner: a rotated square, so that nearly horizontal and
/// nearly vertical edges have all four steps.
const ROTATED_GRID: [DVec2; 4] =
    [DVec2::new(0.375, 0.125), DVec2::new(0.875, 0.375), DVec2::new(0.125, 0.625), DVec2::new(0.625, 0.875)];

/// Offset of rays through pixels' centres.
const CENTRES: [DVec2; 1] = [DVec2::splat(0.5)];

/// Draws a whole picture: `R`, `G`, `B` and `A`, linear. Works on the current rayon pool.
pub fn draw(snapshot: &Snapshot, size: Size) -> Frame {
    let bands = Bands::new(snapshot, size, &ROTATED_GRID);
    let mut pixels = vec![[0.0; 4]; size.width * size.height];
    let numbered = pixels.par_chunks_mut(bands.pixels()).enumerate();
    numbered.for_each_init(Visible::default, |visible, (band, pixels)| {
        bands.draw(band, visible);
        Shader::new(snapshot, &bands).shade(visible, pixels);
    });
    let channels = ["R", "G", "B", "A"].into_iter().enumerate().map(|(channel, name)| {
        Channel::new(name, Precision::Half, pixels.iter().map(|pixel| pixel[channel]).collect())
    });
    Frame { full: size, window: Window::whole(size), channels: channels.collect() }
}

/// Distance along the view axis (planar Z) of the nearest opaque surface at every pixel's centre, metres, row
/// by row from the top; `None` where there is none.
///
/// A centre exactly on a triangle's edge belongs to the triangle. Of two triangles that share the edge both
/// count, and the nearer is visible, so no gap shows between them.
pub fn depths(snapshot: &Snapshot, size: Size) -> Vec<Option<f64>> {
    let bands = Bands::new(snapshot, size, &CENTRES);
    let depths = (0..bands.count()).into_par_iter().map(|band| {
        let mut visible = Visible::default();
        bands.draw(band, &mut visible);
        visible.depths
    });
    let depths: Vec<Vec<f64>> = depths.collect();
    depths.into_iter().flatten().map(|depth| depth.is_finite().then_some(depth)).collect()
}
