//! A page that shows a mesh and its hulls in any browser (feature `viewer`).
//!
//! A [`Page`] holds a mesh and one or more [`HullSet`]s, which are shown side by side. With a
//! [`MergeTree`] the page has a slider from all hulls down to one. It is one HTML file that loads
//! nothing: the viewer is built from `viewer/` in the repository, the geometry follows as text.
//!
//! ```
//! # fn main() -> Result<(), hullwright::Error> {
//! use hullwright::viewer::{HullSet, Page};
//! use hullwright::{Control, MergeTree, Parameters, TriangleMesh, decompose};
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
//! | `hull_set` | hulls and all that they are joined to: shapes, figures, errors point by point |
//! | `samples` | the points of a surface that an error is given at |
//! | `uncovered` | how far the surface is outside of the hulls, join after join |
//! | `overlap` | volume of intersection over union, join after join |
//! | `geometry` | arrays of numbers as compressed text |
//! | `document` | what the page reads, and how it is put into the page |

mod document;
mod geometry;
mod hull_set;
mod overlap;
mod samples;
mod subject;
mod uncovered;

use std::path::Path;

use crate::control::Control;
use crate::decomposition::Hull;
use crate::error::Error;
use crate::geometry::{MeshView, TriangleMesh};
use crate::hull::{ConvexHull, convex_hull};
use crate::io::{NamedMesh, Object};
use crate::merge_tree::MergeTree;
use crate::parallel;
use crate::parameters::Parameters;
use document::Document;
use geometry::Geometry;
use subject::Subject;

/// Hulls to be shown: of a method or of any tool.
#[derive(Debug, Clone)]
pub struct HullSet<'a> {
    name: String,
    hulls: &'a [Hull],
    tree: Option<&'a MergeTree>,
    facts: Vec<(String, String)>,
}

impl<'a> HullSet<'a> {
    /// Hulls under a name. Without a [`tree`](Self::tree) their errors are sampled.
    pub fn new(name: impl Into<String>, hulls: &'a [Hull]) -> Self {
        Self { name: name.into(), hulls, tree: None, facts: Vec::new() }
    }

    /// The joins of these very hulls: the page gets a slider from all hulls to one, and errors are
    /// verified.
    #[must_use]
    pub fn tree(mut self, tree: &'a MergeTree) -> Self {
        self.tree = Some(tree);
        self
    }

    /// A name and a value that are shown with the figures, such as `time` and `74 ms`.
    #[must_use]
    pub fn fact(mut self, name: impl Into<String>, value: impl Into<String>) -> Self {
        self.facts.push((name.into(), value.into()));
        self
    }
}

/// Hulls that some tool wrote, each as the convex hull that an engine makes of its points; one
/// without a volume as it is. Those without triangles, or with a coordinate that is not finite,
/// are left out.
pub fn hulls_of(hulls: &[NamedMesh]) -> Vec<Hull> {
    let is_usable = |named: &&NamedMesh| {
        let TriangleMesh { positions, triangles, .. } = &named.mesh;
        !triangles.is_empty() && positions.iter().flatten().all(|x| x.is_finite())
    };
    let hull = |named: &NamedMesh| {
        let TriangleMesh { positions, triangles, .. } = &named.mesh;
        let as_it_is = || ConvexHull::from((positions.clone(), triangles.clone()));
        Hull::from(convex_hull(positions).unwrap_or_else(|_| as_it_is()))
    };
    hulls.iter().filter(is_usable).map(hull).collect()
}

/// A page about one mesh. See the [module](self).
pub struct Page<'a> {
    subject: Subject<'a>,
    document: Document,
    geometry: Geometry,
}

impl<'a> Page<'a> {
    /// A page without hulls yet. Of `parameters` the bound and the openings count: errors are shown
    /// against that bound, and the mesh with those openings closed.
    ///
    /// # Errors
    /// As [`close_openings`](crate::close_openings).
    pub fn new(
        title: impl Into<String>,
        mesh: impl Into<MeshView<'a>>,
        parameters: &Parameters,
        control: &Control,
    ) -> Result<Self, Error> {
        parameters.validate()?;
        let mut geometry = Geometry::default();
        let subject = parallel::with(control.is_parallel(), || {
            Subject::new(mesh.into(), parameters, control)
        })?;
        let document = Document::new(title.into(), &subject, &mut geometry);
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
    /// mesh, point by point.
    ///
    /// # Errors
    /// As [`measure`](crate::measure::measure()).
    pub fn add(&mut self, set: HullSet<'_>, control: &Control) -> Result<(), Error> {
        let Self { subject, document, geometry } = self;
        let set = parallel::with(control.is_parallel(), || {
            hull_set::shown(set, subject, &document.objects, geometry, control)
        })?;
        document.sets.push(set);
        Ok(())
    }

    /// The page as text: one file that loads nothing.
    ///
    /// # Errors
    /// [`Error::File`], without a path, if the figures can't be written as text.
    pub fn to_html(&self) -> Result<String, Error> {
        document::page(&self.document, &self.geometry)
            .map_err(|error| Error::file(Path::new("page"), error.to_string()))
    }

    /// Writes the page to a file, all or nothing.
    ///
    /// # Errors
    /// [`Error::File`] says what is wrong with the path.
    pub fn write(&self, path: impl AsRef<Path>) -> Result<(), Error> {
        let path = path.as_ref();
        let page = self.to_html()?;
        crate::atomic_write::write(path, page.as_bytes()).map_err(|error| Error::file(path, error))
    }
}
