//! `volumes/farm.svg`: speed-up against nodes, a panel a scene.

use fogbow::study::axis::ticks;
use plotters::coord::Shift;
use plotters::prelude::*;

use super::Result;
use super::farm::{Costs, Row, costs};
use super::farm_model::{Kind, MOST_NODES, simulated, speed_up};

const SIZE: (u32, u32) = (1140, 470);

/// Height of the legend.
const LEGEND: u32 = 76;

/// Nodes where a simulation is drawn.
const SIMULATED: [u32; 7] = [2, 5, 16, 50, 160, 500, 1000];

/// How each of [`Kind::ALL`] is drawn: colours of Okabe and Ito's set, which people who confuse colours tell apart, and
/// dashes.
const STYLES: [(RGBColor, bool); 4] = [
    (RGBColor(0xd5, 0x5e, 0x00), false),
    (RGBColor(0xa6, 0x6f, 0x00), true),
    (RGBColor(0x00, 0x72, 0xb2), false),
    (RGBColor(0x8f, 0x3f, 0x71), true),
];

type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;

/// The plot; nothing where no costs were measured.
pub fn draw(rows: &[Row]) -> Result<Option<String>> {
    let scenes: Vec<&Costs> = costs(rows).collect();
    if scenes.is_empty() {
        return Ok(None);
    }
    let mut svg = String::new();
    {
        let root = SVGBackend::with_string(&mut svg, SIZE).into_drawing_area();
        root.fill(&WHITE)?;
        let (upper, lower) = root.split_vertically(SIZE.1 - LEGEND);
        for (costs, panel) in scenes.iter().zip(upper.split_evenly((1, scenes.len()))) {
            chart(&panel, costs)?;
        }
        legend(&lower)?;
        root.present()?;
    }
    Ok(Some(svg))
}

fn chart(panel: &Area<'_>, costs: &Costs) -> Result<()> {
    let most = f64::from(MOST_NODES);
    let ends = (1.0, most);
    let mut chart = ChartBuilder::on(panel)
        .margin(12)
        .caption(&costs.scene, ("sans-serif", 17).into_font().color(&BLACK.mix(0.8)))
        .x_label_area_size(40)
        .y_label_area_size(48)
        .build_cartesian_2d(
            (ends.0..ends.1).log_scale().with_key_points(ticks(ends, 4)),
            (ends.0..ends.1).log_scale().with_key_points(ticks(ends, 4)),
        )?;
    let label = |v: &f64| format!("{v}");
    chart
        .configure_mesh()
        .light_line_style(BLACK.mix(0.04))
        .bold_line_style(BLACK.mix(0.12))
        .x_desc("nodes")
        .y_desc("times faster than one node")
        .x_label_formatter(&label)
        .y_label_formatter(&label)
        .label_style(("sans-serif", 13))
        .draw()?;
    let ideal = [(1.0, 1.0), (most, most)];
    chart.draw_series(DashedLineSeries::new(ideal, 5, 4, BLACK.mix(0.4).into()))?;
    // Nodes evenly on the axis.
    let mut nodes: Vec<u32> =
        (0..=120).map(|step| most.powf(f64::from(step) / 120.0).round() as u32).collect();
    nodes.dedup();
    for (kind, (color, is_dashed)) in Kind::ALL.into_iter().zip(STYLES) {
        let line = nodes.iter().map(|nodes| (f64::from(*nodes), speed_up(costs, kind, *nodes)));
        let style = color.stroke_width(2);
        if is_dashed {
            chart.draw_series(DashedLineSeries::new(line, 7, 4, style))?;
        } else {
            chart.draw_series(LineSeries::new(line, style))?;
        }
        let dots = SIMULATED.map(|nodes| (f64::from(nodes), simulated(costs, kind, nodes)));
        let dots = dots.into_iter().filter(|(_, times)| *times >= 1.0);
        chart.draw_series(dots.map(|at| Circle::new(at, 3, color.filled())))?;
    }
    Ok(())
}

/// What colours, dashes and dots mean.
fn legend(area: &Area<'_>) -> Result<()> {
    let font = || ("sans-serif", 15).into_font().color(&BLACK.mix(0.8));
    let place = |index: usize| (64 + 360 * (index % 3) as i32, 14 + 28 * (index / 3) as i32);
    let entry = |index: usize, name: &str| {
        let (x, y) = place(index);
        area.draw(&Text::new(name.to_owned(), (x + 54, y - 8), font()))
    };
    let dash = |index: usize, style: ShapeStyle, is_dashed: bool| -> Result<()> {
        let (x, y) = place(index);
        let pieces: &[[i32; 2]] =
            if is_dashed { &[[0, 10], [15, 25], [30, 40]] } else { &[[0, 40]] };
        for [from, to] in pieces {
            area.draw(&PathElement::new([(x + from, y), (x + to, y)], style))?;
        }
        Ok(())
    };
    for (index, (kind, (color, is_dashed))) in Kind::ALL.into_iter().zip(STYLES).enumerate() {
        dash(index, color.stroke_width(3), is_dashed)?;
        entry(index, kind.title())?;
    }
    let ideal = Kind::ALL.len();
    dash(ideal, BLACK.mix(0.4).stroke_width(1), true)?;
    entry(ideal, "ideal")?;
    let (x, y) = place(ideal + 1);
    area.draw(&Circle::new((x + 20, y), 4, BLACK.mix(0.7).filled()))?;
    entry(ideal + 1, "simulated")?;
    Ok(())
}
