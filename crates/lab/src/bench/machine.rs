//! The machine, and everything else that a time depends on.

use std::collections::BTreeMap;

use hullwright::measure::MeasureOptions;
use serde_json::{Value, json};

use super::caps::Caps;

/// Processor, memory, system, versions, caps, and how closely `measure` looks.
pub fn describe(caps: Caps) -> BTreeMap<String, Value> {
    let read = |path: &str| std::fs::read_to_string(path).unwrap_or_default();
    let field = |text: &str, name: &str| {
        let line = text.lines().find_map(|line| line.strip_prefix(name));
        line.map(|rest| rest.trim_start_matches([' ', '\t', ':']).trim().to_owned())
    };
    let options = MeasureOptions::default();
    let processors = std::thread::available_parallelism().map_or(1, usize::from);
    let sees_memory = super::caps::memory(std::process::id()).is_some();
    let rows = [
        ("processor", json!(field(&read("/proc/cpuinfo"), "model name"))),
        ("processors", json!(processors)),
        ("memory", json!(field(&read("/proc/meminfo"), "MemTotal"))),
        ("system", json!(format!("{} {}", std::env::consts::OS, std::env::consts::ARCH))),
        ("kernel", json!(read("/proc/sys/kernel/osrelease").trim())),
        ("hullwright", json!(env!("CARGO_PKG_VERSION"))),
        ("algorithm_version", json!(hullwright::ALGORITHM_VERSION)),
        ("optimised", json!(!cfg!(debug_assertions))),
        ("time_cap_seconds", json!(caps.time.as_secs_f64())),
        ("memory_cap_megabytes", json!(sees_memory.then_some(caps.memory >> 20))),
        ("points_on_hulls", json!(options.hull_samples)),
        ("points_on_mesh", json!(options.mesh_samples)),
        ("points_in_space", json!(options.volume_samples)),
    ];
    rows.map(|(name, value)| (name.to_owned(), value)).into()
}
