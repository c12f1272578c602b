//! Which estimator lights a medium, and why.
//!
//! [`choose()`] decides once, before photons are shot; integrator, plan, reports and study read its
//! [`Choice`]. It measures nothing itself: what the camera sees and how long photons fly comes from
//! pilots.

mod cell_width;
mod choose;
mod gather_termination;
mod kind;
mod phase_blur;

pub use cell_width::{thin_width, thin_width_for_moments, width_for_flights};
pub use choose::{CacheCells, Choice, choose, direct_cells};
pub use gather_termination::GatherTermination;
pub use kind::{Conditions, MediumStrategy, Strategy, Summary};
pub use phase_blur::{PhaseSplit, phases, scatterings};
