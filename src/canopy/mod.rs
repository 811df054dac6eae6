//! Canopies: leaves and fog as a turbid medium for discrete ordinates. In goes a snapshot, out come
//! cross-sections and the first-collision source of its lights. Invariant: this module sweeps nothing and
//! knows no camera.
//!
//! Leaf area by cell follows Ross 1981, "The radiation regime and architecture of plant stands".

pub(crate) mod clumping;
pub(crate) mod clumps;
pub(crate) mod core_bounds;
pub(crate) mod delta_scaled_fog;
pub(crate) mod emissive_bodies;
pub(crate) mod emitter_rays;
pub(crate) mod first_collisions;
pub(crate) mod fluence;
pub(crate) mod leaf_index;
pub(crate) mod leaf_power;
mod leaf_sums;
mod node_fog;
mod recollision;
pub(crate) mod self_interaction;
mod sheets;
pub(crate) mod surface_optics;
pub(crate) mod surfels;
pub(crate) mod surroundings;
pub(crate) mod turbid_medium;
