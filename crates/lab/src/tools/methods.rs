//! The methods, and the values that each one's own setting takes.

use std::path::PathBuf;

use hullwright::surface::SurfaceParameters;
use hullwright::{Length, Method, Parameters, Preset};
use serde::{Deserialize, Serialize};

/// A method with its setting.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum Run {
    /// The paper's method, exactly.
    Surface,
    /// HACD within its frame, with β.
    Hacd { threshold: f64 },
    /// Ours, with this largest error as a fraction of the diagonal.
    Bounded { error: f64, preset: Preset },
    /// Parry's, as Rapier calls it.
    Vhacd { concavity: f64, resolution: u32 },
    /// Another tool's hulls as another machine computed them in so many seconds, with its default
    /// setting.
    Files { tool: Tool, hulls: PathBuf, seconds: f64 },
}

/// A tool whose hulls come as files.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Tool {
    /// On all threads of a processor.
    Coacd,
    /// On a graphics card, an H100.
    Cuacd,
}

impl Tool {
    pub const ALL: [Self; 2] = [Self::Coacd, Self::Cuacd];

    /// What the names of its versions in tables begin with, and of the folder of its hulls.
    pub fn name(self) -> &'static str {
        match self {
            Self::Coacd => "coacd",
            Self::Cuacd => "cuacd",
        }
    }
}

/// The version of Parry whose V-HACD runs here, from the lock file that it was built with.
fn parry_version() -> String {
    let lock = include_str!("../../../../Cargo.lock");
    let versions = lock.split("name = \"parry3d\"\nversion = \"").skip(1);
    let mut versions = versions.filter_map(|rest| rest.split('"').next());
    versions.find(|version| version.starts_with("0.31.")).unwrap_or("0.31").to_owned()
}

/// Steps of two: curves are interpolated in logarithms.
const BOUNDED_ERRORS: [f64; 5] = [0.005, 0.01, 0.02, 0.04, 0.08];
/// The middle of those, around the default.
const QUICK_BOUNDED_ERRORS: [f64; 3] = [0.01, 0.02, 0.04];
/// Concavities of Parry's V-HACD at its default resolution, and at twice that. (Four times that
/// takes 3 s a mesh, for a tenth less error.)
const VHACD: [(u32, &[f64]); 2] = [(64, &[0.0025, 0.01, 0.04]), (128, &[0.0025, 0.01])];

/// Around the default.
const HACD_THRESHOLDS: [f64; 3] = [0.02, 0.05, 0.1];

impl Run {
    /// Ours with its defaults and this bound.
    pub fn bounded(error: f64) -> Self {
        Self::Bounded { error, preset: Preset::Balanced }
    }

    /// Everything that this program can run itself, each method's default setting first.
    pub fn own() -> Vec<Self> {
        let mut runs = vec![Self::Surface];
        runs.extend(HACD_THRESHOLDS.map(|threshold| Self::Hacd { threshold }));
        runs.extend(BOUNDED_ERRORS.map(Self::bounded));
        for (resolution, concavities) in VHACD {
            let run = |&concavity: &f64| Self::Vhacd { concavity, resolution };
            runs.extend(concavities.iter().map(run));
        }
        runs
    }

    /// What `bench --quick` runs.
    pub fn quick() -> Vec<Self> {
        let mut runs = vec![Self::Surface];
        runs.extend(QUICK_BOUNDED_ERRORS.map(Self::bounded));
        runs.push(Self::VHACD_DEFAULT);
        runs
    }

    /// Parry's defaults.
    pub const VHACD_DEFAULT: Self = Self::Vhacd { concavity: 0.01, resolution: 64 };

    /// The settings that stand for their methods in tables of one row per method.
    pub fn defaults() -> [Self; 6] {
        let [coacd, cuacd] =
            Tool::ALL.map(|tool| Self::Files { tool, hulls: PathBuf::new(), seconds: 0.0 });
        [
            Self::bounded(0.02),
            Self::Surface,
            Self::Hacd { threshold: 0.05 },
            Self::VHACD_DEFAULT,
            coacd,
            cuacd,
        ]
    }

    /// Whether a setting is its method's default.
    pub fn is_default(method: &str, setting: &str) -> bool {
        Self::defaults().iter().any(|run| run.method() == method && run.setting() == setting)
    }

    pub fn method(&self) -> &'static str {
        match self {
            Self::Surface => "surface",
            Self::Hacd { .. } => "hacd",
            Self::Bounded { .. } => "bounded",
            Self::Vhacd { .. } => "vhacd",
            Self::Files { tool: Tool::Coacd, .. } => "coacd-files",
            Self::Files { tool: Tool::Cuacd, .. } => "cuacd-files",
        }
    }

    pub fn setting(&self) -> String {
        match self {
            Self::Surface => "paper".into(),
            Self::Hacd { threshold } => format!("threshold {threshold}"),
            Self::Bounded { error, preset: Preset::Balanced } => format!("error {error}"),
            Self::Bounded { error, preset } => format!("error {error}, {preset}"),
            Self::Vhacd { concavity, resolution } => {
                format!("concavity {concavity}, resolution {resolution}")
            }
            Self::Files { tool: Tool::Coacd, .. } => "threshold 0.05, from files".into(),
            Self::Files { tool: Tool::Cuacd, .. } => "defaults, from files".into(),
        }
    }

    /// Version of what runs.
    pub fn version(&self) -> String {
        let ours = env!("CARGO_PKG_VERSION");
        match self {
            Self::Surface | Self::Hacd { .. } | Self::Bounded { .. } => {
                format!("hullwright {ours}, algorithm {}", hullwright::ALGORITHM_VERSION)
            }
            Self::Vhacd { .. } => format!("parry3d {}", parry_version()),
            Self::Files { tool: Tool::Coacd, .. } => "coacd 1.0.14".into(),
            Self::Files { tool: Tool::Cuacd, .. } => "cuacd 0.1.0".into(),
        }
    }

    /// Our own methods, with their parameters.
    pub fn own_method(&self) -> Option<Method> {
        match *self {
            Self::Surface => Some(SurfaceParameters::paper().into()),
            Self::Hacd { threshold } => {
                let mut hacd = SurfaceParameters::paper();
                hacd.concavity_threshold = Some(threshold);
                Some(hacd.into())
            }
            Self::Bounded { error, preset } => Some(bounded(error).with_preset(preset).into()),
            _ => None,
        }
    }
}

/// The defaults, except for the error.
pub fn bounded(error: f64) -> Parameters {
    Parameters::default().with_max_error(Length::Share(error))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_lock_file_names_parry() {
        assert!(parry_version().starts_with("0.31."));
    }
}
