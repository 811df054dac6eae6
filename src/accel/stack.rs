//! Stack of a traversal. Invariant: it never overflows, and allocates only for trees of extreme depth.

/// Number of entries without allocation: seven for each of eighteen levels of eight-wide nodes.
const INLINE: usize = 128;

/// A child to visit.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Entry {
    /// Child, as in [`super::wide_tree`].
    pub(super) child: u32,
    /// Distance at which the ray enters it.
    pub(super) t_near: f32,
}

/// A stack of children, nearest on top.
pub(super) struct Stack {
    inline: [Entry; INLINE],
    len: usize,
    spill: Vec<Entry>,
}

impl Stack {
    #[inline(always)]
    pub(super) fn new() -> Self {
        Self { inline: [Entry::default(); INLINE], len: 0, spill: Vec::new() }
    }

    #[inline(always)]
    pub(super) fn len(&self) -> usize {
        self.len + self.spill.len()
    }

    #[inline(always)]
    pub(super) fn push(&mut self, entry: Entry) {
        match self.inline.get_mut(self.len) {
            Some(slot) => {
                *slot = entry;
                self.len += 1;
            }
            None => self.spill.push(entry),
        }
    }

    /// Removes and returns the last entry, unless only `base` entries are left.
    #[inline(always)]
    pub(super) fn pop(&mut self, base: usize) -> Option<Entry> {
        if self.len() <= base {
            return None;
        }
        if let Some(entry) = self.spill.pop() {
            return Some(entry);
        }
        self.len -= 1;
        self.inline.get(self.len).copied()
    }

    /// Removes all but `base` entries.
    #[inline(always)]
    pub(super) fn truncate(&mut self, base: usize) {
        self.spill.truncate(base.saturating_sub(INLINE));
        self.len = self.len.min(base);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keeps_order_beyond_its_inline_part() {
        let mut stack = Stack::new();
        for child in 0..1000 {
            stack.push(Entry { child, t_near: 0.0 });
        }
        for child in (500..1000).rev() {
            assert_eq!(stack.pop(0).map(|entry| entry.child), Some(child));
        }
        stack.truncate(10);
        assert_eq!(stack.pop(9).map(|entry| entry.child), Some(9));
        assert!(stack.pop(9).is_none());
    }
}
