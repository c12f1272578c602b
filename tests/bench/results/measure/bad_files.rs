//! What becomes of damaged files, by the test that renders them.

use super::Kept;
use super::child::cargo;
use crate::pages::Result;
use crate::pages::bad_files::Row;

/// One part.
pub fn measure(kept: &mut Kept<Row>, quick: bool) -> Result<()> {
    kept.part("all files", || {
        let test = ["test", "--release", "--test", "bad_vdb", "--"];
        cargo(&[&test[..], &["--ignored", "--nocapture", "table"]].concat(), quick)
    })
}
