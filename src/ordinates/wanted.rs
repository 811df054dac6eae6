//! Outputs of a sweep. In go the needs of the iteration and of the last scattering, out comes the list of
//! moments and radiances to compute. Invariant: a sweep computes nothing that is not in this list.

use super::grid::Corners;

/// Moments and radiances that a sweep computes.
#[derive(Clone, Copy)]
pub(crate) struct Wanted<'a> {
    /// Harmonics up to l = 2, for the next order of scattering.
    pub(crate) moments: bool,
    /// Degrees for the last scattering: 4, and `third`, degree 3, for glossy surfaces and fog that scatters
    /// forward.
    pub(crate) last: bool,
    pub(crate) third: bool,
    /// Degrees 5 and 6, for fog that scatters forward.
    pub(crate) high: bool,
    /// Corners of each place next to a grid within this one, which needs radiance by ordinate.
    pub(crate) radiances: Option<&'a [Corners]>,
}

impl<'a> Wanted<'a> {
    /// Moments for the next order alone.
    pub(crate) const ORDERS: Self =
        Self { moments: true, last: false, third: false, high: false, radiances: None };
}
