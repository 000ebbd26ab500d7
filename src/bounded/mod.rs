//! The bounded method.
pub(crate) mod cover;
mod grid;
pub(crate) mod merge;
pub(crate) mod piece;
pub(crate) mod seed_set;
pub(crate) mod seeds;
pub(crate) mod solid;

use crate::mesh::PreparedMesh;
use crate::{Control, Error};
use piece::{Piece, Workshop};

pub(crate) fn env(name: &str, default: f64) -> f64 {
    std::env::var(name).ok().and_then(|v| v.parse().ok()).unwrap_or(default)
}

pub(crate) struct Result_ {
    pub pieces: Vec<Piece>,
    pub times: Vec<(&'static str, f64)>,
    pub counts: Vec<(&'static str, usize)>,
}

pub(crate) fn run(prepared: &PreparedMesh, bound: f64, control: &Control) -> Result<Result_, Error> {
    let mut times = Vec::new();
    let mut counts = Vec::new();
    let mut start = std::time::Instant::now();
    let mut lap = |name: &'static str, times: &mut Vec<(&'static str, f64)>| {
        times.push((name, start.elapsed().as_secs_f64()));
        start = std::time::Instant::now();
    };
    let solid = solid::Solid::new(
        &prepared.mesh.positions,
        &prepared.mesh.triangles,
        prepared.closed.iter().all(|&c| c),
        bound,
    );
    lap("field", &mut times);
    let search_bound = bound * env("SHARE", 0.97);
    let working = seeds::working_mesh(prepared);
    lap("working", &mut times);
    let mut shop = Workshop::new(&solid, search_bound);
    let seeds = seeds::seeds(prepared, &working, &mut shop, control)?;
    lap("seeds", &mut times);
    counts.push(("seeds", seeds.count()));
    let tried = shop.tried;
    let pieces = merge::merge(&seeds, &mut shop, control)?;
    lap("merge", &mut times);
    counts.push(("merged", pieces.len()));
    counts.push(("mtried", shop.tried - tried));
    let tried = shop.tried;
    let pieces = cover::cover(&seeds, pieces, &mut shop, control, &mut counts)?;
    lap("cover", &mut times);
    counts.push(("ctried", shop.tried - tried));
    counts.push(("final", pieces.len()));
    Ok(Result_ { pieces, times, counts })
}

/// Research entry.
pub fn research(positions: &[[f64; 3]], triangles: &[[u32; 3]], bound: f64) -> (Vec<crate::hull::ConvexHull>, Vec<(&'static str, f64)>, Vec<(&'static str, usize)>) {
    let control = Control::new();
    let start = std::time::Instant::now();
    let prepared = crate::mesh::repair::prepare(positions, triangles, &control).unwrap();
    let repair = start.elapsed().as_secs_f64();
    let result = run(&prepared, bound, &control).unwrap();
    let mut times = vec![("repair", repair)];
    times.extend(result.times);
    let mut builder = crate::hull::HullBuilder::new();
    let hulls = result.pieces.into_iter().filter_map(|mut piece| {
        let (h, _) = crate::hull::solid_hull(&mut builder, &piece.hull.vertices(), piece.hull.outward, 1e-6).ok()?;
        Some(crate::hull::ConvexHull { points: h.points.iter().map(|&p| prepared.normalization.restore(p)).collect(), triangles: h.triangles })
    }).collect();
    (hulls, times, result.counts)
}
