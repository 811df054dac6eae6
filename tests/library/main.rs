//! The library against closed forms, brute force and other people's renderers, and its files there and back.
//! One crate, as each would be linked with all of the library; a module is run by
//! `cargo test --test library indirect::`.
#![allow(missing_docs, clippy::unwrap_used)]
#![allow(clippy::print_stdout, reason = "with --nocapture the tests show what they measure")]

mod accel;
mod airlight;
mod blended;
mod blender;
mod camera;
#[path = "../checkout/mod.rs"]
mod checkout;
mod clipping;
mod common;
mod deformation;
mod depth;
mod energy;
mod export;
mod export_keys;
mod export_meshes;
mod exposure;
mod face;
mod falling;
mod figures;
mod frame_file;
mod fuzzed;
mod gltf;
mod gltf_cases;
mod gltf_compressed;
mod gltf_invalid;
mod gltf_made;
mod gltf_valid;
mod grid_files;
mod grid_parts;
mod ground_light;
mod height_fog;
mod indirect;
mod invalid_input;
mod kept_light;
mod lights;
mod masks;
mod mattes;
mod motion_vectors;
mod near_light;
mod normal_maps;
mod numerics;
mod obj;
mod obj_sequences;
mod outline;
mod paths;
mod pixel_filter;
mod ray_visibility;
mod repetition;
mod scanline;
mod scene_format;
mod sequence;
mod shiny;
mod sky;
mod sky_suns;
mod slices;
mod spots;
mod tolerance;
mod translucent;
mod twice_scattered;
mod vdb;
mod voxel_fog;

// What measures figures, held here.
#[path = "../../benches/figures/all_light.rs"]
#[allow(dead_code, unreachable_pub, clippy::print_stderr)]
mod all_light;
#[path = "../../benches/figures/growth.rs"]
#[allow(dead_code, unreachable_pub, clippy::print_stderr)]
mod growth;
#[path = "../../benches/figures/inputs.rs"]
#[allow(dead_code, unreachable_pub, clippy::print_stderr)]
mod inputs;
#[path = "../../benches/figures/skips.rs"]
#[allow(dead_code, unreachable_pub, clippy::print_stderr)]
mod skips;
#[path = "../../benches/figures/skips_on_disk.rs"]
#[allow(dead_code, unreachable_pub, clippy::print_stderr)]
mod skips_on_disk;
