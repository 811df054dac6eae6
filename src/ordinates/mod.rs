//! Light transport along discrete ordinates (Chandrasekhar 1950, "Radiative Transfer"; Lewis & Miller 1984,
//! "Computational Methods of Neutron Transport"). In go cross-sections, boundaries and sources, out comes
//! radiance. Invariant: nothing here knows a leaf, a camera or a scene.
//!
//! [`PlaneParallel`] is a stack of layers over ground, which differ with height alone. On a grid, source
//! iteration solves a [`source_iteration::Problem`]: `sweep` transports light along every ordinate, and
//! `cross_sections` and `walls` turn it into the next order's sources.

mod angle_set;
pub(crate) mod angular_radiance;
pub(crate) mod boundary;
mod bright_walls;
mod chebyshev;
mod counted_orders;
pub(crate) mod cross_sections;
pub(crate) mod domain;
mod double_gauss;
pub(crate) mod emissive_bodies;
mod extrapolation;
pub(crate) mod faces;
pub(crate) mod first_collision_source;
pub(crate) mod grid;
pub(crate) mod harmonics;
pub(crate) mod high_degrees;
mod moment_operators;
pub(crate) mod moments;
pub(crate) mod near_source;
pub(crate) mod occluders;
mod plane_parallel;
mod planes;
pub(crate) mod quadrature;
pub(crate) mod sky;
pub(crate) mod slopes;
pub(crate) mod source_iteration;
pub(crate) mod surface_optics;
pub(crate) mod sweep;
mod sweep_kernels;
mod upwind_stencil;
pub(crate) mod walls;
mod wanted;
mod workspace;

pub use moment_operators::{DEGREES, HARMONICS, Harmonics, basis as harmonic_basis};
pub use plane_parallel::{Beam, Boundaries, Level, Part, PlaneParallel, Species, Stack};
