//! What leaving out saves.

use serde::{Deserialize, Serialize};

use super::markdown::{decimals, table};

/// What was found of one scene.
#[derive(Debug, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case")]
pub enum Row {
    /// A scene as planned and with everything on.
    Everything {
        /// The scene in words.
        scene: String,
        /// Run time with everything on over that as planned.
        times: f64,
    },
    /// What it costs a scene that more could be left out.
    Generality {
        /// The scene in words.
        scene: String,
        /// Share of its time, in %.
        percent: f64,
        /// Nanoseconds of each march.
        nanoseconds: f64,
    },
    /// The peak of memory foretold by the plan, against what a render took.
    Memory {
        /// The scenes in words.
        scene: String,
        /// How far the foretold peak was off, in %: from and to.
        off_percent: [f64; 2],
        /// The peak that was taken, in MiB.
        taken_mib: Option<f64>,
    },
}

/// The tables.
pub fn tables(rows: &[Row]) -> String {
    let everything = rows.iter().filter_map(|row| match row {
        Row::Everything { scene, times } => Some(vec![scene.clone(), decimals(*times, 2)]),
        _ => None,
    });
    let everything = table(&["scene", "time with everything on over time as planned"], everything);
    let generality = rows.iter().filter_map(|row| match row {
        Row::Generality { scene, percent, nanoseconds } => {
            Some(vec![scene.clone(), decimals(*percent, 1), decimals(*nanoseconds, 0)])
        }
        _ => None,
    });
    let generality = table(&["scene", "of its time, %", "ns a march"], generality);
    let memory = rows.iter().filter_map(|row| match row {
        Row::Memory { scene, off_percent: [from, to], taken_mib } => Some(vec![
            scene.clone(),
            if from == to { format!("{to:+.0}") } else { format!("{from:+.0} to {to:+.0}") },
            decimals(*taken_mib, 0),
        ]),
        _ => None,
    });
    let memory = table(&["scene", "foretold over taken, %", "taken, MiB"], memory);
    format!(
        "Each scene as planned and with `--plan everything`, in turn.\n\n{everything}\n\
         ## What it costs that other scenes need more\n\
         A march against code that knows of nothing but one region.\n\n{generality}\n\
         ## Memory, foretold and taken\n\
         The peak that `fogbow plan` foretells against the one that the render took.\n\n{memory}"
    )
}
