//! Any text as a scene file: read, or one line.

#![no_main]

use std::path::Path;

use libfuzzer_sys::fuzz_target;

fuzz_target!(|text: &str| {
    if let Err(error) = fogbow::scene::file::parse(Path::new("fuzzed.toml"), text) {
        assert!(!error.to_string().contains('\n'));
    }
});
