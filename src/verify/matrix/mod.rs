//! The stability matrix: extremes of scenes, combined, each a small picture.
//!
//! A cell asks whether the picture is finite, lies within what energy allows, drops no sample, and
//! was made with a bounded amount of work. Digits are the business of the closed forms: most bounds
//! here are wide, for a cell is made of few photons.

mod judge;
mod lamps;
mod optics;
mod places;
mod sampling;
mod setup;
mod shapes;

use super::case::{Case, Effort};

/// All cells of an effort.
pub(super) fn cases(effort: Effort) -> Vec<Case> {
    let mut cases = optics::cases(effort);
    cases.extend(places::cases(effort));
    cases.extend(lamps::cases());
    cases.extend(shapes::cases(effort));
    cases.extend(sampling::cases(effort));
    cases
}
