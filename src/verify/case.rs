//! Cases: what is checked, against what, and why so closely.

use std::time::Instant;

use serde::Serialize;

use super::{Check, Parts};
use crate::error::Result;

/// What a case belongs to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Group {
    /// Closed forms and published values.
    ClosedForms,
    /// The march from thin to stiff.
    StiffSweep,
    /// Extremes of scenes, combined.
    Matrix,
}

impl Group {
    /// All, in the order of the table.
    pub const ALL: [Self; 3] = [Self::ClosedForms, Self::StiffSweep, Self::Matrix];

    /// Its heading.
    pub const fn title(self) -> &'static str {
        match self {
            Self::ClosedForms => "Closed forms and published values",
            Self::StiffSweep => "Stiff sweep",
            Self::Matrix => "Stability matrix",
        }
    }
}

/// How much work a run of the cases is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Effort {
    /// Under a minute on two cores; bounds are wider where they allow for noise.
    Quick,
    /// Minutes.
    Full,
}

/// The cell of a plane of the stability matrix.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Cell {
    /// The plane's name.
    pub plane: String,
    /// What its row stands for.
    pub row: String,
    /// What its column stands for.
    pub column: String,
}

/// A line to be plotted.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Curve {
    /// What it shows.
    pub name: String,
    /// What its coordinates are.
    pub axes: [&'static str; 2],
    /// Points, both coordinates to be drawn by their logarithm.
    pub points: Vec<[f64; 2]>,
    /// What theory says, in the same coordinates.
    pub theory: Vec<[f64; 2]>,
    /// What that is.
    pub theory_name: &'static str,
}

/// What running a case brought.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Findings {
    /// Numbers and their bounds.
    pub checks: Vec<Check>,
    /// What can be plotted of it.
    pub curves: Vec<Curve>,
}

impl From<Vec<Check>> for Findings {
    fn from(checks: Vec<Check>) -> Self {
        Self { checks, curves: Vec::new() }
    }
}

type Run = Box<dyn Fn(&Parts) -> Result<Findings> + Send + Sync>;

/// Something that must hold, and how to find out.
pub struct Case {
    /// What it belongs to.
    pub group: Group,
    /// Its name, by which it can be run alone.
    pub name: String,
    /// Where the expected value comes from.
    pub source: &'static str,
    /// Why the bounds are as they are.
    pub reason: &'static str,
    /// Where it stands in the stability matrix.
    pub cell: Option<Cell>,
    run: Run,
}

impl Case {
    /// A case outside the matrix.
    pub fn new<F: Into<Findings>>(
        group: Group,
        name: impl Into<String>,
        [source, reason]: [&'static str; 2],
        run: impl Fn(&Parts) -> Result<F> + Send + Sync + 'static,
    ) -> Self {
        let run: Run = Box::new(move |parts| run(parts).map(Into::into));
        Self { group, name: name.into(), source, reason, cell: None, run }
    }

    /// The case as a cell of the matrix.
    pub fn at(self, plane: &str, row: String, column: String) -> Self {
        Self { cell: Some(Cell { plane: plane.into(), row, column }), ..self }
    }

    /// Runs it on the pieces of a renderer. An error is a finding: it fails the case.
    pub fn run(&self, parts: &Parts) -> Outcome {
        let start = Instant::now();
        let (findings, error) = match (self.run)(parts) {
            Ok(findings) => (findings, None),
            Err(error) => (Findings::default(), Some(error.to_string())),
        };
        Outcome {
            group: self.group,
            name: self.name.clone(),
            source: self.source,
            reason: self.reason,
            cell: self.cell.clone(),
            findings,
            error,
            seconds: start.elapsed().as_secs_f64(),
        }
    }
}

impl std::fmt::Debug for Case {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Case").field("name", &self.name).finish_non_exhaustive()
    }
}

/// How a case ended.
#[derive(Debug, Clone, Serialize)]
pub struct Outcome {
    /// As of the case.
    pub group: Group,
    /// As of the case.
    pub name: String,
    /// As of the case.
    pub source: &'static str,
    /// As of the case.
    pub reason: &'static str,
    /// As of the case.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cell: Option<Cell>,
    /// What was found.
    #[serde(flatten)]
    pub findings: Findings,
    /// Why it could not be run.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub error: Option<String>,
    /// How long it took.
    pub seconds: f64,
}

impl Outcome {
    /// Whether all bounds were kept.
    pub fn holds(&self) -> bool {
        self.error.is_none() && self.findings.checks.iter().all(Check::holds)
    }

    /// The check that comes nearest to its bounds or breaks them most.
    pub fn worst(&self) -> Option<&Check> {
        self.findings.checks.iter().max_by(|a, b| a.strain().total_cmp(&b.strain()))
    }

    /// The worst check in words, or why the case could not be run.
    pub fn worst_in_words(&self) -> String {
        match (&self.error, self.worst()) {
            (Some(error), _) => error.clone(),
            (None, Some(check)) => check.to_string(),
            (None, None) => "nothing checked".into(),
        }
    }

    /// The strain of the worst check; infinite where the case could not be run.
    pub fn strain(&self) -> f64 {
        if self.error.is_some() { f64::INFINITY } else { self.worst().map_or(0.0, Check::strain) }
    }
}
