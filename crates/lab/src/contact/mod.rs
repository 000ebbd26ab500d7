//! What contacts in Rapier are like: with small things, and over seams.

pub mod seams;
pub mod small;
