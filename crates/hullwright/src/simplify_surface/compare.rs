//! The public function: how far two surfaces are from each other at most.
//!
//! Whether a triangle is within a length of a surface is decided without samples (`distance`). So
//! the least length that all triangles are within is found by trying some. Points whose distance is
//! known bound it from below: corners and middles at first, then what refutes a length. Only what
//! was refuted is tried again, so most triangles are measured once or twice. What would take too
//! many parts is measured last, from the length that holds for all others.

use super::distance::{NO_GUESS, Parts, Target};
use super::hidden::hidden;
use super::simplify::{ROUNDING, turned};
use crate::bvh::Bvh;
use crate::control::Control;
use crate::error::Error;
use crate::geometry::MeshView;
use crate::geometry::vector::{Vector, centre, larger, smaller};
use crate::mesh::canonical_order::MeshOrder;
use crate::mesh::repair::{Normalization, PreparedMesh, Survey, is_degenerate, prepare};
use crate::parallel;

/// The first length after one that was refuted is longer by this fraction; each further one by
/// twice the fraction before, up to this many times in all.
const FIRST_STEP: f64 = 0.02;
const LARGEST_STEP: f64 = 1e6;

/// The same where no shorter length is tried afterwards.
const LARGEST_LAST_STEP: f64 = 1.0;

/// Shorter distances are not resolved, as a fraction of the diagonal of both surfaces: it is less
/// than the rounding of 32-bit coordinates. Where that rounding bends faces, shorter distances
/// would take parts without end.
const FLOOR: f64 = 1e-8;

/// Parts of a triangle before it waits for a greater length.
const FEW_PARTS: usize = 1 << 12;

/// Triangles between two checks for cancellation.
const PER_TASK: usize = 256;

/// Which triangles count as hidden because nothing can touch them. No distance is measured from
/// them. Others are measured to them: what is near a hidden triangle is near the solid that hides
/// it.
#[non_exhaustive]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum HiddenTriangles<'a> {
    /// Those of either surface that [`simplify_surface`](super::simplify_surface) would leave out.
    #[default]
    Found,
    /// None: distances are measured from all.
    Kept,
    /// Those with these indices, of the first surface and of the second.
    Listed([&'a [u32]; 2]),
}

/// How far two surfaces are from each other: one-sided Hausdorff distances. Lengths are in the
/// input's units.
#[non_exhaustive]
#[derive(Debug, Clone, PartialEq)]
pub struct SurfaceDistances {
    /// How far any point of the first surface is from the second.
    pub from_a_to_b: SurfaceDistance,
    /// How far any point of the second surface is from the first.
    pub from_b_to_a: SurfaceDistance,
    /// The diagonal of the first surface's bounding box.
    pub diagonal: f64,
    /// The triangles of the first surface that count as hidden, ascending.
    pub hidden_of_a: Vec<u32>,
    /// The same of the second.
    pub hidden_of_b: Vec<u32>,
}

impl SurfaceDistances {
    /// The upper bounds are above the lower ones by at most this fraction, or by 0.000001 % of the
    /// diagonal of both surfaces: except where a triangle lies over so many others, so near to the
    /// bound, that its measurement ends early.
    pub const RESOLUTION: f64 = 0.01;

    /// The Hausdorff distance, as an upper bound.
    pub fn hausdorff(&self) -> f64 {
        larger(self.from_a_to_b.at_most, self.from_b_to_a.at_most)
    }
}

/// The greatest distance of any point of one surface from another.
#[non_exhaustive]
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct SurfaceDistance {
    /// An upper bound, verified for whole triangles.
    pub at_most: f64,
    /// A lower bound: the distance of some point.
    pub at_least: f64,
}

/// Measures how far two surfaces are from each other, whatever made them: a mesh and one with fewer
/// triangles that stands for it.
///
/// Both one-sided Hausdorff distances are enclosed: an upper bound holds for all points of all
/// triangles, and some point is at least as far away as the lower bound. Between them are at most
/// 1 % ([`SurfaceDistances::RESOLUTION`]). Surfaces may be closed or open, manifold or not.
/// [`HiddenTriangles`] says what counts as hidden; degenerate and non-finite triangles are left out
/// as by [`simplify_surface`](super::simplify_surface).
///
/// ```
/// use hullwright::{Control, HiddenTriangles, TriangleMesh, surface_distances};
///
/// let square = |side: f64, height: f64| {
///     let corners = [[0.0, 0.0], [side, 0.0], [side, side], [0.0, side]];
///     let positions = corners.map(|[x, y]| [x, y, height]).to_vec();
///     TriangleMesh::new(positions, vec![[0, 1, 2], [0, 2, 3]])
/// };
/// let (large, small) = (square(2.0, 0.0), square(1.0, 0.0));
/// let found = surface_distances(&large, &small, HiddenTriangles::Found, &Control::new())?;
/// // The far corner of the large square, and no point of the small one.
/// assert!((found.from_a_to_b.at_most / 2_f64.sqrt() - 1.0).abs() < 0.01);
/// assert!(found.from_b_to_a.at_most < 1e-9);
/// # Ok::<(), hullwright::Error>(())
/// ```
///
/// About O(n log n) for n triangles of both, some times as long as to verify a known bound.
///
/// # Errors
/// [`Error::EmptyMesh`], [`Error::TooLarge`], [`Error::IndexOutOfRange`], [`Error::SidednessCount`]
/// and [`Error::NothingUsable`] for either mesh, the last also where nothing of it is left;
/// [`Error::Cancelled`] and [`Error::DeadlineExceeded`].
pub fn surface_distances<'a, 'b>(
    a: impl Into<MeshView<'a>>,
    b: impl Into<MeshView<'b>>,
    hidden: HiddenTriangles<'_>,
    control: &Control,
) -> Result<SurfaceDistances, Error> {
    let (a, b) = (a.into(), b.into());
    control.admit(a.triangles().len())?;
    control.admit(b.triangles().len())?;
    parallel::with(control.is_parallel(), || compare(a, b, hidden, control))
}

fn compare(
    a: MeshView<'_>,
    b: MeshView<'_>,
    hidden: HiddenTriangles<'_>,
    control: &Control,
) -> Result<SurfaceDistances, Error> {
    let (of_a, of_b) = match hidden {
        HiddenTriangles::Listed([of_a, of_b]) => (Some(of_a), Some(of_b)),
        HiddenTriangles::Kept => (Some(&[][..]), Some(&[][..])),
        HiddenTriangles::Found => (None, None),
    };
    let a = Shown::new(a, of_a, control)?;
    let b = Shown::new(b, of_b, control)?;
    // One space for both. It may be far larger than that of one of them.
    let normalization = Normalization::of(a.corners().chain(b.corners()));
    let (first, second) = (a.placed(&normalization), b.placed(&normalization));
    let distance = |from: &Placed, to: &Placed| {
        let found = farthest(from, to, control)?;
        let restored = |length: f64| length * normalization.diagonal;
        Ok::<_, Error>(SurfaceDistance {
            at_most: restored(found.at_most + ROUNDING),
            at_least: restored(larger(found.at_least - ROUNDING, 0.0)),
        })
    };
    let from_a_to_b = distance(&first, &second)?;
    let from_b_to_a = distance(&second, &first)?;
    Ok(SurfaceDistances {
        from_a_to_b,
        from_b_to_a,
        diagonal: a.normalization.diagonal,
        hidden_of_a: a.hidden,
        hidden_of_b: b.hidden,
    })
}

/// The triangles of a mesh that are measured.
struct Shown<'a> {
    mesh: MeshView<'a>,
    triangles: Vec<[u32; 3]>,
    /// How many of them, the first ones, distances are measured from.
    visible: usize,
    hidden: Vec<u32>,
    normalization: Normalization,
}

/// The same in the space of both surfaces.
struct Placed {
    points: Vec<Vector>,
    triangles: Vec<[u32; 3]>,
    visible: usize,
}

impl<'a> Shown<'a> {
    /// Hidden are those that are listed, or those that are found to be.
    fn new(mesh: MeshView<'a>, listed: Option<&[u32]>, control: &Control) -> Result<Self, Error> {
        let prepared = prepare(mesh, MeshOrder::Place, control)?;
        let mut hidden = match listed {
            Some(listed) => listed.to_vec(),
            None => found(mesh, &prepared, control)?,
        };
        hidden.retain(|&triangle| (triangle as usize) < mesh.triangles().len());
        hidden.sort_unstable();
        hidden.dedup();
        let normalization = prepared.normalization;
        let points: Vec<Vector> =
            mesh.points().map(|point| normalization.normalize(point)).collect();
        let mut left = Survey::new(mesh).candidates;
        left.retain(|&index| !is_degenerate(&points, mesh.triangles()[index as usize]));
        let is_visible = |index: &u32| hidden.binary_search(index).is_err();
        let (shown, others): (Vec<u32>, Vec<u32>) = left.into_iter().partition(is_visible);
        let visible = shown.len();
        if visible == 0 {
            let (triangles, non_finite) =
                (mesh.triangles().len(), prepared.repairs.non_finite_triangles);
            let degenerate = triangles - non_finite - others.len();
            return Err(Error::NothingUsable { triangles, degenerate, non_finite });
        }
        let all = shown.into_iter().chain(others);
        let triangles = all.map(|index| mesh.triangles()[index as usize]).collect();
        Ok(Self { mesh, triangles, visible, hidden, normalization })
    }

    fn corners(&self) -> impl Iterator<Item = Vector> {
        self.triangles.as_flattened().iter().map(|&vertex| self.mesh.at(vertex))
    }

    fn placed(&self, normalization: &Normalization) -> Placed {
        let points = self.mesh.points().map(|point| normalization.normalize(point)).collect();
        Placed { points, triangles: self.triangles.clone(), visible: self.visible }
    }
}

/// The triangles that nothing can touch, by their indices in the input.
fn found(
    mesh: MeshView<'_>,
    prepared: &PreparedMesh,
    control: &Control,
) -> Result<Vec<u32>, Error> {
    let is_hidden = hidden(prepared, &turned(mesh, prepared), control)?;
    let all = prepared.source_triangles.iter().zip(is_hidden);
    Ok(all.filter(|(_, is_hidden)| *is_hidden).map(|(&triangle, _)| triangle).collect())
}

/// A surface that distances of points are measured from: for pictures and statistics of distances.
#[derive(Debug)]
pub struct MeasuredSurface {
    tree: Bvh,
    normalization: Normalization,
}

impl MeasuredSurface {
    /// The surface of all triangles, hidden ones too. O(n log n).
    ///
    /// # Errors
    /// As [`surface_distances`].
    pub fn new<'a>(mesh: impl Into<MeshView<'a>>, control: &Control) -> Result<Self, Error> {
        let mesh = mesh.into();
        control.admit(mesh.triangles().len())?;
        parallel::with(control.is_parallel(), || {
            let shown = Shown::new(mesh, Some(&[]), control)?;
            let Placed { points, triangles, .. } = shown.placed(&shown.normalization);
            let tree = Bvh::with_control(&points, &triangles, control)?;
            Ok(Self { tree, normalization: shown.normalization })
        })
    }

    /// How far a point is from the surface, in the input's units; infinite for one that is not
    /// finite. O(log n).
    pub fn distance(&self, point: [f64; 3]) -> f64 {
        let point = self.normalization.normalize(point.into());
        let closest = self.tree.closest_point(point, f64::INFINITY);
        closest.map_or(f64::INFINITY, |closest| closest.distance * self.normalization.diagonal)
    }
}

/// What is known of a greatest distance.
struct Found {
    at_most: f64,
    at_least: f64,
}

/// How far any point of one surface is from another.
fn farthest(from: &Placed, to: &Placed, control: &Control) -> Result<Found, Error> {
    // A half for lengths that are not tried, less for those that are refuted although they are
    // true.
    let (gap, resolution) = [0.5, 0.4].map(|share| share * SurfaceDistances::RESOLUTION).into();
    let tree = Bvh::with_control(&to.points, &to.triangles, control)?;
    let target = Target::new(tree, &to.points, &to.triangles).with_resolution(resolution);
    let mut at_least = of_points(from, &target, control)?;
    // The greatest bound of triangles that are done; those that are not, and the greatest length
    // that is refuted for them; the bound for them all, if there is one.
    let (mut settled, mut refuted): (f64, f64) = (0.0, 0.0);
    let mut open: Vec<u32> = (0..from.visible as u32).collect();
    let mut within = f64::INFINITY;
    let mut step = FIRST_STEP;
    let mut hard: Vec<u32> = Vec::new();
    loop {
        let least = larger(larger(at_least, refuted) * (1.0 + gap), FLOOR);
        if larger(settled, within) <= least {
            break;
        }
        let limit = if within < f64::INFINITY {
            larger((least * within).sqrt(), least)
        } else if refuted > 0.0 {
            step = smaller(2.0 * step, LARGEST_STEP);
            larger(least, refuted * (1.0 + step))
        } else {
            least
        };
        let tried = attempt(from, &target, &open, (limit, Some(FEW_PARTS)), control)?;
        at_least = larger(at_least, tried.seen);
        hard.extend(&tried.spent);
        if tried.refuted.is_empty() {
            within = tried.within;
            open.retain(|triangle| tried.spent.binary_search(triangle).is_err());
        } else {
            settled = larger(settled, tried.within);
            (open, refuted) = (tried.refuted, limit);
        }
    }
    let mut at_most = larger(settled, within);
    let mut limit = larger(at_most, larger(at_least * (1.0 + gap), FLOOR));
    step = FIRST_STEP;
    while !hard.is_empty() {
        let tried = attempt(from, &target, &hard, (limit, None), control)?;
        (at_most, at_least) = (larger(at_most, tried.within), larger(at_least, tried.seen));
        hard = [tried.refuted, tried.spent].concat();
        limit = larger(limit * (1.0 + step), at_least * (1.0 + gap));
        step = smaller(2.0 * step, LARGEST_LAST_STEP);
        // No point is measured to be that far away, whatever it is.
        if !limit.is_finite() {
            at_most = f64::INFINITY;
            break;
        }
    }
    Ok(Found { at_most, at_least })
}

/// The greatest distance of a corner or a middle.
fn of_points(from: &Placed, target: &Target<'_>, control: &Control) -> Result<f64, Error> {
    let triangles = &from.triangles[..from.visible];
    let tasks = parallel::map_indices(triangles.len().div_ceil(PER_TASK), |task| {
        control.check()?;
        let own = &triangles[task * PER_TASK..triangles.len().min((task + 1) * PER_TASK)];
        let points = own.iter().flat_map(|triangle| {
            let [a, b, c] = triangle.map(|vertex| from.points[vertex as usize]);
            [a, b, c, (a + b) * 0.5, (b + c) * 0.5, (c + a) * 0.5, centre([a, b, c])]
        });
        Ok(points.filter_map(|point| target.distance(point)).fold(0.0, larger))
    });
    let tasks = tasks.into_iter().collect::<Result<Vec<f64>, Error>>()?;
    Ok(tasks.into_iter().fold(0.0, larger))
}

/// What became of a length.
#[derive(Default)]
struct Tried {
    /// The greatest bound of triangles that are within it.
    within: f64,
    /// Those that are not.
    refuted: Vec<u32>,
    /// Those that fall into too many parts.
    spent: Vec<u32>,
    /// The greatest distance that some point had.
    seen: f64,
}

/// Tries a length for some triangles, ascending, with so many parts at most.
fn attempt(
    from: &Placed,
    target: &Target<'_>,
    open: &[u32],
    (limit, most): (f64, Option<usize>),
    control: &Control,
) -> Result<Tried, Error> {
    let tasks = parallel::map_indices(open.len().div_ceil(PER_TASK), |task| {
        control.check()?;
        let (mut parts, mut tried) = (Parts::default(), Tried::default());
        parts.most = most;
        for &triangle in &open[task * PER_TASK..open.len().min((task + 1) * PER_TASK)] {
            let corners = from.triangles[triangle as usize].map(|v| from.points[v as usize]);
            match target.farthest(corners, NO_GUESS, limit, &mut parts) {
                Some(distance) => tried.within = larger(tried.within, distance),
                None if parts.are_spent => tried.spent.push(triangle),
                None => tried.refuted.push(triangle),
            }
        }
        tried.seen = parts.seen;
        Ok(tried)
    });
    let mut all = Tried::default();
    for tried in tasks {
        let tried: Tried = tried?;
        all.within = larger(all.within, tried.within);
        all.seen = larger(all.seen, tried.seen);
        all.refuted.extend(tried.refuted);
        all.spent.extend(tried.spent);
    }
    Ok(all)
}
