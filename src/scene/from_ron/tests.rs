//! Tests of small scenes in RON, resolved.

use super::*;
use crate::color::Rgb;
use crate::description::Files;
use crate::scene::{Extend, RayVisibility, Segment};
use glam::DVec3;

fn resolved(fields: &str) -> Scene {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.ron");
    std::fs::write(&path, format!("Scene(version: 1, cameras: {{ \"main\": () }}, {fields})")).unwrap();
    let loaded = ron::load_scene(&path, &mut Files::default()).unwrap();
    resolve(loaded, FrameRate::default(), &Baking::ALONE).unwrap().0
}

const LEAF: &str = r#"meshes: { "leaf": Leaf(length_m: 0.1, width_m: 0.05) },"#;

fn leaves(count: u32) -> Scene {
    resolved(&format!(
        r#"{LEAF} leaves: {{ "fall": (count: {count}, seed: 5, meshes: ["leaf"], min_m: (-1.0, 1.0, 2.0),
        max_m: (1.0, 3.0, 5.0), scale: (0.5, 2.0)) }}"#
    ))
}

#[test]
fn parents_come_before_their_children_whatever_the_order_in_the_file() {
    let scene = resolved(
        r#"objects: { "c": (parent: "b", translation_m: (1.0, 0.0, 0.0)), "b": (parent: "a", scale: 2.0),
        "a": (rotation_deg: (0.0, 0.0, 90.0)) }"#,
    );
    let names: Vec<_> = scene.nodes.iter().map(|node| node.name.as_str()).take(3).collect();
    assert_eq!(names, ["a", "b", "c"]);
    let origin = scene.placements(0.0)[2].world_from_node.translation;
    assert!((origin - DVec3::new(0.0, 2.0, 0.0)).length() < 1e-12, "{origin}");
}

#[test]
fn light_comes_through_in_the_colours_of_its_own_texture_or_of_the_other() {
    let folder = tempfile::tempdir().unwrap();
    for (name, color) in [("red.ppm", "255 0 0"), ("green.ppm", "0 255 0")] {
        std::fs::write(folder.path().join(name), format!("P3 1 1 255 {color}\n")).unwrap();
    }
    let path = folder.path().join("scene.ron");
    let text = format!(
        r#"Scene(version: 1, cameras: {{ "main": () }}, {LEAF} materials: {{
        "both": (texture: "red.ppm", base_color: 0.5, transmission: 0.5, transmission_texture: "green.ppm"),
        "one": (texture: "red.ppm", base_color: 0.5, transmission: 0.5) }},
        objects: {{ "a": (mesh: "leaf", material: "both"), "b": (mesh: "leaf", material: "one") }})"#
    );
    std::fs::write(&path, text).unwrap();
    let scene =
        resolve(ron::load_scene(&path, &mut Files::default()).unwrap(), FrameRate::default(), &Baking::ALONE)
            .unwrap()
            .0;
    let colors = ["both", "one"].map(|name| {
        let material = scene.materials.iter().find(|material| material.name == name).unwrap();
        let maps = [material.base_color_texture, material.transmission_texture.map(|map| map.texture)];
        maps.map(|texture| scene.textures[texture.unwrap()].texels.get(0))
    });
    let (red, green) = ([1.0, 0.0, 0.0, 1.0], [0.0, 1.0, 0.0, 1.0]);
    assert_eq!(colors, [[red, green], [red, red]]);
}

#[test]
fn leaves_lie_in_their_box_with_ids_from_one() {
    let scene = leaves(200);
    assert_eq!(scene.instances.iter().map(|leaf| leaf.leaf_id).collect::<Vec<_>>(), Vec::from_iter(1..=200));
    for leaf in &scene.instances {
        let Motion::Still(place) = scene.nodes[leaf.node].motion else { panic!("it moves") };
        let (low, high) = (DVec3::new(-1.0, 1.0, 2.0), DVec3::new(1.0, 3.0, 5.0));
        assert!(place.translation.cmpge(low).all() && place.translation.cmple(high).all());
        let scale = place.matrix3.determinant().cbrt();
        assert!((0.5..=2.0).contains(&scale), "{scale}");
    }
}

#[test]
fn leaves_on_an_object_touch_it_and_droop() {
    let scene = resolved(&format!(
        r#"{LEAF} objects: {{ "twig": (mesh: "leaf", translation_m: (0.0, 5.0, 0.0)) }}, leaves: {{ "crown": (count: 100,
        on: "twig", meshes: ["leaf"], droop_deg: (20.0, 60.0), roll_deg: (-10.0, 10.0)) }}"#
    ));
    let low = scene.meshes[0].positions.iter().fold(DVec3::MAX, |low, p| low.min(p.as_dvec3()));
    let high = scene.meshes[0].positions.iter().fold(DVec3::MIN, |high, p| high.max(p.as_dvec3()));
    for leaf in &scene.instances[1..] {
        let Motion::Still(place) = scene.nodes[leaf.node].motion else { panic!("it moves") };
        assert_eq!(scene.nodes[leaf.node].parent, Some(0));
        assert!(place.translation.cmpge(low - 1e-9).all() && place.translation.cmple(high + 1e-9).all());
        let (tip, upper_side) = (place.transform_vector3(DVec3::NEG_Z), place.transform_vector3(DVec3::Y));
        let droop = (-tip.y).asin().to_degrees();
        assert!((20.0..=60.0).contains(&droop), "{droop}");
        assert!(upper_side.y >= 60_f64.to_radians().cos() * 10_f64.to_radians().cos() - 1e-9, "{upper_side}");
    }
}

#[test]
fn more_leaves_leave_the_others_where_they_are() {
    let (few, many) = (leaves(10), leaves(1000));
    assert_eq!(format!("{:?}", few.nodes[..10].to_vec()), format!("{:?}", many.nodes[..10].to_vec()));
}

#[test]
fn keys_keep_every_digit_and_become_radians() {
    let scene = resolved(
        r#"objects: { "a": (rotation_deg: Keyed(extend: Cycle, keys: [
        (at_s: 0.1, value: (180, 0.0, 0.0), to_next: Hermite(leave_per_s: (90.0, 0.0, 0.0), arrive_per_s: (0.0, 0.0, 0.0))),
        (at_s: 0.3, value: (0.0, 0.0, 0.0))])) }"#,
    );
    let Motion::Keyed { rotation: super::super::Rotation::EulerXyz(track), .. } = &scene.nodes[0].motion
    else {
        panic!("not keyed")
    };
    assert_eq!(track.extend(), Extend::Cycle);
    assert_eq!(track.keys()[0].time_s.to_bits(), 0.1_f64.to_bits());
    assert!((track.keys()[0].value.x - std::f64::consts::PI).abs() < 1e-15);
    let Segment::Hermite { leave, .. } = track.keys()[0].to_next else { panic!("not a cubic") };
    assert!((leave.x - std::f64::consts::FRAC_PI_2).abs() < 1e-15);
}

#[test]
fn the_sun_shines_the_same_way_however_it_is_written() {
    for sun in ["direction: (1.0, -2.0, 0.5)", "to_sun: (-1.0, 2.0, -0.5)"] {
        let scene = resolved(&format!(r#"lights: {{ "sun": Sun({sun}, irradiance_w_per_m2: 1.0) }}"#));
        let world_from_light = scene.nodes[scene.lights[0].node].motion.parent_from_node(0.0);
        let shines = world_from_light.transform_vector3(DVec3::NEG_Z);
        assert!((shines - DVec3::new(1.0, -2.0, 0.5).normalize()).length() < 1e-12);
    }
}

#[test]
fn fog_fills_its_box() {
    let scene =
        resolved(r#"fog: { "haze": (min_m: (0.0, 1.0, 2.0), max_m: (4.0, 3.0, 8.0), density_per_m: 0.1) }"#);
    let world_from_cube = scene.nodes[scene.fogs[0].node].motion.parent_from_node(0.0);
    assert_eq!(world_from_cube.transform_point3(DVec3::NEG_ONE), DVec3::new(0.0, 1.0, 2.0));
    assert_eq!(world_from_cube.transform_point3(DVec3::ONE), DVec3::new(4.0, 3.0, 8.0));
}

#[test]
fn what_nothing_shows_is_not_read() {
    let scene = resolved(
        r#"meshes: { "gone": Obj("gone.obj") }, materials: { "lost": (texture: "lost.png") },
        objects: { "hidden": (mesh: "gone", material: "lost", visible: false) }"#,
    );
    assert!(scene.meshes.is_empty() && scene.textures.is_empty() && scene.instances.is_empty());
    assert!(scene.remarks.0.iter().any(|remark| remark.to_string().contains("meshes.gone")));
}

#[test]
fn scenes_are_called_like_their_file_or_folder() {
    assert_eq!(name_of(Path::new("scenes/first_leaf/scene.ron")), "first_leaf");
    assert_eq!(name_of(Path::new("scenes/birch.ron")), "birch");
    assert_eq!(name_of(Path::new("scene.ron")), "scene");
}

/// Writes an OBJ with a leaf and a twig, and resolves a scene with it.
fn with_tree(scene: &str) -> Result<Scene, String> {
    let folder = tempfile::tempdir().unwrap();
    let obj = "mtllib tree.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl leaf\nf 1 2 3\nusemtl bark\nf 3 2 1\n";
    let mtl = "newmtl leaf\nKd 0.1 0.5 0.1\nnewmtl bark\nKd 0.2 0.1 0.1\n";
    let file = format!("Scene(version: 1, cameras: {{ \"main\": () }}, {scene})");
    for (name, text) in [("tree.obj", obj), ("tree.mtl", mtl), ("scene.ron", &file)] {
        std::fs::write(folder.path().join(name), text).unwrap();
    }
    let loaded = ron::load_scene(&folder.path().join("scene.ron"), &mut Files::default());
    resolve(loaded.map_err(|error| error.diagnostics().to_string())?, FrameRate::default(), &Baking::ALONE)
        .map(|(scene, _)| scene)
        .map_err(|problems| problems.to_string())
}

#[test]
fn materials_of_an_obj_file_give_way_by_name() {
    let rest = r#"materials: { "green": (base_color: 0.4, transmission: (0.1, 0.3, 0.05)) }, objects: { "tree": (mesh: "tree") }"#;
    let tree = |names: &str| {
        format!(r#"meshes: {{ "tree": ObjWith(file: "tree.obj", materials: {names}) }}, {rest}"#)
    };
    let scene = with_tree(&tree(r#"{ "leaf": "green" }"#)).unwrap();
    let triangles = scene.meshes[0].triangles.iter();
    let names: Vec<_> = triangles.map(|triangle| &scene.materials[triangle.material].name).collect();
    assert_eq!(names, ["green", "bark"]);
    for (names, word) in [(r#"{ "leaves": "green" }"#, "`leaf`"), (r#"{ "leaf": "grean" }"#, "`green`")] {
        let said = with_tree(&tree(names)).unwrap_err();
        assert!(said.contains("meshes.tree.materials") && said.contains(word), "{said}");
    }
}

#[test]
fn materials_of_an_obj_file_may_be_written_in_their_place() {
    let rest = r#"materials: { "green": (base_color: 0.4) }, objects: { "tree": (mesh: "tree"), "other": (mesh: "other") }"#;
    let scene = |leaf: &str| {
        let tree = format!(r#"ObjWith(file: "tree.obj", materials: {{ "leaf": {leaf}, "bark": "green" }})"#);
        with_tree(&format!(r#"meshes: {{ "tree": {tree}, "other": Obj("tree.obj") }}, {rest}"#))
    };
    let leaf = |text: &str| {
        let scene = scene(text).unwrap();
        let materials = |mesh: usize| {
            let triangles = scene.meshes[mesh].triangles.iter();
            triangles.map(|triangle| scene.materials[triangle.material].clone()).collect::<Vec<_>>()
        };
        assert_eq!(materials(0)[1].name, "green");
        assert_eq!((materials(1)[0].transmission, materials(1)[1].name.as_str()), (Rgb::ZERO, "bark"));
        materials(0)[0].clone()
    };
    // What it leaves out is as the file has it.
    let lets_through = leaf("(transmission: (0.2, 0.3, 0.1))");
    assert_eq!(lets_through.name, "leaf");
    assert!((lets_through.base_color - Rgb::new(0.1, 0.5, 0.1)).length() < 1e-6);
    assert_eq!(lets_through.transmission, Rgb::new(0.2, 0.3, 0.1));
    let shines =
        leaf("(base_color: (0.5, 0.4, 0.1), roughness: 0.3, opacity: 0.5, emission_w_per_m2_sr: 2.0)");
    assert_eq!(shines.base_color, Rgb::new(0.5, 0.4, 0.1));
    assert_eq!(
        (shines.coat.unwrap().roughness, shines.opacity, shines.emission),
        (0.3, 0.5, Rgb::splat(2.0))
    );
    assert_eq!(leaf("()").base_color, lets_through.base_color);
    let place = "meshes.tree.materials.leaf";
    for (leaf, place, word) in [
        ("(transmission: 0.6)", place, "more light"),
        ("(metallic: 1.0)", "meshes.tree.materials.leaf.metallic", "roughness"),
        ("(alpha_cutoff: 0.5)", place, "alpha_cutoff"),
        (r#"(texture: "gone.png")"#, "meshes.tree.materials.leaf.texture", "gone.png"),
    ] {
        let said = scene(leaf).unwrap_err();
        assert!(said.contains(place) && said.contains(word), "{leaf}: {said}");
    }
}

#[test]
fn each_leaf_of_a_block_has_a_tint_in_between() {
    let block = |more: &str| {
        format!(
            r#"{LEAF} materials: {{ "grey": (base_color: 0.5, transmission: 0.25) }}, leaves: {{ "crown":
            (count: 300, seed: 5, meshes: ["leaf"], materials: ["grey"], min_m: (0.0, 0.0, 0.0), max_m: (1.0, 1.0, 1.0){more}) }}"#
        )
    };
    let (plain, tinted) =
        (resolved(&block("")), resolved(&block(", tint: [(1.0, 0.0, 0.0), (0.0, 1.0, 0.0)]")));
    let of = |scene: &Scene, leaf: usize| scene.materials[scene.instances[leaf].material.unwrap()].base_color;
    let tints: Vec<_> = (0..300).map(|leaf| of(&tinted, leaf)).collect();
    assert!(tints.iter().all(|tint| (tint.x + tint.y - 0.5).abs() < 1e-12 && tint.z == 0.0));
    let mean = tints.iter().map(|tint| tint.x).sum::<f64>() / 300.0;
    assert!((mean - 0.25).abs() < 0.03, "{mean}");
    assert!((0..300).all(|leaf| of(&plain, leaf) == Rgb::splat(0.5)));
    assert_eq!(plain.placements(0.0)[299].world_from_node, tinted.placements(0.0)[299].world_from_node);
}

#[test]
fn leaves_of_blocks_are_seen_as_objects_are() {
    let rays = "visible_to_camera: false, casts_shadow: false, holdout: true";
    let scene = resolved(&format!(
        r#"{LEAF} leaves: {{ "crown": (count: 2, meshes: ["leaf"], min_m: (0.0, 0.0, 0.0), max_m: (1.0, 1.0, 1.0),
        {rays}) }}, fall: {{ "shower": (count: 2, species: [(meshes: ["leaf"], length_m: 0.1)],
        emitter: Box(min_m: (0.0, 1.0, 0.0), max_m: (1.0, 2.0, 1.0)), {rays}) }}"#
    ));
    let expected = RayVisibility { visible_to_camera: false, casts_shadow: false, holdout: true };
    assert_eq!(scene.instances.len(), 4);
    for instance in &scene.instances {
        assert_eq!(scene.ray_visibility.get(&instance.node), Some(&expected));
    }
}
