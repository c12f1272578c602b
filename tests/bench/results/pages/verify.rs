//! How near each group of verified cases comes to its bounds.

use serde::{Deserialize, Serialize};

use super::markdown::{decimals, table, whole};

/// The cases of a group.
#[derive(Debug, Serialize, Deserialize)]
pub struct Row {
    /// What their names begin with.
    pub group: String,
    /// How many there are.
    pub cases: u64,
    /// How many failed.
    pub failed: u64,
    /// The largest share of its bounds that a number used: 0 is right, above 1 is a failure.
    pub strain: f64,
    /// The case with that number.
    pub case: String,
    /// That number with its bounds, in words.
    pub number: String,
}

/// The table.
pub fn tables(rows: &[Row]) -> String {
    let lines = rows.iter().map(|row| {
        vec![
            format!("`{}`", row.group),
            whole(row.cases as f64),
            whole(row.failed as f64),
            decimals(row.strain, 2),
            format!("`{}`, {}", row.case, row.number),
        ]
    });
    let sum = |count: fn(&Row) -> u64| rows.iter().map(count).sum::<u64>();
    format!(
        "{} cases, {} failed. *Strain* is the share of its bounds that the worst number of a group \
         uses: 0 is right, above 1 is a failure.\n\n{}",
        sum(|row| row.cases),
        sum(|row| row.failed),
        table(&["cases of", "number", "failed", "worst strain", "worst number"], lines)
    )
}
