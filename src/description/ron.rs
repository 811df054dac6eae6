//! stub
use super::{Files, LoadError};
use std::path::{Path, PathBuf};
/// stub
#[derive(Debug)]
pub struct SequenceFile {
    /// stub
    pub scene_path: PathBuf,
}
/// stub
#[derive(Debug)]
pub struct LoadedScene {}
/// stub
#[derive(Debug)]
pub enum RonFile {
    /// stub
    Scene(LoadedScene),
    /// stub
    Sequence(SequenceFile),
}
/// stub
pub fn load(_path: &Path, _files: &mut Files) -> Result<RonFile, LoadError> {
    Ok(RonFile::Scene(LoadedScene {}))
}
/// stub
pub fn load_scene(_path: &Path, _files: &mut Files) -> Result<LoadedScene, LoadError> {
    Ok(LoadedScene {})
}
