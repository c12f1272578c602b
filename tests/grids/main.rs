//! Grids: what they are taken for, sampled, shared and made.

#[path = "../common/vdb.rs"]
mod common;
#[path = "../common/skip.rs"]
mod skip;

mod instances;
mod make;
mod roles;
mod sampling;
mod sparse;
