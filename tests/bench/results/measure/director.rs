//! What directing saves: the gold standard, `xs` and their rivals against the truth, by processor seconds.
//!
//! The truth is that of [`reconstruction`](super::reconstruction), which keeps it in the folder `gold-truth`.

use fogbow::director::Saliency;
use fogbow::image::Denoiser;
use fogbow::render::{Rendered, Silent, exposure, render};
use fogbow::scene::{
    Directed, Directing, Director, Importance, RenderSettings, Scene, Strategy, StrategyRequest,
};
use fogbow::study::metric::Options;

use super::Kept;
use super::halves::{Pixels, mean, narrow, wide};
use super::reconstruction::{GoldTruth, gold_stages, noise_scenes, seen_errors};
use super::spent::Spent;
use super::strategy::{Series, ratio};
use crate::pages::Result;
use crate::pages::director::{OneThread, Row, Way};
use crate::pages::strategy::Figures;

/// Extent of a run.
struct Extent {
    /// Pixels along the longer side.
    side: u32,
    /// Rays of a pixel of the gold standard, and of the most important one, as in Anson et al. 2006.
    rays: u32,
    /// What the photons of scenes are divided by: as much as pixels are fewer than in the pictures of 512 pixels that
    /// scenes are made for, so that photons and rays have their shares of the time.
    photons_part: u64,
    /// Pictures of each half of the truth.
    gold_pairs: u64,
    seeds: usize,
    /// Seeds whose pictures are compared by FLIP and VDP.
    seen_seeds: usize,
    /// Every how many-th scene is taken.
    stride: usize,
}

const WHOLE: Extent = Extent {
    side: 192,
    rays: 16,
    photons_part: 7,
    gold_pairs: 6,
    seeds: 4,
    seen_seeds: 1,
    stride: 1,
};
const QUICK: Extent = Extent {
    side: 40,
    rays: 4,
    photons_part: 50,
    gold_pairs: 1,
    seeds: 2,
    seen_seeds: 1,
    stride: 6,
};

/// A way of rendering.
struct Setup {
    name: &'static str,
    director: Director,
    /// What rays and photons of the gold standard are divided by.
    part: [u32; 2],
    reconstruct: bool,
    denoise: bool,
    by: By,
}

/// What X is, and what it directs.
#[derive(Clone, Copy, PartialEq, Eq)]
enum By {
    /// What is so by default: measured error directs rays.
    Default,
    /// Measured error directs radius and step as well.
    ErrorCoarsened,
    /// Measured error directs rays, wherever the eye looks.
    ErrorAlone,
    /// As by default, with the photons and the strategy of the gold standard.
    PhotonsOfGold,
    /// How uncertain scattered light is, to which saliency is added, directs all three.
    Scattering,
}

impl Setup {
    /// Each pixel gets the same.
    const fn uniform(name: &'static str, part: [u32; 2]) -> Self {
        let director = Director::Fixed;
        Self { name, director, part, reconstruct: false, denoise: false, by: By::Default }
    }

    const fn directed(name: &'static str, director: Director) -> Self {
        Self { director, ..Self::uniform(name, [1, 1]) }
    }

    const fn reconstructed(name: &'static str, part: [u32; 2]) -> Self {
        Self { reconstruct: true, ..Self::uniform(name, part) }
    }
}

/// The gold standard first, `xs` next.
const SETUPS: [Setup; 15] = [
    Setup::uniform("gold", [1, 1]),
    Setup::directed("`xs`", Director::Xs),
    Setup { by: By::Scattering, ..Setup::directed("`xs` by scattering", Director::Xs) },
    Setup { by: By::ErrorCoarsened, ..Setup::directed("`xs`, radius and step too", Director::Xs) },
    Setup { by: By::ErrorAlone, ..Setup::directed("`xs` without saliency", Director::Xs) },
    Setup { by: By::PhotonsOfGold, ..Setup::directed("`xs`, photons as gold's", Director::Xs) },
    Setup::directed("`xs-paper`", Director::XsPaper),
    Setup::directed("`variance`", Director::Variance),
    Setup::uniform("one ray", [u32::MAX, 1]),
    Setup::uniform("1/4 of the rays", [4, 1]),
    Setup::uniform("1/4 of rays and photons", [4, 4]),
    Setup::reconstructed("1/4 of the rays, reconstructed", [4, 1]),
    Setup::reconstructed("1/4 of rays and photons, reconstructed", [4, 4]),
    Setup::reconstructed("1/8 of rays and photons, reconstructed", [8, 8]),
    Setup {
        denoise: true,
        ..Setup::uniform("1/8 of rays and photons, Open Image Denoise", [8, 8])
    },
];

/// A part a scene.
pub fn measure(kept: &mut Kept<Row>, quick: bool) -> Result<()> {
    let extent = if quick { QUICK } else { WHOLE };
    let denoiser = Denoiser::find();
    if let Err(error) = &denoiser {
        kept.note(format!("Denoised pictures are left out: {error}."));
    }
    let denoiser = denoiser.ok();
    let (scenes, work) = noise_scenes(kept)?;
    for scene in scenes.iter().step_by(extent.stride) {
        kept.part(&scene.title, || {
            let gold = scene.load(extent.side, extent.rays, extent.photons_part)?;
            let truth = GoldTruth::open(&work, &gold, extent.gold_pairs)?;
            Ok(vec![row(&scene.title, &gold, &truth, denoiser.as_ref(), &extent)?])
        })?;
    }
    Ok(())
}

/// Pictures of one way.
#[derive(Default)]
struct Pictures {
    pixels: Vec<Pixels>,
    /// Processor seconds of all threads.
    seconds: Vec<f64>,
}

fn row(
    title: &str,
    gold: &Scene,
    truth: &GoldTruth,
    denoiser: Option<&Denoiser>,
    extent: &Extent,
) -> Result<Row> {
    // The first picture also pays for memory that later ones find.
    let strategy = strategy_of(&picture(gold, &SETUPS[0], 0, denoiser, None)?);
    let setups = SETUPS.iter().filter(|setup| denoiser.is_some() || !setup.denoise);
    let setups = setups.filter(|setup| strategy.is_some() || setup.by != By::PhotonsOfGold);
    let mut all: Vec<(&Setup, Pictures)> = setups.map(|s| (s, Pictures::default())).collect();
    for seed in 0..extent.seeds {
        let count = all.len();
        for turn in 0..count {
            // Who goes first changes.
            let (setup, pictures) = &mut all[(seed + turn) % count];
            let (rendered, spent) =
                Spent::on(|| picture(gold, setup, seed as u64, denoiser, strategy));
            pictures.pixels.push(wide(&rendered?.film.image()));
            pictures.seconds.push(spent.ran);
        }
    }
    let halves = truth.halves();
    let options = Options { exposure: exposure(gold)?, ..Options::default() };
    let width = gold.film.size[0] as usize;
    let (errors, untrimmed): (Vec<_>, Vec<_>) =
        all.iter().map(|(_, taken)| halves.errors_of_each(&taken.pixels).into()).unzip();
    let series = |index: usize| Series { errors: &errors[index], seconds: &all[index].1.seconds };
    let over = |of: usize, over: usize, figure: fn(Figures) -> f64| {
        ratio(&series(of), &series(over), 0..extent.seeds, figure)
    };
    let mean_truth = halves.mean();
    let saliency = Saliency::from_image(&narrow(&mean_truth, width)).map;
    let mut ways = Vec::new();
    for (index, (setup, taken)) in all.iter().enumerate() {
        let seen = &taken.pixels[..extent.seen_seeds];
        let of_salient = |picture| halves.weighted_error(picture, &saliency);
        let salient_errors: Vec<f64> = taken.pixels.iter().map(of_salient).collect();
        let [flip, vdp_percent] = seen_errors(&mean_truth, seen, width, &options)?;
        ways.push(Way {
            name: setup.name.into(),
            seconds: mean(&taken.seconds),
            error: mean(&errors[index]),
            untrimmed: mean(&untrimmed[index]),
            salient_error: mean(&salient_errors),
            flip,
            vdp_percent,
            gain: over(0, index, |of| of.seconds),
            error_of_gold: over(index, 0, |of| of.error),
            cost_of_xs: over(index, 1, |of| of.cost()),
        });
    }
    let stages = gold_stages(gold, truth)?;
    Ok(Row {
        scene: title.into(),
        size: gold.film.size,
        rays: gold.render.rays,
        photons: gold.render.photons,
        truth_error: halves.error(),
        photon_seconds: stages.photon_seconds,
        ray_seconds: stages.ray_seconds,
        allocation_gain: stages.allocation_gain,
        one_thread: one_thread(gold)?,
        ways,
    })
}

/// The strategy of all media of a picture, if they have one.
fn strategy_of(rendered: &Rendered) -> Option<Strategy> {
    let media = &rendered.strategy.as_ref()?.media;
    let first = media.first()?.strategy;
    media.iter().all(|medium| medium.strategy == first).then_some(first)
}

/// The seconds of gold and `xs` on one thread, whose clock tells what stages take.
fn one_thread(gold: &Scene) -> Result<OneThread> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
    let [whole, directed] = [&SETUPS[0], &SETUPS[1]].map(|setup| {
        pool.install(|| {
            Spent::on(|| picture(gold, setup, 0, None, None).map_err(|e| e.to_string()))
        })
    });
    let directed = directed.0?;
    let stages = directed.timings.iter().map(|(name, took)| ((*name).into(), took.as_secs_f64()));
    whole.0?;
    Ok(OneThread { gold: whole.1.ran, stages: stages.collect() })
}

/// A picture of one way.
fn picture(
    gold: &Scene,
    setup: &Setup,
    seed: u64,
    denoiser: Option<&Denoiser>,
    strategy: Option<Strategy>,
) -> Result<Rendered> {
    let own = gold.render.directing;
    let directing = match setup.by {
        By::Default | By::PhotonsOfGold => own,
        By::ErrorAlone => Directing { weights: [own.weights[0], 0.0], ..own },
        By::ErrorCoarsened => Directing { directed: Directed::ALL, ..own },
        By::Scattering => own.by(Importance::Scattering),
    };
    let settings = RenderSettings {
        seed,
        director: setup.director,
        rays: (gold.render.rays / setup.part[0]).max(1),
        photons: gold.render.photons / u64::from(setup.part[1]),
        reconstruct: setup.reconstruct,
        denoise: setup.denoise,
        directing,
        strategy: match (setup.by, strategy) {
            (By::PhotonsOfGold, Some(strategy)) => StrategyRequest::Asked(strategy),
            _ => gold.render.strategy,
        },
        ..gold.render
    };
    let mut rendered = render(gold, &settings, &Silent)?;
    if let Some(denoiser) = denoiser.filter(|_| setup.denoise) {
        rendered.denoise(denoiser)?;
    }
    Ok(rendered)
}
