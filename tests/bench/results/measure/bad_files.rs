//! What becomes of damaged files, by the test that renders them.

use super::Kept;
use super::child::cargo_test;
use crate::pages::Result;
use crate::pages::bad_files::Row;

/// One part.
pub fn measure(kept: &mut Kept<Row>, quick: bool) -> Result<()> {
    kept.part("all files", || cargo_test("bad_vdb", "table", quick))
}
