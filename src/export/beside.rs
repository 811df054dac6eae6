//! URIs of files beside a glTF file. In goes a path, out comes its URI. Invariant: the URI is relative to the
//! glTF file's folder, in any working directory.

use std::fmt::Write;
use std::path::{Component, Path, PathBuf};

/// URI of a file, relative to a folder. The placeholder of a sequence's number stays as it is.
pub(super) fn uri(file: &Path, folder: &Path) -> String {
    let (from, to) = (real(folder), real(file.parent().unwrap_or(Path::new(""))));
    let common = from.components().zip(to.components()).take_while(|(from, to)| from == to).count();
    let mut parts = vec![Component::ParentDir; from.components().count() - common];
    parts.extend(to.components().skip(common));
    let relative: PathBuf = parts.into_iter().chain(file.file_name().map(Component::Normal)).collect();
    let mut uri = String::new();
    for byte in relative.to_string_lossy().replace('\\', "/").bytes() {
        match byte {
            b'/' | b'-' | b'.' | b'_' | b'~' => uri.push(char::from(byte)),
            _ if byte.is_ascii_alphanumeric() => uri.push(char::from(byte)),
            _ => write!(uri, "%{byte:02X}").unwrap_or_default(),
        }
    }
    uri
}

/// Folder with links resolved, so that `..` leads to its real parent.
fn real(folder: &Path) -> PathBuf {
    let folder = if folder == Path::new("") { Path::new(".") } else { folder };
    folder.canonicalize().or_else(|_| std::path::absolute(folder)).unwrap_or_else(|_| folder.to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn uris_lead_from_one_folder_to_another() {
        let root = tempfile::tempdir().expect("a folder");
        let (scenes, out) = (root.path().join("my scenes"), root.path().join("out/shot"));
        for folder in [&scenes, &out] {
            std::fs::create_dir_all(folder).expect("made");
        }
        let file = scenes.join("mist.####.vdb");
        assert_eq!(uri(&file, &scenes), "mist.%23%23%23%23.vdb");
        assert_eq!(uri(&file, &out), "../../my%20scenes/mist.%23%23%23%23.vdb");
        assert_eq!(uri(Path::new("mist.vdb"), Path::new("")), "mist.vdb");
    }
}
