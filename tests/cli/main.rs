//! The program as a user meets it: command lines in; exit codes, messages and files out.
#![allow(clippy::unwrap_used)]

mod bench;
#[path = "../checkout/mod.rs"]
mod checkout;
mod disks;
mod documentation;
mod exr_files;
mod extras;
mod failures;
mod farm;
mod first_sight;
mod frames;
mod interruption;
mod leftovers;
mod live;
mod losses;
mod mist;
mod previews;
mod program;
mod questions;
mod schema;
mod serve;
mod shipped;
mod surroundings;
