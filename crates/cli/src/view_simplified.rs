//! `hullwright view --simplified`: a mesh before and after simplification.

use std::path::Path;
use std::time::Instant;

use hullwright::{
    Control, Error, HiddenTriangles, Length, MeshView, SimplifyParameters, SurfaceDistances,
    TriangleMesh, UpAxis, simplify_surface, surface_distances,
};
use hullwright_cli::render::{Layout, Panel, Part, Picture, render_with};
use hullwright_cli::terminal::{count, time};
use hullwright_cli::viewer::{Simplified, SimplifiedPage};
use hullwright_formats::MeshFile;
use hullwright_formats::palette::{CAP, CLAY, colour};

/// Pixels of each half of a picture.
const PANEL: usize = 900;

/// What is shown, and how.
pub struct Before<'a> {
    pub title: String,
    pub file: &'a MeshFile,
    pub parameters: SimplifyParameters,
    pub up: UpAxis,
}

/// What stands for the mesh.
pub struct After {
    name: String,
    mesh: TriangleMesh,
    distances: SurfaceDistances,
    facts: Vec<(String, String)>,
}

impl Before<'_> {
    /// Simplifies the mesh.
    pub fn simplified(&self, control: &Control) -> Result<After, Error> {
        let start = Instant::now();
        let result = simplify_surface(self.file, self.parameters, control)?;
        let seconds = start.elapsed().as_secs_f64();
        let hidden = HiddenTriangles::Listed([&result.hidden, &[]]);
        let mut distances = surface_distances(self.file, &result.mesh, hidden, control)?;
        // Both bounds hold.
        for (distance, known) in [
            (&mut distances.from_b_to_a, result.report.from_source),
            (&mut distances.from_a_to_b, result.report.to_source),
        ] {
            distance.at_most = distance.at_most.min(known);
        }
        let name = format!("simplified, {}", self.parameters.max_error);
        let facts = vec![("time".to_owned(), time(seconds))];
        Ok(self.after(name, result.mesh, distances, facts))
    }

    /// Compares it with a mesh that any tool has made.
    pub fn compared(&self, path: &Path, mesh: TriangleMesh) -> Result<After, Error> {
        let keeps = self.parameters.keep_hidden;
        let hidden = if keeps { HiddenTriangles::Kept } else { HiddenTriangles::Found };
        let distances = surface_distances(self.file, &mesh, hidden, &Control::new())?;
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        Ok(self.after(name, mesh, distances, Vec::new()))
    }

    fn after(
        &self,
        name: String,
        mesh: TriangleMesh,
        distances: SurfaceDistances,
        mut facts: Vec<(String, String)>,
    ) -> After {
        let hidden = distances.hidden_of_a.len();
        let before = count(self.file.mesh.triangles.len(), "triangle", "triangles");
        facts.insert(0, ("of".into(), before));
        if hidden > 0 {
            facts.insert(1, ("hidden".into(), hidden.to_string()));
        }
        After { name, mesh, distances, facts }
    }

    /// One file that loads nothing.
    pub fn page(&self, after: &After, control: &Control) -> Result<String, Error> {
        let After { name, mesh, distances, facts } = after;
        let simplified = Simplified {
            name: name.clone(),
            mesh: mesh.view(),
            distances,
            bound: self.parameters.max_error.of_diagonal(distances.diagonal),
            facts: facts.clone(),
            up: self.up,
        };
        SimplifiedPage::new(self.title.clone(), self.file.into(), simplified, control)?.to_html()
    }

    /// Before and after side by side, with the edges of all triangles. What is hidden is red where
    /// it can be seen all the same.
    pub fn picture(&self, after: &After) -> Result<Picture, Error> {
        let mut layout = Layout::default();
        layout.wires = true;
        layout.view.up = self.up;
        let hidden = &after.distances.hidden_of_a;
        let own = |is_hidden: bool| {
            let all = (0_u32..).zip(&self.file.mesh.triangles);
            let own = all.filter(|(index, _)| hidden.binary_search(index).is_ok() == is_hidden);
            own.map(|(_, &triangle)| triangle).collect()
        };
        let positions = &self.file.mesh.positions;
        let part = |triangles: Vec<[u32; 3]>, colour| Part {
            mesh: TriangleMesh::new(positions.clone(), triangles),
            colour,
        };
        let parts = vec![part(own(false), CLAY), part(own(true), CAP)];
        let before = Panel { parts, ..Panel::default() };
        let mut result = Panel::mesh(MeshView::from(&after.mesh));
        result.parts.iter_mut().for_each(|part| part.colour = colour(0));
        render_with(&[before, result], 2 * PANEL, PANEL, &layout)
    }
}

impl After {
    /// What it is, for a line of standard output.
    pub fn summary(&self, of: &MeshFile) -> String {
        let (triangles, before) = (self.mesh.triangles.len(), of.mesh.triangles.len());
        let share = 100.0 * self.distances.hausdorff() / self.distances.diagonal;
        format!("{}: {triangles} of {before} triangles, within {share:.3} %", self.name)
    }
}

/// The bound where none is given, as of `simplify`.
pub const DEFAULT_BOUND: Length = Length::share(0.005);
