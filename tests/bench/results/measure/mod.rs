//! How every record is measured.

mod bad_files;
mod child;
mod convergence;
mod denoise;
mod director;
mod equal_time;
mod flicker;
mod kept;
mod paper;
mod peers;
mod plan;
mod rates;
mod sampler;
mod scaling;
mod scenes;
mod spent;
mod stages;
mod threads;
mod verify;

use std::fmt;
use std::path::Path;

use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::pages::Result;

pub use kept::{Kept, forget, partial};

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

/// All of them, the quickest first.
pub fn measurements() -> [Measurement; 14] {
    [
        Measurement { name: "plan", measure: |k, r, q| record(k, r, q, "plan", plan::measure) },
        Measurement { name: "rates", measure: |k, r, q| record(k, r, q, "rates", rates::measure) },
        Measurement {
            name: "sampler",
            measure: |k, r, q| record(k, r, q, "sampler", sampler::measure),
        },
        Measurement {
            name: "flicker",
            measure: |k, r, q| record(k, r, q, "flicker", flicker::measure),
        },
        Measurement {
            name: "bad-files",
            measure: |k, r, q| record(k, r, q, "bad-files", bad_files::measure),
        },
        Measurement {
            name: "director",
            measure: |k, r, q| record(k, r, q, "director", director::measure),
        },
        Measurement {
            name: "denoise",
            measure: |k, r, q| record(k, r, q, "denoise", denoise::measure),
        },
        Measurement {
            name: "verify",
            measure: |k, r, q| record(k, r, q, "verify", verify::measure),
        },
        Measurement {
            name: "threads",
            measure: |k, r, q| record(k, r, q, "threads", threads::measure),
        },
        Measurement {
            name: "equal-time",
            measure: |k, r, q| record(k, r, q, "equal-time", equal_time::measure),
        },
        Measurement {
            name: "convergence",
            measure: |k, r, q| record(k, r, q, "convergence", convergence::measure),
        },
        Measurement {
            name: "scaling",
            measure: |k, r, q| record(k, r, q, "scaling", scaling::measure),
        },
        Measurement { name: "paper", measure: |k, r, q| record(k, r, q, "paper", paper::measure) },
        Measurement { name: "peers", measure: |k, r, q| record(k, r, q, "peers", peers::measure) },
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
