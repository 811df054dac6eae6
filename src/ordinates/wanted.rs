//! What a sweep is to find. In go the needs of orders and of what is seen, out come choices. Invariant: what
//! nobody asks for is not found.

use super::grid::Corners;

/// What is to be known of light.
#[derive(Clone, Copy)]
pub(crate) struct Wanted<'a> {
    /// Harmonics up to l = 2, with which orders of scattering go on.
    pub(crate) moments: bool,
    /// What the last scattering, the one that is seen, needs beyond that: degree 4, and where things shine
    /// degree 3.
    pub(crate) last: bool,
    pub(crate) third: bool,
    /// And degrees 5 and 6, where fog scatters ahead.
    pub(crate) high: bool,
    /// Nodes about each place next to a grid within this one, which needs light ordinate by ordinate.
    pub(crate) radiances: Option<&'a [Corners]>,
}

impl<'a> Wanted<'a> {
    /// What the next order is made of.
    pub(crate) const ORDERS: Self =
        Self { moments: true, last: false, third: false, high: false, radiances: None };
}
