//! What fields hold that a file leaves out. In goes a number, out comes a value of the field's type that is
//! that number throughout. Invariant: the number lies in the field's range.

use super::keyed::{Keyable, Keyed};
use super::number::{Number, Span, Three};
use super::range::Range;
use glam::DVec3;

/// What a single number can stand for.
pub(super) trait Uniform {
    /// The value that is `number` throughout.
    fn uniform(number: f64) -> Self;
}

impl<R: Range> Uniform for Number<R> {
    fn uniform(number: f64) -> Self {
        debug_assert!(R::contains(number));
        Self::new(number)
    }
}

impl<R: Range, const ONE_WILL_DO: bool> Uniform for Three<R, ONE_WILL_DO> {
    fn uniform(number: f64) -> Self {
        debug_assert!(R::contains(number));
        Self::new(DVec3::splat(number))
    }
}

impl<R: Range> Uniform for Span<R> {
    fn uniform(number: f64) -> Self {
        debug_assert!(R::contains(number));
        Self::new(number, number)
    }
}

impl<T: Keyable + Uniform> Uniform for Keyed<T> {
    fn uniform(number: f64) -> Self {
        Self::Plain(T::uniform(number))
    }
}

pub(super) fn zero<T: Uniform>() -> T {
    T::uniform(0.0)
}

pub(super) fn one<T: Uniform>() -> T {
    T::uniform(1.0)
}

/// What is or is not, and by default is.
pub(super) fn yes() -> bool {
    true
}

/// The same, keyed.
pub(super) fn seen() -> Keyed<bool> {
    Keyed::Plain(true)
}
