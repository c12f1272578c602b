//! Which estimator lights a medium, and why.
//!
//! [`choose()`] makes the [`Choice`] that integrator, plan, reports and study read: what is asked for, what a
//! pilot measured (`render/strategy_pilot.rs`), or what a rule says. `measured` tells what of a pilot's error
//! is noise and what is bias, `unit_costs` what counted work costs.

mod cell_width;
mod choose;
mod gather_termination;
mod kind;
mod measured;
mod phase_blur;
mod possible;
mod rule;
mod unit_costs;

pub use crate::scene::{Strategy, StrategyRequest};
pub use cell_width::{
    direct_cells, thin_width, thin_width_for_moments, width_for_flights, width_for_photons,
};
pub use choose::{Choice, MediumCells, cell_width, choose, shared_footprint};
pub use gather_termination::GatherTermination;
pub use kind::{
    Assignment, Conditions, Evidence, MediumStrategy, Summary, away_from_camera, holds_moments,
};
pub use measured::{BLOCK, Errors, Measured, PhotonScale, RaySamples, errors, weights};
pub use phase_blur::{PhaseSplit, phases, scatterings};
pub use possible::{assignments, is_allowed};
pub use unit_costs::{cost, cost_of_crossings, cost_of_storing};
