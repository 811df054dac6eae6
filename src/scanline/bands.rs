//! Triangles sorted into bands of rows, and the visibility of each band. In goes a snapshot, out come the
//! surfaces that samples show. Invariant: a band draws its triangles in the order of their numbers, on any
//! thread.

use super::projection::{Projection, Vertex};
use super::triangle::EdgeForms;
use crate::accel::PrimitiveId;
use crate::scene::{Clip, Size};
use crate::snapshot::{DrawnMesh, Snapshot};
use glam::{DVec2, Vec3};
use rayon::prelude::*;
use std::ops::Range;

/// Number of rows of pixels in a band: few enough for the cache, and for all threads to have work.
const ROWS: usize = 8;

/// Marks a sample without a triangle.
pub(super) const NOTHING: u32 = u32::MAX;

/// Margin of boxes, in pixels: rounding moves their sides by much less.
const SLACK: f64 = 0.01;

/// Maximum number of places in a row that are tested one by one; with more, only those between the triangle's
/// edges are tested.
const FEW: usize = 6;

/// All triangles that may be visible.
pub(super) struct Bands {
    pub(super) size: Size,
    /// Lattice of each sample within a pixel.
    pub(super) lattices: Vec<Lattice>,
    projection: Projection,
    clip: Clip,
    meshes: Vec<SeenMesh>,
    pub(super) triangles: Vec<Member>,
    /// Numbers of the triangles in each band.
    members: Vec<Vec<u32>>,
}

/// A placed mesh, projected to the picture.
struct SeenMesh {
    vertices: Vec<Vertex>,
    is_blended: bool,
}

/// One sample of every pixel.
pub(super) struct Lattice {
    /// Offset from the pixel's upper left corner.
    pub(super) offset: DVec2,
    /// Coordinates in the picture's plane, column by column and row by row.
    x: Vec<f64>,
    y: Vec<f64>,
}

/// A triangle in the picture.
pub(super) struct Member {
    pub(super) primitive: PrimitiveId,
    /// Vertices of its mesh.
    corners: [u32; 3],
    /// First row of pixels that it may cover, and the row after the last.
    rows: [u32; 2],
}

/// Visibility of a band's samples: pixel by pixel, all samples of a pixel together.
#[derive(Default)]
pub(super) struct Visible {
    pub(super) rows: Range<usize>,
    /// Distance along the view axis, metres; infinite where there is no surface.
    pub(super) depths: Vec<f64>,
    /// Index into [`Bands::triangles`], or [`NOTHING`].
    pub(super) nearest: Vec<u32>,
    /// Blended surfaces in front of that: by sample, then from far to near.
    pub(super) layers: Vec<Layer>,
}

/// A blended triangle at a sample.
#[derive(Clone, Copy)]
pub(super) struct Layer {
    pub(super) sample: usize,
    pub(super) depth: f64,
    pub(super) triangle: u32,
}

impl Lattice {
    fn new(offset: DVec2, projection: &Projection, size: Size) -> Self {
        let place = |column: usize, row: usize| {
            projection.place(DVec2::new(column as f64 + offset.x, row as f64 + offset.y))
        };
        let x = (0..size.width).map(|column| place(column, 0).x).collect();
        let y = (0..size.height).map(|row| place(0, row).y).collect();
        Self { offset, x, y }
    }

    /// Ranges of columns and rows of samples within a box of pixels.
    #[inline]
    fn within(&self, low: DVec2, high: DVec2) -> [Range<usize>; 2] {
        let (low, high) = (low - self.offset - SLACK, high - self.offset + SLACK);
        [whole_between(low.x, high.x, self.x.len()), whole_between(low.y, high.y, self.y.len())]
    }
}

impl Bands {
    /// Projects and sorts the triangles; `pattern` has the samples of a pixel, from its upper left corner.
    pub(super) fn new(snapshot: &Snapshot, size: Size, pattern: &[DVec2]) -> Self {
        let projection = Projection::new(&snapshot.view, size);
        let lattices: Vec<Lattice> =
            pattern.iter().map(|&offset| Lattice::new(offset, &projection, size)).collect();
        let meshes: Vec<SeenMesh> = (0..snapshot.mesh_count())
            .into_par_iter()
            .map(|number| SeenMesh::new(&snapshot.mesh(number), &projection))
            .collect();
        let triangles: Vec<Member> = (0..snapshot.mesh_count())
            .into_par_iter()
            .filter(|number| snapshot.is_mesh_seen(*number))
            .flat_map_iter(|number| {
                let vertices = meshes[number].vertices.as_slice();
                let (projection, lattices) = (&projection, lattices.as_slice());
                let triangles = snapshot.mesh(number).triangles();
                triangles.filter_map(move |(primitive, corners)| {
                    let rows = rows(corners.map(|corner| &vertices[corner]), projection, lattices)?;
                    Some(Member { primitive, corners: corners.map(|corner| corner as u32), rows })
                })
            })
            .collect();
        let mut members = vec![Vec::new(); size.height.div_ceil(ROWS)];
        for (number, triangle) in triangles.iter().enumerate() {
            let [first, end] = triangle.rows.map(|row| row as usize);
            for band in &mut members[first / ROWS..end.div_ceil(ROWS)] {
                band.push(number as u32);
            }
        }
        Self { size, lattices, projection, clip: snapshot.view.clip(), meshes, triangles, members }
    }

    /// Number of pixels of a band; the last band may have fewer.
    pub(super) fn pixels(&self) -> usize {
        ROWS * self.size.width
    }

    pub(super) fn count(&self) -> usize {
        self.members.len()
    }

    /// Draws one band, overwriting an earlier one.
    pub(super) fn draw(&self, band: usize, visible: &mut Visible) {
        visible.rows = band * ROWS..((band + 1) * ROWS).min(self.size.height);
        let samples = visible.rows.len() * self.size.width * self.lattices.len();
        visible.depths.clear();
        visible.depths.resize(samples, f64::INFINITY);
        visible.nearest.clear();
        visible.nearest.resize(samples, NOTHING);
        visible.layers.clear();
        // Opaque triangles come first, as blended ones show only in front of them.
        for &number in &self.members[band] {
            self.draw_triangle(number, visible);
        }
        visible.layers.sort_by(|a, b| {
            (a.sample.cmp(&b.sample)).then(b.depth.total_cmp(&a.depth)).then(a.triangle.cmp(&b.triangle))
        });
    }

    fn draw_triangle(&self, number: u32, visible: &mut Visible) {
        let Member { primitive, corners: [a, b, c], .. } = self.triangles[number as usize];
        let SeenMesh { vertices, is_blended } = &self.meshes[primitive.instance as usize];
        let vertices = [&vertices[a as usize], &vertices[b as usize], &vertices[c as usize]];
        let Some(forms) = EdgeForms::new(vertices) else { return };
        let Some((low, high)) = self.projection.bounds(vertices) else { return };
        for (place, lattice) in self.lattices.iter().enumerate() {
            let [columns, rows] = lattice.within(low, high);
            for row in rows.start.max(visible.rows.start)..rows.end.min(visible.rows.end) {
                let y = lattice.y[row];
                let line = forms.at_height(y);
                let mut columns = columns.clone();
                if columns.len() > FEW {
                    let Some((low, high)) = line.span() else { continue };
                    let column = |x: f64| self.projection.pixels(DVec2::new(x, y)).x - lattice.offset.x;
                    // Rounding moves the ends by much less than a pixel.
                    let between = whole_between(column(low) - 1.0, column(high) + 1.0, columns.end);
                    columns.start = columns.start.max(between.start);
                    columns.end = between.end;
                }
                let first = (row - visible.rows.start) * self.size.width;
                for column in columns {
                    let Some(depth) = line.depth_at(lattice.x[column]) else { continue };
                    if depth < self.clip.start_m || self.clip.end_m <= depth {
                        continue;
                    }
                    let sample = (first + column) * self.lattices.len() + place;
                    if depth < visible.depths[sample] {
                        if *is_blended {
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

impl SeenMesh {
    fn new(mesh: &DrawnMesh, projection: &Projection) -> Self {
        let camera_from_mesh = projection.camera_from_mesh(mesh.relative_from_mesh);
        let vertex =
            |position: &Vec3| projection.vertex(camera_from_mesh.transform_point3(position.as_dvec3()));
        Self { vertices: mesh.positions.iter().map(vertex).collect(), is_blended: mesh.is_blended }
    }
}

/// Rows in which a triangle may cover samples; `None` if it covers none, as small ones often lie between
/// samples.
fn rows(vertices: [&Vertex; 3], projection: &Projection, lattices: &[Lattice]) -> Option<[u32; 2]> {
    let (low, high) = projection.bounds(vertices)?;
    let mut found: Option<[u32; 2]> = None;
    for lattice in lattices {
        let [columns, rows] = lattice.within(low, high);
        if !columns.is_empty() && !rows.is_empty() {
            let [first, end] = found.unwrap_or([u32::MAX, 0]);
            found = Some([first.min(rows.start as u32), end.max(rows.end as u32)]);
        }
    }
    found
}

/// Integers below `count` from `low` to `high`, inclusive.
#[inline]
fn whole_between(low: f64, high: f64, count: usize) -> Range<usize> {
    // Casts truncate, saturate, and turn NaN into 0.
    let below = low as usize;
    let start = below.saturating_add(usize::from((below as f64) < low)).min(count);
    let end = if high >= 0.0 { (high as usize).saturating_add(1).min(count) } else { 0 };
    start..end.max(start)
}
