//! Seeds.
use super::env;
use super::piece::{Piece, Workshop};
use crate::field::Field;
use crate::mesh::adjacency::{Adjacency, NO_NEIGHBOUR};
use crate::mesh::simplify::simplify;
use crate::mesh::{PreparedMesh, TriangleMesh};
use crate::surface::grouping::{group, members};
use crate::vector::{Vector, add, area_normal, distance, dot, length, scale, subtract};
use crate::{Control, Error};
use std::collections::HashMap;

pub(crate) struct Working {
    pub mesh: TriangleMesh,
    pub components: Vec<u32>,
}

pub(crate) struct Seeds {
    pub pieces: Vec<Piece>,
    /// Pairs of seeds that share an edge.
    pub neighbours: Vec<(u32, u32)>,
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
    let mut pieces = Vec::new();
    let mut label = vec![u32::MAX; mesh.triangles.len()];
    let mut stack: Vec<Vec<u32>> = members(&grouping.labels, grouping.count);
    stack.reverse();
    let largest = env("LARGEST", 10.0);
    while let Some(triangles) = stack.pop() {
        let piece = piece_of(prepared, mesh, &owned, &triangles, shop);
        let size = distance(piece.min, piece.max);
        if triangles.len() > 1 && (size > largest || !shop.fits(&piece)) {
            let (a, b) = halves(mesh, &triangles);
            stack.push(b);
            stack.push(a);
            continue;
        }
        let index = pieces.len() as u32;
        for &t in &triangles {
            label[t as usize] = index;
        }
        pieces.push(Piece { seeds: vec![index], ..piece });
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
    Ok(Seeds { pieces, neighbours })
}

fn piece_of(
    prepared: &PreparedMesh,
    mesh: &TriangleMesh,
    owned: &[Vec<u32>],
    triangles: &[u32],
    shop: &mut Workshop<'_>,
) -> Piece {
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
    shop.reduced(&points, outward, area)
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
