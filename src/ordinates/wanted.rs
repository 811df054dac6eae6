//! Outputs of a sweep. In go the needs of the iteration and of the last scattering, out comes the list of
//! moments and radiances to compute. Invariant: a sweep computes nothing that is not in this list.

use super::grid::Corners;

/// Moments and radiances that a sweep is to find.
#[derive(Clone, Copy)]
pub(crate) struct Wanted<'a> {
    /// Harmonics up to l = 2, with which orders of scattering go on.
    pub(crate) moments: bool,
    /// Degrees for the last scattering, the one that is seen: 4, and where things shine
    /// degree 3.
    pub(crate) last: bool,
    pub(crate) third: bool,
    /// And degrees 5 and 6, where fog scatters ahead.
    pub(crate) high: bool,
    /// Nodes about each place next to a grid within this one, which needs light ordinate by ordinate.
    pub(crate) radiances: Option<&'a [Corners]>,
}

impl<'a> Wanted<'a> {
    /// Moments of the next order alone.
    pub(crate) const ORDERS: Self =
        Self { moments: true, last: false, third: false, high: false, radiances: None };
}
