//! A scene made in code. In go named parts, out comes a scene. Invariant: parts are those of files and go
//! their way, so nothing can be built that a file could not hold.

use super::scene::Scene;
use crate::description::obj::Triangles;
use crate::description::ron::{
    BuiltScene, Camera, Fall, Fog, Leaves, Light, Material, NonNegative, Object, Shape, Sky, Triple,
};
use crate::description::{Description, LoadError};
use crate::scene::{Baking, ResolveOptions};

/// Collects the parts of a scene; [`Scene::builder`] starts with none. Parts of one kind
/// have names of their own.
#[derive(Clone, Debug, Default)]
#[must_use = "nothing is checked before `build`"]
pub struct SceneBuilder {
    parts: BuiltScene,
}

impl Scene {
    /// An empty scene to be filled.
    pub fn builder() -> SceneBuilder {
        SceneBuilder::default()
    }
}

/// A method for each section of a scene file: it adds a part by its name.
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
    /// Adds a shape. Files lie relative to the folder that the program runs in.
    shape: meshes, Shape;
    /// Adds what surfaces are made of.
    material: materials, Material;
    /// Places a mesh or a group.
    object: objects, Object;
    /// Scatters leaves.
    leaves: leaves, Leaves;
    /// Lets leaves fall.
    fall: fall, Fall;
    /// Adds a camera; the first one looks unless somebody wants another.
    camera: cameras, Camera;
    /// Adds a light.
    light: lights, Light;
    /// Adds a bank of fog.
    fog: fog, Fog;
}

impl SceneBuilder {
    /// Adds a shape by its triangles.
    pub fn mesh(mut self, name: &str, triangles: Triangles) -> Self {
        self.parts.triangles.push((name.to_owned(), triangles));
        self
    }

    /// Sky behind the scene, which lights it; not beside a background.
    pub fn sky(mut self, sky: Sky) -> Self {
        self.parts.file.sky = Some(sky);
        self
    }

    /// Radiance of whatever lies beyond the scene; it lights nothing.
    pub fn background(mut self, w_per_m2_sr: impl Into<Triple<NonNegative>>) -> Self {
        self.parts.file.background_w_per_m2_sr = w_per_m2_sr.into();
        self
    }

    /// The scene, if all of it can be rendered.
    ///
    /// # Errors
    /// With everything that is wrong, each by its path, such as `fog.haze.density_per_m`.
    pub fn build(self) -> Result<Scene, LoadError> {
        let description = Description::built(self.parts)?;
        Ok(Scene::resolve(description, &ResolveOptions::default(), &Baking::ALONE)?)
    }
}
