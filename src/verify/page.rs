//! The page of a run: the matrix as heat maps, the sweeps as plots, the cases as a table.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use super::case::{Curve, Group, Outcome};

/// Strain at which a cell of a heat map is as dark as it gets.
const DARKEST: f64 = 1.0;

const STYLE: &str = "body{font:15px/1.5 system-ui,sans-serif;margin:2rem auto;max-width:72rem;\
padding:0 1rem;color:#1c2430;background:#fff}table{border-collapse:collapse;margin:.5rem 0 1.5rem}\
td,th{padding:.2rem .6rem;border:1px solid #d5dae1;text-align:left;font-weight:normal}\
th{color:#566}.num{text-align:right;font-variant-numeric:tabular-nums}.fails{background:#c0392b;\
color:#fff}svg{max-width:100%}figure{margin:0 0 1.5rem}figcaption{color:#566}";

/// A page that needs nothing but itself. `command` is what made it.
pub fn page(outcomes: &[Outcome], command: &str) -> String {
    let failed = outcomes.iter().filter(|o| !o.holds()).count();
    let mut out = format!(
        "<!doctype html><html lang=\"en\"><meta charset=\"utf-8\"><title>fogbow verify</title>\
         <meta name=\"viewport\" content=\"width=device-width\"><style>{STYLE}</style>\
         <h1>fogbow verify</h1><p>fogbow {}: {} cases, {failed} failed. Made by \
         <code>{}</code>.</p><p>Strain is how much of its bounds the worst number of a case uses: \
         0 is right in the middle, above 1 is a failure.</p>",
        env!("CARGO_PKG_VERSION"),
        outcomes.len(),
        escaped(command),
    );
    out += "<h2>Stability matrix</h2>";
    for (plane, cells) in planes(outcomes) {
        heat_map(&mut out, plane, &cells);
    }
    out += "<h2>Sweeps</h2>";
    outcomes.iter().flat_map(|o| &o.findings.curves).for_each(|curve| plot(&mut out, curve));
    for group in Group::ALL {
        table(&mut out, group, outcomes);
    }
    out + "</html>\n"
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

/// Cells by plane, in the order of the cases.
fn planes(outcomes: &[Outcome]) -> Vec<(&str, Vec<&Outcome>)> {
    let mut planes: Vec<(&str, Vec<&Outcome>)> = Vec::new();
    for outcome in outcomes {
        let Some(cell) = &outcome.cell else { continue };
        match planes.iter_mut().find(|(plane, _)| *plane == cell.plane) {
            Some((_, cells)) => cells.push(outcome),
            None => planes.push((&cell.plane, vec![outcome])),
        }
    }
    planes
}

fn heat_map(out: &mut String, plane: &str, outcomes: &[&Outcome]) {
    let cells = || outcomes.iter().filter_map(|o| Some((o.cell.as_ref()?, *o)));
    let (mut rows, mut columns) = (Vec::new(), Vec::new());
    let mut at = BTreeMap::new();
    for (cell, outcome) in cells() {
        if !rows.contains(&&cell.row) {
            rows.push(&cell.row);
        }
        if !columns.contains(&&cell.column) {
            columns.push(&cell.column);
        }
        at.insert((&cell.row, &cell.column), outcome);
    }
    let _ = write!(out, "<h3>{}</h3><table><tr><th></th>", escaped(plane));
    for column in &columns {
        let _ = write!(out, "<th>{}</th>", escaped(column));
    }
    out.push_str("</tr>");
    for row in &rows {
        let _ = write!(out, "<tr><th>{}</th>", escaped(row));
        for column in &columns {
            match at.get(&(*row, *column)) {
                Some(outcome) => cell(out, outcome),
                None => out.push_str("<td></td>"),
            }
        }
        out.push_str("</tr>");
    }
    out.push_str("</table>");
}

fn cell(out: &mut String, outcome: &Outcome) {
    let strain = outcome.strain();
    let title = escaped(&format!("{}: {}", outcome.name, worst(outcome)));
    if outcome.holds() {
        let light = 97.0 - 40.0 * (strain / DARKEST).clamp(0.0, 1.0);
        let style = format!("background:hsl(150 45% {light:.0}%)");
        let _ = write!(out, "<td class=num title=\"{title}\" style=\"{style}\">{strain:.2}</td>");
    } else {
        let _ = write!(out, "<td class=\"num fails\" title=\"{title}\">{strain:.3}</td>");
    }
}

/// The worst number of a case in words.
fn worst(outcome: &Outcome) -> String {
    match (&outcome.error, outcome.worst()) {
        (Some(error), _) => error.clone(),
        (None, Some(c)) => {
            format!("{} is {:.6e}, bounds {:.6e} to {:.6e}", c.what, c.found, c.low, c.high)
        }
        (None, None) => "nothing checked".into(),
    }
}

fn table(out: &mut String, group: Group, outcomes: &[Outcome]) {
    let _ = write!(
        out,
        "<h2>{}</h2><table><tr><th>Case<th>Source<th>Bounds<th>Worst<th>Strain<th>Verdict</tr>",
        group.title()
    );
    for outcome in outcomes.iter().filter(|o| o.group == group) {
        let (class, verdict) = if outcome.holds() { ("", "holds") } else { ("fails", "FAILS") };
        let _ = write!(
            out,
            "<tr><td>{}<td>{}<td>{}<td>{}<td class=num>{:.3}<td class=\"{class}\">{verdict}</tr>",
            escaped(&outcome.name),
            escaped(outcome.source),
            escaped(outcome.reason),
            escaped(&worst(outcome)),
            outcome.strain(),
        );
    }
    out.push_str("</table>");
}

/// A line over logarithmic axes.
fn plot(out: &mut String, curve: &Curve) {
    const WIDTH: f64 = 560.0;
    const HEIGHT: f64 = 260.0;
    const MARGIN: f64 = 46.0;
    let logs: Vec<[f64; 2]> =
        curve.points.iter().map(|p| p.map(|v| v.max(1e-300).log10())).collect();
    let range = |axis: usize| {
        let values = || logs.iter().map(|p| p[axis]);
        let low = values().fold(f64::INFINITY, f64::min).floor();
        let high = values().fold(f64::NEG_INFINITY, f64::max).ceil();
        (low, high.max(low + 1.0))
    };
    let ((left, right), (bottom, top)) = (range(0), range(1));
    let x = |v: f64| MARGIN + (v - left) / (right - left) * (WIDTH - 2.0 * MARGIN);
    let y = |v: f64| HEIGHT - MARGIN - (v - bottom) / (top - bottom) * (HEIGHT - 2.0 * MARGIN);
    let mut marks = String::new();
    for p in &logs {
        let _ = write!(marks, "<circle cx=\"{:.1}\" cy=\"{:.1}\" r=\"3\"/>", x(p[0]), y(p[1]));
    }
    let line: Vec<String> = logs.iter().map(|p| format!("{:.1},{:.1}", x(p[0]), y(p[1]))).collect();
    let mut ticks = String::new();
    for (from, to, horizontal) in [(left, right, true), (bottom, top, false)] {
        let every = ((to - from) / 6.0).ceil();
        let mut at = from;
        while at <= to {
            let (tx, ty) = if horizontal {
                (x(at), HEIGHT - MARGIN + 18.0)
            } else {
                (MARGIN - 8.0, y(at) + 4.0)
            };
            let anchor = if horizontal { "middle" } else { "end" };
            let _ = write!(
                ticks,
                "<text x=\"{tx:.1}\" y=\"{ty:.1}\" text-anchor=\"{anchor}\">1e{at:.0}</text>"
            );
            at += every;
        }
    }
    let _ = write!(
        out,
        "<figure><svg viewBox=\"0 0 {WIDTH} {HEIGHT}\" width=\"{WIDTH}\" role=\"img\" \
         font-size=\"12\"><path d=\"M{MARGIN} {MARGIN}V{0}H{1}\" fill=\"none\" stroke=\"#99a\"/>\
         <polyline points=\"{2}\" fill=\"none\" stroke=\"#1f6f8b\" stroke-width=\"2\"/>\
         <g fill=\"#1f6f8b\">{marks}</g><g fill=\"#445\">{ticks}</g></svg>\
         <figcaption>{3}</figcaption></figure>",
        HEIGHT - MARGIN,
        WIDTH - MARGIN,
        line.join(" "),
        escaped(&curve.name),
    );
}
