//! What directed rendering saves, and what the director costs.

use std::path::Path;
use std::time::Instant;

use fogbow::image::Image;
use fogbow::render::{Earlier, Extent, Silent, Stages, maps, render};
use fogbow::scene::{Director, LoadOptions, RenderSettings, Scene};
use fogbow::study::metric::{Options, compare};

use super::Kept;
use super::scenes::{BARE, PAPER, shared, shipped};
use super::spent::median;
use crate::pages::Result;
use crate::pages::director::Row;

/// Rays of the most important pixel, as in Anson et al. 2006.
const RAYS: u32 = 16;

const ROUNDS: u32 = 3;

/// Scenes of `volumes/` beside the paper's.
const OTHERS: [(&str, &str); 3] = [("cloud", "cloud"), ("smoke", "smoke"), ("fire", "fire")];

/// A part a scene.
pub fn measure(kept: &mut Kept<Row>, quick: bool) -> Result<()> {
    for (title, name) in PAPER.into_iter().chain(OTHERS) {
        kept.part(title, || both(title, &shipped(name), quick))?;
    }
    for (title, file) in BARE {
        match shared(file) {
            Some(path) => kept.part(title, || both(title, &path, quick))?,
            None => kept.note(format!("{file} was not there.")),
        }
    }
    Ok(())
}

fn both(title: &str, path: &Path, quick: bool) -> Result<Vec<Row>> {
    let mut options = LoadOptions::default().rays(RAYS);
    if quick {
        options = options.size([64, 64]).photons(20_000);
    }
    let scene = Scene::load(path, &options)?;
    let pairs = Pairs::rendered(&scene)?;
    let fixed = median(pairs.fixed_seconds.clone());
    Ok(vec![pairs.gain(title)?, cost(title, &scene, fixed)?])
}

/// Pairs of runs, and their pictures, which are the same in each.
struct Pairs {
    fixed_seconds: Vec<f64>,
    xs_seconds: Vec<f64>,
    fixed: Image,
    xs: Image,
}

impl Pairs {
    fn rendered(scene: &Scene) -> Result<Self> {
        let picture = |director| -> Result<(f64, Image)> {
            let settings = RenderSettings { director, ..scene.render };
            let start = Instant::now();
            let rendered = render(scene, &settings, &Silent)?;
            Ok((start.elapsed().as_secs_f64(), rendered.film.image()))
        };
        let (first, fixed) = picture(Director::Fixed)?;
        let (second, xs) = picture(Director::Xs)?;
        let mut pairs = Self { fixed_seconds: vec![first], xs_seconds: vec![second], fixed, xs };
        for _ in 1..ROUNDS {
            pairs.fixed_seconds.push(picture(Director::Fixed)?.0);
            pairs.xs_seconds.push(picture(Director::Xs)?.0);
        }
        Ok(pairs)
    }

    fn gain(self, title: &str) -> Result<Row> {
        let Self { fixed_seconds, xs_seconds, fixed, xs } = self;
        let errors = compare(&fixed, &xs, &Options::default())?.errors;
        let each: Vec<f64> = fixed_seconds.iter().zip(&xs_seconds).map(|(a, b)| a / b).collect();
        Ok(Row::Gain {
            scene: title.into(),
            times: median(each.clone()),
            each,
            fixed_seconds,
            xs_seconds,
            code_mse_percent: errors.code_mse_percent,
            code_pixels_percent: errors.code_pixels_percent,
            flip: errors.flip_ldr,
            vdp_visible_percent: errors.vdp_visible_percent,
        })
    }
}

/// The director's time beside the `fixed` seconds of the picture.
fn cost(title: &str, scene: &Scene, fixed: f64) -> Result<Row> {
    let settings = RenderSettings { director: Director::Xs, ..scene.render };
    let mut stages = Stages::default();
    let start = Instant::now();
    maps(scene, &settings, Earlier::default(), Extent::Needed, &mut stages)?;
    let director = start.elapsed().as_secs_f64();
    let saliency = stages.timings.iter().find(|(name, _)| *name == "saliency");
    Ok(Row::Cost {
        scene: title.into(),
        saliency_seconds: saliency.map(|(_, time)| time.as_secs_f64()),
        director_seconds: Some(director),
        fixed_seconds: Some(fixed),
        share_percent: 100.0 * director / fixed,
    })
}
