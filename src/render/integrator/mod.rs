//! Estimators of the radiance along a camera ray.
//!
//! A ray reads from [`camera_path`] (media, mirrors, first diffuse surface) through [`in_scattering`]
//! (what media scatter along a ray) to the estimators that this sums: [`direct_in_media`],
//! [`radiance_cache`], [`final_gather`] with [`sent_path`] and [`emission_nee`], [`photon_gather`] and
//! [`forward_peak`].
//! [`reference`](mod@reference), with the light that [`reference_lights`] samples, is an integrator of its own.

mod camera_path;
mod direct_in_media;
mod emission_nee;
mod final_gather;
mod forward_peak;
mod gather_lights;
mod in_scattering;
mod light_lobes;
mod pending;
mod photon_gather;
mod radiance_cache;
mod ray_estimators;
mod reference;
mod reference_lights;
mod sent_path;
mod setup;

pub(super) use reference_lights::PathTracer;
pub(super) use setup::Integrator;
