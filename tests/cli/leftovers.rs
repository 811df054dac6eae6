//! What killed runs leave behind: whole files, and parts that the next run removes and counts.
#![cfg(unix)]

use crate::program::Studio;
use std::fs::{self, File};
use std::process::Stdio;
use std::time::Instant;

/// A few leaves that fall, so that something is baked.
const FALL: &str = r#"Scene(version: 1, meshes: {"leaf": Leaf(length_m: 0.08, width_m: 0.05)}, objects: {},
    cameras: {"main": (position_m: (0, 1, 3), look_at_m: (0, 1, 0))},
    lights: {"s": Sun(to_sun: (0, 1, 0), irradiance_w_per_m2: 1)},
    fall: {"autumn": (count: 1000, species: [(meshes: ["leaf"], length_m: 0.08)],
        emitter: Box(min_m: (-1, 0.2, -1), max_m: (1, 0.3, 1)))})"#;

/// The next run removes what nobody is at work on of its own files, says so, and touches nothing else.
#[test]
fn parts_of_exports_pictures_and_bakes_are_removed_and_counted() {
    let studio = Studio::new();
    fs::write(studio.path("fall.ron"), FALL).unwrap();
    studio.succeed("inspect fall.ron --bake-cache cache");
    let bake = studio.names("cache").pop().unwrap();
    fs::remove_file(studio.path("cache").join(&bake)).unwrap();
    for (line, folder, name) in [
        ("export tiny.ron a/own.glb", "a", "own.glb"),
        ("preview tiny.ron --frames 1-2 --size 8x4 --out b/x.##.png", "b", "x.02.png"),
        ("preview tiny.ron --frames 1-2 --size 8x4 --out c/sheet.png", "c", "sheet.png"),
        ("preview tiny.ron --frames 1-2 --size 8x4 --out d/play.apng", "d", "play.apng"),
        ("inspect fall.ron --bake-cache cache", "cache", &bake),
    ] {
        fs::create_dir_all(studio.path(folder)).unwrap();
        let part =
            |of: &str, letters: &str| studio.path(folder).join(format!(".{of}.{letters}.sunfleck-part"));
        let (dead, at_work, other) =
            (part(name, "Ab3dE6"), part(name, "Zz9yX8"), part("other.txt", "Ab3dE6"));
        [&dead, &at_work, &other].into_iter().for_each(|path| fs::write(path, "half").unwrap());
        let file = File::open(&at_work).unwrap();
        file.lock().unwrap();
        let said = studio.succeed(line).err;
        assert!(said.contains("removed 1 unfinished file that killed runs left in "), "{line}: {said}");
        assert!(!dead.exists() && at_work.exists() && other.exists(), "{line}");
        assert!(studio.path(folder).join(name).exists(), "{line}");
    }
}

/// Moments all over a run: of loading, rendering, writing frames and pictures.
#[test]
fn runs_that_are_killed_at_any_moment_leave_whole_frames_and_can_go_on() {
    const KILLS: u32 = 12;
    let studio = Studio::new();
    let line = "render tiny.ron --frames 1-12 --size 96x54 --threads 1 --preview png --skip valid --out";
    let started = Instant::now();
    studio.succeed(&format!("{line} whole/"));
    let whole_run = started.elapsed();
    let names = studio.names("whole");
    assert_eq!(names.len(), 24);
    for kill in 0..KILLS {
        let mut run = studio.command(&format!("{line} {kill}/")).stderr(Stdio::null()).spawn().unwrap();
        // Spread by the golden ratio; the last comes after most of the run.
        std::thread::sleep(whole_run.mul_f64((f64::from(kill) * 0.618_034).fract().max(0.02)));
        run.kill().unwrap();
        run.wait().unwrap();
        let folder = kill.to_string();
        for name in studio.names(&folder).iter().filter(|name| !name.starts_with('.')) {
            assert!(
                studio.bytes(&format!("{folder}/{name}")) == studio.bytes(&format!("whole/{name}")),
                "{name}"
            );
        }
        studio.succeed(&format!("{line} {kill}/"));
        assert_eq!(studio.names(&folder), names, "nothing but frames and pictures is left");
        for name in &names {
            assert!(
                studio.bytes(&format!("{folder}/{name}")) == studio.bytes(&format!("whole/{name}")),
                "{name}"
            );
        }
    }
}
