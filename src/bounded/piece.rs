//! A piece: the seeds that it stands for and their hull, which can go on growing.

use super::seed_set::SeedSet;
use super::seeds::Seed;
use super::solid::Solid;
use super::verdicts::{Key, Verdicts};
use crate::geometry::vector::{Vector, add, area_normal, length_squared, maximum, minimum};
use crate::hull::{HullBuilder, Shape, solid_hull};

/// Seeds and their hull.
#[derive(Debug, Clone)]
pub(crate) struct Piece {
    pub seeds: SeedSet,
    pub hull: Hull,
    /// Vertices of the hull, for those that join it; empty where nobody asks.
    pub vertices: Vec<Vector>,
}

/// The hull of some seeds' points.
#[derive(Debug, Clone, Default)]
pub(crate) struct Hull {
    /// Holds the hull if `is_solid`.
    pub builder: HullBuilder,
    pub is_solid: bool,
    /// All points, unless `is_solid`.
    pub points: Vec<Vector>,
    pub outward: Vector,
    pub min: Vector,
    pub max: Vector,
    pub volume: f64,
}

impl Hull {
    fn copy_from(&mut self, other: &Self) {
        self.builder.clone_from(&other.builder);
        self.is_solid = other.is_solid;
        self.points.clone_from(&other.points);
        self.outward = other.outward;
        self.min = other.min;
        self.max = other.max;
        self.volume = other.volume;
    }

    /// The vertices, or all points where there is no volume.
    pub fn vertices(&mut self) -> Vec<Vector> {
        if self.is_solid { self.builder.extract().0 } else { self.points.clone() }
    }

    /// The hull of the union with other points. Whether it had volume before, so that only its
    /// new faces differ.
    pub fn insert(&mut self, points: &[Vector], outward: Vector) -> bool {
        for &point in points {
            self.min = minimum(self.min, point);
            self.max = maximum(self.max, point);
        }
        self.outward = add(self.outward, outward);
        if self.is_solid {
            self.builder.insert_outside(points);
            return true;
        }
        self.points.extend_from_slice(points);
        self.is_solid = self.builder.build(&self.points) == Shape::Solid;
        if self.is_solid {
            self.builder.forget_inner_points();
            self.points.clear();
        }
        false
    }

    pub fn of(points: &[Vector], outward: Vector) -> Self {
        let mut hull = Self {
            builder: HullBuilder::new().with_least_tolerance(SEARCH_TOLERANCE),
            min: [f64::INFINITY; 3],
            max: [f64::NEG_INFINITY; 3],
            ..Self::default()
        };
        hull.insert(points, outward);
        hull.volume = hull.current_volume();
        hull
    }

    pub fn current_volume(&self) -> f64 {
        if self.is_solid { self.builder.volume() } else { 0.0 }
    }
}

/// Points nearer to a hull than this, in diagonals, don't change it during the search.
const SEARCH_TOLERANCE: f64 = 1e-5;

/// Thickness of flat pieces while they are tested, in diagonals.
const THICKNESS: f64 = 1e-6;

/// A face that has not been tested.
struct Unknown {
    size: f64,
    key: Key,
    face: [Vector; 3],
}

/// Memory for trying things out.
pub(crate) struct Workshop<'a> {
    pub solid: &'a Solid,
    pub bound: f64,
    /// A hull with something added, or the memory of one.
    trial: Hull,
    scratch: HullBuilder,
    faces: Vec<Unknown>,
    stack: Vec<[Vector; 3]>,
    points: Vec<Vector>,
    pub tried: usize,
}

impl<'a> Workshop<'a> {
    pub fn new(solid: &'a Solid, bound: f64) -> Self {
        Self {
            solid,
            bound,
            trial: Hull::of(&[], [0.0; 3]),
            scratch: HullBuilder::new(),
            faces: Vec::new(),
            stack: Vec::new(),
            points: Vec::new(),
            tried: 0,
        }
    }

    /// Whether a hull fits, of which only the new faces are asked if `only_new`.
    pub fn fits(&mut self, hull: &Hull, only_new: bool) -> bool {
        let mut faces = std::mem::take(&mut self.faces);
        faces.clear();
        let (verdicts, bound) = (&self.solid.verdicts, self.bound);
        let mut is_refused = false;
        // A face that is known not to fit saves all the others.
        let mut unknown = |mut face: [Vector; 3]| {
            // The same face is tested from the same corner on, whichever hull it belongs to.
            face.sort_unstable_by(|a, b| {
                a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])).then(a[2].total_cmp(&b[2]))
            });
            let key = Verdicts::key(face, bound);
            match verdicts.get(key) {
                Some(true) => {}
                Some(false) => is_refused = true,
                None => {
                    let [a, b, c] = face;
                    let size = length_squared(area_normal(a, b, c));
                    faces.push(Unknown { size, key, face });
                }
            }
            !is_refused
        };
        if hull.is_solid {
            if only_new {
                hull.builder.new_faces().all(&mut unknown);
            } else {
                hull.builder.all_faces().all(&mut unknown);
            }
        } else if let Ok((flat, _)) =
            solid_hull(&mut self.scratch, &hull.points, hull.outward, THICKNESS)
        {
            flat.corners().all(&mut unknown);
        }
        let holds = |&(point, _): &(Vector, f64)| hull.builder.farthest_outside(&[point]) <= 0.0;
        is_refused |= hull.is_solid && self.solid.cavities.iter().any(holds);
        let fits = !is_refused && self.faces_fit(&mut faces);
        self.faces = faces;
        fits
    }

    fn faces_fit(&mut self, faces: &mut [Unknown]) -> bool {
        // Large faces are the likeliest to stand out.
        faces.sort_unstable_by(|a, b| b.size.total_cmp(&a.size));
        let (solid, bound) = (self.solid, self.bound);
        let fits = |unknown: &Unknown, test: &mut dyn FnMut([Vector; 3]) -> bool| {
            let fits = test(unknown.face);
            if !fits {
                solid.verdicts.set(unknown.key, false);
            }
            fits
        };
        let stack = &mut self.stack;
        faces.iter().all(|face| fits(face, &mut |face| solid.centre_fits(face, bound)))
            && faces.iter().all(|face| {
                let whole = fits(face, &mut |face| solid.face_fits(face, bound, stack));
                if whole {
                    solid.verdicts.set(face.key, true);
                }
                whole
            })
    }

    /// Lets a hull take seeds if the joint hull fits.
    pub fn try_take<'s>(&mut self, hull: &mut Hull, seeds: impl Iterator<Item = &'s Seed>) -> bool {
        let mut points = std::mem::take(&mut self.points);
        points.clear();
        let mut outward = [0.0; 3];
        for seed in seeds {
            points.extend_from_slice(&seed.points);
            outward = add(outward, seed.outward);
        }
        self.tried += 1;
        let mut trial = std::mem::take(&mut self.trial);
        trial.copy_from(hull);
        let only_new = trial.insert(&points, outward);
        let fits = self.fits(&trial, only_new);
        if fits {
            std::mem::swap(hull, &mut trial);
        }
        self.trial = trial;
        self.points = points;
        fits
    }
}
