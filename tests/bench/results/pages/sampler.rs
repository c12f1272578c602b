//! Time of a trilinear sample.

use serde::{Deserialize, Serialize};

use super::markdown::{decimals, table};

/// A way of sampling.
#[derive(Debug, Serialize, Deserialize)]
pub struct Row {
    /// Whose, and at which points.
    pub sampler: String,
    /// Time of all over that of fogbow's.
    pub times: f64,
    /// Nanoseconds of a sample.
    pub nanoseconds: Option<f64>,
}

/// The table.
pub fn tables(rows: &[Row]) -> String {
    let lines = rows
        .iter()
        .map(|row| vec![row.sampler.clone(), decimals(row.times, 1), decimals(row.nanoseconds, 1)]);
    format!(
        "Along random rays on one core. Rivals get the very points that fogbow evaluates; on whole \
         rays they evaluate every step, and fogbow skips empty blocks.\n\n{}",
        table(&["sampler", "time over fogbow's", "ns a sample"], lines)
    )
}

/// Every rival's time.
pub fn quoted(rows: &[Row]) -> Vec<(String, String)> {
    let keys = [("openvdb", "OpenVDB BoxSampler"), ("nanovdb", "NanoVDB, places f64")];
    keys.into_iter()
        .filter_map(|(key, sampler)| {
            let row = rows.iter().find(|row| row.sampler == sampler)?;
            Some((format!("sampler.{key}"), format!("{:.1}", row.times)))
        })
        .collect()
}
