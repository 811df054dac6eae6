//! The samples. What of them is known to be wrong in the file, or lost on the way to it.

use crate::checkout;
use serde_json::Value;
use std::collections::BTreeSet;
use std::path::PathBuf;

/// A file, and what it is compared with.
pub(crate) struct Sample {
    pub(crate) file: &'static str,
    pub(crate) truth: &'static str,
    /// Custom properties that a prepared scene carries and this one lacks: where, and what.
    pub(crate) prepared: &'static [(&'static str, &'static str)],
    /// At least so many values are compared.
    pub(crate) least_compared: usize,
    /// How far light values may be off at whole frames, relative.
    pub(crate) light_bar: f64,
    /// What the exporter is known to write wrongly or not at all.
    pub(crate) known: &'static [Known],
}

/// Still lights are JSON numbers in double precision: Blender's own, times constants that fall out again but
/// for the last bit. Blender itself has single precision.
const EXACT: f64 = f64::EPSILON;
/// Values that change are keys, which glTF has in single precision: what of 683 lm/W times the
/// power was rounded away.
const ROUNDED_ONCE: f64 = f32::EPSILON as f64 / 2.0;

/// Objects that a file is known to have wrong, and why.
pub(crate) struct Known {
    /// By their names; names that end in `*` stand for all that begin so.
    pub(crate) objects: &'static [&'static str],
    pub(crate) what: What,
    pub(crate) reason: &'static str,
}

/// Which values are wrong.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum What {
    /// At any time.
    Always(&'static str),
    /// Between whole frames.
    Between(&'static str),
}

impl Known {
    /// The name under which an object's value is known to be wrong, if it is.
    pub(crate) fn covers(&self, object: &str, value: &str, frame: f64) -> Option<&'static str> {
        let is_meant = match self.what {
            What::Always(what) => what == value,
            What::Between(what) => what == value && frame.fract() != 0.0,
        };
        let is_named = |name: &&&str| match name.strip_suffix('*') {
            Some(start) => object.starts_with(start),
            None => object == **name,
        };
        self.objects.iter().filter(|_| is_meant).find(is_named).copied()
    }
}

const AREA_LIGHT: Known = Known {
    objects: &["area"],
    what: What::Always("light"),
    reason: "glTF has no area lights, and this node's `sunfleck_light` says nothing",
};
const JUMPS_SMEARED: Known = Known {
    objects: &[
        "leaf_02", "leaf_06", "leaf_10", "leaf_14", "leaf_18", "leaf_22", "leaf_26", "leaf_30", "leaf_34",
        "leaf_38",
    ],
    what: What::Between("place"),
    reason: "export mode SCENE makes constant keys linear: a jump smears over one frame",
};
const TURNS_SMEARED: Known = Known { what: What::Between("axes"), ..JUMPS_SMEARED };
const JUMPS_BETWEEN_FRAMES: Known = Known {
    objects: &["leaf_06", "leaf_18", "leaf_30"],
    what: What::Between("place"),
    reason: "their constant keys lie between whole frames, where nothing is sampled",
};
const TURNS_BETWEEN_FRAMES: Known = Known { what: What::Between("axes"), ..JUMPS_BETWEEN_FRAMES };
const KEYS_BETWEEN_FRAMES: Known = Known {
    objects: &["leaf_21", "leaf_33"],
    what: What::Between("axes"),
    reason: "their keys lie between whole frames, where nothing is sampled",
};
const NOT_ANIMATED: &str =
    "without KHR_animation_pointer only nodes are animated: the value at frame 0 is kept";
const NO_LENS_KEYS: Known =
    Known { objects: &["render_cam"], what: What::Always("projection"), reason: NOT_ANIMATED };
const WINDOW_COLOR: Known = Known {
    objects: &["window"],
    what: What::Always("light"),
    reason: "its `sunfleck_light`, written by hand, has another colour than Blender's light",
};
const SHEARED_CONSTRAINT: Known = Known {
    objects: &["follower"],
    what: What::Always("axes"),
    reason: "the exporter writes a sheared Child-Of constraint wrongly",
};
const NO_DRIVERS: &str = "export mode ACTIONS leaves drivers, constraints and cycles without keys out";

pub(crate) const SAMPLES: &[Sample] = &[
    Sample {
        known: &[AREA_LIGHT, JUMPS_SMEARED, TURNS_SMEARED, KEYS_BETWEEN_FRAMES],
        ..sample("a_leaves40_scene.glb", "a_leaves40.gt.json", 1000)
    },
    Sample {
        known: &[AREA_LIGHT, JUMPS_BETWEEN_FRAMES, TURNS_BETWEEN_FRAMES, KEYS_BETWEEN_FRAMES],
        ..sample("a_leaves40_sampled.glb", "a_leaves40.gt.json", 1000)
    },
    Sample {
        known: &[
            AREA_LIGHT,
            Known {
                objects: &["leaf_*", "cam"],
                what: What::Always("axes"),
                reason: "unsampled export writes rotations wrongly unless they are Euler XYZ and small; places are right",
            },
        ],
        ..sample("a_leaves40_curves.glb", "a_leaves40.gt.json", 1000)
    },
    sample("b_leafcards.glb", "b_leafcards.gt.json", 50),
    sample("b_leafcards_separate/b_leafcards.gltf", "b_leafcards.gt.json", 50),
    sample("c_morph.glb", "c_morph.gt.json", 30),
    sample("d_skin.glb", "d_skin.gt.json", 40),
    sample("e_inst_default.glb", "e_instances.gt.json", 80),
    Sample {
        known: &[Known {
            objects: &["scatter", "twig_inst_0"],
            what: What::Always("place"),
            reason: "exported without animation: right at frame 1 alone",
        }],
        ..sample("e_inst_gpu_static.glb", "e_instances.gt.json", 80)
    },
    sample("f_plain.glb", "f_compressed.gt.json", 20),
    sample("f_draco.glb", "f_compressed.gt.json", 20),
    Sample {
        prepared: &[(
            "cameras/0/extras/sunfleck_camera",
            r#"{ "shift": [0.15000000596046448, -0.10000000149011612] }"#,
        )],
        known: &[Known {
            objects: &["c_pano"],
            what: What::Always("projection"),
            reason: "the exporter writes panoramic cameras as empty nodes",
        }],
        ..sample("h_cameras.glb", "h_cameras.gt.json", 20)
    },
    Sample { known: &[AREA_LIGHT], ..sample("h_fog_extras.glb", "h_fog_extras.gt.json", 40) },
    Sample {
        known: &[
            Known { objects: &["pt", "spot", "sun"], what: What::Always("light"), reason: NOT_ANIMATED },
            Known { objects: &["cam"], what: What::Always("projection"), reason: NOT_ANIMATED },
        ],
        ..sample("h_lights_nopointer.glb", "h_lights.gt.json", 70)
    },
    Sample { light_bar: ROUNDED_ONCE, ..sample("h_lights_pointer_scene.glb", "h_lights.gt.json", 70) },
    sample("h_time_24_s1.glb", "h_time_24_s1.gt.json", 15),
    Sample {
        prepared: &[("scenes/0/extras/sunfleck", r#"{ "fps": 24, "fps_base": 1.0010000467300415 }"#)],
        ..sample("h_time_23976_s101.glb", "h_time_23976_s101.gt.json", 15)
    },
    Sample {
        known: &[
            Known { objects: &["driven", "follower"], what: What::Always("place"), reason: NO_DRIVERS },
            Known { objects: &["cyclic", "follower"], what: What::Always("axes"), reason: NO_DRIVERS },
        ],
        ..sample("h_transforms.glb", "h_transforms.gt.json", 150)
    },
    Sample { known: &[SHEARED_CONSTRAINT], ..sample("h_transforms_scene.glb", "h_transforms.gt.json", 150) },
    Sample { known: &[WINDOW_COLOR], ..sample("i_conventions.glb", "i_conventions.gt.json", 150) },
    Sample {
        known: &[
            WINDOW_COLOR,
            NO_LENS_KEYS,
            Known { objects: &["ctl_driven"], what: What::Always("place"), reason: NO_DRIVERS },
        ],
        ..sample("i_conventions_actions.glb", "i_conventions.gt.json", 150)
    },
    Sample {
        known: &[WINDOW_COLOR, NO_LENS_KEYS],
        ..sample("i_conventions_nopointer.glb", "i_conventions.gt.json", 150)
    },
];

/// Files that are not compared, and why.
pub(crate) const WITHOUT_TRUTH: &[(&str, &str)] = &[
    ("e_inst_gn_gpu_BADANIM.glb", "its channels target nodes that do not exist: refused"),
    ("f_meshopt_quant.glb", "gltfpack resampled its animation at 30 frames a second"),
    ("j_tangents.glb", "nothing moves: its tangents are compared (tangents.rs)"),
    ("j_tangents_given.glb", "the same"),
    ("g_pbr.glb", "nothing moves, there is no truth"),
];

const fn sample(file: &'static str, truth: &'static str, least_compared: usize) -> Sample {
    Sample { file, truth, prepared: &[], least_compared, light_bar: EXACT, known: &[] }
}

pub(crate) fn path(name: &str) -> PathBuf {
    checkout::file("tests/data/blender").join(name)
}

/// All glTF files of the folder.
pub(crate) fn files() -> BTreeSet<String> {
    let mut names = BTreeSet::new();
    for folder in ["", "b_leafcards_separate/"] {
        for entry in std::fs::read_dir(path(folder)).unwrap() {
            let name = entry.unwrap().file_name().into_string().unwrap();
            if name.ends_with(".glb") || name.ends_with(".gltf") {
                names.insert(format!("{folder}{name}"));
            }
        }
    }
    names
}

/// A file with values put in place of others, or where there were none.
pub(crate) fn prepared(file: &str, changes: &[(&str, &str)]) -> Vec<u8> {
    let bytes = std::fs::read(path(file)).unwrap();
    let mut glb = gltf::Glb::from_slice(&bytes).unwrap();
    let mut json: Value = serde_json::from_slice(&glb.json).unwrap();
    for (place, value) in changes {
        let target = place.split('/').fold(&mut json, |at, step| match step.parse::<usize>() {
            Ok(index) => &mut at[index],
            Err(_) => &mut at[step],
        });
        *target = serde_json::from_str(value).unwrap();
    }
    glb.json = serde_json::to_vec(&json).unwrap().into();
    glb.to_vec().unwrap()
}
