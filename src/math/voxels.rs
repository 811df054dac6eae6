//! Numbers at the whole places of a grid, trilinear between them, nothing beyond. In go bricks of 8 x 8 x 8,
//! out come values. Invariant: what holds nothing takes no memory but its place in a table.

use glam::{DVec3, IVec3};
use std::collections::HashMap;
use std::fmt;
use std::sync::atomic::{AtomicU64, Ordering};

/// Voxels along an edge of a brick, as a power of two.
const LOG_EDGE: i32 = 3;
pub(super) const EDGE: i32 = 1 << LOG_EDGE;
/// Voxels of a brick, z fastest.
pub const BRICK: usize = 512;
/// Strides from a voxel to the next within a brick, along each axis.
const STEPS: [usize; 3] = [64, 8, 1];
/// The two other axes.
const OTHERS: [[usize; 2]; 3] = [[1, 2], [0, 2], [0, 1]];
/// Places in the table at most: 64 MB.
const MOST_PLACES: u64 = 1 << 24;
const NOTHING: u32 = u32::MAX;

static IDS: AtomicU64 = AtomicU64::new(0);

/// A grid of numbers, none of them negative.
pub struct Voxels {
    /// The first voxel of the first brick that cells begin in, and such bricks along each axis.
    first: IVec3,
    bricks: IVec3,
    /// Number by place of a brick, z fastest, among those in which a cell begins that holds something.
    table: Vec<u32>,
    /// Neighbours by that number.
    neighbours: Vec<Neighbours>,
    values: Vec<f32>,
    /// Corners of what is not nothing, in whole places.
    low: IVec3,
    high: IVec3,
    most: f32,
    /// No two grids of a process have the same.
    id: u64,
}

/// Starts of the values of a brick and of the seven next to it that its cells have corners in: ahead along
/// x by bit 0 of the index, y by bit 1, z by bit 2.
pub(super) type Neighbours = [u32; 8];

/// Id alone: its numbers never change.
impl fmt::Debug for Voxels {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Voxels({})", self.id)
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
    /// Number of each brick's values.
    bricks: HashMap<IVec3, u32>,
    /// Numbers of bricks that are the same all over, by their value's bits.
    even: HashMap<u32, u32>,
}

impl VoxelsBuilder {
    /// Builder with room for so many bricks: while there is, they are never held twice.
    pub fn of_up_to(bricks: usize) -> Self {
        // One more, of nothing.
        Self { values: Vec::with_capacity((bricks + 1) * BRICK), ..Self::default() }
    }

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
        // A cell has corners in the brick that it begins in and in those ahead.
        let low = full.keys().copied().reduce(IVec3::min).ok_or(VoxelsError::Empty)? - 1;
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
            neighbours: Vec::new(),
            most: self.values.iter().copied().fold(0.0, f32::max),
            values: self.values,
            low: IVec3::MAX,
            high: IVec3::MIN,
            id: IDS.fetch_add(1, Ordering::Relaxed),
        };
        let nothing = voxels.values.len() as u32;
        voxels.values.resize(voxels.values.len() + BRICK, 0.0);
        for (&at, &number) in &full {
            let start = number * BRICK as u32;
            voxels.bound(at << LOG_EDGE, start);
            for corner in 0..8 {
                let before = at - low - offset(corner);
                let place = voxels.place(before).expect("it is within");
                if voxels.table[place] == NOTHING {
                    voxels.table[place] = voxels.neighbours.len() as u32;
                    voxels.neighbours.push([nothing; 8]);
                }
                voxels.neighbours[voxels.table[place] as usize][corner] = start;
            }
        }
        Ok(voxels)
    }
}

/// Offset of a corner of a cell from its first, or of a brick's neighbour.
fn offset(corner: usize) -> IVec3 {
    IVec3::new(corner as i32 & 1, corner as i32 >> 1 & 1, corner as i32 >> 2)
}

impl Voxels {
    fn bound(&mut self, first: IVec3, start: u32) {
        let values = &self.values[start as usize..][..BRICK];
        for place in (0..BRICK).filter(|place| values[*place] > 0.0) {
            let along = [place / 64, place / 8 % 8, place % 8].map(|index| index as i32);
            let voxel = first + IVec3::from(along);
            (self.low, self.high) = (self.low.min(voxel), self.high.max(voxel));
        }
    }

    /// Corners of the box outside of which it is nothing.
    pub fn bounds(&self) -> (DVec3, DVec3) {
        ((self.low - 1).as_dvec3(), (self.high + 1).as_dvec3())
    }

    /// Memory, in bytes.
    pub fn memory(&self) -> usize {
        size_of_val(&*self.values) + size_of_val(&*self.neighbours) + size_of_val(&*self.table)
    }

    /// Largest number.
    pub fn most(&self) -> f64 {
        f64::from(self.most)
    }

    /// Calls `each` for every brick that holds something, with its first voxel.
    pub fn for_each_brick(&self, mut each: impl FnMut(IVec3, &[f32])) {
        let nothing = (self.values.len() - BRICK) as u32;
        for (place, &number) in self.table.iter().enumerate().filter(|(_, number)| **number != NOTHING) {
            let start = self.neighbours[number as usize][0];
            let (place, [_, rows, row]) = (place as i32, self.bricks.to_array());
            let brick = IVec3::new(place / (rows * row), place / row % rows, place % row);
            if start != nothing {
                each(self.first + (brick << LOG_EDGE), &self.values[start as usize..][..BRICK]);
            }
        }
    }

    /// Index of a brick by its steps from the first.
    fn place(&self, brick: IVec3) -> Option<usize> {
        let is_in = brick.cmpge(IVec3::ZERO).all() && brick.cmplt(self.bricks).all();
        is_in.then(|| ((brick.x * self.bricks.y + brick.y) * self.bricks.z + brick.z) as usize)
    }

    /// The brick in which a cell begins; `None` if its cells hold nothing.
    #[inline]
    pub(super) fn brick_of(&self, cell: IVec3) -> Option<&Neighbours> {
        let number = self.table[self.place((cell - self.first) >> LOG_EDGE)?];
        (number != NOTHING).then(|| &self.neighbours[number as usize])
    }

    /// Corners of the block of cells that begin in the brick of one of them.
    pub(super) fn block_of(&self, cell: IVec3) -> (IVec3, IVec3) {
        let low = self.first + (((cell - self.first) >> LOG_EDGE) << LOG_EDGE);
        (low, low + EDGE)
    }

    /// Whether a cell that was reached by a step along an axis begins in the same brick as the one before.
    pub(super) fn is_in_the_brick_before(&self, cell: IVec3, axis: usize, step: i32) -> bool {
        let local = (cell[axis] - self.first[axis]) & (EDGE - 1);
        local != if step > 0 { 0 } else { EDGE - 1 }
    }

    /// Values at the corners of a cell that begins in a brick: x fastest.
    #[inline]
    pub(super) fn corners(&self, brick: &Neighbours, cell: IVec3) -> [f32; 8] {
        let [x, y, z] = self.steps(cell);
        std::array::from_fn(|corner| self.value(brick, [x[corner & 1], y[corner >> 1 & 1], z[corner >> 2]]))
    }

    /// Makes of the corners of a cell those of the next along an axis, in the same brick: half of them stay.
    #[inline]
    pub(super) fn step_corners(
        &self,
        brick: &Neighbours,
        corners: &mut [f32; 8],
        cell: IVec3,
        (axis, is_ahead): (usize, bool),
    ) {
        /// Corners of the side with the lower coordinate.
        const LOW: [[usize; 4]; 3] = [[0, 2, 4, 6], [0, 1, 4, 5], [0, 1, 2, 3]];
        let new = self.side(brick, cell, axis, is_ahead);
        for (near, new) in LOW[axis].into_iter().zip(new) {
            let far = near | 1 << axis;
            (corners[near], corners[far]) = if is_ahead { (corners[far], new) } else { (new, corners[near]) };
        }
    }

    /// The corners of a cell on its side ahead along an axis, or on the other.
    #[inline]
    fn side(&self, brick: &Neighbours, cell: IVec3, axis: usize, is_ahead: bool) -> [f32; 4] {
        let steps = self.steps(cell);
        let along = steps[axis][usize::from(is_ahead)];
        let across = OTHERS[axis];
        let is_in_one_brick = across.iter().all(|other| steps[*other][1].0 == 0);
        if is_in_one_brick {
            let start = brick[along.0 & 7] as usize + along.1;
            let start = start + steps[across[0]][0].1 + steps[across[1]][0].1;
            let [first, second] = across.map(|other| STEPS[other]);
            let values = &self.values[start..=start + first + second];
            return [values[0], values[first], values[second], values[first + second]];
        }
        std::array::from_fn(|corner| {
            let mut of_corner = [steps[0][0], steps[1][0], steps[2][0]];
            of_corner[axis] = along;
            of_corner[across[0]] = steps[across[0]][corner & 1];
            of_corner[across[1]] = steps[across[1]][corner >> 1];
            self.value(brick, of_corner)
        })
    }

    /// Bit of the neighbour that each corner of a cell is in along each axis, and steps within it.
    #[inline]
    fn steps(&self, cell: IVec3) -> [[(usize, usize); 2]; 3] {
        let local = (cell - self.first) & (EDGE - 1);
        let along = |axis: usize, ahead: i32| {
            let local = (local.to_array()[axis] + ahead) as usize;
            ((local >> LOG_EDGE) << axis, (local & (EDGE as usize - 1)) * STEPS[axis])
        };
        [0, 1, 2].map(|axis| [along(axis, 0), along(axis, 1)])
    }

    #[inline]
    fn value(&self, brick: &Neighbours, [x, y, z]: [(usize, usize); 3]) -> f32 {
        let start = brick[(x.0 | y.0 | z.0) & 7];
        self.values[start as usize + x.1 + y.1 + z.1]
    }

    /// Value at a place.
    pub fn at(&self, place: DVec3) -> f64 {
        // As far out as whole numbers go.
        if place.is_nan() || place.abs().max_element() >= 1e9 {
            return 0.0;
        }
        let cell = place.floor().as_ivec3();
        let values = |brick| trilinear(&self.corners(brick, cell), place - cell.as_dvec3());
        self.brick_of(cell).map_or(0.0, values)
    }
}

/// Between a cell's corners; `share` of the way along each axis.
fn trilinear(corners: &[f32; 8], share: DVec3) -> f64 {
    let along = |from: f32, to: f32| f64::from(from) + share.x * (f64::from(to) - f64::from(from));
    let [a, b] = [0, 4].map(|z| {
        let (low, high) = (along(corners[z], corners[z + 1]), along(corners[z + 2], corners[z + 3]));
        low + share.y * (high - low)
    });
    a + share.z * (b - a)
}
