//! Trilinear samples, by the bench that is built with its rivals.

use std::path::Path;

use super::child::cargo;
use super::{Kept, LeftOut};
use crate::pages::Result;
use crate::pages::sampler::Row;

/// What the rivals are built from.
const HEADER: &str = "/usr/include/nanovdb/NanoVDB.h";

/// One part.
pub fn measure(kept: &mut Kept<Row>, quick: bool) -> Result<()> {
    if !Path::new(HEADER).is_file() {
        let message = format!("{HEADER} is not there; apt-get install libnanovdb-dev");
        return Err(LeftOut(message).into());
    }
    kept.part("all samplers", || {
        let bench = ["bench", "--bench", "sampler", "--features", "bench-peers"];
        let profile: &[&str] = if quick { &["--profile", "dev"] } else { &[] };
        cargo(&[&bench[..], profile].concat(), quick)
    })
}
