//! What experiments run: meshes, what is done to them, and methods, ours and those of others.

pub mod data_folder;
pub mod kinds;
pub mod meshes;
pub mod methods;
pub mod soup;
pub mod variations;
pub mod vhacd;
