//! Light transport along discrete ordinates (Chandrasekhar 1950, "Radiative Transfer"; Lewis & Miller 1984,
//! "Computational Methods of Neutron Transport"). In go cross-sections, boundaries and sources, out comes
//! radiance. Invariant: nothing here knows a leaf, a camera or a scene.
//!
//! [`PlaneParallel`] is a stack of layers over ground, which differ with height alone.

mod double_gauss;
mod plane_parallel;
mod scattering_operator;

pub use plane_parallel::{Beam, Boundaries, Level, PlaneParallel, Species, Stack};
pub use scattering_operator::{DEGREES, HARMONICS, Harmonics, basis as harmonic_basis};
