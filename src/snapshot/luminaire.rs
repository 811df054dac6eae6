//! A frozen light of any shape. In go two uniform numbers, out comes a light without extent.
//! Invariant: whatever is linear in the light has, over uniform numbers, the expectation of
//! [`Luminaire::point`]'s value; so everything exact that is known of a light without extent holds
//! for one with it, averaged.

use super::light::FrozenLight;
use crate::scene::Light;
use glam::DAffine3;

/// A light of any shape at one time, in relative space: a distribution over lights without extent.
#[derive(Clone, Debug)]
pub struct Luminaire {
    centre: FrozenLight,
}

impl Luminaire {
    /// Freezes `light`; `None` if it gives no light at this time.
    pub fn new(light: &Light, relative_from_light: DAffine3, time_s: f64) -> Option<Self> {
        FrozenLight::new(light, relative_from_light, time_s).map(|centre| Self { centre })
    }

    /// Whether it has no extent: every [`Luminaire::point`] is [`Luminaire::centre`], which is all of it.
    pub fn is_delta(&self) -> bool {
        true
    }

    /// The one in the middle: where it is seen from afar, and what it costs. Not its mean.
    pub fn centre(&self) -> FrozenLight {
        self.centre
    }

    /// The one that two numbers in `[0, 1)` pick; uniform numbers make it all of the light on average.
    pub fn point(&self, _u: [f64; 2]) -> FrozenLight {
        self.centre
    }
}
