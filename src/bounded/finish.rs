//! What is returned: hulls with thickness and few vertices (see `few_vertices`), each verified against
//! the source.

use super::Tuning;
use super::certify::{self, Outside, PointGroups, left_out, phantom};
use super::cover::{self, Covered, hull_of};
use super::few_vertices::{Few, Whole, few_vertices};
use super::piece::{Hull, Piece};
use super::rejoin::rejoin;
use super::seed_set::SeedSet;
use super::seeds::{Seed, Seeds};
use super::solid::Solid;
use crate::control::Control;
use crate::error::Error;
use crate::geometry::vector::{Vector, add, area_normal, bounds, scale};
use crate::hull::{ConvexHull, HullBuilder, LEAST_THICKNESS, solid_hull};

/// An edge may collapse if that adds at most this share of the mean volume of all hulls: engines pay
/// for each vertex.
const VOLUME_PER_VERTEX: f64 = 1.2e-3;

/// The surface may lie this far outside of a hull that leaves out vertices, in bounds.
pub(super) const LEFT_OUT: f64 = 0.05;

/// A cap on vertices that would let the surface lie farther outside than this, in bounds, divides the
/// hull instead.
pub(super) const MOST_LEFT_OUT: f64 = 0.5;

/// A hull that is returned, in diagonals.
pub(crate) struct Finished {
    pub hull: ConvexHull,
    pub seeds: SeedSet,
    /// Where it holds a part of its seeds only: that part's triangles of the surface.
    pub part: Option<Vec<u32>>,
    /// Points inside that it holds too, so that nothing between it and others of its kind stays empty.
    pub inner: Vec<Vector>,
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

/// What hulls are made from.
pub(super) struct Material<'a> {
    pub seeds: &'a Seeds,
    pub solid: &'a Solid,
    pub tuning: &'a Tuning,
    /// A vertex may be saved if that adds at most this volume, in cubed diagonals.
    pub volume_per_vertex: f64,
    pub control: &'a Control,
}

/// Makes hulls of pieces; of those before the last round of dissolving where that serves better: what was
/// won by nearly all of the bound may be lost again when it is verified, or leave surface outside, which
/// counts more than hulls.
pub(crate) fn finish_covered(
    seeds: &Seeds,
    Covered { pieces, before }: Covered,
    solid: &Solid,
    tuning: &Tuning,
    control: &Control,
) -> Result<Outcome, Error> {
    let count = pieces.len();
    let finished = finish(seeds, pieces, solid, tuning, control)?;
    let is_exposed = finished.exposed > LEFT_OUT * tuning.bound;
    let is_divided = finished.hulls.len() > count;
    let Some(before) = before else { return Ok(finished) };
    if !(is_exposed || is_divided) || control.is_past_deadline() {
        return Ok(finished);
    }
    let before = cover::shrink(seeds, before, control)?;
    let other = finish(seeds, before, solid, tuning, control)?;
    let serves_better =
        other.hulls.len() <= finished.hulls.len() || is_exposed && other.exposed < finished.exposed;
    Ok(if serves_better { other } else { finished })
}

/// Makes hulls of pieces. One that does not keep the bound in the end is divided again.
pub(crate) fn finish(
    seeds: &Seeds,
    pieces: Vec<Piece>,
    solid: &Solid,
    tuning: &Tuning,
    control: &Control,
) -> Result<Outcome, Error> {
    let volume =
        pieces.iter().map(|piece| piece.hull.volume).sum::<f64>() / pieces.len().max(1) as f64;
    let volume_per_vertex = VOLUME_PER_VERTEX * volume;
    let material = Material { seeds, solid, tuning, volume_per_vertex, control };
    let size = |piece: &Piece| piece.seeds.count();
    let parts =
        crate::parallel::map_largest_first(&pieces, size, |piece| finish_one(&material, piece));
    let parts = parts.into_iter().collect::<Result<Vec<Vec<Finished>>, Error>>()?;
    let is_divided = parts.iter().any(|part| part.len() > 1);
    let mut hulls: Vec<Finished> = parts.into_iter().flatten().collect();
    if is_divided {
        hulls = rejoin(&material, hulls)?;
    }
    let exposed = exposed(&material, &hulls)?;
    Ok(Outcome { hulls, exposed })
}

/// No point of the surface is farther than this outside all hulls.
fn exposed(material: &Material<'_>, hulls: &[Finished]) -> Result<f64, Error> {
    let &Material { seeds, tuning, control, .. } = material;
    let allowed = LEFT_OUT * tuning.bound;
    let (settled, open): (Vec<_>, Vec<_>) =
        (0..).zip(hulls).partition(|(_, hull)| hull.left_out <= allowed);
    let mut exposed = settled.iter().map(|(_, hull)| hull.left_out).fold(0.0, f64::max);
    if open.is_empty() {
        return Ok(exposed);
    }
    control.check()?;
    // Other hulls may hold what one has left out.
    let mut owners = vec![u32::MAX; seeds.surface.triangles.len()];
    for (index, hull) in open {
        if hull.part.is_some() {
            hull.triangles(seeds).for_each(|triangle| owners[triangle as usize] = index);
            continue;
        }
        for seed in hull.seeds.iter() {
            control.check()?;
            let own = own_points(seeds, &SeedSet::of(seeds.count(), [seed]), None);
            let seed = &seeds.seeds[seed as usize];
            let left_out = left_out(&hull.hull, &PointGroups::new(&own), f64::INFINITY);
            if left_out <= allowed {
                exposed = exposed.max(left_out);
            } else {
                seed.triangles.iter().for_each(|&triangle| owners[triangle as usize] = index);
            }
        }
    }
    let outsides: Vec<Outside> = hulls.iter().map(|hull| Outside::new(&hull.hull)).collect();
    let enough = exposed.max(tuning.enough);
    certify::exposed(&seeds.surface, &owners, &outsides, enough, control)
}

fn finish_one(material: &Material<'_>, piece: &Piece) -> Result<Vec<Finished>, Error> {
    let &Material { seeds, tuning, control, .. } = material;
    let mut done = Vec::new();
    // With points inside that parts hold too; without, once they have turned out to lie in a cavity.
    let mut open = vec![(piece.seeds.clone(), None, Some(Vec::new()))];
    let mut builder = HullBuilder::new();
    while let Some((set, part, inner)) = open.pop() {
        control.check()?;
        let is_filling = inner.as_ref().is_some_and(|inner| !inner.is_empty());
        let may_fill = inner.is_some();
        let finished = finished(material, set, part, inner.unwrap_or_default(), &mut builder)?;
        if keeps_bound(&finished, tuning) {
            done.push(finished);
            continue;
        }
        if is_filling && finished.phantom > tuning.bound {
            open.push((finished.seeds, finished.part, None));
            continue;
        }
        let mut inner = may_fill.then(|| finished.inner.clone());
        if let Some(inner) = &mut inner
            && inner.is_empty()
        {
            inner.extend(middle(material, &finished, &mut builder)?);
        }
        let mut members: Vec<u32> = finished.seeds.iter().collect();
        if members.len() > 1 {
            let centre = |&seed: &u32| {
                let Seed { min, max, .. } = seeds.seeds[seed as usize];
                scale(add(min, max), 0.5)
            };
            let (first, second) = halves(&mut members, centre);
            for half in [second, first] {
                open.push((SeedSet::of(seeds.count(), half.iter().copied()), None, inner.clone()));
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
                open.push((finished.seeds.clone(), Some(triangles), inner));
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
            open.push((finished.seeds.clone(), Some(half.to_vec()), inner.clone()));
        }
    }
    Ok(done)
}

pub(super) fn keeps_bound(finished: &Finished, tuning: &Tuning) -> bool {
    finished.phantom <= tuning.bound && finished.left_out <= MOST_LEFT_OUT * tuning.bound
}

/// The middle of a hull that would keep the bound but for its cap on vertices: its parts, each of which is a hull
/// of some of the surface, fill it if all of them reach there.
fn middle(
    material: &Material<'_>,
    finished: &Finished,
    builder: &mut HullBuilder,
) -> Result<Option<Vector>, Error> {
    let &Material { seeds, solid, tuning, control, .. } = material;
    let Some(most) = tuning.max_vertices else { return Ok(None) };
    let own = own_points(seeds, &finished.seeds, finished.part.as_deref());
    // A seed may stand for nothing of the surface.
    if !solid.is_closed || own.len() <= most {
        return Ok(None);
    }
    let (whole, _) = solid_hull(builder, &own, [0.0; 3], LEAST_THICKNESS)?;
    let count = whole.points.len();
    if count <= most || phantom(&whole, solid, tuning.bound, tuning.bound, control)? > tuning.bound
    {
        return Ok(None);
    }
    let sum = whole.points.iter().fold([0.0; 3], |sum, &point| add(sum, point));
    Ok(Some(scale(sum, 1.0 / count as f64)))
}

/// Two halves along the axis on which the items are spread most.
fn halves(items: &mut [u32], centre: impl Fn(&u32) -> Vector) -> (&[u32], &[u32]) {
    let (min, max) = bounds(items.iter().map(&centre));
    let extent = |axis: &usize| max[*axis] - min[*axis];
    let axis = (0..3).max_by(|a, b| extent(a).total_cmp(&extent(b))).unwrap_or(0);
    items.sort_by(|a, b| centre(a)[axis].total_cmp(&centre(b)[axis]).then(a.cmp(b)));
    items.split_at(items.len() / 2)
}

/// A hull of seeds, or of a part of one, as it may be returned; it need not keep the bound.
pub(super) fn finished(
    material: &Material<'_>,
    set: SeedSet,
    part: Option<Vec<u32>>,
    inner: Vec<Vector>,
    builder: &mut HullBuilder,
) -> Result<Finished, Error> {
    let &Material { seeds, tuning, .. } = material;
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
    hull.insert(&inner, [0.0; 3]);
    let mut own = own_points(seeds, &set, part.as_deref());
    own.extend_from_slice(&inner);
    let own = extreme(builder, own);
    let groups = PointGroups::new(&own);
    let points = hull.vertices();
    let (mut full, mut added_thickness) =
        solid_hull(builder, &points, hull.outward, LEAST_THICKNESS)?;
    let allowed = LEFT_OUT * tuning.bound;
    let mut full_left_out = left_out(&full, &groups, allowed);
    if full_left_out > allowed && own.len() > WORTH_A_HULL.end {
        // The hull of very many points has thousands of vertices that don't matter.
        let mut reducer = HullBuilder::new().with_least_tolerance(OF_MANY * allowed);
        if let Some(points) = reducer.vertices_of(&own) {
            (full, added_thickness) = solid_hull(builder, &points, hull.outward, LEAST_THICKNESS)?;
            full_left_out = left_out(&full, &groups, allowed);
        }
    }
    if full_left_out > allowed {
        // Beyond a sharp edge a point can be far away that is hardly in front of any face.
        (full, added_thickness) = solid_hull(builder, &own, hull.outward, LEAST_THICKNESS)?;
        full_left_out = left_out(&full, &groups, f64::INFINITY);
    }
    let component = set.iter().next().map_or(0, |seed| seeds.seeds[seed as usize].component);
    let whole = Whole { hull: full, left_out: full_left_out, own: groups, outward: hull.outward };
    let Few { hull, growth, phantom, left_out } = few_vertices(material, whole, builder)?;
    Ok(Finished {
        hull,
        seeds: set,
        part,
        inner,
        added_thickness,
        cap_growth: growth,
        phantom,
        left_out,
        component,
    })
}

/// The surface's vertices that a hull must hold.
fn own_points(seeds: &Seeds, set: &SeedSet, part: Option<&[u32]>) -> Vec<Vector> {
    match part {
        Some(triangles) => seeds.surface.positions_of(triangles.iter().copied()),
        None => {
            let of = |seed: u32| &seeds.seeds[seed as usize];
            if set.iter().any(|seed| !of(seed).own.is_empty()) {
                return set.iter().flat_map(|seed| &of(seed).own).copied().collect();
            }
            let triangles = set.iter().flat_map(|seed| &of(seed).triangles);
            seeds.surface.positions_of(triangles.copied())
        }
    }
}

/// Those of some points that tell how far all of them are outside of a hull: the distance to a
/// convex set is a convex function, so the vertices of the points' own hull do.
fn extreme(builder: &mut HullBuilder, points: Vec<Vector>) -> Vec<Vector> {
    let vertices = WORTH_A_HULL.contains(&points.len()).then(|| builder.vertices_of(&points));
    vertices.flatten().unwrap_or(points)
}

/// Of very many points those are left out of a hull that stand out less than this share of what may be left
/// out.
const OF_MANY: f64 = 0.25;

/// Fewer points are asked as quickly as their hull is built, more in less time.
const WORTH_A_HULL: std::ops::Range<usize> = 64..8192;
