//! How every record is measured.

mod bad_files;
mod child;
mod convergence;
mod denoise;
mod director;
mod earlier;
mod equal_time;
mod farm;
mod flicker;
mod halves;
mod kept;
mod paper;
mod peers;
mod plan;
mod rates;
mod reconstruction;
mod sampler;
mod scaling;
mod scene_text;
mod scenes;
mod spent;
mod stages;
mod stated_error;
mod strategy;
mod threads;
mod verify;

use std::fmt;
use std::path::Path;

use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::pages::Result;

pub use kept::{Kept, forget, partial};
pub use strategy::write_scenes;

/// A measurement, and how its record is made.
pub struct Measurement {
    /// As in [`PAGES`](crate::pages::PAGES).
    pub name: &'static str,
    /// Writes the record: where finished parts are kept, where it goes, and whether it is tiny.
    pub measure: fn(&Path, &Path, bool) -> Result<()>,
}

/// What a measurement wants is not on this machine.
#[derive(Debug)]
pub struct LeftOut(pub String);

impl fmt::Display for LeftOut {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for LeftOut {}

/// The measurements of these names, each made by `measure` of a module.
macro_rules! measured {
    ($($name:literal by $module:ident),* $(,)?) => {
        [$(Measurement {
            name: $name,
            measure: |kept, to, quick| record(kept, to, quick, $name, $module::measure),
        }),*]
    };
}

/// All of them, the quickest first.
pub fn measurements() -> [Measurement; 19] {
    measured![
        "plan" by plan,
        "rates" by rates,
        "sampler" by sampler,
        "flicker" by flicker,
        "bad-files" by bad_files,
        "director" by director,
        "denoise" by denoise,
        "verify" by verify,
        "threads" by threads,
        "farm" by farm,
        "stated-error" by stated_error,
        "equal-time" by equal_time,
        "strategy" by strategy,
        "convergence" by convergence,
        "reconstruction" by reconstruction,
        "earlier" by earlier,
        "scaling" by scaling,
        "paper" by paper,
        "peers" by peers,
    ]
}

/// Measures what is not kept, and writes the record.
fn record<R: Serialize + DeserializeOwned>(
    kept: &Path,
    record: &Path,
    quick: bool,
    name: &str,
    measure: fn(&mut Kept<R>, bool) -> Result<()>,
) -> Result<()> {
    let size = if quick { " --quick" } else { "" };
    let command = format!("`cargo bench --bench results -- --only {name}{size}`");
    let mut kept = Kept::open(kept, &command);
    if quick {
        kept.note("Tiny: these figures only show that the command works.");
    }
    measure(&mut kept, quick)?;
    let text = serde_json::to_string_pretty(&kept.record(name))? + "\n";
    std::fs::write(record, text).map_err(|e| format!("{}: {e}", record.display()).into())
}
