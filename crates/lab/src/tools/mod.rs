//! What experiments run: meshes, what is done to them, and methods, ours and those of others.

mod damage;
pub mod data_folder;
mod disturb;
pub mod kinds;
pub mod meshes;
pub mod methods;
pub mod random;
pub mod soup;
pub mod variations;
pub mod vhacd;
