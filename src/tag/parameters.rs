//! From the tag's flat settings to the library's parameters, and what the plugin needs to know of
//! these: the only file that looks into them.

use hullwright::{ALGORITHM_VERSION, Length, Method, Openings, Parameters};
#[cfg(feature = "bevy_gltf")]
use hullwright_formats::conventions::Fallback;
use sha2::{Digest, Sha256};

use super::outcomes::SkipReason;
#[cfg(feature = "bevy_gltf")]
use super::settings::FallbackCollider;
use super::{ConvexDecomposition, DecompositionShape, MaxError};

/// Which of the physics engine's own shapes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) enum PrimitiveKind {
    Cuboid,
    Ball,
    Capsule,
}

/// What is made of a mesh.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Goal {
    /// Hulls by this method.
    Hulls(Method),
    /// Triangles, and why.
    Triangles {
        reason: SkipReason,
        /// How far they may be from the mesh, in metres of the world; `None` for its own.
        bound: Option<f32>,
    },
    /// A box, ball or capsule around it.
    Primitive(PrimitiveKind),
}

impl Goal {
    /// What a tag requests, if it gets no triangles. Where it has no probe of its own,
    /// `probe_radius` holds.
    pub(crate) fn of(tag: &ConvexDecomposition, probe_radius: Option<f32>) -> Self {
        let mut goal = Self::of_tag(tag);
        if let (Self::Hulls(Method::Bounded(parameters)), None) = (&mut goal, &tag.parameters)
            && parameters.probe_radius.is_none()
            && !parameters.keep_cavities
        {
            parameters.probe_radius = probe_radius.map(metres);
        }
        goal
    }

    /// The triangles of what has this tag. Where it says nothing of a bound, `level_bound` holds.
    pub(crate) fn triangles(
        tag: &ConvexDecomposition,
        reason: SkipReason,
        level_bound: Option<f32>,
    ) -> Self {
        let bound = tag.level_bound.or(level_bound).filter(|bound| *bound != 0.0);
        Self::Triangles { reason, bound }
    }

    fn of_tag(tag: &ConvexDecomposition) -> Self {
        match tag.shape {
            DecompositionShape::Cuboid => Self::Primitive(PrimitiveKind::Cuboid),
            DecompositionShape::Ball => Self::Primitive(PrimitiveKind::Ball),
            DecompositionShape::Capsule => Self::Primitive(PrimitiveKind::Capsule),
            DecompositionShape::ConvexHull => {
                let base = tag.flat_parameters().into();
                let hull =
                    hullwright_formats::conventions::ColliderKind::ConvexHull.parameters(&base);
                Self::Hulls(hull.unwrap_or(base))
            }
            DecompositionShape::Auto
            | DecompositionShape::Hulls
            | DecompositionShape::Triangles => Self::Hulls(tag.to_parameters()),
        }
    }

    pub(crate) fn parameters(&self) -> Option<&Method> {
        match self {
            Self::Hulls(parameters) => Some(parameters),
            Self::Triangles { .. } | Self::Primitive(_) => None,
        }
    }

    /// Why there are triangles instead of hulls.
    pub(crate) fn why_triangles(&self) -> Option<SkipReason> {
        match self {
            Self::Triangles { reason, .. } => Some(*reason),
            Self::Hulls(_) | Self::Primitive(_) => None,
        }
    }

    /// How far triangles may be from the mesh, in metres of the world; 0 for its own, and for
    /// hulls.
    pub(crate) fn bound_of_triangles(&self) -> f32 {
        match self {
            Self::Triangles { bound, .. } => bound.unwrap_or(0.0),
            Self::Hulls(_) | Self::Primitive(_) => 0.0,
        }
    }

    /// Whether it takes no more than a look at the mesh.
    pub(crate) fn is_quick(&self) -> bool {
        matches!(self, Self::Triangles { bound: None, .. } | Self::Primitive(_))
    }

    /// Whether the result depends on how large the mesh is in the world.
    pub(crate) fn has_absolute_length(&self) -> bool {
        let is_absolute = |length: Length| matches!(length, Length::Units(_));
        match self {
            Self::Hulls(Method::Bounded(of) | Method::Hull(of)) => {
                is_absolute(of.max_error) || of.probe_radius.is_some_and(is_absolute)
            }
            Self::Hulls(Method::Surface(of)) => is_absolute(of.unit),
            Self::Triangles { bound, .. } => bound.is_some(),
            Self::Primitive(_) => false,
        }
    }

    /// Whether hulls may fill what a probe can't reach.
    pub(crate) fn has_probe(&self) -> bool {
        self.parameters().is_some_and(
            |method| matches!(method, Method::Bounded(of) if of.probe_radius.is_some()),
        )
    }

    /// For one part of a larger mesh: what is open on it is closed by the other parts.
    pub(crate) fn keep_openings_of_part(&mut self) {
        if let Self::Hulls(Method::Bounded(parameters) | Method::Hull(parameters)) = self
            && parameters.openings == Openings::Auto
        {
            parameters.openings = Openings::Keep;
        }
    }

    /// Hash of what is made, whichever mesh it is made of.
    pub(crate) fn hash(&self) -> [u8; 32] {
        let mut hasher = Sha256::new_with_prefix(ALGORITHM_VERSION.to_le_bytes());
        hasher.update([match self {
            Self::Triangles { .. } => 0,
            Self::Hulls(_) => 1,
            Self::Primitive(PrimitiveKind::Cuboid) => 2,
            Self::Primitive(PrimitiveKind::Ball) => 3,
            Self::Primitive(PrimitiveKind::Capsule) => 4,
        }]);
        match self {
            Self::Hulls(parameters) => hasher.update(parameters.fingerprint()),
            Self::Triangles { bound: Some(bound), .. } => {
                hasher.update(bound.to_le_bytes());
            }
            Self::Triangles { bound: None, .. } | Self::Primitive(_) => {}
        }
        hasher.finalize().into()
    }
}

impl ConvexDecomposition {
    /// The method that makes the hulls: [`parameters`](Self::parameters) if they are given, else
    /// the one of the tag's own settings.
    pub fn to_parameters(&self) -> Method {
        self.parameters.clone().unwrap_or_else(|| self.flat_parameters().into())
    }

    fn flat_parameters(&self) -> Parameters {
        Parameters::default()
            .with_max_error(self.max_error.into())
            .with_preset(self.preset)
            .with_max_hulls(self.max_hulls.map(|limit| limit as usize))
            .with_max_vertices(self.max_vertices.map(|limit| limit as usize))
            .with_keep_cavities(self.keep_cavities)
            .with_openings(self.openings)
            .with_probe_radius(self.probe_radius.map(metres))
    }
}

impl From<MaxError> for Length {
    fn from(max_error: MaxError) -> Self {
        match max_error {
            MaxError::Share(share) => Self::Share(as_written(share)),
            MaxError::Metres(length) => metres(length),
        }
    }
}

/// A length of the world.
pub(crate) fn metres(length: f32) -> Length {
    Length::Units(as_written(length))
}

/// The shortest decimal that rounds to a number: 0.02 and not 0.0199999996, so that hulls are those
/// that the library and the command line make with the bound that the user wrote.
fn as_written(x: f32) -> f64 {
    x.to_string().parse().unwrap_or(f64::from(x))
}

impl From<Length> for MaxError {
    fn from(length: Length) -> Self {
        match length {
            Length::Share(share) => Self::Share(share as f32),
            Length::Units(metres) => Self::Metres(metres as f32),
        }
    }
}

#[cfg(feature = "bevy_gltf")]
impl From<Fallback> for FallbackCollider {
    fn from(fallback: Fallback) -> Self {
        match fallback {
            Fallback::None => Self::None,
            Fallback::ConvexHull => Self::ConvexHull,
            Fallback::BoundingBox => Self::BoundingBox,
        }
    }
}

#[cfg(test)]
mod tests {
    use hullwright::Preset;

    use super::*;

    #[test]
    fn the_default_tag_asks_for_the_librarys_default() {
        assert_eq!(ConvexDecomposition::default().to_parameters(), Method::default());
    }

    #[test]
    fn every_setting_of_the_tag_is_a_parameter() {
        let tag = ConvexDecomposition::default()
            .with_max_error(0.013)
            .with_preset(Preset::Fine)
            .with_max_hulls(7)
            .with_max_vertices(20)
            .with_keep_cavities(true)
            .with_openings(Openings::Keep)
            .with_probe_radius(0.1);
        let expected = Parameters::default()
            .with_max_error(Length::share(0.013))
            .with_preset(Preset::Fine)
            .with_max_hulls(7)
            .with_max_vertices(20)
            .with_keep_cavities(true)
            .with_openings(Openings::Keep)
            .with_probe_radius(Length::units(0.1));
        assert_eq!(tag.to_parameters(), expected.into());
        let metres = tag.with_max_error(MaxError::Metres(0.1)).flat_parameters();
        assert_eq!(metres.max_error, Length::units(0.1));
    }

    #[test]
    fn the_probe_of_the_settings_is_for_tags_that_say_nothing_of_it_and_keep_no_cavities() {
        let probe = |tag: ConvexDecomposition| match Goal::of(&tag, Some(0.2)) {
            Goal::Hulls(Method::Bounded(parameters)) => parameters.probe_radius,
            _ => None,
        };
        let tag = ConvexDecomposition::default;
        assert_eq!(probe(tag()), Some(Length::units(0.2)));
        assert_eq!(probe(tag().with_probe_radius(0.1)), Some(Length::units(0.1)));
        assert_eq!(probe(tag().with_keep_cavities(true)), None);
        assert_eq!(probe(tag().with_parameters(Parameters::default())), None);
        assert!(Goal::of(&tag(), Some(0.2)).has_absolute_length());
        // Both at once contradict each other.
        let both = tag().with_probe_radius(0.1).with_keep_cavities(true);
        assert!(both.to_parameters().validate().is_err());
    }

    #[test]
    fn a_bound_that_is_no_number_stays_none_and_is_refused() {
        for share in [f32::NAN, f32::INFINITY, -0.5, 0.0] {
            let tag = ConvexDecomposition::default().with_max_error(share);
            assert!(tag.to_parameters().validate().is_err(), "{share}");
        }
    }

    #[test]
    fn keys_of_caches_on_disk_stay_what_they_are() {
        for (text, expected) in KEYS {
            let method: Method = text.parse().unwrap();
            let hash: String = Sha256::digest(method.fingerprint())
                .iter()
                .map(|byte| format!("{byte:02x}"))
                .collect();
            assert_eq!(hash[..16], *expected, "{text}");
        }
    }

    /// Computed by hand from the layout that version 0.1 has.
    const KEYS: [(&str, &str); 5] = [
        ("", "3211bdd0ccd190b3"),
        ("max_error=1% preset=fine max_hulls=32 keep_cavities=true", "2c3dd7790ddaf23b"),
        ("method=surface max_vertices=none", "5988c0db962c82cd"),
        ("method=surface maximum_resolutions=250,500 unit=1.5m", "25cda2332a0d6d47"),
        ("method=hull max_vertices=16 openings=keep up_axis=z", "87f079ead0363924"),
    ];
}
