//! The machine, and everything else that a time depends on.

use std::collections::BTreeMap;

use hullwright::measure::MeasureOptions;
use serde_json::{Value, json};
use sysinfo::{CpuRefreshKind, MemoryRefreshKind, RefreshKind, System};

use super::limits::Limits;

/// Processor, memory, system, versions, limits, and how closely `measure` looks.
pub fn describe(limits: Limits) -> BTreeMap<String, Value> {
    let parts = RefreshKind::nothing()
        .with_cpu(CpuRefreshKind::nothing())
        .with_memory(MemoryRefreshKind::nothing().with_ram());
    let system = System::new_with_specifics(parts);
    let memory = system.as_ref().map(|system| format!("{} kB", system.total_memory() >> 10));
    let processor = system.as_ref().ok().and_then(|system| Some(system.cpus().first()?.brand()));
    let options = MeasureOptions::default();
    let processors = std::thread::available_parallelism().map_or(1, usize::from);
    let rows = [
        ("processor", json!(processor)),
        ("processors", json!(processors)),
        ("memory", json!(memory.ok())),
        ("system", json!(format!("{} {}", std::env::consts::OS, std::env::consts::ARCH))),
        ("kernel", json!(System::kernel_version().ok())),
        ("hullwright", json!(env!("CARGO_PKG_VERSION"))),
        ("algorithm_version", json!(hullwright::ALGORITHM_VERSION)),
        ("optimised", json!(!cfg!(debug_assertions))),
        ("time_limit_seconds", json!(limits.time.as_secs_f64())),
        ("memory_limit_megabytes", json!(limits.memory >> 20)),
        ("points_on_hulls", json!(options.hull_samples)),
        ("points_on_mesh", json!(options.mesh_samples)),
        ("points_in_space", json!(options.volume_samples)),
    ];
    rows.map(|(name, value)| (name.to_owned(), value)).into()
}
