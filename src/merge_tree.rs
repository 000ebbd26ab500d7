//! Fewer hulls afterwards: from a finished decomposition on down to one hull, without a new run.

use crate::bounded::decomposition_hierarchy::DecompositionHierarchy;
use crate::control::Control;
use crate::decomposition::{Decomposition, Hull};
use crate::error::Error;
use crate::geometry::MeshView;
use crate::method::MethodReport;
use crate::openings::OpeningSettings;
use crate::openings::prepare::prepare_closed;
use crate::parallel;
use crate::parameters::Parameters;

/// The hulls of a decomposition and all that they can be joined to, one join after the other: the
/// pair whose joint hull protrudes least goes first.
///
/// ```
/// # fn main() -> Result<(), hullwright::Error> {
/// # let positions = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
/// # let triangles = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]];
/// # let mesh = hullwright::MeshView::new(&positions, &triangles);
/// use hullwright::{Control, MergeTree, Parameters, decompose};
///
/// let (parameters, control) = (Parameters::default(), Control::new());
/// let decomposition = decompose(mesh, &parameters, &control)?;
/// let tree = MergeTree::new(mesh, &decomposition, &parameters, &control)?;
/// for point in tree.curve() {
///     println!("{} hulls: at most {} off", point.hulls, point.error);
/// }
/// let four = tree.at_hulls(4);
/// # assert!(four.len() <= 4);
/// # Ok(())
/// # }
/// ```
#[derive(Debug, Clone)]
pub struct MergeTree {
    hierarchy: DecompositionHierarchy,
    leaves: Vec<Hull>,
    uncovered: f64,
}

/// A state of a [`MergeTree`].
#[non_exhaustive]
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct CurvePoint {
    /// Number of hulls.
    pub hulls: usize,
    /// The larger of the two errors below: the bound that this state keeps.
    pub error: f64,
    /// No point of a hull's surface is farther than this outside the solid. In units.
    pub protrusion_max: f64,
    /// No point of the surface is farther than this outside every hull. In units.
    pub uncovered_max: f64,
}

/// A join of a [`MergeTree`]: two hulls give way to the hull of both.
#[non_exhaustive]
#[derive(Debug, Clone, PartialEq)]
pub struct Join {
    /// The two that give way. The hulls that the tree was made of have the first numbers, then
    /// come the joint ones, in the order of the joins.
    pub joined: [usize; 2],
    /// The joint hull, with its verified protrusion.
    pub hull: Hull,
}

impl MergeTree {
    /// Joins the hulls of `decomposition`, which came from the same mesh and parameters.
    ///
    /// O(k²) lower bounds for k hulls; a few joint hulls per join are built and verified against the
    /// mesh.
    ///
    /// # Errors
    /// Those of [`decompose`](crate::decompose); [`Error::NoHulls`] without hulls.
    ///
    /// ```
    /// # let mesh = hullwright::TriangleMesh::new(
    /// #     vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
    /// #     vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]],
    /// # );
    /// use hullwright::{Control, MergeTree, Parameters, decompose};
    ///
    /// let (parameters, control) = (Parameters::default(), Control::new());
    /// let result = decompose(&mesh, &parameters, &control)?;
    /// let tree = MergeTree::new(&mesh, &result, &parameters, &control)?;
    /// assert_eq!(tree.curve().len(), result.hulls.len());
    /// # Ok::<(), hullwright::Error>(())
    /// ```
    pub fn new<'a, R: Clone + Into<MethodReport>>(
        mesh: impl Into<MeshView<'a>>,
        decomposition: &Decomposition<R>,
        parameters: &Parameters,
        control: &Control,
    ) -> Result<Self, Error> {
        let report: MethodReport = decomposition.report.clone().into();
        let known = report.bounded().map(|report| report.uncovered_max);
        Self::build(mesh.into(), &decomposition.hulls, known, parameters, control)
    }

    /// Joins hulls of any tool, each taken as the convex hull that it is. Those whose errors are not
    /// known are verified first. Of `parameters` the bound says how finely the solid is looked at, and
    /// the limit on vertices holds for joint hulls.
    ///
    /// # Errors
    /// As [`new`](Self::new), and [`Error::UnusableHull`] for a hull whose triangles name points that
    /// it does not have.
    ///
    /// ```
    /// # fn main() -> Result<(), hullwright::Error> {
    /// use hullwright::{Control, Hull, MergeTree, Parameters, TriangleMesh, convex_hull};
    ///
    /// let mesh = TriangleMesh::new(
    ///     vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
    ///     vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]],
    /// );
    /// let hulls = [Hull::from(convex_hull(&mesh.positions)?)];
    /// let tree = MergeTree::from_hulls(&mesh, &hulls, &Parameters::default(), &Control::new())?;
    /// assert_eq!(tree.curve().len(), 1);
    /// # Ok(())
    /// # }
    /// ```
    pub fn from_hulls<'a>(
        mesh: impl Into<MeshView<'a>>,
        hulls: &[Hull],
        parameters: &Parameters,
        control: &Control,
    ) -> Result<Self, Error> {
        Self::build(mesh.into(), hulls, None, parameters, control)
    }

    fn build(
        mesh: MeshView<'_>,
        hulls: &[Hull],
        uncovered: Option<f64>,
        parameters: &Parameters,
        control: &Control,
    ) -> Result<Self, Error> {
        parameters.validate()?;
        if hulls.is_empty() {
            return Err(Error::NoHulls);
        }
        let settings = OpeningSettings::from(parameters);
        let prepared = prepare_closed(mesh, &settings, control)?.prepared;
        let hierarchy = parallel::with(control.is_parallel(), || {
            DecompositionHierarchy::new(prepared, hulls, parameters, control)
        })?;
        let uncovered = match uncovered {
            Some(uncovered) => uncovered,
            None => hierarchy.uncovered(control)?,
        };
        Ok(Self { hierarchy, leaves: hulls.to_vec(), uncovered })
    }

    /// All states, from the decomposition's hulls down to one. The number of hulls falls from one
    /// to the next, the error never does.
    ///
    /// ```
    /// # let mesh = hullwright::TriangleMesh::new(
    /// #     vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
    /// #     vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]],
    /// # );
    /// # let (parameters, control) = (hullwright::Parameters::default(), hullwright::Control::new());
    /// # let decomposition = hullwright::decompose(&mesh, &parameters, &control)?;
    /// let tree = hullwright::MergeTree::new(&mesh, &decomposition, &parameters, &control)?;
    /// assert_eq!(tree.curve()[0].hulls, decomposition.hulls.len());
    /// # Ok::<(), hullwright::Error>(())
    /// ```
    pub fn curve(&self) -> Vec<CurvePoint> {
        (0..=self.hierarchy.joins()).map(|joins| self.point(joins)).collect()
    }

    /// All joins, from the decomposition's hulls down to one: what each state of
    /// [`curve`](Self::curve) has that the one before has not.
    ///
    /// ```
    /// # let mesh = hullwright::TriangleMesh::new(
    /// #     vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
    /// #     vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]],
    /// # );
    /// # let (parameters, control) = (hullwright::Parameters::default(), hullwright::Control::new());
    /// # let decomposition = hullwright::decompose(&mesh, &parameters, &control)?;
    /// let tree = hullwright::MergeTree::new(&mesh, &decomposition, &parameters, &control)?;
    /// assert_eq!(tree.joins().len() + 1, tree.curve().len());
    /// # Ok::<(), hullwright::Error>(())
    /// ```
    pub fn joins(&self) -> Vec<Join> {
        let joints = self.hierarchy.joint_hulls(&self.leaves);
        joints.map(|(joined, hull)| Join { joined, hull }).collect()
    }

    /// The hulls of the state with at most `most` hulls: `most`, or all there are, or one if
    /// `most` is 0.
    ///
    /// ```
    /// # let mesh = hullwright::TriangleMesh::new(
    /// #     vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
    /// #     vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]],
    /// # );
    /// # let (parameters, control) = (hullwright::Parameters::default(), hullwright::Control::new());
    /// # let decomposition = hullwright::decompose(&mesh, &parameters, &control)?;
    /// let tree = hullwright::MergeTree::new(&mesh, &decomposition, &parameters, &control)?;
    /// assert_eq!(tree.at_hulls(1).len(), 1);
    /// # Ok::<(), hullwright::Error>(())
    /// ```
    pub fn at_hulls(&self, most: usize) -> Vec<Hull> {
        let joins = self.leaves.len().saturating_sub(most.max(1));
        self.hierarchy.hulls(joins, &self.leaves)
    }

    /// The fewest hulls whose error, in units, is at most `error`; the decomposition's own hulls
    /// if theirs is larger already.
    ///
    /// ```
    /// # let mesh = hullwright::TriangleMesh::new(
    /// #     vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
    /// #     vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]],
    /// # );
    /// # let (parameters, control) = (hullwright::Parameters::default(), hullwright::Control::new());
    /// # let decomposition = hullwright::decompose(&mesh, &parameters, &control)?;
    /// let tree = hullwright::MergeTree::new(&mesh, &decomposition, &parameters, &control)?;
    /// assert_eq!(tree.at_error(1.0).len(), 1);
    /// # Ok::<(), hullwright::Error>(())
    /// ```
    pub fn at_error(&self, error: f64) -> Vec<Hull> {
        let joins = (0..=self.hierarchy.joins())
            .rev()
            .find(|&joins| self.point(joins).error <= error)
            .unwrap_or(0);
        self.hierarchy.hulls(joins, &self.leaves)
    }

    fn point(&self, joins: usize) -> CurvePoint {
        let protrusion_max = self.hierarchy.protrusion(joins);
        CurvePoint {
            hulls: self.leaves.len() - joins,
            error: protrusion_max.max(self.uncovered),
            protrusion_max,
            uncovered_max: self.uncovered,
        }
    }
}
