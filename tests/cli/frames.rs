//! `render`: which frames there are afterwards, and what is in them.

use crate::program::Studio;
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};
use sunfleck::film::Frame;
use sunfleck::scene::Size;

#[test]
fn a_sequence_goes_where_nobody_said_otherwise() {
    let studio = Studio::new();
    let outcome = studio.succeed("render tiny.ron --frames 1-2");
    assert_eq!(studio.names("out/tiny"), ["tiny.0001.exr", "tiny.0002.exr"]);
    let last = outcome.err.lines().last().unwrap();
    assert!(last.starts_with("2 frames written to out/tiny in "), "{last}");
    assert_eq!(outcome.out, "", "what people read goes to the error stream");
}

#[test]
fn a_scene_is_rendered_too() {
    let studio = Studio::new();
    studio.succeed("render scene.ron --size 16x9 --samples 1 --bounces 0 --frames 1 --out still.exr");
    assert_eq!(studio.frame("still.exr").frame.full, Size { width: 16, height: 9 });
    studio.succeed("render scene.ron --size 8x4 --samples 1 --frames 1 --out usual.exr");
    studio.succeed("render scene.ron --size 8x4 --samples 1 --frames 1 --bounces all --out all.exr");
    assert_eq!(studio.frame("usual.exr").frame, studio.frame("all.exr").frame);
}

/// What moves in a scene by itself is seen at any frame; of a sequence those that it names.
#[test]
fn a_scene_by_itself_has_every_frame() {
    let studio = Studio::new();
    studio.succeed("render scene.ron --size 32x18 --samples 2 --bounces 0 --frames 7,30 --out a/");
    assert_eq!(studio.names("a"), ["scene.0007.exr", "scene.0030.exr"]);
    studio.succeed("render tiny.ron --frames 7 --out b/");
    assert_eq!(studio.frame("a/scene.0007.exr").frame, studio.frame("b/tiny.0007.exr").frame);
    studio.fail("render tiny.ron --frames 30 --out b/", 2);
    studio.succeed("preview scene.ron --size 16x9 --frames 2-3 --out c/");
    assert_eq!(studio.names("c"), ["scene.0002.png", "scene.0003.png"]);
    studio.succeed("render scene.ron --size 16x9 --samples 1 --bounces 0 --out d/");
    assert_eq!(studio.names("d"), ["scene.0001.exr"]);
}

#[test]
fn a_frame_says_how_good_it_is() {
    let studio = Studio::new();
    let outcome = studio.succeed("render tiny.ron --tolerance 0.2 --passes error --frames 1 --out a.exr");
    assert!(outcome.err.contains(" s, noise "), "{}", outcome.err);
    let file = studio.frame("a.exr");
    assert_eq!(file.attributes.get("sunfleck:tolerance"), Some("0.2"));
    let errors = &file.frame.channel("error.Y").unwrap().pixels;
    assert!(
        errors.iter().all(|error| (0.0..=0.2).contains(error)) && errors.iter().any(|error| *error > 0.0)
    );
    // Another tolerance is another frame.
    let skips = |line: &str| studio.succeed(line).err.contains("1 skipped");
    assert!(skips("render tiny.ron --tolerance 0.2 --passes error --frames 1 --out a.exr --skip valid"));
    assert!(!skips("render tiny.ron --tolerance 0.1 --passes error --frames 1 --out a.exr --skip valid"));
}

/// The manifest names all objects in the picture, by the ids that its channels hold.
#[test]
fn mattes_are_named() {
    let studio = Studio::new();
    studio.succeed(
        "render scene.ron --size 16x9 --samples 4 --bounces 0 --frames 1 --passes cryptomatte,motion --out a.exr",
    );
    let file = studio.frame("a.exr");
    // The layer's own hash is 3ae39a58.
    let field = |name: &str| file.attributes.get(&format!("cryptomatte/3ae39a5/{name}")).unwrap();
    assert_eq!(field("name"), "CryptoObject");
    assert_eq!((field("hash"), field("conversion")), ("MurmurHash3_32", "uint32_to_float32"));
    let manifest: BTreeMap<String, String> = serde_json::from_str(field("manifest")).unwrap();
    let hashes: BTreeSet<String> = manifest.values().cloned().collect();
    let ids =
        ["00.R", "00.B", "01.R"].map(|name| file.frame.channel(&format!("CryptoObject{name}")).unwrap());
    let found: BTreeSet<String> = ids
        .iter()
        .flat_map(|channel| channel.pixels.iter().filter(|id| **id != 0.0))
        .map(|id| format!("{:08x}", id.to_bits()))
        .collect();
    assert!(!found.is_empty() && found == hashes, "{found:?} {manifest:?}");
    assert!(file.frame.channel("Vector.W").is_some());
}

#[test]
fn a_file_made_by_blender_is_rendered_too() {
    let studio = Studio::new();
    studio.succeed("render checkout:tests/data/leaves500/leaves500.glb --size 5% --samples 1 --out a/");
    assert_eq!(studio.frame("a/leaves500.0001.exr").frame.full, Size { width: 24, height: 14 });
}

#[test]
fn frames_are_chosen_by_lists() {
    let studio = Studio::new();
    for (list, frames) in [
        ("3", &[3][..]),
        ("1-3", &[1, 2, 3]),
        ("1..3", &[1, 2, 3]),
        ("1-9x4", &[1, 5, 9]),
        ("1-9:4", &[1, 5, 9]),
        ("2,12,4-5", &[2, 4, 5, 12]),
        ("all", &[1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12]),
    ] {
        studio.succeed(&format!("render tiny.ron --frames {list} --size 4x2 --samples 1 --out {list}/"));
        let names: Vec<_> = frames.iter().map(|frame| format!("tiny.{frame:04}.exr")).collect();
        assert_eq!(studio.names(list), names, "--frames {list}");
    }
}

#[test]
fn output_patterns_number_the_frames() {
    let studio = Studio::new();
    for (pattern, name) in [("a.#.exr", "a.7.exr"), ("b_%03d.exr", "b_007.exr"), ("c.$F5.exr", "c.00007.exr")]
    {
        studio.succeed(&format!("render tiny.ron --frames 7 --size 4x2 --samples 1 --out {pattern}"));
        assert!(studio.path(name).is_file(), "{name} is missing");
    }
    // A folder that exists is itself.
    std::fs::create_dir(studio.path("take#3_%d_$F")).unwrap();
    studio.succeed("render tiny.ron --frames 7 --size 4x2 --samples 1 --out take#3_%d_$F/d.##.exr");
    assert_eq!(studio.names("take#3_%d_$F"), ["d.07.exr"]);
    studio.fail("render tiny.ron --frames 7 --size 4x2 --samples 1 --out take#4/d.##.exr", 2);
}

#[test]
fn flags_work_in_any_order() {
    let studio = Studio::new();
    studio.succeed("render --samples 1 tiny.ron --out a/ --frames 2 --size 8x4");
    studio.succeed("render --size 8x4 --frames=2 --out b/ --samples=1 tiny.ron");
    assert_eq!(studio.bytes("a/tiny.0002.exr"), studio.bytes("b/tiny.0002.exr"));
}

#[test]
fn sizes_may_be_percentages_of_the_sequence() {
    let studio = Studio::new();
    studio.succeed("render tiny.ron --frames 1 --size 50% --out half.exr");
    assert_eq!(studio.frame("half.exr").frame.full, Size { width: 16, height: 9 });
}

#[test]
fn a_crop_is_a_part_of_the_whole() {
    // Many blocks of the leaves stop where others go on.
    let leaves = "checkout:tests/data/leaves500/leaves500.glb";
    for (input, volume, [x0, y0, x1, y1]) in [
        ("tiny.ron", "segments --samples 1", [4, 3, 20, 12]),
        ("tiny.ron", "slices --samples 1", [4, 3, 20, 12]),
        ("tiny.ron", "slices --samples 5", [4, 3, 20, 12]),
        ("tiny.ron", "slices --tolerance 0.1", [4, 3, 20, 12]),
        ("tiny.ron", "slices --tolerance 0.1 --filter blackman-harris", [4, 3, 20, 12]),
        (leaves, "slices --tolerance 0.02", [100, 52, 300, 150]),
    ] {
        let studio = Studio::new();
        let flags = format!("render {input} --bounces all --frames 1 --volume {volume}");
        studio.succeed(&format!("{flags} --out whole.exr"));
        studio.succeed(&format!("{flags} --crop {x0},{y0},{x1},{y1} --out part.exr"));
        let (whole, part) = (studio.frame("whole.exr").frame, studio.frame("part.exr").frame);
        assert_eq!(part.full, whole.full);
        let window = part.window;
        assert_eq!([window.x, window.y, window.x + window.width, window.y + window.height], [x0, y0, x1, y1]);
        let pixel = |frame: &sunfleck::film::Frame, x, y| {
            frame.channel("R").unwrap().pixels[frame.window.index(x, y).unwrap()]
        };
        for (x, y) in part.window.pixels() {
            assert_eq!(pixel(&part, x, y), pixel(&whole, x, y), "{input} {volume}, ({x}, {y})");
        }
    }
}

#[test]
fn all_passes_are_the_channels_that_compositors_know() {
    let studio = Studio::new();
    studio.succeed("render tiny.ron --frames 1 --size 8x4 --passes all --out a.exr");
    let mut names: Vec<String> =
        studio.frame("a.exr").frame.channels.iter().map(|channel| channel.name.clone()).collect();
    let mut expected = [
        "R",
        "G",
        "B",
        "A",
        "Z",
        "Normal.X",
        "Normal.Y",
        "Normal.Z",
        "Position.X",
        "Position.Y",
        "Position.Z",
        "albedo.R",
        "albedo.G",
        "albedo.B",
        "error.Y",
        "indirect.R",
        "indirect.G",
        "indirect.B",
        "indirect_shafts.R",
        "indirect_shafts.G",
        "indirect_shafts.B",
        "leaf_id.X",
        "shafts.R",
        "shafts.G",
        "shafts.B",
        "transmittance.R",
        "transmittance.G",
        "transmittance.B",
        "Vector.X",
        "Vector.Y",
        "Vector.Z",
        "Vector.W",
    ]
    .map(String::from)
    .to_vec();
    let ranks =
        (0..3).flat_map(|layer| "RGBA".chars().map(move |letter| format!("CryptoObject0{layer}.{letter}")));
    expected.extend(ranks);
    names.sort_unstable();
    expected.sort_unstable();
    assert_eq!(names, expected);
}

#[test]
fn cameras_seeds_and_methods_change_the_picture() {
    let studio = Studio::new();
    let render = |flags: &str| {
        studio.succeed(&format!("render tiny.ron --frames 1 --out a.exr {flags}"));
        studio.frame("a.exr").frame.channels
    };
    let plain = render("");
    for flags in [
        "--camera low",
        "--seed 7",
        "--volume march --volume-steps 8",
        "--volume equiangular",
        "--volume paths",
    ] {
        assert_ne!(render(flags), plain, "{flags}");
    }
}

#[test]
fn the_bytes_do_not_depend_on_threads_or_company() {
    let studio = Studio::new();
    studio.succeed("render tiny.ron --bounces all --frames 1-3 --passes all --threads 1 --out one/");
    let light = studio.frame("one/tiny.0003.exr").frame;
    for pass in ["indirect.R", "indirect_shafts.R"] {
        assert!(light.channel(pass).unwrap().pixels.iter().any(|&value| value > 0.0), "{pass} is dark");
    }
    for threads in ["2", "16", "2 --frames-at-once 1"] {
        studio.succeed(&format!(
            "render tiny.ron --bounces all --frames 1-3 --passes all --threads {threads} --out many/"
        ));
        for frame in ["tiny.0001.exr", "tiny.0002.exr", "tiny.0003.exr"] {
            let [one, many] = ["one", "many"].map(|folder| studio.bytes(&format!("{folder}/{frame}")));
            assert_eq!(one, many, "{frame} on {threads} threads");
        }
    }
    studio.succeed("render tiny.ron --bounces all --frames 3 --passes all --threads 2 --out alone/");
    assert_eq!(studio.bytes("one/tiny.0003.exr"), studio.bytes("alone/tiny.0003.exr"));
}

#[test]
fn a_dry_run_writes_nothing() {
    let studio = Studio::new();
    let before = studio.names(".");
    let outcome = studio.succeed("render tiny.ron --dry-run --frames 1-9x4");
    assert_eq!(studio.names("."), before);
    for part in ["3 frames of 32x18 pixels", "--volume auto", "camera `main`", "out/tiny/tiny.0001.exr"] {
        assert!(outcome.out.contains(part), "{part} is not in\n{}", outcome.out);
    }
    for word in ["slices", "segments", "march", "equiangular", "paths"] {
        let said = studio.succeed(&format!("render tiny.ron --dry-run --volume {word}")).out;
        assert!(said.contains(&format!(", --volume {word}, ")), "{said}");
    }
}

#[test]
fn no_frames_are_rendered_well_and_animate_nothing() {
    let studio = Studio::new();
    let outcome = studio.succeed("render tiny.ron --frames none --out a/ --progress plain");
    assert!(format!("{}{}", outcome.out, outcome.err).contains("0 frames written"), "{}", outcome.err);
    assert!(studio.succeed("render tiny.ron --frames none --dry-run").out.starts_with("0 frames"));
    studio.fail("export tiny.ron tiny.glb --frames none", 2);
}

#[test]
fn valid_frames_are_skipped_and_damaged_ones_rendered_again() {
    let studio = Studio::new();
    let render = "render tiny.ron --frames 1-3 --out a/ --skip valid";
    studio.succeed(render);
    let whole: Vec<_> = (1..=3).map(|frame| studio.bytes(&format!("a/tiny.000{frame}.exr"))).collect();
    let mut damaged = whole[1].clone();
    let middle = damaged.len() * 3 / 4;
    damaged[middle] ^= 0x40;
    std::fs::write(studio.path("a/tiny.0002.exr"), damaged).unwrap();
    std::fs::write(studio.path("a/tiny.0003.exr"), &whole[2][..whole[2].len() / 2]).unwrap();

    let again = studio.succeed(render);
    assert!(again.err.contains("2 frames written"), "{}", again.err);
    assert!(again.err.contains("1 skipped (there already, and valid)"), "{}", again.err);
    for (frame, bytes) in (1..=3).zip(&whole) {
        assert_eq!(&studio.bytes(&format!("a/tiny.000{frame}.exr")), bytes, "frame {frame}");
    }
    // A comment more is the same scene.
    let scene = std::fs::read_to_string(studio.path("tiny.ron")).unwrap();
    std::fs::write(studio.path("tiny.ron"), format!("// Leaves.\n{scene}")).unwrap();
    let again = studio.succeed(render);
    assert!(again.err.contains("3 skipped (there already, and valid)"), "{}", again.err);
}

#[test]
fn frames_of_other_settings_are_not_valid_but_exist() {
    let studio = Studio::new();
    studio.succeed("render tiny.ron --frames 1 --out a/");
    let other = studio.succeed("render tiny.ron --frames 1 --out a/ --seed 3 --skip exists");
    assert!(other.err.contains("1 skipped (there already)"), "{}", other.err);
    let other = studio.succeed("render tiny.ron --frames 1 --out a/ --seed 3 --skip valid");
    assert!(other.err.contains("1 frame written"), "{}", other.err);
}

#[test]
fn without_a_terminal_progress_is_plain_lines() {
    let studio = Studio::new();
    let outcome = studio.succeed("render tiny.ron --frames 1-2 --size 4x2 --out a/");
    let lines: Vec<_> = outcome.err.lines().collect();
    assert_eq!(lines.len(), 3, "{}", outcome.err);
    assert!(lines[0].starts_with("frame 1 written to a/tiny.0001.exr"), "{}", lines[0]);
    assert!(!outcome.err.contains(['\r', '\u{1b}']), "{:?}", outcome.err);
}

#[test]
fn progress_for_programs_is_json() {
    let studio = Studio::new();
    let outcome = studio.succeed("render tiny.ron --frames 1-2 --size 4x2 --out a/ --progress jsonl");
    let events: Vec<Value> = outcome.out.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    assert_eq!(events.first().unwrap()["event"], "started");
    assert_eq!(events.last().unwrap()["event"], "finished");
    assert_eq!(events.last().unwrap()["written"], 2);
    assert_eq!(outcome.err, "");
}

#[test]
fn statistics_are_a_line_a_frame() {
    let studio = Studio::new();
    studio.succeed("render tiny.ron --frames 2 --out a/");
    studio.succeed("render tiny.ron --frames 1-2 --tolerance 0.2 --out a/ --skip exists --stats stats.jsonl");
    let stats = String::from_utf8(studio.bytes("stats.jsonl")).unwrap();
    let lines: Vec<Value> = stats.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    let line = |frame: i64| lines.iter().find(|line| line["frame"] == frame).unwrap();
    assert_eq!(line(2)["outcome"], "skipped");
    let written = line(1);
    assert_eq!((&written["outcome"], &written["blocks"]), (&"written".into(), &12.into()), "4 x 3 blocks");
    assert!(written["samples"].as_u64().unwrap() >= 4 * 32 * 18 * 9 / 10, "{written}");
    assert!(written["error"].as_f64().unwrap() <= 0.2, "{written}");
    assert_eq!(written["method"], "slices");
    let slices = written["slices"].as_u64().unwrap();
    assert!(slices > 10 && written["segments"].as_u64().unwrap() > slices, "{written}");
    let memory = written["peak_memory_bytes"].as_u64();
    assert!(memory.is_some_and(|bytes| bytes > 1 << 20) || !cfg!(target_os = "linux"), "{written}");
    let stages = ["snapshot_seconds", "indirect_seconds", "walks_seconds", "render_seconds", "write_seconds"];
    assert!(stages.iter().all(|key| written[key].is_f64()), "{written}");
}

#[test]
fn previews_lie_beside_the_frames() {
    let studio = Studio::new();
    studio.succeed("render tiny.ron --frames 1 --size 8x4 --out a/ --preview png");
    assert_eq!(studio.names("a"), ["tiny.0001.exr", "tiny.0001.png"]);
    let preview = image::open(studio.path("a/tiny.0001.png")).unwrap();
    assert_eq!((preview.width(), preview.height()), (8, 4));
}

#[test]
fn previews_follow_curve_and_exposure_and_frames_do_not() {
    let studio = Studio::new();
    let picture = |flags: &str, folder: &str| {
        studio.succeed(&format!(
            "render tiny.ron --frames 1 --size 8x4 --bounces 0 --out {folder}/ --preview png {flags}"
        ));
        let preview = image::open(studio.path(&format!("{folder}/tiny.0001.png"))).unwrap().to_rgb8();
        (studio.bytes(&format!("{folder}/tiny.0001.exr")), preview.into_raw())
    };
    let (frame, agx) = picture("", "agx");
    let sum = |bytes: &[u8]| bytes.iter().map(|&byte| u32::from(byte)).sum::<u32>();
    for (flags, folder) in [("--exposure -1", "dark"), ("--display srgb", "srgb"), ("--display raw", "raw")] {
        let (same, other) = picture(flags, folder);
        assert_eq!(same, frame, "{flags}");
        assert_ne!(other, agx, "{flags}");
    }
    assert!(sum(&picture("--exposure -1", "dark").1) < sum(&agx));
    let (_, doubled) = picture("--display raw --exposure 1 --skip valid", "raw");
    let (_, once) = picture("--display raw --exposure 0 --skip valid", "raw");
    assert!(once.iter().zip(&doubled).all(|(&once, &doubled)| once > 120 || doubled.abs_diff(2 * once) <= 2));
}

#[test]
fn shafts_alone_are_the_pass_and_hide_what_fog_hides() {
    let studio = Studio::new();
    studio.succeed("render tiny.ron --frames 1 --passes shafts,transmittance --out all.exr");
    studio.succeed("render tiny.ron --frames 1 --passes depth --only shafts --out alone.exr");
    let (all, alone) = (studio.frame("all.exr").frame, studio.frame("alone.exr").frame);
    let pixels = |frame: &Frame, name: &str| frame.channel(name).unwrap().pixels.clone();
    for color in ["R", "G", "B"] {
        assert_eq!(pixels(&alone, color), pixels(&all, &format!("shafts.{color}")), "{color}");
    }
    let through = ["R", "G", "B"].map(|color| pixels(&all, &format!("transmittance.{color}")));
    for (pixel, alpha) in pixels(&alone, "A").into_iter().enumerate() {
        let mean = through.iter().map(|channel| channel[pixel]).sum::<f32>() / 3.0;
        assert!((alpha - (1.0 - mean)).abs() < 1e-3, "{alpha} {mean}");
    }
    assert!(alone.channel("Z").is_some() && alone.channel("shafts.R").is_none());
    // Another picture: not the one that is there.
    let beauty = studio.succeed("render tiny.ron --frames 1 --passes depth --out alone.exr --skip valid");
    assert!(beauty.err.contains("1 frame written"), "{}", beauty.err);
    let bare = r#"Scene(version: 1, meshes: {"leaf": Leaf(length_m: 1.0, width_m: 1.0)}, objects: {"leaf": (mesh: "leaf")},
        cameras: {"main": (position_m: (0.0, 0.0, 4.0))}, sky: Constant(radiance_w_per_m2_sr: 1.0))"#;
    std::fs::write(studio.path("bare.ron"), bare).unwrap();
    let black = studio.succeed("render bare.ron --size 8x4 --samples 1 --only shafts --out black.exr").err;
    assert!(black.contains("the scene has no fog"), "{black}");
}

/// A wall that shines, and the same wall as a plate behind a holdout.
#[test]
fn frames_go_over_a_plate() {
    let studio = Studio::new();
    let plate = [0.5, 0.3, 0.2];
    for (name, holdout) in [("wall", false), ("plate", true)] {
        let scene = format!(
            r#"Scene(version: 1, meshes: {{ "wall": Quad(size_m: 8.0), "leaf": Leaf(length_m: 0.5, width_m: 0.3) }},
            materials: {{ "glow": (base_color: 0.0, emission_w_per_m2_sr: {:?}), "red": (base_color: (0.5, 0.2, 0.1)) }},
            objects: {{ "wall": (mesh: "wall", material: "glow", rotation_deg: (90.0, 0.0, 0.0),
                translation_m: (0.0, 0.0, -2.0), holdout: {holdout}),
                "leaf": (mesh: "leaf", material: "red", rotation_deg: (60.0, 20.0, 0.0)) }},
            cameras: {{ "main": (position_m: (0.0, 0.0, 3.0), look_at_m: (0.0, 0.0, 0.0), fov_deg: 40.0) }},
            lights: {{ "sun": Sun(to_sun: (0.3, 1.0, 0.2), irradiance_w_per_m2: 3.0) }},
            fog: {{ "haze": (min_m: (-3.0, -3.0, -1.5), max_m: (3.0, 3.0, 2.0), density_per_m: 0.2) }})"#,
            (plate[0], plate[1], plate[2])
        );
        std::fs::write(studio.path(&format!("{name}.ron")), scene).unwrap();
        studio.succeed(&format!(
            "render {name}.ron --frames 1 --size 32x18 --samples 4 --bounces 0 --out {name}.exr"
        ));
    }
    let (wall, over) = (studio.frame("wall.exr").frame, studio.frame("plate.exr").frame);
    let alpha = &over.channel("A").unwrap().pixels;
    for (color, plate) in ["R", "G", "B"].into_iter().zip(plate) {
        let pixels = wall.channel(color).unwrap().pixels.iter().zip(&over.channel(color).unwrap().pixels);
        for ((&whole, &light), &alpha) in pixels.zip(alpha) {
            let laid_over = light + (1.0 - alpha) * plate;
            assert!((laid_over - whole).abs() < 1e-3, "{color}: {laid_over} {whole}");
        }
    }
}
