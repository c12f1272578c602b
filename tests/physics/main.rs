//! Pictures and what they are made of against closed forms, brute force and the reference.

#[path = "../common/vdb.rs"]
mod common;
#[path = "../common/skip.rs"]
mod skip;

mod background;
mod clip;
mod closed_forms;
mod coats;
mod compositing;
mod edges;
mod extremes;
mod features;
mod fly_in;
mod furnaces;
mod gather;
mod lamps;
mod lattice;
mod motion;
mod photons;
mod pictures;
mod reference;
