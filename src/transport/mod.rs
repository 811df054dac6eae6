//! A ray becomes a colour.

mod sample;

pub use sample::{Sample, SurfaceFeatures};
