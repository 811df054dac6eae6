//! Fog as ordinates see it. In goes a medium, out come what dims light and what is scattered. Invariant: what
//! is not scattered is not lost either.
//!
//! Harmonics up to l = 2 cannot tell light that is scattered nearly straight ahead from light that is not
//! scattered. Where all orders are wanted, such light counts as not scattered (delta-M, Wiscombe 1977), and
//! still goes as the sun's own light does. Where orders are counted, every scattering counts.

use crate::color::Rgb;
use crate::fog::Medium;
use crate::scene::Bounces;
use glam::DVec3;

pub(super) struct SweptFog<'a> {
    medium: &'a Medium,
    /// What light loses on its way.
    pub(super) dimming: Medium,
    has_peaks: bool,
}

impl<'a> SweptFog<'a> {
    pub(super) fn new(medium: &'a Medium, bounces: Bounces) -> Self {
        let has_peaks = bounces != Bounces::All;
        let dimming = if has_peaks { medium.clone() } else { medium.without_peaks() };
        Self { medium, dimming, has_peaks }
    }

    /// What harmonics of each degree get back at a point, 1/m.
    pub(super) fn scattering_at(&self, point: DVec3) -> [Rgb; 3] {
        [0, 1, 2].map(|degree| match self.has_peaks {
            true => self.medium.scattering_by_degree_at(point, degree),
            false => self.medium.scattering_without_peak_at(point, degree),
        })
    }
}
