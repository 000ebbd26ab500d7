//! Experiments that print to the terminal and keep nothing.

pub mod agreement;
pub mod budgets;
pub mod cancel;
pub mod corpus;
pub mod identical;
pub mod openings;
pub mod presets;
pub mod props;
pub mod stages;
pub mod table1;
pub mod targets;
pub mod turned;
pub mod versus_paper;
pub mod volume;
