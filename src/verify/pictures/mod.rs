//! Whole pictures against closed forms, published values and independent methods.
//!
//! Each picture is made with several seeds; the mean must lie as near to what is expected as its
//! standard error allows, and that error must be small enough for the answer to say something.

mod angles;
mod balance;
mod lamps;
mod slabs;

use super::case::{Case, Effort, Group};
use super::parts::Render;
use super::{Check, Parts, scenes};
use crate::error::Result;
use crate::image::Film;
use crate::scene::Scene;
use crate::vdb::GridToWrite;

/// Pictures a mean is taken over.
const SEEDS: u32 = 6;

/// Student's t for five degrees of freedom at 1e-3, two-sided: what [`SEEDS`] seeds tell of a
/// standard error.
const STUDENT: f64 = 6.87;

/// Standard errors that a mean may be off where they are known by the spread of all rays.
const SIGMAS: f64 = 4.5;

const NOISE: &str = "6.9 standard errors over six seeds (Student's t, one false alarm in a \
                     thousand, fixed seeds), 4.5 by the spread of rays, and 1 % for the gather's \
                     blur, the reference without";

pub(super) fn cases(effort: Effort) -> Vec<Case> {
    let mut cases = slabs::cases(effort);
    cases.extend(angles::cases(effort));
    cases.extend(lamps::cases(effort));
    cases.extend(balance::cases(effort));
    cases
}

/// How closely a mean must be met, beside its noise.
#[derive(Clone, Copy)]
struct Closeness {
    /// Bias that is allowed, relative.
    bias: f64,
    /// Largest standard error that still says something, relative.
    error: f64,
}

/// Mean over seeds of `measure` on pictures of a scene against what is expected.
fn compare(
    what: &str,
    render: &Render,
    text: &str,
    grids: &[GridToWrite],
    measure: impl Fn(&Film) -> f64,
    expected: f64,
    close: Closeness,
) -> Result<Vec<Check>> {
    compare_scene(what, render, &scenes::scene(text, grids)?, measure, expected, close)
}

/// As [`compare`], of a scene that is there.
fn compare_scene(
    what: &str,
    render: &Render,
    scene: &Scene,
    measure: impl Fn(&Film) -> f64,
    expected: f64,
    close: Closeness,
) -> Result<Vec<Check>> {
    let mut values = Vec::new();
    let (mut dropped, mut noise) = (0, 0.0);
    for seed in 0..SEEDS {
        let rendered = render(scene, &scenes::seeded(scene, u64::from(seed)))?;
        dropped += rendered.work.dropped_samples + rendered.film.repaired();
        values.push(measure(&rendered.film));
        noise += ray_noise(&rendered.film) / f64::from(SEEDS);
    }
    let mean = values.iter().sum::<f64>() / f64::from(SEEDS);
    let squares: f64 = values.iter().map(|v| (v - mean).powi(2)).sum();
    let by_seeds = (squares / f64::from(SEEDS * (SEEDS - 1))).sqrt();
    let by_rays = noise * mean / f64::from(SEEDS).sqrt();
    let tolerance = (STUDENT * by_seeds).max(SIGMAS * by_rays) + close.bias * expected.abs();
    let error = by_seeds.max(by_rays);
    Ok(vec![
        Check::near(what, mean, expected, tolerance),
        Check::at_most(format!("{what}: standard error"), error, close.error * expected.abs()),
        Check::at_most(format!("{what}: dropped samples"), dropped as f64, 0.0),
    ])
}

/// Standard error of the mean of a picture by the variance of each pixel's rays, relative.
fn ray_noise(film: &Film) -> f64 {
    scenes::sum(film, "variance").sqrt() / scenes::sum(film, "G").max(f64::MIN_POSITIVE)
}

/// What a case asks of the renderer.
#[derive(Clone, Copy)]
struct Work {
    /// Camera rays a pixel of the picture by photon map.
    rays: u64,
    /// Its photons.
    photons: u64,
    /// Camera rays a pixel of the reference.
    reference: u64,
    /// Largest standard error that still says something, relative.
    error: f64,
}

impl Work {
    /// The work of an effort: a full run takes 4 times that of a quick one.
    fn new(effort: Effort, rays: u64, photons: u64, reference: u64) -> Self {
        let (scale, error) = if effort == Effort::Quick { (1, 0.06) } else { (4, 0.03) };
        let [rays, photons, reference] = [rays, photons, reference].map(|n| n * scale);
        Self { rays, photons, reference, error }
    }
}

/// A case run by the photon map and by the reference; `text` gives the scene for a number of rays
/// and of photons, `grids` what lies beside it as `grids.vdb`.
fn both(
    name: &str,
    source: &'static str,
    measure: impl Fn(&Film) -> f64 + Copy + Send + Sync + 'static,
    expected: f64,
    work: Work,
    grids: Vec<GridToWrite>,
    text: impl Fn(u64, u64) -> String + Send + Sync + 'static,
) -> Case {
    Case::new(Group::ClosedForms, name, [source, NOISE], move |parts: &Parts| {
        let close = Closeness { bias: 0.01, error: work.error };
        let scene = text(work.rays, work.photons);
        let mut checks =
            compare("photon map", &parts.render, &scene, &grids, measure, expected, close)?;
        let close = Closeness { bias: 0.0, ..close };
        let scene = text(work.reference, 0);
        checks.extend(compare(
            "reference",
            &parts.reference,
            &scene,
            &grids,
            measure,
            expected,
            close,
        )?);
        Ok(checks)
    })
}
