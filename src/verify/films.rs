//! Samples gathered on a film.

use super::case::{Case, Group};
use super::{Check, Parts};
use crate::error::Result;

pub(super) fn cases() -> Vec<Case> {
    let case = |name: &str, words, run: fn(&Parts) -> Result<Vec<Check>>| {
        Case::new(Group::ClosedForms, name, words, run)
    };
    vec![
        case(
            "film/mean-of-many",
            ["the mean of equal samples is the sample", "f64 rounding, over a million samples"],
            |parts| Ok([0.1, 1e-20, 3e30].map(|value| equal(parts, value)).to_vec()),
        ),
        case(
            "film/rare-bright-sample",
            [
                "one sample of 1e6 among a million of 0 is a mean of 1",
                "f64 rounding: nothing is clamped",
            ],
            |parts| {
                let mut samples = (0..1_000_000).map(|i| if i == 1000 { 1e6 } else { 0.0 });
                Ok(vec![Check::near("mean", (parts.mean)(&mut samples), 1.0, 1e-9)])
            },
        ),
    ]
}

fn equal(parts: &Parts, value: f64) -> Check {
    let found = (parts.mean)(&mut std::iter::repeat_n(value, 1_000_000));
    Check::near(format!("{value:e}: relative error"), found / value - 1.0, 0.0, 1e-9)
}
