//! What is taken away: the component as Rust or as glTF extras, and files of hulls.

use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};

use arboard::Clipboard;
use bevy::prelude::*;
use bevy::tasks::{AsyncComputeTaskPool, Task, block_on, poll_once};
use hullwright::hulls_format::HullsFile;
use hullwright::{Preset, mass_properties_with};
use hullwright_formats::{write_file, write_hulls};

use crate::decompose::{Fit, Settings};

/// Decimals of a share: a thousandth of a percent.
const DECIMALS: usize = 5;

/// Stands for no cap in extras, which have no word for it: no hull has so many vertices.
const UNCAPPED: usize = 1_000_000;

/// Where files are saved, and the clipboard once it was used.
#[derive(Resource)]
pub struct Export {
    /// The folder for files.
    pub folder: PathBuf,
    /// What was done last, or why it was not.
    pub message: Result<String, String>,
    clipboard: Mutex<Option<Clipboard>>,
    saving: Vec<Task<Result<String, String>>>,
}

impl Export {
    /// Saves into this folder.
    pub fn new(folder: PathBuf) -> Self {
        Self { folder, message: Ok(String::new()), clipboard: Mutex::default(), saving: Vec::new() }
    }

    /// Copies text, and says so.
    pub fn copy(&mut self, text: &str, what: &str) {
        self.message = match self.with_clipboard(|clipboard| clipboard.set_text(text)) {
            Ok(()) => Ok(format!("copied {what}")),
            Err(error) => Err(format!("{what} could not be copied: {error}")),
        };
    }

    /// The text in the clipboard.
    pub fn copied(&self) -> Result<String, arboard::Error> {
        self.with_clipboard(Clipboard::get_text)
    }

    /// The same clipboard is kept: on X11 its owner hands out the text.
    fn with_clipboard<T>(
        &self,
        use_it: impl FnOnce(&mut Clipboard) -> Result<T, arboard::Error>,
    ) -> Result<T, arboard::Error> {
        let mut slot = self.clipboard.lock().unwrap_or_else(|broken| broken.into_inner());
        match &mut *slot {
            Some(clipboard) => use_it(clipboard),
            empty => use_it(empty.insert(Clipboard::new()?)),
        }
    }

    /// Saves hulls with this suffix, `hulls` or `glb`, in the background, and says where.
    pub fn save(&mut self, fit: &Arc<Fit>, suffix: &'static str) {
        let path = self.folder.join(format!("{}.{suffix}", fit.model.name));
        let fit = fit.clone();
        self.saving.push(AsyncComputeTaskPool::get().spawn(async move {
            let written = match suffix {
                "hulls" => write_hulls_file(&fit, &path),
                _ => {
                    write_hulls(&path, &fit.decomposition.hulls).map_err(|error| error.to_string())
                }
            };
            written.map(|()| format!("saved {}", path.display()))
        }));
    }

    /// Whether a file is being written.
    pub fn is_saving(&self) -> bool {
        !self.saving.is_empty()
    }
}

/// Says what became of files.
pub fn take_saved(mut export: ResMut<Export>) {
    let export = export.bypass_change_detection();
    let message = &mut export.message;
    export.saving.retain_mut(|task| match block_on(poll_once(task)) {
        Some(said) => {
            *message = said;
            false
        }
        None => true,
    });
}

/// With the mass properties at a density of 1, as `hullwright bake` writes them.
fn write_hulls_file(fit: &Fit, path: &Path) -> Result<(), String> {
    let (mesh, hulls) = (&fit.model.mesh, &fit.decomposition.hulls);
    let mass = mass_properties_with(mesh, hulls, 1.0, &fit.settings.parameters())
        .map_err(|error| error.to_string())?;
    let file = HullsFile::new(&fit.model.name, &fit.decomposition).with_mass_properties(mass);
    let bytes = file.to_bytes().map_err(|error| error.to_string())?;
    write_file(path, &bytes).map_err(|error| error.to_string())
}

/// The component in Rust: what differs from its default. For a mesh with this diagonal.
pub fn rust(settings: &Settings, diagonal: f64) -> String {
    let default = Settings::default();
    let mut lines = vec!["ConvexDecomposition::default()".to_owned()];
    if settings.bound != default.bound {
        lines.push(format!(".with_max_error({})", share(settings.bound)));
    }
    if settings.preset != default.preset {
        let name = if settings.preset == Preset::Fast { "Fast" } else { "Fine" };
        lines.push(format!(".with_preset(DecompositionPreset::{name})"));
    }
    if let Some(most) = settings.max_hulls {
        lines.push(format!(".with_max_hulls({most})"));
    }
    if settings.max_vertices != default.max_vertices {
        let most = settings.max_vertices.map_or("None".to_owned(), |most| most.to_string());
        lines.push(format!(".with_max_vertices({most})"));
    }
    if settings.keep_cavities {
        lines.push(".with_keep_cavities(true)".into());
    }
    if settings.openings != default.openings {
        let name = capitalised(settings.openings.name());
        lines.push(format!(".with_openings(DecompositionOpenings::{name})"));
    }
    if settings.probe > 0.0 {
        lines.push(format!(".with_probe_radius({})", metres(settings.probe, diagonal)));
    }
    lines.join("\n    ")
}

/// The same as extras of a glTF node.
pub fn extras(settings: &Settings, diagonal: f64) -> String {
    let default = Settings::default();
    let mut values = vec![r#""collider": "convex_decomposition""#.to_owned()];
    if settings.bound != default.bound {
        values.push(format!(r#""max_error": {}"#, share(settings.bound)));
    }
    if settings.preset != default.preset {
        values.push(format!(r#""preset": "{}""#, settings.preset));
    }
    if let Some(most) = settings.max_hulls {
        values.push(format!(r#""max_hulls": {most}"#));
    }
    if settings.max_vertices != default.max_vertices {
        let most = settings.max_vertices.unwrap_or(UNCAPPED);
        values.push(format!(r#""max_vertices": {most}"#));
    }
    if settings.keep_cavities {
        values.push(r#""keep_cavities": true"#.into());
    }
    if settings.openings != default.openings {
        values.push(format!(r#""openings": "{}""#, settings.openings));
    }
    if settings.probe > 0.0 {
        values.push(format!(r#""probe_radius": "{}m""#, metres(settings.probe, diagonal)));
    }
    format!("{{{}}}", values.join(", "))
}

/// A percentage of the diagonal in metres, if those are the mesh's units, to three digits.
fn metres(percent: f64, diagonal: f64) -> String {
    let length = percent / 100.0 * diagonal;
    let digits = (2.0 - length.log10().floor()).max(1.0) as usize;
    format!("{length:.digits$}")
}

/// Percent as a share, without zeros at its end.
fn share(percent: f64) -> String {
    let text = format!("{:.DECIMALS$}", percent / 100.0);
    text.trim_end_matches('0').to_owned()
}

fn capitalised(word: &str) -> String {
    let mut letters = word.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}

#[cfg(test)]
mod tests {
    use bevy_hullwright::prelude::*;
    use hullwright::{Length, Method, Openings, Parameters};
    use hullwright_formats::conventions::read_extras;

    use super::*;

    /// Of the mesh, in metres.
    const DIAGONAL: f64 = 2.0;

    fn settings() -> Settings {
        Settings {
            bound: 1.0,
            max_hulls: Some(8),
            max_vertices: None,
            preset: Preset::Fine,
            openings: Openings::Close,
            keep_cavities: true,
            probe: 0.0,
        }
    }

    #[test]
    fn a_component_of_defaults_says_nothing_else() {
        assert_eq!(rust(&Settings::default(), DIAGONAL), "ConvexDecomposition::default()");
        assert_eq!(
            extras(&Settings::default(), DIAGONAL),
            r#"{"collider": "convex_decomposition"}"#
        );
    }

    /// Code, what it makes, and its text.
    macro_rules! compiled {
        ($code:expr) => {
            ($code, stringify!($code))
        };
    }

    fn without_spaces(text: &str) -> String {
        text.split_whitespace().collect()
    }

    #[test]
    fn the_component_compiles_and_asks_for_what_the_controls_say() {
        let (tag, code) = compiled!(
            ConvexDecomposition::default()
                .with_max_error(0.01)
                .with_preset(DecompositionPreset::Fine)
                .with_max_hulls(8)
                .with_max_vertices(None)
                .with_keep_cavities(true)
                .with_openings(DecompositionOpenings::Close)
        );
        assert_eq!(without_spaces(&rust(&settings(), DIAGONAL)), without_spaces(code));
        assert_eq!(in_single_precision(tag.to_parameters()), settings().parameters());
        let fast = Settings { preset: Preset::Fast, openings: Openings::Keep, ..settings() };
        let (_, code) = compiled!(
            ConvexDecomposition::default()
                .with_max_error(0.01)
                .with_preset(DecompositionPreset::Fast)
                .with_max_hulls(8)
                .with_max_vertices(None)
                .with_keep_cavities(true)
                .with_openings(DecompositionOpenings::Keep)
        );
        assert_eq!(without_spaces(&rust(&fast, DIAGONAL)), without_spaces(code));
    }

    #[test]
    fn a_probe_is_a_length_in_metres() {
        let settings = Settings { probe: 5.0, ..Settings::default() };
        let (tag, code) = compiled!(ConvexDecomposition::default().with_probe_radius(0.100));
        assert_eq!(without_spaces(&rust(&settings, DIAGONAL)), without_spaces(code));
        let radius = |method: Method| match method {
            Method::Bounded(parameters) => parameters.probe_radius,
            _ => None,
        };
        assert_eq!(radius(tag.to_parameters()), Some(Length::units(0.1)));
        let (tag, complaints) = read_extras(&extras(&settings, DIAGONAL));
        assert_eq!(complaints, Vec::<String>::new());
        let read = tag.and_then(|tag| tag.parameters(&Method::default()));
        assert_eq!(read.and_then(radius), Some(Length::units(0.1)));
    }

    #[test]
    fn the_plugin_reads_every_key_of_the_extras() {
        for settings in [Settings::default(), settings()] {
            let (tag, complaints) = read_extras(&extras(&settings, DIAGONAL));
            assert_eq!(complaints, Vec::<String>::new());
            let read = tag.and_then(|tag| tag.parameters(&Method::default()));
            let mut expected = settings.parameters();
            expected.max_vertices = expected.max_vertices.or(Some(UNCAPPED));
            assert_eq!(read.map(in_single_precision), Some(expected));
        }
    }

    /// The plugin holds the bound as `f32`.
    fn in_single_precision(method: Method) -> Parameters {
        let Method::Bounded(mut parameters) = method else { panic!("another method: {method}") };
        let share = f64::from(parameters.max_error.of_diagonal(1.0) as f32);
        let decimals = 10_f64.powi(DECIMALS as i32);
        parameters.max_error = Length::share((share * decimals).round() / decimals);
        parameters
    }
}
