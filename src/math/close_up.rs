//! Spans of numbers without gaps. In go numbers and where spans of them begin, out come the same spans, one
//! behind the other. Invariant: threads that write spans into rows of zeros leave no page half full.

/// Moves spans together, in their order, each with its first index and its count; gives the rest back.
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
