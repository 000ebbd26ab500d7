//! Single runs: a mesh, a method and its setting, decomposed and judged in a process of its own.

pub mod data_folder;
pub mod execute;
pub mod external_tools;
pub mod journal;
pub mod judge;
pub mod limits;
pub mod machine;
pub mod meshes;
pub mod methods;
pub mod record;
pub mod vhacd;
pub mod worker;
