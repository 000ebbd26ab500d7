//! Writes meshes in every format that is read, all or nothing.

use std::fmt::Write;
use std::path::Path;

use hullwright::{Error, MeshView};

use crate::atomic_write::write_file;
use crate::mesh_file::{Format, NamedMesh, is_mesh_output, mesh_suffix_list};
use crate::vector::Vector;
use crate::write::{check_directory, glb_of, obj_of};

/// Writes meshes to a file, with their names where the format has some. A file that is already
/// there is replaced; if anything goes wrong it stays as it was.
///
/// | suffix | what |
/// |---|---|
/// | `obj` | an object for each, without a colour |
/// | `glb` | a node for each, in its colour, as of [`write_hulls`](crate::write_hulls) |
/// | `stl` | text; a solid for each |
/// | `off`, `ply` | text; one mesh of all |
///
/// Coordinates in text are read back as the same `f64`; those of GLB are `f32` relative to the
/// centre of all, so that they are rounded by up to 0.00001 % of the extent.
///
/// # Errors
/// [`Error::File`] if the suffix is another, if the directory does not exist, if a coordinate is too
/// large for the format, or if writing fails.
///
/// ```
/// # let mesh = hullwright::TriangleMesh::new(vec![[0.0; 3], [1.0; 3], [0.0, 0.0, 0.3]], vec![[0, 1, 2]]);
/// # let directory = tempfile::tempdir().expect("a temporary directory");
/// # let path = directory.path().join("mesh.ply");
/// use hullwright_formats::{NamedMesh, read_mesh, write_meshes};
///
/// write_meshes(&path, &[NamedMesh { name: "roof".into(), mesh: mesh.clone() }])?;
/// assert_eq!(read_mesh(&path)?.mesh, mesh);
/// # Ok::<(), hullwright::Error>(())
/// ```
pub fn write_meshes(path: impl AsRef<Path>, meshes: &[NamedMesh]) -> Result<(), Error> {
    let path = path.as_ref();
    let named = || meshes.iter().map(|mesh| (mesh.name.replace(['\n', '\r'], " "), mesh.into()));
    let bytes = match written_format(path)? {
        Format::Obj => Ok(obj_of(named()).into_bytes()),
        Format::Off => Ok(off_of(&all_of(meshes)).into_bytes()),
        Format::Ply => Ok(ply_of(&all_of(meshes)).into_bytes()),
        Format::Stl => Ok(stl_of(named()).into_bytes()),
        Format::Gltf => glb_of("meshes", named().collect()),
    };
    write_file(path, &bytes.map_err(|reason| Error::file(path, reason))?)
}

/// Checks what [`write_meshes`] would refuse, before there is anything to write.
///
/// # Errors
/// [`Error::File`] if the suffix is another or if the directory does not exist.
pub fn check_mesh_output(path: impl AsRef<Path>) -> Result<(), Error> {
    let path = path.as_ref();
    written_format(path)?;
    check_directory(path)
}

fn written_format(path: &Path) -> Result<Format, Error> {
    let format = Format::from_path(path).filter(|_| is_mesh_output(path));
    format.ok_or_else(|| {
        Error::file(path, format!("meshes can be written as {}", mesh_suffix_list()))
    })
}

/// All vertices and triangles, one mesh after the other.
struct All {
    positions: Vec<[f64; 3]>,
    triangles: Vec<[usize; 3]>,
}

fn all_of(meshes: &[NamedMesh]) -> All {
    let mut all = All { positions: Vec::new(), triangles: Vec::new() };
    for NamedMesh { mesh, .. } in meshes {
        let first = all.positions.len();
        let moved = mesh.triangles.iter().map(|t| t.map(|vertex| first + vertex as usize));
        all.triangles.extend(moved);
        all.positions.extend(&mesh.positions);
    }
    all
}

/// Lines of vertices and of faces, as OFF and PLY have them.
fn lines_of(All { positions, triangles }: &All) -> String {
    let mut text = String::new();
    for [x, y, z] in positions {
        // Writing to a string can't fail.
        let _ = writeln!(text, "{x:?} {y:?} {z:?}");
    }
    for [a, b, c] in triangles {
        let _ = writeln!(text, "3 {a} {b} {c}");
    }
    text
}

fn off_of(all: &All) -> String {
    format!("OFF\n{} {} 0\n{}", all.positions.len(), all.triangles.len(), lines_of(all))
}

fn ply_of(all: &All) -> String {
    let (vertices, faces) = (all.positions.len(), all.triangles.len());
    format!(
        "ply\nformat ascii 1.0\nelement vertex {vertices}\nproperty double x\nproperty double y\n\
         property double z\nelement face {faces}\nproperty list uchar uint vertex_indices\n\
         end_header\n{}",
        lines_of(all)
    )
}

fn stl_of<'a>(meshes: impl Iterator<Item = (String, MeshView<'a>)>) -> String {
    let mut text = String::new();
    for (name, mesh) in meshes {
        let _ = writeln!(text, "solid {name}");
        for triangle in mesh.triangles() {
            let [a, b, c] =
                triangle.map(|vertex| mesh.position(vertex).map(Vector::from).unwrap_or_default());
            let normal = (b - a).cross(c - a).normalize_or_zero();
            let _ = writeln!(text, "facet normal {:?} {:?} {:?}", normal.x, normal.y, normal.z);
            text += "outer loop\n";
            for corner in [a, b, c] {
                let _ = writeln!(text, "vertex {:?} {:?} {:?}", corner.x, corner.y, corner.z);
            }
            text += "endloop\nendfacet\n";
        }
        let _ = writeln!(text, "endsolid {name}");
    }
    text
}
