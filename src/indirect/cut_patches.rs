//! Patches that other walls cut in two. A floor continues behind the wall that stands on it. A slab has a
//! top, seen from above, and a bottom, seen from within. In go patches and the nodes that see them, out come
//! patches of one side each. Invariant: no other wall stands between the place where a patch is lit and those
//! where it is seen.

use crate::accel::PrimitiveId;
use crate::math::Ray;
use crate::ordinates::grid::Grid;
use crate::ordinates::walls::{CutNode, Patch, step_of};
use crate::snapshot::Snapshot;
use glam::DVec3;
use std::collections::HashMap;

/// Distance off a wall, in cells, at which rays along it start.
const OFF_WALL: f64 = 0.02;
/// Distance from a patch's plane, in cells, from which places may be on another side of a thin body.
const OFF_PLANE: f64 = 0.05;

/// Adds a second patch for nodes that see a patch at a place hidden from its own. Such places are in cells
/// with more than one mesh, or off a patch's plane. `primitives` has a triangle for each patch.
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

/// For each patch, whether its cell has a patch of another mesh.
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

/// Whether no wall stands between a patch's position and another place on it.
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
