//! The steps of quickhull: points wait in front of faces, the furthest is added, the faces that
//! it sees make way for a cone.

use super::HullBuilder;
use super::face::{
    Face, NONE, RETIRED, Waiting, after, before, edge_of, face_of, half_edge, is_in_front,
};
use crate::vector::{Vector, subtract};

/// A point this far behind a face, as a share of the extent, is certainly not in front of it.
/// Closer ones are kept until all faces are known.
const CERTAINLY_BEHIND: f64 = 1e-12;

/// An edge between a face that a new point sees and one that it does not.
#[derive(Debug, Clone, Copy)]
pub(super) struct Horizon {
    start: u32,
    end: u32,
    /// The edge in the face that stays.
    outside: u32,
}

impl HullBuilder {
    /// The tetrahedron over four points in general position.
    pub(super) fn start(&mut self, [a, b, c, d]: [u32; 4]) {
        let corner = |vertex: u32| self.points[vertex as usize];
        let base = [corner(a), corner(b), corner(c)];
        // Turned so that d lies behind the base.
        let (b, c) = if is_in_front(base, corner(d)) { (c, b) } else { (b, c) };
        let triangles = [[a, b, c], [a, c, d], [c, b, d], [b, a, d]];
        // Edge k of each face and the same edge of its neighbour.
        let twins = [
            [(3, 0), (2, 0), (1, 0)],
            [(0, 2), (2, 2), (3, 1)],
            [(0, 1), (3, 2), (1, 1)],
            [(0, 0), (1, 2), (2, 1)],
        ];
        for (vertices, twins) in triangles.into_iter().zip(twins) {
            let mut face = Face::new(vertices, &self.points);
            face.twins = twins.map(|(other, edge)| half_edge(other, edge));
            self.faces.push(face);
            self.waiting.push(Waiting::none(0, 0));
        }
    }

    /// The first face that a point is farther in front of than the tolerance.
    #[inline]
    pub(super) fn first_face_in_front(&self, position: Vector) -> Option<(u32, f64)> {
        for (index, face) in self.faces.iter().enumerate() {
            let distance = face.distance(position);
            if distance > self.threshold {
                return Some((index as u32, distance));
            }
        }
        None
    }

    /// Lets a point wait in front of the first face that it is in front of.
    pub(super) fn assign_to_any(&mut self, point: u32) {
        let position = self.points[point as usize];
        let mut best = (-CERTAINLY_BEHIND, NONE);
        for (index, face) in self.faces.iter().enumerate() {
            let distance = face.distance(position);
            if distance > best.0 {
                best = (distance, index as u32);
                if distance > self.threshold {
                    break;
                }
            }
        }
        let (distance, face) = best;
        if face != NONE {
            self.attach(point, face, distance);
        }
    }

    /// Lets a point wait in front of a face.
    #[inline]
    pub(super) fn attach(&mut self, point: u32, face: u32, distance: f64) {
        let waiting = &mut self.waiting[face as usize];
        self.next_waiting[point as usize] = waiting.first;
        waiting.first = point;
        self.has_close_points |= distance <= self.threshold;
        if distance > waiting.distance && !(self.only_marked && self.marks[point as usize] == NONE)
        {
            if distance > self.threshold && waiting.distance <= self.threshold {
                self.work.push(face);
            }
            waiting.distance = distance;
            waiting.furthest = point;
        }
    }

    /// Lets each of `orphans` wait in front of the first of the faces `visible` that it is in
    /// front of.
    pub(super) fn share_out(&mut self) {
        let orphans = std::mem::take(&mut self.orphans);
        let visible = std::mem::take(&mut self.visible);
        for &orphan in &orphans {
            let position = self.points[orphan as usize];
            let mut best = (-CERTAINLY_BEHIND, NONE);
            for &place in &visible {
                let distance = self.faces[place as usize].distance(position);
                if distance > best.0 {
                    best = (distance, place);
                    if distance > self.threshold {
                        break;
                    }
                }
            }
            if best.1 != NONE {
                self.attach(orphan, best.1, best.0);
            }
        }
        self.orphans = orphans;
        self.visible = visible;
    }

    /// Lets each waiting point count, marked or not.
    pub(super) fn consider_all_waiting(&mut self) {
        for index in 0..self.faces.len() {
            let mut point = self.waiting[index].first;
            while point != NONE {
                let distance = self.faces[index].distance(self.points[point as usize]);
                let waiting = &mut self.waiting[index];
                if distance > waiting.distance {
                    waiting.distance = distance;
                    waiting.furthest = point;
                }
                point = self.next_waiting[point as usize];
            }
            if self.waiting[index].distance > self.threshold {
                self.work.push(index as u32);
            }
        }
    }

    /// Adds waiting points until none is farther out than the tolerance.
    pub(super) fn grow(&mut self) {
        loop {
            while let Some(face) = self.work.pop() {
                let Some(&Waiting { furthest, distance, .. }) = self.waiting.get(face as usize)
                else {
                    continue;
                };
                if distance > self.threshold {
                    if self.is_seen(face, self.points[furthest as usize]) {
                        self.add(furthest, face);
                    } else {
                        self.send_elsewhere(furthest, face);
                    }
                }
            }
            if self.only_marked
                || !self.has_close_points
                || !self.add_a_point_that_other_faces_see()
            {
                self.close_gaps();
                return;
            }
        }
    }

    /// Whether a point lies strictly in front of a face, exactly.
    #[inline]
    fn is_seen(&self, face: u32, position: Vector) -> bool {
        let face = &self.faces[face as usize];
        let height = face.height(position);
        if height.abs() > self.certainty {
            height > 0.0
        } else {
            face.sees(position, &self.points, self.reach)
        }
    }

    /// A sliver's plane is so uncertain that a point may wait there in vain.
    #[cold]
    fn send_elsewhere(&mut self, point: u32, face: u32) {
        let unwanted = &mut self.waiting[face as usize];
        let mut next = unwanted.first;
        unwanted.first = NONE;
        unwanted.distance = 0.0;
        while next != NONE {
            let current = next;
            next = self.next_waiting[current as usize];
            if current != point {
                let distance = self.faces[face as usize].distance(self.points[current as usize]);
                if distance > -CERTAINLY_BEHIND {
                    self.attach(current, face, distance);
                }
            }
        }
        let position = self.points[point as usize];
        let seen = (0..self.faces.len() as u32).filter(|&other| other != face).find(|&other| {
            self.faces[other as usize].distance(position) > self.threshold
                && self.is_seen(other, position)
        });
        if let Some(other) = seen {
            self.add(point, other);
        }
    }

    /// A point within the tolerance of the face that it waits at may yet be farther from another
    /// one that it sees. Adds the first such point.
    fn add_a_point_that_other_faces_see(&mut self) -> bool {
        for face in 0..self.faces.len() as u32 {
            let mut point = self.waiting[face as usize].first;
            while point != NONE {
                if let Some(other) = self.farther_face_in_sight(point, face) {
                    self.add(point, other);
                    return true;
                }
                point = self.next_waiting[point as usize];
            }
        }
        false
    }

    fn farther_face_in_sight(&mut self, point: u32, start: u32) -> Option<u32> {
        let position = self.points[point as usize];
        self.stamp += 1;
        self.visible.clear();
        self.visible.push(start);
        self.waiting[start as usize].stamp = self.stamp;
        while let Some(face) = self.visible.pop() {
            for twin in self.faces[face as usize].twins {
                let neighbour = face_of(twin);
                let waiting = &mut self.waiting[neighbour as usize];
                if waiting.stamp == self.stamp {
                    continue;
                }
                waiting.stamp = self.stamp;
                let distance = self.faces[neighbour as usize].distance(position);
                // A sliver's plane may lie: only the exact answer makes progress certain.
                if distance > self.threshold && self.is_seen(neighbour, position) {
                    return Some(neighbour);
                }
                if distance > CERTAINLY_BEHIND {
                    self.visible.push(neighbour);
                }
            }
        }
        None
    }

    /// Replaces the faces that a point sees by faces between their outline and the point.
    fn add(&mut self, point: u32, seen_from: u32) {
        let position = self.points[point as usize];
        self.find_horizon(position, seen_from);
        self.orphans.clear();
        for &face in &self.visible {
            let mut waiting = self.waiting[face as usize].first;
            while waiting != NONE {
                if waiting != point {
                    self.orphans.push(waiting);
                }
                waiting = self.next_waiting[waiting as usize];
            }
        }
        // New faces take the places of those that vanish; `visible` becomes the list of places.
        let edges = self.horizon.len();
        while self.visible.len() > edges {
            if let Some(unused) = self.visible.pop() {
                self.faces[unused as usize] = RETIRED;
                self.waiting[unused as usize] = Waiting::none(0, 0);
                self.free.push(unused);
            }
        }
        while self.visible.len() < edges {
            let place = self.free.pop().unwrap_or(self.faces.len() as u32);
            if place as usize == self.faces.len() {
                self.faces.push(RETIRED);
                self.waiting.push(Waiting::none(0, 0));
            }
            self.visible.push(place);
        }
        self.raise_cone(point, position);
        self.share_out();
    }

    /// Puts a face between each edge of the horizon and the point.
    fn raise_cone(&mut self, point: u32, position: Vector) {
        let (Some(&last), Some(&first)) = (self.visible.last(), self.visible.first()) else {
            return;
        };
        let Some(&Horizon { start, .. }) = self.horizon.first() else { return };
        let mut previous = last;
        // The horizon is in order: each edge ends where the next one starts.
        let mut edge = subtract(self.points[start as usize], position);
        for (index, &Horizon { start, end, outside }) in self.horizon.iter().enumerate() {
            let place = self.visible[index];
            let next = self.visible.get(index + 1).copied().unwrap_or(first);
            let next_edge = subtract(self.points[end as usize], position);
            let mut face = Face::spanned([start, end, point], edge, next_edge, position);
            face.twins = [outside, half_edge(next, 2), half_edge(previous, 1)];
            self.faces[face_of(outside) as usize].twins[edge_of(outside)] = half_edge(place, 0);
            self.faces[place as usize] = face;
            self.waiting[place as usize] = Waiting::none(self.stamp, self.generation);
            previous = place;
            edge = next_edge;
        }
    }

    /// Closes the gaps that retired faces have left.
    fn close_gaps(&mut self) {
        self.free.sort_unstable();
        while let Some(gap) = self.free.pop() {
            self.faces.swap_remove(gap as usize);
            self.waiting.swap_remove(gap as usize);
            if let Some(moved) = self.faces.get(gap as usize).copied() {
                for (edge, twin) in (0..).zip(moved.twins) {
                    let neighbour = &mut self.faces[face_of(twin) as usize];
                    neighbour.twins[edge_of(twin)] = half_edge(gap, edge);
                }
            }
        }
    }

    /// Collects the faces that a point sees, and their outline in order.
    fn find_horizon(&mut self, position: Vector, seen_from: u32) {
        self.stamp += 1;
        self.visible.clear();
        self.horizon.clear();
        self.path.clear();
        self.waiting[seen_from as usize].stamp = self.stamp;
        self.visible.push(seen_from);
        self.path.extend([2, 1, 0].map(|edge| half_edge(seen_from, edge)));
        while let Some(edge) = self.path.pop() {
            let twin = self.faces[face_of(edge) as usize].twins[edge_of(edge)];
            let other = face_of(twin);
            if self.waiting[other as usize].stamp == self.stamp {
                continue;
            }
            let neighbour = &self.faces[other as usize];
            let height = neighbour.height(position);
            self.has_flat_places |= height.abs() * neighbour.inverse <= self.threshold;
            let is_seen = if height.abs() > self.certainty {
                height > 0.0
            } else {
                neighbour.sees(position, &self.points, self.reach)
            };
            let at = edge_of(twin);
            if is_seen {
                self.waiting[other as usize].stamp = self.stamp;
                self.visible.push(other);
                self.path.push(half_edge(other, before(at) as u32));
                self.path.push(half_edge(other, after(at) as u32));
            } else {
                let [start, end] = [neighbour.vertices[after(at)], neighbour.vertices[at]];
                self.horizon.push(Horizon { start, end, outside: twin });
            }
        }
    }
}
