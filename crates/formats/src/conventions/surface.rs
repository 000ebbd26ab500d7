//! Friction, restitution, sensors, groups and events, as extras of a glTF file say them:
//! `{"friction": 0.2, "sensor": true, "collision_groups": "1 / 1 2"}`. Names are Rapier's.

use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

use super::values::{Complaint, boolean, named};

/// How the coefficients of two colliders in contact become one. An engine has its own order of
/// precedence where the rules of two colliders differ.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum CombineRule {
    /// Their mean.
    Average,
    /// The smaller one.
    Min,
    /// Their product.
    Multiply,
    /// The larger one.
    Max,
}

/// What a collider is a member of, and what it interacts with: two colliders do if each is a member
/// of a group in the other's filter. Bit `n - 1` is group `n`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct Groups {
    /// Groups that it is a member of.
    pub memberships: u32,
    /// Groups that it interacts with.
    pub filters: u32,
}

/// Which events a collider sends.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Serialize, Deserialize)]
pub struct Events {
    /// When contacts begin and end.
    pub collision: bool,
    /// When contact forces exceed a threshold.
    pub contact_force: bool,
}

/// What extras or a physics extension say of the surface of colliders. `None` leaves a property to
/// what is above, and at last to the engine.
#[non_exhaustive]
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(default)]
pub struct SurfaceProperties {
    /// Coefficient of friction, at least 0.
    pub friction: Option<f32>,
    /// Coefficient of friction at rest, at least 0, for engines that have one of its own.
    pub static_friction: Option<f32>,
    /// How the coefficients of friction are combined.
    pub friction_combine_rule: Option<CombineRule>,
    /// Coefficient of restitution, at least 0.
    pub restitution: Option<f32>,
    /// How the coefficients of restitution are combined.
    pub restitution_combine_rule: Option<CombineRule>,
    /// Whether it only detects what overlaps it.
    pub sensor: Option<bool>,
    /// Which contacts are computed at all.
    pub collision_groups: Option<Groups>,
    /// Which contacts push.
    pub solver_groups: Option<Groups>,
    /// Which events it sends.
    pub active_events: Option<Events>,
    /// Events about contact forces are sent from this force on, in newtons, at least 0.
    pub contact_force_event_threshold: Option<f32>,
    /// The distance by which the collider counts as larger in contacts, in units of the world, at
    /// least 0.
    pub contact_skin: Option<f32>,
}

/// The keys, the values that they take, and whether no other tool uses them.
pub(super) const SURFACE_SETTINGS: [(&str, &str, bool); 10] = [
    ("friction", "a number from 0", false),
    ("friction_combine_rule", RULES_TEXT, true),
    ("restitution", "a number from 0", false),
    ("restitution_combine_rule", RULES_TEXT, true),
    ("sensor", "true or false", false),
    ("collision_groups", GROUPS_TEXT, true),
    ("solver_groups", GROUPS_TEXT, true),
    ("active_events", "\"collision_events\", \"contact_force_events\", or both in a list", true),
    ("contact_force_event_threshold", "a number from 0", true),
    ("contact_skin", "a number from 0", true),
];

const RULES_TEXT: &str = "\"average\", \"min\", \"multiply\" or \"max\"";

const GROUPS_TEXT: &str = "groups from 1 to 32, those it is a member of before a stroke and those \
                           it meets after it, such as \"1 / 1 2\" or \"2 / all\"";

const RULES: [(&str, CombineRule); 6] = [
    ("average", CombineRule::Average),
    ("min", CombineRule::Min),
    ("multiply", CombineRule::Multiply),
    ("max", CombineRule::Max),
    ("minimum", CombineRule::Min),
    ("maximum", CombineRule::Max),
];

/// Reads what extras say of surfaces, with or without `collider` beside it. Nothing if they are no
/// JSON.
///
/// A value that means nothing is left out. It has a complaint if the key is hardly anybody else's,
/// or stands beside `collider`.
///
/// ```
/// use hullwright_formats::conventions::{Groups, read_surface};
///
/// let (surface, complaints) = read_surface(r#"{"friction": 0.2, "collision_groups": "1 / 1 3"}"#);
/// assert_eq!(surface.friction, Some(0.2));
/// assert_eq!(surface.collision_groups, Some(Groups { memberships: 0b1, filters: 0b101 }));
/// assert!(complaints.is_empty());
/// ```
pub fn read_surface(text: &str) -> (SurfaceProperties, Vec<Complaint>) {
    let (mut surface, mut complaints) = (SurfaceProperties::default(), Vec::new());
    let Ok(Value::Object(extras)) = serde_json::from_str(text) else {
        return (surface, complaints);
    };
    let is_ours = extras.contains_key("collider");
    for (key, expected, is_only_ours) in SURFACE_SETTINGS {
        let Some(value) = extras.get(key) else { continue };
        if surface.set(key, value).is_none() && (is_ours || is_only_ours) {
            complaints.push(format!("\"{key}\" is {value}, and should be {expected}"));
        }
    }
    (surface, complaints)
}

impl SurfaceProperties {
    /// The same, with what it says nothing of from another one. O(1).
    #[must_use]
    pub fn or(self, other: Self) -> Self {
        Self {
            friction: self.friction.or(other.friction),
            static_friction: self.static_friction.or(other.static_friction),
            friction_combine_rule: self.friction_combine_rule.or(other.friction_combine_rule),
            restitution: self.restitution.or(other.restitution),
            restitution_combine_rule: self
                .restitution_combine_rule
                .or(other.restitution_combine_rule),
            sensor: self.sensor.or(other.sensor),
            collision_groups: self.collision_groups.or(other.collision_groups),
            solver_groups: self.solver_groups.or(other.solver_groups),
            active_events: self.active_events.or(other.active_events),
            contact_force_event_threshold: self
                .contact_force_event_threshold
                .or(other.contact_force_event_threshold),
            contact_skin: self.contact_skin.or(other.contact_skin),
        }
    }

    /// `None` if the value means nothing.
    fn set(&mut self, key: &str, value: &Value) -> Option<()> {
        match key {
            "friction" => self.friction = Some(coefficient(value)?),
            "friction_combine_rule" => self.friction_combine_rule = Some(combine_rule(value)?),
            "restitution" => self.restitution = Some(coefficient(value)?),
            "restitution_combine_rule" => {
                self.restitution_combine_rule = Some(combine_rule(value)?);
            }
            "sensor" => self.sensor = Some(boolean(value)?),
            "collision_groups" => self.collision_groups = Some(groups(value)?),
            "solver_groups" => self.solver_groups = Some(groups(value)?),
            "active_events" => self.active_events = Some(events(value)?),
            "contact_force_event_threshold" => {
                self.contact_force_event_threshold = Some(coefficient(value)?);
            }
            "contact_skin" => self.contact_skin = Some(coefficient(value)?),
            _ => return None,
        }
        Some(())
    }
}

/// A finite number from 0.
pub(super) fn coefficient(value: &Value) -> Option<f32> {
    value.as_f64().map(|x| x as f32).filter(|x| x.is_finite() && *x >= 0.0)
}

/// A rule by Rapier's name or by that of the physics extensions.
pub(super) fn combine_rule(value: &Value) -> Option<CombineRule> {
    named(value, &RULES)
}

fn events(value: &Value) -> Option<Events> {
    let names: Vec<&str> = match value {
        Value::String(name) => vec![name],
        Value::Array(names) => names.iter().map(Value::as_str).collect::<Option<_>>()?,
        _ => return None,
    };
    let mut events = Events::default();
    for name in names {
        match name {
            "collision_events" => events.collision = true,
            "contact_force_events" => events.contact_force = true,
            _ => return None,
        }
    }
    Some(events)
}

/// As a text, which is all that Blender's panel can hold, or as an object of two lists.
fn groups(value: &Value) -> Option<Groups> {
    let (memberships, filters) = match value {
        Value::String(text) => {
            let (memberships, filters) = text.split_once('/')?;
            (groups_in_text(memberships)?, groups_in_text(filters)?)
        }
        Value::Object(of) => (groups_in(of, "memberships")?, groups_in(of, "filters")?),
        _ => return None,
    };
    Some(Groups { memberships, filters })
}

fn groups_in_text(text: &str) -> Option<u32> {
    match text.trim() {
        "all" => Some(u32::MAX),
        "none" => Some(0),
        list => {
            let mut numbers =
                list.split(|c: char| c == ',' || c.is_whitespace()).filter(|it| !it.is_empty());
            let mut bits = 0;
            let first = numbers.next()?;
            for number in std::iter::once(first).chain(numbers) {
                bits |= group(number.parse().ok()?)?;
            }
            Some(bits)
        }
    }
}

/// All where the list is absent.
fn groups_in(of: &Map<String, Value>, key: &str) -> Option<u32> {
    let Some(list) = of.get(key) else { return Some(u32::MAX) };
    list.as_array()?.iter().try_fold(0, |bits, number| {
        let number = number.as_f64().filter(|x| x.fract() == 0.0)?;
        Some(bits | group(number as i64)?)
    })
}

fn group(number: i64) -> Option<u32> {
    (1..=32).contains(&number).then(|| 1 << (number - 1))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_property_is_read_with_and_without_a_collider() {
        for collider in ["", r#""collider": "hulls", "#] {
            let (surface, complaints) = read_surface(&format!(
                r#"{{{collider}"friction": 0.25, "friction_combine_rule": "min", "restitution": 1,
                "restitution_combine_rule": "max", "sensor": 1, "collision_groups": "1, 2 / 32",
                "solver_groups": {{"memberships": [3]}}, "active_events": ["contact_force_events"],
                "contact_force_event_threshold": 10, "contact_skin": 0.01}}"#
            ));
            assert_eq!(complaints, Vec::<String>::new());
            let expected = SurfaceProperties {
                friction: Some(0.25),
                static_friction: None,
                friction_combine_rule: Some(CombineRule::Min),
                restitution: Some(1.0),
                restitution_combine_rule: Some(CombineRule::Max),
                sensor: Some(true),
                collision_groups: Some(Groups { memberships: 0b11, filters: 1 << 31 }),
                solver_groups: Some(Groups { memberships: 0b100, filters: u32::MAX }),
                active_events: Some(Events { collision: false, contact_force: true }),
                contact_force_event_threshold: Some(10.0),
                contact_skin: Some(0.01),
            };
            assert_eq!(surface, expected);
        }
    }

    #[test]
    fn groups_are_numbers_all_or_none() {
        let read = |text: &str| read_surface(&format!(r#"{{"solver_groups": "{text}"}}"#));
        for (text, memberships, filters) in
            [("all / none", u32::MAX, 0), ("2/all", 0b10, u32::MAX), (" 1 3 / 1,,2 ", 0b101, 0b11)]
        {
            assert_eq!(read(text).0.solver_groups, Some(Groups { memberships, filters }), "{text}");
        }
        for text in ["", "1", "/", "1 /", "0 / 1", "1 / 33", "1 / 2 / 3", "a / 1", "-1 / 1"] {
            let (surface, complaints) = read(text);
            assert_eq!((surface, complaints.len()), (SurfaceProperties::default(), 1), "{text}");
        }
    }

    #[test]
    fn a_wrong_value_is_somebody_elses_unless_the_key_or_a_collider_says_otherwise() {
        for (key, value, is_only_ours) in [
            ("friction", "-1", false),
            ("friction", "\"low\"", false),
            ("restitution", "null", false),
            ("sensor", "\"ultrasonic\"", false),
            ("friction_combine_rule", "\"mean\"", true),
            ("collision_groups", "{\"memberships\": [33]}", true),
            ("active_events", "\"all\"", true),
            ("contact_skin", "-0.1", true),
        ] {
            let (surface, complaints) = read_surface(&format!(r#"{{"{key}": {value}}}"#));
            assert_eq!(
                (surface, complaints.len()),
                (SurfaceProperties::default(), usize::from(is_only_ours))
            );
            let beside = format!(r#"{{"collider": "hulls", "{key}": {value}}}"#);
            assert_eq!(read_surface(&beside).1.len(), 1, "{beside}");
        }
        for text in ["", "[]", "{", "7"] {
            assert_eq!(read_surface(text), (SurfaceProperties::default(), Vec::new()));
        }
    }

    #[test]
    fn what_one_says_nothing_of_is_the_others() {
        let [near, far] = [r#"{"friction": 0.1}"#, r#"{"friction": 0.9, "sensor": true}"#]
            .map(|text| read_surface(text).0);
        let both = near.or(far);
        assert_eq!((both.friction, both.sensor), (Some(0.1), Some(true)));
    }
}
