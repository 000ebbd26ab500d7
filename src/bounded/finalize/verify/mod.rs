//! Verification against the source, by upper bounds, not samples: how far a hull protrudes from the
//! solid, and how far the surface lies outside the hulls.
//!
//! | file | contents |
//! |---|---|
//! | `protrusion` | the distance from a hull's surface to the solid |
//! | `keeps_bound` | whether that is within the bound |
//! | `hull_distance` | the distance from a point to a hull |
//! | `point_groups` | the greatest distance of many points outside a hull |
//! | `uncovered` | the distance of the surface outside all hulls |

pub(in crate::bounded) mod hull_distance;
pub(in crate::bounded) mod keeps_bound;
pub(in crate::bounded) mod point_groups;
pub(in crate::bounded) mod protrusion;
pub(in crate::bounded) mod uncovered;
