//! Fewer pieces: each grows over all seeds that it can take, few of them are chosen that cover
//! all seeds, and of those one after the other is dissolved into the rest where that works.

use super::Tuning;
use super::piece::{Hull, Piece, Workshop};
use super::seed_set::SeedSet;
use super::seeds::{Seed, Seeds};
use super::solid::Solid;
use crate::control::Control;
use crate::error::Error;
use crate::geometry::vector::{add, distance, scale};

/// Lets a hull take seeds in order of nearness, those of `wanted` alone, until none fits.
///
/// As long as all goes well, more and more seeds are taken at once: faces that would only have
/// been there between one seed and the next are never tested.
fn grow(
    seeds: &Seeds,
    piece: &mut Piece,
    wanted: &SeedSet,
    shop: &mut Workshop<'_>,
    control: &Control,
) -> Result<(), Error> {
    let mut open = wanted.clone();
    open.subtract(&piece.seeds);
    for seed in piece.seeds.iter() {
        open.subtract(&seeds.conflicts[seed as usize]);
    }
    let mut at_once = 1;
    let mut batch: Vec<u32> = Vec::new();
    while !open.is_empty() {
        let mut order: Vec<(f64, u32)> = open
            .iter()
            .map(|index| (reach(&piece.hull, &seeds.seeds[index as usize]), index))
            .collect();
        order.sort_by(|a, b| a.0.total_cmp(&b.0));
        let ordered_at = piece.hull.current_volume();
        let mut order = order.into_iter();
        // The order of nearness changes as the hull grows.
        while piece.hull.current_volume() <= REORDER * ordered_at {
            batch.clear();
            for (_, index) in order.by_ref() {
                let is_free = open.contains(index)
                    && !batch.iter().any(|&b| seeds.conflicts[b as usize].contains(index));
                if !is_free {
                    continue;
                }
                if covers(&piece.hull, &seeds.seeds[index as usize], COVER_TOLERANCE) {
                    piece.seeds.insert(index);
                    open.remove(index);
                    open.subtract(&seeds.conflicts[index as usize]);
                    continue;
                }
                batch.push(index);
                if batch.len() == at_once {
                    break;
                }
            }
            if batch.is_empty() {
                break;
            }
            let fits = take(seeds, piece, &batch, &mut open, shop, control)?;
            at_once = if fits { (2 * at_once).min(MOST_AT_ONCE) } else { 1 };
        }
    }
    Ok(())
}

/// Lets a hull take those of some seeds that fit, all at once if possible. Whether it was.
fn take(
    seeds: &Seeds,
    piece: &mut Piece,
    batch: &[u32],
    open: &mut SeedSet,
    shop: &mut Workshop<'_>,
    control: &Control,
) -> Result<bool, Error> {
    control.check()?;
    if shop.try_take(&mut piece.hull, batch.iter().map(|&index| &seeds.seeds[index as usize])) {
        for &index in batch {
            piece.seeds.insert(index);
            open.remove(index);
            open.subtract(&seeds.conflicts[index as usize]);
        }
        return Ok(true);
    }
    if let &[index] = batch {
        open.remove(index);
        return Ok(false);
    }
    let (first, second) = batch.split_at(batch.len() / 2);
    take(seeds, piece, first, open, shop, control)?;
    let second: Vec<u32> = second.iter().copied().filter(|&index| open.contains(index)).collect();
    if !second.is_empty() {
        take(seeds, piece, &second, open, shop, control)?;
    }
    Ok(false)
}

/// Most seeds that are tried at once.
const MOST_AT_ONCE: usize = 16;

/// A seed that stands out of a hull by less than this, in diagonals, counts as covered.
const COVER_TOLERANCE: f64 = 3e-4;

/// A hull that has grown by this factor asks anew which seeds are near.
const REORDER: f64 = 1.15;

/// How far a seed is outside of a hull, by its representatives.
fn reach(hull: &Hull, seed: &Seed) -> f64 {
    if hull.is_solid {
        hull.builder.farthest_outside(&seed.representatives)
    } else {
        distance(scale(add(hull.min, hull.max), 0.5), scale(add(seed.min, seed.max), 0.5))
    }
}

fn covers(hull: &Hull, seed: &Seed, tolerance: f64) -> bool {
    hull.is_solid
        && (0..3).all(|k| {
            seed.min[k] >= hull.min[k] - tolerance && seed.max[k] <= hull.max[k] + tolerance
        })
        && hull.builder.contains_all(&seed.points, tolerance)
}

/// The hull of some seeds.
pub(crate) fn hull_of(seeds: &Seeds, set: &SeedSet) -> Piece {
    let mut points = Vec::new();
    let mut outward = [0.0; 3];
    for seed in set.iter() {
        let seed = &seeds.seeds[seed as usize];
        points.extend_from_slice(&seed.points);
        outward = add(outward, seed.outward);
    }
    Piece { seeds: set.clone(), hull: Hull::of(&points, outward), vertices: Vec::new() }
}

/// Seeds that only piece `k` of those that are `alive` covers.
fn own(pieces: &[Piece], alive: &[bool], k: usize) -> SeedSet {
    let mut own = pieces[k].seeds.clone();
    for (j, piece) in pieces.iter().enumerate() {
        if j != k && alive[j] {
            own.subtract(&piece.seeds);
        }
    }
    own
}

fn area(seeds: &Seeds, set: &SeedSet) -> f64 {
    set.iter().map(|s| seeds.seeds[s as usize].area).sum()
}

/// Drops pieces all of whose seeds others cover, smallest first.
fn drop_redundant(seeds: &Seeds, pieces: &mut Vec<Piece>) {
    pieces.sort_by(|a, b| area(seeds, &a.seeds).total_cmp(&area(seeds, &b.seeds)));
    let mut alive = vec![true; pieces.len()];
    for k in 0..pieces.len() {
        if own(pieces, &alive, k).is_empty() {
            alive[k] = false;
        }
    }
    let mut index = 0;
    pieces.retain(|_| {
        index += 1;
        alive[index - 1]
    });
}

/// Tries to hand what only piece `k` covers to the others, which may let go of what is covered
/// elsewhere.
fn dissolve_one(
    seeds: &Seeds,
    pieces: &[Piece],
    k: usize,
    shop: &mut Workshop<'_>,
    control: &Control,
) -> Result<Option<Vec<Piece>>, Error> {
    let mut alive = vec![true; pieces.len()];
    let mut left = own(pieces, &alive, k);
    alive[k] = false;
    // The cheapest refusal first: a seed that conflicts with what each other piece must keep.
    let cores: Vec<SeedSet> = (0..pieces.len())
        .map(|j| {
            if j == k {
                SeedSet::none(seeds.count())
            } else {
                let mut core = own(pieces, &alive, j);
                core.subtract(&left);
                core
            }
        })
        .collect();
    let compatible = |seed: u32, core: &SeedSet| !seeds.conflicts[seed as usize].intersects(core);
    if left.iter().any(|seed| !(0..pieces.len()).any(|j| j != k && compatible(seed, &cores[j]))) {
        return Ok(None);
    }
    let mut changed: Vec<(usize, Piece)> = Vec::new();
    let mut sets: Vec<SeedSet> = pieces.iter().map(|piece| piece.seeds.clone()).collect();
    // Those that can take most go first.
    let mut order: Vec<(usize, usize)> = (0..pieces.len())
        .filter(|&j| j != k)
        .map(|j| (left.iter().filter(|&seed| compatible(seed, &cores[j])).count(), j))
        .filter(|&(count, _)| count > 0)
        .collect();
    order.sort_by(|a, b| b.0.cmp(&a.0).then(a.1.cmp(&b.1)));
    for (_, j) in order {
        // What only j covers now, the others being as they have become.
        let mut core = sets[j].clone();
        for (i, set) in sets.iter().enumerate() {
            if i != j && i != k {
                core.subtract(set);
            }
        }
        let mut piece = hull_of(seeds, &core);
        grow(seeds, &mut piece, &left, shop, control)?;
        let mut taken = piece.seeds.clone();
        taken.subtract(&core);
        if taken.is_empty() {
            continue;
        }
        left.subtract(&piece.seeds);
        sets[j] = piece.seeds.clone();
        changed.push((j, piece));
        if left.is_empty() {
            break;
        }
    }
    if !left.is_empty() {
        return Ok(None);
    }
    let mut pieces = pieces.to_vec();
    let all = seeds.all();
    for (j, mut piece) in changed {
        grow(seeds, &mut piece, &all, shop, control)?;
        pieces[j] = piece;
    }
    pieces.remove(k);
    Ok(Some(pieces))
}

/// Dissolves pieces under a bound, those with least area of their own first, until none can go or too
/// much has been tried.
fn dissolve(
    seeds: &Seeds,
    pieces: &mut Vec<Piece>,
    solid: &Solid,
    bound: f64,
    most_tries: usize,
    control: &Control,
) -> Result<(), Error> {
    let mut tried = 0;
    'again: loop {
        let alive = vec![true; pieces.len()];
        let mut order: Vec<(f64, usize)> =
            (0..pieces.len()).map(|k| (area(seeds, &own(pieces, &alive, k)), k)).collect();
        order.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        for some in order.chunks(AT_ONCE) {
            control.check()?;
            if tried >= most_tries || control.is_past_deadline() {
                return Ok(());
            }
            let attempt = |&(_, k): &(f64, usize)| {
                let mut shop = Workshop::new(solid, bound);
                let dissolved = dissolve_one(seeds, pieces, k, &mut shop, control);
                (dissolved, shop.tried)
            };
            let succeeds = |(dissolved, _): &(Result<Option<Vec<Piece>>, Error>, usize)| {
                !matches!(dissolved, Ok(None))
            };
            let attempts = crate::parallel::map_until(some, attempt, succeeds);
            for (dissolved, tries) in attempts {
                tried += tries + pieces.len() / PIECES_PER_TRY;
                if let Some(fewer) = dissolved? {
                    *pieces = fewer;
                    drop_redundant(seeds, pieces);
                    continue 'again;
                }
            }
        }
        return Ok(());
    }
}

/// Pieces whose dissolving is tried between two looks at how much has been tried.
const AT_ONCE: usize = 4;

/// Looking through this many pieces takes about as long as trying a joint hull.
const PIECES_PER_TRY: usize = 16;

/// The last round of dissolving, by nearly all of the bound, may try this share of what the first one may:
/// a tenth is more than nearly all meshes need.
const LAST_TRIES: f64 = 0.1;

/// Fewer pieces that cover the same seeds.
pub(crate) struct Covered {
    pub pieces: Vec<Piece>,
    /// Those before the last round of dissolving, if it took any away, before they [`shrink`].
    pub before: Option<Vec<Piece>>,
}

/// Covers all seeds with fewer pieces.
pub(crate) fn cover(
    seeds: &Seeds,
    pieces: Vec<Piece>,
    solid: &Solid,
    tuning: &Tuning,
    control: &Control,
) -> Result<Covered, Error> {
    if pieces.len() < 2 {
        return Ok(Covered { pieces, before: None });
    }
    let all = seeds.all();
    let size = |piece: &Piece| piece.seeds.count();
    let grown = crate::parallel::map_largest_first(&pieces, size, |piece| {
        control.check()?;
        let mut piece = piece.clone();
        if !control.is_past_deadline() {
            let mut shop = Workshop::new(solid, tuning.search_bound);
            grow(seeds, &mut piece, &all, &mut shop, control)?;
        }
        Ok(piece)
    });
    let mut pieces = grown.into_iter().collect::<Result<Vec<Piece>, Error>>()?;
    drop_redundant(seeds, &mut pieces);
    dissolve(seeds, &mut pieces, solid, tuning.search_bound, tuning.dissolving_tries, control)?;
    let before = pieces.clone();
    let last_tries = (LAST_TRIES * tuning.dissolving_tries as f64) as usize;
    dissolve(seeds, &mut pieces, solid, tuning.last_bound, last_tries, control)?;
    let before = (pieces.len() < before.len()).then_some(before);
    Ok(Covered { pieces: shrink(seeds, pieces, control)?, before })
}

/// Each seed stays with one piece, and pieces shrink to what they own.
pub(crate) fn shrink(
    seeds: &Seeds,
    mut pieces: Vec<Piece>,
    control: &Control,
) -> Result<Vec<Piece>, Error> {
    let alive = vec![true; pieces.len()];
    let mut owned: Vec<Piece> =
        (0..pieces.len()).map(|k| hull_of(seeds, &own(&pieces, &alive, k))).collect();
    let mut shared = SeedSet::of(seeds.count(), 0..seeds.count() as u32);
    for piece in &owned {
        shared.subtract(&piece.seeds);
    }
    let mut order: Vec<u32> = shared.iter().collect();
    order.sort_by(|&a, &b| seeds.seeds[b as usize].area.total_cmp(&seeds.seeds[a as usize].area));
    for index in order {
        control.check()?;
        let seed = &seeds.seeds[index as usize];
        let mut best: Option<(f64, usize)> = None;
        for (k, piece) in pieces.iter().enumerate() {
            if !piece.seeds.contains(index) {
                continue;
            }
            let mut hull = owned[k].hull.clone();
            hull.insert(&seed.points, seed.outward);
            let growth = hull.current_volume() - owned[k].hull.volume;
            if best.is_none_or(|b| growth < b.0) {
                best = Some((growth, k));
            }
        }
        if let Some((_, k)) = best {
            let owner = &mut owned[k];
            owner.seeds.insert(index);
            owner.hull.insert(&seed.points, seed.outward);
            owner.hull.volume = owner.hull.current_volume();
        }
    }
    pieces.clear();
    owned.retain(|piece| !piece.seeds.is_empty());
    Ok(owned)
}
