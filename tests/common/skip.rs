//! Tests that cannot run on this machine: each says so, and is listed for the end of the run.

#![allow(clippy::print_stderr)]

use std::fmt::Display;
use std::fs::OpenOptions;
use std::io::Write;

/// Where skipped tests are listed, one a line: `skipped: PROGRAM::TEST: no WHAT`. Whoever runs the
/// suite removes it before and prints it after, since Cargo hides what passing tests print.
const LIST: &str = concat!(env!("CARGO_TARGET_TMPDIR"), "/skipped");

/// Says that the test that calls it is skipped, whole or in part, for there is no `missing`.
pub(crate) fn skip(missing: impl Display) {
    let thread = std::thread::current();
    let test = thread.name().unwrap_or("a thread of its own");
    let line = format!("skipped: {}::{test}: no {missing}\n", env!("CARGO_CRATE_NAME"));
    eprint!("{line}");
    let list = OpenOptions::new().create(true).append(true).open(LIST);
    list.and_then(|mut list| list.write_all(line.as_bytes())).expect("the list of skipped tests");
}
