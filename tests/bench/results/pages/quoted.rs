//! The figures that the README and the guide may quote, by their keys: marked in the text as
//! `<!-- figure director.lucy.gain -->2.3<!-- / -->`, which `tests/documents/results.rs` holds against these.

use std::collections::BTreeMap;

use super::{Places, Result, director, farm, peers, rates, record, sampler, threads};

/// Every figure by its key.
pub fn figures(places: &Places) -> Result<BTreeMap<String, String>> {
    let mut out = BTreeMap::new();
    if let Some(json) = places.record("director")? {
        out.extend(director::quoted(&record::rows(&json)?));
    }
    if let Some(json) = places.record("farm")? {
        out.extend(farm::quoted(&record::rows(&json)?));
    }
    if let Some(json) = places.record("peers")? {
        out.extend(peers::quoted(&record::rows(&json)?));
    }
    if let Some(json) = places.record("sampler")? {
        out.extend(sampler::quoted(&record::rows(&json)?));
    }
    if let Some(json) = places.record("rates")? {
        out.extend(rates::quoted(&record::rows(&json)?));
    }
    if let Some(json) = places.record("threads")? {
        out.extend(threads::quoted(&record::rows(&json)?));
    }
    Ok(out)
}

/// `readme.json`.
pub fn file(places: &Places) -> Result<String> {
    Ok(serde_json::to_string_pretty(&figures(places)?)? + "\n")
}
