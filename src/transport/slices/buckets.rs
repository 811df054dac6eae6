//! Bucket sort of segments by the part of the slice in which they begin. In go items with bucket numbers, out
//! come the items of each bucket. Invariant: sorting takes linear time and is stable.

#[derive(Debug)]
pub(super) struct Buckets<T> {
    items: Vec<T>,
    buckets: Vec<u32>,
    /// Indices of the items by bucket: items are large, and stay in place.
    sorted: Vec<u32>,
    ends: Vec<u32>,
}

impl<T> Default for Buckets<T> {
    fn default() -> Self {
        Self { items: Vec::new(), buckets: Vec::new(), sorted: Vec::new(), ends: Vec::new() }
    }
}

impl<T: Copy> Buckets<T> {
    /// Removes all items.
    pub(super) fn clear(&mut self) {
        self.items.clear();
        self.buckets.clear();
    }

    pub(super) fn push(&mut self, bucket: usize, item: T) {
        self.items.push(item);
        self.buckets.push(bucket as u32);
    }

    /// Sorts the items into `buckets` buckets.
    pub(super) fn sort(&mut self, buckets: usize) {
        let Self { buckets: of_items, sorted, ends, .. } = self;
        ends.clear();
        ends.resize(buckets, 0);
        for bucket in of_items.iter() {
            ends[*bucket as usize] += 1;
        }
        let mut start = 0;
        for end in ends.iter_mut() {
            let count = *end;
            *end = start;
            start += count;
        }
        sorted.resize(of_items.len(), 0);
        for (number, bucket) in (0..).zip(of_items.iter()) {
            let place = &mut ends[*bucket as usize];
            sorted[*place as usize] = number;
            *place += 1;
        }
    }

    /// Items of a bucket, once they are sorted.
    pub(super) fn bucket(&self, bucket: usize) -> impl Iterator<Item = T> {
        let start = if bucket == 0 { 0 } else { self.ends[bucket - 1] };
        let numbers = &self.sorted[start as usize..self.ends[bucket] as usize];
        numbers.iter().map(|number| self.items[*number as usize])
    }
}

/// Partition point, as [`slice::partition_point`] finds it, in few steps near a guess: a galloping search
/// (Bentley & Yao 1976).
pub(super) fn partition_point_near(values: &[f64], guess: usize, is_before: impl Fn(f64) -> bool) -> usize {
    let (mut low, mut high) = (0, values.len());
    let mut step = 1;
    if guess < high && is_before(values[guess]) {
        low = guess + 1;
        while low + step < high {
            if !is_before(values[low + step]) {
                high = low + step;
                break;
            }
            low += step + 1;
            step *= 2;
        }
    } else {
        high = high.min(guess);
        while step < high {
            if is_before(values[high - step]) {
                low = high - step + 1;
                break;
            }
            high -= step;
            step *= 2;
        }
    }
    low + values[low..high].partition_point(|value| is_before(*value))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn a_guess_does_not_matter(
            mut values in prop::collection::vec(-100_i32..100, 0..60),
            guess in 0_usize..70,
            limit in -101_i32..101,
        ) {
            values.sort_unstable_by(|a, b| b.cmp(a));
            let values: Vec<f64> = values.into_iter().map(f64::from).collect();
            let is_before = |value: f64| value > f64::from(limit);
            let expected = values.partition_point(|value| is_before(*value));
            prop_assert_eq!(partition_point_near(&values, guess.min(values.len()), is_before), expected);
        }
    }
}
