//! Options for loading a scene. In go choices, out comes the scene. Invariant: options that are not set leave
//! the input's own values.

use super::scene::Scene;
use crate::description::{self, LoadError};
use crate::diagnostic::{Diagnostic, Place};
use crate::scene::{Baking, FrameRate, LightUnits, ResolveOptions, Size};
use std::path::Path;

/// Options for reading an input; [`Scene::options`] sets none.
#[derive(Clone, Debug, Default)]
pub struct SceneOptions {
    wanted: ResolveOptions,
}

impl Scene {
    /// Loads a scene or sequence by its extension: `.ron`, `.glb`, `.gltf`, `.obj`. Works on
    /// the current rayon pool.
    ///
    /// # Errors
    /// If a file cannot be read, or with all problems of their contents.
    pub fn load(path: impl AsRef<Path>) -> Result<Self, LoadError> {
        Self::options().load(path)
    }

    /// Options for loading, none of them set.
    pub fn options() -> SceneOptions {
        SceneOptions::default()
    }
}

impl SceneOptions {
    /// Plays an animation of a glTF file: by its name, its number from 0, or `all` of them.
    #[must_use]
    pub fn animation(mut self, name: &str) -> Self {
        self.wanted.animation = Some(name.to_owned());
        self
    }

    /// Sets the units of a glTF file's lights.
    #[must_use]
    pub fn light_units(mut self, units: LightUnits) -> Self {
        self.wanted.light_units = Some(units);
        self
    }

    /// Sets whether a glTF or OBJ file without light gets a sun and a sky; by default it does.
    #[must_use]
    pub fn default_light(mut self, is_on: bool) -> Self {
        self.wanted.no_default_light = !is_on;
        self
    }

    /// Sets whether a sun in a sky's picture becomes a `Sun` light; by default it does.
    #[must_use]
    pub fn sky_sun(mut self, is_apart: bool) -> Self {
        self.wanted.keep_sky_suns = !is_apart;
        self
    }

    /// Sets the size of the whole picture in pixels. The default camera of a file without one frames
    /// everything for this aspect.
    #[must_use]
    pub fn size(mut self, width: usize, height: usize) -> Self {
        self.wanted.size = Some(Size { width, height });
        self
    }

    /// Sets the frame rate in frames a second, as a fraction such as 24000/1001.
    #[must_use]
    pub fn frame_rate(mut self, numerator: u32, denominator: u32) -> Self {
        self.wanted.frame_rate = Some(FrameRate { numerator, denominator });
        self
    }

    /// Sets the camera that renders, by its name.
    #[must_use]
    pub fn camera(mut self, name: &str) -> Self {
        self.wanted.camera = Some(name.to_owned());
        self
    }

    /// Loads a scene or sequence by its extension: `.ron`, `.glb`, `.gltf`, `.obj`. Works on
    /// the current rayon pool.
    ///
    /// # Errors
    /// If a file cannot be read, or with all problems of their contents, or if an option cannot be met.
    pub fn load(&self, path: impl AsRef<Path>) -> Result<Scene, LoadError> {
        self.check()?;
        let description = description::load(path.as_ref())?;
        let animation = self.wanted.animation.as_deref();
        description.check_animation(animation).map_err(|names| {
            let found = format!("there is no animation `{}`", animation.unwrap_or_default());
            let place = Place::File(description.path.clone());
            Diagnostic::error(place, found).expected(names).remedy("choose another animation, or none")
        })?;
        Ok(Scene::resolve(description, &self.wanted, &Baking::ALONE)?)
    }

    fn check(&self) -> Result<(), Diagnostic> {
        let error = |found: String, expected: &str| {
            Diagnostic::error(Place::Nowhere, found).expected(expected).remedy("change the scene's options")
        };
        if let Some(FrameRate { numerator, denominator }) = self.wanted.frame_rate
            && (numerator == 0 || denominator == 0)
        {
            return Err(error(format!("{numerator}/{denominator} frames a second"), "two numbers above 0"));
        }
        if let Some(Size { width, height }) = self.wanted.size
            && (width == 0 || height == 0)
        {
            return Err(error(format!("a size of {width} x {height} pixels"), "at least one pixel"));
        }
        Ok(())
    }
}
