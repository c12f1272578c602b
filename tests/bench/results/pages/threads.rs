//! Two threads against one.

use serde::{Deserialize, Serialize};

use super::markdown::{decimals, range, table};

/// A stage of a scene's render.
#[derive(Debug, Serialize, Deserialize)]
pub struct Row {
    /// A scene of `volumes/`, or `all` for what holds of every one.
    pub scene: String,
    /// The stage.
    pub stage: String,
    /// Seconds on one thread and on two.
    pub seconds: Option<[f64; 2]>,
    /// The first over the second, the median of the rounds.
    pub faster: Option<f64>,
    /// The least and the largest of them.
    pub range: Option<[f64; 2]>,
    /// How much faster without other programs on the machine.
    pub unhindered: Option<f64>,
    /// How many of two threads were busy.
    pub busy: Option<f64>,
    /// The stage's serial part in % of the render.
    pub serial_percent: Option<f64>,
}

/// The table.
pub fn tables(rows: &[Row]) -> String {
    let lines = rows.iter().map(|row| {
        vec![
            row.scene.clone(),
            row.stage.clone(),
            decimals(row.seconds.map(|seconds| seconds[0]), 3),
            decimals(row.seconds.map(|seconds| seconds[1]), 3),
            decimals(row.faster, 2),
            range(row.range, 2),
            decimals(row.unhindered, 2),
            decimals(row.busy, 2),
            decimals(row.serial_percent, 1),
        ]
    });
    format!(
        "Medians of rounds in which one thread and two take turns. \"Unhindered\" is how much faster \
         two threads would be without other programs on the machine. A serial part s of a stage \
         leaves 2 / (1 + s) threads busy (Amdahl 1967). Two renders side by side, on a thread each, \
         tell what the machine itself does at once.\n\n{}",
        table(
            &[
                "scene",
                "stage",
                "1 thread, s",
                "2 threads, s",
                "faster",
                "range",
                "unhindered",
                "busy",
                "serial part of the render, %"
            ],
            lines
        )
    )
}

/// Times faster, scene by scene.
pub fn quoted(rows: &[Row]) -> Vec<(String, String)> {
    rows.iter()
        .filter(|row| row.stage == "the render")
        .filter_map(|row| Some((format!("threads.{}", row.scene), decimals(row.faster?, 2))))
        .collect()
}
