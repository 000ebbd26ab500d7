//! Division and remerging.
//!
//! A piece whose hull does not keep the bound is halved until each part does, at last down to
//! triangles of the source. Those do, unless a hull has to be thicker than the bound. Each halving
//! costs a final hull. Then divided hulls join again as long as the joint hull keeps the bound,
//! those that add the least volume first: a tenth of all meshes have divided hulls, and 7 % of
//! those hulls can join again. O(k²) joint hulls at first for k hulls, fewer where most are far
//! from each other, and O(k) for each join.

use super::final_hull::{FinalHull, Owned, make_hull};
use super::hull_simplification::FinalizeContext;
use crate::bounded::joins::{Cost, Pair, PairQueue, are_near};
use crate::bounded::patch::{Patch, PatchSet, Piece};
use crate::bounded::search::Search;
use crate::error::Error;
use crate::geometry::vector::{Vector, as_arrays, bounds, centre};
use crate::hull::{ConvexHull, HullBuilder, LEAST_THICKNESS, joint_hull, solid_hull};
use crate::parallel;
use crate::solid::{keeps_bound, protrusion};

/// What has become of a piece.
pub(super) struct PieceHulls {
    /// Each keeps the bound, except single triangles whose hull has to be thicker.
    pub hulls: Vec<FinalHull>,
    /// Whether only the limit on vertices divides it.
    pub fits_without_limit: bool,
}

/// The hulls of a piece. `None` where there are so many that the search is given up.
pub(super) fn hulls_of_piece(
    context: &FinalizeContext<'_>,
    piece: &Piece,
) -> Result<Option<PieceHulls>, Error> {
    let owned = Owned { patches: piece.patches.clone(), part: None, inner_points: Vec::new() };
    let open = vec![Open { owned, may_fill: true }];
    let mut division = Division {
        context,
        builder: HullBuilder::new(),
        open,
        done: Vec::new(),
        fits_without_limit: false,
    };
    let is_whole = division.run()?;
    let Division { done, fits_without_limit, .. } = division;
    Ok(is_whole.then_some(PieceHulls { hulls: done, fits_without_limit }))
}

/// A part that is to become a hull.
struct Open {
    owned: Owned,
    /// Whether it may contain points inside; not once they have turned out to be in a cavity.
    may_fill: bool,
}

struct Division<'a> {
    context: &'a FinalizeContext<'a>,
    builder: HullBuilder,
    open: Vec<Open>,
    done: Vec<FinalHull>,
    fits_without_limit: bool,
}

impl Division<'_> {
    /// Divides until nothing is open. Whether it was not given up before.
    fn run(&mut self) -> Result<bool, Error> {
        let &Search { settings, control, .. } = &self.context.search;
        let mut is_first = true;
        while let Some(Open { owned, may_fill }) = self.open.pop() {
            control.check()?;
            let is_first = std::mem::take(&mut is_first);
            let contains_middle = !owned.inner_points.is_empty();
            let hull = make_hull(self.context, owned, &mut self.builder)?;
            if hull.keeps_bound(settings) {
                self.done.push(hull);
                continue;
            }
            if contains_middle && hull.protrusion > settings.bound.verified() {
                let owned = Owned { inner_points: Vec::new(), ..hull.owned };
                self.open.push(Open { owned, may_fill: false });
                continue;
            }
            let mut inner_points = hull.owned.inner_points.clone();
            if (may_fill || is_first) && inner_points.is_empty() {
                let middle = self.middle(&hull)?;
                self.fits_without_limit |= is_first && middle.is_some();
                // If all parts of the hull contain it, they fill the hull; parts of the surface
                // alone would leave it hollow.
                let is_filled = may_fill && self.context.search.exact_solid.is_closed();
                inner_points.extend(middle.filter(|_| is_filled));
            }
            self.divide(hull, may_fill, inner_points)?;
            if settings.gives_up(self.done.len() + self.open.len()) {
                return Ok(false);
            }
        }
        Ok(true)
    }

    /// Halves a hull's patches; of a single patch its triangles. The halves contain the inner
    /// points.
    fn divide(
        &mut self,
        mut hull: FinalHull,
        may_fill: bool,
        inner_points: Vec<Vector>,
    ) -> Result<(), Error> {
        let &Search { patches, exact_solid: solid, settings, control, .. } = &self.context.search;
        let mut push = |patches: PatchSet, part: Option<Vec<u32>>| {
            let inner_points = inner_points.clone();
            let owned = Owned { patches, part, inner_points };
            self.open.push(Open { owned, may_fill });
        };
        let set = &hull.owned.patches;
        let mut members: Vec<u32> = set.iter().collect();
        if members.len() > 1 {
            let box_centre = |&patch: &u32| {
                let Patch { min, max, .. } = patches[patch];
                (min + max) * 0.5
            };
            let (first, second) = halves(&mut members, box_centre);
            for half in [second, first] {
                push(PatchSet::new(patches.count(), half.iter().copied()), None);
            }
            return Ok(());
        }
        let mut triangles: Vec<u32> = hull.owned.triangles(patches).collect();
        if triangles.len() < 2 {
            // The patch mesh's triangle may protrude where the source's does not. A patch that
            // owns nothing of the source can be dropped.
            if hull.owned.part.is_some() {
                let bound = settings.bound.verified();
                hull.protrusion = protrusion(&hull.hull, solid, bound, f64::INFINITY, control)?;
                self.done.push(hull);
            } else if !triangles.is_empty() {
                push(set.clone(), Some(triangles));
            }
            return Ok(());
        }
        let surface = &patches.surface;
        let triangle_centre = |&triangle: &u32| {
            let corners = surface.triangles[triangle as usize];
            centre(corners.map(|vertex| surface.points()[vertex as usize]))
        };
        let (first, second) = halves(&mut triangles, triangle_centre);
        for half in [second, first] {
            push(set.clone(), Some(half.to_vec()));
        }
        Ok(())
    }

    /// The middle of a hull that would keep the bound without the limit on vertices; `None` of
    /// another one.
    fn middle(&mut self, hull: &FinalHull) -> Result<Option<Vector>, Error> {
        let &Search { patches, exact_solid: solid, settings, control, .. } = &self.context.search;
        let Some(max_vertices) = settings.max_vertices else { return Ok(None) };
        let points = hull.owned.surface_points(patches);
        if points.len() <= max_vertices {
            return Ok(None);
        }
        let (unlimited, _) =
            solid_hull(&mut self.builder, as_arrays(&points), [0.0; 3], LEAST_THICKNESS)?;
        let (count, bound) = (unlimited.points.len(), settings.bound.verified());
        if count <= max_vertices || protrusion(&unlimited, solid, bound, bound, control)? > bound {
            return Ok(None);
        }
        let sum = unlimited.points().iter().fold(Vector::ZERO, |sum, &point| sum + point);
        Ok(Some(sum * (1.0 / count as f64)))
    }
}

/// Two halves along the axis of greatest extent.
fn halves(items: &mut [u32], centre: impl Fn(&u32) -> Vector) -> (&[u32], &[u32]) {
    let (min, max) = bounds(items.iter().map(&centre));
    let extent = |axis: &usize| max[*axis] - min[*axis];
    let axis = (0..3).max_by(|a, b| extent(a).total_cmp(&extent(b))).unwrap_or(0);
    items.sort_by(|a, b| centre(a)[axis].total_cmp(&centre(b)[axis]).then(a.cmp(b)));
    items.split_at(items.len() / 2)
}

/// A hull that may join others. It stays in the list when it has.
struct Entry {
    hull: FinalHull,
    volume: f64,
    /// Of its bounding box.
    corners: [Vector; 2],
}

impl Entry {
    fn new(hull: FinalHull) -> Self {
        let (min, max) = bounds(hull.hull.points().iter().copied());
        let volume = hull.hull.volume();
        Self { hull, volume, corners: [min, max] }
    }
}

/// Joins hulls. They are verified from the cheapest pair on until one keeps the bound: most that
/// are dearer lose one of their hulls before it is their turn.
pub(super) fn remerge(
    context: &FinalizeContext<'_>,
    hulls: Vec<FinalHull>,
) -> Result<Vec<FinalHull>, Error> {
    let &Search { patches, settings, control, .. } = &context.search;
    let gap = settings.widest_gap(settings.bound.verified());
    let mut entries: Vec<Entry> = hulls.into_iter().map(Entry::new).collect();
    let mut queue = PairQueue::new(entries.len());
    let count = entries.len() as u32;
    let mut pairs: Vec<Pair> =
        (0..count).flat_map(|second| (0..second).map(move |first| (first, second))).collect();
    let mut builder = HullBuilder::new();
    while !control.is_past_deadline() {
        let corners = |hull: u32| entries[hull as usize].corners;
        pairs.retain(|&(a, b)| queue.is_left(a) && are_near(corners(a), corners(b), gap));
        let costs = parallel::map(&pairs, |&pair| cost(context, &entries, pair));
        for (pair, cost) in pairs.drain(..).zip(costs) {
            if let Some(cost) = cost? {
                queue.push(Cost(cost), pair, ());
            }
        }
        let Some(pair) = cheapest(context, &entries, &mut queue)? else { break };
        let [first, second] = [pair.0, pair.1].map(|hull| &entries[hull as usize].hull.owned);
        let owned = Owned::union(&[first, second], patches);
        let joint = make_hull(context, owned, &mut builder)?;
        if joint.keeps_bound(settings) {
            let new = queue.join(pair);
            entries.push(Entry::new(joint));
            pairs.extend((0..new).map(|other| (other, new)));
        }
    }
    let left = (0..).zip(entries).filter(|(index, _)| queue.is_left(*index));
    Ok(left.map(|(_, entry)| entry.hull).collect())
}

/// Volume that the joint hull of a pair adds, as a share of its own; `None` if it has too many
/// vertices.
fn cost(
    context: &FinalizeContext<'_>,
    entries: &[Entry],
    pair: Pair,
) -> Result<Option<f64>, Error> {
    let &Search { settings, control, .. } = &context.search;
    control.check()?;
    let joint = hull_of_pair(entries, pair)?;
    // Simplification hardly ever keeps the limit of a hull that exceeds it here.
    if settings.max_vertices.is_some_and(|most| joint.points.len() > most) {
        return Ok(None);
    }
    let volume = joint.volume();
    let apart = entries[pair.0 as usize].volume + entries[pair.1 as usize].volume;
    Ok(Some((volume - apart) / volume))
}

/// Takes out the cheapest pair whose joint hull keeps the bound, and those before it, which do not.
fn cheapest(
    context: &FinalizeContext<'_>,
    entries: &[Entry],
    queue: &mut PairQueue<Cost, ()>,
) -> Result<Option<Pair>, Error> {
    let &Search { exact_solid: solid, settings, control, .. } = &context.search;
    let candidates = queue.pop_all();
    let pairs: Vec<Pair> = candidates.iter().map(|&(_, pair, ())| pair).collect();
    let keeps = |&pair: &Pair| {
        let joint = hull_of_pair(entries, pair)?;
        keeps_bound(&joint, solid, settings.bound.verified(), control)
    };
    let mut verdicts = parallel::map_until(&pairs, keeps, |verdict| !matches!(verdict, Ok(false)));
    let Some(last) = verdicts.pop() else { return Ok(None) };
    if !last? {
        return Ok(None);
    }
    let mut others = candidates.into_iter().skip(verdicts.len());
    let found = others.next().map(|(_, pair, ())| pair);
    others.for_each(|(cost, pair, ())| queue.push(cost, pair, ()));
    Ok(found)
}

/// The hull of a pair of hulls.
fn hull_of_pair(entries: &[Entry], (first, second): Pair) -> Result<ConvexHull, Error> {
    let hull = |index: u32| &entries[index as usize].hull.hull;
    joint_hull(&mut HullBuilder::new(), hull(first), hull(second))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bounded::fixture::{Fixture, cubes, l_prism, times_in, u_prism};
    use crate::mesh::shapes::{cuboid, uv_sphere};
    use crate::parameters::{Length, Parameters};

    fn context(fixture: &Fixture) -> FinalizeContext<'_> {
        FinalizeContext { search: fixture.search(), volume_per_vertex: 0.0 }
    }

    /// The hulls of a piece of all patches.
    fn divided(fixture: &Fixture) -> Option<PieceHulls> {
        let piece = fixture.piece(0..fixture.patches.count() as u32);
        hulls_of_piece(&context(fixture), &piece).unwrap()
    }

    /// How often each triangle of the surface is owned.
    fn owners(fixture: &Fixture, hulls: &[FinalHull]) -> Vec<u32> {
        let mut owners = vec![0; fixture.patches.surface.triangles.len()];
        for hull in hulls {
            let own = hull.owned.triangles(&fixture.patches);
            own.for_each(|triangle| owners[triangle as usize] += 1);
        }
        owners
    }

    #[test]
    fn a_piece_that_keeps_the_bound_is_not_divided() {
        let fixture = Fixture::new(&cuboid([0.0; 3], [1.0; 3]), 0.02);
        let PieceHulls { hulls, fits_without_limit } = divided(&fixture).unwrap();
        assert_eq!(hulls.len(), 1);
        assert!(!fits_without_limit);
    }

    #[test]
    fn a_piece_over_a_notch_is_divided_until_each_part_keeps_the_bound() {
        for mesh in [l_prism(), u_prism(), cubes([0.0, 1.5, 3.0])] {
            let fixture = Fixture::new(&mesh, 0.02);
            let PieceHulls { hulls, fits_without_limit } = divided(&fixture).unwrap();
            assert!(hulls.len() > 1 && !fits_without_limit);
            assert!(hulls.iter().all(|hull| hull.keeps_bound(&fixture.settings)));
            let count = fixture.patches.count();
            let sets = hulls.iter().map(|hull| &hull.owned.patches);
            assert_eq!(times_in(count, sets), vec![1; count]);
            assert!(owners(&fixture, &hulls).iter().all(|&owners| owners == 1));
        }
    }

    #[test]
    fn a_single_patch_is_divided_into_its_triangles() {
        // A ball is one patch, which needs far more vertices than the limit allows.
        let parameters =
            Parameters::default().with_max_error(Length::share(0.01)).with_max_vertices(Some(12));
        let fixture = Fixture::with(&uv_sphere(12, [0.0; 3], 1.0), &parameters);
        assert_eq!(fixture.patches.count(), 1);
        let PieceHulls { hulls, fits_without_limit } = divided(&fixture).unwrap();
        assert!(hulls.len() > 1 && fits_without_limit);
        for hull in &hulls {
            assert!(hull.hull.points.len() <= 12 && hull.owned.part.is_some());
            // Its middle stays within all of them, so that no gap opens there.
            assert_eq!(hull.owned.inner_points.len(), 1);
        }
        assert!(owners(&fixture, &hulls).iter().all(|&owners| owners == 1));
    }

    #[test]
    fn a_division_into_more_hulls_than_the_limit_is_given_up() {
        let parameters = Parameters::default().with_max_hulls(1);
        let mut fixture = Fixture::with(&l_prism(), &parameters);
        assert!(divided(&fixture).is_some());
        fixture.settings = fixture.settings.with_bound(0.02);
        assert!(divided(&fixture).is_none());
    }

    #[test]
    fn items_are_halved_along_the_axis_on_which_they_lie_farthest_apart() {
        let places = [[0.0, 5.0, 0.0], [1.0, 0.0, 1.0], [2.0, 9.0, 0.0], [0.0, 2.0, 3.0]];
        let mut items = [0, 1, 2, 3];
        let (first, second) = halves(&mut items, |&item| Vector::from(places[item as usize]));
        assert_eq!((first, second), (&[1, 3][..], &[0, 2][..]));
    }

    #[test]
    fn of_three_items_at_one_place_neither_half_is_empty() {
        let mut items = [4, 2, 3];
        let (first, second) = halves(&mut items, |_| Vector::ZERO);
        assert_eq!((first, second), (&[2][..], &[3, 4][..]));
    }

    #[test]
    fn hulls_of_one_convex_part_join_again() {
        for (mesh, parts) in [(l_prism(), 2), (u_prism(), 3)] {
            let fixture = Fixture::new(&mesh, 0.02);
            // One hull for each patch.
            let pieces = (0..fixture.patches.count() as u32).map(|patch| fixture.piece([patch]));
            let hulls = pieces.flat_map(|piece| {
                hulls_of_piece(&context(&fixture), &piece).unwrap().unwrap().hulls
            });
            let joined = remerge(&context(&fixture), hulls.collect()).unwrap();
            assert_eq!(joined.len(), parts);
            assert!(joined.iter().all(|hull| hull.keeps_bound(&fixture.settings)));
            assert!(owners(&fixture, &joined).iter().all(|&owners| owners == 1));
        }
    }

    #[test]
    fn hulls_apart_do_not_join_and_hulls_at_a_crack_do() {
        let fixture = Fixture::new(&cubes([0.0, 1.02, 3.0]), 0.02);
        let joined = remerge(&context(&fixture), fixture.hulls_of_patches()).unwrap();
        let mut sets: Vec<Vec<u32>> =
            joined.iter().map(|hull| hull.owned.patches.iter().collect()).collect();
        sets.sort();
        assert_eq!(sets, [vec![0, 1], vec![2]]);
    }

    #[test]
    fn a_pair_with_more_vertices_than_the_limit_has_no_cost() {
        let mut fixture = Fixture::new(&cubes([0.0, 1.02]), 0.02);
        let entries: Vec<Entry> = fixture.hulls_of_patches().into_iter().map(Entry::new).collect();
        let found = cost(&context(&fixture), &entries, (0, 1)).unwrap().unwrap();
        assert!((found - 0.02 / 2.02).abs() < 1e-6, "{found}");
        fixture.settings.max_vertices = Some(7);
        assert_eq!(cost(&context(&fixture), &entries, (0, 1)).unwrap(), None);
    }
}
