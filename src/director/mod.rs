//! The director: maps of importance over the picture, and the budget of each pixel.
//!
//! After Anson, Sundstedt, Gutierrez and Chalmers 2006, "Efficient Selective Rendering of
//! Participating Media": the X-map tells how much light survives the medium, the saliency map S what
//! catches the eye, and both together, XS, how many rays a pixel gets. Beyond the paper they also
//! set gather radius and march step, and X may be measured in a pilot that has scattered light.

mod budget;
mod cached_snapshot;
mod importance;
mod photon_demand;
mod resample;
mod saliency;
mod snapshot;
mod tolerance;
mod variance;

pub use budget::{PixelBudget, radius_level};
pub use cached_snapshot::CachedSnapshot;
pub use importance::{false_medium, scattering_x_map, x_map, xs_map};
pub use photon_demand::PhotonDemand;
pub use resample::resampled;
pub use saliency::Saliency;
pub use snapshot::Snapshot;
pub use tolerance::{MeasuredError, error_x_map, visible_differences};
pub use variance::variance_budgets;
