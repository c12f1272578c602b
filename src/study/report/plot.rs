//! Error against run time, for the page's script to draw.

use serde::Serialize;

use super::super::candidate::GOLD;
use super::super::gain::UNIFORM;
use super::super::measured::{PointResult, RunResult};
use super::super::request::Metric;
use super::super::results::Results;
use super::super::statistics::Interval;
use super::super::target::Target;

/// The errors that are drawn against run time, beside the one that answers are about.
const PLOTTED: [Metric; 4] = [Metric::RelativeMse, Metric::Mse, Metric::CodeMse, Metric::Flip];

/// All drawings of a page.
#[derive(Debug, Serialize)]
pub(super) struct Plots<'a> {
    /// The name of the target.
    target: &'a str,
    /// Names that are drawn in colour at first, the directed candidate first.
    core: Vec<&'a str>,
    /// A drawing for each error.
    metrics: Vec<Plot<'a>>,
}

#[derive(Debug, Serialize)]
struct Plot<'a> {
    title: &'static str,
    /// The target's own error.
    own: Option<f64>,
    series: Vec<Series<'a>>,
}

#[derive(Debug, Serialize)]
struct Series<'a> {
    name: &'a str,
    about: &'a str,
    points: Vec<Place<'a>>,
}

/// A point with its intervals: run time in seconds across, error up.
#[derive(Debug, Serialize)]
struct Place<'a> {
    label: &'a str,
    x: f64,
    xr: Option<[f64; 2]>,
    y: f64,
    yr: Option<[f64; 2]>,
}

/// Every candidate's error against its run time, by the study's metric first; metrics by which no
/// error is above 0 are left out.
pub(super) fn plots(results: &Results) -> Plots<'_> {
    let others = PLOTTED.into_iter().filter(|metric| *metric != results.metric());
    let metrics = std::iter::once(results.metric()).chain(others);
    let directed = results.headline.as_ref().map(|headline| headline.candidate.as_str());
    Plots {
        target: super::target_title(results),
        core: directed.into_iter().chain([UNIFORM]).collect(),
        metrics: metrics.filter_map(|metric| plot(results, metric)).collect(),
    }
}

fn plot(results: &Results, metric: Metric) -> Option<Plot<'_>> {
    let mut series: Vec<Series<'_>> = Vec::new();
    for point in &results.points {
        let Some(place) = place(results, point, metric) else { continue };
        match series.last_mut().filter(|series| series.name == point.candidate) {
            Some(series) => series.points.push(place),
            None => series.push(Series {
                name: &point.candidate,
                about: &point.about,
                points: vec![place],
            }),
        }
    }
    let own = metric.value(&results.target().own).filter(|own| *own > 0.0);
    (!series.is_empty()).then_some(Plot { title: metric.title(), own, series })
}

fn place<'a>(results: &Results, point: &'a PointResult, metric: Metric) -> Option<Place<'a>> {
    let errors = point.runs.iter().map(|result| comparable(results.target(), result, metric));
    let error = Interval::from_values(&errors.collect::<Option<Vec<_>>>()?)?;
    (error.estimate > 0.0).then(|| Place {
        label: &point.label,
        x: point.seconds.estimate,
        xr: point.seconds.range,
        y: error.estimate,
        yr: error.range,
    })
}

/// The error of a render. Gold, where it is the target, was measured against half of it: squared
/// errors are told as beside the whole, others are left out.
fn comparable(target: &Target, result: &RunResult, metric: Metric) -> Option<f64> {
    let error = metric.value(result.errors.get(&target.name)?)?;
    if result.run.candidate != GOLD || target.name != GOLD {
        return Some(error);
    }
    let own = metric.value(&target.own).filter(|_| metric.is_squared())?;
    Some(error - target.own_of_other_half(own, result.run.round) + own).filter(|e| *e > 0.0)
}
