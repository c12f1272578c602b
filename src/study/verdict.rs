//! The findings of a study in two sentences.

use super::candidate::GOLD;
use super::figure::significant;
use super::request::Metric;
use super::results::{Answer, PointResult, Results};
use super::statistics::Interval;

/// Two sentences: what the best candidate saves and costs beside gold, and what it gains over
/// uniform sampling of the same error.
pub(super) fn verdict(results: &Results) -> Vec<String> {
    let target = results.target();
    let rivals: Vec<(&PointResult, &Interval)> = results
        .points
        .iter()
        .filter_map(|point| match &point.gain_at_equal_error {
            Answer::Found(gain) => Some((point, gain)),
            Answer::None(_) => None,
        })
        .collect();
    let surely = |gain: &Interval| gain.range.map_or(gain.estimate, |[low, _]| low);
    let best = rivals.iter().max_by(|a, b| surely(a.1).total_cmp(&surely(b.1)));
    let Some((point, gain)) = best else {
        return vec!["No verdict can be given.".into(), nothing(results)];
    };
    let metric = results.metric();
    let error = point.errors.get(&target.name).map_or(0.0, |m| m.error.estimate);
    let gold = results.points.iter().find(|p| p.candidate == GOLD);
    let gold_seconds = gold.map_or(f64::NAN, |p| p.seconds.median);
    let speed_up = point.speed_up.as_ref().map_or_else(|| "?".into(), interval);
    let seen =
        point.trials.iter().filter_map(|t| Metric::VdpVisible.of(t.errors.get(&target.name)?));
    let seen = Interval::of(&seen.collect::<Vec<_>>()).map_or(0.0, |seen| seen.estimate);
    let first = format!(
        "Best of {} at equal error: {} with {} takes {} s where the gold standard takes {} s, \
         {speed_up} times faster, at a {} of {} against the {}, with a visible difference (VDP, \
         P > 0.75) in {} % of the pixels.",
        rivals.len(),
        point.candidate,
        point.label,
        figure(point.seconds.median),
        figure(gold_seconds),
        metric.title(),
        figure(error),
        target.name,
        figure(seen),
    );
    let second = match gain.range {
        Some([low, _]) if low > 1.0 => {
            format!("Uniform sampling needs {} times as long for the same error.", interval(gain))
        }
        Some([_, high]) if high < 1.0 => format!(
            "Yet uniform sampling is quicker for the same error: it needs {} times as long.",
            interval(gain)
        ),
        _ => format!(
            "Whether uniform sampling is slower for the same error is open: it needs {} times as \
             long.",
            interval(gain)
        ),
    };
    vec![first, second]
}

/// Why there is no verdict.
fn nothing(results: &Results) -> String {
    let target = results.target();
    let trusted = |p: &PointResult| p.errors.get(&target.name).is_some_and(|m| m.trusted);
    if results.points.iter().any(trusted) {
        "No candidate has an error that uniform sampling was measured at: give more budgets.".into()
    } else {
        format!(
            "The own error of the {} is over a third of every error measured: give it more {}.",
            target.name,
            if target.name == GOLD { "seeds" } else { "rays" }
        )
    }
}

/// An estimate with its interval.
pub(super) fn interval(interval: &Interval) -> String {
    let estimate = figure(interval.estimate);
    interval.range.map_or_else(
        || estimate.clone(),
        |[low, high]| format!("{estimate} ({} to {})", figure(low), figure(high)),
    )
}

/// Three significant digits.
pub(super) fn figure(value: f64) -> String {
    significant(value, 3)
}
