//! What a file asks for and does not get is said once a kind, and refused by `--strict`.

use crate::program::{Studio, repository};
use serde_json::Value;

/// Exit code of scenes that cannot be used.
const SCENE: i32 = 3;

/// A file that asks for back faces to be hidden.
fn cards() -> String {
    repository("tests/data/blender/b_leafcards.glb").display().to_string()
}

#[test]
fn inspect_and_statistics_list_losses_by_id() {
    let studio = Studio::new();
    let described: Value =
        serde_json::from_str(&studio.succeed(&format!("inspect {} --json", cards())).out).unwrap();
    let losses = described["losses"].as_array().unwrap();
    let culling = losses.iter().find(|loss| loss["id"] == "backface-culling").unwrap();
    assert!(
        culling["count"].as_u64().unwrap() > 0 && culling["place"].as_str().unwrap().ends_with(".glb"),
        "{culling}"
    );

    studio.succeed(&format!(
        "render {} --size 8x4 --samples 1 --frames 1 --out a/ --stats stats.jsonl",
        cards()
    ));
    let stats = String::from_utf8(studio.bytes("stats.jsonl")).unwrap();
    let first: Value = serde_json::from_str(stats.lines().next().unwrap()).unwrap();
    assert_eq!(&first["losses"], &described["losses"]);
}

#[test]
fn strict_refuses_every_loss_and_writes_nothing() {
    let studio = Studio::new();
    for line in [
        "render CARDS --strict --size 8x4 --samples 1 --out a/",
        "inspect CARDS --strict",
        "preview CARDS --strict --out a/",
        "export CARDS a.glb --strict",
    ] {
        let message = studio.fail(&line.replace("CARDS", &cards()), SCENE);
        assert!(
            message.contains("error[backface-culling]: ") && message.contains("remedy: "),
            "{line}: {message}"
        );
    }
    assert_eq!(studio.names("."), ["scene.ron", "tiny.ron"]);
    studio.succeed("render tiny.ron --strict --frames 1 --out a/");
}

/// What a damaged OBJ file leaves is drawn, unless all is wanted.
#[test]
fn damaged_meshes_are_drawn_with_a_word_and_refused_by_strict() {
    let studio = Studio::new();
    let case = |name: &str| repository(&format!("tests/data/obj/obj_mtl_{name}.ron")).display().to_string();
    for (name, loss) in [("missing", "mtl-missing"), ("missing_texture", "mtl-texture")] {
        let told = studio.succeed(&format!("render {} --size 8x4 --samples 1 --out a/", case(name))).err;
        assert_eq!(told.matches(&format!("warning[{loss}]: ")).count(), 1, "{told}");
        let message =
            studio.fail(&format!("render {} --strict --size 8x4 --samples 1 --out b/", case(name)), SCENE);
        assert!(message.contains(&format!("error[{loss}]: ")) && message.contains("remedy: "), "{message}");
    }
    studio.succeed(&format!("render {} --strict --size 8x4 --samples 1 --out c/", case("Ks_one_number")));
}
