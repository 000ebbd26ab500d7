//! What is returned: hulls with thickness and few vertices, each verified against the source.

use super::Tuning;
use super::certify::{Outside, exposed, phantom};
use super::cover::hull_of;
use super::piece::Piece;
use super::seed_set::SeedSet;
use super::seeds::Seeds;
use super::solid::Solid;
use crate::hull::{
    ConvexHull, HullBuilder, cap_vertices_within, fewer_vertices, inner_hull, solid_hull,
};
use crate::{Control, Error};

/// A hull's least thickness as a share of the mesh's diagonal: what is small in all directions
/// gets a body that single precision can still tell from nothing.
const LEAST_THICKNESS: f64 = 1e-6;

/// Vertices that stand out of the others by less than this, in bounds, may be saved, since engines
/// pay for each. The hull grows by about as much, so that less is tried where that is too much.
const TOLERANCES: [f64; 4] = [0.15, 0.1, 0.06, 0.03];

/// Where a hull at the cap may not grow, this much of what stands out may be left out, in bounds.
const SLACKS: [f64; 3] = [0.025, 0.05, 0.1];

/// A cap on vertices that would leave out more than this, in bounds, divides the hull instead.
const MOST_LEFT_OUT: f64 = 0.5;

/// A hull that is returned, in diagonals.
pub(crate) struct Finished {
    pub hull: ConvexHull,
    pub seeds: SeedSet,
    pub added_thickness: f64,
    pub cap_growth: f64,
    /// No point of its surface is farther than this from the solid.
    pub phantom: f64,
    /// How far in front of its faces lies what the cap on vertices left out.
    pub left_out: f64,
    pub component: u32,
}

/// Everything that is returned.
pub(crate) struct Outcome {
    pub hulls: Vec<Finished>,
    pub exposed: f64,
}

/// Makes hulls of pieces. One that does not keep the bound in the end is divided again.
pub(crate) fn finish(
    seeds: &Seeds,
    pieces: Vec<Piece>,
    solid: &Solid,
    tuning: &Tuning,
    control: &Control,
) -> Result<Outcome, Error> {
    let parts =
        super::parallel::map(&pieces, |piece| finish_one(seeds, piece, solid, tuning, control));
    let mut hulls = Vec::new();
    for part in parts {
        hulls.extend(part?);
    }
    let mut owners = vec![u32::MAX; seeds.surface.triangles.len()];
    for (index, hull) in hulls.iter().enumerate() {
        for seed in hull.seeds.iter() {
            for &triangle in &seeds.seeds[seed as usize].triangles {
                owners[triangle as usize] = index as u32;
            }
        }
    }
    control.check()?;
    let outsides = super::parallel::map(&hulls, |hull: &Finished| Outside::new(&hull.hull));
    let exposed = exposed(&seeds.surface, &owners, &outsides, tuning.reduction);
    Ok(Outcome { hulls, exposed })
}

fn finish_one(
    seeds: &Seeds,
    piece: &Piece,
    solid: &Solid,
    tuning: &Tuning,
    control: &Control,
) -> Result<Vec<Finished>, Error> {
    let mut done = Vec::new();
    let mut open = vec![piece.seeds.clone()];
    let mut builder = HullBuilder::new();
    while let Some(set) = open.pop() {
        control.check()?;
        let finished = finished(seeds, set, solid, tuning, &mut builder)?;
        let members: Vec<u32> = finished.seeds.iter().collect();
        let keeps_bound =
            finished.phantom <= tuning.bound && finished.left_out <= MOST_LEFT_OUT * tuning.bound;
        if keeps_bound || members.len() < 2 {
            done.push(finished);
            continue;
        }
        let (first, second) = members.split_at(members.len() / 2);
        open.push(SeedSet::of(seeds.count(), second.iter().copied()));
        open.push(SeedSet::of(seeds.count(), first.iter().copied()));
    }
    Ok(done)
}

fn finished(
    seeds: &Seeds,
    set: SeedSet,
    solid: &Solid,
    tuning: &Tuning,
    builder: &mut HullBuilder,
) -> Result<Finished, Error> {
    let mut piece = hull_of(seeds, &set);
    let points = piece.hull.vertices();
    let (full, added_thickness) =
        solid_hull(builder, &points, piece.hull.outward, LEAST_THICKNESS)?;
    let component = set.iter().next().map_or(0, |seed| seeds.seeds[seed as usize].component);
    let make = |hull: ConvexHull, cap_growth: f64, phantom: f64, left_out: f64| Finished {
        hull,
        seeds: set.clone(),
        added_thickness,
        cap_growth,
        phantom,
        left_out,
        component,
    };
    let most = tuning.max_vertices.unwrap_or(usize::MAX);
    let slack = tuning.reduction;
    for tolerance in TOLERANCES.map(|share| share * tuning.bound) {
        let Some((hull, growth)) = fewer_vertices(builder, &full, tolerance, slack) else {
            continue;
        };
        if hull.points.len() >= full.points.len() || hull.points.len() > most {
            continue;
        }
        let phantom = phantom(&hull, solid, tuning.bound, tuning.bound);
        if phantom <= tuning.bound {
            return Ok(make(hull, growth, phantom, slack));
        }
    }
    if full.points.len() <= most {
        let phantom = phantom(&full, solid, tuning.bound, f64::INFINITY);
        return Ok(make(full, 0.0, phantom, 0.0));
    }
    // The cap has to hold: growing if the bound allows it, else leaving out what stands out least.
    for share in SLACKS {
        let capped = cap_vertices_within(builder, &full, most, share * tuning.bound);
        if let Some((hull, growth)) = capped {
            let phantom = phantom(&hull, solid, tuning.bound, tuning.bound);
            if phantom <= tuning.bound {
                return Ok(make(hull, growth, phantom, share * tuning.bound));
            }
        }
    }
    if let Some((hull, left_out)) = inner_hull(builder, &full, most) {
        let phantom = phantom(&hull, solid, tuning.bound, f64::INFINITY);
        return Ok(make(hull, 0.0, phantom, left_out));
    }
    let phantom = phantom(&full, solid, tuning.bound, f64::INFINITY);
    Ok(make(full, 0.0, phantom, 0.0))
}
