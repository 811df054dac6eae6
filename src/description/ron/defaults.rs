//! Defaults of fields other than their type's own. Invariant: each lies in its field's range.

/// 1, for each component.
pub(super) fn one<T: From<f64>>() -> T {
    T::from(1.0)
}

/// Default of switches that are on.
pub(super) fn yes() -> bool {
    true
}
