//! Sweeps as SVG.

use plotters::prelude::*;
use serde::Serialize;

use super::super::case::Curve;

const SIZE: (u32, u32) = (480, 320);

/// Smallest value that is drawn: what is 0 lies there.
const LEAST: f64 = 1e-18;

/// The colour of what was found, until the page's own stands in its place.
const FOUND: RGBColor = RGBColor(31, 111, 139);

/// A drawing with its title.
#[derive(Debug, Serialize)]
pub(super) struct Plot {
    name: String,
    /// What theory says, where it says something.
    theory: Option<&'static str>,
    svg: String,
}

/// A curve between logarithmic axes, and what theory says beside it.
pub(super) fn plot(curve: &Curve) -> Result<Plot, Box<dyn std::error::Error>> {
    let above = |points: &[[f64; 2]]| -> Vec<(f64, f64)> {
        points.iter().map(|p| (p[0].max(LEAST), p[1].max(LEAST))).collect()
    };
    let (found, theory) = (above(&curve.points), above(&curve.theory));
    let ends = |of: fn(&(f64, f64)) -> f64| {
        let values = || found.iter().chain(&theory).map(of);
        let low = values().fold(f64::INFINITY, f64::min);
        let high = values().fold(LEAST, f64::max);
        low.min(high) / 2.0..high * 2.0
    };
    let (across, up) = (ends(|p| p.0), ends(|p| p.1));
    let mut svg = String::new();
    {
        let root = SVGBackend::with_string(&mut svg, SIZE).into_drawing_area();
        let mut chart = ChartBuilder::on(&root)
            .margin(6)
            .x_label_area_size(40)
            .y_label_area_size(68)
            .build_cartesian_2d(across.log_scale(), up.log_scale())?;
        let label = |v: &f64| format!("{v:.0e}");
        chart
            .configure_mesh()
            .light_line_style(TRANSPARENT)
            .bold_line_style(BLACK.mix(0.12))
            .x_desc(curve.axes[0])
            .y_desc(curve.axes[1])
            .x_label_formatter(&label)
            .y_label_formatter(&label)
            .x_labels(5)
            .y_labels(6)
            .label_style(("sans-serif", 14))
            .draw()?;
        chart.draw_series(LineSeries::new(found.clone(), FOUND.stroke_width(2)))?;
        chart.draw_series(found.iter().map(|p| Circle::new(*p, 3, FOUND.filled())))?;
        if !theory.is_empty() {
            let grey = BLACK.mix(0.55);
            chart.draw_series(DashedLineSeries::new(theory.clone(), 6, 4, grey.into()))?;
        }
        root.present()?;
    }
    let theory = (!theory.is_empty()).then_some(curve.theory_name);
    // Colours are the page's, light or dark.
    let svg = svg.replace("#000000", "currentColor").replace("#1F6F8B", "var(--found)");
    Ok(Plot { name: curve.name.clone(), theory, svg })
}
