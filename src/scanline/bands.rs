//! Triangles sorted into bands of rows, and what each band sees. Invariant: a band draws its triangles in the
//! order of their numbers, so nothing depends on which thread does it.

use super::projection::{Projection, Vertex};
use super::triangle::EdgeForms;
use crate::accel::PrimitiveId;
use crate::scene::Size;
use crate::snapshot::Snapshot;
use glam::DVec2;
use rayon::prelude::*;
use std::ops::Range;

/// Rows of pixels a band: few enough to stay in the cache, and for all threads to have work.
const ROWS: usize = 8;

/// No triangle.
pub(super) const NOTHING: u32 = u32::MAX;

/// All triangles that may be seen.
pub(super) struct Bands<'a> {
    pub(super) size: Size,
    /// Where a pixel's samples lie, from its upper left corner.
    pub(super) pattern: &'a [DVec2],
    projection: Projection,
    pub(super) triangles: Vec<Prepared>,
    /// Of each band, the triangles that reach into it.
    members: Vec<Vec<u32>>,
}

/// A triangle in the picture.
pub(super) struct Prepared {
    pub(super) primitive: PrimitiveId,
    vertices: [Vertex; 3],
    rows: Range<usize>,
    columns: Range<usize>,
    is_blended: bool,
}

/// What a band's samples show: pixel by pixel, all samples of a pixel together.
pub(super) struct Visible {
    /// Rows of pixels.
    pub(super) rows: Range<usize>,
    /// Along the view axis, metres; infinite where there is nothing.
    pub(super) depths: Vec<f64>,
    /// Index into [`Bands::triangles`], or [`NOTHING`].
    pub(super) nearest: Vec<u32>,
    /// Blended surfaces before that: by sample, then from far to near.
    pub(super) layers: Vec<Layer>,
}

/// A blended triangle at a sample.
#[derive(Clone, Copy)]
pub(super) struct Layer {
    pub(super) sample: usize,
    pub(super) depth: f64,
    pub(super) triangle: u32,
}

impl<'a> Bands<'a> {
    pub(super) fn new(snapshot: &Snapshot, size: Size, pattern: &'a [DVec2]) -> Self {
        let projection = Projection::new(&snapshot.view, size);
        let meshes: Vec<Vec<Prepared>> = (0..snapshot.mesh_count())
            .into_par_iter()
            .map(|number| prepare(snapshot, number, &projection, size))
            .collect();
        let triangles: Vec<Prepared> = meshes.into_iter().flatten().collect();
        let mut members = vec![Vec::new(); size.height.div_ceil(ROWS)];
        for (number, triangle) in triangles.iter().enumerate() {
            for band in &mut members[triangle.rows.start / ROWS..triangle.rows.end.div_ceil(ROWS)] {
                band.push(number as u32);
            }
        }
        Self { size, pattern, projection, triangles, members }
    }

    pub(super) fn count(&self) -> usize {
        self.members.len()
    }

    /// Draws one band.
    pub(super) fn visible(&self, band: usize) -> Visible {
        let rows = band * ROWS..((band + 1) * ROWS).min(self.size.height);
        let samples = rows.len() * self.size.width * self.pattern.len();
        let mut visible = Visible {
            rows,
            depths: vec![f64::INFINITY; samples],
            nearest: vec![NOTHING; samples],
            layers: Vec::new(),
        };
        // Opaque ones first: of the blended ones only what lies before them shows.
        for blended in [false, true] {
            for &number in &self.members[band] {
                let triangle = &self.triangles[number as usize];
                if triangle.is_blended == blended {
                    self.draw(triangle, number, &mut visible);
                }
            }
        }
        visible.layers.sort_by(|a, b| {
            (a.sample.cmp(&b.sample)).then(b.depth.total_cmp(&a.depth)).then(a.triangle.cmp(&b.triangle))
        });
        visible
    }

    fn draw(&self, triangle: &Prepared, number: u32, visible: &mut Visible) {
        let Some(forms) = EdgeForms::new(&triangle.vertices) else { return };
        let rows = triangle.rows.start.max(visible.rows.start)..triangle.rows.end.min(visible.rows.end);
        for row in rows {
            for (place, offset) in self.pattern.iter().enumerate() {
                let y = self.projection.place(DVec2::new(0.0, row as f64 + offset.y)).y;
                let Some((low, high)) = forms.span(y) else { continue };
                let column = |x: f64| self.projection.pixels(DVec2::new(x, y)).x - offset.x;
                // Rounding moves the ends by much less than a pixel.
                for column in within(column(low) - 1.0, column(high) + 1.0, &triangle.columns) {
                    let at =
                        self.projection.place(DVec2::new(column as f64 + offset.x, row as f64 + offset.y));
                    let Some(depth) = forms.depth_at(at) else { continue };
                    let pixel = (row - visible.rows.start) * self.size.width + column;
                    let sample = pixel * self.pattern.len() + place;
                    if depth < visible.depths[sample] {
                        if triangle.is_blended {
                            visible.layers.push(Layer { sample, depth, triangle: number });
                        } else {
                            visible.depths[sample] = depth;
                            visible.nearest[sample] = number;
                        }
                    }
                }
            }
        }
    }
}

/// The triangles of a mesh that lie in the picture.
fn prepare(snapshot: &Snapshot, number: usize, projection: &Projection, size: Size) -> Vec<Prepared> {
    let mesh = snapshot.mesh(number);
    let camera_from_mesh = projection.camera_from_mesh(mesh.relative_from_mesh);
    let vertices: Vec<Vertex> = mesh
        .positions
        .iter()
        .map(|position| projection.vertex(camera_from_mesh.transform_point3(position.as_dvec3())))
        .collect();
    let in_picture = mesh.triangles().filter_map(|(primitive, corners)| {
        let vertices = corners.map(|corner| vertices[corner]);
        let (low, high) = projection.bounds(&vertices)?;
        // Samples lie up to a pixel from their pixel's corner.
        let columns = within(low.x - 1.0, high.x + 1.0, &(0..size.width));
        let rows = within(low.y - 1.0, high.y + 1.0, &(0..size.height));
        let is_blended = mesh.is_blended;
        (!columns.is_empty() && !rows.is_empty()).then_some(Prepared {
            primitive,
            vertices,
            rows,
            columns,
            is_blended,
        })
    });
    in_picture.collect()
}

/// Whole numbers between two places, of a range.
fn within(low: f64, high: f64, range: &Range<usize>) -> Range<usize> {
    // Casts saturate, and NaN becomes 0.
    let start = (low.floor().max(0.0) as usize).max(range.start);
    let end = ((high.ceil().max(-1.0) + 1.0) as usize).min(range.end);
    start..end.max(start)
}
