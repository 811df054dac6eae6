//! Fog in a half plane, under a distant light. In go the half plane and its shadows as they grow, out comes, for any ray in it, what fog does on the way.
//! Invariant: what does not depend on the ray is found once a slice, to within 1e-7 of what the ray would scatter without shadows.
//!
//! `fog_slice.rs` goes along a ray, stretch by stretch (`stretch.rs`) between the borders of what the slice cuts of each bank
//! (`section.rs`). What is lit is known by its moments (`lit_cells.rs`), which the integrands' derivatives are multiplied with: where fog is even they are
//! powers (`depth_line.rs`), where it thins out with height they are series (`depth_series.rs`, `thinning_fog.rs`).

mod depth_line;
mod depth_series;
mod fog_slice;
mod lit_cells;
mod section;
mod stretch;
mod thinning_fog;

pub use fog_slice::{FogSlice, Passage};
