//! How much is done in a second.

use serde::{Deserialize, Serialize};

use super::markdown::{NONE, decimals, table, whole};

/// A piece of work.
#[derive(Debug, Serialize, Deserialize)]
pub struct Row {
    /// Whose and which.
    pub work: String,
    /// What is counted.
    pub unit: String,
    /// How many a second on one thread.
    pub one_thread: Option<f64>,
    /// How many a second on all threads.
    pub all_threads: Option<f64>,
    /// For a crate's own work: how many times as fast fogbow is, on one thread and on all.
    pub fogbow_over_it: Option<f64>,
}

/// The table.
pub fn tables(rows: &[Row]) -> String {
    let rate = |value: Option<f64>| value.map_or_else(|| NONE.into(), whole);
    let lines = rows.iter().map(|row| {
        vec![
            row.work.clone(),
            row.unit.clone(),
            rate(row.one_thread),
            rate(row.all_threads),
            decimals(row.fogbow_over_it, 2),
        ]
    });
    format!(
        "Medians. A crate's own work looks at no photon; fogbow's does.\n\n{}",
        table(&["work", "unit", "one thread", "all threads", "fogbow over the crate"], lines)
    )
}

/// Paths a second, scene by scene.
pub fn quoted(rows: &[Row]) -> Vec<(String, String)> {
    let paths = rows.iter().filter(|row| row.unit == "paths/s");
    paths
        .filter_map(|row| {
            let scene = row.work.split(':').next()?;
            Some((format!("rates.{scene}.paths"), whole(row.one_thread?)))
        })
        .collect()
}
