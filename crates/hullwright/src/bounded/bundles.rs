//! Bundles: where a surface has many components, those that are near each other and whose joint
//! hull fits become one patch.
//!
//! Takes the coarse surface and its solid. Halves all components by their places until the hull of
//! each part fits. O(n log n) for n triangles, and a fit test for each part whose middle is not
//! empty.

use super::patch::far_pair;
use super::settings::Settings;
use crate::control::Control;
use crate::error::Error;
use crate::geometry::vector::{Vector, area_normal, bounds};
use crate::hull::growing_hull::GrowingHull;
use crate::mesh::TriangleMesh;
use crate::mesh::grouping::members;
use crate::mesh::simplification::Simplification;
use crate::solid::{FitTester, Solid};

/// Components of a part that are compared with each other: where a point halfway between two of
/// them is outside, the hull of the part is not even built.
const MAX_COMPARED: usize = 16;

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
#[derive(Default)]
pub(super) struct Bundles {
    pub bundles: Vec<Bundle>,
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
        let points = mesh.positions_of(triangles.iter().copied());
        let sum = points.iter().fold(Vector::ZERO, |sum, &point| sum + point);
        Component { centre: sum / points.len().max(1) as f64, triangles }
    };
    let components = members(&coarse.components, coarse.closed.len());
    let components = components.into_iter().filter(|triangles| !triangles.is_empty());
    let mut bundling = Bundling {
        mesh,
        solid,
        bound: settings.bound.search(),
        tester: FitTester::new(solid, settings.bound.search()),
    };
    let mut found = Bundles::default();
    let mut stack = vec![components.map(component).collect::<Vec<Component>>()];
    while let Some(part) = stack.pop() {
        control.check()?;
        if let Some(hull) = bundling.fitting(&part) {
            found.bundles.push(Bundle { triangles: triangles_of(part), hull });
        } else if part.len() > 1 {
            let (first, second) = halves(part);
            stack.extend([second, first]);
        } else {
            found.others.extend(triangles_of(part));
        }
    }
    found.others.sort_unstable();
    Ok(found)
}

fn triangles_of(part: Vec<Component>) -> Vec<u32> {
    let mut triangles: Vec<u32> = part.into_iter().flat_map(|one| one.triangles).collect();
    triangles.sort_unstable();
    triangles
}

/// Two halves along the axis of greatest extent.
fn halves(mut part: Vec<Component>) -> (Vec<Component>, Vec<Component>) {
    let (min, max) = bounds(part.iter().map(|one| one.centre));
    let extent = max - min;
    let axis = (0..3).max_by(|&a, &b| extent[a].total_cmp(&extent[b])).unwrap_or(0);
    let place = |one: &Component| one.centre[axis];
    part.sort_by(|a, b| place(a).total_cmp(&place(b)).then(a.triangles.cmp(&b.triangles)));
    let second = part.split_off(part.len() / 2);
    (part, second)
}

struct Bundling<'a> {
    mesh: &'a TriangleMesh,
    solid: &'a Solid,
    bound: f64,
    tester: FitTester<'a>,
}

impl Bundling<'_> {
    /// The joint hull of components, if it fits.
    fn fitting(&mut self, part: &[Component]) -> Option<GrowingHull> {
        let step = part.len().div_ceil(MAX_COMPARED).max(1);
        let centres: Vec<Vector> = part.iter().step_by(step).map(|one| one.centre).collect();
        let is_separated = centres.iter().enumerate().any(|(index, &a)| {
            centres[..index].iter().any(|&b| self.solid.separates(a, b, self.bound))
        });
        if is_separated {
            return None;
        }
        let triangles = || part.iter().flat_map(|one| &one.triangles).copied();
        let points = self.mesh.positions_of(triangles());
        if let [a, b] = far_pair(&points)[..]
            && self.solid.separates(a, b, self.bound)
        {
            return None;
        }
        let normals = triangles().map(|triangle| {
            let [a, b, c] = self.mesh.corners(self.mesh.triangles[triangle as usize]);
            area_normal(a, b, c)
        });
        let outward = normals.fold(Vector::ZERO, |sum, normal| sum + normal);
        let hull = GrowingHull::new(&points, outward);
        self.tester.fits(&hull, false).then_some(hull)
    }
}
