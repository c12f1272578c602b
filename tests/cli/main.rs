//! The command line from outside.

#[path = "../common/skip.rs"]
mod skip;

mod aovs;
mod bad_files;
mod calls;
mod compositing;
mod cryptomatte;
mod deep;
mod error;
mod groups;
mod help;
mod merge;
mod messages;
mod motion;
mod parts;
mod passes;
mod retime;
mod saved_photons;
mod scattered;
mod shots;
mod terminal;
mod tev;
mod told_apart;
mod wind;

use std::path::Path;

use assert_cmd::Command;

/// Runs fogbow in `folder`: its exit code, and what it prints to stdout and stderr.
fn run(folder: &Path, args: &[&str]) -> (i32, String, String) {
    let mut command = Command::new(assert_cmd::cargo::cargo_bin!("fogbow"));
    let output = command.current_dir(folder).args(args).output().unwrap();
    let [out, err] = [output.stdout, output.stderr].map(|s| String::from_utf8(s).unwrap());
    assert!(!err.contains("panicked"), "{args:?}: {err}");
    (output.status.code().unwrap(), out, err)
}

/// Whether `program` can be run; says so where it cannot.
fn is_there(program: &str) -> bool {
    let there = std::process::Command::new(program).arg("--help").output().is_ok();
    if !there {
        skip::skip(program);
    }
    there
}

/// What a program prints that succeeds in `folder`.
fn printed(folder: &Path, program: &str, args: &[&str]) -> String {
    let output =
        std::process::Command::new(program).current_dir(folder).args(args).output().unwrap();
    assert!(output.status.success(), "{args:?}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8_lossy(&output.stdout).into_owned()
}
