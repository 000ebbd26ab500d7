//! The solid that hulls must not protrude from.
//!
//! [`Solid::side`] says on which side of the surface a point is, [`Solid::closest`] how far it is
//! from it, and [`Solid::locate`] bounds both by the grid.

use std::sync::Arc;

use super::boundary::Boundary;
use super::grid::{Ball, Grid, Location, ROUNDING};
use super::surface::{Side, Surface};
use crate::bvh::Bvh;
use crate::bvh::closest_point::{ClosestPoint, EXACT};
use crate::control::Control;
use crate::error::Error;
use crate::geometry::vector::{Vector, bounds, spread_in_box};
use crate::mesh::simplification::Simplification;
use crate::parallel;
use crate::probe::{Extent, Probe, ProbeSettings};

/// Meshes of up to this many triangles are coarse: their patches follow from the shape, and large
/// faces are compared with the triangles near them. Denser ones are simplified.
pub(crate) const COARSE: usize = 2400;

/// No triangle of the solid is known to be near.
pub(super) const NO_GUESS: u32 = u32::MAX;

/// Points by which the volume is estimated that a probe does not reach: as many take a few
/// milliseconds.
const VOLUME_SAMPLES: usize = 1000;

/// The source mesh as a solid.
pub(crate) struct Solid {
    pub(super) grid: Grid,
    /// The bound that it is made for.
    pub bound: f64,
    pub(super) is_coarse: bool,
    /// How far its surface is from the source at most.
    pub moved: f64,
    /// The deepest point of each cavity that no hull may contain, and its distance from the
    /// surface.
    pub(crate) cavities: Vec<(Vector, f64)>,
    /// What moves in the scene, if that is known: what it does not reach may be filled.
    pub probe: Option<Probe>,
}

/// What a solid is made for.
#[derive(Clone, Copy)]
pub(crate) struct SolidSettings<'a> {
    pub bound: f64,
    /// Hulls that contain a cavity deeper than the bound do not fit.
    pub keep_cavities: bool,
    /// The solid is as this one sees it.
    pub probe: Option<&'a ProbeSettings>,
}

/// Bounds on how far a point outside protrudes.
pub(crate) struct Protruding {
    pub lower: f64,
    pub upper: f64,
}

impl Solid {
    /// The solid of a mesh. O(n log n) for n triangles, and a grid of at most 1.5 million cells.
    ///
    /// # Errors
    /// [`Error::Cancelled`]; [`Error::InvalidParameter`] where a probe can't start.
    pub fn new(
        surface: &Simplification,
        settings: &SolidSettings<'_>,
        control: &Control,
    ) -> Result<Self, Error> {
        let Simplification { mesh, closed, .. } = surface;
        let triangles = surface.triangles_of_solid();
        // Where triangles run along each edge as often one way as the other, the surface ends
        // nowhere, even where more than two meet. Sheets in both orientations can close an open
        // one.
        let is_as_given = triangles.len() == mesh.triangles.len();
        let boundary = match is_as_given && closed.iter().all(|&closed| closed) {
            true => Boundary::default(),
            false => Boundary::new(mesh.points(), &triangles),
        };
        let tree = Surface::new(mesh.points(), &triangles, boundary, control)?;
        Self::around(Arc::new(tree), surface, settings, control)
    }

    /// The solid of the same mesh with other settings. O(cells).
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn with_settings(
        &self,
        surface: &Simplification,
        settings: &SolidSettings<'_>,
        control: &Control,
    ) -> Result<Self, Error> {
        Self::around(Arc::clone(&self.grid.surface), surface, settings, control)
    }

    fn around(
        tree: Arc<Surface>,
        surface: &Simplification,
        &SolidSettings { bound, keep_cavities, probe }: &SolidSettings<'_>,
        control: &Control,
    ) -> Result<Self, Error> {
        let mesh = &surface.mesh;
        let mut solid = Self::plain(tree, mesh.points(), mesh.triangles.len(), bound);
        solid.moved = surface.most_moved();
        if keep_cavities {
            solid.cavities = solid.find_cavities(control)?;
        }
        if let Some(settings) = probe {
            settings.check_starts(solid.tree(), |point| solid.side(point) == Side::Inside)?;
            let bounds = bounds(mesh.points().iter().copied());
            solid.probe = Some(Probe::new(solid.tree(), bounds, settings, bound, control)?);
        }
        Ok(solid)
    }

    /// The solid of a surface, without cavities and a probe. `triangles` is the number that the
    /// mesh has.
    fn plain(surface: Arc<Surface>, positions: &[Vector], triangles: usize, bound: f64) -> Self {
        let grid = Grid::new(surface, positions, bound);
        let is_coarse = triangles <= COARSE;
        Self { grid, bound, is_coarse, moved: 0.0, cavities: Vec::new(), probe: None }
    }

    /// The solid of a surface and its boundary.
    #[cfg(test)]
    pub fn of_surface(
        positions: &[Vector],
        triangles: &[[u32; 3]],
        boundary: Boundary,
        bound: f64,
        control: &Control,
    ) -> Result<Self, Error> {
        let surface = Surface::new(positions, triangles, boundary, control)?;
        Ok(Self::plain(Arc::new(surface), positions, triangles.len(), bound))
    }

    /// Whether the surface encloses the inside: see [`Surface::is_closed`].
    #[inline]
    pub fn is_closed(&self) -> bool {
        self.surface().is_closed()
    }

    /// Whether it has so few triangles that a face may be compared with those near it.
    #[inline]
    pub fn is_coarse(&self) -> bool {
        self.is_coarse
    }

    #[inline]
    pub(super) fn tree(&self) -> &Bvh {
        &self.grid.surface.tree
    }

    #[inline]
    pub(super) fn surface(&self) -> &Surface {
        &self.grid.surface
    }

    /// The side of a point, by the surface. O(log n).
    #[inline]
    pub fn side(&self, point: Vector) -> Side {
        self.surface().side(point)
    }

    /// The radius of a ball around a point that is outside as a whole, and holds no surface; any
    /// radius below `least` if it is less than that. Where the surface is open, it may be less than
    /// the greatest one. O(log n).
    pub fn clearance(&self, point: Vector, least: f64) -> f64 {
        if let Some(Ball { side: Side::Inside, .. }) = self.grid.ball(point) {
            return 0.0;
        }
        let at = self.locate(point);
        if at.upper + ROUNDING < least {
            return 0.0;
        }
        let Some(closest) = self.closest(point, at.triangle()) else { return 0.0 };
        match closest.distance < least {
            true => 0.0,
            false => self.surface().clearance(point, closest.distance),
        }
    }

    /// The corners of the bounding box of the surface.
    pub fn bounds(&self) -> (Vector, Vector) {
        self.grid.bounds()
    }

    /// Bounds on the distance of a point from the surface, and its side, by the grid. O(1) once the
    /// point's cell is filled.
    #[inline]
    pub(super) fn locate(&self, point: Vector) -> Location<'_> {
        self.grid.locate(point)
    }

    /// The closest point of the surface. Faster if the triangle `guess` is near. `None` if there is
    /// no surface. O(log n).
    pub(crate) fn closest(&self, point: Vector, guess: u32) -> Option<ClosestPoint> {
        self.tree().closest_point_near(point, EXACT, guess)
    }

    /// The side of a point whose distance from the surface is known.
    #[inline]
    pub(super) fn side_at_distance(&self, point: Vector, at: &Location<'_>, distance: f64) -> Side {
        at.side_at_distance(distance).unwrap_or_else(|| self.side(point))
    }

    /// How far balls are entered at a point outside that is far from the surface: see
    /// [`Probe::entered`].
    pub(super) fn entered(&self, point: Vector, known: f64) -> Option<f64> {
        let probe = self.probe.as_ref()?;
        probe.entered(self.tree(), point, known, probe.radius)
    }

    /// Whether no ball is entered by more than `bound` at a point outside that is far from the
    /// surface.
    #[inline]
    pub(super) fn probe_allows(&self, point: Vector, bound: f64) -> bool {
        self.probe.as_ref().is_some_and(|probe| probe.allows(self.tree(), point, bound))
    }

    /// The same for all points of a part of a face. `false` if that is not known at once.
    pub(super) fn probe_allows_all(&self, part: impl FnOnce() -> Extent, bound: f64) -> bool {
        self.probe.as_ref().is_some_and(|probe| probe.allows_all(self.tree(), &part(), bound))
    }

    /// The volume outside the solid that a probe does not reach, in cubed diagonals, by evenly
    /// spread points in the box of the mesh. O(1) queries.
    pub fn unreachable_volume(&self) -> f64 {
        let Some(probe) = &self.probe else { return 0.0 };
        let (min, max) = probe.bounds;
        let is_out_of_reach = parallel::map_indices(VOLUME_SAMPLES, |index| {
            let point = spread_in_box(index, min, max);
            self.side(point) == Side::Outside && !probe.reaches(self.tree(), point)
        });
        let count = is_out_of_reach.into_iter().filter(|&is| is).count();
        (max - min).element_product() * count as f64 / VOLUME_SAMPLES as f64
    }

    /// No point of a part is farther than this from the surface, or balls are entered no farther
    /// there. The distance of the part's centre and how far balls are entered there are given.
    pub(super) fn upper_around(&self, distance: f64, entered: Option<f64>, radius: f64) -> f64 {
        let entered = entered.zip(self.probe.as_ref());
        let entered = entered.and_then(|(entered, probe)| probe.entered_around(entered, radius));
        entered.map_or(f64::INFINITY, |entered| entered.max(0.0)).min(distance + radius)
    }

    /// How far a point outside protrudes, if that may be more than `least`.
    pub fn outside(&self, point: Vector, least: f64) -> Option<Protruding> {
        let at = self.locate(point);
        if at.upper + ROUNDING <= least {
            return None;
        }
        let distance = self.closest(point, NO_GUESS)?.distance;
        if distance <= least || self.side_at_distance(point, &at, distance) == Side::Inside {
            return None;
        }
        let Some(probe) = &self.probe else {
            return Some(Protruding { lower: distance, upper: distance });
        };
        let entered = probe.entered(self.tree(), point, 0.0, probe.radius);
        // Where balls are entered too far, they are by half their radius at least.
        let lower = distance.min(entered.unwrap_or(probe.most_entered()));
        let upper = distance.min(entered.unwrap_or(f64::INFINITY));
        (upper > least).then_some(Protruding { lower, upper })
    }

    /// Whether a point is in the solid or at most `bound` away from it, or no ball is entered there
    /// by more.
    #[inline]
    pub fn point_fits(&self, point: Vector, bound: f64) -> bool {
        self.is_within(point, bound) || self.probe_allows(point, bound)
    }

    #[inline]
    fn is_within(&self, point: Vector, bound: f64) -> bool {
        match self.grid.ball(point) {
            Some(Ball { side: Side::Inside, .. }) => return true,
            Some(Ball { radius, .. }) if radius > bound => return false,
            _ => {}
        }
        let at = self.locate(point);
        if at.upper <= bound {
            return true;
        }
        let is_within = || self.tree().is_within(point, bound);
        match at.side() {
            Some(Side::Inside) => true,
            Some(Side::Outside) => at.lower <= bound && is_within(),
            None => is_within() || self.side(point) == Side::Inside,
        }
    }

    /// Whether the point halfway between two others does not fit, so that no hull that fits
    /// contains both. Points at a quarter of the way find more conflicts, and save no hulls.
    pub fn separates(&self, a: Vector, b: Vector, bound: f64) -> bool {
        !self.point_fits((a + b) * 0.5, bound)
    }

    /// Cavities: empty space that is cut off from the outside, or connected to it only through
    /// mouths narrower than twice the bound. The deepest point of each: outside the solid, farther
    /// than the bound from the surface, and without a path to infinity through such points, at the
    /// grid's resolution; and its distance.
    ///
    /// A hull whose surface passes through a cavity protrudes and is refused. But a hull may
    /// swallow a cavity whole: one point of each is enough to detect that. O(cells).
    fn find_cavities(&self, control: &Control) -> Result<Vec<(Vector, f64)>, Error> {
        let grid = &self.grid;
        let is_free = grid.free_cells(self.bound);
        control.check()?;
        let mut is_reached: Vec<bool> = is_free.iter().map(|free| !free).collect();
        let mut flood = |start: usize| {
            let mut reached = Vec::new();
            if !std::mem::replace(&mut is_reached[start], true) {
                reached.push(start);
            }
            let mut next = 0;
            while let Some(&cell) = reached.get(next) {
                next += 1;
                for neighbour in grid.neighbours(cell).into_iter().flatten() {
                    if !std::mem::replace(&mut is_reached[neighbour], true) {
                        reached.push(neighbour);
                    }
                }
            }
            reached
        };
        // The grid's border is outside the mesh.
        for cell in (0..is_free.len()).filter(|&cell| grid.neighbours(cell).contains(&None)) {
            flood(cell);
        }
        let mut cavities = Vec::new();
        for start in 0..is_free.len() {
            control.check()?;
            let points = flood(start).into_iter().map(|cell| grid.centre_of(cell));
            let deepest = points
                .filter_map(|point| Some((point, self.closest(point, NO_GUESS)?.distance)))
                .max_by(|a, b| a.1.total_cmp(&b.1));
            cavities.extend(deepest.filter(|&(point, _)| self.side(point) == Side::Outside));
        }
        Ok(cavities)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::canonical_order::MeshOrder;
    use crate::mesh::repair::prepare;
    use crate::mesh::shapes::{hemisphere, torus};

    #[test]
    fn with_other_settings_a_solid_answers_as_a_new_one() {
        let control = Control::new();
        for mesh in [torus(24, 12), hemisphere(10)] {
            let prepared = prepare(mesh.view(), MeshOrder::Place, &control).unwrap();
            let [first, other] =
                [0.01, 0.04].map(|bound| SolidSettings { bound, keep_cavities: true, probe: None });
            let surface = Simplification::unchanged(&prepared);
            let solid = Solid::new(&surface, &first, &control).unwrap();
            let changed = solid.with_settings(&surface, &other, &control).unwrap();
            let anew = Solid::new(&surface, &other, &control).unwrap();
            assert_eq!(changed.cavities, anew.cavities);
            let (low, high) = bounds(prepared.mesh.points().iter().copied());
            for index in 0..2000 {
                let point = spread_in_box(index, low, high);
                assert_eq!(changed.side(point), anew.side(point));
                let [by_grid, expected] = [&changed, &anew].map(|solid| solid.locate(point).upper);
                assert_eq!(by_grid, expected, "{point:?}");
            }
        }
    }
}
