//! Any bytes as a picture: EXR, HDR, TIFF, PNG or JPEG.

#![no_main]

use std::path::Path;

use fogbow::image::{PICTURE_DECODER, decode_texture};
use libfuzzer_sys::fuzz_target;

fuzz_target!(
    init: {
        // Decoders panic on some files, in a thread of their own, and fogbow reports an error.
        std::panic::set_hook(Box::new(|info| {
            if std::thread::current().name() != Some(PICTURE_DECODER) {
                eprintln!("{info}");
                std::process::abort();
            }
        }));
    },
    |data: &[u8]| {
        drop(decode_texture(data, Path::new("fuzzed.exr")));
    }
);
