//! How near the verified cases come to their bounds.

use std::collections::BTreeMap;

use fogbow::verify::{Effort, Outcome, Parts, cases, run};

use super::Kept;
use crate::pages::Result;
use crate::pages::verify::Row;

/// One part.
pub fn measure(kept: &mut Kept<Row>, quick: bool) -> Result<()> {
    let effort = if quick { Effort::Quick } else { Effort::Full };
    kept.part("all cases", || {
        let outcomes = run(&cases(effort), &Parts::fogbow(), |_| ());
        let mut groups: BTreeMap<String, Vec<&Outcome>> = BTreeMap::new();
        for outcome in &outcomes {
            groups.entry(group(&outcome.name)).or_default().push(outcome);
        }
        Ok(groups.into_iter().filter_map(|(group, cases)| row(group, &cases)).collect())
    })
}

/// What stands before the first stroke of a case's name, of the matrix's before the second.
fn group(case: &str) -> String {
    let words = if case.starts_with("matrix/") { 2 } else { 1 };
    case.split('/').take(words).collect::<Vec<_>>().join("/")
}

/// The row of a group; nothing where it has no case.
fn row(group: String, cases: &[&Outcome]) -> Option<Row> {
    let worst = cases.iter().max_by(|a, b| a.strain().total_cmp(&b.strain()))?;
    Some(Row {
        group,
        cases: cases.len() as u64,
        failed: cases.iter().filter(|outcome| !outcome.holds()).count() as u64,
        strain: worst.strain(),
        case: worst.name.clone(),
        number: worst.worst_in_words(),
    })
}
