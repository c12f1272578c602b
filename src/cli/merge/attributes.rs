//! The header of the merged picture.

use std::collections::BTreeMap;

use serde_json::{Map, Value, json};

use super::super::header::{OF_CAMERA, PREFIX, WORK};
use super::part::{PASSES, Part};
use super::pass::{OF_PASSES, PASS, Pass};
use crate::error::{Error, Result};
use crate::image::merge::PassWork;

/// The attributes that all parts agree in, without crop and recipe, the work of all parts, and where there are
/// several passes those.
///
/// # Errors
/// Where a counter is no number or the sum too large.
pub(super) fn merged(passes: &[Pass], weights: &[f64]) -> Result<BTreeMap<String, String>> {
    let parts = || passes.iter().flat_map(|pass| &pass.parts);
    let of_part = |name: &str| ["crop", "recipe"].contains(&name) || name.starts_with(WORK);
    let agree = |(name, value): &(&str, &str)| {
        !of_part(name) && parts().all(|part| part.attribute(name) == Some(value))
    };
    let kept = passes[0].first().attributes().filter(agree);
    let kept = kept.map(|(name, value)| (format!("{PREFIX}{name}"), value.to_owned()));
    let of_all = |name: &str| {
        let value = passes[0].first().standard(name)?;
        parts()
            .all(|part| part.standard(name) == Some(value))
            .then(|| (name.to_owned(), value.to_owned()))
    };
    let others = OF_CAMERA.into_iter().chain(passes[0].first().of_objects());
    let kept = kept.chain(others.filter_map(of_all));
    let work = work(passes)?.into_iter();
    let work = work.map(|(name, count)| (format!("{PREFIX}{WORK}{name}"), count.to_string()));
    let several = (passes.len() > 1)
        .then(|| (PASSES.into(), json!(self::passes(passes, weights)).to_string()));
    Ok(kept.chain(work).chain(several).collect())
}

/// Counters of work, summed over all parts.
///
/// # Errors
/// As [`merged`].
pub(super) fn work(passes: &[Pass]) -> Result<BTreeMap<String, u64>> {
    let mut work = BTreeMap::new();
    for part in passes.iter().flat_map(|pass| &pass.parts) {
        for (name, _) in part.attributes() {
            let Some(counter) = name.strip_prefix(WORK) else { continue };
            let sum: &mut u64 = work.entry(counter.to_owned()).or_default();
            *sum = sum.checked_add(part.count(name)?).ok_or_else(|| {
                Error::file(&part.path, format!("{PREFIX}{name} is too large to be summed"))
            })?;
        }
    }
    Ok(work)
}

/// The attributes in which passes may differ of each pass, its share of the mean, and the number of its parts. Rays and
/// photons of an equal pass are its own.
pub(super) fn passes(passes: &[Pass], weights: &[f64]) -> Vec<Value> {
    let total: f64 = weights.iter().sum();
    let entry = |(pass, weight): (&Pass, &f64)| {
        let first: &Part = pass.first();
        let mut entry = Map::new();
        for name in OF_PASSES {
            // Each is JSON in the header.
            let value = first.attribute(name).and_then(|text| serde_json::from_str(text).ok());
            entry.insert(name.into(), value.unwrap_or(Value::Null));
        }
        if let Some(of_picture) = first.pass {
            let PassWork { rays, photons } = pass.work();
            entry.insert(PASS.into(), json!(of_picture.to_string()));
            entry.insert("rays".into(), json!(rays));
            entry.insert("photons".into(), json!(photons));
        }
        entry.insert("weight".into(), json!(weight / total));
        entry.insert("parts".into(), json!(pass.parts.len()));
        Value::Object(entry)
    };
    passes.iter().zip(weights).map(entry).collect()
}
