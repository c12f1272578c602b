//! The sweeps as panels of one SVG.

use fogbow::study::axis::{around, color_of, ticks};
use plotters::coord::Shift;
use plotters::prelude::*;

use super::Result;
use super::scaling::{AXES, Row, SCENES};

const SIZE: (u32, u32) = (1140, 720);

/// Room beyond the outermost points, as a factor.
const MARGIN: f64 = 1.4;

/// The most places told on an axis, unless there are as many powers of ten.
const MOST_TICKS: usize = 8;

type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;

/// A measured setting.
struct Point<'a> {
    axis: &'a str,
    scene: &'a str,
    x: f64,
    is_lattice: bool,
    whole: f64,
}

/// Seconds against what is varied between logarithmic axes, a panel for each; nothing where no point
/// was measured.
pub fn draw(rows: &[Row]) -> Result<Option<String>> {
    let points: Vec<Point<'_>> = rows
        .iter()
        .filter_map(|row| match row {
            Row::Point { axis, scene, x, lattice, whole, .. } => {
                Some(Point { axis, scene, x: *x, is_lattice: *lattice, whole: *whole })
            }
            Row::Slope { .. } | Row::Memory { .. } => None,
        })
        .collect();
    if points.is_empty() { Ok(None) } else { panels(&points).map(Some) }
}

fn panels(points: &[Point<'_>]) -> Result<String> {
    let mut svg = String::new();
    {
        let root = SVGBackend::with_string(&mut svg, SIZE).into_drawing_area();
        root.fill(&WHITE)?;
        let panels = root.split_evenly((2, 3));
        let seconds = around(points.iter().map(|point| point.whole), MARGIN).ok_or("a point")?;
        for ((axis, _), panel) in AXES.into_iter().zip(&panels) {
            chart(panel, points, axis, seconds)?;
        }
        legend(&panels[AXES.len()])?;
        root.present()?;
    }
    Ok(svg)
}

fn chart(panel: &Area<'_>, points: &[Point<'_>], axis: &str, seconds: (f64, f64)) -> Result<()> {
    let places = || points.iter().filter(|point| point.axis == axis);
    let ends = around(places().map(|point| point.x), MARGIN).ok_or("a point")?;
    let mut chart = ChartBuilder::on(panel)
        .margin(12)
        .x_label_area_size(40)
        .y_label_area_size(52)
        .build_cartesian_2d(
            (ends.0..ends.1).log_scale().with_key_points(ticks(ends, MOST_TICKS)),
            (seconds.0..seconds.1).log_scale().with_key_points(ticks(seconds, MOST_TICKS)),
        )?;
    let label = |v: &f64| figure(*v);
    chart
        .configure_mesh()
        .light_line_style(BLACK.mix(0.04))
        .bold_line_style(BLACK.mix(0.12))
        .x_desc(axis)
        .y_desc("processor seconds")
        .x_label_formatter(&label)
        .y_label_formatter(&label)
        .label_style(("sans-serif", 13))
        .draw()?;
    let slope = if axis == "voxels" { 1.0 / 3.0 } else { 1.0 };
    // Through the middle of the panel.
    let (x, y) = ((ends.0 * ends.1).sqrt(), (seconds.0 * seconds.1).sqrt());
    let reach = (ends.1 / x).min((seconds.1 / y).powf(1.0 / slope));
    let guide = [1.0 / reach, reach].map(|at| (x * at, y * at.powf(slope)));
    chart.draw_series(DashedLineSeries::new(guide, 5, 4, BLACK.mix(0.4).into()))?;
    let name = if slope < 1.0 { "slope 1/3" } else { "slope 1" };
    let at = (guide[1].0 / MARGIN / 1.1, guide[1].1);
    let style = ("sans-serif", 12).into_font().color(&BLACK.mix(0.6));
    let place = plotters::style::text_anchor::Pos::new(
        plotters::style::text_anchor::HPos::Right,
        plotters::style::text_anchor::VPos::Top,
    );
    chart.draw_series([Text::new(name, at, style.pos(place))])?;
    for (index, scene) in SCENES.iter().enumerate() {
        let sweep: Vec<&Point<'_>> = places().filter(|point| point.scene == *scene).collect();
        let color = color_of(index, SCENES.len());
        let line = sweep.iter().map(|point| (point.x, point.whole));
        chart.draw_series(LineSeries::new(line, color.stroke_width(2)))?;
        for point in sweep {
            let at = (point.x, point.whole);
            chart.draw_series([Circle::new(at, 4, WHITE.filled())])?;
            let style = if point.is_lattice { color.filled() } else { color.stroke_width(2) };
            chart.draw_series([Circle::new(at, 4, style)])?;
        }
    }
    Ok(())
}

/// What colours and dots mean, where a sixth panel would be.
fn legend(panel: &Area<'_>) -> Result<()> {
    let font = || ("sans-serif", 15).into_font().color(&BLACK.mix(0.8));
    let mut y = 60;
    for (index, scene) in SCENES.iter().enumerate() {
        panel.draw(&PathElement::new(
            [(70, y), (110, y)],
            color_of(index, SCENES.len()).stroke_width(3),
        ))?;
        panel.draw(&Text::new(*scene, (124, y - 8), font()))?;
        y += 30;
    }
    for (name, style) in [
        ("light kept on a lattice", BLACK.mix(0.7).filled()),
        ("photons gathered along rays", BLACK.mix(0.7).stroke_width(2)),
    ] {
        panel.draw(&Circle::new((90, y), 4, style))?;
        panel.draw(&Text::new(name, (124, y - 8), font()))?;
        y += 30;
    }
    Ok(())
}

/// A number as short as can be.
fn figure(value: f64) -> String {
    let power = value.log10().floor() as i32;
    if (-2..4).contains(&power) {
        format!("{}", (1e4 * value).round() / 1e4)
    } else {
        format!("{value:e}")
    }
}
