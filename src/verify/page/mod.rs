//! The page of a run: every case on one axis with its bound, failures first; the matrix as heat maps,
//! the sweeps as plots.

mod plot;

use minijinja::value::{Serde, Value};
use minijinja::{AutoEscape, Environment, context};
use serde::Serialize;

use super::case::{Group, Outcome};

const PAGE: &str = include_str!("page.html");
const STYLE: &str = include_str!("page.css");

/// Where the axis of shares ends; what lies beyond is drawn there.
const AXIS: f64 = 1.25;

/// From exact to the bound: hues that colour-blind eyes tell apart, dark ones for marks.
const MARKS: [[f64; 3]; 3] = [[0.0, 150.0, 110.0], [200.0, 160.0, 0.0], [213.0, 80.0, 0.0]];

/// The same as backgrounds of dark text.
const FILLS: [[f64; 3]; 3] = [[178.0, 226.0, 207.0], [243.0, 229.0, 158.0], [244.0, 176.0, 132.0]];

/// A page that needs nothing but itself. `command` is what made it, and with `--case NAME` makes
/// one case again.
///
/// # Errors
/// Where the page or a plot cannot be drawn up.
pub fn page(outcomes: &[Outcome], command: &str) -> Result<String, Box<dyn std::error::Error>> {
    let curves = || outcomes.iter().flat_map(|outcome| &outcome.findings.curves);
    let plots: Vec<plot::Plot> = curves().map(plot::plot).collect::<Result<_, _>>()?;
    let rows = |which: &dyn Fn(&Outcome) -> bool| rows_of(outcomes, which, command);
    let of_groups = Group::ALL.map(|group| GroupTable {
        title: group.title(),
        cases: rows(&|outcome| outcome.group == group),
    });
    let groups: Vec<_> = of_groups.into_iter().filter(|group| !group.cases.is_empty()).collect();
    let lanes = Group::ALL.map(|group| Lane {
        title: group.title(),
        dots: dots(outcomes.iter().filter(|outcome| outcome.group == group)),
    });
    let lanes: Vec<_> = lanes.into_iter().filter(|lane| !lane.dots.is_empty()).collect();
    let mut environment = Environment::new();
    environment.set_auto_escape_callback(|_| AutoEscape::Html);
    environment.add_template("page", PAGE)?;
    let page = environment.get_template("page")?.render(context! {
        style => STYLE,
        version => env!("CARGO_PKG_VERSION"),
        command => command,
        count => outcomes.len(),
        failures => Value::from(Serde(&rows(&|outcome| !outcome.holds()))),
        lanes => Value::from(Serde(&lanes)),
        planes => Value::from(Serde(&planes(outcomes))),
        plots => Value::from(Serde(&plots)),
        groups => Value::from(Serde(&groups)),
    })?;
    Ok(page)
}

/// A heat map.
#[derive(Debug, Serialize)]
struct Plane<'a> {
    name: &'a str,
    columns: Vec<&'a str>,
    rows: Vec<Row<'a>>,
}

#[derive(Debug, Serialize)]
struct Row<'a> {
    name: &'a str,
    /// One a column, where there is a case.
    cells: Vec<Option<HeatCell>>,
}

#[derive(Debug, Serialize)]
struct HeatCell {
    strain: String,
    title: String,
    color: String,
    fails: bool,
}

/// Cells by plane, rows and columns in the order of the cases.
fn planes(outcomes: &[Outcome]) -> Vec<Plane<'_>> {
    let mut planes: Vec<Plane<'_>> = Vec::new();
    for outcome in outcomes {
        let Some(cell) = &outcome.cell else { continue };
        let plane = match planes.iter().position(|plane| plane.name == cell.plane) {
            Some(known) => &mut planes[known],
            None => {
                planes.push(Plane { name: &cell.plane, columns: Vec::new(), rows: Vec::new() });
                planes.last_mut().expect("just pushed")
            }
        };
        let column = position(&mut plane.columns, |known| *known == cell.column, || &cell.column);
        let new = || Row { name: &cell.row, cells: Vec::new() };
        let row = position(&mut plane.rows, |known| known.name == cell.row, new);
        let cells = &mut plane.rows[row].cells;
        cells.resize_with(cells.len().max(column + 1), || None);
        cells[column] = Some(HeatCell::new(outcome));
    }
    planes
}

/// Where in `all` the one is that is meant; it is added where it is new.
fn position<T>(all: &mut Vec<T>, is: impl Fn(&T) -> bool, new: impl FnOnce() -> T) -> usize {
    all.iter().position(is).unwrap_or_else(|| {
        all.push(new());
        all.len() - 1
    })
}

impl HeatCell {
    fn new(outcome: &Outcome) -> Self {
        let strain = outcome.strain();
        Self {
            strain: format!("{strain:.2}"),
            title: format!("{}: {}", outcome.name, outcome.worst_in_words()),
            color: color(FILLS, strain),
            fails: !outcome.holds(),
        }
    }
}

/// The colour of a strain: the first of a ramp at 0, the last at the bound.
fn color(ramp: [[f64; 3]; 3], strain: f64) -> String {
    let at = 2.0 * strain.clamp(0.0, 1.0);
    let below = (at as usize).min(1);
    let share = at - below as f64;
    let channel = |c: usize| ramp[below][c] + share * (ramp[below + 1][c] - ramp[below][c]);
    let [r, g, b] = [0, 1, 2].map(|c| channel(c).round() as u8);
    format!("#{r:02x}{g:02x}{b:02x}")
}

/// Where a strain lies on the axis, in percent of its length.
fn place(strain: f64) -> f64 {
    100.0 * strain.min(AXIS) / AXIS
}

/// The cases of a group on the axis of all.
#[derive(Debug, Serialize)]
struct Lane {
    title: &'static str,
    dots: Vec<Dot>,
}

#[derive(Debug, Serialize)]
struct Dot {
    /// Places in percent of the lane.
    left: String,
    top: String,
    title: String,
    color: String,
    fails: bool,
}

/// Cases as dots, spread over the height of the lane by the golden ratio, so that neighbours are
/// apart.
fn dots<'a>(outcomes: impl Iterator<Item = &'a Outcome>) -> Vec<Dot> {
    let dot = |(index, outcome): (usize, &Outcome)| {
        let strain = outcome.strain();
        Dot {
            left: format!("{:.2}", place(strain)),
            top: format!("{:.1}", 12.0 + 76.0 * (0.5 + index as f64 * 0.618_034).fract()),
            title: format!("{}: {strain:.3}", outcome.name),
            color: color(MARKS, strain),
            fails: !outcome.holds(),
        }
    };
    outcomes.enumerate().map(dot).collect()
}

/// The cases of a group.
#[derive(Debug, Serialize)]
struct GroupTable {
    title: &'static str,
    cases: Vec<CaseRow>,
}

#[derive(Debug, Serialize)]
struct CaseRow {
    name: String,
    source: &'static str,
    reason: &'static str,
    worst: String,
    strain: String,
    /// The length of its bar, in percent of the axis.
    width: String,
    color: String,
    fails: bool,
    again: String,
}

/// The cases for which `which` holds: failures first, then what is nearest to its bound.
fn rows_of(outcomes: &[Outcome], which: impl Fn(&Outcome) -> bool, command: &str) -> Vec<CaseRow> {
    let mut chosen: Vec<&Outcome> = outcomes.iter().filter(|outcome| which(outcome)).collect();
    chosen.sort_by(|a, b| b.strain().total_cmp(&a.strain()));
    let row = |outcome: &&Outcome| {
        let strain = outcome.strain();
        CaseRow {
            name: outcome.name.clone(),
            source: outcome.source,
            reason: outcome.reason,
            worst: outcome.worst_in_words(),
            strain: if strain.is_finite() { format!("{strain:.3}") } else { "∞".into() },
            width: format!("{:.2}", place(strain)),
            color: color(MARKS, strain),
            fails: !outcome.holds(),
            again: format!("{command} --case '{}'", outcome.name),
        }
    };
    chosen.iter().map(row).collect()
}

#[cfg(test)]
mod tests {
    use super::super::{Case, Check, Parts, run};
    use super::*;

    #[test]
    fn failures_come_first_and_lie_beyond_the_mark() {
        let words = ["nothing", "nothing"];
        let case = |name: &'static str, found: f64| {
            Case::new(Group::Matrix, name, words, move |_: &Parts| {
                Ok(vec![Check::at_most("number", found, 1.0)])
            })
        };
        let cases = [case("exact", 0.0), case("wrong", 7.0), case("near", 0.9)];
        let outcomes = run(&cases, &Parts::fogbow(), |_| ());
        let rows = rows_of(&outcomes, |_| true, "fogbow verify");
        let names: Vec<&str> = rows.iter().map(|row| row.name.as_str()).collect();
        assert_eq!(names, ["wrong", "near", "exact"]);
        assert_eq!((place(7.0), place(1.0), place(0.0)), (100.0, 80.0, 0.0));
        assert_eq!(color(MARKS, 0.0), "#00966e");
        assert_eq!(color(MARKS, f64::INFINITY), "#d55000");
        let html = page(&outcomes, "fogbow verify").unwrap();
        assert!(html.contains("1 failed of 3"), "{html}");
        assert_eq!(html.matches("<details class=\"case bad\" open>").count(), 2);
    }
}
