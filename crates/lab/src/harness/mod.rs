//! The one way in which experiments run meshes.
//!
//! An experiment says which meshes, and which [`Task`]s for each. A [`Session`] runs each task in a
//! process with limits, keeps its [`Row`] in a journal, so that it can be stopped and continued,
//! and writes the report with the experiment's tables.

mod journal;
pub mod limits;
pub mod row;
pub mod session;
pub mod worker;

pub use row::{Row, Status};
pub use session::{Session, describe};
pub use worker::{FULL, Judge, Task};
