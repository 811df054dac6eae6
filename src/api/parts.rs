//! What a scene is made of, for programs that make one. In go numbers, out come the fields of a file.
//! Invariant: names, units and meanings are those of docs/scene-format.md, which has every range too; the
//! reader of files checks them.

use super::animated::{Animated, in_steps};
use serde::Serialize;
use std::collections::BTreeMap;
use std::path::PathBuf;

/// A shape.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub enum Shape {
    /// A Wavefront OBJ file with its materials; like all files it lies relative to the folder that
    /// the program runs in.
    Obj(PathBuf),
    /// The same, with other materials in place of some of its own.
    ObjWith {
        /// Where it lies.
        file: PathBuf,
        /// What takes their place, by names of the file's.
        materials: BTreeMap<String, Replacement>,
    },
    /// A square in the x-z plane, centred, facing +y.
    Quad {
        /// Length of an edge.
        size_m: f64,
    },
    /// A cube, centred.
    Cube {
        /// Length of an edge.
        size_m: f64,
    },
    /// A sphere, centred.
    Sphere {
        /// Radius.
        radius_m: f64,
    },
    /// A leaf in the x-z plane, centred, facing +y, its tip towards -z.
    Leaf {
        /// From stalk to tip.
        length_m: f64,
        /// Across, where it is widest.
        width_m: f64,
        /// How far it bends down along its length, in all.
        curl_deg: f64,
        /// How far each half is lifted about the middle vein.
        fold_deg: f64,
    },
}

/// What takes the place of a material of an OBJ file.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Replacement {
    /// A material of the scene, by its name.
    Named(String),
    /// One that only this mesh has. What it leaves out is as the file has it.
    Inline(Box<Material>),
}

/// What a surface is made of.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Material {
    /// Lambert reflectance, linear Rec. 709, `0..=1`; multiplied by the texture. None is 0.8,
    /// or 1 with a texture.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub base_color: Option<[f64; 3]>,
    /// A PNG, JPEG, WebP or PPM image in sRGB; like all images it lies relative to the folder that
    /// the program runs in.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub texture: Option<PathBuf>,
    /// Alpha, `0..=1`, multiplied by that of the texture; none is 1.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub opacity: Option<f64>,
    /// The surface is cut away where alpha is less than this, `0..=1`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub alpha_cutoff: Option<f64>,
    /// How much light goes straight through, `0..=1`; none lets nothing through.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub filter_color: Option<[f64; 3]>,
    /// Lambert transmittance to the far side, `0..=1`; multiplied by its texture, or else by `texture`.
    pub transmission: [f64; 3],
    /// An image of the colours in which light comes through.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub transmission_texture: Option<PathBuf>,
    /// An image of directions that bend its normals.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub normal_map: Option<NormalMap>,
    /// How rough its shine is, `0..=1`; none is matte.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub roughness: Option<f64>,
    /// How much of a metal it is, `0..=1`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub metallic: Option<f64>,
    /// Perfect mirror reflectance, `0..=1`.
    pub mirror: [f64; 3],
    /// Radiance emitted to either side; black is left out.
    #[serde(skip_serializing_if = "is_black")]
    pub emission_w_per_m2_sr: [f64; 3],
}

fn is_black(color: &[f64; 3]) -> bool {
    *color == [0.0; 3]
}

/// An image of directions, as glTF's normal maps are.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct NormalMap {
    /// Its red, green and blue are x, y and z, from -1 to 1.
    pub texture: PathBuf,
    /// Factor on x and y; 1 is as the image has it.
    pub scale: f64,
}

/// A mesh in its place, or a group of such.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Object {
    /// Name of a mesh; without one the object only groups.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mesh: Option<String>,
    /// Name of a material.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub material: Option<String>,
    /// Name of the object that this one follows.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub parent: Option<String>,
    /// Where it is in its parent's space.
    pub translation_m: Animated<[f64; 3]>,
    /// Turned about x, then y, then z.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rotation_deg: Option<Animated<[f64; 3]>>,
    /// Turned, as a quaternion `(x, y, z, w)`; not beside `rotation_deg`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rotation_quaternion: Option<Animated<[f64; 4]>>,
    /// Scaled before it is turned.
    pub scale: Animated<[f64; 3]>,
    /// Whether it and everything that follows it takes part in the picture. Keys jump.
    #[serde(serialize_with = "in_steps")]
    pub visible: Animated<bool>,
    /// Whether the camera sees its mesh; mirrors do in any case.
    pub visible_to_camera: bool,
    /// Whether its mesh keeps light from what lies behind it.
    pub casts_shadow: bool,
    /// Whether its mesh is a hole in the picture: black, with alpha 0.
    pub holdout: bool,
}

impl Default for Object {
    fn default() -> Self {
        Self {
            mesh: None,
            material: None,
            parent: None,
            translation_m: Animated::Still([0.0; 3]),
            rotation_deg: None,
            rotation_quaternion: None,
            scale: Animated::Still([1.0; 3]),
            visible: Animated::Still(true),
            visible_to_camera: true,
            casts_shadow: true,
            holdout: false,
        }
    }
}

/// Seeded copies of meshes, scattered over a box or a surface. Ranges are `[low, high]`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Leaves {
    /// How many.
    pub count: u32,
    /// Another seed, other leaves.
    pub seed: u32,
    /// Names of meshes; each leaf is one of them.
    pub meshes: Vec<String>,
    /// Names of materials; each leaf is made of one of them.
    pub materials: Vec<String>,
    /// Colours of which each leaf has one in between, as a factor on its material; needs `materials`.
    pub tint: Vec<[f64; 3]>,
    /// Name of the object that the leaves follow.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub parent: Option<String>,
    /// Smallest coordinates of the box in which the leaves are at time 0.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub min_m: Option<[f64; 3]>,
    /// Largest coordinates of that box.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub max_m: Option<[f64; 3]>,
    /// Name of the object on whose surface the leaves sit instead.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub on: Option<String>,
    /// How far tips hang below level; any attitude is as likely without.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub droop_deg: Option<[f64; 2]>,
    /// Turn about the leaf's length, beside `droop_deg`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub roll_deg: Option<[f64; 2]>,
    /// Factor on the mesh's size.
    pub scale: [f64; 2],
    /// How they move.
    pub motion: LeafMotion,
    /// Whether the camera sees them; mirrors do in any case.
    pub visible_to_camera: bool,
    /// Whether they keep light from what lies behind them.
    pub casts_shadow: bool,
    /// Whether they are holes in the picture: black, with alpha 0.
    pub holdout: bool,
}

impl Default for Leaves {
    fn default() -> Self {
        Self {
            count: 1,
            seed: 0,
            meshes: Vec::new(),
            materials: Vec::new(),
            tint: Vec::new(),
            parent: None,
            min_m: None,
            max_m: None,
            on: None,
            droop_deg: None,
            roll_deg: None,
            scale: [1.0; 2],
            motion: LeafMotion::Still,
            visible_to_camera: true,
            casts_shadow: true,
            holdout: false,
        }
    }
}

/// How the leaves of a block move.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub enum LeafMotion {
    /// Not at all.
    #[default]
    Still,
    /// Down at a steady speed, swinging and turning, until the ground.
    Falling {
        /// Speed of descent.
        speed_m_per_s: [f64; 2],
        /// Half width of the swing.
        swing_m: [f64; 2],
        /// Swings a second.
        swing_hz: [f64; 2],
        /// Turn rate about a random axis.
        spin_deg_per_s: [f64; 2],
        /// Velocity of the air.
        wind_m_per_s: [f64; 3],
        /// Height at which leaves come to rest.
        ground_y_m: f64,
    },
}

/// A camera.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Camera {
    /// Name of the object that the camera follows.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub parent: Option<String>,
    /// Where it is in its parent's space; none is the origin.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub position_m: Option<Animated<[f64; 3]>>,
    /// What it looks at, in its parent's space.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub look_at_m: Option<Animated<[f64; 3]>>,
    /// What is up in the picture, beside `look_at_m`; none is +y.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub up: Option<Animated<[f64; 3]>>,
    /// Turned about x, then y, then z, from looking along -z; not beside `look_at_m`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rotation_deg: Option<Animated<[f64; 3]>>,
    /// The same as a quaternion `(x, y, z, w)`; one of the two.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rotation_quaternion: Option<Animated<[f64; 4]>>,
    /// Full vertical field of view; none is 45 degrees.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fov_deg: Option<Animated<f64>>,
    /// Of the picture of a camera whose rays are parallel; not beside `fov_deg`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub orthographic_height_m: Option<Animated<f64>>,
    /// The lens that blurs what is out of focus; a pinhole without.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub aperture: Option<Aperture>,
    /// Between which two distances along the view surfaces are seen; none is all before the camera.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub clip_m: Option<[f64; 2]>,
}

/// The opening of a lens.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Aperture {
    /// Focal length over the opening's diameter.
    pub f_stop: Animated<f64>,
    /// Distance of the plane in focus, along the view.
    pub focus_distance_m: Animated<f64>,
    /// With the angle of view it gives the focal length; none is 36 mm.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sensor_width_mm: Option<f64>,
    /// Straight blades of the opening, `3..=32`; none is round.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub blades: Option<u32>,
}

impl Aperture {
    /// A round opening before a sensor 36 mm wide.
    pub fn new(f_stop: impl Into<Animated<f64>>, focus_distance_m: impl Into<Animated<f64>>) -> Self {
        let (f_stop, focus_distance_m) = (f_stop.into(), focus_distance_m.into());
        Self { f_stop, focus_distance_m, sensor_width_mm: None, blades: None }
    }
}
