//! Which estimator lights a medium, and why.
//!
//! [`choose()`] makes the [`Choice`] that integrator, plan, reports and study read, of what is asked for or
//! what a pilot measured (`render/strategy_pilot`). `measured` tells the variance of a picture from a
//! pilot's pixels, `trial` compares assignments by it, `unit_costs` says what counted work costs.

mod cell_width;
mod choose;
mod gather_termination;
mod kind;
mod measured;
mod phase_blur;
mod possible;
mod trial;
mod unit_costs;

pub use crate::scene::{Strategy, StrategyRequest};
pub use cell_width::{
    direct_cells, noise_of_kernels, places_at, shares_direct_cells, width_for_photons,
};
pub use choose::{Choice, MediumCells, cell_width, choose, shared_footprint};
pub use gather_termination::GatherTermination;
pub use kind::{
    Assignment, Conditions, Evidence, MediumStrategy, Summary, away_from_camera, shared, unshared,
};
pub use measured::{
    BLOCK, EDGE_POWER, Measured, PictureSize, PixelRays, PixelSamples, RayLuminance, Variance,
    VarianceScale, weights,
};
pub use phase_blur::{PhaseSplit, phases, scatterings};
pub use possible::{assignments, first_allowed, is_allowed};
pub use trial::{Observed, Trial, leave_out_outliers, trials};
pub use unit_costs::{cost, cost_of_crossings, cost_of_storing};
