//! Patches of walls that walls cut in two. A floor goes on behind the wall that stands on it. A slab has a
//! top, seen from above, and a bottom, seen from within. In go patches and who sees them, out come patches of
//! one side each. Invariant: no other wall stands between where a patch is lit and where it is seen.

use crate::accel::PrimitiveId;
use crate::math::Ray;
use crate::ordinates::grid::Grid;
use crate::ordinates::walls::{CutNode, Patch, step_of};
use crate::snapshot::Snapshot;
use glam::DVec3;
use std::collections::HashMap;

/// Distance off a wall, in cells, at which rays along it start.
const OFF_WALL: f64 = 0.02;
/// Places that lie so far from a patch's plane, in cells, may be of another side of a thin body.
const OFF_PLANE: f64 = 0.05;

/// Adds to patches a second one each, for those who see it where its place is hidden. That may be in cells
/// that more than one mesh goes through, and off a patch's plane. Each patch has a triangle.
pub(super) fn cut_patches(
    (grid, snapshot): (&Grid, &Snapshot),
    nodes: &mut [CutNode],
    (patches, primitives): (&mut Vec<Patch>, &mut Vec<PrimitiveId>),
) {
    let is_crowded = in_crowded_cells(grid, patches, primitives);
    let mut others: HashMap<u32, u32> = HashMap::new();
    for cut in nodes {
        let from = grid.position(cut.node);
        for (link, seen) in cut.cut_links_mut() {
            let point = from + f64::from(seen.at) * grid.cell_m * step_of(link).as_dvec3();
            let number = seen.patch as usize;
            let (patch, primitive) = (&patches[number], primitives[number]);
            let off_plane = (point - patch.position).dot(patch.normal).abs();
            let may_be_cut = is_crowded[number] || off_plane > OFF_PLANE * grid.cell_m;
            if !may_be_cut || is_open((grid, snapshot), (patch, primitive), point) {
                continue;
            }
            let other = Patch { position: point, seen_by: Vec::new(), ..*patch };
            seen.patch = *others.entry(seen.patch).or_insert_with(|| {
                patches.push(other);
                primitives.push(primitive);
                patches.len() as u32 - 1
            });
        }
    }
}

/// Whether a patch of another mesh is in the cell of each patch.
fn in_crowded_cells(grid: &Grid, patches: &[Patch], primitives: &[PrimitiveId]) -> Vec<bool> {
    let cell = |patch: &Patch| grid.nearest(patch.position + 0.25 * grid.cell_m * patch.normal);
    let mut only_mesh: HashMap<usize, Option<u32>> = HashMap::new();
    for (patch, primitive) in patches.iter().zip(primitives) {
        let mesh = Some(primitive.instance);
        let known = only_mesh.entry(cell(patch)).or_insert(mesh);
        if *known != mesh {
            *known = None;
        }
    }
    patches.iter().map(|patch| only_mesh[&cell(patch)].is_none()).collect()
}

/// Whether no wall stands between a patch's place and another one of it.
fn is_open(
    (grid, snapshot): (&Grid, &Snapshot),
    (patch, primitive): (&Patch, PrimitiveId),
    point: DVec3,
) -> bool {
    let off_wall = OFF_WALL * grid.cell_m * patch.normal - snapshot.view.eye;
    let way = point - patch.position;
    let ray = Ray { origin: patch.position + off_wall, direction: way.normalize_or_zero() };
    !snapshot.tree.any_hit(&ray, way.length(), Some(primitive))
}
