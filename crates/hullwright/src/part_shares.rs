//! What hulls are made of: how much of the surface that each stands for belongs to which part of
//! the mesh.

use crate::decomposition::Hull;
use crate::error::Error;
use crate::geometry::MeshView;
use crate::geometry::plane::Plane;
use crate::geometry::vector::{Vector, area_normal, bounds, centre};
use crate::sorting::{sort_by, sort_by_key};

/// How much of a hull is made of one part of a mesh.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct PartShare {
    /// The part: a number that the caller gave to triangles.
    pub part: u32,
    /// Its share of the area that the hull stands for, above 0 and at most 1.
    pub share: f64,
}

/// For each hull the parts of the mesh that it is made of, the largest share first. Parts are what
/// the caller says, by a number for each triangle: materials, primitives, nodes, or whatever else a
/// game looks up for a hull that was hit.
///
/// A hull stands for its [source triangles](crate::decomposition::Provenance::source_triangles).
/// Hulls without any, such as those of a file, stand for the triangles whose centres are nearest
/// to their surface. One that stands for none is made of what is nearest to it. Shares of a
/// hull add up to 1; there are none only where the mesh has no area.
///
/// ```
/// use hullwright::{Control, Parameters, TriangleMesh, decompose, part_shares};
///
/// // A tetrahedron of steel with a floor of rubber.
/// let mesh = TriangleMesh::new(
///     vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
///     vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]],
/// );
/// let (steel, rubber) = (0, 1);
/// let hulls = decompose(&mesh, &Parameters::default(), &Control::new())?.hulls;
/// let shares = part_shares(&mesh, &[rubber, steel, steel, steel], &hulls)?;
/// let [most, least] = shares[0][..] else { panic!("two parts") };
/// assert_eq!([most.part, least.part], [steel, rubber]);
/// assert!((least.share - 0.5 / (1.5 + 0.75_f64.sqrt())).abs() < 1e-9);
/// # Ok::<(), hullwright::Error>(())
/// ```
///
/// O(n) for n triangles where hulls have source triangles, O(n · faces of hulls near them)
/// otherwise.
///
/// # Errors
/// [`Error::InvalidParameter`] if there is not one part for each triangle, and
/// [`Error::IndexOutOfRange`] if a triangle has a vertex that is not there.
pub fn part_shares<'a>(
    mesh: impl Into<MeshView<'a>>,
    parts: &[u32],
    hulls: &[Hull],
) -> Result<Vec<Vec<PartShare>>, Error> {
    let mesh = mesh.into();
    let pieces = pieces(mesh, parts)?;
    let mut areas: Vec<Vec<(u32, f64)>> = vec![Vec::new(); hulls.len()];
    let know_theirs = hulls.iter().all(|hull| !hull.provenance.source_triangles.is_empty());
    if know_theirs {
        for (hull, areas) in hulls.iter().zip(&mut areas) {
            let own = hull.provenance.source_triangles.iter();
            let own = own.filter_map(|&triangle| pieces.get(triangle as usize)?.as_ref());
            areas.extend(own.map(|piece| (piece.part, piece.area)));
        }
    } else {
        let shapes: Vec<Shape> = hulls.iter().map(Shape::new).collect();
        for piece in pieces.iter().flatten() {
            if let Some(hull) = nearest(&shapes, piece.centre) {
                areas[hull].push((piece.part, piece.area));
            }
        }
    }
    for (hull, areas) in hulls.iter().zip(&mut areas).filter(|(_, areas)| areas.is_empty()) {
        let middle = middle(hull);
        let distance = |piece: &&Piece| piece.centre.distance_squared(middle);
        let all = pieces.iter().flatten();
        let nearest = all.min_by(|a, b| distance(a).total_cmp(&distance(b)));
        areas.extend(nearest.map(|piece| (piece.part, piece.area)));
    }
    Ok(areas.into_iter().map(shares).collect())
}

/// A triangle with an area.
struct Piece {
    part: u32,
    area: f64,
    centre: Vector,
}

/// The triangles; `None` for those without an area.
fn pieces(mesh: MeshView<'_>, parts: &[u32]) -> Result<Vec<Option<Piece>>, Error> {
    let triangles = mesh.triangles();
    if parts.len() != triangles.len() {
        let (given, count) = (parts.len(), triangles.len());
        let reason = format!("{given} parts were given for {count} triangles");
        return Err(Error::parameter("parts", reason));
    }
    let vertices = mesh.vertex_count();
    let piece = |(index, (&triangle, &part)): (usize, (&[u32; 3], &u32))| {
        let mut corners = [Vector::ZERO; 3];
        for (corner, vertex) in corners.iter_mut().zip(triangle) {
            *corner = mesh
                .position(vertex)
                .ok_or(Error::IndexOutOfRange { triangle: index, index: vertex, vertices })?
                .into();
        }
        let [a, b, c] = corners;
        let area = area_normal(a, b, c).length() / 2.0;
        let is_usable = area.is_finite() && area > 0.0;
        Ok(is_usable.then(|| Piece { part, area, centre: centre(corners) }))
    };
    triangles.iter().zip(parts).enumerate().map(piece).collect()
}

/// A hull whose surface may be near.
struct Shape {
    planes: Vec<Plane>,
    min: Vector,
    max: Vector,
}

impl Shape {
    fn new(hull: &Hull) -> Self {
        let (min, max) = bounds(hull.shape.points().iter().copied());
        let mut planes = hull.shape.face_planes();
        planes.retain(|plane| plane.normal != Vector::ZERO);
        Self { planes, min, max }
    }

    /// How far a point is from the surface, in front of a face or behind all; infinite where that
    /// is at least `known`.
    fn distance(&self, point: Vector, known: f64) -> f64 {
        let to_box = point.distance(point.clamp(self.min, self.max));
        if to_box >= known || self.planes.is_empty() {
            return f64::INFINITY;
        }
        let heights = self.planes.iter().map(|plane| plane.height(point));
        heights.fold(f64::NEG_INFINITY, f64::max).abs().max(to_box)
    }
}

/// The hull to whose surface a point is nearest, the first of several.
fn nearest(shapes: &[Shape], point: Vector) -> Option<usize> {
    let mut best: Option<(f64, usize)> = None;
    for (index, shape) in shapes.iter().enumerate() {
        let known = best.map_or(f64::INFINITY, |(distance, _)| distance);
        let distance = shape.distance(point, known);
        if distance < known {
            best = Some((distance, index));
        }
    }
    best.map(|(_, index)| index)
}

fn middle(hull: &Hull) -> Vector {
    let points = hull.shape.points();
    points.iter().fold(Vector::ZERO, |sum, &point| sum + point) / points.len().max(1) as f64
}

fn shares(mut areas: Vec<(u32, f64)>) -> Vec<PartShare> {
    sort_by_key(&mut areas, |&(part, _)| part);
    let mut shares: Vec<PartShare> = Vec::new();
    for (part, area) in areas {
        match shares.last_mut() {
            Some(last) if last.part == part => last.share += area,
            _ => shares.push(PartShare { part, share: area }),
        }
    }
    let whole: f64 = shares.iter().map(|share| share.share).sum();
    shares.iter_mut().for_each(|share| share.share /= whole);
    sort_by(&mut shares, |a, b| b.share.total_cmp(&a.share).then(a.part.cmp(&b.part)));
    shares
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hull::convex_hull;
    use crate::mesh::TriangleMesh;
    use crate::mesh::shapes::{cuboid, join};
    use crate::{Control, Parameters, decompose};

    /// Two boxes apart, each a part, the second one with a top of its own.
    fn boxes() -> (TriangleMesh, Vec<u32>) {
        let mesh = join(&[cuboid([0.0; 3], [1.0; 3]), cuboid([2.0, 0.0, 0.0], [4.0, 1.0, 1.0])]);
        let is_top = |triangle: &[u32; 3]| {
            triangle.iter().all(|&vertex| {
                let [x, _, z] = mesh.positions[vertex as usize];
                x >= 2.0 && z == 1.0
            })
        };
        let part = |(index, triangle): (usize, &[u32; 3])| match is_top(triangle) {
            true => 7,
            false => (index >= 12) as u32,
        };
        let parts = mesh.triangles.iter().enumerate().map(part).collect();
        (mesh, parts)
    }

    fn rounded(shares: &[Vec<PartShare>]) -> Vec<Vec<(u32, f64)>> {
        let of_hull = |shares: &Vec<PartShare>| {
            let round = |share: &PartShare| (share.part, (share.share * 1e6).round() / 1e6);
            shares.iter().map(round).collect()
        };
        shares.iter().map(of_hull).collect()
    }

    #[test]
    fn hulls_of_a_decomposition_and_the_same_of_a_file_are_made_of_the_same_parts() {
        let (mesh, parts) = boxes();
        let hulls = decompose(&mesh, &Parameters::default(), &Control::new()).unwrap().hulls;
        // A top of 2 square units of 10.
        let mut expected = [vec![(0, 1.0)], vec![(1, 0.8), (7, 0.2)]];
        let found = rounded(&part_shares(&mesh, &parts, &hulls).unwrap());
        if found[0].len() == 2 {
            expected.reverse();
        }
        assert_eq!(found, expected);
        let of_a_file: Vec<Hull> = hulls.iter().map(|hull| hull.shape.clone().into()).collect();
        assert_eq!(rounded(&part_shares(&mesh, &parts, &of_a_file).unwrap()), expected);
    }

    #[test]
    fn a_hull_within_others_is_made_of_what_is_nearest() {
        let (mesh, parts) = boxes();
        let mut shapes = [cuboid([0.0; 3], [1.0; 3]), cuboid([2.0, 0.0, 0.0], [4.0, 1.0, 1.0])]
            .map(|mesh| convex_hull(&mesh.positions).unwrap())
            .to_vec();
        shapes.push(convex_hull(&cuboid([0.4; 3], [0.6; 3]).positions).unwrap());
        let hulls: Vec<Hull> = shapes.into_iter().map(Hull::from).collect();
        assert_eq!(rounded(&part_shares(&mesh, &parts, &hulls).unwrap())[2], [(0, 1.0)]);
    }

    #[test]
    fn parts_that_are_missing_and_vertices_that_are_not_there_are_errors() {
        let (mut mesh, parts) = boxes();
        let error = part_shares(&mesh, &parts[1..], &[]).unwrap_err();
        assert_eq!(error.code(), "invalid_parameter");
        assert!(error.to_string().contains("23 parts were given for 24 triangles"), "{error}");
        mesh.triangles[3][1] = 99;
        let error = part_shares(&mesh, &parts, &[]).unwrap_err();
        assert_eq!(error.code(), "index_out_of_range");
    }

    #[test]
    fn triangles_without_area_are_no_part_of_a_hull() {
        let (mut mesh, mut parts) = boxes();
        mesh.triangles.push([0, 0, 1]);
        mesh.positions.push([f64::NAN; 3]);
        mesh.triangles.push([0, 1, 16]);
        parts.extend([9, 9]);
        let hull = Hull::from(convex_hull(&mesh.positions[..16]).unwrap());
        let shares = part_shares(&mesh, &parts, &[hull]).unwrap();
        assert!(shares[0].iter().all(|share| share.part != 9));
        let whole: f64 = shares[0].iter().map(|share| share.share).sum();
        assert!((whole - 1.0).abs() < 1e-12);
    }
}
