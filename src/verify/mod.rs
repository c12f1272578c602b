//! Whether the renderer can be believed: closed forms, a stiff sweep and a matrix of extremes.
//!
//! Each [`Case`] holds numbers of the renderer against bounds that come from elsewhere: a closed
//! form, a published value, an independent method, or a conservation law. Cases are run on
//! [`Parts`], the pieces of the renderer, so that faults can be planted to show that they are found.
//!
//! The [guide](crate::guide::verification) tells what is held against what.

mod adding_doubling;
mod case;
mod check;
mod fields;
mod films;
mod known;
mod lines;
mod matrix;
mod page;
mod parts;
mod pictures;
mod scenes;
mod stiff;
mod values;

use rayon::prelude::*;

pub use adding_doubling::{SEEN_FROM, SlabLight, slab};
pub use case::{Case, Cell, Curve, Effort, Findings, Group, Outcome};
pub use check::Check;
pub use page::page;
pub use parts::{Export, FreeFlight, March, Marched, Mean, Parts, PhaseValue, Render};

/// Runs `cases` on `parts`, several at a time; `done` is told of each as it ends. Outcomes are in
/// the order of the cases.
pub fn run(cases: &[Case], parts: &Parts, done: impl Fn(&Outcome) + Sync) -> Vec<Outcome> {
    let run = |case: &Case| {
        let outcome = case.run(parts);
        done(&outcome);
        outcome
    };
    cases.par_iter().map(run).collect()
}

/// All cases of an effort, in the order of the table.
pub fn cases(effort: Effort) -> Vec<Case> {
    let mut cases = lines::cases();
    cases.extend(values::cases());
    cases.extend(films::cases());
    cases.extend(pictures::cases(effort));
    cases.extend(stiff::cases());
    cases.extend(matrix::cases(effort));
    cases
}
