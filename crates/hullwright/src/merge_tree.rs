//! Fewer hulls afterwards: from a finished decomposition on down to one hull, without a new run.

use crate::bounded::join_tree::JoinTree;
use crate::bounded::output::NormalizedHull;
use crate::control::Control;
use crate::decomposition::{ALGORITHM_VERSION, Decomposition, Hull};
use crate::error::Error;
use crate::geometry::MeshView;
use crate::hulls_format::{HullsFile, VerifiedErrors, without_sources};
use crate::mesh::Normalization;
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
    tree: JoinTree,
    leaves: Vec<Hull>,
    /// Restores the tree's lengths, which are fractions of the diagonal.
    normalization: Normalization,
    /// In the units of the mesh.
    uncovered: f64,
    /// What a file says of every state, without hulls.
    file: HullsFile,
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
    /// No point of a hull's surface is farther than this outside the solid. In the units of the
    /// mesh.
    pub protrusion_max: f64,
    /// No point of the surface is farther than this outside every hull. In the units of the mesh.
    pub uncovered_max: f64,
}

/// A join of a [`MergeTree`]: two hulls give way to the hull of both.
#[non_exhaustive]
#[derive(Debug, Clone, PartialEq)]
pub struct Join {
    /// Indices of the two that give way. The hulls that the tree was made of come first, then the
    /// joint ones, in the order of the joins.
    pub joined: [usize; 2],
    /// The joint hull, with its verified protrusion.
    pub hull: Hull,
}

impl MergeTree {
    /// Joins the hulls of `decomposition`, which came from the same mesh and parameters.
    ///
    /// O(k²) lower bounds for k hulls; a few joint hulls per join are built and verified against
    /// the mesh.
    ///
    /// # Errors
    /// Those of [`decompose`](crate::decompose); [`Error::NoHulls`] without hulls.
    pub fn new<'a, R: Clone + Into<MethodReport>>(
        mesh: impl Into<MeshView<'a>>,
        decomposition: &Decomposition<R>,
        parameters: &Parameters,
        control: &Control,
    ) -> Result<Self, Error> {
        let report: MethodReport = decomposition.report.clone().into();
        let known = report.bounded().map(|report| report.uncovered_max);
        let tree = Self::build(mesh.into(), &decomposition.hulls, known, parameters, control)?;
        let file = HullsFile {
            algorithm_version: decomposition.run.algorithm_version,
            method: report.name().into(),
            bound: report.bounded().map(|report| report.bound),
            ..tree.file
        };
        Ok(Self { file, ..tree })
    }

    /// Joins hulls of any tool, each taken as the convex hull that it is. Those without verified
    /// errors are verified first. Of `parameters` the bound says how finely protrusions are
    /// resolved, and the limit on vertices holds for joint hulls.
    ///
    /// # Errors
    /// As [`new`](Self::new), and [`Error::UnusableHull`] for a hull whose triangles name points
    /// that it does not have.
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
        let normalization = prepared.normalization;
        let known = uncovered.map(|uncovered| uncovered / normalization.diagonal);
        let (tree, found) = parallel::with(control.is_parallel(), || {
            JoinTree::from_hulls(&prepared, hulls, known, parameters, control)
        })?;
        let uncovered = uncovered.unwrap_or(found * normalization.diagonal);
        let file = HullsFile {
            name: String::new(),
            algorithm_version: ALGORITHM_VERSION,
            method: String::new(),
            source_vertices: mesh.vertex_count() as u64,
            source_triangles: mesh.triangles().len() as u64,
            diagonal: normalization.diagonal,
            bound: None,
            verified: None,
            mass_properties: None,
            hulls: Vec::new(),
            parts: Vec::new(),
            part_shares: Vec::new(),
        };
        Ok(Self { tree, leaves: hulls.to_vec(), normalization, uncovered, file })
    }

    /// All states, from the decomposition's hulls down to one. The number of hulls falls from one
    /// to the next, the error never does.
    pub fn curve(&self) -> Vec<CurvePoint> {
        (0..=self.tree.joins()).map(|joins| self.point(joins)).collect()
    }

    /// All joins, from the decomposition's hulls down to one: what each state of
    /// [`curve`](Self::curve) has that the one before has not.
    pub fn joins(&self) -> Vec<Join> {
        let joints = self.tree.leaves..self.tree.nodes.len();
        let join = |index: usize| {
            let (first, second) = self.tree.nodes[index].joined?;
            let joined = [first, second].map(|part| part as usize);
            Some(Join { joined, hull: self.hull(index)? })
        };
        joints.filter_map(join).collect()
    }

    /// The hulls of the state with at most `most` hulls: `most`, or all there are, or one if
    /// `most` is 0.
    pub fn at_hulls(&self, most: usize) -> Vec<Hull> {
        self.hulls(self.joins_down_to(most))
    }

    /// The fewest hulls whose error, in units, is at most `error`; the decomposition's own hulls
    /// if theirs is larger already.
    pub fn at_error(&self, error: f64) -> Vec<Hull> {
        let keeps = |joins: &usize| self.point(*joins).error <= error;
        self.hulls((0..=self.tree.joins()).rev().find(keeps).unwrap_or(0))
    }

    /// The state of [`at_hulls`](Self::at_hulls) with its errors, as a file that games load. It has
    /// no mass properties and, for hulls of another tool, no method and no bound. For the state
    /// within an error, `most` is the length of [`at_error`](Self::at_error).
    ///
    /// ```
    /// # let mesh = hullwright::TriangleMesh::new(
    /// #     vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
    /// #     vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]],
    /// # );
    /// # let (parameters, control) = (hullwright::Parameters::default(), hullwright::Control::new());
    /// # let decomposition = hullwright::decompose(&mesh, &parameters, &control)?;
    /// let tree = hullwright::MergeTree::new(&mesh, &decomposition, &parameters, &control)?;
    /// let mass = hullwright::mass_properties(&mesh, &decomposition.hulls, 1.0)?;
    /// let bytes = tree.to_file("rock", 4).with_mass_properties(mass).to_bytes()?;
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn to_file(&self, name: impl Into<String>, most: usize) -> HullsFile {
        let joins = self.joins_down_to(most);
        let CurvePoint { protrusion_max, uncovered_max, .. } = self.point(joins);
        HullsFile {
            name: name.into(),
            verified: Some(VerifiedErrors { protrusion_max, uncovered_max }),
            hulls: self.hulls(joins).into_iter().map(without_sources).collect(),
            ..self.file.clone()
        }
    }

    fn joins_down_to(&self, most: usize) -> usize {
        self.leaves.len().saturating_sub(most.max(1))
    }

    fn point(&self, joins: usize) -> CurvePoint {
        let state = self.tree.state(joins);
        let protrusions = state.iter().map(|&index| self.tree.nodes[index].protrusion);
        let protrusion_max = protrusions.fold(0.0, f64::max) * self.normalization.diagonal;
        CurvePoint {
            hulls: self.leaves.len() - joins,
            error: protrusion_max.max(self.uncovered),
            protrusion_max,
            uncovered_max: self.uncovered,
        }
    }

    fn hulls(&self, joins: usize) -> Vec<Hull> {
        self.tree.state(joins).into_iter().filter_map(|index| self.hull(index)).collect()
    }

    /// An original or joint hull in the input's units.
    fn hull(&self, index: usize) -> Option<Hull> {
        let leaves = self.tree.leaves_below(index);
        let members: Vec<&Hull> = leaves.iter().filter_map(|&leaf| self.leaves.get(leaf)).collect();
        let first = *members.first()?;
        let node = &self.tree.nodes[index];
        if node.joined.is_none() {
            return Some(first.clone());
        }
        let largest =
            |value: fn(&Hull) -> f64| members.iter().map(|&hull| value(hull)).fold(0.0, f64::max);
        let source = members.iter().flat_map(|hull| &hull.provenance.source_triangles);
        let joint = NormalizedHull {
            hull: &node.hull,
            component: first.provenance.component,
            source_triangles: source.copied().collect(),
            added_thickness: 0.0,
            simplification_growth: node.growth,
            protrusion: node.protrusion,
        };
        let mut joint = joint.restored(&self.normalization);
        let errors = &mut joint.errors;
        errors.added_thickness = largest(|hull| hull.errors.added_thickness);
        errors.simplification_growth =
            errors.simplification_growth.max(largest(|hull| hull.errors.simplification_growth));
        Some(joint)
    }
}
