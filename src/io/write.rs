//! Writes hull sets, all or nothing.

use std::path::Path;

use crate::atomic_write;
use crate::error::Error;
use crate::geometry::MeshView;

use super::format::HullFormat;
use super::write_glb::glb_from_hulls;
use super::write_obj::obj_from_hulls;

/// Writes hulls to a file, for example `write_hulls(path, &decomposition.hulls)`. A file that is
/// already there is replaced; if anything goes wrong it stays as it was.
///
/// The suffix `obj` gives a Wavefront OBJ with the objects `hull_0`, `hull_1` and so on, and as
/// many digits as it takes to read back the same `f64`.
///
/// The suffix `glb` gives a binary glTF 2.0 with one node, mesh and colour (see
/// [`palette`](crate::render::palette)) per hull, named in the same way. Its coordinates are `f32`,
/// relative to the centre of all hulls, so that hulls far from the origin keep their shape; a
/// node `hulls` above the others moves them there.
///
/// `.hulls` files are written by [`HullsFile::write`](crate::hulls_format::HullsFile::write).
///
/// # Errors
/// [`Error::File`] if the suffix is another, if the directory does not exist, or if writing
/// fails.
///
/// ```
/// # let mesh = hullwright::TriangleMesh::new(
/// #     vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
/// #     vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]],
/// # );
/// # let (parameters, control) = (hullwright::Parameters::default(), hullwright::Control::new());
/// # let decomposition = hullwright::decompose(&mesh, &parameters, &control)?;
/// # let directory = tempfile::tempdir().expect("a temporary directory");
/// # let path = directory.path().join("hulls.glb");
/// hullwright::io::write_hulls(&path, &decomposition.hulls)?;
/// # Ok::<(), hullwright::Error>(())
/// ```
pub fn write_hulls<'a, H: Into<MeshView<'a>>>(
    path: impl AsRef<Path>,
    hulls: impl IntoIterator<Item = H>,
) -> Result<(), Error> {
    let path = path.as_ref();
    let bytes = match output_format(path)? {
        HullFormat::Obj => obj_from_hulls(hulls).into_bytes(),
        HullFormat::Glb => glb_from_hulls(hulls).map_err(|reason| Error::file(path, reason))?,
    };
    atomic_write::write(path, &bytes).map_err(|error| Error::file(path, error))
}

/// Checks what [`write_hulls`] or [`HullsFile::write`](crate::hulls_format::HullsFile::write) would
/// complain about before there is anything to write.
///
/// # Errors
/// [`Error::File`] if the suffix is neither that of a [`HullFormat`] nor `hulls`, or if the directory
/// does not exist.
pub fn check_output(path: impl AsRef<Path>) -> Result<(), Error> {
    let path = path.as_ref();
    if !super::is_hulls_file(path) {
        output_format(path)?;
    }
    let directory = atomic_write::directory(path);
    if directory.is_dir() {
        Ok(())
    } else {
        let reason = format!("the directory `{}` does not exist", directory.display());
        Err(Error::file(path, reason))
    }
}

fn output_format(path: &Path) -> Result<HullFormat, Error> {
    HullFormat::from_path(path).ok_or_else(|| {
        Error::file(path, format!("hulls can be written as {}", HullFormat::suffix_list()))
    })
}
