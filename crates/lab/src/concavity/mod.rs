//! `cargo lab concavity`: how concave parts are that hulls stand for, as CoACD measures it (Wei,
//! Liu, Ling and Su 2022).
//!
//! A part is the solid within a hull, so that hulls may overlap. Its concavity is the larger of the
//! Hausdorff distance between its boundary and the hull's, and of k times the radius of a ball as
//! large as what the hull adds.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Command;

use hullwright::{Control, TriangleMesh, decompose};
use hullwright_formats::{read_hulls, read_mesh, write_hulls};
use rayon::prelude::*;

use crate::independent::nearest::Tree;
use crate::independent::oracle::Triangle;
use crate::independent::sampling::spread;
use crate::report::{Table, number};
use crate::shapes::{bounds, volume};
use crate::statistics::{mean, range};
use crate::targets::{BOUNDS, HALVINGS, bound_of_hulls};
use crate::terminal::{Failure, print};
use crate::tools::data_folder::DataFolder;
use crate::tools::meshes::{self, Mesh};
use crate::tools::methods::{Tool, bounded};

/// Measure hulls as CoACD does: the concavity of the solid within each hull, on meshes of longest
/// side 2
///
/// Needs a Python with the packages manifold3d and numpy, for the intersections. Meshes that are no
/// manifold are left out.
#[derive(clap::Args)]
pub struct Arguments {
    #[arg(required = true, value_name = "DIR", help = meshes::folders_help())]
    folders: Vec<PathBuf>,

    /// The bounds, as fractions of the diagonal
    #[arg(long, value_name = "BOUNDS", value_delimiter = ',', default_values_t = [0.02, 0.016, 0.014])]
    bounds: Vec<f64>,

    /// A folder with CoACD's hulls in peers/coacd. Where there are some, ours are compared with no
    /// more hulls, and with no more concavity
    #[arg(long, value_name = "DIR")]
    peers: Option<PathBuf>,

    /// The Python that has the packages
    #[arg(long, value_name = "PROGRAM", default_value = "python3")]
    python: String,
}

/// The longest side of the bounding box.
const SIDE: f64 = 2.0;

/// Samples of a unit of area.
const DENSITY: f64 = 10_000.0;

/// Of the radius of what a hull adds: CoACD's default.
const K: f64 = 0.3;

const SCRIPT: &str = include_str!("intersect.py");

/// Distances from the hull's boundary to the part's and back, and the radius times [`K`]; each the
/// largest of all hulls.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
struct Concavity {
    to_part: f64,
    to_hull: f64,
    volume: f64,
}

impl Concavity {
    fn of(hull: &TriangleMesh, part: &TriangleMesh) -> Self {
        let added = (volume(hull) - volume(part)).max(0.0);
        let volume = K * (3.0 * added / (4.0 * std::f64::consts::PI)).cbrt();
        let [hull, part] = [hull, part].map(|mesh| Triangle::all(&mesh.positions, &mesh.triangles));
        if part.is_empty() {
            return Self { volume, ..Self::default() };
        }
        let farthest = |from: &[Triangle], to: &[Triangle]| {
            let tree = Tree::new(to.to_vec());
            // Corners are where most extremes are.
            let corners = from.iter().flat_map(|triangle| triangle.corners);
            let points = spread(from, DENSITY).chain(corners);
            points.map(|point| tree.distance(point)).fold(0.0, f64::max)
        };
        Self { to_part: farthest(&hull, &part), to_hull: farthest(&part, &hull), volume }
    }

    fn max(self, other: Self) -> Self {
        Self {
            to_part: self.to_part.max(other.to_part),
            to_hull: self.to_hull.max(other.to_hull),
            volume: self.volume.max(other.volume),
        }
    }

    fn largest(self) -> f64 {
        self.to_part.max(self.to_hull).max(self.volume)
    }
}

/// Hulls of a mesh, measured.
type Measured = (usize, Concavity);

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let meshes = meshes::find(&arguments.folders)?;
    let folder = arguments.peers.clone().map(DataFolder);
    let mut rows: BTreeMap<String, Vec<Measured>> = BTreeMap::new();
    let (mut left_out, all) = (0, meshes.len());
    for (place, mesh) in meshes.into_iter().enumerate() {
        let evaluator = Evaluator::new(&mesh, &arguments.python)?;
        let mut add = |method: String, found: Measured| -> Result<(), Failure> {
            let largest = number(found.1.largest());
            let hulls = found.0;
            print(&format!(
                "{:>3}/{all}  {:<24} {method}: {hulls} hulls, {largest}",
                place + 1,
                mesh.name
            ))?;
            rows.entry(method).or_default().push(found);
            Ok(())
        };
        for (index, &bound) in arguments.bounds.iter().enumerate() {
            match evaluator.ours(bound) {
                Ok(found) => add(format!("{} %", number(100.0 * bound)), found)?,
                Err(reason) if index == 0 && reason.contains("no manifold") => {
                    print(&format!("{:>3}/{all}  {}: {reason}", place + 1, mesh.name))?;
                    left_out += 1;
                    break;
                }
                Err(reason) => return Err(reason.into()),
            }
        }
        let theirs = folder.as_ref().map(|folder| folder.hulls(Tool::Coacd, &mesh.name));
        if let Some(theirs) = theirs.filter(|path| path.is_file()) {
            let theirs =
                evaluator.measure(read_hulls(theirs)?.into_iter().map(|hull| hull.mesh))?;
            add("CoACD".into(), theirs)?;
            add("CoACD's hulls".into(), evaluator.ours(bound_of_hulls(&mesh, theirs.0)?)?)?;
            add("CoACD's concavity".into(), evaluator.no_more_than(theirs.1.largest())?)?;
        }
    }
    print(&format!("\n{left_out} of {all} are no manifold.\n\n{}", table(&rows).to_markdown()))
}

fn table(rows: &BTreeMap<String, Vec<Measured>>) -> Table {
    let header = [
        "hulls",
        "meshes",
        "number, mean",
        "to part",
        "to hull",
        "volume",
        "concavity, mean",
        "largest",
    ];
    let mut table = Table::new("Concavity", "", &header);
    for (method, found) in rows {
        let of = |value: fn(&Measured) -> f64| -> Vec<f64> { found.iter().map(value).collect() };
        let largest = of(|found| found.1.largest());
        let mut cells = vec![method.clone(), found.len().to_string()];
        let means = [
            mean(&of(|found| found.0 as f64)),
            mean(&of(|found| found.1.to_part)),
            mean(&of(|found| found.1.to_hull)),
            mean(&of(|found| found.1.volume)),
            mean(&largest),
            range(largest).1,
        ];
        cells.extend(means.map(number));
        table.rows.push(cells);
    }
    table
}

/// A mesh, scaled, and the script.
struct Evaluator<'a> {
    mesh: TriangleMesh,
    scale: f64,
    scratch: tempfile::TempDir,
    python: &'a str,
}

impl<'a> Evaluator<'a> {
    fn new(mesh: &Mesh, python: &'a str) -> Result<Self, Failure> {
        let mesh = read_mesh(&mesh.path)?.mesh;
        let (low, high) = bounds(&mesh.positions);
        let scale = SIDE / (high - low).max_element();
        let scratch = tempfile::tempdir().map_err(|error| format!("no scratch folder: {error}"))?;
        write_hulls(scratch.path().join("mesh.obj"), [&scaled(&mesh, scale)])?;
        Ok(Self { mesh, scale, scratch, python })
    }

    /// The default method's hulls under a bound.
    fn ours(&self, bound: f64) -> Result<Measured, String> {
        let found = decompose(&self.mesh, &bounded(bound), &Control::new());
        let hulls = found.map_err(|error| error.to_string())?.hulls.into_iter();
        self.measure(hulls.map(|hull| TriangleMesh::new(hull.shape.points, hull.shape.triangles)))
    }

    /// Those of the largest bound that was found with no more concavity, or of the least one.
    fn no_more_than(&self, concavity: f64) -> Result<Measured, String> {
        let [mut low, mut high] = BOUNDS;
        let mut best = None;
        for _ in 0..HALVINGS {
            let bound = (low * high).sqrt();
            let found = self.ours(bound)?;
            if found.1.largest() > concavity {
                high = bound;
            } else {
                (low, best) = (bound, Some(found));
            }
        }
        best.map_or_else(|| self.ours(low), Ok)
    }

    fn measure(&self, hulls: impl Iterator<Item = TriangleMesh>) -> Result<Measured, String> {
        let path = |name: &str| self.scratch.path().join(name);
        let hulls: Vec<TriangleMesh> = hulls.map(|hull| scaled(&hull, self.scale)).collect();
        write_hulls(path("hulls.obj"), &hulls).map_err(|error| error.to_string())?;
        let parts = self.intersect(&path("parts.obj"))?;
        let found = hulls.par_iter().enumerate().map(|(index, hull)| {
            let none = TriangleMesh::default();
            Concavity::of(hull, parts.get(&index.to_string()).unwrap_or(&none))
        });
        Ok((hulls.len(), found.reduce(Concavity::default, Concavity::max)))
    }

    /// The solid within each hull, by the hull's number; none where they do not meet.
    fn intersect(&self, out: &Path) -> Result<BTreeMap<String, TriangleMesh>, String> {
        let inputs = ["mesh.obj", "hulls.obj"].map(|name| self.scratch.path().join(name));
        let output = Command::new(self.python).args(["-c", SCRIPT]).args(inputs).arg(out).output();
        let output = output.map_err(|error| format!("{}: {error}", self.python))?;
        if !output.status.success() {
            let errors = String::from_utf8_lossy(&output.stderr).into_owned();
            let reason = errors.lines().last().unwrap_or("the script failed");
            return Err(reason.trim_start_matches("error: ").to_owned());
        }
        let parts = read_hulls(out).map_err(|error| error.to_string())?;
        Ok(parts.into_iter().map(|part| (part.name, part.mesh)).collect())
    }
}

fn scaled(mesh: &TriangleMesh, scale: f64) -> TriangleMesh {
    let positions = mesh.positions.iter().map(|point| point.map(|x| x * scale)).collect();
    TriangleMesh::new(positions, mesh.triangles.clone())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shapes::{cuboid, join};
    use hullwright::convex_hull;

    fn own_hull(mesh: &TriangleMesh) -> TriangleMesh {
        let hull = convex_hull(&mesh.positions).unwrap();
        TriangleMesh::new(hull.points, hull.triangles)
    }

    #[test]
    fn a_cube_is_not_concave() {
        let cube = cuboid([0.0; 3], [1.0; 3]);
        let found = Concavity::of(&own_hull(&cube), &cube);
        assert!(found.largest() < 1e-4, "{found:?}");
    }

    /// Arms of length 2 and width 1, 4 high: a bridge is half a square of side 1.
    #[test]
    fn an_l_has_the_concavity_of_its_notch() {
        let mut l = join(&[
            cuboid([0.0, 0.0, 0.0], [1.0, 2.0, 4.0]),
            cuboid([1.0, 0.0, 0.0], [2.0, 1.0, 4.0]),
        ]);
        // The part of the first one's side that the second one covers, and the second one's side
        // there, are inside.
        let side =
            |triangle: &[u32; 3]| triangle.iter().all(|&v| l.positions[v as usize][0] == 1.0);
        let inner: Vec<[u32; 3]> = l.triangles.iter().copied().filter(side).collect();
        assert_eq!(inner.len(), 4);
        l.triangles.retain(|triangle| !inner.contains(triangle));
        let first = l.positions.len() as u32;
        l.positions.extend([[1.0, 1.0, 0.0], [1.0, 2.0, 0.0], [1.0, 2.0, 4.0], [1.0, 1.0, 4.0]]);
        l.triangles.extend([[0, 1, 2], [0, 2, 3]].map(|t| t.map(|v| v + first)));
        let Concavity { to_part, to_hull, volume } = Concavity::of(&own_hull(&l), &l);
        // The middle of the bridge from a wall of the notch, and the notch from the bridge.
        assert!((to_part - 0.5).abs() < 0.01, "{to_part}");
        assert!((to_hull - 0.5_f64.sqrt()).abs() < 0.01, "{to_hull}");
        let ball = (3.0 * 2.0 / (4.0 * std::f64::consts::PI)).cbrt();
        assert!((volume - K * ball).abs() < 1e-9, "{volume}");
    }
}
