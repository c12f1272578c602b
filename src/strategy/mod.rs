//! Which estimator lights a medium.

mod choose;
mod gather_termination;
mod phase_blur;

pub use choose::{CachePlanner, eye, is_before, needs_beams};
pub use gather_termination::GatherTermination;
pub use phase_blur::{PhaseSplit, phases, scatterings};
