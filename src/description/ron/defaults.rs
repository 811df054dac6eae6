//! Defaults of fields that a file leaves out, where they are not their type's own. Invariant: the value
//! lies in the field's range.

/// 1 throughout.
pub(super) fn one<T: From<f64>>() -> T {
    T::from(1.0)
}

/// Default of switches that are on.
pub(super) fn yes() -> bool {
    true
}
