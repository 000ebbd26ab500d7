//! Collapses that samples allow, and that can be taken back.
//!
//! Sums of what collapses move are several times the distance. Here the distance itself is
//! measured, at samples: from the source's vertices to the fan that takes the place of a star, and
//! from places on the fan to the source. A few of the collapses are beyond the bound all the same,
//! between samples. So each is logged with the triangles that it has changed: it can be taken back,
//! after those that have changed the same triangles later.
//!
//! The collapse that bends least is next. O(n log n) for n triangles.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use super::distance::Target;
use crate::bvh::Bvh;
use crate::bvh::closest_point::closest_point_on_triangle;
use crate::control::Control;
use crate::error::Error;
use crate::geometry::vector::{Vector, area_normal, centre, larger};

/// Neighbours that are tried for a vertex, those nearest to the planes around it first.
const MAX_TRIED: usize = 3;

/// A neighbour farther from a plane around the vertex than this multiple of the bound is not tried.
const HOPELESS: f64 = 4.0;

/// Least height of a new triangle over its longest side, as a fraction of the diagonal: the normal
/// of a thinner one is rounding.
const LEAST_HEIGHT: f64 = 1e-6;

/// A vertex of more triangles stays, and none gets more: a step is quadratic in them.
const MAX_STAR: usize = 48;

/// Collapses that are tried between two checks for cancellation.
const PER_CHECK: usize = 1024;

/// A triangle by its index, and its vertices.
type Indexed = (u32, [u32; 3]);

/// A collapse that was made.
struct Step {
    vertex: u32,
    /// The triangles that it has changed or removed, as they were.
    before: Vec<Indexed>,
    is_taken_back: bool,
}

/// A surface of which some triangles are gone.
pub(super) struct Guesses<'a> {
    points: &'a [Vector],
    source: &'a Target<'a>,
    limit: f64,
    /// All there were at first. Those that are gone have an old place.
    triangles: Vec<[u32; 3]>,
    is_left: Vec<bool>,
    /// The surface as it was at first.
    tree: Bvh,
    /// For each vertex the triangles apart from it that were near to it, where that is known:
    /// those of another sheet, as a wall behind its bricks.
    apart: Vec<Option<Vec<u32>>>,
    /// For each vertex its triangles.
    around: Vec<Vec<u32>>,
    /// For each triangle the vertices of the source, gone or not, that are near to it.
    over: Vec<Vec<u32>>,
    /// For each triangle one of the source that is near.
    near: Vec<u32>,
    /// For each triangle the steps that have changed it, in order.
    history: Vec<Vec<u32>>,
    steps: Vec<Step>,
    /// For each vertex whether a collapse of it was beyond the bound: it stays.
    is_refuted: Vec<bool>,
    /// How often something around a vertex has changed.
    versions: Vec<u32>,
    /// How much a collapse bends, its vertex and the neighbour, and the vertex's version.
    queue: BinaryHeap<Reverse<(u64, [u32; 2], u32)>>,
    fan: Vec<Indexed>,
    /// Samples over a star, and the triangles that they go to.
    placed: Vec<(u32, u32)>,
    /// Neighbours of a vertex, and how many triangles each has with it.
    ring: Vec<(u32, u32)>,
    beside: Vec<Indexed>,
}

impl<'a> Guesses<'a> {
    /// Before any collapse. For each vertex that is or was there `owners` has a triangle that it
    /// is near to, for each triangle `near` has one of the source.
    pub(super) fn new(
        (points, triangles): (&'a [Vector], Vec<[u32; 3]>),
        (source, limit): (&'a Target<'a>, f64),
        owners: &[u32],
        near: Vec<u32>,
    ) -> Self {
        let mut around = vec![Vec::new(); points.len()];
        for (index, triangle) in (0_u32..).zip(&triangles) {
            triangle.iter().for_each(|&vertex| around[vertex as usize].push(index));
        }
        let mut over = vec![Vec::new(); triangles.len()];
        for (vertex, &owner) in (0_u32..).zip(owners) {
            over[owner as usize].push(vertex);
        }
        let mut guesses = Self {
            points,
            source,
            limit,
            is_left: vec![true; triangles.len()],
            tree: Bvh::new(points, &triangles),
            apart: vec![None; points.len()],
            around,
            over,
            near,
            history: vec![Vec::new(); triangles.len()],
            steps: Vec::new(),
            is_refuted: vec![false; points.len()],
            versions: vec![0; points.len()],
            queue: BinaryHeap::new(),
            fan: Vec::new(),
            placed: Vec::new(),
            ring: Vec::new(),
            beside: Vec::new(),
            triangles,
        };
        for vertex in 0..points.len() as u32 {
            guesses.push(vertex);
        }
        guesses
    }

    /// How many triangles there were at first.
    pub(super) fn count(&self) -> usize {
        self.triangles.len()
    }

    /// The triangles that are left.
    pub(super) fn left(&self) -> impl Iterator<Item = u32> {
        (0..self.triangles.len() as u32).filter(|&triangle| self.is_left[triangle as usize])
    }

    pub(super) fn is_left(&self, triangle: u32) -> bool {
        self.is_left[triangle as usize]
    }

    pub(super) fn triangle(&self, triangle: u32) -> [u32; 3] {
        self.triangles[triangle as usize]
    }

    /// A triangle of the source that is near to one.
    pub(super) fn near(&self, triangle: u32) -> u32 {
        self.near[triangle as usize]
    }

    /// For each vertex that is or was there a triangle that it is near to.
    pub(super) fn owners(&self) -> Vec<u32> {
        let mut owners = vec![u32::MAX; self.points.len()];
        for (triangle, over) in (0_u32..).zip(&self.over) {
            over.iter().for_each(|&vertex| owners[vertex as usize] = triangle);
        }
        owners
    }

    /// The last step that has changed a triangle.
    pub(super) fn last_step(&self, triangle: u32) -> Option<u32> {
        self.history[triangle as usize].last().copied()
    }

    /// Takes a step back for good, after all later ones that have changed the same triangles.
    /// `changed` gets the triangles that are as they were before.
    pub(super) fn take_back(&mut self, step: u32, changed: &mut Vec<u32>) {
        self.is_refuted[self.steps[step as usize].vertex as usize] = true;
        let mut stack = vec![step];
        while let Some(&step) = stack.last() {
            let Step { before, is_taken_back, .. } = &mut self.steps[step as usize];
            if *is_taken_back {
                stack.pop();
                continue;
            }
            let last = before.iter().filter_map(|&(t, _)| self.history[t as usize].last()).max();
            if let Some(&later) = last.filter(|&&last| last > step) {
                stack.push(later);
                continue;
            }
            *is_taken_back = true;
            for (triangle, corners) in std::mem::take(before) {
                let index = triangle as usize;
                self.history[index].pop();
                if std::mem::replace(&mut self.is_left[index], true) {
                    for vertex in self.triangles[index] {
                        self.around[vertex as usize].retain(|&other| other != triangle);
                    }
                }
                self.triangles[index] = corners;
                corners.iter().for_each(|&v| self.around[v as usize].push(triangle));
                changed.push(triangle);
            }
        }
    }

    /// Lets the vertices of triangles collapse again.
    pub(super) fn open(&mut self, triangles: &[u32]) {
        let mut vertices: Vec<u32> =
            triangles.iter().flat_map(|&t| self.triangles[t as usize]).collect();
        vertices.sort_unstable();
        vertices.dedup();
        self.change(&vertices);
    }

    fn change(&mut self, vertices: &[u32]) {
        vertices.iter().for_each(|&vertex| self.versions[vertex as usize] += 1);
        vertices.iter().for_each(|&vertex| self.push(vertex));
    }

    /// Collapses what samples allow.
    ///
    /// # Errors
    /// [`Error::Cancelled`], [`Error::DeadlineExceeded`].
    pub(super) fn collapse(&mut self, control: &Control) -> Result<(), Error> {
        let mut count = 0_usize;
        while let Some(Reverse((_, [vertex, onto], version))) = self.queue.pop() {
            if version != self.versions[vertex as usize] {
                continue;
            }
            if count.is_multiple_of(PER_CHECK) {
                control.check()?;
            }
            count += 1;
            if self.is_allowed(vertex, onto) {
                let ring: Vec<u32> = self.ring.iter().map(|&(other, _)| other).collect();
                self.make(vertex, onto);
                self.versions[vertex as usize] += 1;
                self.change(&ring);
            }
        }
        Ok(())
    }

    fn corners(&self, corners: [u32; 3]) -> [Vector; 3] {
        corners.map(|vertex| self.points[vertex as usize])
    }

    /// Finds the neighbours of a vertex, in order.
    fn find_ring(&mut self, vertex: u32) {
        let Self { around, triangles, ring, .. } = self;
        ring.clear();
        for &triangle in &around[vertex as usize] {
            for other in triangles[triangle as usize].into_iter().filter(|&v| v != vertex) {
                match ring.iter_mut().find(|(known, _)| *known == other) {
                    Some((_, count)) => *count += 1,
                    None => ring.push((other, 1)),
                }
            }
        }
        ring.sort_unstable();
    }

    /// How many triangles the edges along which a vertex may go have; `None` if it has to stay.
    /// Where the surface ends, or more than two triangles meet, it goes along that line.
    fn edges_along(&self) -> Option<u32> {
        let mut lines = self.ring.iter().map(|&(_, count)| count).filter(|&count| count != 2);
        match (lines.next(), lines.next(), lines.next()) {
            (None, ..) => Some(2),
            (Some(first), Some(second), None) if first == second => Some(first),
            _ => None,
        }
    }

    /// Puts collapses of a vertex onto neighbours into the queue.
    fn push(&mut self, vertex: u32) {
        let count = self.around[vertex as usize].len();
        if count == 0 || count > MAX_STAR || self.is_refuted[vertex as usize] {
            return;
        }
        self.find_ring(vertex);
        let Some(along) = self.edges_along() else { return };
        let mut normals = [Vector::ZERO; MAX_STAR];
        for (normal, &triangle) in normals.iter_mut().zip(&self.around[vertex as usize]) {
            let [a, b, c] = self.corners(self.triangles[triangle as usize]);
            *normal = area_normal(a, b, c).normalize_or_zero();
        }
        let mut tried = [(f64::INFINITY, 0_u32); MAX_TRIED];
        for &(onto, _) in self.ring.iter().filter(|&&(_, count)| count == along) {
            let arm = self.points[onto as usize] - self.points[vertex as usize];
            let heights = normals[..count].iter().map(|normal| normal.dot(arm).abs());
            let mut candidate = (heights.fold(0.0, larger), onto);
            // The ring is in order: of equals the least vertex comes first.
            for better in &mut tried {
                if candidate.0 < better.0 {
                    std::mem::swap(better, &mut candidate);
                }
            }
        }
        let version = self.versions[vertex as usize];
        for (height, onto) in tried.into_iter().filter(|&(h, _)| h <= HOPELESS * self.limit) {
            self.queue.push(Reverse((height.to_bits(), [vertex, onto], version)));
        }
    }

    /// Whether a vertex may collapse onto a neighbour. Leaves the ring, the fan, and where samples
    /// go.
    fn is_allowed(&mut self, vertex: u32, onto: u32) -> bool {
        self.find_ring(vertex);
        if !self.keeps_topology(vertex, onto) {
            return false;
        }
        let Self { around, triangles, fan, .. } = self;
        fan.clear();
        for &triangle in &around[vertex as usize] {
            let corners = triangles[triangle as usize];
            if !corners.contains(&onto) {
                fan.push((triangle, corners.map(|v| if v == vertex { onto } else { v })));
            }
        }
        self.keeps_shape(onto) && self.are_samples_near(vertex) && self.is_fan_near(onto)
    }

    /// Whether closed components stay closed, and none vanishes: the link condition (Dey,
    /// Edelsbrunner, Guha, Nekhayev, "Topology preserving edge contraction", 1999).
    fn keeps_topology(&self, vertex: u32, onto: u32) -> bool {
        let count = self.around[vertex as usize].len();
        let common = |other: u32| {
            let mut around = self.around[other as usize].iter();
            around.any(|&triangle| self.triangles[triangle as usize].contains(&onto))
        };
        let Some(&(_, shared)) = self.ring.iter().find(|&&(other, _)| other == onto) else {
            return false;
        };
        let shared = shared as usize;
        let others = self.ring.iter().filter(|&&(other, _)| other != onto && common(other));
        shared < count
            && self.around[onto as usize].len() + count <= MAX_STAR + 2 * shared
            && others.count() == shared
    }

    /// Whether no triangle of the fan is thin, turned over, or there already.
    fn keeps_shape(&self, onto: u32) -> bool {
        self.fan.iter().all(|&(triangle, new)| {
            let [a, b, c] = self.corners(new);
            let longest = a.distance_squared(b).max(b.distance_squared(c));
            let longest = longest.max(c.distance_squared(a)).sqrt();
            let normal = area_normal(a, b, c);
            let [a, b, c] = self.corners(self.triangles[triangle as usize]);
            let is_there = |&other: &u32| {
                self.triangles[other as usize].iter().all(|corner| new.contains(corner))
            };
            normal.length() > LEAST_HEIGHT * longest
                && normal.dot(area_normal(a, b, c)) > 0.0
                && !self.around[onto as usize].iter().any(is_there)
        })
    }

    fn is_near(&self, vertex: u32, corners: [u32; 3]) -> bool {
        let place = self.points[vertex as usize];
        let [a, b, c] = self.corners(corners).map(|corner| corner - place);
        closest_point_on_triangle(a, b, c).length_squared() <= self.limit * self.limit
    }

    /// Whether all samples over the star are near to the fan, or to what stays.
    fn are_samples_near(&mut self, vertex: u32) -> bool {
        let mut placed = std::mem::take(&mut self.placed);
        let mut beside = std::mem::take(&mut self.beside);
        let mut apart = std::mem::take(&mut self.apart);
        placed.clear();
        beside.clear();
        // The vertex itself decides most.
        let is_near = self.fan.iter().any(|&(_, corners)| self.is_near(vertex, corners))
            || self.apart(vertex, vertex, &mut apart).is_some();
        let star = &self.around[vertex as usize];
        let mut first = 0;
        let is_allowed = is_near
            && star.iter().all(|&triangle| {
                first = self.fan.iter().position(|&(t, _)| t == triangle).unwrap_or(first);
                self.over[triangle as usize].iter().all(|&sample| {
                    let mut fan = self.fan[first..].iter().chain(&self.fan[..first]);
                    let found = fan.find(|&&(_, corners)| self.is_near(sample, corners));
                    let found = found.map(|&(triangle, _)| triangle);
                    let found = found.or_else(|| self.beside(sample, vertex, &mut beside));
                    let found = found.or_else(|| self.apart(sample, vertex, &mut apart));
                    placed.extend(found.map(|triangle| (sample, triangle)));
                    found.is_some()
                })
            });
        (self.placed, self.beside, self.apart) = (placed, beside, apart);
        is_allowed
    }

    /// A triangle beside the star of a vertex that is near to a sample.
    fn beside(&self, sample: u32, vertex: u32, beside: &mut Vec<Indexed>) -> Option<u32> {
        if beside.is_empty() {
            let around = self.ring.iter().flat_map(|&(other, _)| &self.around[other as usize]);
            let all = around.map(|&triangle| (triangle, self.triangles[triangle as usize]));
            beside.extend(all.filter(|(_, corners)| !corners.contains(&vertex)));
        }
        let found = beside.iter().position(|&(_, corners)| self.is_near(sample, corners))?;
        // The next sample is likely to be near to the same one.
        beside[..=found].rotate_right(1);
        Some(beside[0].0)
    }

    /// A triangle that was near to a sample at first, and is, apart from the star of a vertex.
    fn apart(&self, sample: u32, vertex: u32, known: &mut [Option<Vec<u32>>]) -> Option<u32> {
        let is_near = |&triangle: &u32| {
            let corners = self.triangles[triangle as usize];
            self.is_left(triangle) && !corners.contains(&vertex) && self.is_near(sample, corners)
        };
        let place = self.points[sample as usize];
        let near = known[sample as usize].get_or_insert_with(|| {
            let near = self.tree.triangles_near_box(place, place, self.limit);
            near.into_iter().filter(is_near).collect()
        });
        near.iter().copied().find(is_near)
    }

    /// Whether places on the fan are near to the source.
    fn is_fan_near(&mut self, onto: u32) -> bool {
        let apex = self.points[onto as usize];
        for &(triangle, corners) in &self.fan {
            let places = self.corners(corners);
            let middles = places.map(|corner| (corner + apex) * 0.5);
            let spokes = middles.into_iter().filter(|&middle| middle != apex);
            for place in spokes.chain([centre(places)]) {
                let near = &mut self.near[triangle as usize];
                match self.source.near(place, self.limit, *near) {
                    Some(found) => *near = found,
                    None => return false,
                }
            }
        }
        true
    }

    /// Makes the collapse that was allowed last.
    fn make(&mut self, vertex: u32, onto: u32) {
        let Self { triangles, is_left, history, around, over, .. } = self;
        let star = std::mem::take(&mut around[vertex as usize]);
        let before: Vec<Indexed> = star.iter().map(|&t| (t, triangles[t as usize])).collect();
        for &(triangle, corners) in &before {
            history[triangle as usize].push(self.steps.len() as u32);
            over[triangle as usize].clear();
            if corners.contains(&onto) {
                is_left[triangle as usize] = false;
                for corner in corners {
                    around[corner as usize].retain(|&other| other != triangle);
                }
            }
        }
        self.steps.push(Step { vertex, before, is_taken_back: false });
        for &(triangle, corners) in &self.fan {
            triangles[triangle as usize] = corners;
            around[onto as usize].push(triangle);
        }
        for &(sample, triangle) in &self.placed {
            over[triangle as usize].push(sample);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes::uv_sphere;

    #[test]
    fn steps_that_are_taken_back_leave_the_surface_as_it_was() {
        let sphere = uv_sphere(24, [0.0; 3], 0.5);
        let (points, triangles) = (sphere.points(), &sphere.triangles);
        let source = Target::new(Bvh::new(points, triangles), points, triangles);
        let mut owners = vec![0; points.len()];
        for (index, triangle) in (0..).zip(triangles) {
            triangle.iter().for_each(|&vertex| owners[vertex as usize] = index);
        }
        let near = (0..triangles.len() as u32).collect();
        let surface = (points, triangles.clone());
        let mut guesses = Guesses::new(surface, (&source, 0.02), &owners, near);
        guesses.collapse(&Control::new()).unwrap();
        assert!(4 * guesses.left().count() < triangles.len());
        assert!(guesses.owners().iter().all(|&owner| guesses.is_left(owner)));
        // The first one needs those after it, and what is taken back is not made again.
        let (steps, mut changed) = (guesses.steps.len() as u32, Vec::new());
        guesses.take_back(0, &mut changed);
        assert!(changed.len() > guesses.around[guesses.steps[0].vertex as usize].len());
        let refuted = guesses.steps[0].vertex;
        guesses.open(&changed);
        guesses.collapse(&Control::new()).unwrap();
        let later = &guesses.steps[steps as usize..];
        assert!(later.iter().all(|step| step.vertex != refuted));
        (0..guesses.steps.len() as u32).for_each(|step| guesses.take_back(step, &mut changed));
        assert_eq!(guesses.left().count(), triangles.len());
        assert_eq!(&guesses.triangles, triangles);
    }
}
