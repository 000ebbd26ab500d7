//! Merge.
use super::piece::{Piece, Workshop};
use crate::{Control, Error};
use std::cmp::Ordering;
use std::collections::{BTreeSet, BinaryHeap, HashSet};

struct Candidate {
    cost: f64,
    a: u32,
    b: u32,
    piece: Piece,
}
impl PartialEq for Candidate {
    fn eq(&self, o: &Self) -> bool {
        self.cmp(o) == Ordering::Equal
    }
}
impl Eq for Candidate {}
impl PartialOrd for Candidate {
    fn partial_cmp(&self, o: &Self) -> Option<Ordering> {
        Some(self.cmp(o))
    }
}
impl Ord for Candidate {
    fn cmp(&self, o: &Self) -> Ordering {
        o.cost.total_cmp(&self.cost).then_with(|| (o.a, o.b).cmp(&(self.a, self.b)))
    }
}

fn near(a: &Piece, b: &Piece, gap: f64) -> bool {
    (0..3).all(|k| a.min[k] <= b.max[k] + gap && b.min[k] <= a.max[k] + gap)
}

pub(crate) fn merge(
    seeds: Vec<Piece>,
    neighbours: &[(u32, u32)],
    shop: &mut Workshop<'_>,
    control: &Control,
) -> Result<Vec<Piece>, Error> {
    let count = seeds.len();
    let mut pieces: Vec<Option<Piece>> = seeds.into_iter().map(Some).collect();
    let mut links: Vec<BTreeSet<u32>> = vec![BTreeSet::new(); count];
    for &(a, b) in neighbours {
        links[a as usize].insert(b);
        links[b as usize].insert(a);
    }
    let mut refused: HashSet<(u32, u32)> = HashSet::new();
    for round in 0..2 {
        if round == 1 {
            let alive: Vec<u32> =
                (0..pieces.len() as u32).filter(|&i| pieces[i as usize].is_some()).collect();
            for (i, &a) in alive.iter().enumerate() {
                for &b in &alive[i + 1..] {
                    let (Some(pa), Some(pb)) = (&pieces[a as usize], &pieces[b as usize]) else { continue };
                    if near(pa, pb, shop.bound) {
                        links[a as usize].insert(b);
                        links[b as usize].insert(a);
                    }
                }
            }
        }
        let mut heap = BinaryHeap::new();
        let push = |heap: &mut BinaryHeap<Candidate>, refused: &HashSet<(u32, u32)>, shop: &mut Workshop<'_>, pieces: &[Option<Piece>], a: u32, b: u32| {
            let (a, b) = if a < b { (a, b) } else { (b, a) };
            if refused.contains(&(a, b)) {
                return;
            }
            if let (Some(pa), Some(pb)) = (&pieces[a as usize], &pieces[b as usize]) {
                let joint = shop.joint(pa, pb);
                let cost = joint.volume - pa.volume - pb.volume;
                heap.push(Candidate { cost, a, b, piece: joint });
            }
        };
        for a in 0..pieces.len() as u32 {
            for &b in &links[a as usize] {
                if a < b {
                    push(&mut heap, &refused, shop, &pieces, a, b);
                }
            }
        }
        while let Some(Candidate { a, b, piece, .. }) = heap.pop() {
            control.check()?;
            if pieces[a as usize].is_none() || pieces[b as usize].is_none() {
                continue;
            }
            if !shop.fits(&piece) {
                refused.insert((a, b));
                continue;
            }
            let new = pieces.len() as u32;
            pieces[a as usize] = None;
            pieces[b as usize] = None;
            pieces.push(Some(piece));
            let mut joined: BTreeSet<u32> = links[a as usize].union(&links[b as usize]).copied().collect();
            joined.retain(|&l| pieces[l as usize].is_some());
            let bad: Vec<u32> = joined
                .iter()
                .copied()
                .filter(|&l| [a, b].iter().any(|&x| refused.contains(&(x.min(l), x.max(l)))))
                .collect();
            for l in bad {
                refused.insert((l, new));
            }
            for &l in &joined {
                links[l as usize].insert(new);
            }
            links.push(joined.clone());
            for l in joined {
                push(&mut heap, &refused, shop, &pieces, l, new);
            }
        }
    }
    Ok(pieces.into_iter().flatten().collect())
}
