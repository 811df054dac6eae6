//! Defaults of fields other than their type's own. In goes nothing, out come values. Invariant: each lies in
//! its field's range.

/// 1 throughout.
pub(super) fn one<T: From<f64>>() -> T {
    T::from(1.0)
}

/// Default of switches that are on.
pub(super) fn yes() -> bool {
    true
}
