//! `[director]`.

use crate::error::Result;
use crate::scene::directing::{Directed, Directing, Importance, Operator};
use crate::scene::keys::director as keys;
use crate::scene::reader::Section;

/// Reads the table `[director]`.
pub(super) fn read(section: &Section<'_>) -> Result<Directing> {
    section.only(&keys::DIRECTOR)?;
    let x = section.word(&keys::X, Importance::ALL)?;
    let operator = section.maybe_word(&keys::OP, Operator::ALL)?.unwrap_or(x.default_operator());
    let directed = section.maybe(&keys::DIRECTS, |v| {
        Directed::parse(v.string("words")?).map_err(|right| v.wrong(&right))
    })?;
    Ok(Directing {
        x,
        weights: section.maybe_pair(&keys::WEIGHTS)?.unwrap_or(operator.default_weights()),
        operator,
        directed: directed.unwrap_or(x.default_directed()),
        floor: section.whole(&keys::FLOOR)? as u32,
        coarsest_radius: section.number(&keys::RADIUS)?,
        coarsest_step: section.number(&keys::STEP)?,
        tolerance: section.number(&keys::TOLERANCE)?,
        resolution: section.number(&keys::RESOLUTION)?,
    })
}
