//! Weights and joints of every form, and masks on what bends.

use crate::gltf_made::file::{File, sample, seen, vertices};
use glam::{DAffine3, DVec3};
use serde_json::json;

/// A square whose upper corners a weight moves by (1, 0, 1).
fn morphing() -> File {
    let mut file = File::new();
    let moved = file.floats("VEC3", &[0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 1.0, 1.0, 0.0, 1.0]);
    file.primitive()["targets"] = json!([{ "POSITION": moved }]);
    file
}

#[test]
fn weights_step_and_curve() {
    let mut steps = morphing();
    steps.animate("0 weights", "SCALAR", "STEP", &[0.0, 1.0], &[0.25, -0.5]);
    let mut curves = morphing();
    curves.animate("0 weights", "SCALAR", "CUBICSPLINE", &[0.0, 1.0], &[9.0, 0.0, 2.0, -1.0, 1.0, 9.0]);
    let (steps, curves) = (steps.scene(), curves.scene());
    for (time_s, step) in [(0.0, 0.25), (0.5, 0.25), (0.999, 0.25), (1.0, -0.5), (2.0, -0.5)] {
        // glTF 2.0, appendix C.4, with derivatives 2 and -1.
        let t = f64::min(time_s, 1.0);
        let curve =
            2.0 * (t.powi(3) - 2.0 * t * t + t) + (-2.0 * t.powi(3) + 3.0 * t * t) - (t.powi(3) - t * t);
        for (scene, weight) in [(&steps, step), (&curves, curve)] {
            let expected = DVec3::new(1.0 + weight, 1.0, weight - 3.0);
            assert!((vertices(scene, time_s)[2] - expected).length() < 1e-6, "{time_s} {weight}");
        }
    }
}

/// Six joints a vertex, their shares once as floats, once as whole numbers.
#[test]
fn six_joints_and_weights_as_whole_numbers() {
    let places: Vec<DVec3> = (0..6).map(|joint| DVec3::new(0.1, 0.3, -0.2) * f64::from(joint)).collect();
    let shares: [[u8; 8]; 4] = [
        [51, 51, 51, 51, 51, 0, 0, 0],
        [0, 0, 0, 0, 255, 0, 0, 0],
        [5, 10, 20, 40, 80, 100, 0, 0],
        [0, 0, 0, 0, 0, 255, 0, 0],
    ];
    let made = |component: u32| {
        let mut file = File::new();
        let joints = [[0_u8, 1, 2, 3], [4, 5, 0, 0]];
        for (set, joints) in joints.iter().enumerate() {
            let joints = file.numbers("VEC4", 5121, joints.repeat(4), 4);
            let own = || shares.iter().flat_map(|all| all[4 * set..4 * set + 4].to_vec());
            let weights = match component {
                5121 => file.numbers("VEC4", component, own(), 4),
                5123 => file.numbers(
                    "VEC4",
                    component,
                    own().flat_map(|share| (u16::from(share) * 257).to_le_bytes()),
                    4,
                ),
                _ => file.floats("VEC4", &own().map(|share| f32::from(share) / 255.0).collect::<Vec<_>>()),
            };
            let accessor = &mut file.json["accessors"][weights];
            accessor["normalized"] = json!(component != 5126);
            let attributes = &mut file.primitive()["attributes"];
            (attributes[format!("JOINTS_{set}")], attributes[format!("WEIGHTS_{set}")]) =
                (json!(joints), json!(weights));
        }
        let nodes = file.json["nodes"].as_array_mut().unwrap();
        nodes.extend(places.iter().map(|place| json!({ "translation": place.to_array() })));
        nodes[0]["skin"] = json!(0);
        file.json["scenes"][0]["nodes"] = json!([0, 1, 2, 3, 4, 5, 6, 7, 8]);
        file.json["skins"] = json!([{ "joints": [3, 4, 5, 6, 7, 8] }]);
        vertices(&file.scene(), 0.0)
    };
    let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
    for component in [5121, 5123, 5126] {
        for ((found, corner), shares) in made(component).iter().zip(corners).zip(&shares) {
            let shift: DVec3 =
                shares.iter().zip(&places).map(|(share, place)| f64::from(*share) / 255.0 * *place).sum();
            let expected = DVec3::new(corner.0, corner.1, 0.0) + shift;
            assert!((*found - expected).length() < 1e-6, "{component}: {found} {expected}");
        }
    }
}

/// Cut out and bent is what is seen of the bent card through its mask.
#[test]
fn masks_stay_on_what_bends() {
    let mut file = morphing();
    let texture =
        file.texture(&[[255, 255, 255, 255], [255, 255, 255, 0], [255, 255, 255, 0], [255, 255, 255, 255]]);
    file.json["samplers"] = json!([{ "wrapS": 33071, "wrapT": 33071 }]);
    file.json["textures"][texture]["sampler"] = json!(0);
    file.material()["alphaMode"] = json!("MASK");
    file.material()["pbrMetallicRoughness"]["baseColorTexture"] = json!({ "index": texture });
    file.animate("0 weights", "SCALAR", "LINEAR", &[0.0, 1.0], &[0.0, 1.0]);
    let scene = file.scene();
    for time_s in [0.0, 0.5, 1.0] {
        let bent = DAffine3::from_cols_array_2d(&[
            [1.0, 0.0, 0.0],
            [0.5 * time_s, 1.0, 0.5 * time_s],
            [0.0, 0.0, 1.0],
            [0.5 * time_s, 0.0, 0.5 * time_s - 3.0],
        ]);
        for (u, v) in
            [(0.1, 0.3), (0.2, 0.8), (0.3, 0.5), (0.4, 0.2), (0.6, 0.9), (0.7, 0.4), (0.8, 0.1), (0.93, 0.6)]
        {
            let point = bent.transform_point3(DVec3::new(2.0 * u - 1.0, 2.0 * v - 1.0, 0.0));
            let slope = 0.75_f64.tan();
            let film = (0.5 + 0.5 * point.x / -point.z / slope, 0.5 - 0.5 * point.y / -point.z / slope);
            // Half of alpha lies halfway between the middles of texels, at a quarter and at three.
            let shows = !(0.25..0.75).contains(&u);
            assert_eq!(sample(&scene, time_s, film).surface.is_some(), shows, "{time_s} {u} {v}");
            assert_eq!(seen(&scene, time_s, film).x > 0.0, shows);
        }
    }
}
