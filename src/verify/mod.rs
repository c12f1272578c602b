//! Whether the renderer can be believed: closed forms, a stiff sweep and a matrix of extremes.
//!
//! Each [`Case`] holds numbers of the renderer against bounds that come from elsewhere: a closed
//! form, a published value, an independent method, or a conservation law. Cases are run on
//! [`Parts`], the pieces of the renderer, so that faults can be planted to show that they are found.

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

pub use adding_doubling::{SlabLight, slab};
pub use case::{Case, Cell, Curve, Effort, Findings, Group, Outcome};
pub use check::Check;
pub use page::page;
pub use parts::{Export, FreeFlight, March, Marched, Mean, Parts, PhaseValue, Render};

/// All cases of an effort, in the order of the table.
pub fn cases(effort: Effort) -> Vec<Case> {
    let mut cases = lines::cases();
    cases.extend(films::cases());
    cases.extend(pictures::cases(effort));
    cases.extend(stiff::cases());
    cases.extend(matrix::cases(effort));
    cases
}
