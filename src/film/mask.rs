//! Which pixels of a picture want samples. Invariant: pixels outside the window never do.

use crate::scene::Window;

/// A set of pixels of the full picture.
#[derive(Clone, Debug)]
pub struct Mask {
    window: Window,
    wanted: Vec<bool>,
}

impl Mask {
    /// All pixels of a window.
    pub fn all(window: Window) -> Self {
        Self::from_fn(window, |_, _| true)
    }

    /// The pixels `(x, y)` of a window of which `wanted` says so.
    pub fn from_fn(window: Window, mut wanted: impl FnMut(usize, usize) -> bool) -> Self {
        Self { window, wanted: window.pixels().map(|(x, y)| wanted(x, y)).collect() }
    }

    /// The rectangle that they lie in.
    pub fn window(&self) -> Window {
        self.window
    }

    /// Whether a pixel of the full picture is one of them.
    pub fn contains(&self, x: usize, y: usize) -> bool {
        self.window.index(x, y).is_some_and(|index| self.wanted[index])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn holds_what_was_wanted_and_nothing_outside() {
        let window = Window { x: 2, y: 3, width: 4, height: 2 };
        let mask = Mask::from_fn(window, |x, _| x % 2 == 0);
        assert!(mask.contains(2, 3) && mask.contains(4, 4));
        assert!(!mask.contains(3, 3) && !mask.contains(0, 3) && !mask.contains(6, 3) && !mask.contains(2, 5));
        assert!(Mask::all(window).contains(5, 4) && !Mask::all(window).contains(6, 4));
    }
}
