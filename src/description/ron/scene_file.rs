//! What a scene file holds, field by field. Invariant: every field's unit is in its name, and
//! docs/scene-format.md describes every field.

use super::defaults::{one, seen, yes, zero};
use super::fall::Fall;
use super::keyed::Keyed;
use super::leaves::Leaves;
use super::material::Material;
use super::mesh::Mesh;
use super::mist::Mist;
use super::named::Named;
use super::number::{
    Anisotropy, Degrees, Direction, DiscAngle, FStop, FieldOfView, Finite, FocusDistance, HalfAngle,
    JuliaPart, NonNegative, Number, Point, Positive, Quaternion, Triple, UnitInterval, Vector, Whole,
};
use super::sky::Sky;
use super::version::Version;
use glam::DVec3;
use serde::Deserialize;
use std::path::PathBuf;

/// `Scene(..)`: everything there is to see.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SceneFile {
    /// Version of the format.
    pub version: Version,
    /// Shapes.
    #[serde(default)]
    pub meshes: Named<Mesh>,
    /// What surfaces are made of.
    #[serde(default)]
    pub materials: Named<Material>,
    /// Meshes and groups, placed one by one.
    #[serde(default)]
    pub objects: Named<Object>,
    /// Leaves, stamped by the hundred.
    #[serde(default)]
    pub leaves: Named<Leaves>,
    /// Leaves that fall as leaves fall.
    #[serde(default)]
    pub fall: Named<Fall>,
    /// Cameras.
    #[serde(default)]
    pub cameras: Named<Camera>,
    /// Lights.
    #[serde(default)]
    pub lights: Named<Light>,
    /// Banks of fog.
    #[serde(default)]
    pub fog: Named<Fog>,
    /// What lies behind the scene and lights it.
    pub sky: Option<Sky>,
    /// Radiance of whatever lies beyond the scene.
    #[serde(default = "zero")]
    pub background_w_per_m2_sr: Triple<NonNegative>,
}

impl SceneFile {
    /// A scene of nothing but a mesh.
    pub(super) fn of_mesh(name: &str, mesh: Mesh) -> Self {
        let object = Object {
            mesh: Some(name.to_owned()),
            material: None,
            parent: None,
            translation_m: zero(),
            rotation_deg: None,
            rotation_quaternion: None,
            scale: one(),
            visible: seen(),
            visible_to_camera: true,
            casts_shadow: true,
            holdout: false,
        };
        Self {
            version: Version,
            meshes: Named::one(name, mesh),
            materials: Named::default(),
            objects: Named::one(name, object),
            leaves: Named::default(),
            fall: Named::default(),
            cameras: Named::default(),
            lights: Named::default(),
            fog: Named::default(),
            sky: None,
            background_w_per_m2_sr: zero(),
        }
    }
}

/// A mesh in its place, or a group of such.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Object {
    /// Name of a mesh; without one the object only groups.
    pub mesh: Option<String>,
    /// Name of a material; replaces the mesh's own.
    pub material: Option<String>,
    /// Name of the object that this one follows.
    pub parent: Option<String>,
    /// Where it is in its parent's space.
    #[serde(default = "zero")]
    pub translation_m: Keyed<Point>,
    /// Turned about x, then y, then z.
    pub rotation_deg: Option<Keyed<Vector<Degrees>>>,
    /// Turned, as a quaternion.
    pub rotation_quaternion: Option<Keyed<Quaternion>>,
    /// Scaled before it is turned.
    #[serde(default = "one")]
    pub scale: Keyed<Triple<Finite>>,
    /// Whether it and everything that follows it takes part in the picture.
    #[serde(default = "seen")]
    pub visible: Keyed<bool>,
    /// Whether the camera sees its mesh.
    #[serde(default = "yes")]
    pub visible_to_camera: bool,
    /// Whether its mesh throws shadows.
    #[serde(default = "yes")]
    pub casts_shadow: bool,
    /// Whether its mesh is a hole in the picture.
    #[serde(default)]
    pub holdout: bool,
}

/// A camera.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Camera {
    /// Name of the object that the camera follows.
    pub parent: Option<String>,
    /// Where it is in its parent's space.
    #[serde(default = "zero")]
    pub position_m: Keyed<Point>,
    /// What it looks at, in its parent's space.
    pub look_at_m: Option<Keyed<Point>>,
    /// What is up in the picture when it looks at something.
    #[serde(default = "upright")]
    pub up: Keyed<Direction>,
    /// Turned about x, then y, then z, from looking along -z.
    pub rotation_deg: Option<Keyed<Vector<Degrees>>>,
    /// Turned, as a quaternion, from looking along -z.
    pub rotation_quaternion: Option<Keyed<Quaternion>>,
    /// Full vertical field of view.
    pub fov_deg: Option<Keyed<Number<FieldOfView>>>,
    /// Of the picture of a camera whose rays are parallel.
    pub orthographic_height_m: Option<Keyed<Number<Positive>>>,
    /// The lens that blurs what is out of focus; a pinhole without.
    pub aperture: Option<Aperture>,
    /// Between which distances along the view surfaces are seen: all before the camera without.
    pub clip_m: Option<(Number<NonNegative>, Number<Positive>)>,
}

/// The opening of a lens.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Aperture {
    /// Focal length over the opening's diameter.
    pub f_stop: Keyed<Number<FStop>>,
    /// Distance of the plane in focus, along the view.
    pub focus_distance_m: Keyed<Number<FocusDistance>>,
    /// With the angle of view it gives the focal length.
    #[serde(default = "full_frame")]
    pub sensor_width_mm: Number<Positive>,
    /// Straight blades of the opening; a round one without.
    pub blades: Option<Whole<3, 32>>,
}

/// A light.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub enum Light {
    /// Light from infinitely far away.
    Sun {
        /// Name of the object whose rotation the light follows.
        parent: Option<String>,
        /// Where the light goes to.
        direction: Option<Keyed<Direction>>,
        /// Where the light comes from.
        to_sun: Option<Keyed<Direction>>,
        /// On a plane perpendicular to the light.
        irradiance_w_per_m2: Keyed<Triple<NonNegative>>,
        /// The whole angle under which its disc is seen; 0 is parallel light.
        #[serde(default = "zero")]
        angular_diameter_deg: Keyed<Number<DiscAngle>>,
        /// How much darker the disc is towards its edge.
        #[serde(default = "zero")]
        limb_darkening: Number<UnitInterval>,
        /// A PNG, JPEG, WebP or PPM image on the disc, relative to the scene file.
        image: Option<PathBuf>,
        /// A fractal on the disc.
        fractal: Option<Julia>,
        /// How far image or fractal are turned anticlockwise.
        #[serde(default = "zero")]
        picture_rotation_deg: Keyed<Number<Degrees>>,
        /// Whether camera and mirrors see the disc.
        #[serde(default)]
        visible_to_camera: bool,
    },
    /// Light from a point or sphere to all sides.
    Point {
        /// Name of the object that the light follows.
        parent: Option<String>,
        /// Where it is in its parent's space.
        position_m: Keyed<Point>,
        /// In every direction, seen from afar.
        intensity_w_per_sr: Keyed<Triple<NonNegative>>,
        /// Of the sphere that shines; 0 is a point.
        #[serde(default = "zero")]
        radius_m: Keyed<Number<NonNegative>>,
    },
    /// Light from a point or sphere into a cone.
    Spot {
        /// Name of the object that the light follows.
        parent: Option<String>,
        /// Where it is in its parent's space.
        position_m: Keyed<Point>,
        /// Where it points.
        target_m: Keyed<Point>,
        /// Between the axis and the edge of the cone.
        outer_deg: Keyed<Number<HalfAngle>>,
        /// Softness of the edge, as in Blender.
        #[serde(default = "soft_edge")]
        blend: Keyed<Number<UnitInterval>>,
        /// On the axis, seen from afar.
        intensity_w_per_sr: Keyed<Triple<NonNegative>>,
        /// Of the sphere that shines; 0 is a point.
        #[serde(default = "zero")]
        radius_m: Keyed<Number<NonNegative>>,
    },
    /// A flat rectangle that shines from one side.
    Rectangle {
        /// Name of the object that the light follows.
        parent: Option<String>,
        /// Where its middle is in its parent's space.
        position_m: Keyed<Point>,
        /// Where it faces.
        target_m: Keyed<Point>,
        /// The way its height goes.
        #[serde(default = "up")]
        up: Direction,
        /// Across.
        width_m: Keyed<Number<Positive>>,
        /// Along `up`.
        height_m: Keyed<Number<Positive>>,
        /// All light that it emits.
        power_w: Keyed<Triple<NonNegative>>,
    },
    /// A flat disc that shines from one side.
    Disc {
        /// Name of the object that the light follows.
        parent: Option<String>,
        /// Where its middle is in its parent's space.
        position_m: Keyed<Point>,
        /// Where it faces.
        target_m: Keyed<Point>,
        /// Of the disc.
        diameter_m: Keyed<Number<Positive>>,
        /// All light that it emits.
        power_w: Keyed<Triple<NonNegative>>,
    },
}

/// The Julia set of `z^2 + c`.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Julia {
    /// Real part of `c`.
    pub real: Keyed<Number<JuliaPart>>,
    /// Imaginary part of `c`.
    pub imaginary: Keyed<Number<JuliaPart>>,
    /// After so many a point counts as one that never escapes.
    #[serde(default = "hundred")]
    pub iterations: Whole<1, 1000>,
}

/// A bank of fog: in a box, thinner with height, or both; or as dense as voxels are.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Fog {
    /// Name of the object that the fog follows.
    pub parent: Option<String>,
    /// The corner of its box with the smallest coordinates, in its parent's space.
    pub min_m: Option<Point>,
    /// The corner with the largest coordinates.
    pub max_m: Option<Point>,
    /// The height over which its density falls to 1/e.
    pub scale_height_m: Option<Keyed<Number<Positive>>>,
    /// Where that begins: a y coordinate of its parent's space.
    pub base_m: Option<Number<Finite>>,
    /// An OpenVDB file that says how dense it is, in its parent's space.
    pub vdb: Option<PathBuf>,
    /// The file's grid that does [default: `density`].
    pub grid: Option<String>,
    /// Billows that it is made of, in its box.
    pub mist: Option<Mist>,
    /// Extinction coefficient sigma_t where the fog is densest; of voxels that of 1 in them.
    pub density_per_m: Keyed<Triple<NonNegative>>,
    /// How much of the extinction is scattering.
    #[serde(default = "one")]
    pub albedo: Keyed<Triple<UnitInterval>>,
    /// Henyey-Greenstein g; forward if positive.
    #[serde(default = "zero")]
    pub anisotropy: Keyed<Number<Anisotropy>>,
}

fn up() -> Direction {
    Direction(DVec3::Y)
}

fn upright() -> Keyed<Direction> {
    Keyed::Plain(up())
}

fn full_frame() -> Number<Positive> {
    Number::new(36.0)
}

fn hundred() -> Whole<1, 1000> {
    Whole(100)
}

fn soft_edge() -> Keyed<Number<UnitInterval>> {
    Keyed::Plain(Number::new(0.15))
}
