//! Promises of the bounded method, each judged by means of the tests' own.
//!
//! | file | promises |
//! |---|---|
//! | `promise` | the bound is kept, for every bound, preset and kind of mesh |
//! | `verified` | what is verified agrees with brute force |
//! | `bundled_models` | the bundled models keep it, with as many hulls as before |
//! | `degenerate_input` | degenerate input has a result that keeps it, or a typed error |
//! | `dense_meshes` | meshes of very many triangles keep it and lose none |
//! | `hull_counts` | simple shapes have few hulls |
//! | `exact_shapes` | prisms have the known number of hulls at any bound |
//! | `empty_space` | solids are filled, and empty space stays empty |
//! | `caps` | caps on vertices and hulls are kept |
//! | `running` | threads, slices, progress, cancellation, deadlines |
//! | `hierarchy` | joins down to one hull |

mod brute_force;
#[cfg(feature = "io")]
mod bundled_models;
mod caps;
// The unused rest is for other tests.
#[allow(dead_code)]
#[path = "../common/mod.rs"]
mod common;
mod degenerate_input;
mod dense_meshes;
mod empty_space;
mod exact_shapes;
mod hierarchy;
mod hull_counts;
#[allow(dead_code)]
#[path = "../independent/mod.rs"]
mod independent;
mod judge;
mod promise;
mod running;
mod verified;
