//! The pages, plots and quoted figures that follow from the records of measurements.
//!
//! Nothing is measured here: the same records give the same files, so that words can change without
//! measuring anew.

pub mod bad_files;
pub mod convergence;
pub mod denoise;
pub mod director;
pub mod earlier;
pub mod equal_error;
pub mod equal_time;
pub mod farm;
mod farm_model;
mod farm_plot;
pub mod flicker;
mod markdown;
pub mod paper;
pub mod peers;
mod peers_plot;
pub mod plan;
mod published;
pub mod quoted;
pub mod rates;
pub mod ratio;
pub mod reconstruction;
pub mod record;
pub mod sampler;
pub mod scaling;
mod scaling_plot;
pub mod stated_error;
pub mod strategy;
pub mod threads;
pub mod verify;

use std::error::Error;
use std::fs;
use std::path::{Path, PathBuf};

use record::page;

/// What a page is made of, or why it cannot be made.
pub type Result<T> = std::result::Result<T, Box<dyn Error>>;

/// A measurement as its page presents it.
pub struct Page {
    /// The name of its files, and behind `--only`.
    pub name: &'static str,
    /// What it tells, in a line of the index.
    pub tells: &'static str,
    /// Its page from its record.
    write: fn(&str) -> Result<String>,
}

/// All of them, in the order of the index.
pub const PAGES: [Page; 19] = [
    Page {
        name: "director",
        tells: "what directed rendering saves, at what error, and what the director itself takes",
        write: |json| page(json, "What the director saves", director::tables),
    },
    Page {
        name: "equal-time",
        tells: "error against run time of uniform and directed rays, and what each part brings",
        write: |json| page(json, "Directors at equal time", equal_time::tables),
    },
    Page {
        name: "denoise",
        tells: "error with and without Open Image Denoise",
        write: |json| page(json, "What denoising changes", denoise::tables),
    },
    Page {
        name: "reconstruction",
        tells: "error of pictures of few rays: raw, reconstructed and denoised, with bias and cost",
        write: |json| page(json, "What reconstruction brings", reconstruction::tables),
    },
    Page {
        name: "earlier",
        tells: "noise, seconds and memory beside an earlier commit, scene by scene",
        write: |json| page(json, "Beside an earlier build", earlier::tables),
    },
    Page {
        name: "peers",
        tells: "time to the same error beside Cycles and Mitsuba",
        write: |json| page(json, "Beside Cycles and Mitsuba", peers::tables),
    },
    Page {
        name: "sampler",
        tells: "time of a trilinear sample beside OpenVDB and NanoVDB",
        write: |json| page(json, "Trilinear samples along rays", sampler::tables),
    },
    Page {
        name: "rates",
        tells: "photons and gathers a second, beside the crates that keep photons",
        write: |json| page(json, "Photons and gathers a second", rates::tables),
    },
    Page {
        name: "scaling",
        tells: "how cost grows with photons, pixels, rays, voxels and optical thickness",
        write: |json| page(json, "How cost grows", scaling::tables),
    },
    Page {
        name: "threads",
        tells: "two threads against one, stage by stage",
        write: |json| page(json, "Two threads against one", threads::tables),
    },
    Page {
        name: "farm",
        tells: "merged passes beside the whole, and how far many nodes help",
        write: |json| page(json, "Parts on a farm", farm::tables),
    },
    Page {
        name: "stated-error",
        tells: "what `--error` states against the true error, and how near the plan is",
        write: |json| page(json, "Stated against true errors", stated_error::tables),
    },
    Page {
        name: "plan",
        tells: "what leaving out saves, and how near the foretold memory is",
        write: |json| page(json, "What the plan saves", plan::tables),
    },
    Page {
        name: "bad-files",
        tells: "what becomes of damaged and hostile OpenVDB files",
        write: |json| page(json, "Bad files", bad_files::tables),
    },
    Page {
        name: "flicker",
        tells: "what noise adds to the flicker of a sequence",
        write: |json| page(json, "Flicker of a sequence", flicker::tables),
    },
    Page {
        name: "paper",
        tells: "fogbow's figures for its four scenes after Anson et al. 2006",
        write: |json| page(json, "The paper's four scenes", paper::tables),
    },
    Page {
        name: "convergence",
        tells: "how the error falls with time, and the bias that is left",
        write: |json| page(json, "How the error falls", convergence::tables),
    },
    Page {
        name: "strategy",
        tells: "what is chosen to light media, against the best that can be asked for",
        write: |json| page(json, "The choice of strategies", strategy::tables),
    },
    Page {
        name: "verify",
        tells: "how near the closed forms and extremes of `fogbow verify` come to their bounds",
        write: |json| page(json, "What is verified", verify::tables),
    },
];

/// Where records lie and their pages go.
pub struct Places {
    /// Records, pages and quoted figures.
    pub records: PathBuf,
    /// The plot of peers, and the page beside the paper.
    pub volumes: PathBuf,
}

impl Places {
    /// Those of the repository.
    pub fn checked_in() -> Self {
        let root = Path::new(env!("CARGO_MANIFEST_DIR"));
        Self { records: root.join("tests/bench/results"), volumes: root.join("volumes") }
    }

    /// The record of a measurement as text; nothing where there is none.
    ///
    /// # Errors
    /// Where it is there and cannot be read.
    pub fn record(&self, name: &str) -> Result<Option<String>> {
        let path = self.records.join(format!("{name}.json"));
        match fs::read_to_string(&path) {
            Ok(text) => Ok(Some(text)),
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => Ok(None),
            Err(error) => Err(format!("{}: {error}", path.display()).into()),
        }
    }

    /// Every file that follows from the records that are there, with its content.
    ///
    /// # Errors
    /// Where a record cannot be read or holds other fields than its page wants; names the file.
    pub fn rendered(&self) -> Result<Vec<(PathBuf, String)>> {
        let mut files = Vec::new();
        let mut there = Vec::new();
        for listed in &PAGES {
            let Some(json) = self.record(listed.name)? else { continue };
            let at = |e| format!("{}.json: {e}", self.records.join(listed.name).display());
            files.push((
                self.records.join(format!("{}.md", listed.name)),
                (listed.write)(&json).map_err(at)?,
            ));
            there.push((listed, record::about(&json).map_err(at)?));
        }
        files.push((self.records.join("README.md"), index(&there)));
        files.push((self.records.join("readme.json"), quoted::file(self)?));
        if let Some(json) = self.record("peers")? {
            let rows = record::rows(&json)?;
            files.push((self.volumes.join("peers.svg"), peers_plot::draw(&rows)));
        }
        if let Some(json) = self.record("scaling")?
            && let Some(plot) = scaling_plot::draw(&record::rows(&json)?)?
        {
            files.push((self.volumes.join("scaling.svg"), plot));
        }
        if let Some(json) = self.record("farm")?
            && let Some(plot) = farm_plot::draw(&record::rows(&json)?)?
        {
            files.push((self.volumes.join("farm.svg"), plot));
        }
        if let Some(json) = self.record("paper")? {
            files.push((self.volumes.join("PAPER.md"), published::beside(&json)?));
        }
        Ok(files)
    }
}

/// The list of measurements.
fn index(there: &[(&Page, record::About)]) -> String {
    let rows = there.iter().map(|(page, about)| {
        vec![
            format!("[{0}]({0}.md)", page.name),
            page.tells.to_owned(),
            about.date.clone(),
            format!("[{0}.json]({0}.json)", page.name),
        ]
    });
    let table = markdown::table(&["measurement", "tells", "of", "raw figures"], rows);
    format!(
        "# Results\n\
         Every figure that fogbow's pages quote is in this folder, with machine, date and command.\n\n\
         \x20   cargo bench --bench results                       # measures all, hours\n\
         \x20   cargo bench --bench results -- --only director    # one of them\n\
         \x20   cargo bench --bench results -- --quick            # tiny, to target/results/quick\n\
         \x20   cargo bench --bench results -- --render           # only pages, from what was measured\n\n\
         A run that was cut short goes on where it was; with `--fresh` it starts anew. `readme.json` \
         holds the figures that the README quotes.\n\n{table}"
    )
}
