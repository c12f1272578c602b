//! The command line from outside.

#[path = "../common/skip.rs"]
mod skip;

mod bad_files;
mod error;
mod help;
mod merge;
mod messages;
mod terminal;
