//! Candidates: the ways of rendering that a study compares with the gold standard.

use serde::{Deserialize, Serialize};

use crate::scene::{Directed, Director, Importance, Operator, RenderSettings, StrategyRequest};

/// The name of the gold standard among candidates: every pixel at the ceiling of rays, the finest
/// step, the smallest radius.
pub(super) const GOLD: &str = "gold";

/// The candidate that is what `--director xs` makes unless a scene says otherwise.
const DIRECTED: &str = "xs-error";

/// The name of the candidate that shows how errors fall with photons.
pub(super) const PHOTONS: &str = "photons";

/// Its photons over the gold standard's.
const PHOTON_SHARES: [f64; 4] = [1.0 / 4.0, 1.0 / 16.0, 1.0 / 64.0, 1.0 / 256.0];

/// Relative errors for which the variance-driven rival gives a pixel rays.
const TOLERANCES: [f64; 4] = [0.05, 0.1, 0.2, 0.4];

const RADIUS: Directed = Directed { rays: false, radius: true, step: false };
const STEP: Directed = Directed { rays: false, radius: false, step: true };

/// Every candidate by name, with what it is.
pub const CANDIDATES: [(&str, &str); 15] = [
    ("fixed", "as gold with fewer rays"),
    ("fixed-photons", "as gold with fewer rays and as many fewer photons"),
    (PHOTONS, "as gold with fewer photons"),
    ("x-transmittance", "directed by X, the transmittance"),
    ("x-scattering", "directed by X, the contrast of scattered light"),
    ("s", "directed by saliency"),
    (DIRECTED, "X from measured error, of which more passes where S is low; reconstructed"),
    ("xs-transmittance", "X and S, with X from transmittance"),
    ("xs-scattering", "X and S, with X from scattered light"),
    ("xs-product", "X times S instead of their sum, with X from scattered light"),
    ("xs-paper", "as Anson et al. 2006: X and S, with X from transmittance, rays alone directed"),
    ("xs-rays", "as xs-scattering, but rays alone are directed"),
    ("xs-radius", "as xs-scattering, but the gather radius alone is directed"),
    ("xs-step", "as xs-scattering, but the march step alone is directed"),
    ("variance", "no map: each pixel until its own error estimate is small"),
];

/// One way of rendering at several budgets.
#[derive(Clone, Debug, PartialEq)]
pub struct Candidate {
    /// Its name in [`CANDIDATES`].
    pub name: &'static str,
    /// What it is.
    pub about: &'static str,
    /// Its budgets, the largest first.
    pub points: Vec<Point>,
}

/// A candidate at one budget.
#[derive(Clone, Debug, PartialEq)]
pub struct Point {
    /// The budget in words.
    pub label: String,
    /// How it is rendered, but for the seed.
    pub settings: RenderSettings,
}

impl Candidate {
    /// The gold standard of a scene with these settings. It is not reconstructed, and candidates are its variations.
    pub fn gold(settings: &RenderSettings) -> Self {
        let settings =
            RenderSettings { director: Director::Fixed, reconstruct: false, ..*settings };
        let label = format!("{} rays", settings.rays);
        Self { name: GOLD, about: "the gold standard", points: vec![Point { label, settings }] }
    }

    /// The candidates `names`, all where there are none, beside a gold standard of `settings`.
    /// `budgets` are ceilings of rays.
    pub fn all(settings: &RenderSettings, names: &[String], budgets: &[u32]) -> Vec<Self> {
        CANDIDATES
            .iter()
            .filter(|(name, _)| names.is_empty() || names.iter().any(|asked| asked == name))
            .map(|&(name, about)| Self { name, about, points: points(settings, name, budgets) })
            .filter(|candidate| !candidate.points.is_empty())
            .collect()
    }
}

/// The directed candidate out of `names` that is compared with gold and uniform sampling: [`DIRECTED`], or
/// the first that is directed.
pub(super) fn subject(names: &[String]) -> Option<&str> {
    let mut names = names.iter().map(String::as_str);
    let is_directed = |name: &&str| !name.starts_with("fixed") && *name != PHOTONS;
    names.clone().find(|name| *name == DIRECTED).or_else(|| names.find(is_directed))
}

fn points(gold: &RenderSettings, name: &str, budgets: &[u32]) -> Vec<Point> {
    if name == "variance" {
        return TOLERANCES.map(|tolerance| until(gold, tolerance)).to_vec();
    }
    if name == PHOTONS {
        let counts = PHOTON_SHARES.map(|share| (gold.photons as f64 * share).ceil() as u64);
        let fewer = counts.iter().filter(|photons| **photons > 0 && **photons < gold.photons);
        let point = |photons: &u64| Point {
            label: format!("{photons} photons"),
            settings: RenderSettings { photons: *photons, director: Director::Fixed, ..*gold },
        };
        return fewer.map(point).collect();
    }
    // Uniform sampling at the ceiling is the gold standard itself.
    let uniform = name.starts_with("fixed");
    let budgets = budgets.iter().filter(|rays| !uniform || **rays < gold.rays);
    budgets
        .map(|rays| Point { label: format!("{rays} rays"), settings: with(gold, name, *rays) })
        .collect()
}

/// Sampling until the error estimate is under `tolerance`.
fn until(gold: &RenderSettings, tolerance: f64) -> Point {
    let mut settings = RenderSettings { director: Director::Variance, ..*gold };
    settings.directing.tolerance = tolerance;
    Point { label: format!("until {tolerance}"), settings }
}

/// The settings of the candidate `name` at a ceiling of `rays`.
fn with(gold: &RenderSettings, name: &str, rays: u32) -> RenderSettings {
    let mut settings = RenderSettings { rays, ..*gold };
    settings.director = match name {
        "fixed" | "fixed-photons" => Director::Fixed,
        "x-transmittance" | "x-scattering" => Director::X,
        "s" => Director::S,
        _ => Director::Xs,
    };
    if name == "fixed-photons" {
        let share = f64::from(rays) / f64::from(gold.rays);
        settings.photons = (gold.photons as f64 * share).ceil() as u64;
    }
    let directing = &mut settings.directing;
    directing.x = if name.ends_with("transmittance") || name == "xs-paper" {
        Importance::Transmittance
    } else if name == DIRECTED {
        Importance::Error
    } else {
        Importance::Scattering
    };
    let own = directing.operator;
    directing.operator =
        if name == "xs-product" { Operator::Product } else { directing.x.default_operator() };
    // The scene's weights mean something else for another operator.
    if directing.operator.default_weights() != own.default_weights() {
        directing.weights = directing.operator.default_weights();
    }
    directing.directed = match name {
        "xs-rays" | "xs-paper" => Directed::RAYS,
        "xs-radius" => RADIUS,
        "xs-step" => STEP,
        _ => Directed::ALL,
    };
    settings
}

/// The same with the finest march step in every pixel; nothing where it has that already.
pub(super) fn at_finest_step(settings: &RenderSettings) -> Option<RenderSettings> {
    let mut finest = RenderSettings { step: None, ..*settings };
    if !matches!(settings.director, Director::Fixed | Director::Variance) {
        finest.directing.directed.step = false;
    }
    (finest != *settings).then_some(finest)
}

/// The strategy of settings that were written down without one.
fn chosen() -> String {
    StrategyRequest::Auto.name().into()
}

/// Render settings as they are written down, without the seed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[allow(missing_docs, reason = "the fields are those of RenderSettings and Directing")]
pub struct Settings {
    pub rays: u32,
    pub photons: u64,
    pub radius: Option<f64>,
    pub step: Option<f64>,
    pub max_scatter: Option<u32>,
    #[serde(default = "chosen")]
    pub strategy: String,
    pub final_gather: String,
    pub director: String,
    pub x: String,
    pub weights: [f64; 2],
    pub operator: String,
    pub directs: String,
    pub floor: u32,
    pub coarsest_radius: f64,
    pub coarsest_step: f64,
    pub tolerance: f64,
}

impl From<&RenderSettings> for Settings {
    fn from(settings: &RenderSettings) -> Self {
        let directing = &settings.directing;
        Self {
            rays: settings.rays,
            photons: settings.photons,
            radius: settings.radius,
            step: settings.step,
            max_scatter: settings.max_scatter,
            strategy: settings.strategy.name().into(),
            final_gather: settings.final_gather.name().into(),
            director: settings.director.name().into(),
            x: directing.x.name().into(),
            weights: directing.weights,
            operator: directing.operator.name().into(),
            directs: directing.directed.to_string(),
            floor: directing.floor,
            coarsest_radius: directing.coarsest_radius,
            coarsest_step: directing.coarsest_step,
            tolerance: directing.tolerance,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_candidate_is_another_rendering() {
        let gold = RenderSettings::default();
        let all = Candidate::all(&gold, &[], &[16, 4, 1]);
        let mut seen: Vec<RenderSettings> = vec![gold];
        for point in all.iter().flat_map(|candidate| &candidate.points) {
            assert!(!seen.contains(&point.settings), "{point:?}");
            seen.push(point.settings);
        }
        assert_eq!(all.len(), CANDIDATES.len());
        assert_eq!(all[0].points.len(), 2, "fixed at the ceiling is gold");
    }

    #[test]
    fn what_has_the_finest_step_has_no_finer_one() {
        let gold = RenderSettings::default();
        let point = |name: &str| with(&gold, name, 8);
        for name in ["fixed", "xs-rays", "xs-radius", "xs-paper"] {
            assert_eq!(at_finest_step(&point(name)), None, "{name}");
        }
        let finest = at_finest_step(&point("xs-scattering")).unwrap();
        assert!(finest.directing.directed.rays && !finest.directing.directed.step);
        let coarse = RenderSettings { step: Some(0.5), ..gold };
        assert_eq!(at_finest_step(&coarse), Some(gold));
    }

    #[test]
    fn one_is_found_by_name() {
        let one = Candidate::all(&RenderSettings::default(), &["xs-rays".into()], &[8]);
        assert_eq!(one.len(), 1);
        assert_eq!(one[0].points[0].settings.directing.directed, Directed::RAYS);
    }
}
