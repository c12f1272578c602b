//! Error against run time, as SVG.

use plotters::prelude::*;
use serde::Serialize;

use super::super::axis::{Ends, around, color_of, ticks};
use super::super::candidate::GOLD;
use super::super::request::Metric;
use super::super::results::{PointResult, Results};
use super::super::statistics::Interval;

const SIZE: (u32, u32) = (880, 560);

/// The most places told on an axis, unless there are as many powers of ten.
const MOST_TICKS: usize = 10;

/// A drawing with its title.
#[derive(Debug, Serialize)]
pub(super) struct Plot {
    title: String,
    svg: String,
}

/// A point with its intervals.
struct Place {
    time: Interval,
    error: Interval,
}

/// Every candidate's error against its run time between logarithmic axes, both with intervals;
/// nothing where no error is above 0.
pub(super) fn error_against_time(
    results: &Results,
    metric: Metric,
) -> Result<Option<Plot>, Box<dyn std::error::Error>> {
    let mut series: Vec<(String, Vec<Place>)> = Vec::new();
    for point in &results.points {
        let Some(place) = place(results, point, metric) else { continue };
        match series.last_mut().filter(|(name, _)| *name == point.candidate) {
            Some((_, places)) => places.push(place),
            None => series.push((point.candidate.clone(), vec![place])),
        }
    }
    let own = metric.of(&results.target().own).filter(|own| *own > 0.0);
    let places = || series.iter().flat_map(|(_, places)| places);
    let errors = places().map(|p| p.error.estimate).chain(own);
    let times = around(places().map(|p| p.time.estimate), 1.5);
    let (Some(times), Some(errors)) = (times, around(errors, 2.0)) else {
        return Ok(None);
    };
    let mut svg = String::new();
    draw(&mut svg, results, metric, &series, own, (times, errors))?;
    let title = format!("{} against run time", metric.title());
    Ok(Some(Plot { title, svg }))
}

fn draw(
    svg: &mut String,
    results: &Results,
    metric: Metric,
    series: &[(String, Vec<Place>)],
    own: Option<f64>,
    (times, errors): (Ends, Ends),
) -> Result<(), Box<dyn std::error::Error>> {
    let root = SVGBackend::with_string(svg, SIZE).into_drawing_area();
    root.fill(&WHITE)?;
    let mut chart = ChartBuilder::on(&root)
        .margin(12)
        .x_label_area_size(44)
        .y_label_area_size(84)
        .build_cartesian_2d(
            (times.0..times.1).log_scale().with_key_points(ticks(times, MOST_TICKS)),
            (errors.0..errors.1).log_scale().with_key_points(ticks(errors, MOST_TICKS)),
        )?;
    let label = |v: &f64| super::figure(*v);
    chart
        .configure_mesh()
        .light_line_style(BLACK.mix(0.04))
        .bold_line_style(BLACK.mix(0.12))
        .x_desc("run time in seconds, without loading and writing")
        .y_desc(format!("{} against {}", metric.title(), results.target().name))
        .x_label_formatter(&label)
        .y_label_formatter(&label)
        .x_labels(MOST_TICKS)
        .y_labels(MOST_TICKS)
        .label_style(("sans-serif", 14))
        .draw()?;
    for (index, (name, places)) in series.iter().enumerate() {
        let color = if name == GOLD { BLACK.to_rgba() } else { color_of(index, series.len()) };
        for Place { time, error } in places {
            let (x, y) = (time.estimate, error.estimate);
            let lines = [
                time.range.map(|range| within(range, times)).map(|(a, b)| vec![(a, y), (b, y)]),
                error.range.map(|range| within(range, errors)).map(|(a, b)| vec![(x, a), (x, b)]),
            ];
            let lines = lines.into_iter().flatten();
            chart.draw_series(lines.map(|ends| PathElement::new(ends, color.mix(0.35))))?;
        }
        let dots: Vec<(f64, f64)> =
            places.iter().map(|p| (p.time.estimate, p.error.estimate)).collect();
        chart
            .draw_series(LineSeries::new(dots.clone(), color.stroke_width(2)))?
            .label(name)
            .legend(move |(x, y)| Rectangle::new([(x, y - 5), (x + 12, y + 5)], color.filled()));
        let size = if name == GOLD { 8 } else { 4 };
        chart.draw_series(dots.iter().map(|dot| Circle::new(*dot, size, color.filled())))?;
    }
    if let Some(own) = own {
        let name = format!("own error of the {}", results.target().name);
        let grey = BLACK.mix(0.5);
        chart
            .draw_series(DashedLineSeries::new(
                [(times.0, own), (times.1, own)],
                6,
                4,
                grey.into(),
            ))?
            .label(name)
            .legend(move |(x, y)| PathElement::new([(x, y), (x + 12, y)], grey));
    }
    chart
        .configure_series_labels()
        .position(SeriesLabelPosition::LowerLeft)
        .background_style(WHITE.mix(0.85))
        .border_style(BLACK.mix(0.2))
        .label_font(("sans-serif", 13))
        .draw()?;
    root.present()?;
    Ok(())
}

fn place(results: &Results, point: &PointResult, metric: Metric) -> Option<Place> {
    let target = results.target();
    // Gold against itself shows its noise, not its error.
    if point.candidate == target.name {
        return None;
    }
    let errors = point.trials.iter().map(|t| metric.of(t.errors.get(&target.name)?));
    let error = Interval::of(&errors.collect::<Option<Vec<_>>>()?)?;
    (error.estimate > 0.0).then(|| Place { time: point.seconds.clone(), error })
}

/// What of an interval lies between the `ends` of an axis.
fn within(range: [f64; 2], ends: Ends) -> (f64, f64) {
    let [low, high] = range.map(|v| v.clamp(ends.0, ends.1));
    (low, high)
}
