//! Any bytes as a picture: EXR, PNG or JPEG.

#![no_main]

use std::path::Path;

use fogbow::image::{EXR_DECODER, decode_texture};
use libfuzzer_sys::fuzz_target;

fuzz_target!(
    init: {
        // The exr crate panics on some files, in a thread of its own, and fogbow reports an error.
        std::panic::set_hook(Box::new(|info| {
            if std::thread::current().name() != Some(EXR_DECODER) {
                eprintln!("{info}");
                std::process::abort();
            }
        }));
    },
    |data: &[u8]| {
        drop(decode_texture(data, Path::new("fuzzed.exr")));
    }
);
