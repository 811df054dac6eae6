//! A scene as a program holds it. In goes an input, out come frames, names and places. Invariant: a scene
//! that exists is valid, and its files are not read again.

use super::error::RenderError;
use super::viewer::Viewer;
use crate::description::Description;
use crate::diagnostic::{Diagnostic, Diagnostics};
use crate::export::{self, Exported};
use crate::frame_file;
use crate::indirect::KeptLight;
use crate::scene::{self, Baking, FrameRate, RenderSettings, ResolveOptions, Size};
use crate::snapshot::MeshTrees;
use sha2::{Digest, Sha256};
use std::fmt;
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

/// A scene in all its frames, and how it wants to be rendered.
pub struct Scene {
    pub(super) resolved: scene::Scene,
    pub(super) settings: RenderSettings,
    pub(super) options: ResolveOptions,
    /// SHA-256 over all input files; and over the camera that was brought along, if any.
    pub(super) content_hash: String,
    input_hash: String,
    /// Files that it was read from.
    files: Vec<PathBuf>,
    /// Built as frames need them.
    trees: OnceLock<MeshTrees>,
    /// Indirect light of the last frame.
    light: KeptLight,
}

impl fmt::Debug for Scene {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Scene").field("name", &self.settings.name).finish_non_exhaustive()
    }
}

/// Placement of a node at a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct NodePlace {
    /// Origin in the world, metres, Y up.
    pub position_m: [f64; 3],
    /// Axes x, y and z of the node in the world, lengths included.
    pub axes: [[f64; 3]; 3],
    /// Whether it and all that it follows take part in the picture.
    pub visible: bool,
}

impl Scene {
    /// Warnings: requests that are not honoured, or only nearly, and choices where the input says nothing.
    pub fn warnings(&self) -> impl Iterator<Item = &Diagnostic> {
        self.resolved.remarks.told()
    }

    /// First and last frame of what the input calls its own.
    pub fn frames(&self) -> RangeInclusive<i64> {
        self.settings.frames.clone()
    }

    /// Frames a second.
    pub fn frame_rate(&self) -> FrameRate {
        self.settings.frame_rate
    }

    /// Size of its pictures unless somebody wants another.
    pub fn size(&self) -> Size {
        self.settings.size
    }

    /// Names of the cameras, at least one; the first looks unless somebody wants another.
    pub fn cameras(&self) -> impl Iterator<Item = &str> {
        self.resolved.cameras.iter().map(|camera| camera.name.as_str())
    }

    /// Names of all nodes, parents before children: objects, leaves, cameras, lights.
    pub fn nodes(&self) -> impl Iterator<Item = &str> {
        self.resolved.nodes.iter().map(|node| node.name.as_str())
    }

    /// Placement of the first node of that name at a frame, or between two; none if there is no such node.
    pub fn place(&self, node: &str, frame: f64) -> Option<NodePlace> {
        let index = self.nodes().position(|name| name == node)?;
        let placement = self.resolved.placements(self.settings.frame_rate.seconds(frame))[index];
        let world = placement.world_from_node;
        Some(NodePlace {
            position_m: world.translation.to_array(),
            axes: world.matrix3.to_cols_array_2d(),
            visible: placement.visible,
        })
    }

    /// Built when a frame first needs them, kept for all.
    pub(super) fn trees(&self) -> &MeshTrees {
        self.trees.get_or_init(|| MeshTrees::new(&self.resolved))
    }

    /// Light of the last frame, for the next one if it is the same.
    pub(super) fn light(&self) -> &KeptLight {
        &self.light
    }

    /// Writes it as a binary glTF file, whole or not at all: meshes shared, motion as keys over `frames`.
    /// Read back, it gives the same pictures but for what is returned.
    ///
    /// # Errors
    /// If it does not fit into a glTF file or the disk says no.
    pub fn write_glb(
        &self,
        path: impl AsRef<Path>,
        frames: RangeInclusive<i64>,
    ) -> Result<Vec<Diagnostic>, RenderError> {
        let path = path.as_ref();
        let folder = path.parent().unwrap_or(Path::new(""));
        let exported = self.export(frames, folder).map_err(|error| RenderError::Export(Box::new(error)))?;
        frame_file::write_whole(path, &[&exported.head, &exported.binary])?;
        Ok(exported.remarks.told().cloned().collect())
    }

    /// SHA-256 over all input files, in hexadecimal digits.
    pub fn content_hash(&self) -> &str {
        &self.content_hash
    }
}

// What the program asks of it beside.
#[doc(hidden)]
impl Scene {
    pub fn resolve(
        description: Description,
        options: &ResolveOptions,
        baking: &Baking,
    ) -> Result<Self, Diagnostics> {
        let content_hash = description.content_hash.clone();
        let files = description.files.clone();
        let (resolved, settings) = scene::resolve_telling(description, options, baking)?;
        let settings = options.overrule(&settings);
        let (trees, light) = (OnceLock::new(), KeptLight::default());
        let (options, input_hash) = (options.clone(), content_hash.clone());
        Ok(Self { resolved, settings, options, content_hash, input_hash, files, trees, light })
    }

    /// Has a camera that a program brings along, in place of the last such; without one it is as its files
    /// say.
    pub fn look_from(&mut self, viewer: Option<&Viewer>) {
        let Some(viewer) = viewer else { return self.content_hash.clone_from(&self.input_hash) };
        viewer.put_into(&mut self.resolved);
        let said = format!("{} {viewer:?}", self.input_hash);
        self.content_hash = Sha256::digest(said).iter().map(|byte| format!("{byte:02x}")).collect();
    }

    /// Export as a glTF file for a folder, with its motion over some frames.
    pub fn export(&self, frames: RangeInclusive<i64>, folder: &Path) -> Result<Exported, Diagnostic> {
        export::glb(&self.resolved, &RenderSettings { frames, ..self.settings.clone() }, folder)
    }

    /// Files that it was read from.
    pub fn files(&self) -> &[PathBuf] {
        &self.files
    }

    pub fn resolved(&self) -> &scene::Scene {
        &self.resolved
    }

    pub fn settings(&self) -> &RenderSettings {
        &self.settings
    }
}
