//! Few vertices: as many are saved as a little volume allows, and as many as the cap wants, within the
//! bound. Without a paper: engines pay for each vertex of a hull.
//!
//! What is tried, the first that keeps the bound counts: a hull without the vertices that hardly stand
//! out, its edges collapsed outward, or as it is; edges collapsed, of all vertices; all vertices. Where it
//! is the cap that makes trouble: hulls that leave out more; the capped hull; the capped hull, a little
//! smaller. What is left then, the vertices that stand out most, may keep no bound: `finish` divides
//! it.

use super::certify::{PointGroups, left_out, phantom};
use super::finish::{LEFT_OUT, MOST_LEFT_OUT, Material};
use crate::error::Error;
use crate::geometry::vector::{Vector, add, distance, scale, subtract};
use crate::hull::{
    ConvexHull, HullBuilder, LEAST_THICKNESS, cap_vertices, coarser, collapse_edges,
    most_prominent, solid_hull,
};

/// A hull without vertices that hardly stand out has at least this share of its volume left: of a thin plate
/// hardly anything stands out.
const LEAST_VOLUME: f64 = 0.95;

/// Where the cap on vertices can't be kept otherwise, vertices that stand out by this much, in bounds,
/// are left out too.
const COARSER: [f64; 2] = [0.1, 0.2];

/// Where that does not fit either, a hull that the cap lets grow shrinks again by these shares of the
/// bound: less than [`MOST_LEFT_OUT`], which it may leave out.
const SHRUNK: [f64; 2] = [0.2, 0.4];

/// A hull of more vertices than this does not collapse as a whole to keep a cap, once a coarser one has
/// failed: that would take long, and hardly end better.
const TOO_MANY: usize = 256;

/// A hull before vertices are saved.
pub(super) struct Whole {
    pub hull: ConvexHull,
    /// How far outside of it what it must hold lies.
    pub left_out: f64,
    /// What it must hold.
    pub own: PointGroups,
    pub outward: Vector,
}

/// A hull as it may be returned.
pub(super) struct Few {
    pub hull: ConvexHull,
    /// How far it grew to save vertices.
    pub growth: f64,
    pub phantom: f64,
    pub left_out: f64,
}

/// Saves vertices: as many as the volume that they cost allows, and as many as the cap wants.
pub(super) fn few_vertices(
    material: &Material<'_>,
    whole: Whole,
    builder: &mut HullBuilder,
) -> Result<Few, Error> {
    let &Material { solid, tuning, volume_per_vertex, control, .. } = material;
    let bound = tuning.bound;
    let most = tuning.max_vertices.unwrap_or(usize::MAX);
    let mut stack = Vec::new();
    let mut fits = |face| {
        control.check()?;
        let bound = tuning.search_bound;
        Ok(solid.centre_fits(face, bound) && solid.face_fits(face, bound, &mut stack))
    };
    let accepted = |hull: ConvexHull, growth: f64, allowed: f64| -> Result<Option<Few>, Error> {
        if hull.points.len() > most {
            return Ok(None);
        }
        let left_out = left_out(&hull, &whole.own, allowed);
        if left_out > allowed {
            return Ok(None);
        }
        let phantom = phantom(&hull, solid, bound, bound, control)?;
        Ok((phantom <= bound).then_some(Few { hull, growth, phantom, left_out }))
    };
    let mut collapsed = |from: &ConvexHull, allowed: f64| -> Result<Option<Few>, Error> {
        match collapse_edges(from, volume_per_vertex, most, &mut fits)? {
            Some((few, growth)) => accepted(few, growth, allowed),
            None => Ok(None),
        }
    };
    let least_volume = LEAST_VOLUME * whole.hull.volume();
    let mut without_least = |share: f64| -> Result<Option<ConvexHull>, Error> {
        let Some(coarse) = coarser(&whole.hull, share * bound) else { return Ok(None) };
        let (_, added) = solid_hull(builder, &coarse.points, whole.outward, LEAST_THICKNESS)?;
        // Some have no thickness to spare.
        Ok((added == 0.0 && coarse.volume() >= least_volume).then_some(coarse))
    };

    let allowed = (LEFT_OUT * bound).max(whole.left_out);
    let coarse = without_least(LEFT_OUT)?;
    let has_coarse = coarse.is_some();
    if let Some(coarse) = coarse {
        if let Some(few) = collapsed(&coarse, allowed)? {
            return Ok(few);
        }
        if let Some(few) = accepted(coarse, 0.0, allowed)? {
            return Ok(few);
        }
    }
    let has_many = whole.hull.points.len() > most;
    let is_hopeless = has_coarse && has_many && whole.hull.points.len() > TOO_MANY;
    if !is_hopeless && let Some(few) = collapsed(&whole.hull, allowed)? {
        return Ok(few);
    }
    if !has_many {
        let phantom = phantom(&whole.hull, solid, bound, f64::INFINITY, control)?;
        let Whole { hull, left_out, .. } = whole;
        return Ok(Few { hull, growth: 0.0, phantom, left_out });
    }

    // From here on it is the cap that makes trouble.
    let most_allowed = (MOST_LEFT_OUT * bound).max(whole.left_out);
    for share in COARSER {
        let Some(coarse) = without_least(share)? else { continue };
        if let Some(few) = collapsed(&coarse, most_allowed)? {
            return Ok(few);
        }
        if let Some(few) = accepted(coarse, 0.0, most_allowed)? {
            return Ok(few);
        }
    }
    let (capped, growth) = cap_vertices(builder, whole.hull.clone(), most, control)?;
    if let Some(few) = accepted(capped.clone(), growth, allowed)? {
        return Ok(few);
    }
    for share in SHRUNK {
        let Some(smaller) = shrunk(&capped, share * bound) else { break };
        if let Some(few) = accepted(smaller, growth, most_allowed)? {
            return Ok(few);
        }
    }
    let inner = most_prominent(builder, &whole.hull.points, most, control)?;
    let hull = inner.unwrap_or_else(|| whole.hull.clone());
    let phantom = phantom(&hull, solid, bound, f64::INFINITY, control)?;
    let left_out = left_out(&hull, &whole.own, f64::INFINITY);
    Ok(Few { hull, growth: 0.0, phantom, left_out })
}

/// A hull whose vertices are drawn to its centre, the farthest by `by`; `None` if nothing would be left
/// of it.
fn shrunk(hull: &ConvexHull, by: f64) -> Option<ConvexHull> {
    let sum = hull.points.iter().fold([0.0; 3], |sum, &point| add(sum, point));
    let centre = scale(sum, 1.0 / hull.points.len() as f64);
    let farthest = hull.points.iter().map(|&point| distance(point, centre)).fold(0.0, f64::max);
    let factor = 1.0 - by / farthest;
    let moved = |&point: &Vector| add(centre, scale(subtract(point, centre), factor));
    (farthest > by).then(|| ConvexHull {
        points: hull.points.iter().map(moved).collect(),
        triangles: hull.triangles.clone(),
    })
}
