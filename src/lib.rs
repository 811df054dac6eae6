//! Sunfleck turns a keyframed description of falling leaves into EXR frames whose volumetric
//! shadows are integrated exactly along each ray.
//!
//! # The story in ten lines
//!
//! 1. [`description`] reads what the author wrote: RON, glTF, OBJ. It alone opens input files.
//! 2. [`scene`] resolves it once: SI units, keyframed tracks, no dangling names. A [`scene::Scene`] that exists is valid.
//! 3. [`snapshot`] freezes one shutter interval: everything is placed relative to the camera.
//! 4. [`accel`] answers about its triangles: nearest hit, any hit, and which parts of a ray lie in shadow.
//! 5. [`scattering`] knows what matter does to light: phase functions, optical depth, surfaces.
//! 6. [`transport`] turns a ray into a colour: surface light times transmittance, plus the shafts.
//! 7. [`film`] turns samples into pixels and passes.
//! 8. [`render`] is the one loop that joins transport and film.
//! 9. [`frame_file`] writes a film as EXR, whole or not at all.
//! 10. [`sequence`] decides which frames; [`cli`] is what a user types.
//!
//! Imports point only upward in this list; `tests/architecture.rs` holds that.

pub mod accel;
pub mod cli;
pub mod color;
pub mod description;
pub mod diagnostic;
pub mod film;
pub mod frame_file;
pub mod math;
pub mod render;
pub mod scattering;
pub mod scene;
pub mod sequence;
pub mod snapshot;
pub mod transport;
