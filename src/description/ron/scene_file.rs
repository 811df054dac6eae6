//! Fields of a scene file. In goes RON, out come typed sections. Invariant: every field's unit is in its
//! name, and docs/scene-format.md describes every field.

use super::animated::Animated;
use super::camera::Camera;
use super::defaults::one;
use super::fall::Fall;
use super::fog::Fog;
use super::leaves::Leaves;
use super::light::Light;
use super::material::Material;
use super::named::Named;
use super::number::{Degrees, Finite, NonNegative, Point, Quaternion, Triple, Vector};
use super::shape::Shape;
use super::sky::Sky;
use super::version::Version;
use serde::{Deserialize, Serialize};

/// `Scene(..)`: contents of a scene.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SceneFile {
    /// Version of the format.
    pub version: Version,
    /// Shapes.
    #[serde(default)]
    pub meshes: Named<Shape>,
    /// Materials of surfaces.
    #[serde(default)]
    pub materials: Named<Material>,
    /// Placed meshes and groups.
    #[serde(default)]
    pub objects: Named<Object>,
    /// Blocks of scattered leaves.
    #[serde(default)]
    pub leaves: Named<Leaves>,
    /// Blocks of falling leaves.
    #[serde(default)]
    pub fall: Named<Fall>,
    /// Cameras.
    #[serde(default)]
    pub cameras: Named<Camera>,
    /// Lights.
    #[serde(default)]
    pub lights: Named<Light>,
    /// Fog volumes.
    #[serde(default)]
    pub fog: Named<Fog>,
    /// Sky, seen behind the scene, which it lights.
    pub sky: Option<Sky>,
    /// Radiance of rays that leave the scene; it lights nothing.
    #[serde(default)]
    pub background_w_per_m2_sr: Triple<NonNegative>,
}

impl SceneFile {
    /// Creates a scene of a single mesh.
    pub(super) fn of_mesh(name: &str, mesh: Shape) -> Self {
        let object = Object { mesh: Some(name.to_owned()), ..Object::default() };
        Self { meshes: Named::one(name, mesh), objects: Named::one(name, object), ..Self::default() }
    }
}

/// Placed mesh, or a group.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
#[non_exhaustive]
pub struct Object {
    /// Name of a mesh; without one the object only groups.
    pub mesh: Option<String>,
    /// Name of a material; replaces the mesh's own.
    pub material: Option<String>,
    /// Name of the object that this one follows.
    pub parent: Option<String>,
    /// Position in its parent's space.
    pub translation_m: Animated<Point>,
    /// Rotation about x, then y, then z.
    pub rotation_deg: Option<Animated<Vector<Degrees>>>,
    /// Rotation as a quaternion `(x, y, z, w)`; excludes `rotation_deg`.
    pub rotation_quaternion: Option<Animated<Quaternion>>,
    /// Scale, applied before the rotation.
    pub scale: Animated<Triple<Finite>>,
    /// Whether it and its descendants are visible. Keys are steps.
    pub visible: Animated<bool>,
    /// Whether the camera sees its mesh; mirrors always do.
    pub visible_to_camera: bool,
    /// Whether its mesh casts shadows.
    pub casts_shadow: bool,
    /// Whether its mesh is a holdout: black, with alpha 0.
    pub holdout: bool,
}

impl Object {
    /// Creates an object at the origin from the names of a mesh and a material.
    pub fn of(mesh: &str, material: &str) -> Self {
        Self { mesh: Some(mesh.to_owned()), material: Some(material.to_owned()), ..Self::default() }
    }
}

impl Default for Object {
    fn default() -> Self {
        Self {
            mesh: None,
            material: None,
            parent: None,
            translation_m: Animated::default(),
            rotation_deg: None,
            rotation_quaternion: None,
            scale: one(),
            visible: true.into(),
            visible_to_camera: true,
            casts_shadow: true,
            holdout: false,
        }
    }
}
