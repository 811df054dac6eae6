//! Builder of a scene in code. In go named parts, out comes a scene. Invariant: parts are those of scene
//! files and are resolved by the same code, so a file can hold every scene that is built.

use super::scene::Scene;
use crate::description::obj::Triangles;
use crate::description::ron::{
    BuiltScene, Camera, Fall, Fog, Leaves, Light, Material, NonNegative, Object, Shape, Sky, Triple,
};
use crate::description::{Description, LoadError};
use crate::scene::{Baking, ResolveOptions};

/// Builder that collects the parts of a scene; [`Scene::builder`] returns an empty one. Names of parts of one
/// kind are unique. A camera is required. The scene has 24 frames a second, and second 0 is frame 0.
#[derive(Clone, Debug, Default)]
#[must_use = "nothing is checked before `build`"]
pub struct SceneBuilder {
    parts: BuiltScene,
}

impl Scene {
    /// Creates a builder without parts.
    pub fn builder() -> SceneBuilder {
        SceneBuilder::default()
    }
}

/// Defines a method for each section of a scene file, which adds a part by its name.
macro_rules! sections {
    ($($(#[$doc:meta])* $part:ident: $section:ident, $type:ty;)*) => {
        impl SceneBuilder {$(
            $(#[$doc])*
            pub fn $part(mut self, name: &str, $part: $type) -> Self {
                self.parts.file.$section.push(name, $part);
                self
            }
        )*}
    };
}

sections! {
    /// Adds a shape. Paths of its files are relative to the working directory.
    shape: meshes, Shape;
    /// Adds a material.
    material: materials, Material;
    /// Places a mesh or a group.
    object: objects, Object;
    /// Scatters leaves.
    leaves: leaves, Leaves;
    /// Adds falling leaves.
    fall: fall, Fall;
    /// Adds a camera. The first one renders unless another is named.
    camera: cameras, Camera;
    /// Adds a light.
    light: lights, Light;
    /// Adds a fog volume.
    fog: fog, Fog;
}

impl SceneBuilder {
    /// Adds a shape by its triangles.
    pub fn mesh(mut self, name: &str, triangles: Triangles) -> Self {
        self.parts.triangles.push((name.to_owned(), triangles));
        self
    }

    /// Sets the sky, which is seen behind the scene and lights it. A scene has no sky and background at once.
    pub fn sky(mut self, sky: Sky) -> Self {
        self.parts.file.sky = Some(sky);
        self
    }

    /// Sets the radiance of rays that leave the scene; it lights nothing.
    pub fn background(mut self, w_per_m2_sr: impl Into<Triple<NonNegative>>) -> Self {
        self.parts.file.background_w_per_m2_sr = w_per_m2_sr.into();
        self
    }

    /// Resolves and validates the scene.
    ///
    /// # Errors
    /// Lists all problems, each with its path, such as `fog.haze.density_per_m`.
    pub fn build(self) -> Result<Scene, LoadError> {
        let description = Description::built(self.parts)?;
        Ok(Scene::resolve(description, &ResolveOptions::default(), &Baking::ALONE)?)
    }
}
