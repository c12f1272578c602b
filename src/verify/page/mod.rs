//! The page of a run: the matrix as heat maps, the sweeps as plots, the cases as tables.

mod plot;

use minijinja::value::{Serde, Value};
use minijinja::{AutoEscape, Environment, context};
use serde::Serialize;

use super::case::{Group, Outcome};
use crate::image::viridis;

const PAGE: &str = include_str!("page.html");
const STYLE: &str = include_str!("page.css");

/// A page that needs nothing but itself. `command` is what made it, and with `--case NAME` makes
/// one case again.
///
/// # Errors
/// Where the page or a plot cannot be drawn up.
pub fn page(outcomes: &[Outcome], command: &str) -> Result<String, Box<dyn std::error::Error>> {
    let curves = || outcomes.iter().flat_map(|outcome| &outcome.findings.curves);
    let plots: Vec<plot::Plot> = curves().map(plot::plot).collect::<Result<_, _>>()?;
    let groups = Group::ALL.map(|group| group_of(outcomes, group, command));
    let groups: Vec<_> = groups.into_iter().filter(|group| !group.cases.is_empty()).collect();
    let mut environment = Environment::new();
    environment.set_auto_escape_callback(|_| AutoEscape::Html);
    environment.add_template("page", PAGE)?;
    let page = environment.get_template("page")?.render(context! {
        style => STYLE,
        version => env!("CARGO_PKG_VERSION"),
        command => command,
        count => outcomes.len(),
        failed => outcomes.iter().filter(|outcome| !outcome.holds()).count(),
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
    ink: &'static str,
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
        cells[column] = Some(HeatCell::of(outcome));
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
    fn of(outcome: &Outcome) -> Self {
        let strain = outcome.strain();
        // From light, in the middle of the bounds, to dark at their ends.
        let [r, g, b] = viridis(1.0 - strain.min(1.0));
        Self {
            strain: format!("{strain:.2}"),
            title: format!("{}: {}", outcome.name, outcome.worst_in_words()),
            color: format!("#{r:02x}{g:02x}{b:02x}"),
            ink: if strain > 0.5 { "#fff" } else { "#000" },
            fails: !outcome.holds(),
        }
    }
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
    fails: bool,
    again: String,
}

fn group_of(outcomes: &[Outcome], group: Group, command: &str) -> GroupTable {
    let row = |outcome: &Outcome| CaseRow {
        name: outcome.name.clone(),
        source: outcome.source,
        reason: outcome.reason,
        worst: outcome.worst_in_words(),
        strain: format!("{:.3}", outcome.strain()),
        fails: !outcome.holds(),
        again: format!("{command} --case '{}'", outcome.name),
    };
    let cases = outcomes.iter().filter(|outcome| outcome.group == group).map(row).collect();
    GroupTable { title: group.title(), cases }
}
