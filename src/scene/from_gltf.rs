//! stub
use super::{LightUnits, RenderSettings, Scene};
use crate::description::gltf::GltfScene;
use crate::diagnostic::Diagnostics;
pub(super) fn resolve(
    _scene: GltfScene,
    _units: Option<LightUnits>,
) -> Result<(Scene, RenderSettings), Diagnostics> {
    Ok((Scene::default(), RenderSettings::default()))
}
