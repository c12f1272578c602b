//! `report.html`: one file that opens offline.

mod pictures;
mod plot;

use std::path::Path;

use minijinja::context;
use minijinja::value::{Serde, Value};
use serde::Serialize;

use super::ablation::Effect;
use super::convergence::Convergence;
use super::html::{json, unmade, write_page};
use super::request::Metric;
use super::results::{Answer, PointResult, Results};
use super::verdict::{figure, interval};
use crate::error::Result;
use crate::image::viridis;

const PAGE: &str = include_str!("page.html");
const STYLE: &str = include_str!("page.css");
const SCRIPT: &str = include_str!("page.js");

/// The errors that are drawn against run time, beside the one that answers are about.
const PLOTTED: [Metric; 4] = [Metric::RelativeMse, Metric::Mse, Metric::CodeMse, Metric::Flip];

/// Writes `report.html` to the `folder` of the study that `results` are of.
///
/// # Errors
/// Where a picture of the study cannot be read or the page cannot be made or written.
pub fn write_report(results: &Results, folder: &Path) -> Result<()> {
    let path = folder.join("report.html");
    let mut metrics = vec![results.metric()];
    metrics.extend(PLOTTED.into_iter().filter(|metric| *metric != results.metric()));
    let mut plots = Vec::new();
    for metric in metrics {
        plots.extend(plot::error_against_time(results, metric).map_err(|e| unmade(&path, &e))?);
    }
    let gallery = pictures::gallery(results, folder, &path)?;
    let rows: Vec<Vec<Cell>> = results.points.iter().map(|point| row(results, point)).collect();
    let palette: Vec<[u8; 3]> = (0..256).map(|i| viridis(f64::from(i) / 255.0)).collect();

    let context = context! {
        style => STYLE,
        script => SCRIPT,
        results => Value::from(Serde(results)),
        machine => results.machine.to_string(),
        metric => results.metric().title(),
        target => &results.target().name,
        targets => target_rows(results),
        plots => Value::from(Serde(&plots)),
        rows => Value::from(Serde(&rows)),
        curves => curve_rows(results),
        effects => Value::from(Serde(&effect_rows(results))),
        convergence => convergence_rows(results),
        cards => Value::from(Serde(&gallery.cards)),
        views => json(&path, &gallery.views)?,
        palette => json(&path, &palette)?,
    };
    write_page(&path, PAGE, context)
}

/// A cell of the table: what is read and what is sorted by.
#[derive(Debug, Serialize)]
struct Cell {
    text: String,
    sort: Option<f64>,
}

impl Cell {
    fn number(value: Option<f64>) -> Self {
        Self { text: value.map_or_else(|| "–".into(), figure), sort: value }
    }

    fn answer(answer: &Answer) -> Self {
        match answer {
            Answer::Found(found) => Self { text: interval(found), sort: Some(found.estimate) },
            Answer::None(why) => Self { text: why.clone(), sort: None },
        }
    }

    fn text(text: &str) -> Self {
        Self { text: text.into(), sort: None }
    }
}

/// The cells of a point, in the order of the table's head in the page.
fn row(results: &Results, point: &PointResult) -> Vec<Cell> {
    let target = &results.target().name;
    let mean = |metric: Metric| {
        let errors = point.trials.iter().map(|t| metric.of(t.errors.get(target)?));
        let errors: Vec<f64> = errors.collect::<Option<_>>()?;
        Some(errors.iter().sum::<f64>() / errors.len() as f64)
    };
    let measured = point.errors.get(target);
    let error = measured.map_or_else(
        || Cell::text("–"),
        |m| Cell {
            text: format!("{}{}", interval(&m.error), if m.trusted { "" } else { " *" }),
            sort: Some(m.error.estimate),
        },
    );
    let ratios = point.trials.iter().filter_map(|t| t.errors.get(target)?.mean_ratio);
    let ratios: Vec<f64> = ratios.collect();
    let ratio = (!ratios.is_empty()).then(|| ratios.iter().sum::<f64>() / ratios.len() as f64);
    let split = point.relative_mse_split;
    let share = split.map(|s| s.bias / (s.bias + s.noise + s.step.unwrap_or(0.0)));
    vec![
        Cell::text(&point.candidate),
        Cell { text: point.label.clone(), sort: Some(f64::from(point.settings.rays)) },
        Cell { text: interval(&point.seconds), sort: Some(point.seconds.estimate) },
        Cell::number(Some(point.seconds.median)),
        error,
        point.speed_up.as_ref().map_or_else(
            || Cell::text("–"),
            |s| Cell { text: interval(s), sort: Some(s.estimate) },
        ),
        Cell::answer(&point.gain_at_equal_error),
        Cell::answer(&point.gain_at_equal_time),
        Cell::number(split.map(|split| split.noise)),
        Cell::number(split.and_then(|split| split.step)),
        Cell::number(split.map(|split| split.bias)),
        Cell::number(share.map(|share| 100.0 * share)),
        Cell::number(ratio),
        Cell::number(mean(Metric::CodeMse)),
        Cell::number(mean(Metric::CodePixels)),
        Cell::number(mean(Metric::VdpMean)),
        Cell::number(mean(Metric::VdpVisible)),
        Cell::number(mean(Metric::VdpLocalizedMean)),
        Cell::number(mean(Metric::VdpLocalizedVisible)),
        Cell::number(mean(Metric::Dssim)),
        Cell::number(mean(Metric::Flip)),
        Cell::number(mean(Metric::JodLost)),
    ]
}

/// Name, renders, rays, seconds and own error of each target.
fn target_rows(results: &Results) -> Vec<Vec<String>> {
    let metric = results.metric();
    let cells = |target: &super::Target| {
        vec![
            target.name.clone(),
            target.renders.to_string(),
            target.rays.to_string(),
            figure(target.seconds),
            metric.of(&target.own).map_or_else(|| "–".into(), figure),
        ]
    };
    results.targets.iter().map(cells).collect()
}

/// Name, slope and times to reach the errors asked for, of each candidate.
fn curve_rows(results: &Results) -> Vec<Vec<String>> {
    let answer = |answer: &Answer| Cell::answer(answer).text;
    results
        .curves
        .iter()
        .map(|curve| {
            let slope = curve.slope.map_or_else(|| "–".into(), |slope| format!("{slope:.2}"));
            let mut cells = vec![curve.candidate.clone(), slope];
            cells.extend(curve.time_to.iter().map(|(_, told)| answer(told)));
            cells
        })
        .collect()
}

/// Part, candidates, gains at equal time and equal error, and outcome of each effect.
fn effect_rows(results: &Results) -> Vec<Vec<Cell>> {
    let row = |effect: &Effect| {
        vec![
            Cell::text(&effect.part),
            Cell::text(&effect.with),
            Cell::text(&effect.without),
            Cell::answer(&effect.error_gain),
            Cell::answer(&effect.time_gain),
            Cell::text(effect.outcome()),
        ]
    };
    results.ablation.iter().map(row).collect()
}

/// Quantity, measured exponent and expected exponent of what falls with photons.
fn convergence_rows(results: &Results) -> Vec<[String; 3]> {
    let exponent = |v: Option<f64>| v.map_or_else(|| "–".into(), |v| format!("{v:.2}"));
    let rows = |c: &Convergence| {
        let [noise, bias] = [0, 1].map(|part| c.expected.map(|both| both[part]));
        // Whichever falls more slowly is what is left.
        let slower = c.expected.map(|[noise, bias]| noise.max(bias));
        [
            ("MSE", c.mse, slower),
            ("its noise", c.noise, noise),
            ("its bias", c.bias, bias),
            ("radius, or edge of cells", c.radius, None),
        ]
        .map(|(name, measured, theory)| [name.into(), exponent(measured), exponent(theory)])
        .to_vec()
    };
    results.convergence.as_ref().map(rows).unwrap_or_default()
}
