//! `fall` blocks from outside. The same leaves whatever is asked of the scene, an author's own keys, and
//! the way through glTF.

use crate::checkout;
use glam::DVec3;
use std::path::Path;
use sunfleck::scene::{self, RenderSettings, Scene};
use sunfleck::{description, export};

fn resolved(path: &Path) -> (Scene, RenderSettings) {
    scene::resolve(description::load(path).unwrap(), None).unwrap_or_else(|problems| panic!("{problems}"))
}

/// A scene of one fall, with more objects and fields of the block.
fn scene_file(objects: &str, fields: &str) -> String {
    format!(
        r#"Scene(version: 1, cameras: {{ "main": () }},
        meshes: {{ "leaf": Leaf(length_m: 0.1, width_m: 0.06, curl_deg: 30.0), "crown": Sphere(radius_m: 0.5) }},
        objects: {{ "tree": (mesh: "crown", translation_m: (0.0, 3.0, 0.0)), {objects} }},
        fall: {{ "autumn": (count: 12, seed: 8, release_s: (0.0, 2.0), species: [(meshes: ["leaf"], length_m: (0.06, 0.1))],
            motion: (flutter: 1.0, tumble: 1.0, helical: 1.0), {fields}) }})"#
    )
}

const FROM_A_BOX: &str = "emitter: Box(min_m: (-1.0, 2.0, -1.0), max_m: (1.0, 3.0, 1.0))";

fn scene_of(objects: &str, fields: &str) -> Scene {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.ron");
    std::fs::write(&path, scene_file(objects, fields)).unwrap();
    resolved(&path).0
}

/// Where the middle of every leaf is, by name.
fn leaves(scene: &Scene, time_s: f64) -> Vec<(String, DVec3, bool)> {
    let placements = scene.placements(time_s);
    let leaves = scene.instances.iter().filter(|instance| scene.meshes[instance.mesh].name == "leaf");
    leaves
        .map(|leaf| {
            let positions = &scene.meshes[leaf.mesh].positions;
            let low = positions.iter().copied().reduce(|a, b| a.min(b)).unwrap();
            let high = positions.iter().copied().reduce(|a, b| a.max(b)).unwrap();
            let placement = placements[leaf.node];
            let middle = placement.world_from_node.transform_point3((0.5 * (low + high)).as_dvec3());
            (scene.nodes[leaf.node].name.clone(), middle, placement.visible)
        })
        .collect()
}

#[test]
fn frames_and_frame_rates_do_not_change_the_leaves() {
    let folder = tempfile::tempdir().unwrap();
    let keyed = "Keyed(keys: [(at_s: 0.5, value: (0.0, 0.0, 0.0)), (at_s: 1.7, value: (2.0, 0.0, 0.5))])";
    let speed = "Keyed(extend: Cycle, keys: [(at_s: 0.0, value: 1.0), (at_s: 1.3, value: 2.0)])";
    let fields = format!("{FROM_A_BOX}, speed: {speed}, wind: (mean_m_per_s: {keyed}, eddy_m_per_s: 0.4)");
    std::fs::write(folder.path().join("scene.ron"), scene_file("", &fields)).unwrap();
    let sequence = |name: &str, fields: &str| {
        let path = folder.path().join(name);
        std::fs::write(&path, format!("Sequence(version: 1, scene: \"scene.ron\", {fields})")).unwrap();
        resolved(&path).0
    };
    let slow = sequence("slow.ron", "frames: (1, 48), frame_rate: 24");
    let fast = sequence("fast.ron", "frames: (60, 61), frame_rate: 60");
    for second in 0..8 {
        assert_eq!(leaves(&slow, f64::from(second)), leaves(&fast, f64::from(second)));
    }
}

#[test]
fn leaves_hang_on_the_surface_of_an_object() {
    let scene = scene_of("", "emitter: Surface(object: \"tree\")");
    for (name, middle, visible) in leaves(&scene, -1.0) {
        let radius = (middle - DVec3::Y * 3.0).length();
        assert!((0.49..=0.5001).contains(&radius) && visible, "{name} {radius}");
    }
    // And all of them lie on the ground in the end.
    assert!(leaves(&scene, 100.0).iter().all(|(_, middle, _)| (0.0..0.05).contains(&middle.y)));
}

#[test]
fn a_trunk_keeps_its_leaves_outside() {
    let trunk = r#""trunk": (mesh: "crown", scale: (1.0, 8.0, 1.0)), "#;
    let blown = format!("{FROM_A_BOX}, wind: (mean_m_per_s: (2.0, 0.0, 0.5), eddy_m_per_s: 0.5)");
    // 1 on the surface of the spheroid, less within.
    let least = |scene: &Scene| {
        let moments = (0..200).map(|moment| 0.1 * f64::from(moment));
        let places = moments.flat_map(|time_s| leaves(scene, time_s));
        places
            .map(|(_, middle, _)| (middle / DVec3::new(0.5, 4.0, 0.5)).length())
            .fold(f64::INFINITY, f64::min)
    };
    // Let go beside it, and blown against it.
    let beside = blown.replace("(1.0, 3.0, 1.0)", "(-0.6, 3.0, 1.0)");
    assert!(least(&scene_of(trunk, &beside)) < 0.8);
    let stopped = scene_of(trunk, &format!(r#"{beside}, obstacles: ["trunk"]"#));
    let least = least(&stopped);
    assert!(least > 1.0, "{least}");
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.ron");
    std::fs::write(&path, scene_file("", &format!(r#"{FROM_A_BOX}, obstacles: ["tree", "house"]"#))).unwrap();
    let said = scene::resolve(description::load(&path).unwrap(), None).unwrap_err().to_string();
    assert!(said.contains("fall.autumn.obstacles[1]") && said.contains("house"), "{said}");
}

#[test]
fn leaves_that_are_not_attached_are_not_there_before() {
    let scene = scene_of("", &format!("{FROM_A_BOX}, attached: false"));
    assert!(leaves(&scene, -0.5).iter().all(|(_, _, visible)| !visible));
    assert!(leaves(&scene, 2.5).iter().all(|(_, _, visible)| *visible));
    let some = leaves(&scene, 1.0).iter().filter(|(_, _, visible)| *visible).count();
    assert!(0 < some && some < 12);
}

#[test]
fn an_object_of_a_leafs_name_takes_its_place() {
    let keys = "Keyed(keys: [(at_s: 0.0, value: (5.0, 1.0, 0.0)), (at_s: 1.0, value: (6.0, 1.0, 0.0))])";
    let objects = format!(
        "\"autumn.3\": (translation_m: {keys}), \"autumn.5\": (mesh: \"crown\", translation_m: (9.0, 0.0, 0.0)),"
    );
    let (keyed, free) = (scene_of(&objects, FROM_A_BOX), scene_of("", FROM_A_BOX));
    let (keyed_leaves, free_leaves) = (leaves(&keyed, 0.5), leaves(&free, 0.5));
    assert_eq!((keyed_leaves.len(), free_leaves.len()), (11, 12));
    for (name, middle, _) in &keyed_leaves {
        let free = free_leaves.iter().find(|(other, _, _)| other == name).unwrap();
        if name == "autumn.3" {
            assert!((*middle - DVec3::new(5.5, 1.0, 0.0)).length() < 0.05, "{middle}");
        } else {
            assert_eq!(*middle, free.1, "{name}");
        }
    }
    assert!(!keyed_leaves.iter().any(|(name, _, _)| name == "autumn.5"));
}

#[test]
fn leaves_fall_the_same_way_through_gltf() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.ron");
    std::fs::write(&path, scene_file("", &format!("{FROM_A_BOX}, attached: false"))).unwrap();
    let (scene, settings) = resolved(&path);
    let settings = RenderSettings { frames: 1..=120, ..settings };
    let exported = export::glb(&scene, &settings, Path::new("")).unwrap();
    assert!(exported.remarks.0.is_empty(), "{}", exported.remarks);
    let path = folder.path().join("scene.glb");
    std::fs::write(&path, [exported.head, exported.binary].concat()).unwrap();
    let (again, _) = resolved(&path);
    // Not only at frames: the curves themselves are carried.
    for moment in 5..480 {
        let time_s = f64::from(moment) / 96.0;
        for ((name, middle, visible), (_, again, visible_again)) in
            leaves(&scene, time_s).into_iter().zip(leaves(&again, time_s))
        {
            assert!((middle - again).length() < 1e-5, "{name} at {time_s} s: {middle} {again}");
            assert_eq!(visible, visible_again, "{name} at {time_s} s");
        }
    }
}

/// Blocks name grounds that meet at x = 0, and leaves of each come down on both: none is in either,
/// on its way or at rest.
#[test]
fn no_leaf_is_below_the_ground_of_another_block() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.ron");
    let block = |name: &str, seed: u32| {
        format!(
            r#""from {name}": (count: 40, seed: {seed}, species: [(meshes: ["leaf"], length_m: (0.06, 0.1))], ground: (object: "{name}"),
                emitter: Box(min_m: (-1.0, 1.0, -0.5), max_m: (1.0, 1.5, 0.5))),"#
        )
    };
    let scene = format!(
        r#"Scene(version: 1, cameras: {{ "main": () }},
            meshes: {{ "leaf": Leaf(length_m: 0.1, width_m: 0.06), "piece": Quad(size_m: 10.0) }},
            objects: {{ "meadow": (mesh: "piece", translation_m: (-5.0, 0.1, 0.0)), "path": (mesh: "piece", translation_m: (5.0, 0.13, 0.0)) }},
            fall: {{ {} {} }})"#,
        block("meadow", 3),
        block("path", 4)
    );
    std::fs::write(&path, scene).unwrap();
    let scene = resolved(&path).0;
    let falling = || scene.instances.iter().filter(|instance| scene.meshes[instance.mesh].name == "leaf");
    let mut lie = [[0; 2]; 2];
    for moment in (0..240).chain([10_000]) {
        let placements = scene.placements(f64::from(moment) / 24.0);
        for leaf in falling() {
            let world_from_leaf = placements[leaf.node].world_from_node;
            let name = &scene.nodes[leaf.node].name;
            for vertex in &scene.meshes[leaf.mesh].positions {
                let point = world_from_leaf.transform_point3(vertex.as_dvec3());
                let ground_m = if point.x < 0.0 { 0.1 } else { 0.13 };
                // A curve keeps to a third of 1 % of the leaf's length.
                assert!(point.y > ground_m - 4e-4, "{name} at frame {moment}: {point}");
            }
            if moment == 10_000 {
                let middle = world_from_leaf.translation;
                assert!(middle.y < 0.2, "{name} lies at {middle}");
                lie[usize::from(name.starts_with("from path"))][usize::from(middle.x > 0.0)] += 1;
            }
        }
    }
    assert!(lie.iter().flatten().all(|&count| count > 5), "{lie:?}");
}

#[test]
fn leaves_that_never_land_are_remarked_upon() {
    let scene = scene_of("", "emitter: Box(min_m: (0.0, 150.0, 0.0), max_m: (0.0, 151.0, 0.0))");
    assert!(
        scene.remarks.to_string().contains("fall.autumn: warning[leaves-in-the-air]: "),
        "{}",
        scene.remarks
    );
}

#[test]
fn a_folder_of_bakes_changes_no_leaf_even_if_it_is_damaged() {
    let folder = tempfile::tempdir().unwrap();
    let (scene, bakes) = (folder.path().join("scene.ron"), folder.path().join("bakes"));
    let low = "emitter: Box(min_m: (-1.0, 0.2, -1.0), max_m: (1.0, 0.3, 1.0))";
    std::fs::write(&scene, scene_file("", low).replace("count: 12", "count: 1000")).unwrap();
    let inspect = |cache: &Path| {
        let mut command = std::process::Command::new(checkout::program());
        let command = command.arg("inspect").arg(&scene).args(["--json", "--frames", "12", "--bake-cache"]);
        let output = command.arg(cache).output().unwrap();
        assert!(output.status.success() && output.stderr.is_empty(), "{output:?}");
        output.stdout
    };
    let without = inspect(Path::new("off"));
    assert!(!bakes.exists());
    assert_eq!(inspect(&bakes), without);
    let files: Vec<_> = std::fs::read_dir(&bakes).unwrap().map(|entry| entry.unwrap().path()).collect();
    let [file] = &files[..] else { panic!("{files:?}") };
    assert_eq!(inspect(&bakes), without);
    let whole = std::fs::read(file).unwrap();
    let mut damaged = whole.clone();
    damaged[whole.len() / 2] ^= 16;
    for rubbish in [&damaged[..], &whole[..100], b"", b"rubbish"] {
        std::fs::write(file, rubbish).unwrap();
        assert_eq!(inspect(&bakes), without);
        // And mended.
        assert_eq!(std::fs::read(file).unwrap(), whole);
    }
    // A folder that cannot be one is done without.
    assert_eq!(inspect(&scene), without);
}

/// Who mends the first block is not to learn of the second afterwards.
#[test]
fn a_ground_that_is_none_is_told_of_each_block_that_names_it() {
    let block = r#"(count: 1, species: [(meshes: ["leaf"], length_m: 0.1)], ground: (object: "maedow"),
        emitter: Box(min_m: (0.0, 1.0, 0.0), max_m: (1.0, 2.0, 1.0)))"#;
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.ron");
    let scene = format!(
        r#"Scene(version: 1, cameras: {{ "main": () }}, meshes: {{ "leaf": Leaf(length_m: 0.1, width_m: 0.06) }},
            fall: {{ "ash": {block}, "birch": {block} }})"#
    );
    std::fs::write(&path, scene).unwrap();
    let told = scene::resolve(description::load(&path).unwrap(), None).unwrap_err().to_string();
    for name in ["ash", "birch"] {
        assert_eq!(told.matches(&format!("fall.{name}.ground.object")).count(), 1, "{told}");
    }
}

/// Two keys of one value.
fn twice(value: &str) -> String {
    format!("Keyed(keys: [(at_s: 0.0, value: {value}), (at_s: 3.0, value: {value})])")
}

#[test]
fn keys_that_say_the_same_are_a_plain_value() {
    let of = |speed: &str, mean: &str, gust: &str, eddy: &str| {
        let wind = format!("mean_m_per_s: {mean}, gust_m_per_s: {gust}, eddy_m_per_s: {eddy}");
        scene_of("", &format!("{FROM_A_BOX}, speed: {speed}, wind: ({wind})"))
    };
    let (mean, gust) = ("(0.5, 0.0, 0.1)", "(0.4, 0.1, 0.0)");
    let plain = of("2.0", mean, gust, "0.0");
    let keyed = of(&twice("2.0"), &twice(mean), &twice(gust), &twice("0.0"));
    let moments = (0..48).map(|moment| f64::from(moment) / 8.0);
    assert!(moments.clone().all(|time_s| leaves(&plain, time_s) == leaves(&keyed, time_s)));
    // What the wind carries past is a sum of its keys, the same but for the rounding of sums.
    let (plain, keyed) = (of("1.0", mean, gust, "0.3"), of("1.0", &twice(mean), gust, &twice("0.3")));
    for (one, other) in
        moments.flat_map(|time_s| leaves(&plain, time_s).into_iter().zip(leaves(&keyed, time_s)))
    {
        assert!((one.1 - other.1).length() < 1e-3, "{one:?} {other:?}");
    }
}

#[test]
fn a_fall_that_comes_later_is_the_same_fall() {
    let of = |from_s: f64| {
        let key = |at_s: f64, value: &str| format!("(at_s: {:?}, value: {value})", from_s + at_s);
        let mean = [key(0.0, "(0.0, 0.0, 0.0)"), key(1.5, "(2.0, 0.0, 0.0)"), key(2.5, "(0.0, 0.0, 1.0)")];
        let speed = [key(0.5, "1.0"), key(2.0, "2.5")];
        let keys = |keys: &[String]| format!("Keyed(keys: [{}])", keys.join(", "));
        let (mean, speed) = (keys(&mean), keys(&speed));
        let fields = format!("{FROM_A_BOX}, speed: {speed}, wind: (mean_m_per_s: {mean}, eddy_m_per_s: 0.0)");
        let text = scene_file("", &fields)
            .replace("release_s: (0.0, 2.0)", &format!("release_s: ({from_s:?}, {:?})", from_s + 2.0));
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("scene.ron");
        std::fs::write(&path, text).unwrap();
        resolved(&path).0
    };
    let (soon, late) = (of(0.0), of(16.0));
    for time_s in (0..48).map(|moment| f64::from(moment) / 8.0) {
        for (one, other) in leaves(&soon, time_s).iter().zip(&leaves(&late, 16.0 + time_s)) {
            assert!((one.1 - other.1).length() < 1e-5, "{time_s} s: {one:?} {other:?}");
        }
    }
}

/// Level leaves that fall for long, in keys of wind and speed.
fn sinking(speed: &str, mean: &str) -> Scene {
    let fields =
        format!("{FROM_A_BOX}, ground: (height_m: -40.0), speed: {speed}, wind: (mean_m_per_s: {mean})");
    let text = scene_file("", &fields)
        .replace("motion: (flutter: 1.0, tumble: 1.0, helical: 1.0)", "motion: (steady: 1.0)")
        .replace("release_s: (0.0, 2.0)", "release_s: 0.0");
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.ron");
    std::fs::write(&path, text).unwrap();
    resolved(&path).0
}

/// From a time on by so many seconds.
fn moved(scene: &Scene, from_s: f64, seconds: f64) -> Vec<DVec3> {
    let ways = leaves(scene, from_s).into_iter().zip(leaves(scene, from_s + seconds));
    ways.map(|((_, from, _), (_, to, _))| to - from).collect()
}

#[test]
fn wind_that_begins_carries_leaves_from_then_on() {
    let begins = "Keyed(keys: [(at_s: 0.0, value: (0.0, 0.0, 0.0), to_next: Step), (at_s: 4.0, value: (1.5, 0.0, 0.0))])";
    let (calm, windy) = (sinking("1.0", "(0.0, 0.0, 0.0)"), sinking("1.0", begins));
    for (calm, windy) in moved(&calm, 0.0, 3.9).iter().zip(&moved(&windy, 0.0, 3.9)) {
        assert!((*calm - *windy).length() < 1e-3, "{calm} {windy}");
    }
    for (calm, windy) in moved(&calm, 8.0, 4.0).iter().zip(&moved(&windy, 8.0, 4.0)) {
        let carried = (*windy - *calm) / 4.0;
        assert!((carried - DVec3::new(1.5, 0.0, 0.0)).length() < 0.1, "{carried}");
    }
}

#[test]
fn leaves_sink_as_fast_as_keys_of_their_speed_say() {
    let faster = "Keyed(keys: [(at_s: 0.0, value: 1.0, to_next: Step), (at_s: 6.0, value: 2.0)])";
    let scenes = ["1.0", "2.0", faster].map(|speed| sinking(speed, "(0.0, 0.0, 0.0)"));
    let sinks = |scene: &Scene, from_s: f64| {
        let ways = moved(scene, from_s, 2.0);
        -ways.iter().map(|way| way.y).sum::<f64>() / ways.len() as f64 / 2.0
    };
    let [slow, fast, keyed] = scenes.each_ref().map(|scene| (sinks(scene, 3.0), sinks(scene, 8.0)));
    assert!((fast.1 / slow.1 - 2.0).abs() < 0.1, "{fast:?} {slow:?}");
    assert!((keyed.0 / slow.0 - 1.0).abs() < 0.02 && (keyed.1 / fast.1 - 1.0).abs() < 0.02, "{keyed:?}");
}
