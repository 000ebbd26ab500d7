//! Bundles: where a surface has many components, those that are near each other and whose joint
//! hull fits become one patch.
//!
//! Takes the coarse surface and its solid. Halves all components by their places until the hull of
//! each part fits: a seed. Its parts are halved on until none is larger than a patch may be, which
//! is more where there would be too many. O(n log n) for n triangles, and a fit test for each part
//! whose middle is not empty.

use super::patch::far_pair;
use super::settings::Settings;
use crate::control::Control;
use crate::error::Error;
use crate::geometry::vector::{Vector, diagonal, halves, mean};
use crate::hull::growing_hull::GrowingHull;
use crate::mesh::TriangleMesh;
use crate::mesh::grouping::members;
use crate::mesh::simplification::Simplification;
use crate::solid::{FitTester, Solid};

/// Components of a part that are compared with each other: where a point halfway between two of
/// them is outside, the hull of the part is not even built.
const MAX_COMPARED: usize = 16;

/// Bundles that the search takes in less time than what else it does. Slivers that are all longer
/// than a patch may be would each be one: 13,600 of a grille took 8 s, and had 10 hulls.
const MOST_BUNDLES: usize = 3000;

/// The factor by which patches become larger at a time.
const GROWTH: f64 = 1.5;

/// A component, and where it is.
struct Component {
    /// The mean of its vertices.
    centre: Vector,
    triangles: Vec<u32>,
}

/// Components whose joint hull fits.
pub(super) struct Bundle {
    /// Their triangles, ascending.
    pub triangles: Vec<u32>,
    pub hull: GrowingHull,
}

/// The components of a surface.
pub(super) struct Bundles {
    /// Bundles of one hull that fits.
    pub seeds: Vec<Vec<Bundle>>,
    /// The triangles of components whose own hull does not fit, ascending.
    pub others: Vec<u32>,
}

/// Bundles the components of a surface.
///
/// # Errors
/// [`Error::Cancelled`].
pub(super) fn bundle(
    coarse: &Simplification,
    solid: &Solid,
    settings: &Settings,
    control: &Control,
) -> Result<Bundles, Error> {
    let mesh = &coarse.mesh;
    let component = |triangles: Vec<u32>| {
        let centre = mean(&mesh.positions_of(triangles.iter().copied()));
        Component { centre, triangles }
    };
    let components = members(&coarse.components, coarse.closed.len());
    let components = components.into_iter().filter(|triangles| !triangles.is_empty());
    let components: Vec<Component> = components.map(component).collect();
    let bound = settings.bound.search();
    let tester = FitTester::new(solid, bound);
    let mut bundling = Bundling { mesh, components: &components, solid, bound, tester };
    let mut fitting: Vec<Vec<u32>> = Vec::new();
    let mut others: Vec<u32> = Vec::new();
    let mut stack = vec![Vec::from_iter(0..components.len() as u32)];
    while let Some(part) = stack.pop() {
        control.check()?;
        if bundling.fits(&part) {
            fitting.push(part);
        } else if part.len() == 1 {
            others.extend(bundling.triangles(&part));
        } else {
            stack.extend(bundling.halved(part));
        }
    }
    others.sort_unstable();
    let mut largest = settings.patch_size * mesh.area().sqrt();
    loop {
        let seeds: Result<Vec<Vec<Bundle>>, Error> = fitting
            .iter()
            .map(|seed| control.check().map(|()| bundling.divided(seed, largest)))
            .collect();
        let seeds = seeds?;
        let count: usize = seeds.iter().map(Vec::len).sum();
        if count <= MOST_BUNDLES.max(fitting.len()) {
            return Ok(Bundles { seeds, others });
        }
        largest *= GROWTH;
    }
}

struct Bundling<'a> {
    mesh: &'a TriangleMesh,
    components: &'a [Component],
    solid: &'a Solid,
    bound: f64,
    tester: FitTester<'a>,
}

impl Bundling<'_> {
    fn triangles(&self, part: &[u32]) -> impl Iterator<Item = u32> {
        part.iter().flat_map(|&one| &self.components[one as usize].triangles).copied()
    }

    fn points(&self, part: &[u32]) -> Vec<Vector> {
        self.mesh.positions_of(self.triangles(part))
    }

    /// Whether the joint hull of components fits.
    fn fits(&mut self, part: &[u32]) -> bool {
        let separates = |a, b| self.solid.separates(a, b, self.bound);
        let some = part.iter().step_by(part.len().div_ceil(MAX_COMPARED).max(1));
        let centres: Vec<Vector> = some.map(|&one| self.components[one as usize].centre).collect();
        let is_separated =
            |(index, &a): (usize, &Vector)| centres[..index].iter().any(|&b| separates(a, b));
        if centres.iter().enumerate().any(is_separated) {
            return false;
        }
        let points = self.points(part);
        if let [a, b] = far_pair(&points)[..]
            && separates(a, b)
        {
            return false;
        }
        let hull = self.hull(part, &points);
        self.tester.fits(&hull, false)
    }

    /// The bundles of a seed: parts that are single, or no larger than this.
    fn divided(&self, seed: &[u32], largest: f64) -> Vec<Bundle> {
        let mut bundles = Vec::new();
        let mut stack = vec![seed.to_vec()];
        while let Some(part) = stack.pop() {
            let points = self.points(&part);
            if part.len() > 1 && diagonal(points.iter().copied()) > largest {
                stack.extend(self.halved(part));
                continue;
            }
            let mut triangles: Vec<u32> = self.triangles(&part).collect();
            triangles.sort_unstable();
            bundles.push(Bundle { triangles, hull: self.hull(&part, &points) });
        }
        bundles
    }

    /// Both halves, the first last.
    fn halved(&self, mut part: Vec<u32>) -> [Vec<u32>; 2] {
        let centre = |&component: &u32| self.components[component as usize].centre;
        let (first, second) = halves(&mut part, centre);
        [second.to_vec(), first.to_vec()]
    }

    fn hull(&self, part: &[u32], points: &[Vector]) -> GrowingHull {
        let normals = self.triangles(part).map(|triangle| self.mesh.area_normal(triangle));
        GrowingHull::new(points, normals.fold(Vector::ZERO, |sum, normal| sum + normal))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bounded::fixture::{Fixture, cubes};
    use crate::geometry::TriangleMesh;
    use crate::mesh::shapes::{cuboid, join, torus};

    /// The components of each seed, and those in none.
    fn bundled(mesh: &TriangleMesh) -> (Vec<Vec<u32>>, Vec<u32>) {
        let fixture = Fixture::new(mesh, 0.02);
        let (coarse, solid) = (&fixture.surfaces.coarse, &fixture.solids.coarse);
        let found = bundle(coarse, solid, &fixture.settings, &fixture.control).unwrap();
        let components = |triangles: &[u32]| {
            let all = triangles.iter().map(|&triangle| coarse.components[triangle as usize]);
            let mut components: Vec<u32> = all.collect();
            components.sort_unstable();
            components.dedup();
            components
        };
        let triangles_of = |seed: &Vec<Bundle>| -> Vec<u32> {
            seed.iter().flat_map(|bundle| &bundle.triangles).copied().collect()
        };
        let seeds: Vec<Vec<u32>> = found.seeds.iter().map(triangles_of).collect();
        // Each triangle is in one of them.
        let mut all = [found.others.clone(), seeds.concat()].concat();
        all.sort_unstable();
        assert_eq!(all, Vec::from_iter(0..coarse.mesh.triangles.len() as u32));
        (seeds.iter().map(|seed| components(seed)).collect(), components(&found.others))
    }

    #[test]
    fn components_near_each_other_are_one_seed() {
        let (mut seeds, others) = bundled(&cubes([0.0, 1.01, 4.0, 5.01]));
        seeds.sort();
        assert_eq!(seeds, [[0, 1], [2, 3]]);
        assert!(others.is_empty());
    }

    #[test]
    fn components_around_empty_space_are_no_seed() {
        // Each of the four sides of a frame is as far from the opposite one as it is long.
        let side = |low, high| cuboid(low, high);
        let frame = [
            side([0.0, 0.0, 0.0], [4.0, 0.5, 0.5]),
            side([0.0, 3.5, 0.0], [4.0, 4.0, 0.5]),
            side([0.0, 0.51, 0.0], [0.5, 3.49, 0.5]),
            side([3.5, 0.51, 0.0], [4.0, 3.49, 0.5]),
        ];
        assert_eq!(bundled(&join(&frame)).0.len(), 4);
    }

    #[test]
    fn slivers_longer_than_a_patch_are_bundled_where_there_are_too_many() {
        // Thin planks side by side, as long as the whole.
        let plank = |i: usize| {
            let x = i as f64 * 1e-4;
            cuboid([x, 0.0, 0.0], [x + 9e-5, 1.0, 1e-3])
        };
        let count = |planks: usize| {
            let fixture = Fixture::new(&join(&Vec::from_iter((0..planks).map(plank))), 0.02);
            let (coarse, solid) = (&fixture.surfaces.coarse, &fixture.solids.coarse);
            let found = bundle(coarse, solid, &fixture.settings, &fixture.control).unwrap();
            (found.seeds.len(), found.seeds.iter().map(Vec::len).sum::<usize>())
        };
        assert_eq!(count(2000), (1, 2000));
        let (seeds, bundles) = count(4000);
        assert_eq!(seeds, 1);
        assert!(bundles <= MOST_BUNDLES, "{bundles}");
    }

    #[test]
    fn a_component_that_does_not_fit_is_in_no_seed() {
        let far = cuboid([4.0, 0.0, 0.0], [4.5, 0.5, 0.5]);
        let (seeds, others) = bundled(&join(&[torus(24, 12), far]));
        assert_eq!((seeds.len(), others.len()), (1, 1));
        assert_ne!(seeds[0], others);
    }
}
