//! Flicker of a sequence, by the test that measures it.

use super::child::cargo_test;
use super::scenes::shared;
use super::{Kept, LeftOut};
use crate::pages::Result;
use crate::pages::flicker::Row;

/// One part.
pub fn measure(kept: &mut Kept<Row>, quick: bool) -> Result<()> {
    if shared("gas_sequence/fluid_data_0007.vdb").is_none() {
        return Err(LeftOut("the gas sequence is not in ../shared/volumes".into()).into());
    }
    kept.part("the gas sequence", || cargo_test("sequence", "flicker", quick))
}
