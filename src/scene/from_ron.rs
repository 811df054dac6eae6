//! stub
use super::{RenderSettings, Scene};
use crate::description::ron::{LoadedScene, SequenceFile};
use crate::diagnostic::Diagnostics;
pub(super) fn resolve(
    _scene: LoadedScene,
    _sequence: Option<SequenceFile>,
) -> Result<(Scene, RenderSettings), Diagnostics> {
    Ok((Scene::default(), RenderSettings::default()))
}
pub(super) fn apply_sequence(
    _sequence: SequenceFile,
    _scene: &Scene,
    settings: RenderSettings,
) -> Result<RenderSettings, Diagnostics> {
    Ok(settings)
}
