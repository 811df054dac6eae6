//! Numbers at integer places of a grid, trilinear between them, 0 outside. In go bricks of 8 x 8 x 8, out
//! come values. Invariant: empty regions take no memory but their entries in a table.

use super::brick_rows::{BRICK, BrickRows, EDGE, LOG_EDGE, NOTHING};
use glam::{DVec3, IVec3};
use std::collections::HashMap;
use std::fmt;
use std::sync::atomic::{AtomicU64, Ordering};

/// Maximum distance in voxels between the origin and any brick, so that 32 bits hold all steps.
const FARTHEST: i32 = 1 << 29;

/// Maximum number of entries of the table: 64 MB.
const MOST_PLACES: u64 = 1 << 24;

static IDS: AtomicU64 = AtomicU64::new(0);

/// A grid of non-negative numbers.
pub struct Voxels {
    /// First voxel of the first brick, and number of bricks along each axis. Those at the sides are empty.
    first: IVec3,
    bricks: IVec3,
    /// Index of the brick at each place, z fastest.
    table: Vec<u32>,
    rows: BrickRows,
    /// Corners of the region that is not 0, in integer places.
    low: IVec3,
    high: IVec3,
    most: f32,
    /// Unique number of the grid within the process.
    id: u64,
}

/// Indices of a brick and of the seven next to it in which its cells have corners: ahead along x by bit 0 of
/// the index, y by bit 1, z by bit 2.
pub(super) type Neighbours = [u32; 8];

/// Values at the corners of a cell, x fastest, and the starts of the first four corners' rows along z.
pub(super) struct Corners {
    pub(super) values: [f32; 8],
    rows: [usize; 4],
}

/// Prints the id alone: its numbers never change.
impl fmt::Debug for Voxels {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Voxels({})", self.id)
    }
}

/// Reason why a grid cannot be built.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum VoxelsError {
    /// It is empty.
    #[error("no voxel is above 0")]
    Empty,
    /// It lies too far from the origin.
    #[error("it has voxels beyond number {FARTHEST} along an axis")]
    TooFar,
    /// It is too large.
    #[error("its voxels reach over {0} bricks of 8 x 8 x 8, more than {MOST_PLACES}")]
    TooWide(u64),
}

/// Bricks as they are added, by their first voxel; a later one at the same place replaces the earlier.
#[derive(Debug, Default)]
pub struct VoxelsBuilder {
    rows: BrickRows,
    /// Index of each brick.
    bricks: HashMap<IVec3, u32>,
    /// Indices of uniform bricks, by their value's bits.
    even: HashMap<u32, u32>,
}

impl VoxelsBuilder {
    /// Builder with room for so many bricks, so that they are never copied.
    pub fn of_up_to(bricks: usize) -> Self {
        Self { rows: BrickRows::of_up_to(bricks), ..Self::default() }
    }

    /// Adds a brick, z fastest. `first` is a multiple of 8; negative values count as 0.
    pub fn add(&mut self, first: IVec3, values: impl IntoIterator<Item = f32>) {
        self.bricks.insert(first >> LOG_EDGE, self.rows.add(values));
    }

    /// Adds a uniform cube of `edge` voxels, a multiple of 8: its bricks share their values.
    ///
    /// # Errors
    /// If it is too large.
    pub fn add_even(&mut self, first: IVec3, edge: i32, value: f32) -> Result<(), VoxelsError> {
        let along = i64::from(edge >> LOG_EDGE);
        let count = along.pow(3) as u64 + self.bricks.len() as u64;
        if count > MOST_PLACES {
            return Err(VoxelsError::TooWide(count));
        }
        let rows = &mut self.rows;
        let number = *self.even.entry(value.to_bits()).or_insert_with(|| rows.add([value; BRICK]));
        let along = along as i32;
        for place in 0..along.pow(3) {
            let offset = IVec3::new(place / (along * along), place / along % along, place % along);
            self.bricks.insert((first >> LOG_EDGE) + offset, number);
        }
        Ok(())
    }

    /// Builds the grid.
    ///
    /// # Errors
    /// If it is empty or too large.
    pub fn built(self) -> Result<Voxels, VoxelsError> {
        let full = || self.bricks.iter().filter(|(_, number)| **number != NOTHING);
        // A cell has corners in the brick in which it begins and in those ahead.
        let low = full().map(|(at, _)| *at).reduce(IVec3::min).ok_or(VoxelsError::Empty)? - 1;
        let high = full().map(|(at, _)| *at).reduce(IVec3::max).ok_or(VoxelsError::Empty)? + 1;
        if low.min(-high).min_element() < -FARTHEST >> LOG_EDGE {
            return Err(VoxelsError::TooFar);
        }
        let bricks = high - low + 1;
        let places = bricks.to_array().into_iter().map(|count| count as u64).product::<u64>();
        if places > MOST_PLACES {
            return Err(VoxelsError::TooWide(places));
        }
        let mut voxels = Voxels {
            first: low << LOG_EDGE,
            bricks,
            table: vec![NOTHING; places as usize],
            most: self.rows.most(),
            rows: BrickRows::default(),
            low: IVec3::MAX,
            high: IVec3::MIN,
            id: IDS.fetch_add(1, Ordering::Relaxed),
        };
        for (&at, &number) in full() {
            let place = voxels.place(at - low).expect("it is within");
            voxels.table[place] = number;
            voxels.bound(at << LOG_EDGE, || self.rows.brick(number));
        }
        Ok(Voxels { rows: self.rows, ..voxels })
    }
}

impl Voxels {
    fn bound(&mut self, first: IVec3, values: impl Fn() -> [f32; BRICK]) {
        if first.cmpge(self.low).all() && (first + (EDGE - 1)).cmple(self.high).all() {
            return;
        }
        let values = values();
        for place in (0..BRICK).filter(|place| values[*place] > 0.0) {
            let along = [place / 64, place / 8 % 8, place % 8].map(|index| index as i32);
            let voxel = first + IVec3::from(along);
            (self.low, self.high) = (self.low.min(voxel), self.high.max(voxel));
        }
    }

    /// Corners of the box outside of which all values are 0.
    pub fn bounds(&self) -> (DVec3, DVec3) {
        ((self.low - 1).as_dvec3(), (self.high + 1).as_dvec3())
    }

    /// Memory, in bytes.
    pub fn memory(&self) -> usize {
        self.rows.memory() + size_of_val(&*self.table)
    }

    /// Maximum of all numbers.
    pub fn most(&self) -> f64 {
        f64::from(self.most)
    }

    /// Calls `each` for every brick that is not empty, with its first voxel.
    pub fn for_each_brick(&self, mut each: impl FnMut(IVec3, &[f32])) {
        for (place, &number) in self.table.iter().enumerate().filter(|(_, number)| **number != NOTHING) {
            let (place, [_, rows, row]) = (place as i32, self.bricks.to_array());
            let brick = IVec3::new(place / (rows * row), place / row % rows, place % row);
            each(self.first + (brick << LOG_EDGE), &self.rows.brick(number));
        }
    }

    /// Index in the table of a brick, by its steps from the first.
    fn place(&self, brick: IVec3) -> Option<usize> {
        let is_in = brick.cmpge(IVec3::ZERO).all() && brick.cmplt(self.bricks).all();
        is_in.then(|| ((brick.x * self.bricks.y + brick.y) * self.bricks.z + brick.z) as usize)
    }

    /// Indices of the bricks around the cells that begin in one; `None` if they are empty.
    #[inline]
    pub(super) fn bricks_about(&self, cell: IVec3) -> Option<Neighbours> {
        let start = self.place((cell - self.first) >> LOG_EDGE)?;
        let [_, rows, row] = self.bricks.to_array().map(|count| count as usize);
        // Beyond the last bricks along an axis there is nothing.
        let number = |corner: usize| {
            let ahead = (corner & 1) * rows * row + (corner >> 1 & 1) * row + (corner >> 2);
            self.table.get(start + ahead).copied().unwrap_or(NOTHING)
        };
        let bricks = std::array::from_fn(number);
        (bricks != [NOTHING; 8]).then_some(bricks)
    }

    /// Corners of the block of cells that begin in the brick of one of them.
    pub(super) fn block_of(&self, cell: IVec3) -> (IVec3, IVec3) {
        let low = self.first + (((cell - self.first) >> LOG_EDGE) << LOG_EDGE);
        (low, low + EDGE)
    }

    /// Whether a cell, reached by a step along an axis, begins in the same brick as the one before.
    pub(super) fn is_in_the_brick_before(&self, cell: IVec3, axis: usize, step: i32) -> bool {
        let local = (cell[axis] - self.first[axis]) & (EDGE - 1);
        local != if step > 0 { 0 } else { EDGE - 1 }
    }

    /// Values at the corners of a cell that begins in a brick.
    #[inline]
    pub(super) fn corners(&self, bricks: &Neighbours, cell: IVec3) -> Corners {
        let mut corners = Corners { values: [0.0; 8], rows: [0; 4] };
        let local = self.local(cell);
        (0..4).for_each(|column| self.put_column(bricks, &mut corners, local, column));
        corners
    }

    /// Updates the corners of a cell to those of the next along an axis, in the same brick: half of them
    /// stay.
    #[inline]
    pub(super) fn step_corners(
        &self,
        bricks: &Neighbours,
        corners: &mut Corners,
        cell: IVec3,
        (axis, is_ahead): (usize, bool),
    ) {
        let local = self.local(cell);
        if axis == 2 {
            let z = local[2] + usize::from(is_ahead);
            for column in 0..4 {
                let new = self.value(bricks, corners.rows[column], (local, column), z);
                let (near, far) = (corners.values[column], corners.values[column + 4]);
                (corners.values[column], corners.values[column + 4]) =
                    if is_ahead { (far, new) } else { (new, near) };
            }
            return;
        }
        for other in 0..2 {
            let (near, far) = (other << (1 - axis), other << (1 - axis) | 1 << axis);
            let (kept, new) = if is_ahead { (near, far) } else { (far, near) };
            corners.rows[kept] = corners.rows[new];
            corners.values[kept] = corners.values[new];
            corners.values[kept + 4] = corners.values[new + 4];
            self.put_column(bricks, corners, local, new);
        }
    }

    /// Indices of a cell in its brick.
    #[inline]
    fn local(&self, cell: IVec3) -> [usize; 3] {
        ((cell - self.first) & (EDGE - 1)).to_array().map(|along| along as usize)
    }

    /// Looks up the two corners of a cell on a row along z: ahead along x by bit 0 of `column`, y by bit 1.
    #[inline]
    fn put_column(&self, bricks: &Neighbours, corners: &mut Corners, local: [usize; 3], column: usize) {
        let row = self.row(bricks, (local, column), 0);
        let value = |z| self.value(bricks, row, (local, column), z);
        (corners.rows[column], corners.values[column]) = (row, value(local[2]));
        corners.values[column + 4] = value(local[2] + 1);
    }

    /// Value on a column of a cell; `row` is the start of the column's row.
    #[inline]
    fn value(&self, bricks: &Neighbours, row: usize, column: ([usize; 3], usize), z: usize) -> f32 {
        let is_ahead = z >> LOG_EDGE == 1;
        self.rows.value(if is_ahead { self.row(bricks, column, 1) } else { row + z })
    }

    /// Start of a row, in the brick `ahead` along z.
    #[inline]
    fn row(&self, bricks: &Neighbours, (local, column): ([usize; 3], usize), ahead: usize) -> usize {
        let (x, y) = (local[0] + (column & 1), local[1] + (column >> 1));
        let brick = bricks[(x >> LOG_EDGE | y >> LOG_EDGE << 1 | ahead << 2) & 7];
        self.rows.row(brick, (x & 7) << LOG_EDGE | y & 7)
    }

    /// Value at a place.
    pub fn at(&self, place: DVec3) -> f64 {
        // Range in which places convert to integers.
        if place.is_nan() || place.abs().max_element() >= 1e9 {
            return 0.0;
        }
        let cell = place.floor().as_ivec3();
        let value = |bricks| trilinear(&self.corners(&bricks, cell).values, place - cell.as_dvec3());
        self.bricks_about(cell).map_or(0.0, value)
    }
}

/// Interpolates between a cell's corners; `share` is the position along each axis.
fn trilinear(corners: &[f32; 8], share: DVec3) -> f64 {
    let along = |from: f32, to: f32| f64::from(from) + share.x * (f64::from(to) - f64::from(from));
    let [a, b] = [0, 4].map(|z| {
        let (low, high) = (along(corners[z], corners[z + 1]), along(corners[z + 2], corners[z + 3]));
        low + share.y * (high - low)
    });
    a + share.z * (b - a)
}
