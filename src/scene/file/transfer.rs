//! Transfer functions: what the values of a grid stand for.

use crate::error::Result;
use crate::math::Rgb;
use crate::medium::Remap;
use crate::scene::keys::transfer as keys;
use crate::scene::reader::{Place, Range, Section, Value};

/// A transfer function of a medium, an albedo or an emission.
#[derive(Debug, Clone, PartialEq)]
pub struct TransferSection {
    /// Where it stands.
    pub at: Place,
    /// `from`, `clamp`, `gamma`.
    pub remap: Remap,
    /// `ramp`: places and values, those of scalars in all channels; none where the value is its
    /// place.
    pub stops: Vec<(f64, Rgb)>,
}

/// The most stops of a ramp.
const MAX_STOPS: usize = 4096;

/// The transfer function that stands in `section`; nothing where none of its keys does.
pub(super) fn read(section: &Section<'_>, values: Range) -> Result<Option<TransferSection>> {
    let keys = keys::TRANSFER.keys;
    let Some(first) = keys.iter().find_map(|key| section.get(key)) else { return Ok(None) };
    let [min, max] = section.pair(&keys::FROM)?;
    if min >= max {
        let from = section.require(&keys::FROM)?;
        return Err(from.wrong("two values, the smaller one first"));
    }
    Ok(Some(TransferSection {
        at: first.place(),
        remap: Remap {
            min,
            max,
            clamp: section.switch(&keys::CLAMP)?,
            gamma: section.number(&keys::GAMMA)?,
        },
        stops: section.maybe(&keys::RAMP, |v| stops(v, values))?.unwrap_or_default(),
    }))
}

/// The stops of a ramp, whose values lie in the range `values`.
fn stops(value: &Value<'_>, values: Range) -> Result<Vec<(f64, Rgb)>> {
    let right = keys::RAMP.kind.right();
    let list = value.list(MAX_STOPS, &right)?;
    if list.is_empty() {
        return Err(value.wrong(&right));
    }
    let mut stops: Vec<(f64, Rgb)> = Vec::with_capacity(list.len());
    for stop in &list {
        let right = "a stop [place, value]";
        let pair = stop.list(2, right)?;
        let [place, color] = &pair[..] else { return Err(stop.wrong(right)) };
        let at = place.number(Range::ANY)?;
        if let Some((last, _)) = stops.last().filter(|(last, _)| at < *last) {
            return Err(place.wrong(&format!("a place not below the one before, {last}")));
        }
        stops.push((at, color.color(values)?));
    }
    Ok(stops)
}

impl TransferSection {
    /// The stops with every value times `factor`; from 0 to `factor` where there is no ramp.
    pub fn times(&self, factor: Rgb) -> Vec<(f64, Rgb)> {
        if self.stops.is_empty() {
            return vec![(0.0, Rgb::ZERO), (1.0, factor)];
        }
        self.stops.iter().map(|(place, value)| (*place, *value * factor)).collect()
    }
}
