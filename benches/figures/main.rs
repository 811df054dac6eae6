//! Figures that the documents quote: `cargo bench --bench figures -- <figure> [count]`.
#![allow(missing_docs, unreachable_pub, clippy::print_stdout, clippy::print_stderr, clippy::unwrap_used)]

mod all_light;
#[path = "../../tests/checkout/mod.rs"]
mod checkout;
mod falling;
mod growth;
mod heaps;
mod import;
mod inputs;
mod leaks;
mod lit_segments;
mod near_light;
mod preview;
mod ray_scenes;
mod rays;
mod shafts;
mod skips;
mod skips_on_disk;
mod slices;
mod streaks;

use std::path::Path;

fn main() {
    // Cargo adds `--bench`.
    let arguments: Vec<String> = std::env::args().skip(1).filter(|argument| argument != "--bench").collect();
    let count = |default: u64| arguments.get(1).and_then(|count| count.parse().ok()).unwrap_or(default);
    match arguments.first().map(String::as_str) {
        Some("all-light") => all_light::run(count(1) as usize),
        Some("falling") => falling::run(count(3) as usize),
        Some("growth") => growth::run(arguments.get(1)),
        Some("heaps") => heaps::run(arguments.get(1)),
        Some("import") => import::run(count(3) as usize),
        // What `import` starts.
        Some("read") => import::read(Path::new(&arguments[1])),
        Some("leaks") => leaks::run(count(100_000_000)),
        Some("near") => near_light::run(count(9) as usize),
        Some("preview") => preview::run(count(9) as usize),
        Some("rays") => rays::run(count(7) as usize),
        Some("segments") => lit_segments::run(count(2000) as u32),
        Some("shafts") => shafts::run(count(3) as usize),
        Some("streaks") => streaks::run(),
        Some("bias") => streaks::run_bias(count(32) as u32),
        Some("canopy") => slices::run_canopy(count(3) as usize),
        Some("skips") => skips::run(count(5) as usize),
        Some("slices") => slices::run(count(3) as usize),
        Some("sun") => slices::run_sun(count(3) as usize),
        _ => {
            println!(
                "all-light [rounds]  light of all orders by the grid and by random walks: error against time"
            );
            println!(
                "bias [seeds]      means of pictures of few samples against the per-ray method; seeds of 16 samples"
            );
            println!("canopy [rounds]   whole pictures of 20,000 leaves by slices: time and error");
            println!("falling [rounds]  20,000 falling leaves from the file to their keys: time");
            println!(
                "growth [quantity]  how time grows with leaves, pixels, lights, accuracy, fog, threads; writes plots"
            );
            println!("heaps [file]      leaves that have fallen and lie through each other");
            println!("import [rounds]   large glTF files: time and memory");
            println!("leaks [rays]      rays aimed at edges and vertices of closed meshes that pass through");
            println!("near [rounds]     a near light's lit parts, few and many: time and error");
            println!("preview [rounds]  scan-line pictures: time of a frame and its parts");
            println!("rays [rounds]     time of a ray and of a shadow query, one thread");
            println!("shafts [rounds]   cost of a sample's parts by each method, and the methods' errors");
            println!("skips [rounds]    what is left out where a scene does not need it, with and without");
            println!("slices [rounds]   whole pictures of 500 leaves: time and error, threads");
            println!("streaks           correlation of the error along slices and across them");
            println!(
                "sun [rounds]      the same under a sun with an extent, and with the sun in the picture"
            );
            println!("segments [rays]   lit segments against brute force in double precision");
        }
    }
}
