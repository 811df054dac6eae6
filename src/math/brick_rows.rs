//! Bricks of 8 x 8 x 8 numbers, stored by rows along z. In go bricks, out come numbers. Invariant: all empty
//! rows of a brick share one row.

/// Length of a brick's edge, as a power of two.
pub(super) const LOG_EDGE: i32 = 3;
pub(super) const EDGE: i32 = 1 << LOG_EDGE;
/// Count of numbers of a brick; z is fastest.
pub const BRICK: usize = 512;
/// Index of the empty brick.
pub(super) const NOTHING: u32 = 0;
/// Count of numbers of a row, and of rows of a brick.
const ROW: usize = EDGE as usize;
const ROWS: usize = BRICK / ROW;

/// Bricks, by index.
#[derive(Debug)]
pub(super) struct BrickRows {
    bricks: Vec<Brick>,
    values: Vec<f32>,
}

/// Location of a brick's rows.
#[derive(Debug)]
struct Brick {
    /// Index among all rows of its first, which is empty if any of its rows is.
    first: u32,
    /// Offset from there of each row, by x and y, y fastest.
    rows: [u8; ROWS],
}

/// One empty brick.
impl Default for BrickRows {
    fn default() -> Self {
        Self { bricks: vec![Brick { first: 0, rows: [0; ROWS] }], values: vec![0.0; ROW] }
    }
}

impl BrickRows {
    /// Empty, with room for so many bricks.
    pub(super) fn of_up_to(bricks: usize) -> Self {
        let mut rows = Self::default();
        rows.values.reserve_exact(bricks * BRICK);
        rows
    }

    /// Stores a brick of these values, negative ones as 0; returns its index.
    pub(super) fn add(&mut self, values: impl IntoIterator<Item = f32>) -> u32 {
        let mut all = [0.0; BRICK];
        for (stored, value) in all.iter_mut().zip(values) {
            *stored = value.max(0.0);
        }
        let is_full = |row: &[f32]| row.iter().any(|value| *value > 0.0);
        let full = all.chunks_exact(ROW).filter(|row| is_full(row)).count();
        if full == 0 {
            return NOTHING;
        }
        let (start, mut rows) = (self.values.len(), [0; ROWS]);
        // Empty rows share the first.
        self.values.resize(start + if full < ROWS { ROW } else { 0 }, 0.0);
        for (place, row) in rows.iter_mut().zip(all.chunks_exact(ROW)).filter(|(_, row)| is_full(row)) {
            *place = ((self.values.len() - start) / ROW) as u8;
            self.values.extend_from_slice(row);
        }
        self.bricks.push(Brick { first: (start / ROW) as u32, rows });
        self.bricks.len() as u32 - 1
    }

    /// Index among all numbers of a brick's row, by `x << 3 | y`.
    #[inline]
    pub(super) fn row(&self, brick: u32, along: usize) -> usize {
        let Brick { first, rows } = &self.bricks[brick as usize];
        ROW * (*first as usize + usize::from(rows[along & (ROWS - 1)]))
    }

    /// The number at an index among all.
    #[inline]
    pub(super) fn value(&self, place: usize) -> f32 {
        self.values[place]
    }

    pub(super) fn brick(&self, brick: u32) -> [f32; BRICK] {
        let mut values = [0.0; BRICK];
        for (along, values) in values.chunks_exact_mut(ROW).enumerate() {
            values.copy_from_slice(&self.values[self.row(brick, along)..][..ROW]);
        }
        values
    }

    /// Maximum of all numbers.
    pub(super) fn most(&self) -> f32 {
        self.values.iter().copied().fold(0.0, f32::max)
    }

    pub(super) fn memory(&self) -> usize {
        size_of_val(&*self.values) + size_of_val(&*self.bricks)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Bricks are returned as they were added, and rows that are not empty are stored whole.
    #[test]
    fn rows_of_nothing_take_no_memory() {
        let mut rows = BrickRows::default();
        let one = |at: usize| move |place: usize| if place == at { 2.0 } else { -1.0 };
        assert_eq!(rows.add((0..BRICK).map(|_| -1.0)), NOTHING);
        let before = rows.memory();
        let first = rows.add((0..BRICK).map(one(77)));
        assert_eq!(rows.memory() - before, 2 * ROW * 4 + size_of::<Brick>());
        let before = rows.memory();
        let full = rows.add((0..BRICK).map(|place| place as f32 + 1.0));
        assert_eq!(rows.memory() - before, BRICK * 4 + size_of::<Brick>());
        let short = rows.add([0.0, 3.0]);
        for place in 0..BRICK {
            assert_eq!(rows.brick(first)[place], one(77)(place).max(0.0));
            assert_eq!(rows.brick(full)[place], place as f32 + 1.0);
            assert_eq!(rows.brick(short)[place], if place == 1 { 3.0 } else { 0.0 });
            assert_eq!(rows.brick(NOTHING)[place], 0.0);
        }
        assert_eq!(rows.most(), BRICK as f32);
    }
}
