//! Height field of the leaves on the ground, on a fine grid. In go leaves at rest, out come heights.
//! Invariant: a square's height is that of its highest leaf, up to the bend of the mesh within the square.

use super::ground::Ground;
use super::outline::Outline;
use glam::{DQuat, DVec3};
use std::collections::HashMap;
use std::hash::{BuildHasherDefault, Hasher};

/// Squares along a leaf of the mean length, and at most along the longest.
const SQUARES_ALONG: f64 = 20.0;
const MOST_SQUARES_ALONG: f64 = 64.0;
/// Squares along a side of a tile: larger tiles would waste memory around single leaves.
const TILE: i32 = 8;
/// Height without leaves.
const BARE: f32 = f32::NEG_INFINITY;

/// Heights by squares, in tiles that exist where leaves lie.
pub(super) struct Heap {
    square_m: f64,
    tiles: Vec<Tile>,
    /// Indices of tiles, by [`key`].
    numbers: HashMap<u64, usize, BuildHasherDefault<OfKeys>>,
}

#[derive(Clone)]
struct Tile {
    highest_m: f32,
    tops_m: Vec<f32>,
}

/// Points of a leaf, one a square, relative to its centre.
pub(super) struct Sheet {
    points: Vec<DVec3>,
}

/// Pose of a sheet: centre and rotation.
#[derive(Clone, Copy)]
pub(super) struct Lie {
    pub(super) middle: DVec3,
    pub(super) turn: DQuat,
}

impl Heap {
    /// Creates a heap for leaves with these ranges of lengths.
    pub(super) fn new(lengths_m: impl Iterator<Item = (f64, f64)>) -> Self {
        let (mut sum, mut count, mut longest) = (0.0, 0.0, 0.0_f64);
        for (low, high) in lengths_m {
            (sum, count, longest) = (sum + 0.5 * (low + high), count + 1.0, longest.max(high));
        }
        let square_m = (sum / (count * SQUARES_ALONG)).max(longest / MOST_SQUARES_ALONG);
        Self { square_m, tiles: Vec::new(), numbers: HashMap::default() }
    }

    /// Sheet of a mesh with a scale of at most `scale`.
    pub(super) fn sheet(&self, outline: &Outline, scale: f64) -> Sheet {
        Sheet { points: outline.sampled(self.square_m / scale) }
    }

    /// Whether a leaf of at least this height may lie within a distance of a place.
    pub(super) fn may_reach(&self, place: DVec3, within_m: f64, height_m: f64) -> bool {
        let [low_x, low_z] =
            self.square(place.x - within_m, place.z - within_m).map(|at| at.div_euclid(TILE));
        let [high_x, high_z] =
            self.square(place.x + within_m, place.z + within_m).map(|at| at.div_euclid(TILE));
        let mut tiles = (low_x..=high_x).flat_map(|x| (low_z..=high_z).map(move |z| [x, z]));
        tiles.any(|place| self.tile(place).is_some_and(|tile| f64::from(tile.highest_m) >= height_m))
    }

    fn tile(&self, place: [i32; 2]) -> Option<&Tile> {
        self.numbers.get(&key(place)).map(|&number| &self.tiles[number])
    }

    /// Heights under a sheet's points, in their order; `None` over bare ground.
    fn under<'a>(&'a self, points: &'a [DVec3]) -> impl Iterator<Item = Option<f64>> + 'a {
        // Neighbours are mostly in the same tile.
        let mut last: Option<([i32; 2], Option<&Tile>)> = None;
        points.iter().map(move |point| {
            let square = self.square(point.x, point.z);
            let place = square.map(|at| at.div_euclid(TILE));
            let tile = match last {
                Some((at, tile)) if at == place => tile,
                _ => self.tile(place),
            };
            last = Some((place, tile));
            tile.map(|tile| tile.tops_m[within_tile(square)]).filter(|&top| top > BARE).map(f64::from)
        })
    }

    /// Lowest height of a sheet's centre at which no point is below the heap; minus infinity over bare
    /// ground.
    pub(super) fn lowest_height_m(&self, sheet: &Sheet, lie: Lie) -> f64 {
        let points = sheet.at(lie);
        let heights = self.under(&points).zip(&points);
        let over = heights.filter_map(|(top, point)| Some(lie.middle.y + top? - point.y));
        over.fold(f64::NEG_INFINITY, f64::max)
    }

    /// Distances by which each point of a sheet has to rise to the heap or the ground.
    pub(super) fn rises(&self, sheet: &Sheet, lie: Lie, ground: &Ground) -> Vec<DVec3> {
        let points = sheet.at(lie);
        let floors = self.under(&points).zip(&points).map(|(top, point)| {
            let ground_m = ground.height_m(point.x, point.z);
            let floor = top.map_or(ground_m, |top| top.max(ground_m));
            DVec3::new(point.x - lie.middle.x, floor - point.y, point.z - lie.middle.z)
        });
        floors.collect()
    }

    /// Adds a leaf.
    pub(super) fn lay(&mut self, sheet: &Sheet, lie: Lie) {
        let half = 0.5 * self.square_m;
        let mut last: Option<([i32; 2], usize)> = None;
        for point in sheet.at(lie) {
            let top_m = point.y as f32;
            let [low_x, low_z] = self.square(point.x - half, point.z - half);
            let [high_x, high_z] = self.square(point.x + half, point.z + half);
            for square in (low_x..=high_x).flat_map(|x| (low_z..=high_z).map(move |z| [x, z])) {
                let place = square.map(|at| at.div_euclid(TILE));
                let number = match last {
                    Some((at, number)) if at == place => number,
                    _ => *self.numbers.entry(key(place)).or_insert(self.tiles.len()),
                };
                last = Some((place, number));
                if number == self.tiles.len() {
                    self.tiles.push(Tile { highest_m: BARE, tops_m: vec![BARE; (TILE * TILE) as usize] });
                }
                let tile = &mut self.tiles[number];
                tile.highest_m = tile.highest_m.max(top_m);
                let top = &mut tile.tops_m[within_tile(square)];
                *top = top.max(top_m);
            }
        }
    }

    fn square(&self, x: f64, z: f64) -> [i32; 2] {
        [x, z].map(|along| (along / self.square_m).floor() as i32)
    }
}

impl Sheet {
    /// Sheet of a scaled mesh.
    pub(super) fn scaled(&self, scale: f64) -> Self {
        Self { points: self.points.iter().map(|&point| point * scale).collect() }
    }

    /// Mean of its points, an estimate of its centre of mass.
    pub(super) fn mean(&self) -> DVec3 {
        self.points.iter().sum::<DVec3>() / self.points.len() as f64
    }

    /// Points in the world.
    fn at(&self, lie: Lie) -> Vec<DVec3> {
        self.points.iter().map(|&point| lie.middle + lie.turn * point).collect()
    }
}

fn key([x, z]: [i32; 2]) -> u64 {
    (u64::from(x as u32) << 32) | u64::from(z as u32)
}

/// Multiplicative hash (Knuth, volume 3, 6.4), for keys that are not adversarial.
#[derive(Default)]
struct OfKeys(u64);

impl Hasher for OfKeys {
    fn write_u64(&mut self, key: u64) {
        let mixed = (key ^ (key >> 32)).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        self.0 = mixed ^ (mixed >> 32);
    }

    fn write(&mut self, bytes: &[u8]) {
        bytes.iter().for_each(|&byte| self.write_u64((self.0 << 8) | u64::from(byte)));
    }

    fn finish(&self) -> u64 {
        self.0
    }
}

fn within_tile(square: [i32; 2]) -> usize {
    let [x, z] = square.map(|at| at.rem_euclid(TILE));
    (z * TILE + x) as usize
}
