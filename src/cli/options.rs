//! Options of a scene by a command's flags. In go arguments, out come options. Invariant: flags that
//! change what a camera or light that is made up has to serve are among them.

use super::arguments::{ExportArguments, SceneArguments};
use super::parse::SizeArgument;
use super::words::Switch;
use sunfleck::scene::{FrameRate, ResolveOptions, Size};

impl ExportArguments {
    /// Options by these flags. Whoever reads the file lights it if it has no light, so it gets none unless
    /// it is to have it.
    pub(super) fn options(&self) -> ResolveOptions {
        let no_default_light = self.scene.default_light != Some(Switch::On);
        ResolveOptions { frame_rate: self.fps, no_default_light, ..self.scene.options() }
    }
}

/// Options of commands that look at the scene through a camera.
pub(super) fn seen(
    scene: &SceneArguments,
    size: Option<SizeArgument>,
    frame_rate: Option<FrameRate>,
    camera: Option<&String>,
) -> ResolveOptions {
    let size = size.and_then(SizeArgument::pixels);
    ResolveOptions { size, frame_rate, camera: camera.cloned(), ..scene.options() }
}

impl SizeArgument {
    /// A size that is none of the input's own shape.
    fn pixels(self) -> Option<Size> {
        match self {
            Self::Pixels(size) => Some(size),
            Self::Percent(_) => None,
        }
    }
}
