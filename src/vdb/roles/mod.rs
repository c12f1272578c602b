//! Which grid of a file is what: density, fire, temperature, colour, velocity.
//!
//! Names decide first, by one table ([`NAMES`], below); [`Contents`] then looks at the values, since
//! programs also write empty flames and constant temperatures.
//!
#![doc = include_str!("../../guide/names.md")]

mod contents;
mod find;
mod fire;
mod names;
mod overlap;
mod triples;
mod up;

pub use contents::Contents;
pub use fire::{Fire, FireKind, Unit};
pub use names::{KnownName, NAMES, Role, role_of};
pub use triples::GridRef;
pub use up::Axis;
