//! `.hulls`: a decomposition in a file, so that a game decomposes nothing when it starts.
//!
//! Binary, little endian, versioned and checksummed:
//!
//! | bytes | what |
//! |---|---|
//! | 8 | `89 48 55 4C 4C 53 0D 0A`, as PNG's: shows a transfer as text |
//! | 4 | version of the format, `u32` |
//! | 4 | [`ALGORITHM_VERSION`](crate::ALGORITHM_VERSION) of the library that decomposed, `u32` |
//! | 8 | length of the body in bytes, `u64` |
//! | … | body |
//! | 4 | CRC-32 (IEEE) of all before it, `u32` |
//!
//! Body; a text is its length (`u32`) and UTF-8, an optional value a byte 0 or 1 and then the
//! value if 1, a point three `f64`, a triangle three `u32`:
//!
//! | what | type |
//! |---|---|
//! | name of the mesh, name of the method | texts |
//! | vertices and triangles of the mesh | `u64` each |
//! | diagonal of the mesh | `f64` |
//! | bound that was asked for | optional `f64` |
//! | verified errors: protrusion, uncovered distance | optional, `f64` each |
//! | mass properties: what from (byte), mass, centre, inertia (xx, yy, zz, xy, xz, yz) | optional, `f64` each |
//! | number of hulls | `u32` |
//! | per hull: component `u32`; volume, added thickness, simplification growth `f64`; verified protrusion, optional `f64`; number of points, number of triangles `u32`; points; triangles | |
//!
//! A `.hullscene` file ([`HullScene`], feature `bake`) holds all meshes of a scene. It has the same header
//! with other first bytes (`89 48 55 4C 53 43 0D 0A`) and this body:
//!
//! | what | type |
//! |---|---|
//! | name of the scene | text |
//! | number of meshes | `u32` |
//! | per mesh: number of names `u32`, names (texts); hash of the mesh, 32 bytes; parameters as text; length (`u32`) and bytes of a whole `.hulls` file | |
//!
//! It has a suffix of its own since engines choose the type of an asset by it.
//!
//! Reading promises: no panic on any bytes, no allocation that the file's size does not justify,
//! and nothing out of range in what is returned: indices name points, numbers are finite.

#[cfg(feature = "bake")]
mod mesh_hash;
mod read;
#[cfg(feature = "bake")]
mod scene;
#[cfg(test)]
mod tests;
mod write;

use std::path::Path;

use crate::decomposition::{Decomposition, Hull, Provenance};
use crate::mass::MassProperties;

#[cfg(feature = "bake")]
pub use mesh_hash::MeshHash;
#[cfg(feature = "bake")]
pub use scene::{BakedMesh, HullScene, SceneLookup};

/// Version of the format that is written, and the newest that is read.
pub const FORMAT_VERSION: u32 = 1;

const MAGIC: [u8; 8] = *b"\x89HULLS\r\n";

const SCENE_MAGIC: [u8; 8] = *b"\x89HULSC\r\n";

/// Magic number, two versions, length of the body.
const HEADER: usize = 24;

const CHECKSUM: usize = 4;

/// Hulls, and what a game needs to know of how they came about.
#[non_exhaustive]
#[derive(Debug, Clone, PartialEq)]
pub struct HullsFile {
    /// The mesh's name; may be empty.
    pub name: String,
    /// [`ALGORITHM_VERSION`](crate::ALGORITHM_VERSION) of the library that decomposed.
    pub algorithm_version: u32,
    /// The method's name.
    pub method: String,
    /// Vertices of the mesh.
    pub source_vertices: u64,
    /// Triangles of the mesh.
    pub source_triangles: u64,
    /// Diagonal of the mesh's bounding box, in its units.
    pub diagonal: f64,
    /// The bound that was asked for, in units; `None` if the method has none.
    pub bound: Option<f64>,
    /// What was verified against the mesh; `None` if the method verifies nothing.
    pub verified: Option<VerifiedErrors>,
    /// Mass properties of the mesh.
    pub mass_properties: Option<MassProperties>,
    /// The hulls. Which triangles of the mesh they stand for is not kept:
    /// [`source_triangles`](crate::Provenance::source_triangles) is empty.
    pub hulls: Vec<Hull>,
}

/// Distances that were verified against the mesh, in its units.
#[non_exhaustive]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VerifiedErrors {
    /// No point of a hull's surface is farther outside the solid.
    pub protrusion_max: f64,
    /// No point of the mesh's surface is farther outside every hull.
    pub uncovered_max: f64,
}

/// Why a `.hulls` file can't be read or written.
#[non_exhaustive]
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum HullsFileError {
    /// The bytes don't begin as a `.hulls` file does.
    #[error("it is no .hulls file")]
    NotHulls,
    /// It holds a scene, where a single mesh is expected.
    #[error("it is a .hullscene file, which holds the meshes of a scene instead of one")]
    IsScene,
    /// The bytes don't begin as a `.hullscene` file does.
    #[error("it is no .hullscene file")]
    NotScene,
    /// It holds a single mesh, where a scene is expected.
    #[error(
        "it is a .hulls file, which holds one mesh and not what it was made from; bake the scene \
         anew, or load it as a single mesh"
    )]
    IsSingle,
    /// A newer library wrote it.
    #[error("its format has version {found}, but this library reads up to {FORMAT_VERSION}")]
    NewerVersion {
        /// The file's version.
        found: u32,
    },
    /// Its length is not the one that its header says.
    #[error("it has {found} bytes instead of {expected}")]
    WrongLength {
        /// The length by its header.
        expected: u64,
        /// The length that it has.
        found: u64,
    },
    /// Its bytes have changed since it was written.
    #[error("its checksum does not match: it is damaged")]
    Damaged,
    /// A value means nothing, though the checksum matches.
    #[error("{0}")]
    Invalid(&'static str),
    /// The file system refused.
    #[error("{path}: {reason}")]
    File {
        /// The path, as given.
        path: String,
        /// What it said.
        reason: String,
    },
    /// Something is wrong with the file at a path.
    #[error("{path}: {error}")]
    At {
        /// The path, as given.
        path: String,
        /// What is wrong.
        #[source]
        error: Box<HullsFileError>,
    },
}

impl HullsFile {
    /// What is worth keeping of a decomposition, without mass properties.
    pub fn new(name: impl Into<String>, decomposition: &Decomposition) -> Self {
        let Decomposition { hulls, report, .. } = decomposition;
        let bounded = report.bounded.as_ref();
        Self {
            name: name.into(),
            algorithm_version: report.algorithm_version,
            method: report.method.name().into(),
            source_vertices: report.source_vertices as u64,
            source_triangles: report.source_triangles as u64,
            diagonal: report.diagonal,
            bound: bounded.map(|bounded| bounded.bound),
            verified: bounded.map(|bounded| VerifiedErrors {
                protrusion_max: bounded.protrusion_max,
                uncovered_max: bounded.uncovered_max,
            }),
            mass_properties: None,
            hulls: hulls
                .iter()
                .map(|hull| Hull {
                    provenance: Provenance {
                        component: hull.provenance.component,
                        source_triangles: Vec::new(),
                    },
                    ..hull.clone()
                })
                .collect(),
        }
    }

    /// The same with mass properties of the mesh.
    #[must_use]
    pub fn with_mass_properties(mut self, properties: MassProperties) -> Self {
        self.mass_properties = Some(properties);
        self
    }

    /// Whether the library decomposes in the same way as the one that wrote the file.
    pub fn is_current(&self) -> bool {
        self.algorithm_version == crate::ALGORITHM_VERSION
    }

    /// The bytes of the file. O(size).
    ///
    /// # Errors
    /// [`HullsFileError::Invalid`] if a hull, a text or a list has more parts than 32 bits count.
    pub fn to_bytes(&self) -> Result<Vec<u8>, HullsFileError> {
        write::to_bytes(self)
    }

    /// Reads the bytes of a file. O(size).
    ///
    /// # Errors
    /// [`HullsFileError`] says what is wrong with them.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, HullsFileError> {
        read::from_bytes(bytes)
    }

    /// Writes the file, all or nothing: a file that is already there is replaced in one step.
    ///
    /// # Errors
    /// As [`to_bytes`](Self::to_bytes), and [`HullsFileError::File`] if writing fails.
    ///
    /// ```
    /// use hullwright::hulls_format::HullsFile;
    ///
    /// # let mesh = hullwright::TriangleMesh::new(
    /// #     vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
    /// #     vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]],
    /// # );
    /// # let (parameters, control) = (hullwright::Parameters::default(), hullwright::Control::new());
    /// # let decomposition = hullwright::decompose(&mesh, &parameters, &control)?;
    /// # let directory = tempfile::tempdir()?;
    /// let file = HullsFile::new("tetrahedron", &decomposition);
    /// let path = directory.path().join("tetrahedron.hulls");
    /// file.write(&path)?;
    /// assert_eq!(HullsFile::read(&path)?, file);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[cfg(feature = "fs")]
    pub fn write(&self, path: impl AsRef<Path>) -> Result<(), HullsFileError> {
        let path = path.as_ref();
        let bytes = self.to_bytes().map_err(|error| error.at(path))?;
        crate::atomic_write::write(path, &bytes).map_err(|error| file_error(path, &error))
    }

    /// Reads a file.
    ///
    /// # Errors
    /// [`HullsFileError::File`] if it can't be read, [`HullsFileError::At`] if it does not hold
    /// what it should.
    pub fn read(path: impl AsRef<Path>) -> Result<Self, HullsFileError> {
        let path = path.as_ref();
        let bytes = std::fs::read(path).map_err(|error| file_error(path, &error))?;
        Self::from_bytes(&bytes).map_err(|error| error.at(path))
    }
}

impl HullsFileError {
    fn at(self, path: &Path) -> Self {
        Self::At { path: path.display().to_string(), error: Box::new(self) }
    }
}

fn file_error(path: &Path, error: &std::io::Error) -> HullsFileError {
    HullsFileError::File { path: path.display().to_string(), reason: error.to_string() }
}
