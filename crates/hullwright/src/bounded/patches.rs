//! The surface is divided into patches: the paper's groups (section 3.4.1) of the patch mesh,
//! halved between its facets until the hull of each patch, or of a part that contains it, fits.
//!
//! Takes the patch mesh and the solid, gives [`Patches`] with their neighbours, seeds and
//! conflicts. Components whose hull fits, above all convex ones, are one patch each. O(n log n) for
//! n triangles, two fit tests per patch, and O(p²) segments between p patches.

use super::detail::Detail;
use super::facets::components;
use super::patch::{Patch, PatchSet, Patches, far_pair};
use super::patch_mesh::{PatchMesh, reducer_of_whole};
use super::settings::Settings;
use super::surfaces::Surfaces;
use crate::control::Control;
use crate::error::Error;
use crate::geometry::vector::{Vector, diagonal};
use crate::hull::HullBuilder;
use crate::hull::growing_hull::GrowingHull;
use crate::mesh::adjacency::{Adjacency, NO_NEIGHBOUR};
use crate::mesh::grouping::{group, members};
use crate::parallel;
use crate::solid::FitTester;
use crate::solid::Solid;
use crate::sorting::{sort_by_key, sort_by_number};

/// Above this number of groups the grouping is repeated with a larger threshold: under the first
/// one, each facet of a fine cylinder is a group. Where the bound as the threshold leaves more, the
/// surface folds everywhere, and whole components are divided instead: the search compares all
/// patches, and 6,500 take it half a minute.
const MAX_GROUPS: usize = 600;

/// Factor between the thresholds of repeated groupings.
const THRESHOLD_GROWTH: f64 = 2.0;

/// Triangles whose extent exceeds that of the longest of them by this factor can be divided by
/// size. Halving a bundle of needles across leaves parts as long as before: a tube of 300 facets
/// would become 5,000 patches.
const MIN_ELONGATION: f64 = 1.5;

/// Facets of a patch that are compared with each other: a hull around empty space has some of them
/// on either side of it.
const MAX_COMPARED: usize = 16;

/// Steps of the power iteration for the longest principal axis: any axis near it serves.
const POWER_STEPS: usize = 30;

/// Start of the power iteration: oblique, since flat groups are often orthogonal to an axis.
const POWER_START: Vector = Vector::new(1.0, 0.7, 0.4);

/// A patch and its triangles of the patch mesh.
type Part = (Patch, Vec<u32>);

/// Divides the surface into patches.
pub(crate) fn divide_into_patches(
    mesh: PatchMesh,
    surfaces: &Surfaces,
    solid: &Solid,
    settings: &Settings,
    control: &Control,
) -> Result<Patches, Error> {
    let adjacency = Adjacency::new(&mesh.mesh);
    let largest = settings.patch_size * mesh.mesh.area().sqrt();
    let division = Division { mesh: &mesh, solid, settings, largest, control };
    let (mut groups, mut are_across_folds) = division.groups(&adjacency)?;
    are_across_folds |= !mesh.bundles.is_empty();
    let mut patches = Vec::new();
    let mut labels = vec![0_u32; mesh.mesh.triangles.len()];
    let mut add = |(patch, triangles): Part| {
        triangles.iter().for_each(|&triangle| labels[triangle as usize] = patches.len() as u32);
        patches.push(patch);
        patches.len() as u32 - 1
    };
    let (is_whole, wholes) = division.whole_components()?;
    let mut seeds: Vec<Vec<u32>> = wholes.into_iter().map(|whole| vec![add(whole)]).collect();
    for group in &mut groups {
        group.retain(|&triangle| !is_whole[mesh.components[triangle as usize] as usize]);
    }
    groups.retain(|group| !group.is_empty());
    if !mesh.planes.is_empty() {
        groups = between_cuts(&mesh, &adjacency, &groups);
    }
    let divided = parallel::map_largest_first(&groups, Vec::len, |group| division.divide(group));
    for group in divided {
        seeds.extend(group?.into_iter().map(|seed| seed.into_iter().map(&mut add).collect()));
    }
    let neighbours = neighbours(&adjacency, &labels);
    let PatchMesh { mut mesh, surface, parents, bundles, .. } = mesh;
    let start = mesh.positions.len() as u32;
    if !bundles.is_empty() {
        mesh.positions.extend_from_slice(&surface.positions);
    }
    for seed in bundles {
        let first = patches.len() as u32;
        for bundle in seed {
            labels.resize(labels.len() + bundle.triangles.len(), patches.len() as u32);
            let corners = bundle.triangles.iter().map(|&part| surface.triangles[part as usize]);
            mesh.triangles.extend(corners.map(|corners| corners.map(|vertex| start + vertex)));
            patches.push(bundle);
        }
        seeds.push((first..patches.len() as u32).collect());
    }
    let detail = Detail::new(surfaces, solid, &surface, &parents, settings.bound.tolerance());
    if !detail.points.is_empty() {
        add_detail(&mut patches, &detail, settings);
    }
    let conflicts = conflicts(&patches, solid, settings.bound.search(), control)?;
    let seeds = agreeing(&conflicts, seeds);
    Ok(Patches {
        patches,
        are_across_folds,
        neighbours,
        seeds,
        conflicts,
        surface,
        parents,
        detail,
        mesh,
        labels,
    })
}

/// Pairs of labels with a common edge, ascending.
fn neighbours(adjacency: &Adjacency, labels: &[u32]) -> Vec<(u32, u32)> {
    let mut neighbours = Vec::new();
    for (triangle, &a) in (0_u32..).zip(labels) {
        for other in adjacency.triangle_neighbours(triangle) {
            if other != NO_NEIGHBOUR {
                let b = labels[other as usize];
                if a < b {
                    neighbours.push((a, b));
                }
            }
        }
    }
    neighbours.sort_unstable();
    neighbours.dedup();
    neighbours
}

/// Adds the detail that patches stand for to their points, as far as hulls would leave too much of
/// it uncovered. What a patch looks like to its neighbours does not change.
fn add_detail(patches: &mut [Patch], detail: &Detail, settings: &Settings) {
    let tolerance = settings.bound.max_uncovered();
    let mut reducer = HullBuilder::new().with_least_tolerance(tolerance);
    for patch in patches {
        let own = patch.triangles.iter().flat_map(|&part| &detail.points[part as usize]);
        let mut points: Vec<Vector> = own.copied().collect();
        if points.is_empty() {
            continue;
        }
        points.extend_from_slice(&patch.points);
        let points = reducer.vertices_of(&points).unwrap_or(points);
        let representatives = std::mem::take(&mut patch.representatives);
        patch.set_points(points);
        patch.representatives = representatives;
    }
}

/// For each patch those that it conflicts with: a point between the two is outside the solid by
/// more than the bound, so that no hull that fits contains both.
fn conflicts(
    patches: &[Patch],
    solid: &Solid,
    bound: f64,
    control: &Control,
) -> Result<Vec<PatchSet>, Error> {
    let count = patches.len();
    // All pairs of representatives find more conflicts, for a tenth more time, and save no hulls.
    let is_conflict = |first: &Patch, second: &Patch| {
        let mut pairs = first.representatives.iter().zip(&second.representatives);
        pairs.any(|(&p, &q)| solid.separates(p, q, bound))
    };
    let rows = parallel::map_indices(count, |index| {
        control.check()?;
        let others = index + 1..count;
        let conflicts = others.filter(|&other| is_conflict(&patches[index], &patches[other]));
        Ok(PatchSet::new(count, conflicts.map(|other| other as u32)))
    });
    let mut conflicts: Vec<PatchSet> = rows.into_iter().collect::<Result<_, Error>>()?;
    for index in 0..count {
        let row: Vec<u32> = conflicts[index].iter().filter(|&o| o as usize > index).collect();
        for other in row {
            conflicts[other as usize].insert(index as u32);
        }
    }
    Ok(conflicts)
}

/// Seeds without conflicts among their patches, then the patches of all others one by one: a hull
/// whose faces all lie on the surface can still contain empty space.
fn agreeing(conflicts: &[PatchSet], seeds: Vec<Vec<u32>>) -> Vec<Vec<u32>> {
    let agrees = |seed: &Vec<u32>| {
        seed.iter().all(|&a| seed.iter().all(|&b| !conflicts[a as usize].contains(b)))
    };
    let (agreeing, others): (Vec<_>, Vec<_>) = seeds.into_iter().partition(agrees);
    agreeing.into_iter().chain(others.into_iter().flatten().map(|patch| vec![patch])).collect()
}

/// The connected parts of groups between cuts.
fn between_cuts(mesh: &PatchMesh, adjacency: &Adjacency, groups: &[Vec<u32>]) -> Vec<Vec<u32>> {
    let PatchMesh { planes, facets, .. } = mesh;
    let mut labels = vec![u32::MAX; planes.len()];
    for (label, group) in (0..).zip(groups) {
        group.iter().for_each(|&triangle| labels[triangle as usize] = label);
    }
    let is_cut = |triangle: u32, _: usize, other: u32| {
        let (a, b) = (triangle as usize, other as usize);
        labels[a] != labels[b] || planes[a] == planes[b] && facets[a] != facets[b]
    };
    let components = components(adjacency, is_cut);
    let count = components.iter().max().map_or(0, |&last| last as usize + 1);
    let mut groups = members(&components, count);
    // What is in no group is whole already.
    groups.retain(|group| group.iter().all(|&triangle| labels[triangle as usize] != u32::MAX));
    groups
}

/// What groups are divided by.
struct Division<'a> {
    mesh: &'a PatchMesh,
    solid: &'a Solid,
    settings: &'a Settings,
    /// Maximum diagonal of a patch.
    largest: f64,
    control: &'a Control,
}

impl Division<'_> {
    /// The paper's groups, each as its triangles, or, where those are too many, the components; and
    /// whether it is those.
    fn groups(&self, adjacency: &Adjacency) -> Result<(Vec<Vec<u32>>, bool), Error> {
        let (mesh, bound) = (&self.mesh.mesh, self.settings.bound);
        let mut threshold = bound.grouping_threshold();
        let mut grouping = group(mesh, adjacency, threshold, threshold, self.control)?;
        while grouping.count > MAX_GROUPS && threshold < bound.verified() {
            threshold *= THRESHOLD_GROWTH;
            grouping = group(mesh, adjacency, threshold, threshold, self.control)?;
        }
        if grouping.count > MAX_GROUPS {
            return Ok((self.components(), true));
        }
        Ok((members(&grouping.labels, grouping.count), false))
    }

    /// The triangles of each component.
    fn components(&self) -> Vec<Vec<u32>> {
        let labels = &self.mesh.components;
        let count = labels.iter().max().map_or(0, |&last| last as usize + 1);
        members(labels, count)
    }

    /// For each component whether it is one patch, and those patches.
    fn whole_components(&self) -> Result<(Vec<bool>, Vec<Part>), Error> {
        let components = self.components();
        let patches = parallel::map_largest_first(&components, Vec::len, |triangles| {
            self.control.check()?;
            Ok(self.whole_patch(triangles))
        });
        let patches = patches.into_iter().collect::<Result<Vec<Option<Patch>>, Error>>()?;
        let is_whole = patches.iter().map(Option::is_some).collect();
        let wholes = patches.into_iter().zip(components);
        Ok((is_whole, wholes.filter_map(|(patch, triangles)| Some((patch?, triangles))).collect()))
    }

    /// The patch of a component, if its hull fits.
    fn whole_patch(&self, triangles: &[u32]) -> Option<Patch> {
        let (mesh, solid, bound) = (self.mesh, self.solid, self.settings.bound);
        let mut vertices: Vec<Vector> =
            triangles.iter().flat_map(|&triangle| mesh.corners(triangle)).collect();
        vertices.dedup();
        // Two far points rule out most components that do not fit.
        let is_separated = matches!(
            far_pair(&vertices)[..],
            [a, b] if solid.separates(a, b, bound.search())
        );
        if triangles.is_empty() || is_separated {
            return None;
        }
        let mut tester = FitTester::new(solid, bound.search());
        let coarse = GrowingHull::new(&vertices, Vector::ZERO);
        if coarse.is_solid && !tester.fits(&coarse, false) {
            return None;
        }
        let patch = mesh.patch(triangles, &mut reducer_of_whole(&coarse, self.settings));
        tester.fits(&GrowingHull::new(&patch.points, patch.outward), false).then_some(patch)
    }

    /// Halves a group along its longest principal axis until no part is larger than the largest
    /// patch, and the hull of each part, or of one that contains it, fits. Parts of the same
    /// fitting hull form a seed, others are seeds of their own.
    fn divide(&self, group: &[u32]) -> Result<Vec<Vec<Part>>, Error> {
        let (mesh, bound) = (self.mesh, self.settings.bound);
        let mut tester = FitTester::new(self.solid, bound.search());
        let mut reducer = HullBuilder::new().with_least_tolerance(bound.tolerance());
        let mut stack = vec![(group.to_vec(), false)];
        let mut seeds: Vec<Vec<Part>> = Vec::new();
        while let Some((triangles, mut is_in_seed)) = stack.pop() {
            self.control.check()?;
            let mut make = || mesh.patch(&triangles, &mut reducer);
            let mut fits =
                |patch: &Patch| tester.fits(&GrowingHull::new(&patch.points, patch.outward), false);
            if triangles.len() > 1 && is_large(mesh, &triangles, self.largest) {
                if !is_in_seed && fits(&make()) && !self.contains_space(&triangles) {
                    is_in_seed = true;
                    // Its parts are next on the stack.
                    seeds.push(Vec::new());
                }
            } else {
                let patch = make();
                // A part of a hull that fits, and holds no empty space, also fits.
                let is_fitting = triangles.len() == 1
                    || (is_in_seed || fits(&patch)) && !self.contains_space(&triangles);
                if is_fitting {
                    match seeds.last_mut() {
                        Some(seed) if is_in_seed => seed.push((patch, triangles)),
                        _ => seeds.push(vec![(patch, triangles)]),
                    }
                    continue;
                }
            }
            let (first, second) = halves(mesh, &triangles);
            stack.extend([(second, is_in_seed), (first, is_in_seed)]);
        }
        Ok(seeds)
    }

    /// Whether a hull of several facets, all of whose faces may lie on the surface, holds empty
    /// space: a point between two facets does not fit. Small patches have no room for that.
    fn contains_space(&self, triangles: &[u32]) -> bool {
        if self.mesh.planes.is_empty() {
            return false;
        }
        let units = units(self.mesh, triangles);
        let step = units.len().div_ceil(MAX_COMPARED);
        let centres: Vec<Vector> =
            units.iter().step_by(step).map(|unit| self.mesh.centre_of(unit)).collect();
        let bound = self.settings.bound.search();
        centres.iter().enumerate().any(|(index, &first)| {
            centres[..index].iter().any(|&second| self.solid.separates(first, second, bound))
        })
    }
}

/// Whether triangles extend farther than `largest`, and not because a single one or a single facet
/// does.
fn is_large(mesh: &PatchMesh, triangles: &[u32], largest: f64) -> bool {
    let facet = |&triangle: &u32| mesh.facets[triangle as usize];
    let first = triangles.first().map(facet);
    let all = extent(mesh, triangles);
    all > largest
        && triangles.iter().any(|triangle| Some(facet(triangle)) != first)
        && units(mesh, triangles).iter().all(|unit| all > MIN_ELONGATION * extent(mesh, unit))
}

/// Diagonal of the bounding box of triangles.
fn extent(mesh: &PatchMesh, triangles: &[u32]) -> f64 {
    diagonal(triangles.iter().flat_map(|&triangle| mesh.corners(triangle)))
}

/// The parts that triangles are halved by: whole facets, or the triangles of a single facet.
fn units(mesh: &PatchMesh, triangles: &[u32]) -> Vec<Vec<u32>> {
    let mut ordered: Vec<u32> = triangles.to_vec();
    sort_by_key(&mut ordered, |&triangle| (mesh.facets[triangle as usize], triangle));
    let facet = |triangle: &u32| mesh.facets[*triangle as usize];
    let units: Vec<Vec<u32>> =
        ordered.chunk_by(|a, b| facet(a) == facet(b)).map(<[u32]>::to_vec).collect();
    if units.len() > 1 { units } else { ordered.into_iter().map(|t| vec![t]).collect() }
}

/// Two halves along the longest principal axis. Neither is empty for two triangles or more.
fn halves(mesh: &PatchMesh, triangles: &[u32]) -> (Vec<u32>, Vec<u32>) {
    let units = units(mesh, triangles);
    let centres: Vec<Vector> = units.iter().map(|unit| mesh.centre_of(unit)).collect();
    let sum = centres.iter().fold(Vector::ZERO, |sum, &centre| sum + centre);
    let mean = sum * (1.0 / units.len() as f64);
    let mut covariance = [Vector::ZERO; 3];
    for &centre in &centres {
        let away = centre - mean;
        for (row, &x) in covariance.iter_mut().zip(&away.to_array()) {
            for (entry, &y) in row.as_mut().iter_mut().zip(&away.to_array()) {
                *entry += x * y;
            }
        }
    }
    let axis = principal_axis(covariance);
    let mut order: Vec<(f64, usize)> =
        (0..units.len()).map(|unit| (axis.dot(centres[unit] - mean), unit)).collect();
    sort_by_number(&mut order);
    let half = order.partition_point(|entry| entry.0 < 0.0).clamp(1, order.len().max(2) - 1);
    let part = |entries: &[(f64, usize)]| {
        let mut part: Vec<u32> =
            entries.iter().flat_map(|entry| &units[entry.1]).copied().collect();
        part.sort_unstable();
        part
    };
    (part(&order[..half]), part(&order[half..]))
}

/// About the eigenvector of the greatest eigenvalue, by power iteration.
fn principal_axis(covariance: [Vector; 3]) -> Vector {
    let mut axis = POWER_START;
    for _ in 0..POWER_STEPS {
        let next = Vector::from(covariance.map(|row| row.dot(axis)));
        let length = next.length();
        if length <= 0.0 {
            break;
        }
        axis = next * (1.0 / length);
    }
    axis
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bounded::fixture::{Fixture, cubes, l_prism, u_prism};
    use crate::geometry::vector::as_vectors;
    use crate::mesh::TriangleMesh;
    use crate::mesh::shapes::{cuboid, join, torus};
    use crate::parameters::{Parameters, Preset};
    use crate::solid::Boundary;

    const BOUND: f64 = 0.02;

    /// Conflicts of two cubes that are more than a cube apart, with a patch for each triangle.
    fn two_cubes() -> Vec<PatchSet> {
        let mesh = join(&[
            cuboid(Vector::ZERO, Vector::splat(0.2)),
            cuboid(Vector::new(0.45, 0.0, 0.0), Vector::new(0.65, 0.2, 0.2)),
        ]);
        let TriangleMesh { positions, triangles, .. } = &mesh;
        let solid = Solid::of_surface(
            as_vectors(positions),
            triangles,
            Boundary::default(),
            BOUND,
            &Control::new(),
        );
        let patch = |corners: &[u32; 3]| {
            let representatives: Vec<Vector> =
                corners.iter().map(|&vertex| positions[vertex as usize]).map(Into::into).collect();
            Patch { representatives, ..Patch::default() }
        };
        let patches: Vec<Patch> = triangles.iter().map(patch).collect();
        conflicts(&patches, &solid.unwrap(), BOUND, &Control::new()).unwrap()
    }

    #[test]
    fn patches_conflict_where_there_is_a_gap_between_them() {
        let conflicts = two_cubes();
        let half = conflicts.len() / 2;
        for (a, of_a) in conflicts.iter().enumerate() {
            for b in 0..2 * half {
                let is_conflict = of_a.contains(b as u32);
                assert_eq!(is_conflict, (a < half) != (b < half), "{a} and {b}");
            }
        }
    }

    #[test]
    fn seeds_with_a_conflict_fall_into_single_patches() {
        let conflicts = two_cubes();
        let seeds = vec![vec![0, 1, 12], vec![2, 3], vec![13]];
        let expected = [vec![2, 3], vec![13], vec![0], vec![1], vec![12]];
        assert_eq!(agreeing(&conflicts, seeds), expected);
    }

    #[test]
    fn each_convex_component_is_one_patch() {
        let fixture = Fixture::new(&cubes([0.0, 2.0, 4.0]), 0.02);
        assert_eq!(fixture.patches.count(), 3);
        assert_eq!(fixture.patches.seeds, [[0], [1], [2]]);
    }

    #[test]
    fn each_triangle_has_one_patch_and_each_patch_fits() {
        for mesh in [l_prism(), u_prism(), torus(24, 12)] {
            let fixture = Fixture::new(&mesh, 0.02);
            let Patches { patches, labels, surface, seeds, .. } = &fixture.patches;
            let mut triangles: Vec<u32> =
                patches.iter().flat_map(|patch| patch.triangles.clone()).collect();
            triangles.sort_unstable();
            assert_eq!(triangles, Vec::from_iter(0..surface.triangles.len() as u32));
            for (label, patch) in (0..).zip(patches) {
                assert!(patch.triangles.iter().all(|&triangle| labels[triangle as usize] == label));
            }
            let bound = fixture.settings.bound.search();
            let mut tester = FitTester::new(&fixture.solids.coarse, bound);
            let fits =
                |seed: &Vec<u32>| tester.fits(&fixture.piece(seed.iter().copied()).hull, false);
            assert!(seeds.iter().all(fits));
            let mut members = seeds.concat();
            members.sort_unstable();
            assert_eq!(members, Vec::from_iter(0..patches.len() as u32));
        }
    }

    #[test]
    fn patches_of_a_prism_end_at_its_cut() {
        let fixture = Fixture::new(&l_prism(), 0.02);
        let Patches { patches, .. } = &fixture.patches;
        let diagonal = fixture.prepared.normalization.diagonal;
        // No patch is on both sides of both planes at the notch, which is in the middle.
        for patch in patches {
            let is_across = |k: usize| patch.min[k] < -1e-9 && patch.max[k] > 1e-9;
            assert!(!(is_across(0) && is_across(1)), "{}", patch.max * diagonal);
        }
    }

    #[test]
    fn a_larger_patch_size_makes_fewer_patches() {
        let mesh = torus(24, 12);
        let count = |preset| {
            let parameters = Parameters::default().with_preset(preset);
            Fixture::with(&mesh, &parameters).patches.count()
        };
        assert!(2 * count(Preset::Fast) < count(Preset::Balanced));
    }

    #[test]
    fn neighbours_share_an_edge() {
        // A square of two triangles to a patch, on each side of a cube.
        let labels: Vec<u32> = (0..12).map(|triangle| triangle / 2).collect();
        let neighbours = neighbours(&Adjacency::new(&cuboid([0.0; 3], [1.0; 3])), &labels);
        // All but the three pairs of opposite sides.
        assert_eq!(neighbours.len(), 15 - 3);
        assert!(neighbours.iter().all(|&(a, b)| a < b) && neighbours.is_sorted());
    }

    #[test]
    fn triangles_are_halved_across_their_longest_axis() {
        let fixture = Fixture::new(&torus(24, 12), 0.02);
        let Fixture { surfaces, solids, settings, control, .. } = &fixture;
        let mesh = &PatchMesh::new(&surfaces.coarse, &solids.coarse, settings, control).unwrap();
        let all: Vec<u32> = (0..mesh.mesh.triangles.len() as u32)
            .filter(|&triangle| mesh.corners(triangle).iter().all(|corner| corner.x > 0.1))
            .collect();
        // This part of the ring is longest along y.
        let (first, second) = halves(mesh, &all);
        assert_eq!(first.len() + second.len(), all.len());
        let side = |half: &[u32]| mesh.centre_of(half).y.signum();
        assert!(side(&first) != side(&second));
    }

    #[test]
    fn of_two_triangles_at_one_place_each_is_a_half() {
        let positions = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        let mesh = TriangleMesh::new(positions, vec![[0, 1, 2], [0, 2, 1]]);
        let mesh = PatchMesh {
            surface: mesh.clone(),
            mesh,
            components: vec![0; 2],
            parents: vec![0, 1],
            represented: vec![vec![0], vec![1]],
            facets: vec![0, 1],
            planes: Vec::new(),
            bundles: Vec::new(),
        };
        assert_eq!(halves(&mesh, &[0, 1]), (vec![0], vec![1]));
    }

    #[test]
    fn the_principal_axis_is_that_of_the_greatest_variance() {
        let covariance = [Vector::X, Vector::Y * 9.0, Vector::Z * 4.0];
        assert!(principal_axis(covariance).distance(Vector::Y) < 1e-6);
        assert_eq!(principal_axis([Vector::ZERO; 3]), POWER_START);
    }
}
