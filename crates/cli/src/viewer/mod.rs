//! A page that shows a mesh and its hulls in any browser .
//!
//! A [`Page`] holds a mesh and one or more [`HullSet`]s, which are shown side by side. With a
//! [`MergeTree`](hullwright::MergeTree) the page has a slider from all hulls down to one. It is one
//! HTML file that loads nothing: the viewer is built from `viewer/` in the repository, the geometry
//! follows as text.
//!
//! ```
//! # fn main() -> Result<(), hullwright::Error> {
//! use hullwright::{Control, MergeTree, Parameters, TriangleMesh, decompose};
//! use hullwright_cli::viewer::{HullSet, Page};
//!
//! let mesh = TriangleMesh::new(
//!     vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
//!     vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]],
//! );
//! let (parameters, control) = (Parameters::default(), Control::new());
//! let result = decompose(&mesh, &parameters, &control)?;
//! let tree = MergeTree::new(&mesh, &result, &parameters, &control)?;
//! let mut page = Page::new("tetrahedron", &mesh, &parameters, &control)?;
//! page.add(HullSet::new("bounded", &result.hulls).tree(&tree), &control)?;
//! assert!(page.to_html()?.starts_with("<!doctype html>"));
//! # Ok(())
//! # }
//! ```
//!
//! | file | contents |
//! |---|---|
//! | `subject` | the mesh: repaired, its openings closed, its surface sampled |
//! | `errors` | uncovered distance and overlap, join after join |
//! | `simplified` | a page about a mesh and a surface with fewer triangles |
//! | `hull_set` | hulls and all that they are joined to: shapes, figures, errors point by point |
//! | `document` | what the page reads, and how it is put into the page |

mod document;
mod errors;
mod hull_set;
mod simplified;
mod subject;

use std::path::Path;

use hullwright::{Control, Error, MeshView, Parameters};
use hullwright_formats::{Object, write_file};

use crate::unwritable;
use document::{Document, Geometry};
use subject::Subject;

pub use hull_set::{HullSet, hulls_of};
pub use simplified::{Simplified, SimplifiedPage};

/// A page about one mesh. See the [module](self).
pub struct Page<'a> {
    subject: Subject<'a>,
    document: Document,
    geometry: Geometry,
}

impl<'a> Page<'a> {
    /// A page without hulls yet. Of `parameters` the bound and the openings count: errors are shown
    /// against that bound, and the mesh with those openings closed; with a probe, what it does not
    /// reach is shown too.
    ///
    /// # Errors
    /// As [`close_openings`](hullwright::openings::close_openings).
    pub fn new(
        title: impl Into<String>,
        mesh: impl Into<MeshView<'a>>,
        parameters: &Parameters,
        control: &Control,
    ) -> Result<Self, Error> {
        let subject = Subject::new(mesh.into(), parameters, control)?;
        let mut geometry = Geometry::default();
        let mut document = Document::new(title.into(), &subject, &mut geometry);
        if let Some(filled) = subject.mesh.filled(control)? {
            document.show_filled(&filled, &subject, &mut geometry);
        }
        Ok(Self { subject, document, geometry })
    }

    /// Names parts of the mesh: each hull then says which of them it stands for.
    #[must_use]
    pub fn objects(mut self, objects: &[Object]) -> Self {
        self.document.name_objects(objects);
        self
    }

    /// Adds hulls, to the right of those that are there.
    ///
    /// Takes some seconds for hundreds of hulls with a tree: all joint hulls are compared with the
    /// mesh, point by point, on rayon's current pool.
    ///
    /// # Errors
    /// As [`measure`](hullwright::measure::measure()).
    pub fn add(&mut self, set: HullSet<'_>, control: &Control) -> Result<(), Error> {
        let Self { subject, document, geometry } = self;
        document.sets.push(hull_set::shown(set, subject, &document.objects, geometry, control)?);
        Ok(())
    }

    /// The page as text: one file that loads nothing.
    ///
    /// # Errors
    /// [`Error::File`], without a path, if the figures can't be written as text.
    pub fn to_html(&self) -> Result<String, Error> {
        document::page(&self.document, &self.geometry).map_err(|error| unwritable("page", error))
    }

    /// What the page is filled with, for a viewer that has it from elsewhere: its text, and the
    /// bytes of its arrays.
    ///
    /// # Errors
    /// As [`to_html`](Self::to_html).
    pub fn data(&self) -> Result<(String, &[u8]), Error> {
        let text =
            serde_json::to_string(&self.document).map_err(|error| unwritable("page", error))?;
        Ok((text, self.geometry.bytes()))
    }

    /// Writes the page to a file, all or nothing.
    ///
    /// # Errors
    /// [`Error::File`] says what is wrong with the path.
    pub fn write(&self, path: impl AsRef<Path>) -> Result<(), Error> {
        write_file(path, self.to_html()?.as_bytes())
    }
}
