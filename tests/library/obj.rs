//! OBJ and MTL files as exporters write them: what is seen of them, and what is said to be lost.

use crate::checkout;
use crate::common::{EXACT, look};
use std::path::{Path, PathBuf};
use sunfleck::color::{Rgb, linear_from_srgb};
use sunfleck::description;
use sunfleck::scene::{self, AlphaMode, Material, Scene};

/// Reflectance of what nobody gave a material.
const GREY: [f64; 3] = [0.8; 3];
const RED: [f64; 3] = [1.0, 0.0, 0.0];
const GREEN: [f64; 3] = [0.0, 1.0, 0.0];
const BLUE: [f64; 3] = [0.0, 0.0, 1.0];

/// A square that fills the view, with texture coordinates.
const SQUARE: &str = "v -9 -9 0\nv 9 -9 0\nv 9 9 0\nv -9 9 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n";
const FACE: &str = "f 1/1 2/2 3/3 4/4\n";
const RED_IMAGE: &str = "P3 1 1 255 255 0 0";
const GREEN_IMAGE: &str = "P3 1 1 255 0 255 0";

type Files<'a> = &'a [(&'a str, &'a [u8])];

/// The sun shines along the view, so that a matte surface is as bright as it reflects.
fn scene_text(obj: &str) -> String {
    format!(
        "Scene(version: 1, meshes: {{ \"m\": Obj({obj:?}) }}, objects: {{ \"o\": (mesh: \"m\") }},
        cameras: {{ \"c\": (position_m: (0.0, 0.0, 4.0), look_at_m: (0.0, 0.0, 0.0)) }},
        lights: {{ \"s\": Sun(to_sun: (0.0, 0.0, 1.0), irradiance_w_per_m2: {:?}) }})",
        std::f64::consts::PI
    )
}

fn load(path: &Path) -> Result<Scene, String> {
    let description = description::load(path).map_err(|error| error.diagnostics().to_string())?;
    scene::resolve(description, None).map(|(scene, _)| scene).map_err(|error| error.to_string())
}

/// The scene that shows `a.obj` of some files.
fn shown(files: Files<'_>) -> Result<Scene, String> {
    let folder = tempfile::tempdir().unwrap();
    for (name, bytes) in files {
        let path = folder.path().join(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, bytes).unwrap();
    }
    let scene = folder.path().join("scene.ron");
    std::fs::write(&scene, scene_text("a.obj")).unwrap();
    load(&scene)
}

fn losses(scene: &Scene) -> Vec<&'static str> {
    scene.remarks.losses().map(|(loss, _)| loss.id()).collect()
}

fn seen(scene: &Scene) -> Rgb {
    look(scene, &EXACT, 0.51, 0.47).radiance
}

fn assert_near(found: Rgb, expected: [f64; 3], of: &str) {
    let off = (found - Rgb::from_array(expected)).abs().max_element();
    assert!(off < 1e-3, "{of}: {found} is not {expected:?}");
}

/// The material that the first triangle has.
fn material(scene: &Scene) -> &Material {
    &scene.materials[scene.meshes[0].triangles[0].material]
}

/// A square in a material of its own.
fn with_mtl(mtl: &str) -> Scene {
    let obj = format!("mtllib a.mtl\n{SQUARE}usemtl m\n{FACE}");
    let mtl = format!("newmtl m\n{mtl}");
    shown(&[
        ("a.obj", obj.as_bytes()),
        ("a.mtl", mtl.as_bytes()),
        ("red.ppm", RED_IMAGE.as_bytes()),
        ("half.ppm", b"P3 1 1 255 128 128 128"),
        ("two.ppm", b"P3 2 1 255 255 0 0 0 0 255"),
        ("normal.ppm", b"P3 1 1 255 128 128 255"),
    ])
    .unwrap()
}

/// Whole scenes, each with the colour of its triangle's material and what is said.
#[test]
fn scenes_of_real_exporters_are_drawn() {
    let folder = checkout::file("tests/data/obj");
    let cases: [(&str, [f64; 3], &[&str]); 7] = [
        ("obj_mtl_Ks_one_number", RED, &[]),
        ("obj_mtl_missing", GREY, &["mtl-missing"]),
        // The grey in the texture's place is tinted by `Kd`, as the texture would be.
        ("obj_mtl_missing_texture", [0.8, 0.0, 0.0], &["mtl-texture"]),
        ("obj_mtl_unnamed_newmtl", GREY, &["mtl-unnamed"]),
        ("obj_plus_sign", GREY, &[]),
        ("obj_two_mtllibs_on_one_line", RED, &[]),
        ("obj_vertex_w", GREY, &[]),
    ];
    for (name, color, said) in cases {
        let scene = load(&folder.join(name).with_extension("ron")).unwrap();
        assert_eq!(losses(&scene), said, "{name}");
        assert_near(look(&scene, &EXACT, 0.5, 0.55).surface.unwrap().albedo, color, name);
        let corners = scene.meshes[0].positions.iter().map(|corner| corner.to_array()).collect::<Vec<_>>();
        assert_eq!(corners, [[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [0.0, 1.0, 0.0]], "{name}");
    }
}

/// Ways to write a red square.
#[test]
fn all_ways_to_write_a_file_say_the_same() {
    let plain = format!("mtllib a.mtl\n{SQUARE}usemtl red\n{FACE}");
    let with = |from: &str, to: &str| plain.replace(from, to).into_bytes();
    let mut with_mark = b"\xef\xbb\xbf".to_vec();
    with_mark.extend(&plain.as_bytes()["mtllib a.mtl\n".len()..]);
    with_mark.extend(b"mtllib a.mtl\n");
    let cases: [(&str, Vec<u8>); 22] = [
        ("plain", plain.clone().into_bytes()),
        ("a mark before the first vertex, mtllib last", with_mark),
        ("mtllib after usemtl", with("mtllib a.mtl\n", "").into_iter().chain(*b"mtllib a.mtl\n").collect()),
        ("plus signs", with("v 9 -9 0", "v +9 -9 +0.0e+0")),
        ("numbers with a bare point", with("v 9 -9 0", "v 9. -9. .0")),
        ("weights", with("v 9 -9 0\n", "v 9 -9 0 0.5\n")),
        ("a face on several lines", with(FACE, "f 1/1 \\\n2/2\\\n 3/3 4/4\n")),
        ("a comment after a face", with(FACE, "f 1/1 2/2 3/3 4/4 # the square 5/5\n")),
        ("a comment right after a face", with(FACE, "f 1/1 2/2 3/3 4/4# the square 5/5\n")),
        ("UTF-16 without a mark", plain.encode_utf16().flat_map(u16::to_le_bytes).collect()),
        ("old line ends", with("\n", "\r")),
        ("line ends of Windows", with("\n", "\r\n")),
        ("tabs", with(" ", "\t")),
        ("Latin-1 in a comment", b"# f\xfcr\n".iter().copied().chain(plain.bytes()).collect()),
        ("several libraries", with("mtllib a.mtl", "mtllib b.mtl a.mtl")),
        ("one of several libraries", with("mtllib a.mtl", "mtllib a.mtl # b.mtl")),
        ("backslashes", with("mtllib a.mtl", "mtllib .\\more\\a.mtl")),
        ("a library with spaces", with("mtllib a.mtl", "mtllib more/a b.mtl")),
        ("quotes", with("mtllib a.mtl", "mtllib \"more/a b.mtl\"")),
        ("a comment after a name", with("usemtl red", "usemtl red # it")),
        (
            "a reference to what comes later",
            format!("{FACE}mtllib a.mtl\n{SQUARE}").replace("f ", "usemtl red\nf ").into_bytes(),
        ),
        ("negative indices", with(FACE, "f -4/-4 -3/-3 -2/-2 -1/-1\n")),
    ];
    for (name, obj) in cases {
        let scene = shown(&[
            ("a.obj", obj.as_slice()),
            ("a.mtl", b"newmtl red\nKd 1 0 0\n"),
            ("b.mtl", b"newmtl blue\nKd 0 0 1\n"),
            ("more/a.mtl", b"\xef\xbb\xbfnewmtl red\r\nKd 1 0 0\r\n"),
            ("more/a b.mtl", b"newmtl\tred\rKd\t1\t0\t0\r"),
        ])
        .unwrap_or_else(|error| panic!("{name}: {error}"));
        assert_eq!(losses(&scene), [""; 0], "{name}: {}", scene.remarks);
        assert_near(seen(&scene), RED, name);
        assert_eq!(scene.meshes[0].triangles.len(), 2, "{name}");
    }
}

/// What cannot be is left out, each kind once with its first line; the rest is drawn.
#[test]
fn what_is_wrong_is_left_out_and_said() {
    // Lines 1 to 8 are the square.
    let cases: [(&str, &str, usize, usize); 16] = [
        ("f 0 1 2", "obj-face-index", 9, 1),
        ("f 1 2 5\nf 1 2 9\nf -5 1 2", "obj-face-index", 9, 3),
        ("f 1 2", "obj-thin-face", 9, 1),
        ("f", "obj-thin-face", 9, 1),
        ("f 1 2 x", "obj-numbers", 9, 1),
        ("f 1/1/1/1 2 3", "obj-numbers", 9, 1),
        ("f 1.0 2 3", "obj-numbers", 9, 1),
        ("f 99999999999999999999 2 3", "obj-numbers", 9, 1),
        ("vt what", "obj-numbers", 9, 1),
        ("v 1 2", "obj-numbers", 9, 1),
        ("v 1,5 2 3", "obj-numbers", 9, 1),
        ("l 1 2 3\np 1", "points-and-lines", 9, 2),
        ("curv 0 1 1 2\nbevel on\nbevel off", "obj-statement", 9, 3),
        ("usemtl unheard_of", "obj-material-missing", 9, 1),
        ("f 1/9 2/9 3/9", "obj-texture-coordinates", 9, 1),
        ("f 1//9 2//9 3//9", "obj-normals", 9, 1),
    ];
    for (lines, id, line, count) in cases {
        let scene = shown(&[("a.obj", format!("{SQUARE}{lines}\n{FACE}").as_bytes())]).unwrap();
        let told: Vec<_> = scene.remarks.losses().collect();
        assert_eq!(told.len(), 1, "{lines}: {}", scene.remarks);
        assert_eq!((told[0].0.id(), told[0].1.count), (id, count), "{lines}");
        assert!(told[0].1.to_string().contains(&format!("a.obj:{line}:")), "{lines}: {}", told[0].1);
        assert_near(seen(&scene), GREY, lines);
    }
    for number in ["nan", "-1.#IND", "1e99", "inf"] {
        let obj = format!("{SQUARE}v {number} 0 0\nf 1 2 5\n{FACE}");
        let scene = shown(&[("a.obj", obj.as_bytes())]).unwrap();
        assert_eq!(losses(&scene), ["obj-numbers", "obj-face-vertex"], "{number}");
        assert_eq!(scene.meshes[0].triangles.len(), 2, "{number}");
    }
}

/// A texture beside the OBJ is another one, however it is called.
#[test]
fn textures_are_found_beside_the_mtl() {
    for (line, losses_said, color) in [
        ("map_Kd leaf.ppm", &[][..], GREEN),
        ("map_Kd .\\leaf.ppm", &[], GREEN),
        ("map_Kd deep\\er\\leaf 2.ppm", &[], BLUE),
        ("map_Kd -s 1 1 1 -o 0 0 0 -bm 0.5 -clamp on deep/er/leaf 2.ppm", &[], BLUE),
        ("map_Kd\t-blendu off leaf.ppm", &["mtl-texture-option"], GREEN),
        ("map_Kd only_there.ppm", &["mtl-texture"], GREY),
        ("map_Kd C:\\Users\\me\\only_there.ppm", &["mtl-texture"], GREY),
        ("map_Kd deep", &["mtl-texture"], GREY),
        ("map_Kd broken.ppm", &["mtl-texture"], GREY),
        ("map_Kd", &["mtl-value"], GREY),
        ("map_Kd -s 1 1 1", &["mtl-texture"], GREY),
    ] {
        let scene = shown(&[
            ("a.obj", format!("mtllib materials/a.mtl\n{SQUARE}usemtl m\n{FACE}").as_bytes()),
            ("leaf.ppm", RED_IMAGE.as_bytes()),
            ("only_there.ppm", RED_IMAGE.as_bytes()),
            ("deep/er/leaf 2.ppm", RED_IMAGE.as_bytes()),
            ("materials/a.mtl", format!("newmtl m\n{line}\n").as_bytes()),
            ("materials/leaf.ppm", GREEN_IMAGE.as_bytes()),
            ("materials/deep/er/leaf 2.ppm", b"P3 1 1 255 0 0 255"),
            ("materials/broken.ppm", b"P3 1 1"),
        ])
        .unwrap();
        assert_eq!(losses(&scene), losses_said, "{line}: {}", scene.remarks);
        assert_near(seen(&scene), color, line);
    }
}

#[test]
fn without_texture_coordinates_a_texture_shows_its_corner() {
    let obj = format!("mtllib a.mtl\n{SQUARE}usemtl m\nf 1 2 3 4\n");
    let mtl = b"newmtl m\nmap_Kd two.ppm\n";
    let image = b"P3 2 2 255 0 255 0 0 0 255 0 0 255 0 0 255";
    let scene = shown(&[("a.obj", obj.as_bytes()), ("a.mtl", mtl), ("two.ppm", image)]).unwrap();
    assert_eq!(losses(&scene), ["texture-coordinates-missing"]);
    let looked_up = scene.textures[0].color(glam::Vec2::ZERO);
    assert_near(seen(&scene), looked_up.to_array(), "its corner");
}

/// Numbers of materials, as Blender's importer takes them.
#[test]
fn materials_have_the_numbers_of_the_file() {
    let cases: [(&str, f64, f64, f64); 12] = [
        // metallic, roughness, F0; -1 without a coat.
        ("Kd 1 0 0\nKs 0", -1.0, -1.0, -1.0),
        ("illum 1\nKs 1 1 1\nNs 90", -1.0, -1.0, -1.0),
        ("illum 2\nKs 0.5 0.5 0.5\nNs 250", 0.0, 0.5, 0.04),
        ("Ks 0.5 0.5 0.5\nNs 250\nNi 1.5", 0.0, 0.5, 0.04),
        ("illum 2\nKs 0.5\nNs 1000\nNi 1.0", 0.0, 0.0, 0.04),
        ("illum 2\nKs 0.6 0.9 0\nNs 5000\nNi 3", 0.0, 0.0, 0.25),
        ("illum 2\nKd 1 0 0", -1.0, -1.0, -1.0),
        ("illum 3\nKa 0.25\nKs 0.5\nNs 0", 0.25, 1.0, 0.04),
        ("Pr 0.3\nPm 1", 1.0, 0.3, 0.04),
        ("illum 0\nPr 0.3", 0.0, 0.3, 0.04),
        ("map_Pr half.ppm\nPr 0.1\nPm 0.7", 0.7, 1.0, 0.04),
        ("map_Pr gone.ppm\nPr 0.1\nPm 0.7", 0.7, 0.1, 0.04),
    ];
    for (mtl, metallic, roughness, f0) in cases {
        let scene = with_mtl(mtl);
        let coat = material(&scene).coat.map_or([-1.0; 3], |coat| [coat.metallic, coat.roughness, coat.f0.x]);
        let off = coat.iter().zip([metallic, roughness, f0]).map(|(found, due)| (found - due).abs());
        assert!(off.fold(0.0, f64::max) < 1e-6, "{mtl}: {coat:?}");
    }
    let scene = with_mtl("Pc 0.5\nPcr 0.25\nPs 0\naniso 0\nanisor 0\nsharpness 60\nTf 1 1 1");
    let clearcoat = material(&scene).clearcoat.unwrap();
    assert_eq!((clearcoat.share, clearcoat.roughness), (0.5, 0.25));
    assert_eq!(losses(&scene), [""; 0], "{}", scene.remarks);
}

#[test]
fn emission_opacity_and_normal_maps_are_honoured() {
    assert_near(seen(&with_mtl("Kd 0\nKe 0 0 0.5")), [0.0, 0.0, 0.5], "Ke");
    assert_near(seen(&with_mtl("Kd 0\nKe 3")), [3.0; 3], "Ke of one number");
    assert_near(seen(&with_mtl("Kd 0\nKe 0 0 0\nmap_Ke red.ppm")), RED, "map_Ke alone");
    assert_near(seen(&with_mtl("Kd 0\nmap_Ke gone.ppm")), [0.0; 3], "map_Ke that is not there");
    assert_near(seen(&with_mtl("map_Kd gone.ppm\nmap_Ke gone.ppm")), GREY, "one for both that is not there");
    assert_near(seen(&with_mtl("Kd 0 0 0\nmap_Kd red.ppm")), RED, "a texture in black");
    // Half of the square, and half of the black behind it.
    assert_near(seen(&with_mtl("Kd 1 0 0\nd 0.5")), [0.5, 0.0, 0.0], "d");
    assert_near(seen(&with_mtl("Kd 1 0 0\nTr 0.75")), [0.25, 0.0, 0.0], "Tr");
    assert_near(seen(&with_mtl("Kd 1 0 0\nd 1\nTr 1")), RED, "d before Tr");
    let half = 128.0 / 255.0;
    assert_near(seen(&with_mtl("map_Kd red.ppm\nmap_d half.ppm")), [half, 0.0, 0.0], "map_d");
    assert_near(seen(&with_mtl("Kd 1 0 0\nmap_d half.ppm")), [half, 0.0, 0.0], "map_d without map_Kd");
    assert_eq!(material(&with_mtl("map_Kd red.ppm")).alpha_mode, AlphaMode::Opaque);

    for (mtl, strength) in
        [("norm normal.ppm", 1.0), ("map_Bump -bm 0.5 normal.ppm", 0.5), ("bump normal.ppm", 1.0)]
    {
        let scene = with_mtl(mtl);
        assert_eq!(material(&scene).normal_map.unwrap().1, strength, "{mtl}");
        assert_eq!(scene.meshes[0].tangents.len(), scene.meshes[0].positions.len(), "{mtl}");
    }
    let heights = with_mtl("map_Bump half.ppm");
    assert_eq!(losses(&heights), ["mtl-bump-map"]);
    assert!(material(&heights).normal_map.is_none());
}

#[test]
fn options_place_textures() {
    // The left half is red and the right half blue; the view's middle is at 0.5.
    let at_quarter = |mtl: &str| look(&with_mtl(mtl), &EXACT, 0.5, 0.47).radiance;
    assert_near(at_quarter("map_Kd -s 0.5 1 1 two.ppm"), RED, "a quarter");
    assert_near(at_quarter("map_Kd -o 0.25 0 0 two.ppm"), BLUE, "three quarters");
    assert_near(at_quarter("map_Kd -o 2.5 0 0 -clamp on two.ppm"), BLUE, "beyond the edge");
    let scene = with_mtl("map_Kd -o 0.25 0 0 two.ppm\nmap_Ke two.ppm");
    assert_eq!(losses(&scene), ["mtl-texture-option"]);
}

#[test]
fn colours_of_vertices_are_srgb() {
    let square = "v -9 -9 0 1 0 0.5\nv 9 -9 0 1 0 0.5\nv 9 9 0 1 0 0.5\nv -9 9 0 1 0 0.5\n";
    let scene = shown(&[("a.obj", format!("{square}f 1 2 3 4\n").as_bytes())]).unwrap();
    assert_eq!(losses(&scene), [""; 0]);
    assert_near(seen(&scene), [0.8, 0.0, 0.8 * linear_from_srgb(0.5)], "all");
    let some = square.replacen(" 1 0 0.5", "", 1).replacen(" 1 0 0.5", " 2 0 0", 1);
    let scene = shown(&[("a.obj", format!("{some}f 1 2 3 4\n").as_bytes())]).unwrap();
    assert_eq!(losses(&scene), ["obj-vertex-colors"]);
    assert_eq!(scene.meshes[0].colors[0].to_array(), [1.0; 3]);
    assert_eq!(scene.meshes[0].colors[1].to_array(), [1.0, 0.0, 0.0]);
}

#[test]
fn values_out_of_range_are_put_right_and_said() {
    for (mtl, color) in [
        ("Kd 2 0 0", RED),
        ("Kd 1 -1 0", RED),
        ("Kd nan 0 0", GREY),
        ("Kd much", GREY),
        ("Kd 0.5 0.5", GREY),
        ("d 7\nKd 1 0 0", RED),
        ("illum\nKd 1 0 0", RED),
    ] {
        let scene = with_mtl(mtl);
        assert_eq!(losses(&scene), ["mtl-value"], "{mtl}");
        assert_near(seen(&scene), color, mtl);
    }
    for mtl in ["disp a.png", "map_Ns a.png", "refl -type sphere a.png", "Ps 0.5", "unknown 3", "d -halo 1"] {
        assert_eq!(losses(&with_mtl(mtl)), ["mtl-statement"], "{mtl}");
    }
    assert_eq!(losses(&with_mtl("illum 4\nNi 1.33")), ["mtl-statement"]);
}

#[test]
fn smoothing_groups_are_smooth_where_there_are_no_normals() {
    let roof = "v -1 0 0\nv 0 0 1\nv 1 0 0\nv -1 1 0\nv 0 1 1\nv 1 1 0\n";
    let faces = "f 1 2 5 4\nf 2 3 6 5\n";
    let scene = shown(&[("a.obj", format!("{roof}s 1\n{faces}").as_bytes())]).unwrap();
    let mesh = &scene.meshes[0];
    let ridge = mesh.positions.iter().zip(&mesh.normals).filter(|(position, _)| position.z == 1.0);
    let normals: Vec<_> = ridge.map(|(_, normal)| *normal).collect();
    assert!(
        !normals.is_empty() && normals.iter().all(|normal| normal.abs_diff_eq(glam::Vec3::Z, 1e-6)),
        "{normals:?}"
    );
    for text in
        [format!("{roof}s off\n{faces}"), format!("{roof}{faces}"), format!("{roof}s 1\ns 0\n{faces}")]
    {
        assert!(shown(&[("a.obj", text.as_bytes())]).unwrap().meshes[0].normals.is_empty());
    }
}

/// Faces without normals do not take them from others.
#[test]
fn each_face_has_what_it_says() {
    let obj = format!("{SQUARE}vn 0 0 1\nvn 0 0 0\nf 1//1 2//1 3//1\nf 1/1 3/3 4/4\nf 1//2 2//2 3//2\n");
    let scene = shown(&[("a.obj", obj.as_bytes())]).unwrap();
    assert_eq!(losses(&scene), ["obj-normals"]);
    let mesh = &scene.meshes[0];
    assert_eq!((mesh.normals.len(), mesh.uvs.len()), (mesh.positions.len(), mesh.positions.len()));
    assert!(mesh.normals.iter().all(|normal| *normal == glam::Vec3::Z), "{:?}", mesh.normals);
}

#[test]
fn materials_that_others_replace_need_no_textures() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| -> PathBuf { folder.path().join(name) };
    std::fs::write(path("a.obj"), format!("mtllib a.mtl\n{SQUARE}usemtl m\n{FACE}")).unwrap();
    std::fs::write(path("a.mtl"), "newmtl m\nmap_Kd gone.png\n").unwrap();
    let text = scene_text("a.obj").replace("objects:", "materials: { \"n\": (base_color: 0.5) }, objects:");
    let of_object = text.replace("(mesh: \"m\")", "(mesh: \"m\", material: \"n\")");
    let of_mesh = text.replace("Obj(\"a.obj\")", "ObjWith(file: \"a.obj\", materials: { \"m\": \"n\" })");
    for (text, way) in [(of_object, "the object's"), (of_mesh, "by name")] {
        std::fs::write(path("scene.ron"), text).unwrap();
        let scene = load(&path("scene.ron")).unwrap();
        assert_eq!(losses(&scene), [""; 0], "{way}");
        assert_near(seen(&scene), [0.5; 3], way);
    }
}
