//! Changes to parts of a scene in code. In goes a part, out comes the same part with other fields. Invariant:
//! programs still compile when a later version adds a field to a part.

use crate::description::obj::Triangles;
use crate::description::ron::{
    Aperture, Camera, Fall, FallGround, FallMotion, Fog, Julia, Leaves, Light, Material, Mist, NormalMap,
    Object, Shape, Sky, Species, Sun, Wind,
};

macro_rules! changed {
    ($($part:ty)*) => {
        $(impl $part {
            /// Returns the part with changed fields: `part.with(|part| part.field = value)`.
            #[must_use]
            pub fn with(mut self, change: impl FnOnce(&mut Self)) -> Self {
                change(&mut self);
                self
            }
        })*
    };
}

changed! {
    Aperture Camera Fall FallGround FallMotion Fog Julia Leaves Light Material Mist NormalMap Object Shape
    Sky Species Sun Triangles Wind
}
