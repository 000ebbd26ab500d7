//! `.hulls`: a decomposition in a file, so that a game decomposes nothing when it starts.
//!
//! [`HullsFile::part`] says which primitive of the mesh, and so which material, a hull is made of.
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
//! | requested bound | optional `f64` |
//! | verified errors: protrusion, uncovered distance | optional, `f64` each |
//! | mass properties: what from (byte), mass, centre, inertia (xx, yy, zz, xy, xz, yz) | optional, `f64` each |
//! | number of hulls | `u32` |
//! | per hull: component `u32`; volume, added thickness, simplification growth `f64`; verified protrusion, optional `f64`; number of points, number of triangles `u32`; points; triangles | |
//!
//! Since version 2 a file may say what its hulls are made of. One that does not is written in
//! version 1, without this end of the body. A number is LEB128 of at most 32 bits here, a text its
//! length (a number) and UTF-8:
//!
//! | what | type |
//! |---|---|
//! | number of parts of the mesh | number |
//! | per part: name of the mesh, number of the primitive, name of the material | text, number, text |
//! | per hull, if there are several parts: number of shares; per share, the largest first: part, and if the hull has several, the share in single precision | numbers, shares `f32` |
//!
//! A `.hullscene` file ([`HullScene`], feature `scene`) holds all meshes of a scene. It has the
//! same header with other first bytes (`89 48 55 4C 53 43 0D 0A`) and this body:
//!
//! | what | type |
//! |---|---|
//! | name of the scene | text |
//! | number of meshes | `u32` |
//! | per mesh: number of names `u32`, names (texts); since version 2 indices of glTF meshes (number, then each, `u32`), and the bounding box, an optional pair of points of three `f32`; hash of the mesh, 32 bytes; parameters as text; length (`u32`) and bytes of a whole `.hulls` file | |
//! | since version 2 number of meshes with triangles | `u32` |
//! | per such mesh: indices of glTF meshes, as above; number of points, points of three `f32`; number of corners, corners (indices of points), three in succession a triangle | `u32` each |
//!
//! | since version 4 number of surfaces | `u32` |
//! | per surface: bound `f32`; number of parts; per part hash of the mesh, 32 bytes, number of primitives, columns of its place and translation, four points of three `f32`; points and corners, as above; number of ends, ends | `u32` each |
//!
//! It has version 4 where it has surfaces, else version 3 where one of its `.hulls` files has
//! version 2, and else version 2. It has a
//! suffix of its own since engines choose the type of an asset by it.
//!
//! Reading promises: no panic on any bytes, no allocation that the file's size does not justify,
//! and nothing out of range in what is returned: indices name points, numbers are finite.

mod file;
#[cfg(feature = "scene")]
mod mesh_hash;
mod parts;
#[cfg(feature = "scene")]
mod scene;
#[cfg(feature = "scene")]
mod surfaces;

#[cfg(feature = "scene")]
pub use file::SCENE_FORMAT_VERSION;
pub(crate) use file::without_sources;
pub use file::{FORMAT_VERSION, HullsFile, HullsFileError, VerifiedErrors};
#[cfg(feature = "scene")]
pub use mesh_hash::MeshHash;
pub use parts::MeshPart;
#[cfg(feature = "scene")]
pub use scene::{BakedMesh, BakedTriangles, HullScene, SceneLookup};
#[cfg(feature = "scene")]
pub use surfaces::{BakedSurface, PlacedMesh, surface_key};
