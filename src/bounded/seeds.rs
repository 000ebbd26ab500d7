//! Seeds.
use super::env;
use super::piece::{Hull, Workshop};
use super::seed_set::SeedSet;
use crate::hull::{HullBuilder, Shape};
use crate::field::Field;
use crate::mesh::adjacency::{Adjacency, NO_NEIGHBOUR};
use crate::mesh::simplify::simplify;
use crate::mesh::{PreparedMesh, TriangleMesh};
use crate::surface::grouping::{group, members};
use crate::vector::{Vector, add, area_normal, distance, dot, length, maximum, minimum, scale, subtract};
use crate::{Control, Error};
use std::collections::HashMap;

pub(crate) struct Working {
    pub mesh: TriangleMesh,
    pub components: Vec<u32>,
}


pub(crate) fn working_mesh(prepared: &PreparedMesh) -> Working {
    let target = env("TARGET", 1600.0) as usize;
    let simplified = simplify(&prepared.mesh, &prepared.components, target);
    let mut mesh = simplified.mesh;
    let mut components = simplified.components;
    refine(&mut mesh, &mut components, env("EDGE", 0.08), env("MOST", 4000.0) as usize);
    Working { mesh, components }
}

/// Halves the longest edges.
fn refine(mesh: &mut TriangleMesh, components: &mut Vec<u32>, longest: f64, most: usize) {
    loop {
        // All edges longer than the limit, marked; split each triangle at its longest marked edge.
        let mut middles: HashMap<(u32, u32), u32> = HashMap::new();
        let mut next = Vec::with_capacity(mesh.triangles.len());
        let mut next_components = Vec::with_capacity(mesh.triangles.len());
        let mut split = false;
        let count = mesh.triangles.len();
        // longest edges of triangles that are too long
        let key = |a: u32, b: u32| if a < b { (a, b) } else { (b, a) };
        if count < most {
            for t in 0..count {
                let t = mesh.triangles[t];
                let (k, l) = longest_edge(mesh, t);
                if l > longest {
                    let e = key(t[k], t[(k + 1) % 3]);
                    if !middles.contains_key(&e) {
                        let m = scale(
                            add(mesh.positions[e.0 as usize], mesh.positions[e.1 as usize]),
                            0.5,
                        );
                        middles.insert(e, mesh.positions.len() as u32);
                        mesh.positions.push(m);
                    }
                }
            }
        }
        for t in 0..count {
            let tri = mesh.triangles[t];
            // Split at marked edges, longest first, recursively.
            let mut stack = vec![tri];
            while let Some(tri) = stack.pop() {
                let mut best: Option<(f64, usize, u32)> = None;
                for k in 0..3 {
                    if let Some(&m) = middles.get(&key(tri[k], tri[(k + 1) % 3])) {
                        let l = distance(
                            mesh.positions[tri[k] as usize],
                            mesh.positions[tri[(k + 1) % 3] as usize],
                        );
                        if best.is_none_or(|b| l > b.0) {
                            best = Some((l, k, m));
                        }
                    }
                }
                match best {
                    Some((_, k, m)) => {
                        split = true;
                        let (a, b, c) = (tri[k], tri[(k + 1) % 3], tri[(k + 2) % 3]);
                        stack.push([a, m, c]);
                        stack.push([m, b, c]);
                    }
                    None => {
                        next.push(tri);
                        next_components.push(components[t]);
                    }
                }
            }
        }
        mesh.triangles = next;
        *components = next_components;
        if !split {
            return;
        }
    }
}

fn longest_edge(mesh: &TriangleMesh, t: [u32; 3]) -> (usize, f64) {
    let p = t.map(|v| mesh.positions[v as usize]);
    let l = [distance(p[0], p[1]), distance(p[1], p[2]), distance(p[2], p[0])];
    let k = if l[0] >= l[1] && l[0] >= l[2] { 0 } else if l[1] >= l[2] { 1 } else { 2 };
    (k, l[k])
}

/// A patch of the surface that is not divided any further.
#[derive(Debug, Clone)]
pub(crate) struct Seed {
    /// Vertices of its hull, but for those that stand out less than the reduction; all its points
    /// where it is flat.
    pub points: Vec<Vector>,
    /// A few of `points`, spread out.
    pub representatives: Vec<Vector>,
    pub outward: Vector,
    pub area: f64,
    pub min: Vector,
    pub max: Vector,
}

/// Seeds and who is next to whom.
pub(crate) struct Seeds {
    pub seeds: Vec<Seed>,
    /// Pairs of seeds that share an edge.
    pub neighbours: Vec<(u32, u32)>,
    /// For each seed those that no hull can hold together with it.
    pub conflicts: Vec<SeedSet>,
}

impl Seeds {
    pub fn count(&self) -> usize {
        self.seeds.len()
    }
}

pub(crate) fn seeds(
    prepared: &PreparedMesh,
    working: &Working,
    shop: &mut Workshop<'_>,
    control: &Control,
) -> Result<Seeds, Error> {
    let mesh = &working.mesh;
    let adjacency = Adjacency::new(mesh);
    let p = env("P", 0.002);
    let grouping = group(mesh, &adjacency, p, p, control)?;
    // Each source vertex goes to the nearest working triangle.
    let field = Field::new(&mesh.positions, &mesh.triangles);
    let mut owned: Vec<Vec<u32>> = vec![Vec::new(); mesh.triangles.len()];
    let mut guess = u32::MAX;
    for (v, &p) in prepared.mesh.positions.iter().enumerate() {
        if let Some(c) = field.distance_near(p, f64::INFINITY, guess) {
            guess = c.triangle;
            owned[c.triangle as usize].push(v as u32);
        }
    }
    let mut seeds: Vec<Seed> = Vec::new();
    let mut label = vec![u32::MAX; mesh.triangles.len()];
    let mut stack: Vec<Vec<u32>> = members(&grouping.labels, grouping.count);
    stack.reverse();
    let mut reducer = HullBuilder::new().with_least_tolerance(env("REDUCE", 0.0007));
    let total: f64 = mesh
        .triangles
        .iter()
        .map(|t| {
            let [a, b, c] = t.map(|v| mesh.positions[v as usize]);
            0.5 * length(area_normal(a, b, c))
        })
        .sum();
    let largest = env("LARGEST", 0.0).max(env("SIZE", 0.0) * total.sqrt());
    let largest = if largest > 0.0 { largest } else { 10.0 };
    while let Some(triangles) = stack.pop() {
        control.check()?;
        let seed = seed_of(prepared, mesh, &owned, &triangles, &mut reducer);
        let size = distance(seed.min, seed.max);
        let hull = Hull::of(&seed.points, seed.outward);
        if triangles.len() > 1 && (size > largest || !shop.fits(&hull, false)) {
            let (a, b) = halves(mesh, &triangles);
            stack.push(b);
            stack.push(a);
            continue;
        }
        let index = seeds.len() as u32;
        for &t in &triangles {
            label[t as usize] = index;
        }
        seeds.push(seed);
    }
    let mut neighbours = Vec::new();
    for t in 0..mesh.triangles.len() as u32 {
        for n in adjacency.triangle_neighbours(t) {
            if n != NO_NEIGHBOUR {
                let (a, b) = (label[t as usize], label[n as usize]);
                if a < b {
                    neighbours.push((a, b));
                }
            }
        }
    }
    neighbours.sort_unstable();
    neighbours.dedup();
    let conflicts = conflicts(&seeds, shop);
    Ok(Seeds { seeds, neighbours, conflicts })
}

/// For each seed those that it can't be together with: some point between them is outside.
fn conflicts(seeds: &[Seed], shop: &Workshop<'_>) -> Vec<SeedSet> {
    let mut conflicts = vec![SeedSet::none(seeds.len()); seeds.len()];
    for (i, a) in seeds.iter().enumerate() {
        for (j, b) in seeds.iter().enumerate().skip(i + 1) {
            let separated = a.representatives.iter().any(|&p| {
                b.representatives.iter().any(|&q| shop.solid.separates(p, q, shop.bound))
            });
            if separated {
                conflicts[i].insert(j as u32);
                conflicts[j].insert(i as u32);
            }
        }
    }
    conflicts
}

/// A few points, spread out: each the farthest from those before.
fn representatives(points: &[Vector], count: usize) -> Vec<Vector> {
    let Some(&first) = points.first() else { return Vec::new() };
    let farthest = |from: &[Vector]| {
        points
            .iter()
            .map(|&p| (from.iter().map(|&q| distance(p, q)).fold(f64::INFINITY, f64::min), p))
            .max_by(|a, b| a.0.total_cmp(&b.0))
            .map(|(_, p)| p)
    };
    let mut chosen: Vec<Vector> = farthest(&[first]).into_iter().collect();
    while chosen.len() < count.min(points.len()) {
        let Some(next) = farthest(&chosen) else { break };
        chosen.push(next);
    }
    chosen
}

fn seed_of(
    prepared: &PreparedMesh,
    mesh: &TriangleMesh,
    owned: &[Vec<u32>],
    triangles: &[u32],
    reducer: &mut HullBuilder,
) -> Seed {
    let mut vertices: Vec<u32> =
        triangles.iter().flat_map(|&t| mesh.triangles[t as usize]).collect();
    vertices.sort_unstable();
    vertices.dedup();
    let mut points: Vec<Vector> = vertices.iter().map(|&v| mesh.positions[v as usize]).collect();
    let mut outward = [0.0; 3];
    let mut area = 0.0;
    for &t in triangles {
        points.extend(owned[t as usize].iter().map(|&v| prepared.mesh.positions[v as usize]));
        let [a, b, c] = mesh.triangles[t as usize].map(|v| mesh.positions[v as usize]);
        let n = area_normal(a, b, c);
        outward = add(outward, n);
        area += 0.5 * length(n);
    }
    if reducer.build(&points) == Shape::Solid {
        points = reducer.extract().0;
    }
    let (mut min, mut max) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for &p in &points {
        min = minimum(min, p);
        max = maximum(max, p);
    }
    let representatives = representatives(&points, env("REPS", 4.0) as usize);
    Seed { points, representatives, outward, area, min, max }
}

/// Two halves along the longest principal direction.
fn halves(mesh: &TriangleMesh, triangles: &[u32]) -> (Vec<u32>, Vec<u32>) {
    let centre = |t: u32| {
        let [a, b, c] = mesh.triangles[t as usize].map(|v| mesh.positions[v as usize]);
        scale(add(add(a, b), c), 1.0 / 3.0)
    };
    let n = triangles.len() as f64;
    let mean = scale(triangles.iter().fold([0.0; 3], |s, &t| add(s, centre(t))), 1.0 / n);
    let mut m = [[0.0; 3]; 3];
    for &t in triangles {
        let d = subtract(centre(t), mean);
        for i in 0..3 {
            for j in 0..3 {
                m[i][j] += d[i] * d[j];
            }
        }
    }
    let mut axis: Vector = [1.0, 0.7, 0.4];
    for _ in 0..30 {
        let next = [0, 1, 2].map(|i| dot(m[i], axis));
        let l = length(next);
        if l <= 0.0 {
            break;
        }
        axis = scale(next, 1.0 / l);
    }
    let mut order: Vec<(f64, u32)> =
        triangles.iter().map(|&t| (dot(axis, subtract(centre(t), mean)), t)).collect();
    order.sort_by(|a, b| a.0.total_cmp(&b.0));
    let half = order.iter().position(|o| o.0 >= 0.0).unwrap_or(order.len() / 2).clamp(1, order.len() - 1);
    let mut a: Vec<u32> = order[..half].iter().map(|o| o.1).collect();
    let mut b: Vec<u32> = order[half..].iter().map(|o| o.1).collect();
    a.sort_unstable();
    b.sort_unstable();
    (a, b)
}
