//! The methods, and the values that each one's own setting takes.

use hullwright::surface::SurfaceParameters;
use hullwright::{Length, Method, Openings, Parameters, Preset};
use serde::{Deserialize, Serialize};

use crate::hacd::HacdParameters;

/// A method with its setting.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum Run {
    /// The paper's method, exactly.
    Surface,
    /// Ours, with this largest error as a fraction of the diagonal.
    Bounded { error: f64, preset: Preset, openings: Openings },
    /// β.
    Hacd { threshold: f64 },
    /// Parry's, as Rapier calls it.
    Vhacd { concavity: f64, resolution: u32 },
    /// V-HACD 4 from its own library, through the script of [`external_tools`](super::external_tools).
    Vhacd4 { hulls: u32 },
    /// CoACD, through the script of [`external_tools`](super::external_tools).
    Coacd { threshold: f64 },
    /// CoACD's hulls as somebody else computed them, with its default threshold.
    CoacdFiles,
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
/// Around ε of the paper's own method, for want of a value of its own; 0.4 for hulls as few as
/// those of the others.
const HACD_THRESHOLDS: [f64; 4] = [0.02, 0.05, 0.1, 0.4];
/// Concavities of Parry's V-HACD at its default resolution, and at twice that. (Four times that
/// takes 3 s a mesh, for a tenth less error.)
const VHACD: [(u32, &[f64]); 2] = [(64, &[0.0025, 0.01, 0.04]), (128, &[0.0025, 0.01])];
/// Its default number of hulls, and a quarter of it.
const VHACD4_HULLS: [u32; 2] = [16, 64];
/// Around its default, 0.05.
const COACD_THRESHOLDS: [f64; 4] = [0.02, 0.05, 0.1, 0.2];

impl Run {
    /// Ours with its defaults and this bound.
    pub fn bounded(error: f64) -> Self {
        Self::Bounded { error, preset: Preset::Balanced, openings: Openings::Auto }
    }

    /// Everything that this program can run itself, each method's default setting first.
    pub fn own() -> Vec<Self> {
        let mut runs = vec![Self::Surface];
        runs.extend(BOUNDED_ERRORS.map(Self::bounded));
        runs.extend(HACD_THRESHOLDS.map(|threshold| Self::Hacd { threshold }));
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

    /// Through Python.
    pub fn vhacd4() -> Vec<Self> {
        VHACD4_HULLS.map(|hulls| Self::Vhacd4 { hulls }).to_vec()
    }

    /// Through Python.
    pub fn coacd() -> Vec<Self> {
        COACD_THRESHOLDS.map(|threshold| Self::Coacd { threshold }).to_vec()
    }

    /// Parry's defaults.
    pub const VHACD_DEFAULT: Self = Self::Vhacd { concavity: 0.01, resolution: 64 };

    /// The settings that stand for their methods in tables of one row per method.
    pub fn defaults() -> [Self; 7] {
        [
            Self::bounded(0.02),
            Self::Surface,
            Self::Hacd { threshold: 0.05 },
            Self::VHACD_DEFAULT,
            Self::Vhacd4 { hulls: 64 },
            Self::Coacd { threshold: 0.05 },
            Self::CoacdFiles,
        ]
    }

    pub fn method(&self) -> &'static str {
        match self {
            Self::Surface => "surface",
            Self::Bounded { .. } => "bounded",
            Self::Hacd { .. } => "hacd",
            Self::Vhacd { .. } => "vhacd",
            Self::Vhacd4 { .. } => "vhacd4",
            Self::Coacd { .. } => "coacd",
            Self::CoacdFiles => "coacd-files",
        }
    }

    pub fn setting(&self) -> String {
        match self {
            Self::Surface => "paper".into(),
            Self::Bounded { error, preset, openings } => {
                let mut setting = format!("error {error}");
                if *preset != Preset::Balanced {
                    setting += &format!(", {preset}");
                }
                if *openings != Openings::Auto {
                    setting += &format!(", openings {openings}");
                }
                setting
            }
            Self::Hacd { threshold } => format!("beta {threshold}"),
            Self::Vhacd { concavity, resolution } => {
                format!("concavity {concavity}, resolution {resolution}")
            }
            Self::Vhacd4 { hulls } => format!("hulls {hulls}, flood fill"),
            Self::Coacd { threshold } => format!("threshold {threshold}"),
            Self::CoacdFiles => "threshold 0.05, from files".into(),
        }
    }

    /// Version of what runs. `packages` are the versions that Python has of `coacd` and `vhacdx`.
    pub fn version(&self, packages: &[String; 2]) -> String {
        let ours = env!("CARGO_PKG_VERSION");
        match self {
            Self::Surface | Self::Bounded { .. } | Self::Hacd { .. } => {
                format!("hullwright {ours}, algorithm {}", hullwright::ALGORITHM_VERSION)
            }
            Self::Vhacd { .. } => format!("parry3d {}", parry_version()),
            Self::Vhacd4 { .. } => format!("vhacdx {}", packages[1]),
            Self::Coacd { .. } => format!("coacd {}", packages[0]),
            Self::CoacdFiles => "coacd 1.0.14".into(),
        }
    }

    /// Our own methods, with their parameters.
    pub fn own_method(&self) -> Option<Method> {
        match *self {
            Self::Surface => Some(SurfaceParameters::paper().into()),
            Self::Bounded { error, preset, openings } => {
                Some(bounded(error).preset(preset).openings(openings).into())
            }
            _ => None,
        }
    }

    pub fn hacd_parameters(&self) -> Option<HacdParameters> {
        let Self::Hacd { threshold } = *self else { return None };
        Some(HacdParameters { concavity_threshold: threshold, ..HacdParameters::default() })
    }
}

/// The defaults, except for the error.
pub fn bounded(error: f64) -> Parameters {
    Parameters::default().max_error(Length::Share(error))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_lock_file_names_parry() {
        assert!(parry_version().starts_with("0.31."));
    }
}
