//! What a body made of hulls does in Rapier: it falls, rolls, hooks and rests as its shape says.
//!
//! All of it is deterministic: the same hulls, the same steps, one thread. Bodies are the bundled
//! models and meshes made here; lengths are metres.

mod bodies;
// The unused rest is for other tests.
#[allow(dead_code)]
#[path = "../../../hullwright/tests/common/mod.rs"]
mod common;
mod contacts;
mod hanging;
mod resting;
mod seams;
mod shapes;
mod world;
