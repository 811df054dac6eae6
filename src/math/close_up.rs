//! Compaction of a list. In go numbers and the first index of each span to keep, out come the spans without
//! gaps between them. Invariant: order and values of the spans stay.

/// Moves spans together, each given by its first index and its count; frees the remaining memory.
pub fn close_up<'a>(numbers: &mut Vec<u16>, spans: impl Iterator<Item = (&'a mut u32, usize)>) {
    let mut end = 0;
    for (first, count) in spans {
        let start = *first as usize;
        numbers.copy_within(start..start + count, end);
        *first = end as u32;
        end += count;
    }
    numbers.truncate(end);
    numbers.shrink_to_fit();
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spans_stay_as_they_are() {
        let (mut numbers, mut firsts) = (vec![0, 1, 2, 0, 3, 4, 5, 0], [1, 4, 6]);
        close_up(&mut numbers, firsts.iter_mut().zip([2, 1, 1]));
        assert_eq!((numbers, firsts), (vec![1, 2, 3, 5], [0, 2, 3]));
    }
}
