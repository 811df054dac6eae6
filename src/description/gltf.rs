//! stub
use super::{Files, LoadError};
use std::path::Path;
/// stub
#[derive(Debug)]
pub struct GltfScene {}
/// stub
pub fn load(_path: &Path, _files: &mut Files) -> Result<GltfScene, LoadError> {
    Ok(GltfScene {})
}
