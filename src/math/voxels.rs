//! Numbers at the whole places of a grid, trilinear between them, nothing beyond. In go bricks of 8 x 8 x 8,
//! out come values. Invariant: what holds nothing takes no memory but its place in a table.

use glam::{DVec3, IVec3};
use std::collections::HashMap;
use std::fmt;

/// Voxels along an edge of a brick, as a power of two.
const LOG_EDGE: i32 = 3;
pub(super) const EDGE: i32 = 1 << LOG_EDGE;
/// Voxels of a brick, z fastest: steps along x and y.
pub const BRICK: usize = 512;
const STEP_X: usize = 64;
const STEP_Y: usize = 8;
/// Places in the table at most: 64 MB.
const MOST_PLACES: u64 = 1 << 24;
const NOTHING: u32 = u32::MAX;

/// A grid of numbers, none of them negative.
pub struct Voxels {
    /// The first voxel of the first brick, and bricks along each axis.
    first: IVec3,
    bricks: IVec3,
    /// By place of a brick, z fastest: its number among those that hold something.
    table: Vec<u32>,
    /// By the same: whether any cell that begins in the brick holds something.
    holds: Vec<bool>,
    values: Vec<f32>,
    /// Corners of what is not nothing, in whole places.
    low: IVec3,
    high: IVec3,
    most: f32,
}

/// By where it lies: its numbers never change.
impl fmt::Debug for Voxels {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Voxels({self:p})")
    }
}

/// Why there is no grid.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum VoxelsError {
    /// Nothing is in it.
    #[error("no voxel is above 0")]
    Empty,
    /// It reaches too far.
    #[error("its voxels reach over {0} bricks of 8 x 8 x 8, more than {MOST_PLACES}")]
    TooWide(u64),
}

/// Bricks as they come, by their first voxel; a later one of the same place replaces the earlier.
#[derive(Debug, Default)]
pub struct VoxelsBuilder {
    values: Vec<f32>,
    /// By brick the number of its values.
    bricks: HashMap<IVec3, u32>,
    /// Numbers of bricks that are the same all over, by their value's bits.
    even: HashMap<u32, u32>,
}

impl VoxelsBuilder {
    /// A brick, z fastest. `first` is a multiple of 8; what is below 0 counts as nothing.
    pub fn add(&mut self, first: IVec3, values: impl IntoIterator<Item = f32>) {
        let number = (self.values.len() / BRICK) as u32;
        self.values.extend(values.into_iter().map(|value| value.max(0.0)).take(BRICK));
        self.values.resize((number as usize + 1) * BRICK, 0.0);
        self.bricks.insert(first >> LOG_EDGE, number);
    }

    /// A cube of one value, of `edge` voxels, a multiple of 8: its bricks share their values.
    ///
    /// # Errors
    /// If it reaches too far.
    pub fn add_even(&mut self, first: IVec3, edge: i32, value: f32) -> Result<(), VoxelsError> {
        let along = i64::from(edge >> LOG_EDGE);
        let count = along.pow(3) as u64 + self.bricks.len() as u64;
        if count > MOST_PLACES {
            return Err(VoxelsError::TooWide(count));
        }
        let number = *self.even.entry(value.to_bits()).or_insert_with(|| {
            let number = (self.values.len() / BRICK) as u32;
            self.values.resize(self.values.len() + BRICK, value.max(0.0));
            number
        });
        let along = along as i32;
        for place in 0..along.pow(3) {
            let offset = IVec3::new(place / (along * along), place / along % along, place % along);
            self.bricks.insert((first >> LOG_EDGE) + offset, number);
        }
        Ok(())
    }

    /// All of it.
    ///
    /// # Errors
    /// If there is nothing, or it reaches too far.
    pub fn built(self) -> Result<Voxels, VoxelsError> {
        let is_full = |number: &u32| {
            let start = *number as usize * BRICK;
            self.values[start..start + BRICK].iter().any(|value| *value > 0.0)
        };
        let full: HashMap<IVec3, u32> = self
            .bricks
            .iter()
            .filter(|(_, number)| is_full(number))
            .map(|(&at, &number)| (at, number))
            .collect();
        let low = full.keys().copied().reduce(IVec3::min).ok_or(VoxelsError::Empty)?;
        let high = full.keys().copied().reduce(IVec3::max).ok_or(VoxelsError::Empty)?;
        let bricks = high - low + 1;
        let places = bricks.to_array().into_iter().map(|count| count as u64).product::<u64>();
        if places > MOST_PLACES {
            return Err(VoxelsError::TooWide(places));
        }
        let mut voxels = Voxels {
            first: low << LOG_EDGE,
            bricks,
            table: vec![NOTHING; places as usize],
            holds: vec![false; places as usize],
            most: self.values.iter().copied().fold(0.0, f32::max),
            values: self.values,
            low: IVec3::MAX,
            high: IVec3::MIN,
        };
        for (&at, &number) in &full {
            let place = voxels.place(at - low).expect("it is within");
            voxels.table[place] = number;
            voxels.bound(at << LOG_EDGE, number);
        }
        // A cell has corners in the brick that it begins in and in those behind it.
        for &at in full.keys() {
            for corner in 0..8 {
                let before = at - low - IVec3::new(corner & 1, corner >> 1 & 1, corner >> 2);
                if let Some(place) = voxels.place(before) {
                    voxels.holds[place] = true;
                }
            }
        }
        Ok(voxels)
    }
}

impl Voxels {
    fn bound(&mut self, first: IVec3, number: u32) {
        let values = &self.values[number as usize * BRICK..][..BRICK];
        for place in (0..BRICK).filter(|place| values[*place] > 0.0) {
            let along = [place / STEP_X, place / STEP_Y % STEP_Y, place % STEP_Y].map(|index| index as i32);
            let voxel = first + IVec3::from(along);
            (self.low, self.high) = (self.low.min(voxel), self.high.max(voxel));
        }
    }

    /// Corners of the box outside of which it is nothing.
    pub fn bounds(&self) -> (DVec3, DVec3) {
        ((self.low - 1).as_dvec3(), (self.high + 1).as_dvec3())
    }

    /// Its largest number.
    pub fn most(&self) -> f64 {
        f64::from(self.most)
    }

    /// Of a brick by its steps from the first.
    fn place(&self, brick: IVec3) -> Option<usize> {
        let is_in = brick.cmpge(IVec3::ZERO).all() && brick.cmplt(self.bricks).all();
        is_in.then(|| ((brick.x * self.bricks.y + brick.y) * self.bricks.z + brick.z) as usize)
    }

    fn number(&self, brick: IVec3) -> u32 {
        self.place(brick).map_or(NOTHING, |place| self.table[place])
    }

    /// Whether the cells that begin in the brick of one of them hold anything.
    pub(super) fn brick_of_cell_holds(&self, cell: IVec3) -> bool {
        let brick = (cell - self.first) >> LOG_EDGE;
        // Before the first brick cells end in it.
        brick.cmplt(IVec3::ZERO).any() || self.place(brick).is_some_and(|place| self.holds[place])
    }

    /// Corners of the block of cells that begin in the brick of one of them.
    pub(super) fn block_of(&self, cell: IVec3) -> (IVec3, IVec3) {
        let low = self.first + (((cell - self.first) >> LOG_EDGE) << LOG_EDGE);
        (low, low + EDGE)
    }

    fn value(&self, voxel: IVec3) -> f32 {
        let from_first = voxel - self.first;
        match self.number(from_first >> LOG_EDGE) {
            NOTHING => 0.0,
            number => self.values[number as usize * BRICK + within(from_first)],
        }
    }

    /// At the corners of a cell: x fastest.
    pub(super) fn corners(&self, cell: IVec3) -> [f32; 8] {
        let from_first = cell - self.first;
        let local = from_first & (EDGE - 1);
        if local.max_element() < EDGE - 1 {
            let number = self.number(from_first >> LOG_EDGE);
            if number == NOTHING {
                return [0.0; 8];
            }
            let start = number as usize * BRICK + within(from_first);
            return std::array::from_fn(|corner| {
                self.values[start + (corner & 1) * STEP_X + (corner >> 1 & 1) * STEP_Y + (corner >> 2)]
            });
        }
        std::array::from_fn(|corner| {
            let corner = corner as i32;
            self.value(cell + IVec3::new(corner & 1, corner >> 1 & 1, corner >> 2))
        })
    }

    /// At a place.
    pub fn at(&self, place: DVec3) -> f64 {
        // As far out as whole numbers go.
        if place.is_nan() || place.abs().max_element() >= 1e9 {
            return 0.0;
        }
        let cell = place.floor().as_ivec3();
        trilinear(&self.corners(cell), place - cell.as_dvec3())
    }
}

/// Of a voxel's values in its brick.
fn within(from_first: IVec3) -> usize {
    let local = from_first & (EDGE - 1);
    local.x as usize * STEP_X + local.y as usize * STEP_Y + local.z as usize
}

/// Between a cell's corners; `share` of the way along each axis.
pub(super) fn trilinear(corners: &[f32; 8], share: DVec3) -> f64 {
    let along = |from: f32, to: f32| f64::from(from) + share.x * (f64::from(to) - f64::from(from));
    let [a, b] = [0, 4].map(|z| {
        let (low, high) = (along(corners[z], corners[z + 1]), along(corners[z + 2], corners[z + 3]));
        low + share.y * (high - low)
    });
    a + share.z * (b - a)
}
