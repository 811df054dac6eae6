//! What fields hold that a file leaves out, where that is not their type's own default. Invariant: the value
//! lies in the field's range.

/// 1 throughout.
pub(super) fn one<T: From<f64>>() -> T {
    T::from(1.0)
}

/// What is or is not, and by default is.
pub(super) fn yes() -> bool {
    true
}
