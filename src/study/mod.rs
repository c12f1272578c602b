//! What a shortcut costs in error and saves in time, against a fixed gold standard.
//!
//! A [`Study`] renders a scene at full quality, its *gold standard*, and with every [`Candidate`],
//! at several budgets and with several seeds. Runs take turns, so that a machine that drifts
//! hurts all alike, and each is on disk before the next begins. Then every picture is compared
//! with a [`Target`] and the questions are answered: how much faster, how much worse, and what
//! would uniform sampling have given for the same time or the same error.
//!
//! ```
//! use fogbow::render::Silent;
//! use fogbow::scene::{LoadOptions, Scene};
//! use fogbow::study::{Request, Study, write_report};
//!
//! # fn main() -> fogbow::Result<()> {
//! # let folder = tempfile::tempdir().expect("a folder for the example");
//! # let (path, out) = (folder.path().join("fog.toml"), folder.path().join("study"));
//! # std::fs::write(&path, SCENE).expect("the scene can be written");
//! let scene = Scene::load(&path, &LoadOptions::default())?;
//! let request = Request {
//!     candidates: vec!["fixed".into(), "x-transmittance".into()],
//!     budgets: vec![8, 4, 2],
//!     seeds: 2,
//!     ..Request::default()
//! };
//! let results = Study::new(&scene, &out, &request, false)?.run("an example", &Silent)?;
//! write_report(&results, &out)?;
//! for point in &results.points {
//!     let seconds = point.seconds.estimate;
//!     println!("{} with {}: {seconds:.3} s", point.candidate, point.label);
//! }
//! println!("{}", results.verdict.join("\n"));
//! # assert!(out.join("report.html").is_file());
//! # Ok(())
//! # }
//! # const SCENE: &str = "
//! # film = { size = [12, 12] }
//! # render = { rays = 8, photons = 200 }
//! # camera = { position = [0, 0, 4], target = [0, 0, 0] }
//! # [[medium]]
//! # region = { sphere = { center = [0, 0, 0], radius = 1 } }
//! # sigma_t = 1
//! # albedo = 0.5
//! # [[light]]
//! # type = \"point\"
//! # position = [0, 3, 0]
//! # intensity = [9, 9, 9]
//! # ";
//! ```

mod ablation;
mod analysis;
pub mod axis;
mod candidate;
mod contrast;
mod convergence;
mod curve;
mod deadline;
mod figure;
pub mod forced_choice;
mod gain;
mod headline;
mod html;
mod job;
mod machine;
mod measured;
pub mod metric;
mod plan;
mod report;
mod request;
mod results;
mod runner;
mod split;
mod statistics;
mod store;
mod target;
mod verdict;

pub use ablation::Effect;
pub use candidate::{CANDIDATES, Candidate, Point, Settings};
pub use contrast::{EQUAL, MOST_SEEDS, Outcome, seeds_to_settle};
pub use convergence::{Convergence, Estimator};
pub use curve::{Crossing, Curve};
pub use figure::significant;
pub use headline::{Contrast, Headline, SeedsToSettle};
pub use job::Run;
pub use machine::Machine;
pub use measured::{CurveResult, Estimate, Measured, PointResult, RunResult};
pub use plan::Plan;
pub use report::write_report;
pub use request::{Metric, Request};
pub use results::{Results, SCHEMA};
pub use runner::Study;
pub use split::ErrorSplit;
pub use statistics::{CONFIDENCE, Interval, slope};
pub use store::RUNS;
pub use target::Target;
