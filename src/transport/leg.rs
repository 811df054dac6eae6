//! Radiance along one leg of a path, from its origin to the first surface, for rays and slices alike. In go
//! the light in front of that surface, the light behind, and the transmittance between. Invariant: radiance
//! is *surface times transmittance plus shafts*, and each part of it is attenuated as the whole is.

use super::{MATTES_OF_A_SAMPLE, Matte};
use crate::color::Rgb;
use std::ops::{Add, AddAssign};

/// A leg's light, and its end.
pub(super) struct Leg {
    pub(super) shown: Shown,
    pub(super) airlight: Airlight,
    pub(super) end: LegEnd,
}

impl Leg {
    /// `in_front` has the shafts and blended surfaces, `behind` the light of the surface that ends the leg,
    /// or of the background.
    pub(super) fn new(airlight: Airlight, in_front: Shown, behind: Shown, end: LegEnd) -> Self {
        Self { shown: in_front + behind.weakened(airlight.transmittance), airlight, end }
    }
}

/// In-scattered radiance along a leg, and the transmittance for light behind it (Koschmieder 1924).
#[derive(Clone, Copy)]
pub(super) struct Airlight {
    /// Radiance, W m^-2 sr^-1.
    pub(super) shafts: Rgb,
    /// Part of `shafts` that had been scattered before.
    pub(super) indirect_shafts: Rgb,
    /// Transmittance of fog and blended surfaces.
    pub(super) transmittance: Rgb,
}

#[derive(Clone, Copy)]
pub(super) struct LegEnd {
    /// Whether it is an opaque surface.
    pub(super) is_covered: bool,
    /// The share of the leg that ends at holdouts.
    pub(super) held_out: f64,
    pub(super) mattes: [Matte; MATTES_OF_A_SAMPLE],
}

/// Radiance that leaves a surface towards the eye.
#[derive(Clone, Copy, Default)]
pub(super) struct Shown {
    pub(super) radiance: Rgb,
    /// Part that is emission, by the surface or mirrored in it.
    pub(super) emitted: Rgb,
    /// Part that is indirect light, on the surface or mirrored in it.
    pub(super) indirect: Rgb,
}

impl Shown {
    /// Radiance that is emission alone.
    pub(super) fn emitted(emitted: Rgb) -> Self {
        Self { radiance: emitted, emitted, indirect: Rgb::ZERO }
    }

    pub(super) fn weakened(self, transmittance: Rgb) -> Self {
        Self {
            radiance: transmittance * self.radiance,
            emitted: transmittance * self.emitted,
            indirect: transmittance * self.indirect,
        }
    }
}

impl AddAssign for Shown {
    fn add_assign(&mut self, other: Self) {
        self.radiance += other.radiance;
        self.emitted += other.emitted;
        self.indirect += other.indirect;
    }
}

impl Add for Shown {
    type Output = Self;
    fn add(mut self, other: Self) -> Self {
        self += other;
        self
    }
}
