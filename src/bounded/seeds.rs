//! Seeds: the paper's groups of a simplified or refined mesh, halved until the hull of each, or of a part
//! that it belongs to, fits.
//!
//! A seed takes all of the source's surface that is nearest to its triangles, so that hulls of
//! seeds cover the source and not only what simplification left of it.

use std::sync::Arc;

use super::Tuning;
use super::cluster::Clustered;
use super::piece::{Hull, Workshop};
use super::refine::refine;
use super::seed_set::SeedSet;
use super::solid::Solid;
use crate::bvh::Bvh;
use crate::bvh::closest_triangles::closest_triangles;
use crate::control::Control;
use crate::error::Error;
use crate::geometry::vector::{
    Vector, add, area_normal, bounds, diagonal, distance, dot, length, length_squared, scale,
    subtract,
};
use crate::hull::HullBuilder;
use crate::mesh::adjacency::{Adjacency, NO_NEIGHBOUR};
use crate::mesh::simplify::simplify;
use crate::mesh::{PreparedMesh, TriangleMesh};
use crate::surface::grouping::{group, members};

/// More groups than this are grown anew under a larger threshold: each facet of a fine cylinder
/// would be one of its own.
const MOST_GROUPS: usize = 600;

/// Seeds between two looks at the control.
const SEEDS_PER_CHECK: usize = 8;

/// A patch of the surface that is not divided any further.
#[derive(Debug, Clone, Default)]
pub(crate) struct Seed {
    /// Vertices of its hull, but for those that stand out less than the reduction; all its points
    /// where it is flat.
    pub points: Vec<Vector>,
    /// A few of `points`, spread out.
    pub representatives: Vec<Vector>,
    /// Sum of its triangles' normals, each twice as long as the triangle's area.
    pub outward: Vector,
    pub area: f64,
    pub min: Vector,
    pub max: Vector,
    /// The triangles of [`Seeds::surface`] that it stands for.
    pub triangles: Vec<u32>,
    /// Their vertices, where the mesh was clustered: there are many, and to look for them again takes long.
    pub own: Vec<Vector>,
    pub component: u32,
}

impl Seed {
    fn set_points(&mut self, points: Vec<Vector>) {
        (self.min, self.max) = bounds(points.iter().copied());
        self.representatives = far_pair(&points);
        self.points = points;
    }
}

/// Seeds and who is next to whom.
pub(crate) struct Seeds {
    pub seeds: Vec<Seed>,
    /// Pairs of seeds that share an edge.
    pub neighbours: Vec<(u32, u32)>,
    /// Seeds that merging takes together from the start: parts of the same part of a group whose
    /// hull fits, and no two of which conflict. Each seed is in one.
    pub blocks: Vec<Vec<u32>>,
    /// For each seed those that no hull can hold together with it, by the bound of the search.
    pub conflicts: Vec<SeedSet>,
    /// The source, its long triangles halved.
    pub surface: Arc<TriangleMesh>,
    /// For each triangle of `surface` the prepared mesh's triangle that it is a part of.
    pub parents: Arc<Vec<u32>>,
    /// The mesh that was grouped, and for each of its triangles its seed.
    pub grouped: TriangleMesh,
    pub labels: Vec<u32>,
}

impl Seeds {
    pub fn count(&self) -> usize {
        self.seeds.len()
    }

    /// The set of all seeds.
    pub fn all(&self) -> SeedSet {
        SeedSet::of(self.count(), 0..self.count() as u32)
    }
}

/// The mesh that is grouped, with the surface that its triangles stand for.
pub(crate) struct Working {
    mesh: TriangleMesh,
    components: Vec<u32>,
    surface: TriangleMesh,
    parents: Vec<u32>,
    /// For each triangle of `mesh` those of `surface`.
    owned: Vec<Vec<u32>>,
}

/// Simplifies a dense mesh and refines a coarse one. The surface of one that was clustered stays as it is:
/// what its triangles stand in for has been refined.
pub(crate) fn working_mesh(
    prepared: &PreparedMesh,
    clustered: Option<&Clustered>,
    tuning: &Tuning,
    control: &Control,
) -> Result<Working, Error> {
    let (source, source_components) = match clustered {
        Some(clustered) => (&clustered.mesh, &clustered.components),
        None => (&prepared.mesh, &prepared.components),
    };
    let mut surface = source.clone();
    let parents = match clustered {
        Some(_) => (0..surface.triangles.len() as u32).collect(),
        None => refine(&mut surface, tuning.longest_edge),
    };
    let components_of = |parents: &[u32], components: &[u32]| {
        parents.iter().map(|&parent| components[parent as usize]).collect::<Vec<u32>>()
    };
    control.check()?;
    if source.triangles.len() <= tuning.triangles {
        let mut mesh = surface.clone();
        let origins = match clustered {
            Some(_) => refine(&mut mesh, tuning.longest_edge),
            None => (0..mesh.triangles.len() as u32).collect(),
        };
        // The first part of a triangle stands for all of it.
        let mut last = u32::MAX;
        let owned = origins.iter().map(|&origin| {
            let is_first = std::mem::replace(&mut last, origin) != origin;
            if is_first { vec![origin] } else { Vec::new() }
        });
        let owned = owned.collect();
        let parents_of_parts: Vec<u32> =
            origins.iter().map(|&origin| parents[origin as usize]).collect();
        let components = components_of(&parents_of_parts, source_components);
        return Ok(Working { mesh, components, surface, parents, owned });
    }
    let simplified = simplify(source, source_components, tuning.triangles)?;
    control.check()?;
    let mut mesh = simplified.mesh;
    let origins = refine(&mut mesh, tuning.longest_edge);
    let components = components_of(&origins, &simplified.components);
    let bvh = Bvh::new(&mesh.positions, &mesh.triangles);
    let mut owned: Vec<Vec<u32>> = vec![Vec::new(); mesh.triangles.len()];
    for (triangle, nearest) in
        closest_triangles(&surface.positions, &surface.triangles, &bvh, control)?
            .into_iter()
            .enumerate()
    {
        if let Some(list) = owned.get_mut(nearest as usize) {
            list.push(triangle as u32);
        }
    }
    Ok(Working { mesh, components, surface, parents, owned })
}

/// Groups, halves, and finds out who conflicts with whom.
pub(crate) fn seeds(
    working: Working,
    solid: &Solid,
    tuning: &Tuning,
    control: &Control,
) -> Result<Seeds, Error> {
    let mesh = &working.mesh;
    let adjacency = Adjacency::new(mesh);
    let mut threshold = tuning.grouping_threshold;
    let mut grouping = group(mesh, &adjacency, threshold, threshold, control)?;
    while grouping.count > MOST_GROUPS && threshold < tuning.bound {
        threshold *= 2.0;
        grouping = group(mesh, &adjacency, threshold, threshold, control)?;
    }
    let area: f64 =
        mesh.triangles.iter().map(|&triangle| 0.5 * length(normal(mesh, triangle))).sum();
    let largest = tuning.seed_size * area.sqrt();
    let mut groups = members(&grouping.labels, grouping.count);
    let Whole { is_whole, mut seeds, mut labels } =
        whole_components(&working, solid, tuning, control)?;
    // Of clustered meshes a group may reach across components.
    for group in &mut groups {
        group.retain(|&triangle| !is_whole[working.components[triangle as usize] as usize]);
    }
    groups.retain(|group| !group.is_empty());
    let parts = crate::parallel::map_largest_first(&groups, Vec::len, |group| {
        divide(&working, group, solid, largest, tuning, control)
    });
    let mut blocks: Vec<Vec<u32>> = (0..seeds.len() as u32).map(|seed| vec![seed]).collect();
    for part in parts {
        for block in part? {
            let first = seeds.len() as u32;
            for (seed, triangles) in block {
                for triangle in triangles {
                    labels[triangle as usize] = seeds.len() as u32;
                }
                seeds.push(seed);
            }
            blocks.push((first..seeds.len() as u32).collect());
        }
    }
    let mut neighbours = Vec::new();
    for triangle in 0..mesh.triangles.len() as u32 {
        for other in adjacency.triangle_neighbours(triangle) {
            if other != NO_NEIGHBOUR {
                let (a, b) = (labels[triangle as usize], labels[other as usize]);
                if a < b {
                    neighbours.push((a, b));
                }
            }
        }
    }
    neighbours.sort_unstable();
    neighbours.dedup();
    let Working { mesh, surface, parents, .. } = working;
    let (mut surface, mut parents) = (Arc::new(surface), Arc::new(parents));
    if let Some(clustered) = solid.clustered.as_deref() {
        (surface, parents) = (clustered.surface.clone(), clustered.parents.clone());
        take_clusters(&mut seeds, clustered, tuning, control)?;
    }
    let conflicts = conflicts(&seeds, solid, tuning.search_bound, control)?;
    // A hull whose faces all lie on the surface can still swallow what is empty.
    let agrees = |block: &Vec<u32>| {
        let all = SeedSet::of(seeds.len(), block.iter().copied());
        !block.iter().any(|&seed| conflicts[seed as usize].intersects(&all))
    };
    let (mut blocks, torn): (Vec<_>, Vec<_>) = blocks.into_iter().partition(agrees);
    blocks.extend(torn.into_iter().flatten().map(|seed| vec![seed]));
    Ok(Seeds { seeds, neighbours, blocks, conflicts, surface, parents, grouped: mesh, labels })
}

/// Seeds take the surface that their triangles stand for.
fn take_clusters(
    seeds: &mut [Seed],
    clustered: &Clustered,
    tuning: &Tuning,
    control: &Control,
) -> Result<(), Error> {
    let mut owners = vec![u32::MAX; clustered.mesh.triangles.len()];
    for (index, seed) in (0..).zip(&mut *seeds) {
        seed.triangles.drain(..).for_each(|triangle| owners[triangle as usize] = index);
    }
    for (triangle, &stand_in) in (0..).zip(&clustered.stand_in) {
        if let Some(&owner) = owners.get(stand_in as usize)
            && let Some(seed) = seeds.get_mut(owner as usize)
        {
            seed.triangles.push(triangle);
        }
    }
    control.check()?;
    let points = crate::parallel::map(seeds, |seed: &Seed| {
        control.check()?;
        let own = clustered.surface.positions_of(seed.triangles.iter().copied());
        let mut reducer = HullBuilder::new().with_least_tolerance(tuning.reduction);
        let points = reducer.vertices_of(&own).unwrap_or_else(|| own.clone());
        Ok((own, points))
    });
    for (seed, result) in seeds.iter_mut().zip(points) {
        let (own, points) = result?;
        if !points.is_empty() {
            seed.set_points(points);
        }
        seed.own = own;
    }
    Ok(())
}

/// Components that are one seed each.
struct Whole {
    /// For each component.
    is_whole: Vec<bool>,
    seeds: Vec<Seed>,
    /// For each triangle its seed, if it has one already.
    labels: Vec<u32>,
}

/// Points of a whole component that stand out of its hull less than this share of its thickness are left out.
const REDUCTION_OF_THICKNESS: f64 = 0.02;

/// Components whose hull fits are one seed each: convex ones above all.
fn whole_components(
    working: &Working,
    solid: &Solid,
    tuning: &Tuning,
    control: &Control,
) -> Result<Whole, Error> {
    let Working { mesh, components, .. } = working;
    let count = components.iter().max().map_or(0, |&last| last as usize + 1);
    let parts = members(components, count);
    let mut shop = Workshop::new(solid, tuning.search_bound);
    let mut is_whole = vec![false; count];
    let mut seeds = Vec::new();
    let mut labels = vec![0_u32; mesh.triangles.len()];
    for (component, triangles) in parts.iter().enumerate() {
        control.check()?;
        // A few far points tell most of those that are not.
        let mut vertices: Vec<Vector> = triangles
            .iter()
            .flat_map(|&triangle| mesh.triangles[triangle as usize])
            .map(|vertex| mesh.positions[vertex as usize])
            .collect();
        vertices.dedup();
        let pair = far_pair(&vertices);
        if triangles.is_empty()
            || pair.windows(2).any(|pair| solid.separates(pair[0], pair[1], tuning.search_bound))
        {
            continue;
        }
        let coarse = Hull::of(&vertices, [0.0; 3]);
        if coarse.is_solid && !shop.fits(&coarse, false) {
            continue;
        }
        // What may be left out of a body is little of its thickness too.
        let thickness = coarse.volume / length_squared(subtract(coarse.max, coarse.min));
        let reduction = match coarse.is_solid {
            true => tuning.reduction.min(REDUCTION_OF_THICKNESS * thickness),
            false => tuning.reduction,
        };
        let mut reducer = HullBuilder::new().with_least_tolerance(reduction);
        let seed = seed_of(working, triangles, &mut reducer);
        if !shop.fits(&Hull::of(&seed.points, seed.outward), false) {
            continue;
        }
        is_whole[component] = true;
        for &triangle in triangles {
            labels[triangle as usize] = seeds.len() as u32;
        }
        seeds.push(seed);
    }
    Ok(Whole { is_whole, seeds, labels })
}

fn normal(mesh: &TriangleMesh, triangle: [u32; 3]) -> Vector {
    let [a, b, c] = triangle.map(|vertex| mesh.positions[vertex as usize]);
    area_normal(a, b, c)
}

/// Parts of a group that are not halved any further, with their triangles.
type Block = Vec<(Seed, Vec<u32>)>;

/// Halves a group until no part is larger than `largest`, and the hull of each, or of what it was halved
/// from, fits. Parts of the same fitting hull come as one block, all others alone.
fn divide(
    working: &Working,
    group: &[u32],
    solid: &Solid,
    largest: f64,
    tuning: &Tuning,
    control: &Control,
) -> Result<Vec<Block>, Error> {
    let mesh = &working.mesh;
    let mut shop = Workshop::new(solid, tuning.search_bound);
    let mut reducer = HullBuilder::new().with_least_tolerance(tuning.reduction);
    let mut stack = vec![(group.to_vec(), false)];
    let mut blocks: Vec<Block> = Vec::new();
    let mut seeds = 0_usize;
    while let Some((triangles, mut is_in_block)) = stack.pop() {
        if seeds.is_multiple_of(SEEDS_PER_CHECK) {
            control.check()?;
        }
        let mut make = || seed_of(working, &triangles, &mut reducer);
        let mut fits = |seed: &Seed| shop.fits(&Hull::of(&seed.points, seed.outward), false);
        if triangles.len() > 1 && is_large(mesh, &triangles, largest) {
            if !is_in_block && fits(&make()) {
                is_in_block = true;
                // Its parts are next on the stack.
                blocks.push(Vec::new());
            }
        } else {
            let seed = make();
            // What a hull that fits holds, fits as well but for hulls that swallow what is empty, and
            // those are found when the result is verified.
            if is_in_block || triangles.len() == 1 || fits(&seed) {
                seeds += 1;
                match blocks.last_mut() {
                    Some(block) if is_in_block => block.push((seed, triangles)),
                    _ => blocks.push(vec![(seed, triangles)]),
                }
                continue;
            }
        }
        let (first, second) = halves(mesh, &triangles);
        stack.extend([(second, is_in_block), (first, is_in_block)]);
    }
    Ok(blocks)
}

/// Whether triangles reach farther than `largest`, and not because one of them does.
fn is_large(mesh: &TriangleMesh, triangles: &[u32], largest: f64) -> bool {
    let extent_of_all = extent(mesh, triangles);
    extent_of_all > largest
        && triangles.iter().all(|&triangle| extent_of_all > LONGER * extent(mesh, &[triangle]))
}

/// Triangles that reach this much farther than the longest of them can be divided by size.
const LONGER: f64 = 1.5;

/// Diagonal of the bounding box of triangles.
fn extent(mesh: &TriangleMesh, triangles: &[u32]) -> f64 {
    let vertices = triangles.iter().flat_map(|&triangle| mesh.triangles[triangle as usize]);
    diagonal(vertices.map(|vertex| mesh.positions[vertex as usize]))
}

fn seed_of(working: &Working, triangles: &[u32], reducer: &mut HullBuilder) -> Seed {
    let Working { mesh, components, surface, owned, .. } = working;
    let mut vertices: Vec<u32> =
        triangles.iter().flat_map(|&triangle| mesh.triangles[triangle as usize]).collect();
    vertices.sort_unstable();
    vertices.dedup();
    let mut points: Vec<Vector> = vertices.iter().map(|&v| mesh.positions[v as usize]).collect();
    let own: Vec<u32> =
        triangles.iter().flat_map(|&triangle| &owned[triangle as usize]).copied().collect();
    vertices.clear();
    vertices.extend(own.iter().flat_map(|&triangle| surface.triangles[triangle as usize]));
    vertices.sort_unstable();
    vertices.dedup();
    points.extend(vertices.iter().map(|&vertex| surface.positions[vertex as usize]));
    let mut outward = [0.0; 3];
    let mut area = 0.0;
    for &triangle in triangles {
        let normal = normal(mesh, mesh.triangles[triangle as usize]);
        outward = add(outward, normal);
        area += 0.5 * length(normal);
    }
    points = reducer.vertices_of(&points).unwrap_or(points);
    let component = triangles.first().map_or(0, |&triangle| components[triangle as usize]);
    let mut seed = Seed { outward, area, triangles: own, component, ..Seed::default() };
    seed.set_points(points);
    seed
}

/// Two points that are far apart.
fn far_pair(points: &[Vector]) -> Vec<Vector> {
    let farthest = |from: Vector| {
        points.iter().copied().max_by(|&a, &b| distance(a, from).total_cmp(&distance(b, from)))
    };
    let first = points.first().and_then(|&point| farthest(point));
    let second = first.and_then(farthest);
    first.into_iter().chain(second).collect()
}

/// For each seed those that it can't be together with: some point between them is outside.
fn conflicts(
    seeds: &[Seed],
    solid: &Solid,
    bound: f64,
    control: &Control,
) -> Result<Vec<SeedSet>, Error> {
    let indices: Vec<usize> = (0..seeds.len()).collect();
    let rows = crate::parallel::map(&indices, |&index| {
        control.check()?;
        let mut row = SeedSet::none(seeds.len());
        let first = &seeds[index];
        for (other, second) in seeds.iter().enumerate().skip(index + 1) {
            let separated = first
                .representatives
                .iter()
                .any(|&p| second.representatives.iter().any(|&q| solid.separates(p, q, bound)));
            if separated {
                row.insert(other as u32);
            }
        }
        Ok(row)
    });
    let mut conflicts: Vec<SeedSet> = rows.into_iter().collect::<Result<_, Error>>()?;
    for index in 0..seeds.len() {
        let row: Vec<u32> = conflicts[index].iter().filter(|&o| o as usize > index).collect();
        for other in row {
            conflicts[other as usize].insert(index as u32);
        }
    }
    Ok(conflicts)
}

/// Steps of the power iteration for the longest principal direction: it need not be exact.
const POWER_STEPS: usize = 30;

/// Two halves along the longest principal direction. Neither is empty for two triangles or more.
fn halves(mesh: &TriangleMesh, triangles: &[u32]) -> (Vec<u32>, Vec<u32>) {
    let centre = |triangle: u32| {
        let corners =
            mesh.triangles[triangle as usize].map(|vertex| mesh.positions[vertex as usize]);
        scale(corners.into_iter().fold([0.0; 3], add), 1.0 / 3.0)
    };
    let sum = triangles.iter().fold([0.0; 3], |sum, &triangle| add(sum, centre(triangle)));
    let mean = scale(sum, 1.0 / triangles.len() as f64);
    let mut covariance = [[0.0; 3]; 3];
    for &triangle in triangles {
        let away = subtract(centre(triangle), mean);
        for (row, &x) in covariance.iter_mut().zip(&away) {
            for (entry, &y) in row.iter_mut().zip(&away) {
                *entry += x * y;
            }
        }
    }
    let mut axis: Vector = [1.0, 0.7, 0.4];
    for _ in 0..POWER_STEPS {
        let next = covariance.map(|row| dot(row, axis));
        let length = length(next);
        if length <= 0.0 {
            break;
        }
        axis = scale(next, 1.0 / length);
    }
    let mut order: Vec<(f64, u32)> =
        triangles.iter().map(|&t| (dot(axis, subtract(centre(t), mean)), t)).collect();
    order.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let half = order.partition_point(|entry| entry.0 < 0.0).clamp(1, order.len().max(2) - 1);
    let part = |entries: &[(f64, u32)]| {
        let mut part: Vec<u32> = entries.iter().map(|entry| entry.1).collect();
        part.sort_unstable();
        part
    };
    (part(&order[..half]), part(&order[half..]))
}
