//! The regret of the choice of strategies: what is chosen against the best that can be asked for.
//!
//! The cost of a candidate is its relative squared error times its processor seconds: what unbiased
//! rendering keeps, however long it takes. For each scene what is chosen and every strategy asked for
//! by name take turns, seed by seed. The first half of the seeds says which request is the best; the
//! regret is the cost of what is chosen over that of this one on the other half, lest the best be the
//! luckiest. Requests that no medium can follow, and those that come to the same as another, are left
//! out.
//!
//! Errors are against two references that are traced until the error of their mean is a tenth of the
//! smallest of the candidates', and at most 0.003; they are kept by the hash of the scene in the folder
//! `strategy-truth`, from run to run.

mod candidate;
mod scenes;
mod truth;

use std::fs;
use std::path::Path;

use fogbow::render::{Rendered, Silent, render};
use fogbow::scene::{LoadOptions, RenderSettings, Scene, Strategy, StrategyRequest};

use super::Kept;
use super::halves::{mean, wide};
use super::spent::Spent;
use crate::pages::Result;
use crate::pages::ratio::Ratio;
use crate::pages::strategy::{Comparison, Row};
use candidate::Candidate;
pub use candidate::{Series, ratio};
pub use scenes::{StrategyScene, scenes_of_files, side_lit_smoke};
use scenes::{fly_in, scenes};
use truth::Truth;

/// Seeds that say which candidate is the best, and as many on which it is compared.
const SEEDS: usize = 8;

/// Largest error of the references over the smallest of the candidates.
const TRUTH_SHARE: f64 = 0.1;

/// Largest error of the references: where both have found too little light, the errors of candidates
/// are large for want of a scale, and a tenth of them is soon reached.
const MAX_TRUTH_ERROR: f64 = 0.003;

/// Processor seconds that the references of a scene may take, where [`MORE_TRUTH`] says nothing else.
const TRUTH_SECONDS: f64 = 48.0;

/// The environment variable of other such seconds: references are kept, so that a later run may go on with them.
const MORE_TRUTH: &str = "FOGBOW_TRUTH_SECONDS";

/// Frames of the flight into a cloud.
const FRAMES: u32 = 12;

/// Extent of a run.
struct Extent {
    seeds: usize,
    truth_seconds: f64,
    /// Every how many-th scene is taken.
    stride: usize,
    /// What pixels and photons are divided by along each side, and in number.
    part: u32,
}

const WHOLE: Extent = Extent { seeds: SEEDS, truth_seconds: TRUTH_SECONDS, stride: 1, part: 1 };
const QUICK: Extent = Extent { seeds: 2, truth_seconds: 1.0, stride: 7, part: 4 };

/// A part a scene.
pub fn measure(kept: &mut Kept<Row>, quick: bool) -> Result<()> {
    let mut extent = if quick { QUICK } else { WHOLE };
    if let Ok(seconds) = std::env::var(MORE_TRUTH) {
        extent.truth_seconds =
            seconds.parse().map_err(|_| format!("{MORE_TRUTH} is {seconds}; give seconds"))?;
        kept.note(format!("References took up to {seconds} processor seconds (`{MORE_TRUTH}`)."));
    }
    let work = kept.lasting("strategy-truth");
    let (scenes, left_out) = scenes(&work)?;
    left_out.into_iter().for_each(|sentence| kept.note(sentence));
    for scene in scenes.iter().step_by(extent.stride) {
        kept.part(&scene.name, || Ok(vec![compare(scene, &extent, &work)?]))?;
    }
    Ok(())
}

/// Writes every scene, and the frames of a flight into a cloud, as a scene file in `folder`.
pub fn write_scenes(folder: &Path) -> Result<()> {
    let (mut scenes, left_out) = scenes(folder)?;
    left_out.iter().for_each(|sentence| println!("{sentence}"));
    scenes.extend(fly_in(FRAMES)?);
    for (number, scene) in scenes.iter().enumerate() {
        let name = scene.name.replace(|c: char| !c.is_ascii_alphanumeric(), "_");
        fs::write(folder.join(format!("{number:02}_{name}.toml")), &scene.text)?;
    }
    Ok(())
}

fn compare(scene: &StrategyScene, extent: &Extent, work: &Path) -> Result<Row> {
    let loaded = load(scene, extent, work)?;
    let mut candidates = candidates(&loaded)?;
    for seed in 0..2 * extent.seeds {
        // Who goes first changes.
        let count = candidates.len();
        for turn in 0..count {
            let candidate = &mut candidates[(seed + turn) % count];
            let settings =
                RenderSettings { strategy: candidate.request, seed: seed as u64, ..loaded.render };
            let (rendered, spent) = Spent::on(|| render(&loaded, &settings, &Silent));
            let rendered = rendered?;
            candidate.other_seeds += usize::from(media(&rendered) != candidate.media);
            candidate.pictures.push(wide(&rendered.film.image()));
            candidate.seconds.push(spent.ran);
        }
    }
    let [width, height] = loaded.film.size;
    let folder = work.join(format!("{}_{width}x{height}", loaded.hash));
    let mut truth = Truth::open(&folder, &loaded)?;
    let smallest = |truth: &Truth| {
        let errors = candidates.iter().map(|c| mean(&c.errors(truth.halves())[0]));
        errors.fold(f64::INFINITY, f64::min)
    };
    let is_enough = |truth: &Truth| {
        truth.halves().error() <= MAX_TRUTH_ERROR.min(TRUTH_SHARE * smallest(truth))
    };
    // Growing takes as long as all before.
    while !is_enough(&truth) && 2.0 * truth.spent().seconds < extent.truth_seconds {
        truth.grow(&loaded)?;
    }
    Ok(row(scene, &candidates, &truth, is_enough(&truth), extent.seeds))
}

/// The scene, of fewer pixels and photons for a quick run.
fn load(scene: &StrategyScene, extent: &Extent, work: &Path) -> Result<Scene> {
    let path = work.join("scene.toml");
    fs::write(&path, &scene.text)?;
    let own = Scene::load(&path, &LoadOptions::default())?;
    if extent.part == 1 {
        return Ok(own);
    }
    let options = LoadOptions::default()
        .size(own.film.size.map(|side| (side / extent.part).max(1)))
        .photons(own.render.photons / u64::from(extent.part * extent.part));
    Ok(Scene::load(&path, &options)?)
}

/// What is chosen, and all requests that differ, without pictures.
fn candidates(scene: &Scene) -> Result<Vec<Candidate>> {
    let mut candidates: Vec<Candidate> = Vec::new();
    for &(_, request) in StrategyRequest::ALL {
        let settings = RenderSettings { strategy: request, ..scene.render };
        let media = media(&render(scene, &settings, &Silent)?);
        let is_followed = match request {
            StrategyRequest::Asked(asked) => media.contains(&asked),
            StrategyRequest::Auto => true,
        };
        // What is chosen stands beside the same by name: choosing takes time.
        let is_new = candidates.iter().all(|c| !c.is_asked() || c.media != media);
        if is_followed && is_new {
            let (pictures, seconds) = (Vec::new(), Vec::new());
            candidates.push(Candidate { request, media, other_seeds: 0, pictures, seconds });
        }
    }
    Ok(candidates)
}

/// The strategy of each medium.
fn media(rendered: &Rendered) -> Vec<Strategy> {
    let media = rendered.strategy.iter().flat_map(|summary| &summary.media);
    media.map(|medium| medium.strategy).collect()
}

fn row(
    scene: &StrategyScene,
    candidates: &[Candidate],
    truth: &Truth,
    is_enough: bool,
    seeds: usize,
) -> Row {
    let (trimmed, whole): (Vec<_>, Vec<_>) = candidates
        .iter()
        .map(|candidate| {
            let [trimmed, whole] = candidate.errors(truth.halves());
            (trimmed, whole)
        })
        .unzip();
    Row {
        scene: scene.name.clone(),
        reference_rays: truth.spent().rays,
        reference_error: truth.halves().error(),
        is_reference_enough: is_enough,
        candidates: candidates.iter().map(|candidate| candidate.measured(truth.halves())).collect(),
        trimmed: comparison(candidates, &trimmed, seeds),
        of_all_pixels: Some(comparison(candidates, &whole, seeds)),
    }
}

/// What is chosen, the first candidate, beside the request that is best by these errors of each over
/// the seeds.
fn comparison(candidates: &[Candidate], errors: &[Vec<f64>], seeds: usize) -> Comparison {
    let series: Vec<Series<'_>> = candidates
        .iter()
        .zip(errors)
        .map(|(candidate, errors)| Series { errors, seconds: &candidate.seconds })
        .collect();
    let first: Vec<usize> = (0..seeds).collect();
    let second: Vec<usize> = (seeds..2 * seeds).collect();
    let cost = |index: &usize| series[*index].figures(&first).cost();
    let requested = (0..candidates.len()).filter(|&index| candidates[index].is_asked());
    let best = requested.min_by(|a, b| cost(a).total_cmp(&cost(b))).unwrap_or(0);
    let compared = seeds..2 * seeds;
    let Ratio { ratio: regret, interval } =
        ratio(&series[0], &series[best], compared, |of| of.cost());
    Comparison {
        best: candidates[best].request.name().into(),
        compared: [0, best].map(|index| series[index].figures(&second)),
        regret,
        interval,
    }
}
