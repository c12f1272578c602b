//! fogbow's four scenes after the paper's, directed in the paper's way and in fogbow's own.

use std::path::Path;

use fogbow::render::Silent;
use fogbow::scene::{LoadOptions, Scene};
use fogbow::study::{Metric, PointResult, Request, Results, Study, write_report};
use serde_json::Value;

use super::Kept;
use super::scenes::{PAPER, shipped};
use crate::pages::Result;
use crate::pages::paper::{Row, SpeedUp};

/// The paper's way, and fogbow's own.
const WAYS: [&str; 2] = ["xs-paper", "xs-scattering"];

/// A part a scene.
pub fn measure(kept: &mut Kept<Row>, quick: bool) -> Result<()> {
    for (title, name) in PAPER {
        let folder = kept.folder(name);
        kept.part(title, || rows(title, &studied(&shipped(name), &folder, quick)?))?;
    }
    Ok(())
}

fn studied(path: &Path, folder: &Path, quick: bool) -> Result<Results> {
    let mut options = LoadOptions::default();
    if quick {
        let whole = Scene::load(path, &options)?;
        options = options.size(whole.film.size.map(|side| side / 8)).photons(20_000);
    }
    let scene = Scene::load(path, &options)?;
    let request = Request {
        candidates: WAYS.map(str::to_owned).to_vec(),
        budgets: vec![scene.render.rays],
        seeds: if quick { 2 } else { 4 },
        metric: Metric::CodeMse,
        ..Request::default()
    };
    let resume = folder.join("study.json").exists();
    let study = Study::new(&scene, folder, &request, resume)?;
    let results = study.run("cargo bench --bench results -- --only paper", &Silent)?;
    write_report(&results, folder)?;
    Ok(results)
}

fn rows(title: &str, results: &Results) -> Result<Vec<Row>> {
    let of = |way: &str| results.points.iter().find(|point| point.candidate == way);
    let mut rows = Vec::new();
    for way in ["gold"].into_iter().chain(WAYS) {
        let point = of(way).ok_or_else(|| format!("{title}: {way} was not rendered"))?;
        let error = |name: &str| (way != "gold").then(|| mean(point, name)).flatten();
        rows.push(Row {
            scene: title.into(),
            way: way.into(),
            seconds: point.seconds.estimate,
            speed_up: point
                .speed_up
                .as_ref()
                .filter(|_| way != "gold")
                .map(|speed_up| SpeedUp { estimate: speed_up.estimate, range: speed_up.range }),
            code_mse_percent: error("code_mse_percent"),
            code_pixels_percent: error("code_pixels_percent"),
            vdp_mean_percent: error("vdp_mean_percent"),
            vdp_visible_percent: error("vdp_visible_percent"),
            vdp_localized_mean_percent: error("vdp_localized_mean_percent"),
            vdp_localized_visible_percent: error("vdp_localized_visible_percent"),
        });
    }
    Ok(rows)
}

/// An error against the gold standard, the mean over seeds; nothing where a seed lacks it.
fn mean(point: &PointResult, name: &str) -> Option<f64> {
    let each = point.runs.iter().map(|trial| {
        let errors = serde_json::to_value(trial.errors.get("gold")?).ok()?;
        errors.get(name).and_then(Value::as_f64)
    });
    let each: Vec<f64> = each.collect::<Option<_>>()?;
    (!each.is_empty()).then(|| each.iter().sum::<f64>() / each.len() as f64)
}
