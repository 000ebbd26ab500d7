//! The cap on hulls: hulls join, even beyond the bound, until few enough are left.

use super::containment::solid::Solid;
use super::finalize::final_hull::FinalHull;
use super::hierarchy::Hierarchy;
use super::patch_set::PatchSet;
use super::patches::patch::Patches;
use super::settings::Settings;
use crate::control::Control;
use crate::error::Error;

/// Joins hulls until no more than `most` are left. See [`Hierarchy::new`].
///
/// # Errors
/// [`Error::Cancelled`].
pub(super) fn limit_hulls(
    hulls: &[FinalHull],
    most: usize,
    patches: &Patches,
    solid: &Solid,
    settings: &Settings,
    control: &Control,
) -> Result<Vec<FinalHull>, Error> {
    let leaves = hulls.iter().map(|hull| (hull.hull.clone(), hull.protrusion)).collect();
    let hierarchy = Hierarchy::new(leaves, most, solid, settings, control)?;
    let mut limited = Vec::new();
    for index in hierarchy.state(hierarchy.joins()) {
        let leaves = hierarchy.leaves_of(index);
        let members: Vec<&FinalHull> = leaves.iter().filter_map(|&leaf| hulls.get(leaf)).collect();
        let Some(first) = members.first() else { continue };
        let node = &hierarchy.nodes[index];
        let largest = |value: fn(&FinalHull) -> f64| {
            members.iter().map(|&hull| value(hull)).fold(0.0, f64::max)
        };
        let mut set = PatchSet::empty(patches.count());
        members.iter().for_each(|hull| set.union_with(&hull.patches));
        // Another hull may represent the rest of a divided patch.
        let has_parts = members.iter().any(|hull| hull.part.is_some());
        let part =
            has_parts.then(|| members.iter().flat_map(|hull| hull.triangles(patches)).collect());
        limited.push(FinalHull {
            hull: node.hull.clone(),
            patches: set,
            part,
            inner_points: Vec::new(),
            added_thickness: largest(|hull| hull.added_thickness),
            simplification_growth: node.growth.max(largest(|hull| hull.simplification_growth)),
            protrusion: node.protrusion,
            uncovered: largest(|hull| hull.uncovered),
            component: first.component,
        });
    }
    Ok(limited)
}
