//! What a scene is made of, for programs that make one. In go numbers, out come the fields of a file. Invariant: names, units
//! and meanings are those of docs/scene-format.md, which has every range too; the reader of files checks them.

use serde::{Serialize, Serializer};

/// A value that stays, or one that goes straight from key to key.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Animated<T> {
    /// The same at all times.
    Still(T),
    /// Interpolated between keys.
    Keyed {
        /// At least one, their times strictly increasing.
        keys: Vec<Key<T>>,
        /// What happens outside the keys.
        extend: Extend,
    },
}

/// A value at a time.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Key<T> {
    /// Seconds.
    pub at_s: f64,
    /// The value there.
    pub value: T,
}

/// What a keyed value does outside its keys.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub enum Extend {
    /// Keeps the first or last value.
    #[default]
    Hold,
    /// Starts over.
    Cycle,
}

impl<T> Animated<T> {
    /// From pairs of seconds and values; holds the first and the last.
    pub fn keys(keys: impl IntoIterator<Item = (f64, T)>) -> Self {
        Self::Keyed { keys: pairs(keys), extend: Extend::Hold }
    }

    /// The same over and over.
    pub fn cycle(keys: impl IntoIterator<Item = (f64, T)>) -> Self {
        Self::Keyed { keys: pairs(keys), extend: Extend::Cycle }
    }
}

fn pairs<T>(keys: impl IntoIterator<Item = (f64, T)>) -> Vec<Key<T>> {
    keys.into_iter().map(|(at_s, value)| Key { at_s, value }).collect()
}

impl<T> From<T> for Animated<T> {
    fn from(value: T) -> Self {
        Self::Still(value)
    }
}

/// A shape.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub enum Shape {
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

/// What a surface is made of.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Material {
    /// Lambert reflectance, linear Rec. 709, `0..=1`; none is white.
    pub base_color: Option<[f64; 3]>,
    /// Alpha, `0..=1`; none is 1.
    pub opacity: Option<f64>,
    /// How much light goes straight through, `0..=1`; none lets nothing through.
    pub filter_color: Option<[f64; 3]>,
    /// Lambert transmittance to the far side, `0..=1`.
    pub transmission: [f64; 3],
    /// How rough its shine is, `0..=1`; none is matte.
    pub roughness: Option<f64>,
    /// How much of a metal it is, `0..=1`.
    pub metallic: Option<f64>,
    /// Perfect mirror reflectance, `0..=1`.
    pub mirror: [f64; 3],
    /// Radiance emitted to either side.
    pub emission_w_per_m2_sr: [f64; 3],
}

/// A mesh in its place, or a group of such.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Object {
    /// Name of a mesh; without one the object only groups.
    pub mesh: Option<String>,
    /// Name of a material.
    pub material: Option<String>,
    /// Name of the object that this one follows.
    pub parent: Option<String>,
    /// Where it is in its parent's space.
    pub translation_m: Animated<[f64; 3]>,
    /// Turned about x, then y, then z.
    pub rotation_deg: Animated<[f64; 3]>,
    /// Scaled before it is turned.
    pub scale: Animated<[f64; 3]>,
    /// Whether it and everything that follows it takes part in the picture. Keys jump.
    #[serde(serialize_with = "in_steps")]
    pub visible: Animated<bool>,
}

impl Default for Object {
    fn default() -> Self {
        let origin = || Animated::Still([0.0; 3]);
        Self {
            mesh: None,
            material: None,
            parent: None,
            translation_m: origin(),
            rotation_deg: origin(),
            scale: Animated::Still([1.0; 3]),
            visible: Animated::Still(true),
        }
    }
}

/// What is on or off goes to no value between.
fn in_steps<S: Serializer>(visible: &Animated<bool>, serializer: S) -> Result<S::Ok, S::Error> {
    let Animated::Keyed { keys, extend } = visible else { return visible.serialize(serializer) };
    let key =
        |key: &Key<bool>| serde_json::json!({ "at_s": key.at_s, "value": key.value, "to_next": "Step" });
    let keys: Vec<serde_json::Value> = keys.iter().map(key).collect();
    serde_json::json!({ "keys": keys, "extend": extend }).serialize(serializer)
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
    /// Name of the object that the leaves follow.
    pub parent: Option<String>,
    /// Smallest coordinates of the box in which the leaves are at time 0.
    pub min_m: Option<[f64; 3]>,
    /// Largest coordinates of that box.
    pub max_m: Option<[f64; 3]>,
    /// Name of the object on whose surface the leaves sit instead.
    pub on: Option<String>,
    /// How far tips hang below level; any attitude is as likely without.
    pub droop_deg: Option<[f64; 2]>,
    /// Turn about the leaf's length, beside `droop_deg`.
    pub roll_deg: Option<[f64; 2]>,
    /// Factor on the mesh's size.
    pub scale: [f64; 2],
    /// How they move.
    pub motion: LeafMotion,
}

impl Default for Leaves {
    fn default() -> Self {
        Self {
            count: 1,
            seed: 0,
            meshes: Vec::new(),
            materials: Vec::new(),
            parent: None,
            min_m: None,
            max_m: None,
            on: None,
            droop_deg: None,
            roll_deg: None,
            scale: [1.0; 2],
            motion: LeafMotion::Still,
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
    pub parent: Option<String>,
    /// Where it is in its parent's space; none is the origin.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub position_m: Option<Animated<[f64; 3]>>,
    /// What it looks at, in its parent's space.
    pub look_at_m: Option<Animated<[f64; 3]>>,
    /// Turned about x, then y, then z, from looking along -z; not beside `look_at_m`.
    pub rotation_deg: Option<Animated<[f64; 3]>>,
    /// Full vertical field of view; none is 45 degrees.
    pub fov_deg: Option<Animated<f64>>,
    /// Of the picture of a camera whose rays are parallel; not beside `fov_deg`.
    pub orthographic_height_m: Option<Animated<f64>>,
    /// The lens that blurs what is out of focus; a pinhole without.
    pub aperture: Option<Aperture>,
}

/// The opening of a lens before a sensor 36 mm wide.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Aperture {
    /// Focal length over the opening's diameter.
    pub f_stop: Animated<f64>,
    /// Distance of the plane in focus, along the view.
    pub focus_distance_m: Animated<f64>,
}

/// A light.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub enum Light {
    /// Light from infinitely far away.
    Sun {
        /// Where the light comes from.
        to_sun: Animated<[f64; 3]>,
        /// On a plane perpendicular to the light.
        irradiance_w_per_m2: Animated<[f64; 3]>,
        /// The whole angle under which its disc is seen; 0 is parallel light.
        angular_diameter_deg: Animated<f64>,
    },
    /// Light from a point or sphere to all sides.
    Point {
        /// Name of the object that the light follows.
        parent: Option<String>,
        /// Where it is in its parent's space.
        position_m: Animated<[f64; 3]>,
        /// In every direction, seen from afar.
        intensity_w_per_sr: Animated<[f64; 3]>,
        /// Of the sphere that shines; 0 is a point.
        radius_m: Animated<f64>,
    },
    /// Light from a point or sphere into a cone.
    Spot {
        /// Name of the object that the light follows.
        parent: Option<String>,
        /// Where it is in its parent's space.
        position_m: Animated<[f64; 3]>,
        /// Where it points.
        target_m: Animated<[f64; 3]>,
        /// Between the axis and the edge of the cone.
        outer_deg: Animated<f64>,
        /// Softness of the edge, `0..=1`.
        blend: Animated<f64>,
        /// On the axis, seen from afar.
        intensity_w_per_sr: Animated<[f64; 3]>,
        /// Of the sphere that shines; 0 is a point.
        radius_m: Animated<f64>,
    },
    /// A flat rectangle that shines from one side.
    Rectangle {
        /// Name of the object that the light follows.
        parent: Option<String>,
        /// Where its middle is in its parent's space.
        position_m: Animated<[f64; 3]>,
        /// Where it faces.
        target_m: Animated<[f64; 3]>,
        /// Across.
        width_m: Animated<f64>,
        /// Upwards.
        height_m: Animated<f64>,
        /// All light that it emits.
        power_w: Animated<[f64; 3]>,
    },
}

/// A bank of fog: in a box, thinner with height, or both.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Fog {
    /// Name of the object that the fog follows.
    pub parent: Option<String>,
    /// The corner of its box with the smallest coordinates, in its parent's space.
    pub min_m: Option<[f64; 3]>,
    /// The corner with the largest coordinates.
    pub max_m: Option<[f64; 3]>,
    /// The height over which its density falls to 1/e.
    pub scale_height_m: Option<Animated<f64>>,
    /// Where that begins: a y coordinate of its parent's space.
    pub base_m: Option<f64>,
    /// Extinction coefficient sigma_t where the fog is densest.
    pub density_per_m: Animated<[f64; 3]>,
    /// How much of the extinction is scattering, `0..=1`.
    pub albedo: Animated<[f64; 3]>,
    /// Henyey-Greenstein g; forward if positive.
    pub anisotropy: Animated<f64>,
}

impl Fog {
    /// Grey fog in a box, of an extinction a metre; it scatters all that it takes, to all sides alike.
    pub fn in_box(min_m: [f64; 3], max_m: [f64; 3], density_per_m: f64) -> Self {
        Self {
            parent: None,
            min_m: Some(min_m),
            max_m: Some(max_m),
            scale_height_m: None,
            base_m: None,
            density_per_m: Animated::Still([density_per_m; 3]),
            albedo: Animated::Still([1.0; 3]),
            anisotropy: Animated::Still(0.0),
        }
    }
}
