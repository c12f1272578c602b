//! Which grid glows, and how its values are meant.
//!
//! Programs write fire's grids into plain smoke as well, empty, constant or as copies of the density,
//! so a name alone does not make fire:
//!
//! - A grid called `flame` and the like glows unless it is empty or constant over the smoke.
//! - `temperature` glows where it is in Kelvin or Celsius, reaches the Draper point (798 K, where
//!   solids begin to glow visibly) and is not constant; or where it is normalised and says more than
//!   the density does: over the smoke it varies by more than a tenth of its mean, a linear function
//!   of the density explains less than 0.7 of its variance, and no flame is there that is empty.
//!   Mantaflow's hot smoke carries a temperature that is blown about with the density and follows it,
//!   beside an empty flame; a lighting artist who is given that expects grey smoke.
//! - `fuel` is what may burn, and not what burns: it glows only in a file without any grid of fire or
//!   temperature.
//! - `emission` in a cache of Mantaflow marks the cells of sources, and never glows.

use crate::error::Result;
use crate::vdb::{Grid, ReadAs, VdbFile};

use super::names::{Role, role_of};
use super::overlap::{Overlap, Smoke};
use super::triples::GridRef;
use super::up::is_mantaflow;

/// Where solids begin to glow visibly (Draper 1847), in Kelvin.
const DRAPER_POINT: f64 = 798.0;
/// 0 degrees Celsius in Kelvin.
const CELSIUS: f64 = 273.15;
/// Temperatures whose largest value is below this are no Kelvin.
const LEAST_KELVIN: f64 = 200.0;
/// Temperatures with a value below minus this share of the largest magnitude are in Celsius; what is
/// nearer to 0 is ringing of an advection.
const RINGING: f64 = 0.05;
/// A grid is constant where it varies by no more than this share of its mean.
const CONSTANT: f64 = 0.01;
/// A normalised temperature varies where its deviation is more than this share of its mean.
const VARIES: f64 = 0.1;
/// A normalised temperature follows the density where that explains this share of its variance: 0.75
/// to 0.80 in the shared cache of Mantaflow's hot smoke, 0.03 in the shipped fire.
const FOLLOWS: f64 = 0.7;

/// What glows.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Fire {
    /// The grid, a scalar.
    pub grid: GridRef,
    /// How its values are meant.
    pub kind: FireKind,
    /// Smallest and largest finite value of its active voxels.
    pub range: [f64; 2],
}

/// How the values of a glowing grid are meant.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum FireKind {
    /// Strength of the glow, without a unit.
    Intensity,
    /// Temperature, of which the glow follows as a blackbody's.
    Temperature(Unit),
}

/// Unit of a temperature.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Unit {
    /// No unit: the largest value is as hot as the fire gets.
    Normalised,
    /// Kelvin.
    Kelvin,
    /// Degrees Celsius.
    Celsius,
}

impl Unit {
    /// The unit of a temperature whose finite values have this range. What the file states, such as
    /// `K` or `Celsius`, wins; else negative values mean Celsius, and a largest value of 200 or more
    /// means Kelvin.
    pub fn infer(range: [f64; 2], stated: Option<&str>) -> Self {
        let stated = stated.map(|unit| unit.trim().trim_start_matches('°').to_lowercase());
        match stated.as_deref() {
            Some("k" | "kelvin" | "degk") => Self::Kelvin,
            Some("c" | "celsius" | "degc" | "centigrade") => Self::Celsius,
            _ if range[0] < -RINGING * range[1].abs() => Self::Celsius,
            _ if range[1] >= LEAST_KELVIN => Self::Kelvin,
            _ => Self::Normalised,
        }
    }
}

/// Why a grid that could glow does not.
type Dark = String;

/// What glows in `file`, whose smoke is known; a note for each grid that could and does not.
pub(super) fn find(file: &VdbFile, smoke: &Smoke, notes: &mut Vec<String>) -> Result<Option<Fire>> {
    let mantaflow = is_mantaflow(file.grids().iter().map(|grid| grid.name.as_str()));
    let mut candidates = candidates(file);
    let has_better = candidates.iter().any(|candidate| candidate.role != Role::Fuel);
    candidates.retain(|candidate| !has_better || candidate.role != Role::Fuel);
    let mut without_flame = false;
    for Candidate { index, role, .. } in candidates {
        let info = &file.grids()[index];
        let mut dark = |why: Dark| {
            let path = file.path().display();
            notes.push(format!("{path}: grid \"{}\" does not glow: it {why}", info.label()));
        };
        if mantaflow && info.name == "emission" {
            dark("marks the cells of sources".into());
            continue;
        }
        let grid = file.read_scalar(index, ReadAs::Raw)?;
        let range = [grid.statistics().min, grid.statistics().max];
        if range == [0.0; 2] || role != Role::Temperature && range[1] <= 0.0 {
            without_flame |= role == Role::Fire;
            dark("is empty".into());
            continue;
        }
        let kind = match role {
            Role::Temperature => {
                temperature(&grid, smoke, Unit::infer(range, None)).and_then(|kind| {
                    let is_vague = kind == FireKind::Temperature(Unit::Normalised);
                    if is_vague && without_flame {
                        return Err("is normalised, and the flame beside it is empty".into());
                    }
                    Ok(kind)
                })
            }
            _ => intensity(&grid, smoke),
        };
        match kind {
            Ok(kind) => return Ok(Some(Fire { grid: file.reference(index), kind, range })),
            Err(why) => dark(why),
        }
    }
    Ok(None)
}

/// A grid whose name says that it may glow.
struct Candidate {
    index: usize,
    role: Role,
    rank: usize,
}

/// The scalar grids of fire, temperature and fuel, the preferred ones first.
fn candidates(file: &VdbFile) -> Vec<Candidate> {
    let grids = file.grids().iter().enumerate();
    let mut found: Vec<_> = grids
        .filter(|(_, grid)| grid.is_scalar() && !grid.is_level_set())
        .filter_map(|(index, grid)| match role_of(&grid.name)? {
            (role @ (Role::Fire | Role::Temperature | Role::Fuel), rank) => {
                Some(Candidate { index, role, rank })
            }
            _ => None,
        })
        .collect();
    found.sort_by_key(|candidate| candidate.rank); // the table has them in this order
    found
}

fn intensity(grid: &Grid<f32>, smoke: &Smoke) -> Result<FireKind, Dark> {
    match smoke.overlap(grid) {
        // A mean of 0 is a flame outside of the smoke.
        Some(over) if over.mean > 0.0 && over.deviation <= CONSTANT * over.mean => {
            Err(constant(&over))
        }
        _ => Ok(FireKind::Intensity),
    }
}

fn temperature(grid: &Grid<f32>, smoke: &Smoke, unit: Unit) -> Result<FireKind, Dark> {
    let statistics = grid.statistics();
    let over = smoke.overlap(grid);
    if let Some(over) = over.filter(|over| over.deviation <= CONSTANT * over.mean.abs()) {
        return Err(constant(&over));
    }
    if statistics.max - statistics.min <= CONSTANT * statistics.max.abs() {
        return Err(format!("is constant, {:.4}", statistics.max));
    }
    let hottest = match unit {
        Unit::Kelvin => Some(statistics.max),
        Unit::Celsius => Some(statistics.max + CELSIUS),
        Unit::Normalised => None,
    };
    match (hottest, over) {
        (Some(kelvin), _) if kelvin < DRAPER_POINT => {
            Err(format!("is too cold, at most {kelvin:.0} K of the {DRAPER_POINT} K that glow"))
        }
        (Some(_), _) => Ok(FireKind::Temperature(unit)),
        (None, None) => Err("lies in no smoke".into()),
        (None, Some(over)) if over.deviation <= VARIES * over.mean.abs() => Err(format!(
            "hardly varies over the smoke, by {:.2} of its mean",
            over.deviation / over.mean.abs()
        )),
        (None, Some(over)) if over.explained >= FOLLOWS => Err(format!(
            "follows the density, which explains {:.3} of its variance",
            over.explained
        )),
        (None, Some(_)) => Ok(FireKind::Temperature(unit)),
    }
}

fn constant(over: &Overlap) -> Dark {
    format!("is constant over the smoke, {:.4}", over.mean)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_follow_from_statements_and_ranges() {
        for (range, stated, unit) in [
            ([0.0, 1.0], None, Unit::Normalised),
            ([-0.01, 1.3], None, Unit::Normalised),
            ([0.0, 199.0], None, Unit::Normalised),
            ([250.0, 2000.0], None, Unit::Kelvin),
            ([-20.0, 1200.0], None, Unit::Kelvin),
            ([-80.0, 1200.0], None, Unit::Celsius),
            ([-70.0, 25.0], None, Unit::Celsius),
            ([0.0, 1200.0], Some("Celsius"), Unit::Celsius),
            ([0.0, 1200.0], Some("°C"), Unit::Celsius),
            ([-80.0, 1200.0], Some("K"), Unit::Kelvin),
            ([0.0, 1.0], Some("furlong"), Unit::Normalised),
        ] {
            assert_eq!(Unit::infer(range, stated), unit, "{range:?} {stated:?}");
        }
    }
}
