//! A scene made in code. In go named parts, out comes a scene. Invariant: parts go the way of a file, through
//! the same reader and the same resolution, so nothing can be built that a file could not hold.

use super::falls::Fall;
use super::lights::Light;
use super::parts::{Camera, Leaves, Material, Object, Shape};
use super::scene::Scene;
use super::surroundings::{Fog, Sky};
use crate::description::obj::Triangles;
use crate::description::ron::{BuiltScene, Parts};
use crate::description::{Description, LoadError};
use crate::scene::{Baking, ResolveOptions};
use serde::Serialize;
use serde_json::Value;

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
    /// Adds a shape.
    pub fn shape(mut self, name: &str, shape: Shape) -> Self {
        add(&mut self.parts.meshes, name, &shape);
        self
    }

    /// Adds a shape by its triangles.
    pub fn mesh(mut self, name: &str, triangles: Triangles) -> Self {
        self.parts.triangles.push((name.to_owned(), triangles));
        self
    }

    /// Adds what surfaces are made of.
    pub fn material(mut self, name: &str, material: Material) -> Self {
        add(&mut self.parts.materials, name, &material);
        self
    }

    /// Places a mesh or a group.
    pub fn object(mut self, name: &str, object: Object) -> Self {
        add(&mut self.parts.objects, name, &object);
        self
    }

    /// Scatters leaves.
    pub fn leaves(mut self, name: &str, leaves: Leaves) -> Self {
        add(&mut self.parts.leaves, name, &leaves);
        self
    }

    /// Lets leaves fall.
    pub fn fall(mut self, name: &str, fall: Fall) -> Self {
        add(&mut self.parts.fall, name, &fall);
        self
    }

    /// Adds a camera; the first one looks unless somebody wants another.
    pub fn camera(mut self, name: &str, camera: Camera) -> Self {
        add(&mut self.parts.cameras, name, &camera);
        self
    }

    /// Adds a light.
    pub fn light(mut self, name: &str, light: Light) -> Self {
        add(&mut self.parts.lights, name, &light);
        self
    }

    /// Adds a bank of fog.
    pub fn fog(mut self, name: &str, fog: Fog) -> Self {
        add(&mut self.parts.fog, name, &fog);
        self
    }

    /// What lies behind the scene and lights it; not beside a background.
    pub fn sky(mut self, sky: Sky) -> Self {
        self.parts.sky = Some(value(&sky));
        self
    }

    /// Radiance of whatever lies beyond the scene; it lights nothing.
    pub fn background(mut self, w_per_m2_sr: [f64; 3]) -> Self {
        self.parts.background = Some(value(&w_per_m2_sr));
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

fn add(parts: &mut Parts, name: &str, part: &impl Serialize) {
    parts.push((name.to_owned(), value(part)));
}

/// Parts leave out what they do not say, so that a null is what JSON has no word for: NaN, infinity, a
/// path that is no text.
fn value(part: &impl Serialize) -> Value {
    let mut value = serde_json::to_value(part).unwrap_or_default();
    refuse_nulls(&mut value);
    value
}

/// Puts something in their place that no field takes: a null would count as a field left out.
fn refuse_nulls(value: &mut Value) {
    match value {
        Value::Null => *value = Value::from(UNWRITABLE),
        Value::Array(values) => values.iter_mut().for_each(refuse_nulls),
        Value::Object(fields) => fields.values_mut().for_each(refuse_nulls),
        _ => {}
    }
}

/// What the reader says that it found.
const UNWRITABLE: &str = "something that is neither a finite number nor text";
