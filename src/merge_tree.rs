//! Fewer hulls afterwards: from a finished decomposition on down to one hull, without a new run.

use crate::bounded::decomposition_hierarchy::DecompositionHierarchy;
use crate::control::Control;
use crate::decomposition::{Decomposition, Hull};
use crate::error::Error;
use crate::geometry::Coordinate;
use crate::mesh::repair::prepare;
use crate::parallel;
use crate::parameters::Parameters;

/// The hulls of a decomposition and all that they can be joined to, one join after the other: the
/// pair whose joint hull stands out least goes first.
///
/// ```
/// # fn main() -> Result<(), hullwright::Error> {
/// # let positions = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
/// # let triangles = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]];
/// use hullwright::{Control, MergeTree, Parameters, decompose};
///
/// let (parameters, control) = (Parameters::default(), Control::new());
/// let decomposition = decompose(&positions, &triangles, &parameters, &control)?;
/// let tree = MergeTree::new(&positions, &triangles, &decomposition, &parameters, &control)?;
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
    exposed: f64,
}

/// A state of a [`MergeTree`].
#[non_exhaustive]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CurvePoint {
    /// Number of hulls.
    pub hulls: usize,
    /// The larger of the two errors below: the bound that this state keeps.
    pub error: f64,
    /// No point of a hull's surface is farther than this outside the solid. In units.
    pub phantom_max: f64,
    /// No point of the surface is farther than this outside every hull. In units.
    pub exposed_max: f64,
}

impl MergeTree {
    /// Joins the hulls of `decomposition`, which came from the same mesh and parameters.
    ///
    /// O(k²) joint hulls for k hulls, each of which is verified against the mesh.
    ///
    /// # Errors
    /// Those of [`decompose`](crate::decompose); [`Error::NoHull`] for a decomposition without
    /// hulls, or with one whose triangles name points that it does not have.
    pub fn new<C: Coordinate>(
        positions: &[[C; 3]],
        triangles: &[[u32; 3]],
        decomposition: &Decomposition,
        parameters: &Parameters,
        control: &Control,
    ) -> Result<Self, Error> {
        parameters.validate()?;
        if decomposition.hulls.is_empty() {
            return Err(Error::NoHull { reason: "there are no hulls to join" });
        }
        let positions: Vec<[f64; 3]> =
            positions.iter().map(|point| point.map(Coordinate::to_f64)).collect();
        let prepared = prepare(&positions, triangles, control)?;
        let hierarchy = parallel::with(parameters.parallel, || {
            DecompositionHierarchy::new(prepared, &decomposition.hulls, parameters, control)
        })?;
        let exposed = match &decomposition.report.bounded {
            Some(report) => report.exposed_max,
            None => hierarchy.uncovered(control)?,
        };
        Ok(Self { hierarchy, leaves: decomposition.hulls.clone(), exposed })
    }

    /// All states, from the decomposition's hulls down to one. The number of hulls falls from one
    /// to the next, the error never does.
    pub fn curve(&self) -> Vec<CurvePoint> {
        (0..=self.hierarchy.joins()).map(|joins| self.point(joins)).collect()
    }

    /// The hulls of the state with at most `most` hulls: `most`, or all there are, or one if
    /// `most` is 0.
    pub fn at_hulls(&self, most: usize) -> Vec<Hull> {
        let joins = self.leaves.len().saturating_sub(most.max(1));
        self.hierarchy.hulls(joins, &self.leaves)
    }

    /// The fewest hulls whose error, in units, is at most `error`; the decomposition's own hulls
    /// if theirs is larger already.
    pub fn at_error(&self, error: f64) -> Vec<Hull> {
        let joins = (0..=self.hierarchy.joins())
            .rev()
            .find(|&joins| self.point(joins).error <= error)
            .unwrap_or(0);
        self.hierarchy.hulls(joins, &self.leaves)
    }

    fn point(&self, joins: usize) -> CurvePoint {
        let phantom_max = self.hierarchy.protrusion(joins);
        CurvePoint {
            hulls: self.leaves.len() - joins,
            error: phantom_max.max(self.exposed),
            phantom_max,
            exposed_max: self.exposed,
        }
    }
}
