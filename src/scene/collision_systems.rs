//! Names of collision systems, by which physics extensions say what collides, as an engine's
//! groups.

use bevy::prelude::*;
use hullwright_formats::conventions::{CollisionFilter, Groups};

/// Which collision group each collision system of glTF's physics extensions has: the first name has
/// group 2. Files add the names that are new, so that the same name is the same group in all of
/// them. Group 1 has what is in no system, and all filters let it pass.
///
/// A game whose own colliders meet those of files says the names first:
///
/// ```
/// use bevy::prelude::*;
/// use bevy_hullwright::prelude::*;
///
/// # let mut app = App::new();
/// app.insert_resource(CollisionSystems::new(["landscape", "character"]));
/// # let systems = app.world().resource::<CollisionSystems>();
/// assert_eq!(systems.group("character"), Some(0b100));
/// ```
#[derive(Resource, Reflect, Debug, Clone, PartialEq, Eq, Default)]
#[reflect(Resource, Default, Clone, PartialEq)]
#[type_path = "hullwright"]
pub struct CollisionSystems {
    names: Vec<String>,
}

/// Systems that have a group: engines have 32, and one is for what is in no system.
const MOST: usize = 31;

/// The group of colliders that are in no system. Avian's without layers are in this one alone, and
/// Rapier's without groups in all.
const IN_NO_SYSTEM: u32 = 1;

impl CollisionSystems {
    /// With these names. The first has group 2, and those after the 31st have none.
    pub fn new(names: impl IntoIterator<Item = impl Into<String>>) -> Self {
        Self { names: names.into_iter().take(MOST).map(Into::into).collect() }
    }

    /// The bit of a system's group; `None` for one that has none. O(systems).
    pub fn group(&self, system: &str) -> Option<u32> {
        self.names.iter().position(|name| name == system).map(bit)
    }

    /// The groups that a filter stands for. Systems for which no group is left are named, and left
    /// out.
    pub(super) fn groups(&mut self, filter: &CollisionFilter) -> (Groups, Vec<String>) {
        let mut without = Vec::new();
        let mut bits = |names: &[String]| {
            let mut bits = 0;
            for name in names {
                match self.group_or_new(name) {
                    Some(group) => bits |= group,
                    None => without.push(name.clone()),
                }
            }
            bits
        };
        let memberships = match bits(&filter.systems) {
            0 => IN_NO_SYSTEM,
            memberships => memberships,
        };
        let filters = match &filter.collide_with {
            Some(systems) => bits(systems) | IN_NO_SYSTEM,
            None => !bits(&filter.not_collide_with) | IN_NO_SYSTEM,
        };
        (Groups { memberships, filters }, without)
    }

    fn group_or_new(&mut self, system: &str) -> Option<u32> {
        if let Some(group) = self.group(system) {
            return Some(group);
        }
        if self.names.len() >= MOST {
            return None;
        }
        self.names.push(system.to_owned());
        Some(bit(self.names.len() - 1))
    }
}

/// The group of the name with this index.
fn bit(index: usize) -> u32 {
    IN_NO_SYSTEM << (index + 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(names: &[&str]) -> Vec<String> {
        names.iter().map(|name| (*name).to_owned()).collect()
    }

    fn filter(systems: &[&str], with: Option<&[&str]>, without: &[&str]) -> CollisionFilter {
        CollisionFilter {
            systems: names(systems),
            collide_with: with.map(names),
            not_collide_with: names(without),
        }
    }

    #[test]
    fn colliders_meet_as_their_systems_say() {
        let mut systems = CollisionSystems::default();
        let mut groups = |filter: CollisionFilter| {
            let (groups, without) = systems.groups(&filter);
            assert!(without.is_empty());
            groups
        };
        let world = groups(filter(&["world"], None, &[]));
        let ghost = groups(filter(&["ghost"], None, &["world"]));
        let picky = groups(filter(&["picky"], Some(&["world"]), &[]));
        let plain = groups(filter(&[], None, &["ghost"]));
        let [in_rapier, in_avian] =
            [u32::MAX, 1].map(|memberships| Groups { memberships, filters: u32::MAX });
        let meet =
            |a: Groups, b: Groups| a.memberships & b.filters != 0 && b.memberships & a.filters != 0;
        for (a, b, expected) in [
            (world, ghost, false),
            (world, picky, true),
            (picky, ghost, false),
            (plain, ghost, false),
            (plain, world, true),
            (plain, picky, true),
            (ghost, ghost, true),
            (in_rapier, world, true),
            (in_rapier, picky, true),
            (in_avian, picky, true),
            (in_avian, ghost, true),
        ] {
            assert_eq!((meet(a, b), meet(b, a)), (expected, expected), "{a:?} {b:?}");
        }
    }

    #[test]
    fn names_that_the_game_says_first_have_the_first_groups() {
        let mut systems = CollisionSystems::new(["a", "b"]);
        systems.groups(&filter(&["c", "b"], None, &[]));
        assert_eq!(
            ["a", "b", "c", "d"].map(|name| systems.group(name)),
            [Some(2), Some(4), Some(8), None]
        );
    }

    #[test]
    fn a_system_too_many_is_named() {
        let all: Vec<String> = (0..40).map(|index| format!("system {index}")).collect();
        let mut systems = CollisionSystems::default();
        let (groups, without) =
            systems.groups(&CollisionFilter { systems: all, ..CollisionFilter::default() });
        assert_eq!((groups.memberships, without.len()), (!IN_NO_SYSTEM, 9));
    }
}
