//! `[director]`.

use super::super::directing::{
    Directed, Directing, Importance, MAX_COARSENING, Operator, RESOLUTIONS,
};
use super::super::reader::{Range, Section, Value};
use super::super::settings::MAX_RAYS;
use crate::error::Result;

const COARSENING: Range =
    Range::new(|x| (1.0..=MAX_COARSENING).contains(&x), "a factor from 1 to 256");

const RESOLUTION: Range =
    Range::new(|x| RESOLUTIONS.contains(&x), "a factor from 0.0625 (1/16) to 4");

/// Reads the table `[director]` of the document's `root`.
pub(super) fn read(root: &Section<'_>) -> Result<Directing> {
    let default = Directing::default();
    let Some(value) = root.get("director") else { return Ok(default) };
    let section = value.table("a table [director]")?;
    section.only(
        "[director]",
        &["x", "weights", "op", "directs", "floor", "radius", "step", "tolerance", "resolution"],
    )?;
    let floor = |v: Value<'_>| v.integer(1, u64::from(MAX_RAYS));
    Ok(Directing {
        x: section.or("x", default.x, |v| v.word(Importance::ALL))?,
        weights: section.or("weights", default.weights, |v| v.pair(Range::NOT_NEGATIVE))?,
        operator: section.or("op", default.operator, |v| v.word(Operator::ALL))?,
        directed: section.or("directs", default.directed, |v| {
            Directed::parse(v.string("words")?).map_err(|right| v.wrong(&right))
        })?,
        floor: section.or("floor", u64::from(default.floor), floor)? as u32,
        coarsest_radius: section.or("radius", default.coarsest_radius, |v| v.number(COARSENING))?,
        coarsest_step: section.or("step", default.coarsest_step, |v| v.number(COARSENING))?,
        tolerance: section.or("tolerance", default.tolerance, |v| v.number(Range::POSITIVE))?,
        resolution: section.or("resolution", default.resolution, |v| v.number(RESOLUTION))?,
    })
}
