//! A page for each mesh of a benchmark, with ours and V-HACD's hulls side by side.

use std::path::Path;

use hullwright::Control;
use hullwright::io::read_mesh;
use hullwright_cli::terminal::Failure;

use crate::report::html_report::{self, PageLink};
use crate::runs::meshes::Mesh;
use crate::view::ComparisonPage;

/// The folder of the pages, in that of the report.
const FOLDER: &str = "pages";

/// Writes the pages of all meshes that can be decomposed, and returns their names.
pub fn write(report: &Path, meshes: &[Mesh]) -> Result<Vec<PageLink>, Failure> {
    html_report::create_folder(&report.join(FOLDER))?;
    let mut links = Vec::new();
    for mesh in meshes {
        // What fails has a row in the tables that says so.
        let Ok(file) = read_mesh(&mesh.path) else { continue };
        let control = Control::new();
        let Ok(mut page) = ComparisonPage::new(&mesh.name, &file, &control) else { continue };
        if page.add_ours().and_then(|()| page.add_vhacd()).is_err() {
            continue;
        }
        let file = format!("{FOLDER}/{}.html", file_name(&mesh.name));
        page.write(&report.join(&file))?;
        links.push(PageLink { name: mesh.name.clone(), file });
    }
    Ok(links)
}

/// The name with all that means something in an address replaced.
fn file_name(name: &str) -> String {
    name.chars().map(|c| if c.is_alphanumeric() || "-.".contains(c) { c } else { '_' }).collect()
}
