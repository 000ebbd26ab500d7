//! What the stages work with: the bound and shares of it, and how finely a preset divides the
//! surface. Lengths are fractions of the diagonal.

use std::ops::RangeInclusive;

use crate::mesh::Normalization;
use crate::parameters::{Length, Parameters, Preset};
use crate::probe::ProbeSettings;
use crate::solid::{COARSE, SolidSettings};

/// What the exact surface may have moved, as a fraction of the bound.
const EXACT_SHARE: f64 = 0.001;

/// How far detail goes, and what of the bound is left for the search. Fractions of the bound.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Shares {
    /// The coarse surface may be this far from the exact one.
    coarse: f64,
    /// The bound of the search. The rest is a margin for what its fit test overlooks, and for the
    /// detail that hulls contain in the end. More gives fewer pieces, but verification divides as
    /// many again.
    search: f64,
    /// The bound of the last round of dissolving, which has less to overlook.
    last_round: f64,
}

/// A surface of few triangles has little detail: removing more of it saves no time and costs hulls.
const OF_FEW: Shares = Shares { coarse: 0.02, search: 0.9, last_round: 0.985 };

/// The search sees a scan by a fifth of its triangles or fewer. What hulls grow by to contain its
/// detail is taken from the last round.
const OF_MANY: Shares = Shares { coarse: 0.2, search: 0.92, last_round: 0.95 };

/// Distance, as a fraction of the bound, by which the surface may lie outside a hull that leaves
/// out vertices: gaps under objects are more visible than protrusions; without it hulls would keep
/// every vertex.
pub(super) const MAX_UNCOVERED: f64 = 0.05;

/// The same for a hull that exceeds only the limit on vertices. Beyond it the hull is divided
/// instead: with half of the bound the teapot's foot goes, and it tips over.
pub(super) const MAX_UNCOVERED_UNDER_LIMIT: f64 = 0.15;

/// What patches may leave out, and the uncovered distance that counts as covered, as a fraction of
/// the bound: half of what a hull may leave out in the end.
const PATCH_SHARE_OF_UNCOVERED: f64 = 0.5 * MAX_UNCOVERED;

/// A smaller bound, as a fraction of the diagonal, is less than single precision and the minimum
/// thickness of hulls leave of a shape.
const MIN_BOUND: f64 = 1e-5;

/// Half a diagonal is more than any hull of the mesh can protrude.
const MAX_BOUND: f64 = 0.5;

/// Longest edge of a simplified mesh that is divided into patches, as a multiple of the bound.
/// Patches end at its edges: longer ones would keep hulls from ending where the shape does.
const LONGEST_EDGE: f64 = 4.0;

/// Limits of the same, as fractions of the diagonal. Small bounds would take many triangles, and
/// more time; under large bounds features of the shape are no larger than 16 % of the diagonal.
const LONGEST_EDGE_LIMITS: RangeInclusive<f64> = 0.04..=0.16;

/// Planar and angular threshold of the grouping, as a fraction of the bound: the hull of a group
/// should fit with room to spare, since groups whose hulls do not fit are halved.
const GROUPING_THRESHOLD: f64 = 0.1;

/// How finely a preset divides the surface, and how long it searches.
struct PresetSettings {
    /// Maximum diagonal of a patch, as a share of the square root of the surface's area. Smaller
    /// patches give fewer hulls and take longer: 0.12 instead of 0.15 saves 4 % of the hulls for
    /// 30 % of the time.
    patch_size: f64,
    /// Joint hulls that dissolving may test: a limit for meshes of hundreds of pieces.
    dissolve_attempts: usize,
    /// Triangles of the simplified mesh. Its triangles must be smaller than patches.
    triangles: usize,
}

/// Larger patches and no dissolving. On fewer triangles, patches around rings are so coarse that
/// verification divides again what the search has saved.
const FAST: PresetSettings =
    PresetSettings { patch_size: 0.35, dissolve_attempts: 0, triangles: 1200 };

const BALANCED: PresetSettings =
    PresetSettings { patch_size: 0.12, dissolve_attempts: 20_000, triangles: COARSE };

/// No pass suits every mesh: the one with the fewest hulls is kept.
const FINE: [PresetSettings; 3] = [
    BALANCED,
    PresetSettings { patch_size: 0.09, dissolve_attempts: 60_000, triangles: 3000 },
    PresetSettings { patch_size: 0.15, dissolve_attempts: 60_000, triangles: 1600 },
];

/// The bound, and the shares of it that the stages work with. Lengths are fractions of the
/// diagonal.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Bound {
    protrusion: f64,
    /// The requested bound, also where [`Settings::with_bound`] allows more protrusion.
    requested: f64,
    shares: Shares,
}

impl Bound {
    fn new(bound: f64) -> Self {
        let bound = bound.clamp(MIN_BOUND, MAX_BOUND);
        Self { protrusion: bound, requested: bound, shares: OF_MANY }
    }

    /// The bound on the protrusion of the hulls that are returned.
    pub(crate) fn verified(self) -> f64 {
        self.protrusion
    }

    /// The bound of the search.
    pub(crate) fn search(self) -> f64 {
        self.shares.search * self.protrusion
    }

    /// The bound of the last round of dissolving.
    pub(crate) fn last_round(self) -> f64 {
        self.shares.last_round * self.protrusion
    }

    /// How far the exact surface may be from the source.
    pub(crate) fn exact(self) -> f64 {
        EXACT_SHARE * self.requested
    }

    /// How far the coarse surface may be from the exact one.
    pub(crate) fn coarse(self) -> f64 {
        self.shares.coarse * self.protrusion
    }

    /// The bound of the parameters, whose shares may stay uncovered.
    pub(crate) fn requested(self) -> f64 {
        self.requested
    }

    /// How far the surface may be outside the hull that owns it.
    pub(crate) fn max_uncovered(self) -> f64 {
        MAX_UNCOVERED * self.requested
    }

    /// The same where the limit on vertices can't be kept otherwise.
    pub(crate) fn max_uncovered_under_limit(self) -> f64 {
        MAX_UNCOVERED_UNDER_LIMIT * self.requested
    }

    /// Points of a patch this near to the hull of its other points are left out, and uncovered
    /// surface nearer to a hull counts as covered.
    pub(crate) fn tolerance(self) -> f64 {
        PATCH_SHARE_OF_UNCOVERED * self.requested
    }

    /// Longest edge of the mesh that is divided into patches.
    pub(crate) fn longest_edge(self) -> f64 {
        let (shortest, longest) = (*LONGEST_EDGE_LIMITS.start(), *LONGEST_EDGE_LIMITS.end());
        (LONGEST_EDGE * self.protrusion).clamp(shortest, longest)
    }

    /// Planar and angular threshold of the grouping.
    pub(crate) fn grouping_threshold(self) -> f64 {
        GROUPING_THRESHOLD * self.protrusion
    }
}

/// The bound, how finely the surface is divided, and the limits on the result.
#[derive(Clone)]
pub(crate) struct Settings {
    pub bound: Bound,
    /// Triangles of the mesh that is divided into patches.
    pub triangles: usize,
    /// See [`PresetSettings::patch_size`].
    pub patch_size: f64,
    /// See [`PresetSettings::dissolve_attempts`].
    pub dissolve_attempts: usize,
    pub max_vertices: Option<usize>,
    pub max_hulls: Option<usize>,
    /// Whether a search with more hulls than the limit is given up.
    given_up_above_limit: bool,
    pub keep_cavities: bool,
    pub probe: Option<ProbeSettings>,
}

impl Settings {
    /// What the solid is made for.
    pub(crate) fn solid(&self) -> SolidSettings<'_> {
        let &Self { bound, keep_cavities, ref probe, .. } = self;
        SolidSettings { bound: bound.verified(), keep_cavities, probe: probe.as_ref() }
    }

    /// One for each pass over the surface that the preset makes. At least one.
    pub(crate) fn of_preset(parameters: &Parameters, normalization: &Normalization) -> Vec<Self> {
        let passes: &[PresetSettings] = match parameters.preset {
            Preset::Fast => &[FAST],
            Preset::Balanced => &[BALANCED],
            Preset::Fine => &FINE,
        };
        passes.iter().map(|pass| Self::new(parameters, normalization, pass)).collect()
    }

    /// For stages after the search, which do not depend on the preset.
    pub(crate) fn after_search(parameters: &Parameters, normalization: &Normalization) -> Self {
        Self::new(parameters, normalization, &BALANCED)
    }

    fn new(
        parameters: &Parameters,
        normalization: &Normalization,
        preset: &PresetSettings,
    ) -> Self {
        let &Parameters { max_error, max_hulls, max_vertices, keep_cavities, .. } = parameters;
        let &PresetSettings { patch_size, dissolve_attempts, triangles } = preset;
        let bound = match max_error {
            Length::Share(share) => share,
            Length::Units(length) => length / normalization.diagonal,
        };
        Self {
            bound: Bound::new(bound),
            triangles,
            patch_size,
            dissolve_attempts,
            max_vertices,
            max_hulls,
            given_up_above_limit: false,
            keep_cavities,
            probe: ProbeSettings::new(
                parameters.probe_radius,
                &parameters.probe_from,
                normalization,
            ),
        }
    }

    /// Hulls may be this far apart and join within a bound: a ball that rests on both edges of a
    /// wider gap sinks in by more than the bound.
    pub(crate) fn widest_gap(&self, bound: f64) -> f64 {
        let radius = self.probe.as_ref().map_or(0.0, |probe| probe.radius);
        let sunk = bound.min(radius);
        bound.max(2.0 * (sunk * (2.0 * radius - sunk)).sqrt())
    }

    /// The same with as little search as the fastest preset has.
    pub(crate) fn hurried(&self) -> Self {
        let PresetSettings { patch_size, dissolve_attempts, .. } = FAST;
        Self { patch_size, dissolve_attempts, ..self.clone() }
    }

    /// The same for an exact surface of this many triangles.
    pub(crate) fn for_surface(&self, triangles: usize) -> Self {
        let shares = if triangles <= COARSE { OF_FEW } else { OF_MANY };
        Self { bound: Bound { shares, ..self.bound }, ..self.clone() }
    }

    /// Whether a search with so many hulls is given up.
    pub(crate) fn gives_up(&self, hulls: usize) -> bool {
        self.given_up_above_limit && self.max_hulls.is_some_and(|most| hulls > most)
    }

    /// The same under another bound on protrusions, for the limit on hulls. No more may stay
    /// uncovered.
    pub(crate) fn with_bound(&self, bound: f64) -> Self {
        let Bound { requested, shares, .. } = self.bound;
        let bound = Bound { requested, shares, ..Bound::new(bound) };
        Self { bound, given_up_above_limit: true, ..self.clone() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(parameters: &Parameters) -> Settings {
        Settings::of_preset(parameters, &Normalization::UNIT)[0].clone()
    }

    fn with_share(share: f64) -> Settings {
        of(&Parameters::default().with_max_error(Length::share(share)))
    }

    #[test]
    fn a_bound_is_at_least_what_hulls_can_keep_and_at_most_half_the_diagonal() {
        for (share, bound) in [(1e-9, 1e-5), (0.02, 0.02), (3.0, 0.5)] {
            assert_eq!(with_share(share).bound.verified(), bound);
            assert_eq!(with_share(share).bound.requested(), bound);
        }
    }

    #[test]
    fn a_bound_in_units_is_divided_by_the_diagonal() {
        let normalization = Normalization { diagonal: 4.0, ..Normalization::UNIT };
        let parameters = Parameters::default().with_max_error(Length::units(0.2));
        for settings in Settings::of_preset(&parameters, &normalization) {
            assert_eq!(settings.bound.verified(), 0.05);
        }
    }

    #[test]
    fn a_search_keeps_less_than_the_bound_and_its_last_round_is_in_between() {
        for triangles in [COARSE, COARSE + 1] {
            let bound = with_share(0.02).for_surface(triangles).bound;
            assert!(bound.search() < bound.last_round() && bound.last_round() < bound.verified());
        }
    }

    #[test]
    fn a_surface_of_more_triangles_may_lose_more_detail() {
        let coarse = |triangles| with_share(0.02).for_surface(triangles).bound.coarse();
        assert_eq!(coarse(COARSE), coarse(12));
        assert!(5.0 * coarse(COARSE) < coarse(COARSE + 1));
    }

    #[test]
    fn what_a_patch_leaves_out_is_less_than_what_a_hull_may_leave_uncovered() {
        let bound = with_share(0.02).bound;
        assert!(bound.exact() < bound.tolerance());
        assert!(bound.tolerance() < bound.max_uncovered());
        assert!(bound.max_uncovered() < bound.max_uncovered_under_limit());
        assert!(bound.max_uncovered_under_limit() < bound.requested());
    }

    #[test]
    fn under_a_larger_bound_hulls_protrude_more_and_no_more_stays_uncovered() {
        let settings = with_share(0.02).for_surface(12);
        let larger = settings.with_bound(0.1).bound;
        assert_eq!(larger.verified(), 0.1);
        assert!((larger.search() - 5.0 * settings.bound.search()).abs() < 1e-12);
        let unchanged = [
            Bound::requested,
            Bound::exact,
            Bound::tolerance,
            Bound::max_uncovered,
            Bound::max_uncovered_under_limit,
        ];
        for length in unchanged {
            assert_eq!(length(larger), length(settings.bound));
        }
    }

    #[test]
    fn only_a_search_for_the_limit_on_hulls_is_given_up_and_only_above_it() {
        let settings = of(&Parameters::default().with_max_hulls(4));
        assert!(!settings.gives_up(1000));
        let repeated = settings.with_bound(0.03);
        assert!(!repeated.gives_up(4) && repeated.gives_up(5));
        assert!(!with_share(0.02).with_bound(0.03).gives_up(1000));
    }

    #[test]
    fn a_ball_on_both_edges_of_the_widest_gap_sinks_in_by_the_bound() {
        let bound = 0.02;
        assert_eq!(with_share(bound).widest_gap(bound), bound);
        let with_probe =
            |radius| of(&Parameters::default().with_probe_radius(Length::share(radius)));
        for radius in [0.05, 0.3] {
            let half = 0.5 * with_probe(radius).widest_gap(bound);
            let sunk = radius - (radius * radius - half * half).sqrt();
            assert!((sunk - bound).abs() < 1e-12, "{sunk}");
        }
        // A ball that is smaller than the bound falls through a gap of its own width.
        assert_eq!(with_probe(0.015).widest_gap(bound), 0.03);
        assert_eq!(with_probe(0.005).widest_gap(bound), bound);
    }

    #[test]
    fn edges_of_the_mesh_to_divide_follow_the_bound_within_limits() {
        let longest = [0.001, 0.02, 0.2].map(|share| with_share(share).bound.longest_edge());
        assert_eq!(longest, [0.04, 0.08, 0.16]);
    }

    #[test]
    fn a_hurried_search_has_the_patches_of_the_fastest_preset() {
        let fast = of(&Parameters::default().with_preset(Preset::Fast));
        let hurried = of(&Parameters::default().with_preset(Preset::Fine)).hurried();
        assert_eq!(hurried.patch_size, fast.patch_size);
        assert_eq!(hurried.dissolve_attempts, 0);
    }

    #[test]
    fn the_finest_preset_first_does_what_the_balanced_one_does() {
        let passes = |preset| {
            Settings::of_preset(&Parameters::default().with_preset(preset), &Normalization::UNIT)
        };
        let sizes = |passes: &[Settings]| -> Vec<(f64, usize)> {
            passes.iter().map(|pass| (pass.patch_size, pass.triangles)).collect()
        };
        let (fine, balanced) = (passes(Preset::Fine), passes(Preset::Balanced));
        assert_eq!(sizes(&fine[..1]), sizes(&balanced));
        assert!(fine.len() > 1);
    }
}
