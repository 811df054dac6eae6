//! Options of whoever loads a scene. In go choices, out comes the scene. Invariant: a choice that is not
//! made leaves what the input says.

use super::scene::Scene;
use crate::description::{self, LoadError};
use crate::diagnostic::{Diagnostic, Place};
use crate::scene::{Baking, FrameRate, LightUnits, ResolveOptions, Size};
use std::path::Path;

/// Choices about how an input is read; [`Scene::options`] starts with none.
#[derive(Clone, Debug, Default)]
pub struct SceneOptions {
    wanted: ResolveOptions,
}

impl Scene {
    /// Loads a scene or sequence by its extension: `.ron`, `.glb`, `.gltf`, `.obj`. Works on
    /// the current rayon pool.
    ///
    /// # Errors
    /// If a file cannot be read, or with all that is wrong with what was found in it.
    pub fn load(path: impl AsRef<Path>) -> Result<Self, LoadError> {
        Self::options().load(path)
    }

    /// Choices to load with.
    pub fn options() -> SceneOptions {
        SceneOptions::default()
    }
}

impl SceneOptions {
    /// Animation of a glTF file that plays: its name, its number from 0, or `all`.
    #[must_use]
    pub fn animation(mut self, name: &str) -> Self {
        self.wanted.animation = Some(name.to_owned());
        self
    }

    /// Units of the lights of a glTF file.
    #[must_use]
    pub fn light_units(mut self, units: LightUnits) -> Self {
        self.wanted.light_units = Some(units);
        self
    }

    /// Whether a glTF or OBJ file without light gets a sun and a sky; without a choice it does.
    #[must_use]
    pub fn default_light(mut self, is_on: bool) -> Self {
        self.wanted.no_default_light = !is_on;
        self
    }

    /// Whether a sun in the picture of a sky lights as a `Sun` does; without a choice it does.
    #[must_use]
    pub fn sky_sun(mut self, is_apart: bool) -> Self {
        self.wanted.keep_sky_suns = !is_apart;
        self
    }

    /// Pixels of the whole picture. A camera that is made up for a file without one looks so that all
    /// is seen in this shape.
    #[must_use]
    pub fn size(mut self, width: usize, height: usize) -> Self {
        self.wanted.size = Some(Size { width, height });
        self
    }

    /// Frames a second, as a fraction such as 24000/1001.
    #[must_use]
    pub fn frame_rate(mut self, numerator: u32, denominator: u32) -> Self {
        self.wanted.frame_rate = Some(FrameRate { numerator, denominator });
        self
    }

    /// Name of the camera that looks.
    #[must_use]
    pub fn camera(mut self, name: &str) -> Self {
        self.wanted.camera = Some(name.to_owned());
        self
    }

    /// Loads a scene or sequence by its extension: `.ron`, `.glb`, `.gltf`, `.obj`. Works on
    /// the current rayon pool.
    ///
    /// # Errors
    /// If a file cannot be read, or with all that is wrong with what was found in it; if a
    /// choice cannot be met.
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
