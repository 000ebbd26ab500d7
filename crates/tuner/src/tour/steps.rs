//! What the tour does, and what has to come of it.

use std::path::PathBuf;

use hullwright::{Openings, Preset};
use hullwright_formats::conventions::read_extras;

use super::hand::Deed;
use super::seen::Seen;
use crate::balls::THROW;
use crate::decompose::Settings;
use crate::export::{extras, rust};
use crate::model::bundled;
use crate::scene::{STACK, Trial};

/// When a step's picture is taken.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum When {
    /// When the hulls are there and all bodies lie still.
    Settled,
    /// After this many frames, whatever moves.
    Frames(usize),
    /// While a job has run for some time: the old hulls have to be there still.
    Busy,
}

/// A step: its name, what is done, when the picture is taken, and what has to be true then of what
/// was seen before and is seen now.
pub struct Step {
    /// Also the picture's name.
    pub name: &'static str,
    /// What is done, one after the other.
    pub deeds: Vec<Deed>,
    /// When its picture is taken.
    pub when: When,
    /// What has to be true, in words.
    pub promise: &'static str,
    /// Whether it is.
    pub holds: fn(&Seen, &Seen) -> bool,
}

fn step(
    name: &'static str,
    deeds: impl Into<Vec<Deed>>,
    promise: &'static str,
    holds: fn(&Seen, &Seen) -> bool,
) -> Step {
    Step { name, deeds: deeds.into(), when: When::Settled, promise, holds }
}

impl Step {
    fn at(self, when: When) -> Self {
        Self { when, ..self }
    }
}

/// Every control once, in an order that tells a story.
pub fn steps() -> Vec<Step> {
    [settings(), views(), models(), trials(), exports()].into_iter().flatten().collect()
}

fn settings() -> Vec<Step> {
    use Deed::{Click, Key, Point, Slide};
    vec![
        step("start", [], "the mug has hulls within the bound", |_, now| {
            now.model == "mug" && now.hulls > 1 && now.errors.iter().all(|error| *error <= 2.0)
        }),
        step(
            "bound-small",
            [Slide("bound", 0.35)],
            "a smaller bound has more hulls",
            |old, now| now.settings.bound < old.settings.bound && now.hulls > old.hulls,
        ),
        step("bound-large", [Slide("bound", 0.8)], "a larger bound has fewer hulls", |old, now| {
            now.settings.bound > old.settings.bound && now.hulls < old.hulls
        }),
        step(
            "bound-by-keys",
            [Key("0"), Key("["), Key("["), Key("]")],
            "keys change it",
            |_, now| now.settings.bound < Settings::default().bound,
        ),
        step(
            "probe",
            [Key("0"), Slide("probe", 0.5)],
            "there are fewer hulls, and what they may fill",
            |old, now| now.settings.probe > 4.0 && now.hulls < old.hulls && now.filled > 0,
        ),
        step(
            "filled",
            [Click("filled"), Point(0.62, 0.5)],
            "it is seen, and a ball at the pointer",
            |_, now| now.show.filled && now.is_ball_seen,
        ),
        step("no-probe", [Click("filled"), Slide("probe", 0.0)], "nothing is filled", |_, now| {
            now.settings.probe == 0.0 && now.filled == 0 && !now.is_ball_seen
        }),
        step(
            "cap-on-hulls",
            [Click("cap hulls"), Slide("max hulls", 0.45)],
            "it is kept",
            |_, now| now.settings.max_hulls.is_some_and(|most| now.hulls <= most && most < 16),
        ),
        step("no-cap-on-hulls", [Click("cap hulls")], "it is gone", |old, now| {
            now.settings.max_hulls.is_none() && now.hulls > old.hulls
        }),
        step("cap-on-vertices", [Slide("max vertices", 0.2)], "it is kept", |old, now| {
            now.settings.max_vertices.is_some_and(|most| most < 32) && now.vertices < old.vertices
        }),
        step("no-cap-on-vertices", [Click("cap vertices")], "it is gone", |_, now| {
            now.settings.max_vertices.is_none()
        }),
        step("preset-fast", [Click("fast")], "it is set", |_, now| {
            now.settings.preset == Preset::Fast
        }),
        step("preset-fine", [Click("fine")], "it is set", |_, now| {
            now.settings.preset == Preset::Fine
        }),
        step("openings-keep", [Click("keep")], "it is set", |_, now| {
            now.settings.openings == Openings::Keep
        }),
        step("openings-close", [Click("close")], "it is set", |_, now| {
            now.settings.openings == Openings::Close
        }),
        step("cavities", [Click("cavities")], "it is set", |_, now| now.settings.keep_cavities),
        step(
            "default-settings",
            [Click("default settings")],
            "they are as at the start",
            |_, now| now.settings == Settings::default(),
        ),
    ]
}

fn views() -> Vec<Step> {
    use Deed::{Click, Drag, Key, Slide, Wheel};
    vec![
        step("hulls-alone", [Click("mesh")], "the mesh is hidden", |_, now| !now.show.mesh),
        step("mesh-alone", [Click("mesh"), Click("hulls")], "the hulls are", |_, now| {
            now.show.mesh && !now.show.hulls
        }),
        step("without-edges", [Click("hulls"), Click("edges")], "the edges are", |_, now| {
            now.show.hulls && !now.show.edges
        }),
        step("apart", [Click("edges"), Slide("apart", 0.5)], "hulls move apart", |_, now| {
            now.show.explosion > 0.5
        }),
        step("turned", [Drag(-220.0, 60.0), Wheel(2.0)], "the camera follows", |old, now| {
            now.azimuth > old.azimuth
                && now.elevation > old.elevation
                && now.distance < old.distance
        }),
        step("together", [Key("x")], "hulls are together again", |_, now| {
            now.show.explosion == 0.0
        }),
        step("z-up", [Click("z up")], "it lies on its back", |_, now| now.show.z_up),
        step("y-up", [Key("z")], "it stands again", |_, now| !now.show.z_up),
    ]
}

fn models() -> Vec<Step> {
    use Deed::{Click, DropFile, Key, Type, Wait};
    let path = |name: &str| bundled(name).to_string_lossy().into_owned();
    vec![
        step("bundled", [Click("bundled"), Wait(3)], "the list is open", |_, now| now.is_list_open)
            .at(When::Frames(8)),
        step("chair", [Click("chair")], "the chair is there", |_, now| now.model == "chair"),
        step(
            "path",
            [Click("path"), Type(path("teapot")), Click("open")],
            "a path opens",
            |_, now| now.model == "teapot",
        ),
        step("dropped-file", [DropFile(bundled("lamp"))], "a dropped file opens", |_, now| {
            now.model == "lamp"
        }),
        step("no-mesh", [DropFile(PathBuf::from("Cargo.toml"))], "it says why not", |old, now| {
            now.model == old.model && now.error.is_some()
        }),
        step("next", [Key("n")], "the gear is next", |_, now| {
            now.model == "gear" && now.error.is_none()
        }),
        step(
            "before",
            [Key("p"), Wait(60), Key("p"), Wait(60), Key("p")],
            "and the dog before",
            |_, now| now.model == "dog",
        ),
        step(
            "busy",
            [Deed::Slide("bound", 0.03), Click("fine")],
            "the old hulls stay",
            |old, now| now.is_busy && now.hulls == old.hulls,
        )
        .at(When::Busy),
        step("overtaken", [Key("0")], "newer settings cancel it", |_, now| {
            !now.is_busy && now.settings == Settings::default()
        }),
    ]
}

fn trials() -> Vec<Step> {
    use Deed::{Click, DropFile, Key, Slide};
    vec![
        step("drop", [Click("drop")], "it has fallen and lies still", |_, now| {
            now.show.trial == Trial::Drop && now.things == 1 && now.highest < 0.8 && now.is_still
        }),
        step("drop-again", [Click("again")], "it is in the air", |old, now| {
            now.show.attempt > old.show.attempt && now.highest > 0.8
        })
        .at(When::Frames(3)),
        step("hook-mug", [DropFile(bundled("mug")), Click("hook")], "it hangs", |_, now| {
            now.show.trial == Trial::Hook && now.lowest > 0.75
        }),
        step("hook-filled", [Slide("bound", 0.96)], "a filled handle falls", |old, now| {
            now.hulls < old.hulls && now.lowest < old.lowest - 0.1
        }),
        step("hook-chair", [Key("0"), DropFile(bundled("chair"))], "it hangs", |_, now| {
            now.model == "chair" && now.lowest > 0.3
        }),
        step("hook-no-hole", [DropFile(bundled("bowl"))], "it is laid on the hook", |_, now| {
            now.model == "bowl" && now.things == 1
        }),
        step("stack-bowls", [Click("stack ten")], "ten bowls nest", |_, now| {
            now.things == STACK && now.highest < 3.5
        }),
        step("stack-chairs", [DropFile(bundled("chair"))], "there are ten", |_, now| {
            now.things == STACK
        }),
        step("balls-at-stack", [Key("b")], "balls fly", |old, now| now.balls == old.balls + THROW)
            .at(When::Frames(14)),
        step("bowl", [Key("1"), DropFile(bundled("bowl"))], "balls go with the model", |_, now| {
            now.model == "bowl" && now.balls == 0
        }),
        step("balls-in-bowl", [Key("b")], "balls are thrown", |_, now| now.balls == THROW),
        step("more-balls", [Click("throw balls")], "more are", |_, now| now.balls == 2 * THROW),
    ]
}

fn exports() -> Vec<Step> {
    use Deed::{Click, DropFile, Key, Slide};
    vec![
        step(
            "copy-rust",
            [DropFile(bundled("mug")), Slide("bound", 0.45), Click("copy as Rust")],
            "the clipboard has it",
            |_, now| now.copied.as_ref() == Some(&rust(&now.settings, now.diagonal)),
        ),
        step(
            "copy-extras",
            [Click("copy as extras")],
            "the clipboard has what the plugin reads",
            |_, now| {
                let copied = now.copied.as_deref().map(read_extras);
                now.copied.as_ref() == Some(&extras(&now.settings, now.diagonal))
                    && copied.is_some_and(|(tag, wrong)| tag.is_some() && wrong.is_empty())
            },
        ),
        step("save-hulls", [Click("save .hulls")], "the file holds these hulls", |_, now| {
            now.saved("hulls") == Some(now.hulls)
        }),
        step("save-glb", [Click("save .glb")], "the file holds these hulls", |_, now| {
            now.saved("glb") == Some(now.hulls)
        }),
        step("keys", [Key("?")], "the keys are listed", |_, now| now.help),
        step("keys-gone", [Key("?")], "and gone", |_, now| !now.help),
    ]
}
