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

impl SceneBuilder {
    /// Adds a shape. Files lie relative to the folder that the program runs in.
    pub fn shape(mut self, name: &str, shape: Shape) -> Self {
        self.parts.file.meshes.push(name, shape);
        self
    }

    /// Adds a shape by its triangles.
    pub fn mesh(mut self, name: &str, triangles: Triangles) -> Self {
        self.parts.triangles.push((name.to_owned(), triangles));
        self
    }

    /// Adds what surfaces are made of.
    pub fn material(mut self, name: &str, material: Material) -> Self {
        self.parts.file.materials.push(name, material);
        self
    }

    /// Places a mesh or a group.
    pub fn object(mut self, name: &str, object: Object) -> Self {
        self.parts.file.objects.push(name, object);
        self
    }

    /// Scatters leaves.
    pub fn leaves(mut self, name: &str, leaves: Leaves) -> Self {
        self.parts.file.leaves.push(name, leaves);
        self
    }

    /// Lets leaves fall.
    pub fn fall(mut self, name: &str, fall: Fall) -> Self {
        self.parts.file.fall.push(name, fall);
        self
    }

    /// Adds a camera; the first one looks unless somebody wants another.
    pub fn camera(mut self, name: &str, camera: Camera) -> Self {
        self.parts.file.cameras.push(name, camera);
        self
    }

    /// Adds a light.
    pub fn light(mut self, name: &str, light: Light) -> Self {
        self.parts.file.lights.push(name, light);
        self
    }

    /// Adds a bank of fog.
    pub fn fog(mut self, name: &str, fog: Fog) -> Self {
        self.parts.file.fog.push(name, fog);
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
