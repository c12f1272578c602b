//! Renders: scene and settings become a picture.
//!
//! [`render()`] runs the stages of a session one after another, each from the products of those
//! before:
//!
//! | stage | file | product |
//! | --- | --- | --- |
//! | pilot, director | `pilot`, `director_pass` | maps, and a budget for every pixel |
//! | photons | `photon_pass` | strategy, photon maps and caches |
//! | rays | `exposure`, `pixel_sampling`, `integrator`, `features` | samples on a tiled film |
//! | film | [`TiledFilm::resolve`](crate::film::TiledFilm::resolve), `reconstruction` | layers of the picture |
//!
//! Budgets and estimators meet only here: the rooms below are given plain numbers.
//! [`render_reference`] renders the same scene without bias onto the same film.
//!
//! Around the stages stand `control` (stop, pause, deadline), `clock`, `progress`, `checkpoint` with
//! its file format, `cost_model` for the time that is left, and `costs`, `memory` and `photon_rate` for
//! estimates before a render.

mod cell_file;
mod checkpoint;
mod checkpoint_file;
mod clock;
mod control;
mod cost_model;
mod costs;
mod deep;
mod director_pass;
mod error_pilot;
mod error_session;
mod exposure;
mod features;
mod integrator;
mod memory;
mod object_coverage;
mod opacity_depths;
mod pass_settings;
mod photon_file;
mod photon_pass;
mod photon_rate;
mod photon_stage;
mod pilot;
mod pixel_sampling;
mod planned_pass;
mod progress;
mod ray_sample;
mod reconstructed_passes;
mod reconstruction;
mod rendered;
mod rounds;
mod save_photons;
mod seen_cells;
mod session;
mod stage_settings;
mod state_file;
mod stated_error;
mod strategy_pilot;
mod variance_pilot;
mod without_photons;

pub use checkpoint::Checkpoints;
pub use clock::{Clock, Deadline};
pub use control::{Control, PREVIEW_RATIO, PictureSoFar, Preview, Stop};
pub use costs::{Costs, StageSeconds, costs, memory_needed};
pub use director_pass::{DirectorMaps, Earlier, Extent, maps};
pub use memory::{Memory, MemoryParts, memory_without_photons};
pub use pass_settings::PassSettings;
pub use photon_file::{SavedPhotons, photons_key};
pub use photon_pass::PhotonPass;
pub use photon_rate::photons_within;
pub use pilot::{exposure, metered};
pub use progress::{Progress, Silent, Stages};
pub use rendered::{DirectorWork, Ended, ReachedError, Rendered};
pub use save_photons::{PhotonsReport, save_photons};
pub use session::{render, render_next, shot_strategies};
pub use stated_error::StatedError;
pub use without_photons::{preview, render_reference};
