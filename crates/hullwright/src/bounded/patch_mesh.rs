//! The mesh that is divided into patches: the coarse surface cut into facets, or, if it has many
//! triangles, simplified and refined; of one of many components what is in no bundle of them.
//!
//! Takes the coarse surface, gives the mesh that is divided into patches. Each of its triangles
//! represents the triangles of the coarse surface that are closest to it. So the hulls of patches
//! cover that surface, and not only what simplification left of it.

use super::bundles::{Bundle, Bundles, bundle};
use super::detail::Parts;
use super::facets::{Facets, facets};
use super::patch::Patch;
use super::settings::Settings;
use crate::bvh::{Bvh, closest_triangles};
use crate::control::Control;
use crate::error::Error;
use crate::geometry::vector::{Vector, centre};
use crate::hull::HullBuilder;
use crate::hull::growing_hull::GrowingHull;
use crate::mesh::TriangleMesh;
use crate::mesh::refine::refine;
use crate::mesh::simplification::Simplification;
use crate::mesh::simplify::{SimplifiedMesh, simplify};
use crate::solid::{COARSE, Solid};

/// Simplification joins nothing, and each component is a patch or more. Of a surface in more
/// components than this the search, which compares all patches, takes seconds and gigabytes: near
/// ones are bundled.
const MOST_COMPONENTS: usize = 1200;

/// Points of a whole component nearer to its hull than this share of its thickness are left out.
/// With the patch tolerance alone, a thin plate would keep hardly more than four corners.
const TOLERANCE_OF_THICKNESS: f64 = 0.02;

/// The mesh, and the surface that its triangles represent.
pub(crate) struct PatchMesh {
    pub mesh: TriangleMesh,
    pub components: Vec<u32>,
    pub surface: TriangleMesh,
    /// For each triangle of `surface` the coarse triangle that it is a part of.
    pub parents: Vec<u32>,
    /// For each triangle of `mesh` those of `surface` that it represents.
    pub represented: Vec<Vec<u32>>,
    /// For each triangle of `mesh` its facet: patches end at borders of facets.
    pub facets: Vec<u32>,
    /// For each triangle of `mesh` its planar group. Empty where the mesh was not cut.
    pub planes: Vec<u32>,
    /// The patches of what no triangle of `mesh` represents, by seeds.
    pub bundles: Vec<Vec<Patch>>,
}

impl PatchMesh {
    /// A surface of few triangles is divided into facets; of one of many components those that are
    /// near each other are bundled.
    pub(crate) fn new(
        coarse: &Simplification,
        solid: &Solid,
        settings: &Settings,
        control: &Control,
    ) -> Result<Self, Error> {
        let (source, source_components) = (&coarse.mesh, &coarse.components);
        if coarse.closed.len() > MOST_COMPONENTS {
            return Self::bundled(coarse, solid, settings, control);
        }
        if source.triangles.len() <= COARSE {
            return Ok(Self::from_facets(coarse, settings));
        }
        let (surface, parents) = refined(source.clone(), settings);
        control.check()?;
        if source.triangles.len() <= settings.triangles {
            let components = select(&parents, source_components);
            let (mesh, represented) = (surface.clone(), each_itself(&surface));
            return Ok(Self::without_facets(mesh, components, surface, parents, represented));
        }
        let mut simplified = simplify(source, source_components, settings.triangles, control)?;
        control.check()?;
        // Patches of a surface that is another one would not fit, and end as single triangles.
        if simplified.error > settings.bound.verified() && settings.triangles < COARSE {
            simplified = simplify(source, source_components, COARSE, control)?;
            control.check()?;
        }
        let all: Vec<u32> = (0..surface.triangles.len() as u32).collect();
        Self::of_simplified(simplified, surface, parents, &all, settings, control)
    }

    /// A surface whose components are bundled. What is in no bundle is simplified.
    fn bundled(
        coarse: &Simplification,
        solid: &Solid,
        settings: &Settings,
        control: &Control,
    ) -> Result<Self, Error> {
        let Bundles { seeds, others } = bundle(coarse, solid, settings, control)?;
        let (surface, parents) = refined(coarse.mesh.clone(), settings);
        let parts = Parts::new(&surface, &parents, coarse.mesh.triangles.len());
        let parts_of = |triangles: &[u32]| -> Vec<u32> {
            triangles.iter().flat_map(|&triangle| parts.of(triangle)).collect()
        };
        let patch_of = |Bundle { triangles, hull }: Bundle| {
            let own = parts_of(&triangles);
            let points = surface.positions_of(own.iter().copied());
            let normals = own.iter().map(|&triangle| surface.area_normal(triangle));
            let mut patch = patch(&points, normals, &mut reducer_of_whole(&hull, settings));
            patch.component = triangles.first().map_or(0, |&t| coarse.components[t as usize]);
            patch.triangles = own;
            patch
        };
        let bundles =
            seeds.into_iter().map(|seed| seed.into_iter().map(patch_of).collect()).collect();
        let triangles = others.iter().map(|&t| coarse.mesh.triangles[t as usize]).collect();
        let rest = TriangleMesh::new(coarse.mesh.positions.clone(), triangles);
        let components = select(&others, &coarse.components);
        let simplified = simplify(&rest, &components, settings.triangles, control)?;
        control.check()?;
        let others = parts_of(&others);
        let mesh = Self::of_simplified(simplified, surface, parents, &others, settings, control)?;
        Ok(Self { bundles, ..mesh })
    }

    /// The simplified mesh, refined, which represents some triangles of the surface.
    fn of_simplified(
        simplified: SimplifiedMesh,
        surface: TriangleMesh,
        parents: Vec<u32>,
        some: &[u32],
        settings: &Settings,
        control: &Control,
    ) -> Result<Self, Error> {
        let (mesh, origins) = refined(simplified.mesh, settings);
        let components = select(&origins, &simplified.components);
        let represented = represented(&mesh, &surface, some, control)?;
        Ok(Self::without_facets(mesh, components, surface, parents, represented))
    }

    /// The coarse surface itself, cut into facets.
    fn from_facets(coarse: &Simplification, settings: &Settings) -> Self {
        let Facets { mesh, parents, planes, facets } = facets(&coarse.mesh, settings);
        let components = select(&parents, &coarse.components);
        let (surface, represented) = (mesh.clone(), each_itself(&mesh));
        let bundles = Vec::new();
        Self { mesh, components, surface, parents, represented, facets, planes, bundles }
    }

    /// A mesh each of whose triangles is a facet.
    fn without_facets(
        mesh: TriangleMesh,
        components: Vec<u32>,
        surface: TriangleMesh,
        parents: Vec<u32>,
        represented: Vec<Vec<u32>>,
    ) -> Self {
        let facets = (0..mesh.triangles.len() as u32).collect();
        let (planes, bundles) = (Vec::new(), Vec::new());
        Self { mesh, components, surface, parents, represented, facets, planes, bundles }
    }

    /// The patch of some triangles. `reducer` drops points within its tolerance of their hull.
    pub(super) fn patch(&self, triangles: &[u32], reducer: &mut HullBuilder) -> Patch {
        let Self { mesh, components, surface, represented, .. } = self;
        let mut points = mesh.positions_of(triangles.iter().copied());
        let own: Vec<u32> = triangles
            .iter()
            .flat_map(|&triangle| &represented[triangle as usize])
            .copied()
            .collect();
        points.extend(surface.positions_of(own.iter().copied()));
        let normals = triangles.iter().map(|&triangle| self.normal(triangle));
        let component = triangles.first().map_or(0, |&triangle| components[triangle as usize]);
        let mut patch = patch(&points, normals, reducer);
        (patch.triangles, patch.component) = (own, component);
        if !self.planes.is_empty() {
            // Ends of large patches around empty space can all be near other patches.
            patch.representatives.push(self.centre_of(triangles));
        }
        patch
    }

    /// The centre of triangles by area; of a single one its own.
    pub(super) fn centre_of(&self, triangles: &[u32]) -> Vector {
        if let &[triangle] = triangles {
            return centre(self.corners(triangle));
        }
        let (mut sum, mut area) = (Vector::ZERO, f64::MIN_POSITIVE);
        for &triangle in triangles {
            let weight = self.normal(triangle).length();
            sum += centre(self.corners(triangle)) * weight;
            area += weight;
        }
        sum * (1.0 / area)
    }

    pub(super) fn corners(&self, triangle: u32) -> [Vector; 3] {
        self.mesh.corners(self.mesh.triangles[triangle as usize])
    }

    /// Twice the area of a triangle times its unit normal.
    pub(super) fn normal(&self, triangle: u32) -> Vector {
        self.mesh.area_normal(triangle)
    }
}

/// The patch of points, and of triangles by their area normals.
fn patch(
    points: &[Vector],
    normals: impl Iterator<Item = Vector>,
    reducer: &mut HullBuilder,
) -> Patch {
    let mut patch = Patch::default();
    for normal in normals {
        patch.outward += normal;
        patch.area += 0.5 * normal.length();
    }
    patch.set_points(reducer.vertices_of(points).unwrap_or_else(|| points.to_vec()));
    patch
}

/// What drops points of whole components whose hull is known.
pub(super) fn reducer_of_whole(hull: &GrowingHull, settings: &Settings) -> HullBuilder {
    let thickness = hull.volume / hull.max.distance_squared(hull.min);
    let tolerance = settings.bound.tolerance();
    HullBuilder::new().with_least_tolerance(match hull.is_solid {
        true => tolerance.min(TOLERANCE_OF_THICKNESS * thickness),
        false => tolerance,
    })
}

/// For each index what it selects.
fn select(indices: &[u32], from: &[u32]) -> Vec<u32> {
    indices.iter().map(|&index| from[index as usize]).collect()
}

/// A surface with its long triangles halved, and for each its parent.
fn refined(mut surface: TriangleMesh, settings: &Settings) -> (TriangleMesh, Vec<u32>) {
    let parents = refine(&mut surface, settings.bound.longest_edge());
    (surface, parents)
}

/// For each triangle of a mesh those of some of a surface that are closest to it.
fn represented(
    mesh: &TriangleMesh,
    surface: &TriangleMesh,
    some: &[u32],
    control: &Control,
) -> Result<Vec<Vec<u32>>, Error> {
    let bvh = Bvh::new(mesh.points(), &mesh.triangles);
    let mut represented: Vec<Vec<u32>> = vec![Vec::new(); mesh.triangles.len()];
    let triangles: Vec<[u32; 3]> = some.iter().map(|&t| surface.triangles[t as usize]).collect();
    let closest = closest_triangles(surface.points(), &triangles, &bvh, control)?;
    for (&triangle, closest) in some.iter().zip(closest) {
        if let Some(list) = represented.get_mut(closest as usize) {
            list.push(triangle);
        }
    }
    Ok(represented)
}

/// What the triangles of a surface represent that is divided as it is.
fn each_itself(surface: &TriangleMesh) -> Vec<Vec<u32>> {
    (0..surface.triangles.len() as u32).map(|triangle| vec![triangle]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bounded::fixture::Fixture;
    use crate::mesh::shapes::{cuboid, uv_sphere};

    /// A sphere each of whose triangles is by itself, a thousandth smaller.
    fn in_pieces(slices: u32) -> TriangleMesh {
        let whole = uv_sphere(slices, [0.0; 3], 0.5);
        let positions = whole.triangles.iter().flat_map(|triangle| {
            let corners = triangle.map(|vertex| Vector::from(whole.positions[vertex as usize]));
            corners.map(|corner| corner.lerp(centre(corners), 1e-3).into())
        });
        let count = whole.triangles.len() as u32;
        let triangles = (0..count).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]);
        TriangleMesh::new(positions.collect(), triangles.collect())
    }

    #[test]
    fn a_surface_of_many_components_is_divided_into_bundles_that_represent_all_of_it() {
        // Fewer triangles than a surface that is cut may have, and more.
        for slices in [30, 60] {
            let fixture = Fixture::new(&in_pieces(slices), 0.02);
            let Fixture { surfaces, solids, settings, control, .. } = &fixture;
            assert!(surfaces.coarse.closed.len() > MOST_COMPONENTS);
            let divided =
                PatchMesh::new(&surfaces.coarse, &solids.coarse, settings, control).unwrap();
            let bundles = divided.bundles.concat();
            assert!(3 * bundles.len() < surfaces.coarse.closed.len(), "{}", bundles.len());
            let of_bundles = bundles.iter().flat_map(|bundle| &bundle.triangles);
            let mut all: Vec<u32> = of_bundles.copied().collect();
            all.extend(divided.represented.concat());
            all.sort_unstable();
            assert_eq!(all, Vec::from_iter(0..divided.surface.triangles.len() as u32));
        }
    }

    #[test]
    fn a_surface_of_few_triangles_is_divided_as_it_is() {
        let fixture = Fixture::new(&cuboid([0.0; 3], [1.0; 3]), 0.02);
        let Fixture { surfaces, solids, settings, control, .. } = &fixture;
        let divided = PatchMesh::new(&surfaces.coarse, &solids.coarse, settings, control).unwrap();
        assert!(divided.mesh == fixture.surfaces.coarse.mesh && divided.mesh == divided.surface);
        assert_eq!(divided.components, [0; 12]);
        assert_eq!(divided.represented, each_itself(&divided.surface));
        assert_eq!(divided.planes.len(), 12);
    }

    #[test]
    fn a_surface_of_many_triangles_is_divided_through_fewer_that_represent_all_of_it() {
        // Its coarse surface under so small a bound has more triangles than are divided.
        let fixture = Fixture::new(&uv_sphere(44, [0.0; 3], 1.0), 0.002);
        let Fixture { surfaces, solids, settings, control, .. } = &fixture;
        assert!(surfaces.coarse.mesh.triangles.len() > COARSE);
        let divided = PatchMesh::new(&surfaces.coarse, &solids.coarse, settings, control).unwrap();
        assert!(divided.mesh.triangles.len() < divided.surface.triangles.len());
        assert!(divided.planes.is_empty());
        let mut represented = divided.represented.concat();
        represented.sort_unstable();
        assert_eq!(represented, Vec::from_iter(0..divided.surface.triangles.len() as u32));
    }

    #[test]
    fn a_patch_has_the_area_and_the_outward_side_of_its_triangles() {
        let fixture = Fixture::new(&cuboid([0.0; 3], [1.0; 3]), 0.02);
        let Fixture { surfaces, solids, settings, control, .. } = &fixture;
        let divided = PatchMesh::new(&surfaces.coarse, &solids.coarse, settings, control).unwrap();
        let face: Vec<u32> = (0..12).filter(|&triangle| divided.normal(triangle).z > 0.0).collect();
        let patch = divided.patch(&face, &mut HullBuilder::new());
        assert!((patch.area - 1.0 / 3.0).abs() < 1e-12);
        assert!(patch.outward.distance(Vector::Z * (2.0 / 3.0)) < 1e-12);
        assert_eq!(patch.triangles, face);
        // The centre of the face is one of the points by which others see it.
        let top = 0.5 / 3.0_f64.sqrt();
        let is_centre = |point: &&Vector| point.distance(Vector::Z * top) < 1e-9;
        assert_eq!(patch.representatives.iter().filter(is_centre).count(), 1);
    }
}
