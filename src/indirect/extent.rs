//! Where grids lie and how fine they are. In go a snapshot and what surrounds the camera in it,
//! out come nested grids. Invariant: sides of cells are powers of the root of two, so they change
//! rarely where bounds move.

use super::field::WALL_CELLS;
use super::grid::Grid;
use super::surroundings::Surroundings;
use crate::math::Ray;
use crate::snapshot::Snapshot;
use glam::DVec3;

/// Nodes of the innermost grid, about, and of each about it.
const NODES: f64 = 30_000.0;
const OUTER_NODES: f64 = 24_000.0;
/// And of those beyond the first of them.
const FAR_NODES: f64 = 8_000.0;
/// A cell is no smaller than so many leaves: else a leaf that moves is now in one cell, now in another.
const LEAVES_PER_CELL: f64 = 2.0;
/// Fewer leaves are no reason for large cells of fog: where cells are small beside them they are walls.
const FEW_LEAVES: usize = 16;
/// Along the longest side, however large leaves are.
const FEWEST_CELLS: f64 = 16.0;
/// Or in any box: what is flat would else have cells as small as it is thin.
const MOST_CELLS: f64 = 192.0;
/// All grids together.
const MOST_LEVELS: usize = 5;
/// A grid reaches beyond the one within it by so many of that one's longest sides.
const MARGIN: f64 = 1.5;
/// Or to the end of the world, if that is at most so many times as long: where two grids meet, light is known
/// less well.
const ONE_GRID: f64 = 12.0;
/// There is another grid where the world is so many times as long as all of them.
const LARGER: f64 = 1.01;
/// The innermost grid reaches to the world's end on sides where that is nearer than this share of its longest
/// side: walls about leaves lie within it, or well beyond its rim, where nothing cuts light off.
const NEAR: f64 = 0.25;
/// Fog without bounds counts as far as this optical depth, or nearly all that there is of it.
const FOG_DEPTH: f64 = 4.0;
/// Beneath things, where they end before it does: less of that is seen.
const DEPTH_BENEATH: f64 = 2.0;
const NEARLY_ALL: f64 = 0.95;
/// Or as far as so many times the size of the innermost grid.
const FARTHEST: f64 = 1e3;

/// A box of world space.
type Bounds = (DVec3, DVec3);

/// About all fog that has bounds and all leaves, without either about everything; then about that, as far as
/// there are things or fog. Cells are `scale` times as wide as they would be, but no finer than leaves allow.
/// The innermost comes first.
pub(super) fn levels(snapshot: &Snapshot, surroundings: &Surroundings, scale: f64) -> Vec<Grid> {
    let all = surroundings.bounds(f64::INFINITY);
    let fog = bounded_fog(snapshot);
    let widest = 0.1 * all.map_or(0.0, diagonal).max(fog.map_or(0.0, diagonal));
    let leaves = surroundings.bounds(widest);
    let Some(inner) = [fog, leaves].into_iter().flatten().reduce(union).or(all) else { return Vec::new() };
    let world = world(snapshot, inner, all);
    let inner = with_near_sides(inner, world);
    let side = side(inner);
    let fine = (side.element_product() / NODES).cbrt().max(side.max_element() / MOST_CELLS);
    let leaf_m = match surroundings.leaf_width_m(widest.min(WALL_CELLS * fine), FEW_LEAVES) {
        0.0 if fog.is_none() => surroundings.leaf_width_m(widest, 1),
        leaf_m => leaf_m,
    };
    let finest = (LEAVES_PER_CELL * leaf_m).min(side.max_element() / FEWEST_CELLS);
    let mut cell_m = (scale * fine.max(finest)).max(finest);
    let mut grids: Vec<Grid> = grid(inner, cell_m).into_iter().collect();
    let mut bounds = inner;
    while grids.len() < MOST_LEVELS && diagonal(world) > LARGER * diagonal(bounds) {
        let is_last = diagonal(world) <= ONE_GRID * diagonal(bounds);
        let margin = if is_last { f64::INFINITY } else { MARGIN * (bounds.1 - bounds.0).max_element() };
        bounds = union(inner, ((bounds.0 - margin).max(world.0), (bounds.1 + margin).min(world.1)));
        let nodes = if grids.len() == 1 { OUTER_NODES } else { FAR_NODES };
        cell_m = (scale * (self::side(bounds).element_product() / nodes).cbrt()).max(2.0 * cell_m);
        grids.extend(grid(bounds, cell_m));
    }
    grids
}

fn grid((low, high): Bounds, cell_m: f64) -> Option<Grid> {
    let cell_m = rung(cell_m);
    (cell_m > 0.0 && cell_m.is_finite()).then(|| Grid::covering(low, high, cell_m))
}

/// The next of the sizes that cells may have.
fn rung(cell_m: f64) -> f64 {
    2.0_f64.powf((2.0 * cell_m.log2()).ceil() / 2.0)
}

fn union(a: Bounds, b: Bounds) -> Bounds {
    (a.0.min(b.0), a.1.max(b.1))
}

fn with_near_sides(inner: Bounds, world: Bounds) -> Bounds {
    let near = NEAR * (inner.1 - inner.0).max_element();
    let low = DVec3::select((inner.0 - world.0).cmple(DVec3::splat(near)), world.0, inner.0);
    let high = DVec3::select((world.1 - inner.1).cmple(DVec3::splat(near)), world.1, inner.1);
    (low, high)
}

fn diagonal((low, high): Bounds) -> f64 {
    (high - low).length()
}

/// Nowhere flat.
fn side((low, high): Bounds) -> DVec3 {
    (high - low).max(DVec3::splat(1e-3 * (high - low).max_element()))
}

fn bounded_fog(snapshot: &Snapshot) -> Option<Bounds> {
    let eye = snapshot.view.eye;
    let boxes = snapshot.medium.banks().iter().filter_map(|bank| bank.bounds());
    boxes.map(|(low, high)| (low + eye, high + eye)).reduce(union)
}

/// All that there is: things, and fog without bounds as far as it matters about the innermost grid.
fn world(snapshot: &Snapshot, inner: Bounds, things: Option<Bounds>) -> Bounds {
    let known = things.map_or(inner, |things| union(things, inner));
    if snapshot.medium.banks().iter().all(|bank| bank.bounds().is_some()) {
        return known;
    }
    let middle = 0.5 * (inner.0 + inner.1);
    let ray = |direction: DVec3| Ray { origin: middle - snapshot.view.eye, direction };
    let reach = |direction: DVec3| reach_m(snapshot, &ray(direction), (diagonal(inner), FOG_DEPTH));
    let high = DVec3::new(reach(DVec3::X), reach(DVec3::Y), reach(DVec3::Z));
    let low = DVec3::new(reach(-DVec3::X), reach(-DVec3::Y), reach(-DVec3::Z));
    let mut fog = (middle - low, middle + high);
    let is_covered =
        [known.0.cmple(fog.0), known.1.cmpge(fog.1)].iter().all(|sides| sides.test(0) && sides.test(2));
    let beneath = if is_covered { 0.0 } else { DEPTH_BENEATH };
    let lowest = middle.y - reach_m(snapshot, &ray(-DVec3::Y), (diagonal(inner), beneath));
    fog.0.y = fog.0.y.max(lowest.min(known.0.y));
    union(known, fog)
}

/// How far fog goes on that matters, up to an optical depth.
fn reach_m(snapshot: &Snapshot, ray: &Ray, (size_m, most): (f64, f64)) -> f64 {
    let depth =
        |reach_m: f64| snapshot.medium.optical_depth(ray.origin, ray.direction, reach_m).max_element();
    let farthest = FARTHEST * size_m;
    let enough = most.min(NEARLY_ALL * depth(farthest));
    let (mut near, mut far) = (0.0, farthest);
    for _ in 0..40 {
        let middle = 0.5 * (near + far);
        if depth(middle) < enough { near = middle } else { far = middle }
    }
    far
}
