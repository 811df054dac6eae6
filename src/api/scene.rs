//! Scene in memory. In goes an input, out come frames, names and placements. Invariant: a scene that exists
//! is valid, and its files are not read again.

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

/// Scene with all its frames and its render settings.
pub struct Scene {
    pub(super) resolved: scene::Scene,
    pub(super) settings: RenderSettings,
    pub(super) options: ResolveOptions,
    /// SHA-256 over all input files, and over the viewer's camera, if there is one.
    pub(super) content_hash: String,
    input_hash: String,
    /// Files that it was read from.
    files: Vec<PathBuf>,
    /// Trees of the meshes, built when a frame first needs them.
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
    /// Whether the node and all its parents are visible.
    pub visible: bool,
}

impl Scene {
    /// Warnings: requests that are not honoured or only approximated, and assumptions where the input is
    /// silent.
    pub fn warnings(&self) -> impl Iterator<Item = &Diagnostic> {
        self.resolved.remarks.reported()
    }

    /// First and last frame of the input. A scene in code, or a scene file, has every frame; this is then
    /// `1..=1`.
    pub fn frames(&self) -> RangeInclusive<i64> {
        self.settings.frames.clone()
    }

    /// Frames a second, 24 by default. Frame `n` is at second `n / rate`, and second 0 is frame 0.
    pub fn frame_rate(&self) -> FrameRate {
        self.settings.frame_rate
    }

    /// Default size of its pictures; 960 x 540 unless the input says otherwise.
    pub fn size(&self) -> Size {
        self.settings.size
    }

    /// Names of the cameras, at least one. The first one renders by default.
    pub fn cameras(&self) -> impl Iterator<Item = &str> {
        self.resolved.cameras.iter().map(|camera| camera.name.as_str())
    }

    /// Names of all nodes, parents before children: objects, leaves, cameras, lights.
    pub fn nodes(&self) -> impl Iterator<Item = &str> {
        self.resolved.nodes.iter().map(|node| node.name.as_str())
    }

    /// Placement of the first node with that name at a frame, or between two; `None` without such a node.
    pub fn place(&self, node: &str, frame: f64) -> Option<NodePlace> {
        let index = self.nodes().position(|name| name == node)?;
        let placement = self.resolved.placement(index, self.settings.frame_rate.seconds(frame));
        let world = placement.world_from_node;
        Some(NodePlace {
            position_m: world.translation.to_array(),
            axes: world.matrix3.to_cols_array_2d(),
            visible: placement.visible,
        })
    }

    /// Trees of the meshes, built on first use.
    pub(super) fn trees(&self) -> &MeshTrees {
        self.trees.get_or_init(|| MeshTrees::new(&self.resolved))
    }

    /// Cache of the last frame's indirect light, for a next frame with the same contents.
    pub(super) fn light(&self) -> &KeptLight {
        &self.light
    }

    /// Writes a binary glTF file, whole or not at all: meshes shared, motion as keys over `frames`. Read
    /// back, it gives the same pictures, except for the returned losses.
    ///
    /// # Errors
    /// If it does not fit into a glTF file or the file cannot be written.
    pub fn write_glb(
        &self,
        path: impl AsRef<Path>,
        frames: RangeInclusive<i64>,
    ) -> Result<Vec<Diagnostic>, RenderError> {
        let path = path.as_ref();
        let folder = path.parent().unwrap_or(Path::new(""));
        let exported = self.export(frames, folder).map_err(|error| RenderError::Export(Box::new(error)))?;
        frame_file::write_whole(path, &[&exported.head, &exported.binary])?;
        Ok(exported.remarks.reported().cloned().collect())
    }

    /// SHA-256 over all input files, in hexadecimal digits.
    pub fn content_hash(&self) -> &str {
        &self.content_hash
    }
}

// Methods for the program alone.
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

    /// Replaces the camera by that of a viewer, or restores the file's without one.
    pub fn look_from(&mut self, viewer: Option<&Viewer>) {
        let Some(viewer) = viewer else { return self.content_hash.clone_from(&self.input_hash) };
        viewer.put_into(&mut self.resolved);
        let said = format!("{} {viewer:?}", self.input_hash);
        self.content_hash = Sha256::digest(said).iter().map(|byte| format!("{byte:02x}")).collect();
    }

    /// Drops keys of falls that only other times need; time in seconds.
    pub fn keep_span(&mut self, span_s: (f64, f64)) {
        self.resolved.keep_span(span_s);
    }

    /// Exports the scene as glTF for a folder, with its motion over some frames.
    pub fn export(&self, frames: RangeInclusive<i64>, folder: &Path) -> Result<Exported, Diagnostic> {
        export::glb(&self.resolved, &RenderSettings { frames, ..self.settings.clone() }, folder)
    }

    /// Files that the scene was read from.
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
