//! The library for JavaScript: what crosses the border of the wasm module, in the forms that cross
//! it cheaply.
//!
//! Arrays of numbers are flat; parameters are the text that [`Parameters`](hullwright::Parameters)
//! reads; reports are JSON. The package in `npm/` gives all of that its public form and runs it in
//! a worker. Errors are JavaScript's `Error` with a `code`; a panic is one with the code `trap`,
//! after which the module must not be used again.
//!
//! | file | contents |
//! |---|---|
//! | `calls` | decompose, measure, join |
//! | `surface` | simplify |
//! | `readers` | mesh files (feature `readers`) |
//! | `page` | a decomposition that stays, with all that a page shows of it (feature `page`) |
//! | `hulls` | hulls in single precision, and in double precision from files |
//! | `mesh` | a mesh in flat arrays |
//! | `errors` | errors with codes |

mod calls;
mod errors;
mod hulls;
mod mesh;
#[cfg(feature = "page")]
mod page;
#[cfg(feature = "readers")]
mod readers;
mod surface;

pub use calls::{Decomposed, Joined, algorithm_version, decompose, measure, merge_tree, start};
pub use hulls::{HullArrays, HullList};
pub use mesh::Mesh;
#[cfg(feature = "page")]
pub use page::Shown;
#[cfg(feature = "readers")]
pub use readers::MeshReader;
pub use surface::{Simplified, simplify};
