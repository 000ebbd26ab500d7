//! Dissolve.
use super::env;
use super::piece::{Piece, Workshop};
use super::seeds::Seeds;
use crate::vector::{Vector, area_normal, dot, length, scale, add, distance};
use crate::{Control, Error};

pub(crate) struct Rng(u64);
impl Rng {
    pub fn next(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }
}

fn planes(piece: &Piece) -> Vec<(Vector, f64)> {
    piece
        .triangles
        .iter()
        .filter_map(|t| {
            let [a, b, c] = t.map(|i| piece.points[i as usize]);
            let n = area_normal(a, b, c);
            let l = length(n);
            (l > 0.0).then(|| {
                let n = scale(n, 1.0 / l);
                (n, dot(n, a))
            })
        })
        .collect()
}

fn out(planes: &[(Vector, f64)], p: Vector) -> f64 {
    planes.iter().map(|(n, h)| dot(*n, p) - h).fold(f64::NEG_INFINITY, f64::max)
}

fn covers(piece: &Piece, planes: &[(Vector, f64)], seed: &Piece, tol: f64) -> bool {
    if planes.is_empty() {
        return false;
    }
    (0..3).all(|k| seed.min[k] >= piece.min[k] - tol && seed.max[k] <= piece.max[k] + tol)
        && seed.points.iter().all(|&p| out(planes, p) <= tol)
}

/// Grows a piece over all seeds it can take. Returns the piece with all seeds it covers.
fn grow(
    seeds: &Seeds,
    start: Piece,
    shop: &mut Workshop<'_>,
    rng: &mut Rng,
    noise: f64,
    tol: f64,
) -> Piece {
    let n = seeds.pieces.len();
    let mut taken = vec![false; n];
    let mut refused = vec![false; n];
    let mut piece = start;
    let factor: Vec<f64> = (0..n).map(|_| 1.0 + noise * rng.next()).collect();
    for &s in &piece.seeds {
        taken[s as usize] = true;
    }
    let centres: Vec<Vector> = seeds.pieces.iter().map(|p| scale(add(p.min, p.max), 0.5)).collect();
    loop {
        let planes = planes(&piece);
        for s in 0..n {
            if !taken[s] && covers(&piece, &planes, &seeds.pieces[s], tol) {
                taken[s] = true;
                refused[s] = false;
                piece.seeds.push(s as u32);
            }
        }
        let pc = scale(add(piece.min, piece.max), 0.5);
        let mut order: Vec<(f64, usize)> = (0..n)
            .filter(|&s| !taken[s] && !refused[s])
            .map(|s| {
                let d = if planes.is_empty() {
                    distance(pc, centres[s])
                } else {
                    let q = &seeds.pieces[s];
                    let step = (q.points.len() / 8).max(1);
                    q.points.iter().step_by(step).map(|&p| out(&planes, p)).fold(0.0, f64::max)
                };
                ((d + 1e-4) * factor[s], s)
            })
            .collect();
        order.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut grown = false;
        for (_, s) in order {
            let joint = shop.joint(&piece, &seeds.pieces[s]);
            if shop.fits(&joint) {
                piece = joint;
                taken[s] = true;
                grown = true;
                break;
            }
            refused[s] = true;
        }
        if !grown {
            return piece;
        }
    }
}

fn greedy(sets: &[Vec<u32>], weight: &[f64], chosen: &mut Vec<usize>, n: usize) -> bool {
    let mut count = vec![0u32; n];
    for &c in chosen.iter() {
        for &s in &sets[c] {
            count[s as usize] += 1;
        }
    }
    loop {
        if count.iter().all(|&c| c > 0) {
            break;
        }
        let mut best = (0.0, usize::MAX);
        for (i, set) in sets.iter().enumerate() {
            let gain: f64 = set.iter().filter(|&&s| count[s as usize] == 0).map(|&s| weight[s as usize]).sum();
            if gain > best.0 {
                best = (gain, i);
            }
        }
        if best.1 == usize::MAX {
            return false;
        }
        chosen.push(best.1);
        for &s in &sets[best.1] {
            count[s as usize] += 1;
        }
    }
    // drop redundant
    let mut k = 0;
    while k < chosen.len() {
        let c = chosen[k];
        if sets[c].iter().all(|&s| count[s as usize] > 1) {
            for &s in &sets[c] {
                count[s as usize] -= 1;
            }
            chosen.remove(k);
        } else {
            k += 1;
        }
    }
    true
}

pub(crate) fn dissolve(
    seeds: &Seeds,
    pieces: Vec<Piece>,
    shop: &mut Workshop<'_>,
    control: &Control,
) -> Result<Vec<Piece>, Error> {
    let rounds = env("GROW", 0.0) as usize;
    let perseed = env("SEEDGROW", 0.0) as usize;
    if rounds + perseed == 0 || pieces.len() < 2 {
        return Ok(pieces);
    }
    let tol = env("TOL", 0.0005);
    let n = seeds.pieces.len();
    let mut rng = Rng(0x9E3779B97F4A7C15);
    let mut candidates: Vec<Piece> = pieces.clone();
    for round in 0..rounds {
        for p in &pieces {
            control.check()?;
            let noise = if round == 0 { 0.0 } else { 2.0 };
            candidates.push(grow(seeds, p.clone(), shop, &mut rng, noise, tol));
        }
    }
    for round in 0..perseed {
        for p in &seeds.pieces {
            let noise = if round == 0 { 0.0 } else { 2.0 };
            candidates.push(grow(seeds, p.clone(), shop, &mut rng, noise, tol));
        }
    }
    let sets: Vec<Vec<u32>> = candidates
        .iter()
        .map(|c| {
            let mut s = c.seeds.clone();
            s.sort_unstable();
            s.dedup();
            s
        })
        .collect();
    let area: Vec<f64> = seeds.pieces.iter().map(|p| p.area + 1e-9).collect();
    let mut best: Vec<usize> = (0..pieces.len()).collect();
    let tries = env("TRIES", 300.0) as usize;
    for attempt in 0..tries {
        let mut weight = area.clone();
        if attempt == 1 {
            weight.fill(1.0);
        }
        let mut chosen = Vec::new();
        if attempt > 1 {
            for w in &mut weight {
                *w = w.powf(rng.next()) * (0.2 + rng.next());
            }
            chosen = best.clone();
            let keep = 0.3 + 0.6 * rng.next();
            chosen.retain(|_| rng.next() < keep);
        }
        if greedy(&sets, &weight, &mut chosen, n) && chosen.len() <= best.len() {
            best = chosen;
        }
    }
    // each seed to the chosen hull that ... ; simple: first owner by fewest options
    let mut owner: Vec<Vec<u32>> = vec![Vec::new(); best.len()];
    for s in 0..n as u32 {
        let mut options: Vec<usize> = (0..best.len()).filter(|&k| sets[best[k]].binary_search(&s).is_ok()).collect();
        // prefer the smallest set
        options.sort_by_key(|&k| sets[best[k]].len());
        if let Some(&k) = options.first() {
            owner[k].push(s);
        }
    }
    let shrink = env("SHRINK", 0.0) > 0.0;
    let mut result = Vec::new();
    for (k, own) in owner.into_iter().enumerate() {
        if !shrink {
            result.push(candidates[best[k]].clone());
            continue;
        }
        if own.is_empty() {
            continue;
        }
        let mut points = Vec::new();
        let mut outward = [0.0; 3];
        let mut a = 0.0;
        for &s in &own {
            let p = &seeds.pieces[s as usize];
            points.extend_from_slice(&p.points);
            outward = add(outward, p.outward);
            a += p.area;
        }
        let mut piece = shop.hull(&points, outward, a);
        piece.seeds = own;
        result.push(piece);
    }
    Ok(result)
}
