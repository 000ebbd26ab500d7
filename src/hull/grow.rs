//! The steps of quickhull: the farthest waiting point is added, and the faces that it sees make way for
//! a cone.
//!
//! All of them are small, so that what counts is the number of instructions: no roots, no
//! divisions, few questions asked twice.

use super::builder::HullBuilder;
use super::face::{
    Face, Given, Horizon, NONE, RETIRED, Waiting, after, before, edge_of, face_of, half_edge,
};
use super::waiting_points::{InFront, in_front_of, inverse_root};
use crate::geometry::vector::{Vector, length_squared};

impl HullBuilder {
    /// Adds waiting points until none is farther out than the tolerance.
    pub(super) fn grow(&mut self) {
        loop {
            // In turn, so that the hull grows on all sides: the latest first would make more faces
            // that don't stay.
            let mut next = 0;
            while let Some(&face) = self.work.get(next) {
                next += 1;
                let Some(&Waiting { furthest, height, .. }) = self.waiting.get(face as usize)
                else {
                    continue;
                };
                if furthest != NONE {
                    if height > self.heights.error || self.is_seen(face, furthest) {
                        self.add(furthest, face);
                    } else {
                        self.send_elsewhere(furthest, face);
                    }
                }
            }
            self.work.clear();
            if self.only_marked
                || !self.has_close_points
                || !(self.add_a_point_that_other_faces_see()
                    || self.add_points_beyond_sharp_edges())
            {
                self.close_gaps();
                self.measure_new_faces();
                return;
            }
        }
    }

    /// Whether a point is farther in front of a face than the tolerance.
    fn is_beyond(&self, face: u32, position: Vector) -> bool {
        let face = &self.faces[face as usize];
        self.heights.is_beyond(face.plane.height(position), &face.plane)
    }

    /// Whether a point lies strictly in front of a face, exactly.
    pub(super) fn is_seen(&self, face: u32, point: u32) -> bool {
        let given = self.given();
        let face = &self.faces[face as usize];
        let height = face.plane.height(self.points[point as usize]);
        face.sees(point, height, given, self.heights)
    }

    /// A sliver's plane is so uncertain that a point may wait there in vain.
    #[cold]
    fn send_elsewhere(&mut self, point: u32, face: u32) {
        let unwanted = &mut self.waiting[face as usize];
        let mut next = unwanted.first;
        *unwanted = Waiting::none(unwanted.stamp, unwanted.generation);
        while next != NONE {
            let current = next;
            next = self.next_waiting[current as usize];
            if current != point {
                self.planes.clear();
                self.planes.push(self.faces[face as usize].plane);
                let position = self.points[current as usize];
                if let Some(found) = in_front_of(position, &self.planes, self.heights) {
                    self.attach(current, InFront { face, ..found });
                }
            }
        }
        let position = self.points[point as usize];
        let seen = (0..self.faces.len() as u32)
            .filter(|&other| other != face)
            .find(|&other| self.is_beyond(other, position) && self.is_seen(other, point));
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

    /// Begins a walk from face to face; `visible` holds those to go on from.
    pub(super) fn begin_walk(&mut self, start: u32) {
        self.stamp += 1;
        self.waiting[start as usize].stamp = self.stamp;
        self.visible.clear();
        self.visible.push(start);
    }

    /// Whether a walk comes to a face for the first time.
    #[inline]
    pub(super) fn is_new_to_walk(&mut self, face: u32) -> bool {
        let waiting = &mut self.waiting[face as usize];
        let is_new = waiting.stamp != self.stamp;
        waiting.stamp = self.stamp;
        is_new
    }

    fn farther_face_in_sight(&mut self, point: u32, start: u32) -> Option<u32> {
        let position = self.points[point as usize];
        self.begin_walk(start);
        while let Some(face) = self.visible.pop() {
            for twin in self.faces[face as usize].twins {
                let neighbour = face_of(twin);
                if !self.is_new_to_walk(neighbour) {
                    continue;
                }
                // A sliver's plane may lie: only the exact answer makes progress certain.
                if self.is_beyond(neighbour, position) && self.is_seen(neighbour, point) {
                    return Some(neighbour);
                }
                let face = &self.faces[neighbour as usize];
                if self.heights.is_in_front(face.plane.height(position), &face.plane) {
                    self.visible.push(neighbour);
                }
            }
        }
        None
    }

    /// Replaces the faces that a point sees by faces between their outline and the point.
    pub(super) fn add(&mut self, point: u32, seen_from: u32) {
        self.find_horizon(point, seen_from);
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
        self.raise_cone(point);
        self.share_out(point);
    }

    /// Collects the faces that a point sees, the points that wait there, and the outline in order.
    fn find_horizon(&mut self, point: u32, seen_from: u32) {
        let position = self.points[point as usize];
        self.stamp += 1;
        let (stamp, heights) = (self.stamp, self.heights);
        // Borrowed one by one, so that the compiler need not look them up again and again.
        let faces = self.faces.as_slice();
        let given = Given { points: &self.originals, factor: self.factor };
        let waiting = self.waiting.as_mut_slice();
        let (visible, path) = (&mut self.visible, &mut self.path);
        let (horizon, lines) = (&mut self.horizon, &mut self.lines);
        let mut is_flat = false;
        visible.clear();
        horizon.clear();
        path.clear();
        lines.clear();
        let state = &mut waiting[seen_from as usize];
        state.stamp = stamp;
        lines.push(state.first);
        visible.push(seen_from);
        let [first, second, third] = faces[seen_from as usize].twins;
        path.extend([third, second]);
        // The way that is taken next need not go through the list of those that are left.
        let mut ahead = Some(first);
        while let Some(twin) = ahead {
            let other = face_of(twin);
            let state = &mut waiting[other as usize];
            if state.stamp == stamp {
                ahead = path.pop();
                continue;
            }
            let neighbour = &faces[other as usize];
            let height = neighbour.plane.height(position);
            let is_seen = if height > heights.high {
                true
            } else if height < -heights.high {
                false
            } else {
                is_flat |= !heights.is_beyond(height.abs(), &neighbour.plane);
                if height.abs() > heights.error {
                    height > 0.0
                } else {
                    neighbour.sees(point, height, given, heights)
                }
            };
            let at = edge_of(twin);
            if is_seen {
                state.stamp = stamp;
                if state.first != NONE {
                    lines.push(state.first);
                }
                visible.push(other);
                path.push(neighbour.twins[before(at)]);
                ahead = Some(neighbour.twins[after(at)]);
            } else {
                let [start, end] = [neighbour.vertices[after(at)], neighbour.vertices[at]];
                horizon.push(Horizon { start, end, outside: twin });
                ahead = path.pop();
            }
        }
        self.has_flat_places |= is_flat;
    }

    /// Puts a face between each edge of the horizon and the point.
    fn raise_cone(&mut self, point: u32) {
        let position = self.points[point as usize];
        let (stamp, generation) = (self.stamp, self.generation);
        self.planes.clear();
        let (faces, waiting) = (self.faces.as_mut_slice(), self.waiting.as_mut_slice());
        let given = Given { points: &self.originals, factor: self.factor };
        let visible = self.visible.as_slice();
        let (Some(&first), Some(&last)) = (visible.first(), visible.last()) else { return };
        let Some(&Horizon { start, .. }) = self.horizon.first() else { return };
        // The horizon is in order: each edge ends where the next one starts.
        let mut edge = given.edge(point, start);
        let mut place = first;
        let mut previous = last;
        for (index, &Horizon { start, end, outside }) in self.horizon.iter().enumerate() {
            let next = visible.get(index + 1).copied().unwrap_or(first);
            let next_edge = given.edge(point, end);
            let mut face = Face::spanned([start, end, point], [edge, next_edge], position);
            face.twins = [outside, half_edge(next, 2), half_edge(previous, 1)];
            faces[face_of(outside) as usize].twins[edge_of(outside)] = half_edge(place, 0);
            waiting[place as usize] = Waiting::none(stamp, generation);
            faces[place as usize] = face;
            self.planes.push(face.plane);
            (previous, place, edge) = (place, next, next_edge);
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

    /// Inverse lengths of normals, for the faces that have come to stay.
    fn measure_new_faces(&mut self) {
        let generation = self.generation;
        let is_new = |waiting: &Waiting| waiting.generation == generation;
        let faces = self.faces.iter().zip(&self.waiting);
        let new = faces.filter(|(_, waiting)| is_new(waiting)).map(|(face, _)| face);
        self.inverses.clear();
        self.inverses.extend(new.map(|face| length_squared(face.plane.normal)));
        for square in &mut self.inverses {
            *square = inverse_root(*square);
        }
        let faces = self.faces.iter_mut().zip(&self.waiting);
        let new = faces.filter(|(_, waiting)| is_new(waiting)).map(|(face, _)| face);
        for (face, &inverse) in new.zip(&self.inverses) {
            face.inverse = inverse;
        }
    }
}
