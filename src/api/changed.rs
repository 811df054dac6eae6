//! Parts that a program changes as it likes. In goes a part, out comes the same with other fields. Invariant:
//! a part may get a field with any version, and no program that was written before has to say it.

use crate::description::obj::Triangles;
use crate::description::ron::{
    Aperture, Camera, Fall, FallGround, FallMotion, Fog, Julia, Leaves, Material, Mist, NormalMap, Object,
    Species, Sun, Wind,
};

macro_rules! changed {
    ($($part:ty)*) => {
        $(impl $part {
            /// Part with other fields: `part.with(|part| part.field = value)`.
            #[must_use]
            pub fn with(mut self, change: impl FnOnce(&mut Self)) -> Self {
                change(&mut self);
                self
            }
        })*
    };
}

changed! {
    Aperture Camera Fall FallGround FallMotion Fog Julia Leaves Material Mist NormalMap Object Species Sun
    Triangles Wind
}
