//! `fogbow verify`: closed forms, the stiff sweep and the stability matrix, as a table.

use std::fmt::Write as _;
use std::io::Write as _;
use std::path::PathBuf;
use std::sync::atomic::{AtomicUsize, Ordering};

use serde_json::json;

use super::console;
use crate::error::{Error, Result};
use crate::file;
use crate::verify::{self, Case, Effort, Group, Outcome, Parts, cases, page};

/// Hold fogbow's figures against closed forms, published values and extremes.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Fewer and smaller cases: under a minute on two cores.
    #[arg(long)]
    pub quick: bool,
    /// Run only the cases whose name begins so.
    #[arg(long, value_name = "NAME")]
    pub case: Option<String>,
    /// Print all numbers as one JSON object.
    #[arg(long)]
    pub json: bool,
    /// Write a page with heat maps of the matrix and plots of the sweeps.
    #[arg(long, value_name = "FILE")]
    pub html: Option<PathBuf>,
    /// Print nothing while cases run.
    #[arg(long)]
    pub quiet: bool,
}

/// Runs the cases and prints the table.
///
/// # Errors
/// Where no case has the name, the page cannot be written, or a case fails.
pub fn run(args: &Args) -> Result<()> {
    let effort = if args.quick { Effort::Quick } else { Effort::Full };
    let selected = select(cases(effort), args.case.as_deref())?;
    let parts = Parts::fogbow();
    let (ended, total) = (AtomicUsize::new(0), selected.len());
    let outcomes = verify::run(&selected, &parts, |outcome| {
        let number = ended.fetch_add(1, Ordering::Relaxed) + 1;
        if !args.quiet {
            let verdict = if outcome.holds() { "" } else { " FAILS" };
            let seconds = outcome.seconds;
            console::message(&format!("{number}/{total} {} {seconds:.1} s{verdict}", outcome.name));
        }
    });
    if let Some(path) = &args.html {
        let unmade = |e: &dyn std::fmt::Display| Error::file(path, format!("cannot be made: {e}"));
        let text = page(&outcomes, &command(args.quick, None)).map_err(|e| unmade(&e))?;
        file::write(path, |out| out.write_all(text.as_bytes()))?;
    }
    let failed = outcomes.iter().filter(|o| !o.holds()).count();
    if args.json {
        let report = json!({
            "version": env!("CARGO_PKG_VERSION"),
            "effort": effort,
            "cases": outcomes,
            "failed": failed,
        });
        console::result(&report.to_string());
    } else {
        console::result(table(&outcomes, args.quick).trim_end());
    }
    if failed > 0 {
        let count = outcomes.len();
        return Err(Error::Verify(format!("{failed} of {count} cases failed")));
    }
    Ok(())
}

fn select(mut cases: Vec<Case>, name: Option<&str>) -> Result<Vec<Case>> {
    let Some(name) = name else { return Ok(cases) };
    if let Some(exact) = cases.iter().position(|case| case.name == name) {
        return Ok(vec![cases.swap_remove(exact)]);
    }
    cases.retain(|case| case.name.starts_with(name));
    if cases.is_empty() {
        return Err(Error::Usage(format!(
            "--case {name}: no case has a name that begins so; leave --case out to see all"
        )));
    }
    Ok(cases)
}

/// The command that runs one case, or all.
fn command(quick: bool, case: Option<&str>) -> String {
    let quick = if quick { " --quick" } else { "" };
    let case = case.map_or(String::new(), |name| format!(" --case '{name}'"));
    format!("fogbow verify{quick}{case}")
}

fn table(outcomes: &[Outcome], quick: bool) -> String {
    let mut out = String::new();
    let width = outcomes.iter().map(|o| o.name.len()).max().unwrap_or(0);
    // Writing to a string cannot fail.
    for group in Group::ALL {
        let in_group: Vec<_> = outcomes.iter().filter(|o| o.group == group).collect();
        if in_group.is_empty() {
            continue;
        }
        let seconds: f64 = in_group.iter().map(|o| o.seconds).sum();
        let _ = writeln!(out, "{} ({} cases, {seconds:.1} s)", group.title(), in_group.len());
        for outcome in in_group {
            let verdict = if outcome.holds() { "holds" } else { "FAILS" };
            let strain = outcome.strain();
            let _ = writeln!(
                out,
                "  {verdict} {strain:7.3}  {:width$}  {}",
                outcome.name,
                outcome.worst_in_words()
            );
            if !outcome.holds() {
                let again = command(quick, Some(&outcome.name));
                let _ = writeln!(out, "         again: {again}");
            }
        }
        out.push('\n');
    }
    let failed = outcomes.iter().filter(|o| !o.holds()).count();
    let seconds: f64 = outcomes.iter().map(|o| o.seconds).sum();
    let _ = writeln!(out, "{} cases, {failed} failed, {seconds:.1} s", outcomes.len());
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::verify::Check;

    #[test]
    fn a_failed_case_is_listed_with_its_command() {
        let words = ["nothing", "nothing"];
        let wrong = |_: &Parts| Ok(vec![Check::at_most("number", 2.0, 1.0)]);
        let cases = [Case::new(Group::Matrix, "matrix/wrong", words, wrong)];
        let text = table(&verify::run(&cases, &Parts::fogbow(), |_| ()), true);
        assert!(text.contains("FAILS   2.000  matrix/wrong  number: 2.0"), "{text}");
        assert!(text.contains("again: fogbow verify --quick --case 'matrix/wrong'"), "{text}");
        assert!(text.contains("1 cases, 1 failed"), "{text}");
    }
}
