//! The meshes below folders, and selections of them.

use std::path::{Path, PathBuf};

use hullwright_formats::Format;

/// A mesh file, and its name in tables.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct Mesh {
    /// Folder and file, with `/`.
    pub name: String,
    pub path: PathBuf,
    pub bytes: u64,
    /// Of the file's bytes, in hexadecimal.
    pub hash: String,
}

/// All meshes below the folders, by name. A file may be given too.
pub fn find(folders: &[PathBuf]) -> Result<Vec<Mesh>, String> {
    let mut meshes = Vec::new();
    for folder in folders {
        let mut files = Vec::new();
        if folder.is_dir() {
            collect(folder, &mut files)?;
        } else if folder.is_file() {
            files.push(folder.clone());
        } else {
            return Err(format!("{}: there is no such folder", folder.display()));
        }
        for path in files {
            let name = name(folder, &path);
            let bytes = std::fs::read(&path).map_err(|e| format!("{}: {e}", path.display()))?;
            meshes.push(Mesh { name, path, bytes: bytes.len() as u64, hash: hash(&bytes) });
        }
    }
    meshes.sort();
    meshes.dedup_by(|a, b| a.name == b.name);
    if meshes.is_empty() { Err("there is no mesh below the folders".into()) } else { Ok(meshes) }
}

/// The folder in a mesh's name; nothing where there is none.
pub fn folder(name: &str) -> &str {
    name.rsplit_once('/').map_or("", |(folder, _)| folder)
}

/// So many meshes: one of each folder, the one in its middle, and the others evenly spread over the
/// list. More, if there are more folders.
pub fn spread_over_folders(meshes: Vec<Mesh>, count: usize) -> Vec<Mesh> {
    let (mut taken, mut rest) = (Vec::new(), Vec::new());
    for group in meshes.chunk_by(|a, b| folder(&a.name) == folder(&b.name)) {
        for (index, mesh) in group.iter().enumerate() {
            let list = if index == group.len() / 2 { &mut taken } else { &mut rest };
            list.push(mesh.clone());
        }
    }
    let others = count.saturating_sub(taken.len());
    taken.extend(spread(rest, others));
    taken.sort();
    taken
}

/// So many meshes, evenly spread over the list.
pub fn spread(meshes: Vec<Mesh>, count: usize) -> Vec<Mesh> {
    let all = meshes.len();
    if all <= count {
        return meshes;
    }
    let is_taken = |index: usize| (index * count) / all != ((index + 1) * count) / all;
    meshes.into_iter().enumerate().filter(|(i, _)| is_taken(*i)).map(|(_, mesh)| mesh).collect()
}

/// Says which files are meshes, in the help of a command that takes them.
pub fn files_help() -> String {
    format!("The meshes: {}", Format::suffix_list())
}

/// The same of a command that takes folders.
pub fn folders_help() -> String {
    format!("Folders with meshes: {}", Format::suffix_list())
}

/// Adds all mesh files below a folder.
pub fn collect(folder: &Path, files: &mut Vec<PathBuf>) -> Result<(), String> {
    let entries =
        std::fs::read_dir(folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    for entry in entries {
        let path = entry.map_err(|error| format!("{}: {error}", folder.display()))?.path();
        if path.is_dir() {
            collect(&path, files)?;
        } else if Format::from_path(&path).is_some() {
            files.push(path);
        }
    }
    Ok(())
}

/// The path below the folder, and before it the folder's own name where that is all.
fn name(folder: &Path, path: &Path) -> String {
    let below = path.strip_prefix(folder).unwrap_or(path);
    let mut parts: Vec<String> =
        below.components().map(|part| part.as_os_str().to_string_lossy().into_owned()).collect();
    if parts.len() < 2 {
        let parent = if path == folder { path.parent() } else { Some(folder) };
        // A folder such as `.` gets its name from where it really is.
        let parent = parent.and_then(|parent| parent.canonicalize().ok());
        let file = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        parts = vec![file];
        if let Some(name) = parent.as_deref().and_then(Path::file_name) {
            parts.insert(0, name.to_string_lossy().into_owned());
        }
    }
    parts.join("/")
}

/// FNV-1a: enough to see that a file is another one.
fn hash(bytes: &[u8]) -> String {
    const BASIS: u64 = 0xcbf2_9ce4_8422_2325;
    const PRIME: u64 = 0x0000_0100_0000_01b3;
    let hash = bytes.iter().fold(BASIS, |hash, &b| (hash ^ u64::from(b)).wrapping_mul(PRIME));
    format!("{hash:016x}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn meshes_are_named_by_folder_and_file_however_they_are_given() {
        let root = tempfile::tempdir().unwrap();
        let folder = root.path().join("meshes/princeton");
        std::fs::create_dir_all(&folder).unwrap();
        for file in ["3.off", "10.off", "notes.txt"] {
            std::fs::write(folder.join(file), "OFF").unwrap();
        }
        let names = |path: PathBuf| -> Vec<String> {
            find(&[path]).unwrap().into_iter().map(|mesh| mesh.name).collect()
        };
        let expected = ["princeton/10.off", "princeton/3.off"];
        assert_eq!(names(root.path().join("meshes")), expected);
        assert_eq!(names(folder.clone()), expected);
        assert_eq!(names(folder.join("3.off")), ["princeton/3.off"]);
        assert!(find(&[root.path().join("nothing")]).is_err());
    }

    #[test]
    fn a_spread_over_folders_leaves_none_out() {
        let mesh =
            |name: String| Mesh { name, path: PathBuf::new(), bytes: 0, hash: String::new() };
        let mut all: Vec<Mesh> = (0..90).map(|i| mesh(format!("large/{i:03}"))).collect();
        all.extend((0..3).map(|i| mesh(format!("small/{i}"))));
        let few = spread_over_folders(all.clone(), 4);
        let names: Vec<&str> = few.iter().map(|mesh| mesh.name.as_str()).collect();
        assert!(names.iter().any(|name| name.starts_with("small/")), "{names:?}");
        assert_eq!(names.len(), 4);
        assert_eq!(spread_over_folders(all, 1).len(), 2);
    }

    #[test]
    fn a_spread_is_even() {
        let mesh = |i: usize| Mesh {
            name: format!("{i:03}"),
            path: PathBuf::new(),
            bytes: 0,
            hash: String::new(),
        };
        let all: Vec<Mesh> = (0..100).map(mesh).collect();
        let few = spread(all.clone(), 10);
        assert_eq!(few.len(), 10);
        assert_eq!(few[1].name, "019");
        assert_eq!(spread(all.clone(), 1000), all);
    }
}
