//! The solid that hulls must not protrude from.
//!
//! [`Solid::side`] and [`Solid::locate`] say what a point is to its surface; [`Solid::measure`] how far the source is.
//! Where the mesh was clustered, the surface is that of the reduced mesh, and distances to the source follow from it.

use std::sync::Arc;

use super::boundary::Boundary;
use super::grid::{Ball, Grid, Location, ROUNDING};
use super::surface::{Side, Surface};
use crate::bvh::Bvh;
use crate::bvh::closest_point::EXACT;
use crate::clustering::Clustered;
use crate::control::Control;
use crate::error::Error;
use crate::geometry::vector::{Vector, bounds, spread_in_box};
use crate::mesh::PreparedMesh;
use crate::parallel;
use crate::probe::{Extent, Probe, ProbeSettings};

/// Meshes of up to this many triangles are coarse: their patches follow from the shape, and large faces are compared
/// with the triangles near them. Denser ones are simplified.
pub(crate) const COARSE: usize = 2400;

/// Points by which the volume is estimated that a probe does not reach: as many take a few milliseconds.
const VOLUME_SAMPLES: usize = 1000;

/// The source mesh as a solid, or a reduced one that represents it.
pub(crate) struct Solid {
    pub(super) grid: Grid,
    pub(super) is_coarse: bool,
    /// The deepest point of each cavity that no hull may contain, and its distance from the surface.
    pub(super) cavities: Vec<(Vector, f64)>,
    /// Where the solid is that of a reduced mesh: what it represents.
    pub clustered: Option<Arc<Clustered>>,
    /// See [`displacement`](Self::displacement): 0 unless the surface stands for the source.
    pub(super) displacement: f64,
    /// What moves in the scene, if that is known: what it does not reach may be filled.
    pub probe: Option<Probe>,
}

/// What a solid is made for.
pub(crate) struct SolidSettings<'a> {
    pub bound: f64,
    /// Hulls that contain a cavity deeper than the bound do not fit.
    pub keep_cavities: bool,
    /// The solid is as this one sees it.
    pub probe: Option<&'a ProbeSettings>,
}

/// Bounds on the distance between a point and the source.
pub(crate) struct SourceDistance {
    /// At least the distance.
    pub upper: f64,
    /// At most the depth, if the point is inside the source or that near to it.
    pub lower: f64,
    /// The distance from the solid's own surface.
    pub(super) own: f64,
    /// A triangle of the source within `upper`.
    triangle: u32,
}

impl Solid {
    /// The solid of a mesh, or of the reduced mesh if there is one. O(n log n) for n triangles, and a grid of at most 1.5
    /// million cells.
    ///
    /// # Errors
    /// [`Error::Cancelled`]; [`Error::InvalidParameter`] where a probe can't start.
    pub fn new(
        prepared: &PreparedMesh,
        clustered: Option<Arc<Clustered>>,
        &SolidSettings { bound, keep_cavities, probe }: &SolidSettings<'_>,
        control: &Control,
    ) -> Result<Self, Error> {
        let mut solid = Self::without_probe(prepared, clustered, bound, keep_cavities, control)?;
        if let Some(settings) = probe {
            let (tree, displacement) = (solid.tree(), solid.displacement);
            let is_inside = |point| solid.side(point) == Side::Inside;
            settings.check_starts(tree, displacement, is_inside)?;
            let bounds = bounds(prepared.mesh.points().iter().copied());
            let probe = Probe::new(tree, bounds, settings, displacement, bound, control)?;
            solid.probe = Some(probe);
        }
        Ok(solid)
    }

    fn without_probe(
        prepared: &PreparedMesh,
        clustered: Option<Arc<Clustered>>,
        bound: f64,
        keep_cavities: bool,
        control: &Control,
    ) -> Result<Self, Error> {
        if let Some(clustered) = clustered {
            let (mesh, boundary) = (&clustered.mesh, Boundary::default());
            let solid = Self::of_surface(mesh.points(), &mesh.triangles, boundary, bound, control)?;
            let displacement = clustered.displacement;
            let clustered = Some(clustered);
            return Ok(Self { clustered, displacement, is_coarse: false, ..solid });
        }
        let mesh = &prepared.mesh;
        let triangles = prepared.triangles_of_solid();
        // Where triangles run along each edge as often one way as the other, the surface ends nowhere,
        // even where more than two meet. Sheets in both orientations can close an open one.
        let is_as_given = triangles.len() == mesh.triangles.len();
        let boundary = match is_as_given && prepared.closed.iter().all(|&closed| closed) {
            true => Boundary::default(),
            false => Boundary::new(mesh.points(), &triangles),
        };
        let mut solid = Self::of_surface(mesh.points(), &triangles, boundary, bound, control)?;
        solid.is_coarse = mesh.triangles.len() <= COARSE;
        if keep_cavities {
            solid.cavities = solid.cavities(bound, control)?;
        }
        Ok(solid)
    }

    /// The solid of a surface and its boundary.
    ///
    /// # Errors
    /// [`Error::Cancelled`].
    pub fn of_surface(
        positions: &[Vector],
        triangles: &[[u32; 3]],
        boundary: Boundary,
        bound: f64,
        control: &Control,
    ) -> Result<Self, Error> {
        let tree = Bvh::with_control(positions, triangles, control)?;
        let surface = Surface { tree, boundary };
        if !surface.is_closed() {
            surface.tree.expect_winding_numbers(control)?;
        }
        Ok(Self {
            grid: Grid::new(surface, positions, bound),
            is_coarse: triangles.len() <= COARSE,
            cavities: Vec::new(),
            clustered: None,
            displacement: 0.0,
            probe: None,
        })
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

    /// No point of the solid's own surface is farther than this from the source, and what is inside the solid is
    /// inside the source or no farther outside.
    pub fn displacement(&self) -> f64 {
        self.displacement
    }

    /// The side of a point, by the surface. O(log n).
    #[inline]
    pub fn side(&self, point: Vector) -> Side {
        self.surface().side(point)
    }

    /// Bounds on the distance of a point from the solid's own surface, and its side, by the grid. O(1) once the
    /// point's cell is filled.
    #[inline]
    pub(super) fn locate(&self, point: Vector) -> Location<'_> {
        self.grid.locate(point)
    }

    /// Bounds on the distance of a point from the source. `guess` is a triangle of the solid that may be near
    /// and makes it faster. `None` if the solid has no surface. O(log n).
    pub(super) fn measure(&self, point: Vector, guess: u32) -> Option<SourceDistance> {
        let closest = self.tree().closest_point_near(point, EXACT, guess)?;
        let (own, triangle) = (closest.distance, closest.triangle);
        let (upper, triangle) = match &self.clustered {
            None => (own + self.displacement, triangle),
            Some(clustered) => {
                clustered.closest_around(clustered.mesh.triangles[triangle as usize], point, own)
            }
        };
        Some(SourceDistance { upper, lower: own - self.displacement(), own, triangle })
    }

    /// The side of a measured point. Inside the source it is inside, or not farther outside than
    /// [`displacement`](Self::displacement).
    #[inline]
    pub(super) fn side_of_measured(
        &self,
        point: Vector,
        at: &Location<'_>,
        distance: &SourceDistance,
    ) -> Side {
        at.side_at_distance(distance.own).unwrap_or_else(|| self.side(point))
    }

    /// How far balls are entered at a point outside that is far from the surface: see [`Probe::entered`].
    pub(super) fn entered(&self, point: Vector, known: f64) -> Option<f64> {
        let probe = self.probe.as_ref()?;
        probe.entered(self.tree(), point, known, probe.radius)
    }

    /// Whether no ball is entered by more than `bound` at a point outside that is far from the surface.
    #[inline]
    pub(super) fn probe_allows(&self, point: Vector, bound: f64) -> bool {
        self.probe.as_ref().is_some_and(|probe| probe.allows(self.tree(), point, bound))
    }

    /// The same for all points of a part of a face. `false` if that is not known at once.
    pub(super) fn probe_allows_all(&self, part: impl FnOnce() -> Extent, bound: f64) -> bool {
        self.probe.as_ref().is_some_and(|probe| probe.allows_all(self.tree(), &part(), bound))
    }

    /// The volume outside the solid that a probe does not reach, in cubed diagonals, by evenly spread points in the box
    /// of the mesh. O(1) queries.
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

    /// No point of a part is farther than this from the source, or balls are entered no farther there. The distance
    /// from the part's centre and how far balls are entered there are given.
    pub(super) fn upper_around(&self, upper: f64, entered: Option<f64>, radius: f64) -> f64 {
        let entered = entered.zip(self.probe.as_ref());
        let entered = entered.and_then(|(entered, probe)| probe.entered_around(entered, radius));
        entered.map_or(f64::INFINITY, |entered| entered.max(0.0)).min(upper + radius)
    }

    /// Bounds on the protrusion of a point outside, if it may be more than `least`.
    pub fn outside(&self, point: Vector, least: f64) -> Option<SourceDistance> {
        let mut distance = self.outside_source(point, least)?;
        if let Some(probe) = &self.probe {
            let entered = probe.entered(self.tree(), point, 0.0, probe.radius);
            // Where balls are entered too far, they are by half their radius at least.
            distance.lower = distance.lower.min(entered.unwrap_or(probe.most_entered()));
            distance.upper = distance.upper.min(entered.unwrap_or(f64::INFINITY));
        }
        (distance.upper > least).then_some(distance)
    }

    /// Bounds on the distance from the source to a point outside, if it may be more than `least`.
    fn outside_source(&self, point: Vector, least: f64) -> Option<SourceDistance> {
        let at = self.locate(point);
        if at.upper + ROUNDING + self.displacement() <= least {
            return None;
        }
        let distance = self.measure(point, u32::MAX)?;
        let is_outside = || self.side_of_measured(point, &at, &distance) == Side::Outside;
        (distance.upper > least && is_outside()).then_some(distance)
    }

    /// No point of a face is farther than this from the source, by the triangle that is near one of them.
    pub(super) fn upper_of_face(&self, face: [Vector; 3], distance: &SourceDistance) -> f64 {
        let triangle = distance.triangle;
        match &self.clustered {
            None => self.grid.upper_to_triangle(face, triangle) + self.displacement,
            Some(clustered) => {
                let [a, b, c] = face.map(|corner| clustered.squared_distance_to(corner, triangle));
                a.max(b).max(c).sqrt()
            }
        }
    }

    /// Whether a point is in the solid or at most `bound` away from it, or no ball is entered there by more.
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

    /// Whether the point halfway between two others does not fit, so that no hull that fits contains
    /// both. Points at a quarter of the way find more conflicts, and save no hulls.
    pub fn separates(&self, a: Vector, b: Vector, bound: f64) -> bool {
        !self.point_fits((a + b) * 0.5, bound)
    }

    /// Cavities: empty space that is cut off from the outside, or connected to it only through mouths
    /// narrower than twice the bound. The deepest point of each: outside the solid, farther than `bound` from the
    /// surface, and without a path to infinity through such points, at the grid's resolution; and its distance.
    ///
    /// A hull whose surface passes through a cavity protrudes and is refused. But a hull may swallow a cavity whole: one
    /// point of each is enough to detect that. O(cells).
    fn cavities(&self, bound: f64, control: &Control) -> Result<Vec<(Vector, f64)>, Error> {
        let grid = &self.grid;
        let is_free = grid.free_cells(bound);
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
                .filter_map(|point| Some((point, self.measure(point, u32::MAX)?.own)))
                .max_by(|a, b| a.1.total_cmp(&b.1));
            cavities.extend(deepest.filter(|&(point, _)| self.side(point) == Side::Outside));
        }
        Ok(cavities)
    }
}
