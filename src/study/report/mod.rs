//! `report.html`: one file that opens offline.

mod pictures;
mod plot;

use std::path::Path;

use minijinja::context;
use minijinja::value::{Serde, Value};
use serde::Serialize;

use super::ablation::Effect;
use super::candidate::GOLD;
use super::contrast::Outcome;
use super::convergence::Convergence;
use super::headline::Contrast;
use super::html::{json, write_page};
use super::measured::{Estimate, PointResult};
use super::request::Metric;
use super::results::Results;
use super::verdict::{figure, interval};
use crate::error::Result;
use crate::image::{AgxCurve, viridis};

const PAGE: &str = include_str!("page.html");
const STYLE: &str = include_str!("page.css");
const SCRIPT: &str =
    concat!(include_str!("table.js"), include_str!("plot.js"), include_str!("viewer.js"));

/// The heads of the table of candidates but for the one of the error, in the order of its cells.
const HEADS: [&str; 22] = [
    "candidate",
    "budget",
    "seconds",
    "median",
    "",
    "gold's time / its own",
    "gain at equal error (time)",
    "gain at equal time (error)",
    "noise",
    "step",
    "bias",
    "bias, %",
    "mean ratio",
    "MSE of codes, %",
    "pixels in error, %",
    "VDP, %",
    "VDP > 0.75, %",
    "localised VDP, %",
    "localised VDP > 0.75, %",
    "1 - SSIM",
    "FLIP",
    "JOD lost",
];

/// Writes `report.html` to the `folder` of the study that `results` are of.
///
/// # Errors
/// Where a picture of the study cannot be read or the page cannot be made or written.
pub fn write_report(results: &Results, folder: &Path) -> Result<()> {
    let path = folder.join("report.html");
    let gallery = pictures::gallery(results, folder, &path)?;
    let rows: Vec<Vec<Cell>> = results.points.iter().map(|point| row(results, point)).collect();
    let palette: Vec<[u8; 3]> = (0..256).map(|i| viridis(f64::from(i) / 255.0)).collect();
    let heads = HEADS.map(|head| if head.is_empty() { results.metric().title() } else { head });
    let view = serde_json::json!({
        "exposure": results.view.exposure,
        "transform": results.view.transform,
        "agx": AgxCurve::new(),
    });

    let context = context! {
        style => STYLE,
        script => SCRIPT,
        results => Value::from(Serde(results)),
        sentences => Value::from(Serde(&results.verdict.iter().map(|s| Sentence::new(s)).collect::<Vec<_>>())),
        numbers => Value::from(Serde(&numbers(results))),
        machine => results.machine.to_string(),
        metric => results.metric().title(),
        target => target_title(results),
        targets => target_rows(results),
        plots => json(&path, &plot::plots(results))?,
        heads => heads,
        rows => Value::from(Serde(&rows)),
        curves => curve_rows(results),
        effects => Value::from(Serde(&effect_rows(results))),
        convergence => convergence_rows(results),
        cards => Value::from(Serde(&gallery.cards)),
        views => json(&path, &gallery.views)?,
        view => json(&path, &view)?,
        seeds => seeds(results),
        palette => json(&path, &palette)?,
    };
    write_page(&path, PAGE, context)
}

/// A sentence of the verdict, and the command that it ends with.
#[derive(Debug, Serialize)]
struct Sentence<'a> {
    text: &'a str,
    command: Option<&'a str>,
}

impl<'a> Sentence<'a> {
    fn new(sentence: &'a str) -> Self {
        sentence.find(": fogbow ").map_or(Self { text: sentence, command: None }, |end| Self {
            text: &sentence[..=end],
            command: Some(&sentence[end + ": ".len()..]),
        })
    }
}

/// A number of the headline.
#[derive(Debug, Serialize)]
struct Number {
    value: String,
    what: String,
    range: String,
}

/// The three ratios of the headline.
fn numbers(results: &Results) -> Vec<Number> {
    let Some(headline) = &results.headline else { return Vec::new() };
    let number = |contrast: &Contrast, what: &str| {
        let ratio = contrast.ratio.as_ref()?;
        let told = match contrast.outcome {
            Outcome::Equal => ": equal to within 10 %",
            Outcome::Open => ": open",
            Outcome::Above | Outcome::Below => "",
        };
        let range = ratio.range.map_or_else(
            || "a single seed has no interval".into(),
            |[low, high]| format!("{} to {}{told}", figure(low), figure(high)),
        );
        Some(Number { value: format!("{}×", figure(ratio.estimate)), what: what.into(), range })
    };
    let all = [
        number(&headline.time_saved, "as fast as the gold standard"),
        number(&headline.error_gain, "the error, by uniform sampling in the same time"),
        number(&headline.error_cost, "the error of one gold standard"),
    ];
    all.into_iter().flatten().collect()
}

/// The target in words.
fn target_title(results: &Results) -> &str {
    let name = results.target().name.as_str();
    if name == GOLD { "gold standard" } else { name }
}

/// How many seeds there are, and of what there are fewer.
fn seeds(results: &Results) -> String {
    let fewer = results.plan.fewer.iter().map(|(name, seeds)| format!(", {seeds} of {name}"));
    format!("{} of each{}", results.plan.seeds, fewer.collect::<String>())
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

    fn estimate(estimate: &Estimate) -> Self {
        match estimate {
            Estimate::Found(found) => Self { text: interval(found), sort: Some(found.estimate) },
            Estimate::None(why) => Self { text: why.clone(), sort: None },
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
        let errors = point.runs.iter().map(|t| metric.value(t.errors.get(target)?));
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
    let ratios = point.runs.iter().filter_map(|t| t.errors.get(target)?.mean_ratio);
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
        Cell::estimate(&point.gain_at_equal_error),
        Cell::estimate(&point.gain_at_equal_time),
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
            metric.value(&target.own).map_or_else(|| "–".into(), figure),
        ]
    };
    results.targets.iter().map(cells).collect()
}

/// Name, slope and times to reach the errors asked for, of each candidate.
fn curve_rows(results: &Results) -> Vec<Vec<String>> {
    let text = |estimate: &Estimate| Cell::estimate(estimate).text;
    results
        .curves
        .iter()
        .map(|curve| {
            let slope = curve.slope.map_or_else(|| "–".into(), |slope| format!("{slope:.2}"));
            let mut cells = vec![curve.candidate.clone(), slope];
            cells.extend(curve.time_to.iter().map(|(_, estimate)| text(estimate)));
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
            Cell::estimate(&effect.error_gain),
            Cell::estimate(&effect.time_gain),
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
