//! Bounds and cell sizes of grids. In goes a snapshot with its surroundings, out come nested grids.
//! Invariant: sides of cells are powers of the square root of 2, so they change rarely as bounds move.

use super::contents::WALL_CELLS;
use super::layers::Layers;
use crate::canopy::core_bounds::{Bounds, Strays, Weighed, core_bounds, union};
use crate::canopy::surroundings::Surroundings;
use crate::color::Rgb;
use crate::math::Ray;
use crate::ordinates::grid::Grid;
use crate::snapshot::{FrozenLight, Luminaire, Snapshot};
use glam::{BVec3, DVec3};

/// Approximate number of nodes of the innermost grid, and of the next unless it has nothing but shade.
const NODES: f64 = 30_000.0;
const OUTER_NODES: f64 = 24_000.0;
/// Approximate number of nodes of each other grid.
const FAR_NODES: f64 = 8_000.0;
/// Maximum number of cells of an outer grid along its longest side: ground is flat, so its grid has that
/// number squared.
const OUTER_CELLS: f64 = 64.0;
/// Minimum size of a cell, in leaf widths: in smaller cells moving leaves would jump from cell to cell.
pub(super) const LEAVES_PER_CELL: f64 = 2.0;
/// Minimum number of leaves that enlarge cells of fog: fewer are walls where cells are small beside them.
pub(super) const FEW_LEAVES: usize = 16;
/// Ratio of cell sizes from which fog around leaves has a grid of its own.
const COARSEST: f64 = 8.0;
/// Maximum size of a leaf, as a share of the diagonal of everything.
const SMALL: f64 = 0.1;
/// Minimum number of cells along the longest side, however large leaves are.
const FEWEST_CELLS: f64 = 16.0;
/// Maximum number of cells along the longest side: otherwise cells of a flat box would be as small as it is
/// thin.
const MOST_CELLS: f64 = 192.0;
/// Maximum number of grids; the last reaches as far as the world does.
const MOST_LEVELS: usize = 6;
/// Margin of a grid around the next inner one, in the longest sides of that one.
const MARGIN: f64 = 1.5;
/// Ratio of the world's size to the grid's up to which the next grid covers the whole world: light is less
/// accurate where two grids meet.
const ONE_GRID: f64 = 12.0;
/// Ratio of the world's size to that of all grids above which there is another grid.
const LARGER: f64 = 1.01;
/// Distance to the world's bounds, as a share of the innermost grid's longest side, within which the grid
/// extends to them. So walls around leaves lie within the grid, or well beyond its rim, where nothing cuts
/// light off.
const NEAR: f64 = 0.25;
/// Maximum length of shadows that count beside layers, in heights of the objects that cast them.
const LONGEST_SHADOW: f64 = 4.0;
/// Optical depth to which unbounded fog counts; the depth to `NEARLY_ALL` of it if that is less.
const FOG_DEPTH: f64 = 4.0;
/// Optical depth below objects, where these end before the fog does: less of that is seen.
const DEPTH_BENEATH: f64 = 2.0;
const NEARLY_ALL: f64 = 0.95;
/// Maximum distance to which unbounded fog counts, in sizes of the innermost grid.
const FARTHEST: f64 = 1e3;

/// Optical depth of a cell above which lamps in bounded fog have finer cells about them: close to a lamp,
/// light that is scattered twice falls off as 1/r.
const LAMP_CELL_DEPTH: f64 = 0.05;
/// Optical depth of a cell that leaves ask for, above which a lamp's surroundings are the innermost grid.
const LEAF_CELL_DEPTH: f64 = 0.2;
/// Optical depth around a lamp that these cells cover.
const LAMP_DEPTH: f64 = 0.5;
/// Optical depth around a lamp to which unbounded fog counts.
const LIT_DEPTH: f64 = 2.0;
/// Maximum distance from a lamp to which it counts, in multiples of the lamp's height above ground plus the
/// fog's scale height.
const LIT_HEIGHTS: f64 = 8.0;
/// Maximum height above the lamp, in the fog's scale heights.
const LIT_ABOVE: f64 = 3.0;

/// Grids around all bounded fog and all leaves, or around everything if there are none; then outer grids, up
/// to the bounds of all objects and fog. The innermost comes first.
pub(super) fn levels(
    snapshot: &Snapshot,
    surroundings: &Surroundings,
    layers: Option<&Layers>,
    emissive: &[Luminaire],
) -> Vec<Grid> {
    let things = surroundings.boxes(f64::INFINITY);
    let all = core_bounds(things, Strays::Lost);
    let fogs = bounded_fogs(snapshot, layers);
    let fog = core_bounds(fogs.clone(), Strays::Sparse);
    let widest = widest_leaf_m(surroundings, [all, fog]);
    let leaves = core_bounds(surroundings.boxes(widest), Strays::Sparse);
    let leaf_m = leaf_width_m(surroundings, leaves, widest);
    let lamps = fog.and_then(|fog| about_lamps(snapshot, fog, emissive));
    let lit = |depth| layers.map_or_else(Vec::new, |layers| lit_fogs(snapshot, layers, (emissive, depth)));
    let lamps_alone = || lit(LAMP_DEPTH).into_iter().reduce(union);
    let resolved = resolved(snapshot, [fog, leaves, lamps], leaf_m);
    let inner = resolved.or(leaves).or(fog).or(all).or_else(lamps_alone);
    let Some(inner) = inner else { return Vec::new() };
    let all = [all, core_bounds(fogs, Strays::Lost)].into_iter().flatten().reduce(union);
    let things = all.map_or(inner, |all| union(all, inner));
    let world = match layers {
        Some(layers) => {
            let near = lit(LIT_DEPTH).into_iter().filter(|lit| is_near(*lit, inner));
            near.fold(with_shade(snapshot, layers, layers.down_to_ground(things)), union)
        }
        None => world(snapshot, inner, things),
    };
    let inner = with_near_sides(inner, world);
    let mut cell_m = fine_m(inner).max(finest_m(surroundings, inner, widest, fog.is_some()));
    let ends = |(low, high): Bounds| {
        let [at_low, at_high] = [low.cmple(world.0), high.cmpge(world.1)];
        match layers {
            None => [at_low, at_high],
            // All other sides border on layers.
            Some(layers) => [at_low & BVec3::new(false, layers.end_below(), false), BVec3::FALSE],
        }
    };
    let grid = |bounds, cell_m| {
        let grid = grid(bounds, cell_m)?.closed(ends(bounds));
        // Larger cells beyond do not resolve where dense fog ends.
        Some(if fog.is_some() { grid.widened() } else { grid })
    };
    // Slabs have cells as fine as other bounded fog.
    let is_shade_alone =
        layers.is_some() && snapshot.medium.is_unbounded() && diagonal(things) <= LARGER * diagonal(inner);
    let mut grids: Vec<Grid> = grid(inner, cell_m).into_iter().collect();
    let mut bounds = inner;
    while grids.len() < MOST_LEVELS && diagonal(world) > LARGER * diagonal(bounds) {
        let is_last = diagonal(world) <= ONE_GRID * diagonal(bounds) || grids.len() + 1 == MOST_LEVELS;
        let margin = if is_last { f64::INFINITY } else { MARGIN * (bounds.1 - bounds.0).max_element() };
        bounds = union(inner, ((bounds.0 - margin).max(world.0), (bounds.1 + margin).min(world.1)));
        let nodes = if grids.len() == 1 && !is_shade_alone { OUTER_NODES } else { FAR_NODES };
        let side = side(bounds);
        let even = (side.element_product() / nodes).cbrt().max(side.max_element() / OUTER_CELLS);
        cell_m = even.max(2.0 * cell_m);
        grids.extend(grid(bounds, cell_m));
    }
    grids
}

/// Bounded fog and leaves; leaves and lamps alone, where its cells would be too large for lamps, and lamps
/// alone, where those of leaves would be. `None` where its cells are too large for leaves.
fn resolved(snapshot: &Snapshot, [fog, leaves, lamps]: [Option<Bounds>; 3], leaf_m: f64) -> Option<Bounds> {
    let all = [fog, leaves].into_iter().flatten().reduce(union)?;
    let less = [lamps, leaves].into_iter().flatten().reduce(union);
    let density_per_m = snapshot.medium.most_ever_per_m();
    let leaf_cell_m = LEAVES_PER_CELL * leaf_m;
    let is_dense = leaf_cell_m * density_per_m > LEAF_CELL_DEPTH;
    if let Some(lamps) = lamps.filter(|lamps| is_dense && 2.0 * fine_m(*lamps) < leaf_cell_m) {
        return Some(lamps);
    }
    let is_coarse = fine_m(all) * density_per_m > LAMP_CELL_DEPTH;
    let is_finer = |less: &Bounds| lamps.is_some() && 2.0 * fine_m(*less) < fine_m(all);
    let bounds = less.filter(is_finer).filter(|_| is_coarse).unwrap_or(all);
    (leaf_m == 0.0 || fine_m(bounds) < COARSEST * leaf_cell_m).then_some(bounds)
}

/// Maximum size of a leaf beside all things; beside fog, unless most that is small beside it is small beside
/// things as well. So ground of some metres is no leaf of wide fog.
fn widest_leaf_m(surroundings: &Surroundings, [things, fog]: [Option<Bounds>; 2]) -> f64 {
    let [things, fog] = [things, fog].map(|bounds| SMALL * bounds.map_or(0.0, diagonal));
    if things >= fog {
        return things;
    }
    let [among_things, in_fog] = [things, fog].map(|widest_m| surroundings.boxes(widest_m).len());
    if among_things >= FEW_LEAVES && 2 * among_things > in_fog { things } else { fog }
}

/// Width of leaves in their bounds. What a grid about these has as a wall is none, if others are.
fn leaf_width_m(surroundings: &Surroundings, leaves: Option<Bounds>, widest: f64) -> f64 {
    let widest_leaf = leaves.map_or(widest, |leaves| widest.min(WALL_CELLS * fine_m(leaves)));
    match surroundings.leaf_width_m(widest_leaf, FEW_LEAVES) {
        0.0 => surroundings.leaf_width_m(widest, FEW_LEAVES),
        leaf_m => leaf_m,
    }
}

/// Cell size that leaves ask for.
fn finest_m(surroundings: &Surroundings, inner: Bounds, widest: f64, has_fog: bool) -> f64 {
    let leaf_m = match surroundings.leaf_width_m(widest.min(WALL_CELLS * fine_m(inner)), FEW_LEAVES) {
        0.0 if !has_fog => surroundings.leaf_width_m(widest, 1),
        leaf_m => leaf_m,
    };
    (LEAVES_PER_CELL * leaf_m).min(side(inner).max_element() / FEWEST_CELLS)
}

fn grid((low, high): Bounds, cell_m: f64) -> Option<Grid> {
    let cell_m = rung(cell_m);
    (cell_m > 0.0 && cell_m.is_finite()).then(|| Grid::covering(low, high, cell_m))
}

/// The next larger of the sizes that cells may have.
fn rung(cell_m: f64) -> f64 {
    2.0_f64.powf((2.0 * cell_m.log2()).ceil() / 2.0)
}

/// Cell size of a box for the usual number of nodes.
fn fine_m(bounds: Bounds) -> f64 {
    let side = side(bounds);
    (side.element_product() / NODES).cbrt().max(side.max_element() / MOST_CELLS)
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

/// Size of a box, with a minimum where it is flat.
fn side((low, high): Bounds) -> DVec3 {
    (high - low).max(DVec3::splat(1e-3 * (high - low).max_element()))
}

/// Bounds of fog, without those of layers.
fn bounded_fogs(snapshot: &Snapshot, layers: Option<&Layers>) -> Vec<Weighed> {
    let fog = layers.map_or(&snapshot.medium, |layers| &layers.other_fog);
    let eye = snapshot.view.eye;
    let weighed = |(low, high): (DVec3, DVec3)| {
        let size = high - low;
        let area_m2 = size.element_product() / size.min_element().max(f64::MIN_POSITIVE);
        Weighed { bounds: (low + eye, high + eye), area_m2 }
    };
    fog.all_bounds().map(weighed).collect()
}

/// Bounded fog around lamps and emissive surfaces, as far as their light varies much. Fog of voxels is left
/// out, as its density varies as much.
fn about_lamps(snapshot: &Snapshot, fog: Bounds, emissive: &[Luminaire]) -> Option<Bounds> {
    let medium = &snapshot.medium;
    let reach = DVec3::splat(LAMP_DEPTH / medium.most_ever_per_m());
    let about = |light: &Luminaire| {
        let FrozenLight::Point { position, .. } = light.centre() else { return None };
        let place = snapshot.world_from_relative(position);
        let is_in_fog = medium.extinction_at(position) != Rgb::ZERO;
        is_in_fog.then(|| ((place - reach).max(fog.0), (place + reach).min(fog.1)))
    };
    let lights = snapshot.lights.iter().chain(emissive).filter(|_| !medium.has_voxels());
    lights.filter_map(about).reduce(union)
}

/// Things with the fog and the ground that they shade, as layers have the light of an open plain: all around
/// as far as they are high, and in shadows of suns.
fn with_shade(snapshot: &Snapshot, layers: &Layers, things: Bounds) -> Bounds {
    let up = layers.heights.up;
    let height_m = (things.1 - things.0).dot(up.abs());
    let around = height_m * (DVec3::ONE - up.abs());
    let shadow = |light: &Luminaire| match light.centre() {
        FrozenLight::Sun { to_light, .. } if to_light.dot(up) > 0.0 => {
            let along = height_m * (up - to_light / to_light.dot(up));
            Some(along.clamp_length_max(LONGEST_SHADOW * height_m))
        }
        _ => None,
    };
    let shadows = snapshot.lights.iter().filter_map(shadow);
    let shaded = shadows.map(|shadow| (things.0 + shadow, things.1 + shadow));
    shaded.fold((things.0 - around, things.1 + around), union)
}

/// Fog around lamps and emissive surfaces, whose light layers do not have, to an optical depth.
fn lit_fogs(snapshot: &Snapshot, layers: &Layers, (emissive, depth): (&[Luminaire], f64)) -> Vec<Bounds> {
    let up = layers.heights.up.abs();
    let about = |light: &Luminaire| {
        let FrozenLight::Point { position, .. } = light.centre() else { return None };
        let place = snapshot.world_from_relative(position);
        let farthest_m = LIT_HEIGHTS * (layers.above_ground_m(place) + layers.heights.scale_m);
        let ray = Ray { origin: position, direction: up.any_orthonormal_vector() };
        let reach_m = reach_m(snapshot, &ray, farthest_m, depth);
        let reach = reach_m * (DVec3::ONE - up) + reach_m.min(LIT_ABOVE * layers.heights.scale_m) * up;
        Some((place - reach, place + reach))
    };
    snapshot.lights.iter().chain(emissive).filter_map(about).collect()
}

/// Whether fog is close enough to a grid to be part of its world.
fn is_near(fog: Bounds, inner: Bounds) -> bool {
    let [fog_at, inner_at] = [fog, inner].map(|(low, high)| 0.5 * (low + high));
    fog_at.distance(inner_at) <= 0.5 * diagonal(fog) + ONE_GRID * diagonal(inner)
}

/// Bounds of everything: objects, and unbounded fog as far as it counts for the innermost grid.
fn world(snapshot: &Snapshot, inner: Bounds, known: Bounds) -> Bounds {
    if !snapshot.medium.is_unbounded() {
        return known;
    }
    let middle = 0.5 * (inner.0 + inner.1);
    let farthest_m = FARTHEST * diagonal(inner);
    let ray = |direction: DVec3| Ray { origin: middle - snapshot.view.eye, direction };
    let reach = |direction: DVec3| reach_m(snapshot, &ray(direction), farthest_m, FOG_DEPTH);
    let high = DVec3::new(reach(DVec3::X), reach(DVec3::Y), reach(DVec3::Z));
    let low = DVec3::new(reach(-DVec3::X), reach(-DVec3::Y), reach(-DVec3::Z));
    let mut fog = (middle - low, middle + high);
    let is_covered =
        [known.0.cmple(fog.0), known.1.cmpge(fog.1)].iter().all(|sides| sides.test(0) && sides.test(2));
    let beneath = if is_covered { 0.0 } else { DEPTH_BENEATH };
    let lowest = middle.y - reach_m(snapshot, &ray(-DVec3::Y), farthest_m, beneath);
    fog.0.y = fog.0.y.max(lowest.min(known.0.y));
    union(known, fog)
}

/// Distance along a ray to an optical depth of fog.
fn reach_m(snapshot: &Snapshot, ray: &Ray, farthest: f64, most: f64) -> f64 {
    let along = snapshot.medium.along(ray, farthest);
    let depth = |reach_m: f64| along.optical_depth(reach_m).max_element();
    let enough = most.min(NEARLY_ALL * depth(farthest));
    let (mut near, mut far) = (0.0, farthest);
    for _ in 0..40 {
        let middle = 0.5 * (near + far);
        if depth(middle) < enough { near = middle } else { far = middle }
    }
    far
}
