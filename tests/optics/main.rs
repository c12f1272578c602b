//! Media, phase functions, lights and materials: values, integrals and sampling.

#[path = "../common/chi2.rs"]
mod chi2;
#[path = "../common/vdb.rs"]
mod common;
#[path = "../common/lights.rs"]
mod lights;
#[path = "../common/skip.rs"]
mod skip;

mod environment;
mod fields;
mod light;
mod medium;
mod mie;
mod phase;
mod ramps;
mod surface;
