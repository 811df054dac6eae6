//! A union of closed intervals. In go intervals, out come the union and its gaps. Invariant: sorted,
//! disjoint, none empty.

use std::cmp::Ordering;

/// The union of the intervals inserted so far.
#[derive(Clone, Debug, Default)]
pub struct IntervalSet {
    intervals: Vec<(f64, f64)>,
}

impl IntervalSet {
    /// Empties the set and keeps its memory.
    pub fn clear(&mut self) {
        self.intervals.clear();
    }

    /// The intervals, sorted and disjoint.
    pub fn as_slice(&self) -> &[(f64, f64)] {
        &self.intervals
    }

    /// Whether a number lies strictly inside one of the intervals.
    pub fn contains(&self, number: f64) -> bool {
        let after = self.intervals.partition_point(|interval| interval.1 <= number);
        self.intervals.get(after).is_some_and(|interval| interval.0 < number)
    }

    /// Adds `[start, end]`, merged with all intervals that it touches. Empty intervals (`start >= end`) add
    /// nothing.
    pub fn insert(&mut self, start: f64, end: f64) {
        self.insert_and_tell(start, end, |_, _| {});
    }

    /// Adds `[start, end]` and calls `gap(start, end)` for each part that no interval covered before, in
    /// order.
    pub fn insert_and_tell(&mut self, start: f64, end: f64, gap: impl FnMut(f64, f64)) {
        // Anything but Less: a NaN is ignored, too.
        if start.partial_cmp(&end) != Some(Ordering::Less) {
            return;
        }
        self.for_each_gap(start, end, gap);
        let first = self.intervals.partition_point(|interval| interval.1 < start);
        let touched = self.intervals[first..].iter().take_while(|interval| interval.0 <= end).count();
        if touched == 0 {
            return self.intervals.insert(first, (start, end));
        }
        let merged_end = self.intervals[first + touched - 1].1.max(end);
        self.intervals[first] = (self.intervals[first].0.min(start), merged_end);
        if touched > 1 {
            self.intervals.drain(first + 1..first + touched);
        }
    }

    /// Calls `gap(start, end)` for each part of `[start, end]` that no interval covers, in order.
    pub fn for_each_gap(&self, start: f64, end: f64, mut gap: impl FnMut(f64, f64)) {
        let mut cursor = start;
        let first = self.intervals.partition_point(|interval| interval.1 <= start);
        for &(covered_start, covered_end) in &self.intervals[first..] {
            if covered_start >= end {
                break;
            }
            if covered_start > cursor {
                gap(cursor, covered_start);
            }
            cursor = cursor.max(covered_end);
        }
        if cursor < end {
            gap(cursor, end);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// Compared with a bitmap of unit cells.
        #[test]
        fn equals_a_bitmap(inserted in prop::collection::vec((0_u8..60, 0_u8..60), 0..40)) {
            let mut set = IntervalSet::default();
            let mut covered = [false; 60];
            for (start, end) in inserted {
                let mut told = [false; 60];
                set.insert_and_tell(f64::from(start), f64::from(end), |start, end| {
                    told[start as usize..end as usize].fill(true);
                });
                for cell in 0..60_u8 {
                    let is_new = (start..end).contains(&cell) && !covered[usize::from(cell)];
                    prop_assert_eq!(told[usize::from(cell)], is_new);
                }
                for cell in start..end.max(start) {
                    covered[usize::from(cell)] = true;
                }
            }
            let intervals = set.as_slice();
            prop_assert!(intervals.iter().all(|interval| interval.0 < interval.1));
            prop_assert!(intervals.windows(2).all(|pair| pair[0].1 < pair[1].0));
            let mut open = [false; 60];
            set.for_each_gap(0.0, 60.0, |start, end| {
                open[start as usize..end as usize].fill(true);
            });
            for cell in 0..60 {
                prop_assert_eq!(covered[cell], !open[cell]);
            }
        }
    }

    #[test]
    fn nan_and_empty_add_nothing() {
        let mut set = IntervalSet::default();
        set.insert(f64::NAN, 1.0);
        set.insert(1.0, f64::NAN);
        set.insert(1.0, 1.0);
        set.insert(2.0, 1.0);
        assert!(set.as_slice().is_empty());
    }
}
