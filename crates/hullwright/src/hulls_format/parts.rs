//! What the hulls of a `.hulls` file are made of: the parts of the mesh once, then the shares of
//! each hull.
//!
//! Numbers are LEB128, seven bits to a byte, the lowest first: a box is a few hundred bytes, and
//! what it is made of should add little to that. For the same reason a share that is the only one
//! of its hull is not written, nor are shares where there is one part.

use crate::part_shares::PartShare;

/// A part of a mesh that hulls are made of: one primitive, which has one material.
#[non_exhaustive]
#[derive(Debug, Clone, PartialEq, Eq, Hash, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct MeshPart {
    /// The mesh's name; may be empty.
    pub mesh: String,
    /// The number of the primitive in its mesh, from 0.
    pub primitive: u32,
    /// The material's name; empty where there is none, or it has none.
    pub material: String,
}

impl MeshPart {
    /// A primitive of a mesh.
    pub fn new(mesh: impl Into<String>, primitive: u32, material: impl Into<String>) -> Self {
        Self { mesh: mesh.into(), primitive, material: material.into() }
    }
}

/// What is wrong, in words.
type Checked<T> = Result<T, &'static str>;

/// How far the sum of a hull's shares may be from 1: rounding each to 24 bits moves it by less than
/// a tenth of this.
const ROUNDING: f64 = 1e-6;

/// A hull that is wholly of the first part.
const WHOLE: PartShare = PartShare { part: 0, share: 1.0 };

/// Shares as a file holds them: in single precision, in which the smallest may vanish.
pub(super) fn rounded(mut shares: Vec<Vec<PartShare>>) -> Vec<Vec<PartShare>> {
    for of_hull in &mut shares {
        of_hull.iter_mut().for_each(|share| share.share = f64::from(share.share as f32));
        of_hull.retain(|share| share.share != 0.0);
    }
    shares
}

/// Each hull wholly of the only part.
pub(super) fn of_one_part(hulls: usize) -> Vec<Vec<PartShare>> {
    vec![vec![WHOLE]; hulls]
}

/// Whether the shares of hulls mean something.
pub(super) fn check(parts: usize, shares: &[Vec<PartShare>], hulls: usize) -> Checked<()> {
    let expected = if parts == 0 { 0 } else { hulls };
    ensure(shares.len() == expected, "there is not one list of shares for each hull")?;
    shares.iter().try_for_each(|of_hull| {
        let exist = of_hull.iter().all(|share| (share.part as usize) < parts);
        ensure(exist, "a hull is made of a part that is not there")?;
        let are_shares = of_hull.iter().all(|share| share.share > 0.0 && share.share <= 1.0);
        ensure(are_shares, "a hull's share of a part is not above 0 and at most 1")?;
        let are_sorted = of_hull.is_sorted_by(|a, b| a.share >= b.share);
        ensure(are_sorted, "the shares of a hull do not begin with the largest")?;
        let sum: f64 = of_hull.iter().map(|share| share.share).sum();
        let is_whole = match of_hull.len() {
            // Of a mesh whose area is no number.
            0 => parts > 1,
            1 => sum == 1.0,
            _ => (sum - 1.0).abs() <= ROUNDING,
        };
        ensure(is_whole, "the shares of a hull do not add up to 1")
    })
}

/// Writes parts, at least one, and shares, which were checked before.
pub(super) fn write(
    bytes: &mut Vec<u8>,
    parts: &[MeshPart],
    shares: &[Vec<PartShare>],
) -> Checked<()> {
    write_count(bytes, parts.len())?;
    for part in parts {
        write_text(bytes, &part.mesh)?;
        write_number(bytes, part.primitive);
        write_text(bytes, &part.material)?;
    }
    for of_hull in shares.iter().filter(|_| parts.len() > 1) {
        write_count(bytes, of_hull.len())?;
        for share in of_hull {
            write_number(bytes, share.part);
            if of_hull.len() > 1 {
                bytes.extend((share.share as f32).to_le_bytes());
            }
        }
    }
    Ok(())
}

fn write_text(bytes: &mut Vec<u8>, text: &str) -> Checked<()> {
    write_count(bytes, text.len())?;
    bytes.extend(text.as_bytes());
    Ok(())
}

fn write_count(bytes: &mut Vec<u8>, count: usize) -> Checked<()> {
    let count = u32::try_from(count).map_err(|_| "a mesh has more parts than 32 bits count")?;
    write_number(bytes, count);
    Ok(())
}

fn write_number(bytes: &mut Vec<u8>, mut number: u32) {
    while number >= 0x80 {
        bytes.push(number as u8 | 0x80);
        number >>= 7;
    }
    bytes.push(number as u8);
}

/// Parts, and the shares of each hull.
type Parts = (Vec<MeshPart>, Vec<Vec<PartShare>>);

/// Reads what [`write`] writes from the front of `rest`, and checks it.
pub(super) fn read(rest: &mut &[u8], hulls: usize) -> Checked<Parts> {
    let count = read_count(rest)?;
    let parts = (0..count).map(|_| read_part(rest)).collect::<Checked<Vec<_>>>()?;
    let shares = match count {
        0 => Vec::new(),
        1 => of_one_part(hulls),
        _ => (0..hulls).map(|_| read_shares(rest)).collect::<Checked<_>>()?,
    };
    check(count, &shares, hulls)?;
    Ok((parts, shares))
}

fn read_part(rest: &mut &[u8]) -> Checked<MeshPart> {
    let mesh = read_text(rest)?;
    let primitive = read_number(rest)?;
    Ok(MeshPart { mesh, primitive, material: read_text(rest)? })
}

fn read_shares(rest: &mut &[u8]) -> Checked<Vec<PartShare>> {
    let count = read_count(rest)?;
    let share = |_| {
        let part = read_number(rest)?;
        if count == 1 {
            return Ok(PartShare { part, ..WHOLE });
        }
        let (share, after) = rest.split_first_chunk().ok_or(TOO_SHORT)?;
        *rest = after;
        Ok(PartShare { part, share: f32::from_le_bytes(*share).into() })
    };
    (0..count).map(share).collect()
}

fn read_text(rest: &mut &[u8]) -> Checked<String> {
    let length = read_count(rest)?;
    let (text, after) = rest.split_at_checked(length).ok_or(TOO_SHORT)?;
    *rest = after;
    let text = std::str::from_utf8(text).map_err(|_| "a text is not UTF-8")?;
    Ok(text.to_owned())
}

/// A count of things that take at least a byte each, for which there must be room.
fn read_count(rest: &mut &[u8]) -> Checked<usize> {
    let count = read_number(rest)? as usize;
    ensure(count <= rest.len(), TOO_SHORT).map(|()| count)
}

fn read_number(rest: &mut &[u8]) -> Checked<u32> {
    let mut number = 0_u64;
    for place in (0..u32::BITS).step_by(7) {
        let (byte, after) = rest.split_first().ok_or(TOO_SHORT)?;
        *rest = after;
        number |= u64::from(byte & 0x7f) << place;
        if *byte < 0x80 {
            return u32::try_from(number).map_err(|_| TOO_LARGE);
        }
    }
    Err(TOO_LARGE)
}

fn ensure(holds: bool, or: &'static str) -> Checked<()> {
    if holds { Ok(()) } else { Err(or) }
}

pub(super) const TOO_SHORT: &str = "it counts more than it holds";

const TOO_LARGE: &str = "a number has more than 32 bits";
