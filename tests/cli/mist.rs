//! Mist that drifts: a frame is a function of its number, and what cannot be is refused with its place.

use crate::checkout;
use crate::program::Studio;

/// Exit code of scenes that cannot be used.
const SCENE: i32 = 3;

/// A camera before a box of mist under a sun.
fn scene(fog: &str) -> String {
    format!(
        r#"Scene(version: 1,
            cameras: {{"c": (position_m: (0, 1.5, 8), look_at_m: (0, 1.5, 0), fov_deg: 40)}},
            lights: {{"sun": Sun(to_sun: (0.3, 0.6, -0.7), irradiance_w_per_m2: 10)}},
            fog: {{"banks": (min_m: (-3, 0, -3), max_m: (3, 3, 3), density_per_m: 0.4, {fog})}},
        )"#
    )
}

const DRIFTING: &str = "scale_height_m: 1, mist: (size_m: 1.5, octaves: 3, wind_m_per_s: (2, 0, 0), \
                        evolution_turns: Keyed(keys: [(at_s: 0, value: 0), (at_s: 4, value: 1)]))";

#[test]
fn a_frame_is_a_function_of_its_number() {
    let studio = Studio::new();
    std::fs::write(studio.path("mist.ron"), scene(DRIFTING)).unwrap();
    let render = "render mist.ron --size 16x9 --samples 2 --shutter 0.5";
    studio.succeed(&format!("{render} --frames 1-3 --out all/f.#.exr"));
    studio.succeed(&format!("{render} --frames 3 --threads 1 --out alone/f.#.exr"));
    assert_eq!(studio.bytes("all/f.3.exr"), studio.bytes("alone/f.3.exr"));
    assert_ne!(studio.bytes("all/f.1.exr"), studio.bytes("all/f.3.exr"));
    let told = studio.succeed("inspect mist.ron").out;
    assert!(told.contains("billows of 1.5 m and smaller"), "{told}");
}

#[test]
fn exports_leave_it_out_and_say_so() {
    let studio = Studio::new();
    std::fs::write(studio.path("mist.ron"), scene(DRIFTING)).unwrap();
    let outcome = studio.succeed("export mist.ron mist.glb");
    assert!(outcome.err.contains("export-mist"), "{}", outcome.err);
}

#[test]
fn what_no_mist_can_be_is_refused_with_its_place() {
    let studio = Studio::new();
    std::fs::copy(checkout::file("tests/data/vdb/several.vdb"), studio.path("grid.vdb")).unwrap();
    for (fog, said) in [
        ("mist: (size_m: 1, voxel_m: 0.001)", "fog.banks.mist"),
        ("mist: (size_m: 0.001, voxel_m: 0.5)", "billows of 0.001 m"),
        ("mist: (size_m: 0.00001)", "billows of 0.00001 m"),
        ("mist: (size_m: 0)", "greater than 0"),
        ("mist: (size_m: 1, cover: 2)", "from 0 to 1"),
        ("mist: (size_m: 1, ground: \"hill\")", "fog.banks.mist.ground"),
        ("mist: (size_m: 1), vdb: \"grid.vdb\"", "`mist` stands beside `vdb`"),
        ("mist: (size: 1)", "size_m"),
    ] {
        std::fs::write(studio.path("mist.ron"), scene(fog)).unwrap();
        let outcome = studio.run("render mist.ron --size 8x4 --out a/");
        assert!(outcome.code == SCENE && outcome.err.contains(said), "{fog}: {}", outcome.err);
        assert!(outcome.err.contains("remedy"), "{fog}: {}", outcome.err);
    }
    for (corners, said) in [
        ("min_m: (1e12, 0, 0), max_m: (1.00000000001e12, 3, 3),", "from its parent's origin"),
        ("min_m: (-1e6, 0, -1e6), max_m: (1e6, 1e-6, 1e6),", "fog.banks.mist"),
    ] {
        let text = scene("mist: (size_m: 1, voxel_m: 0.25)");
        let text = text.replace("min_m: (-3, 0, -3), max_m: (3, 3, 3),", corners);
        std::fs::write(studio.path("mist.ron"), text).unwrap();
        let outcome = studio.run("render mist.ron --size 8x4 --out a/");
        assert!(outcome.code == SCENE && outcome.err.contains(said), "{corners}: {}", outcome.err);
    }
    let without = scene("mist: (size_m: 1)").replace("min_m: (-3, 0, -3), max_m: (3, 3, 3),", "");
    std::fs::write(studio.path("mist.ron"), without).unwrap();
    let outcome = studio.run("render mist.ron --size 8x4 --out a/");
    assert!(outcome.code == SCENE && outcome.err.contains("`mist` has no box"), "{}", outcome.err);
}
