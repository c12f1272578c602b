//! `volumes/peers.svg`: error against CPU time in the smoke box.

use super::equal_error::{Point, front};
use super::peers::Row;

/// Width and height in pixels.
const SIZE: [f64; 2] = [800.0, 520.0];

/// Left, top, right and bottom of the axes.
const AXES: [f64; 4] = [84.0, 64.0, 776.0, 462.0];

/// From and to where the axes go: seconds and error.
const SECONDS: [f64; 2] = [0.2, 200.0];
const ERRORS: [f64; 2] = [0.00005, 0.04];

const SCENE: &str = "smoke";

/// How a renderer is drawn. Colours are after Okabe and Ito's set, which people who confuse colours tell
/// apart; marks and dashes differ as well.
struct Series {
    renderer: &'static str,
    label: &'static str,
    color: &'static str,
    dashes: &'static str,
    mark: Mark,
    /// The point beside which the label stands, counted from the last: 0 is the slowest.
    beside: usize,
    /// From there, in pixels.
    offset: [f64; 2],
}

#[derive(Clone, Copy)]
enum Mark {
    Circle,
    Square,
    Triangle,
    Diamond,
}

const SERIES: [Series; 5] = [
    Series {
        renderer: "fogbow-fixed",
        label: "fogbow, fixed",
        color: "#d55e00",
        dashes: "none",
        mark: Mark::Circle,
        beside: 0,
        offset: [12.0, 5.0],
    },
    Series {
        renderer: "fogbow-xs",
        label: "fogbow, directed (xs)",
        color: "#a66f00",
        dashes: "none",
        mark: Mark::Square,
        beside: 0,
        offset: [8.0, 22.0],
    },
    Series {
        renderer: "cycles",
        label: "Cycles, null scattering",
        color: "#0072b2",
        dashes: "7 4",
        mark: Mark::Triangle,
        beside: 0,
        offset: [12.0, 5.0],
    },
    Series {
        renderer: "cycles-biased-oidn",
        label: "Cycles, biased march, denoised",
        color: "#00795a",
        dashes: "7 4",
        mark: Mark::Square,
        beside: 1,
        offset: [10.0, -8.0],
    },
    Series {
        renderer: "mitsuba",
        label: "Mitsuba",
        color: "#8f3f71",
        dashes: "2 3",
        mark: Mark::Diamond,
        beside: 1,
        offset: [12.0, -4.0],
    },
];

/// The plot, on a white card that reads on light and dark pages.
pub fn draw(rows: &[Row]) -> String {
    let [width, height] = SIZE;
    let mut out = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" \
         viewBox=\"0 0 {width} {height}\" role=\"img\" font-family=\"sans-serif\">\n\
         <title>Relative MSE against CPU time in the smoke box: fogbow, Cycles and Mitsuba</title>\n\
         <rect x=\"0.5\" y=\"0.5\" width=\"{}\" height=\"{}\" rx=\"8\" fill=\"#ffffff\" \
         stroke=\"#d0d0d0\"/>\n",
        width - 1.0,
        height - 1.0
    );
    let [left, top, right, bottom] = AXES;
    out += &text([left, 30.0], 17.0, "#1a1a1a", "start", "Error against CPU time, smoke box");
    let below = "left and down is better; faint points are slower than a better one";
    out += &text([left, 50.0], 13.0, "#555555", "start", below);
    for (value, at) in ticks(SECONDS) {
        let x = place([value, ERRORS[0]])[0];
        out += &grid([x, top], [x, bottom], at.is_some());
        if let Some(label) = at {
            out += &text([x, bottom + 20.0], 14.0, "#333333", "middle", &label);
        }
    }
    for (value, at) in ticks(ERRORS) {
        let y = place([SECONDS[0], value])[1];
        out += &grid([left, y], [right, y], at.is_some());
        if let Some(label) = at {
            out += &text([left - 8.0, y + 5.0], 14.0, "#333333", "end", &label);
        }
    }
    let middle = f64::midpoint(left, right);
    let below = [middle, bottom + 42.0];
    out += &text(below, 14.0, "#333333", "middle", "CPU seconds over the number of threads");
    out += &format!(
        "<text transform=\"translate(22 {:.1}) rotate(-90)\" font-size=\"14\" fill=\"#333333\" \
         text-anchor=\"middle\">relative MSE</text>\n",
        f64::midpoint(top, bottom)
    );
    for series in &SERIES {
        out += &line(rows, series);
    }
    out + "</svg>\n"
}

/// A renderer's points, a line through those better than all sooner ones, and its name.
fn line(rows: &[Row], series: &Series) -> String {
    let own = rows.iter().filter(|row| row.scene == SCENE && row.renderer == series.renderer);
    let points: Vec<Point> = own.map(|row| (row.seconds, row.relmse)).collect();
    let best = front(&points);
    let at = |&(seconds, error): &Point| place([seconds, error]);
    let path: Vec<String> = best.iter().map(at).map(|[x, y]| format!("{x:.1},{y:.1}")).collect();
    let Series { color, dashes, .. } = series;
    let mut out = format!(
        "<polyline points=\"{}\" fill=\"none\" stroke=\"{color}\" stroke-width=\"2.5\" \
         stroke-dasharray=\"{dashes}\"/>\n",
        path.join(" ")
    );
    for point in &points {
        let opacity = if best.contains(point) { 1.0 } else { 0.3 };
        out += &mark(series.mark, at(point), color, opacity);
    }
    if let Some(point) = best.len().checked_sub(1 + series.beside).and_then(|i| best.get(i)) {
        let [x, y] = at(point);
        let [dx, dy] = series.offset;
        // A white rim keeps the name apart from lines that it crosses.
        out += &format!(
            "<text x=\"{:.1}\" y=\"{:.1}\" font-size=\"15\" font-weight=\"600\" fill=\"{color}\" \
             stroke=\"#ffffff\" stroke-width=\"4\" paint-order=\"stroke\">{}</text>\n",
            x + dx,
            y + dy,
            series.label
        );
    }
    out
}

fn mark(mark: Mark, [x, y]: [f64; 2], color: &str, opacity: f64) -> String {
    let outline = |corners: &[[f64; 2]]| {
        let places: Vec<String> =
            corners.iter().map(|[dx, dy]| format!("{:.1},{:.1}", x + dx, y + dy)).collect();
        format!(
            "<polygon points=\"{}\" fill=\"{color}\" fill-opacity=\"{opacity}\"/>\n",
            places.join(" ")
        )
    };
    match mark {
        Mark::Circle => format!(
            "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"5\" fill=\"{color}\" \
             fill-opacity=\"{opacity}\"/>\n"
        ),
        Mark::Square => outline(&[[-4.5, -4.5], [4.5, -4.5], [4.5, 4.5], [-4.5, 4.5]]),
        Mark::Triangle => outline(&[[0.0, -6.0], [5.5, 4.5], [-5.5, 4.5]]),
        Mark::Diamond => outline(&[[0.0, -6.0], [6.0, 0.0], [0.0, 6.0], [-6.0, 0.0]]),
    }
}

/// Where seconds and error are, in pixels.
fn place([seconds, error]: [f64; 2]) -> [f64; 2] {
    let part = |value: f64, [from, to]: [f64; 2]| (value / from).ln() / (to / from).ln();
    let [left, top, right, bottom] = AXES;
    [left + part(seconds, SECONDS) * (right - left), bottom - part(error, ERRORS) * (bottom - top)]
}

/// Places on a logarithmic axis, with labels at the powers of ten.
fn ticks([from, to]: [f64; 2]) -> Vec<(f64, Option<String>)> {
    let powers = from.log10().floor() as i32..=to.log10().floor() as i32;
    let each = powers.flat_map(|power| (1..10).map(move |digit| (digit, power)));
    each.map(|(digit, power)| {
        let value = f64::from(digit) * 10_f64.powi(power);
        (value, (digit == 1).then(|| format!("{:.*}", (-power).max(0) as usize, value)))
    })
    .filter(|(value, _)| (from..=to).contains(value))
    .collect()
}

fn grid([x1, y1]: [f64; 2], [x2, y2]: [f64; 2], is_labelled: bool) -> String {
    let color = if is_labelled { "#c8c8c8" } else { "#ececec" };
    format!(
        "<line x1=\"{x1:.1}\" y1=\"{y1:.1}\" x2=\"{x2:.1}\" y2=\"{y2:.1}\" stroke=\"{color}\"/>\n"
    )
}

fn text([x, y]: [f64; 2], size: f64, color: &str, anchor: &str, text: &str) -> String {
    format!(
        "<text x=\"{x:.1}\" y=\"{y:.1}\" font-size=\"{size}\" fill=\"{color}\" \
         text-anchor=\"{anchor}\">{text}</text>\n"
    )
}
