//! Passes and crops on a farm: whether passes are worth the whole, and what a frame has in serial.
//!
//! For each of some seeds the whole is rendered, and eight passes are averaged, by photons that were shot anew and by
//! saved ones. Errors are taken against two halves of the wholes of all other seeds at once: the product of the
//! differences from both is in the mean the squared error alone, for their noise is independent. Seconds are
//! those that threads ran, which other programs on the machine hardly touch.
//!
//! What stays in serial is measured by itself at the size of a picture for a farm: what the clock would
//! tell without other programs. How far many nodes help is counted from that on the page.

mod costs;
mod equality;
mod merging;
mod parts;

use rayon::ThreadPoolBuilder;

use super::Kept;
use crate::pages::Result;
use crate::pages::farm::Row;

/// Scenes of `volumes/`.
const SCENES: [&str; 3] = ["smoke", "cloud", "road"];

/// A part for the passes of a scene, and one for what it takes.
pub fn measure(kept: &mut Kept<Row>, quick: bool) -> Result<()> {
    let pool = ThreadPoolBuilder::new().num_threads(2).build()?;
    let folder = tempfile::tempdir()?;
    for name in SCENES {
        kept.part(&format!("passes of {name}"), || {
            equality::measure(name, quick, &pool, folder.path())
        })?;
        kept.part(&format!("costs of {name}"), || {
            Ok(vec![Row::Costs(costs::measure(name, quick, &pool, folder.path())?)])
        })?;
    }
    Ok(())
}
