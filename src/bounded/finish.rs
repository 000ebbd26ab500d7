//! What is returned: hulls with thickness and few vertices, each verified against the source.

use super::Tuning;
use super::certify::{self, Outside, left_out, phantom};
use super::cover::hull_of;
use super::piece::{Hull, Piece};
use super::seed_set::SeedSet;
use super::seeds::{Seed, Seeds};
use super::solid::Solid;
use crate::hull::{
    ConvexHull, HullBuilder, LEAST_THICKNESS, Shape, cap_vertices_within, fewer_vertices,
    inner_hull, solid_hull,
};
use crate::vector::{Vector, add, area_normal, maximum, minimum, scale};
use crate::{Control, Error};

/// Vertices that stand out of the others by less than this, in bounds, may be saved, since engines
/// pay for each. The hull grows by about as much, so that less is tried where that is too much.
const TOLERANCES: [f64; 4] = [0.15, 0.1, 0.06, 0.03];

/// The surface may lie this far outside of a hull that leaves out vertices, in bounds.
const LEFT_OUT: f64 = 0.05;

/// Where a hull at the cap may not grow, this much of what stands out may be left out, in bounds.
const SLACKS: [f64; 3] = [0.025, 0.05, 0.1];

/// A cap on vertices that would leave out more than this, in bounds, divides the hull instead.
const MOST_LEFT_OUT: f64 = 0.5;

/// A hull that is returned, in diagonals.
pub(crate) struct Finished {
    pub hull: ConvexHull,
    pub seeds: SeedSet,
    /// Where it holds a part of a single seed only: that part's triangles of the surface.
    pub part: Option<Vec<u32>>,
    pub added_thickness: f64,
    pub cap_growth: f64,
    /// No point of its surface is farther than this from the solid.
    pub phantom: f64,
    /// No point of the surface that it stands for is farther than this outside of it.
    pub left_out: f64,
    pub component: u32,
}

impl Finished {
    /// The triangles of [`Seeds::surface`] that it stands for.
    pub fn triangles<'a>(&'a self, seeds: &'a Seeds) -> impl Iterator<Item = u32> + 'a {
        let of_seeds = self.part.is_none().then(|| {
            self.seeds.iter().flat_map(|seed| &seeds.seeds[seed as usize].triangles).copied()
        });
        of_seeds.into_iter().flatten().chain(self.part.iter().flatten().copied())
    }
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
        crate::parallel::map(&pieces, |piece| finish_one(seeds, piece, solid, tuning, control));
    let mut hulls = Vec::new();
    for part in parts {
        hulls.extend(part?);
    }
    let mut owners = vec![u32::MAX; seeds.surface.triangles.len()];
    for (index, hull) in hulls.iter().enumerate() {
        for triangle in hull.triangles(seeds) {
            owners[triangle as usize] = index as u32;
        }
    }
    control.check()?;
    let mut exposed = hulls.iter().map(|hull| hull.left_out).fold(0.0, f64::max);
    if exposed > LEFT_OUT * tuning.bound {
        // Other hulls may hold what one has left out.
        let outsides: Vec<Outside> = hulls.iter().map(|hull| Outside::new(&hull.hull)).collect();
        exposed = certify::exposed(&seeds.surface, &owners, &outsides, tuning.reduction, control)?;
    }
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
    let mut open = vec![(piece.seeds.clone(), None)];
    let mut builder = HullBuilder::new();
    while let Some((set, part)) = open.pop() {
        control.check()?;
        let finished = finished(seeds, set, part, solid, tuning, &mut builder, control)?;
        let keeps_bound =
            finished.phantom <= tuning.bound && finished.left_out <= MOST_LEFT_OUT * tuning.bound;
        if keeps_bound {
            done.push(finished);
            continue;
        }
        let mut members: Vec<u32> = finished.seeds.iter().collect();
        if members.len() > 1 {
            let centre = |&seed: &u32| {
                let Seed { min, max, .. } = seeds.seeds[seed as usize];
                scale(add(min, max), 0.5)
            };
            let (first, second) = halves(&mut members, centre);
            for half in [second, first] {
                open.push((SeedSet::of(seeds.count(), half.iter().copied()), None));
            }
            continue;
        }
        // Triangles of the source fit, at the latest each on its own.
        let mut triangles: Vec<u32> = finished.triangles(seeds).collect();
        if triangles.len() < 2 {
            // The simplified mesh's triangle may stand out where the source's does not, and if it
            // stands for none, nobody misses it.
            if finished.part.is_some() {
                done.push(finished);
            } else if !triangles.is_empty() {
                open.push((finished.seeds.clone(), Some(triangles)));
            }
            continue;
        }
        let centre = |&triangle: &u32| {
            let corners = seeds.surface.triangles[triangle as usize];
            let [a, b, c] = corners.map(|vertex| seeds.surface.positions[vertex as usize]);
            scale(add(add(a, b), c), 1.0 / 3.0)
        };
        let (first, second) = halves(&mut triangles, centre);
        for half in [second, first] {
            open.push((finished.seeds.clone(), Some(half.to_vec())));
        }
    }
    Ok(done)
}

/// Two halves along the axis on which the items are spread most.
fn halves(items: &mut [u32], centre: impl Fn(&u32) -> Vector) -> (&[u32], &[u32]) {
    let (mut min, mut max) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for item in items.iter() {
        min = minimum(min, centre(item));
        max = maximum(max, centre(item));
    }
    let extent = |axis: &usize| max[*axis] - min[*axis];
    let axis = (0..3).max_by(|a, b| extent(a).total_cmp(&extent(b))).unwrap_or(0);
    items.sort_by(|a, b| centre(a)[axis].total_cmp(&centre(b)[axis]).then(a.cmp(b)));
    items.split_at(items.len() / 2)
}

fn finished(
    seeds: &Seeds,
    set: SeedSet,
    part: Option<Vec<u32>>,
    solid: &Solid,
    tuning: &Tuning,
    builder: &mut HullBuilder,
    control: &Control,
) -> Result<Finished, Error> {
    let mut hull = match &part {
        None => hull_of(seeds, &set).hull,
        Some(triangles) => {
            let corners = |&triangle: &u32| {
                seeds.surface.triangles[triangle as usize]
                    .map(|vertex| seeds.surface.positions[vertex as usize])
            };
            let points: Vec<Vector> = triangles.iter().flat_map(corners).collect();
            let normals = triangles.iter().map(corners).map(|[a, b, c]| area_normal(a, b, c));
            Hull::of(&points, normals.fold([0.0; 3], add))
        }
    };
    let own = extreme(builder, own_points(seeds, &set, part.as_deref()));
    let points = hull.vertices();
    let (mut full, mut added_thickness) =
        solid_hull(builder, &points, hull.outward, LEAST_THICKNESS)?;
    let allowed = LEFT_OUT * tuning.bound;
    let mut full_left_out = left_out(&full, &own, allowed);
    if full_left_out > allowed {
        // Beyond a sharp edge a point can be far away that is hardly in front of any face.
        (full, added_thickness) = solid_hull(builder, &own, hull.outward, LEAST_THICKNESS)?;
        full_left_out = left_out(&full, &own, f64::INFINITY);
    }
    let component = set.iter().next().map_or(0, |seed| seeds.seeds[seed as usize].component);
    let make = |hull: ConvexHull, cap_growth: f64, phantom: f64, left_out: f64| Finished {
        hull,
        seeds: set.clone(),
        part: part.clone(),
        added_thickness,
        cap_growth,
        phantom,
        left_out,
        component,
    };
    let most = tuning.max_vertices.unwrap_or(usize::MAX);
    for tolerance in TOLERANCES.map(|share| share * tuning.bound) {
        control.check()?;
        let Some((hull, growth)) = fewer_vertices(builder, &full, tolerance, tuning.reduction)
        else {
            continue;
        };
        if hull.points.len() >= full.points.len() || hull.points.len() > most {
            continue;
        }
        let left_out = left_out(&hull, &own, allowed);
        if left_out > allowed {
            continue;
        }
        let phantom = phantom(&hull, solid, tuning.bound, tuning.bound, control)?;
        if phantom <= tuning.bound {
            return Ok(make(hull, growth, phantom, left_out));
        }
    }
    if full.points.len() <= most {
        let phantom = phantom(&full, solid, tuning.bound, f64::INFINITY, control)?;
        return Ok(make(full, 0.0, phantom, full_left_out));
    }
    // The cap has to hold: growing if the bound allows it, else leaving out what stands out least.
    for share in SLACKS {
        let capped = cap_vertices_within(builder, &full, most, share * tuning.bound);
        if let Some((hull, growth)) = capped {
            let phantom = phantom(&hull, solid, tuning.bound, tuning.bound, control)?;
            let left_out = left_out(&hull, &own, f64::INFINITY);
            if phantom <= tuning.bound && left_out <= MOST_LEFT_OUT * tuning.bound {
                return Ok(make(hull, growth, phantom, left_out));
            }
        }
    }
    if let Some((hull, _)) = inner_hull(builder, &full, most) {
        let phantom = phantom(&hull, solid, tuning.bound, f64::INFINITY, control)?;
        let left_out = left_out(&hull, &own, f64::INFINITY);
        return Ok(make(hull, 0.0, phantom, left_out));
    }
    let phantom = phantom(&full, solid, tuning.bound, f64::INFINITY, control)?;
    Ok(make(full, 0.0, phantom, full_left_out))
}

/// Those of some points that tell how far all of them are outside of a hull: the distance to a
/// convex set is a convex function, so the vertices of the points' own hull do.
fn extreme(builder: &mut HullBuilder, points: Vec<Vector>) -> Vec<Vector> {
    if points.len() < FEW || builder.build(&points) != Shape::Solid {
        return points;
    }
    builder.extract().0
}

/// So few points are asked as quickly as their hull is built.
const FEW: usize = 64;

/// The surface's vertices that a hull must hold.
fn own_points(seeds: &Seeds, set: &SeedSet, part: Option<&[u32]>) -> Vec<Vector> {
    let corners = |&triangle: &u32| seeds.surface.triangles[triangle as usize];
    let mut vertices: Vec<u32> = match part {
        Some(triangles) => triangles.iter().flat_map(corners).collect(),
        None => {
            set.iter().flat_map(|s| &seeds.seeds[s as usize].triangles).flat_map(corners).collect()
        }
    };
    vertices.sort_unstable();
    vertices.dedup();
    vertices.iter().map(|&vertex| seeds.surface.positions[vertex as usize]).collect()
}
