//! The findings of a study in sentences, the answer first.

use super::contrast::{EQUAL, MOST_SEEDS, Outcome};
use super::figure::significant;
use super::headline::{Headline, SeedsToSettle};
use super::results::Results;
use super::statistics::Interval;

/// What the directed candidate saves beside gold, what uniform sampling would have made of the same
/// time, and, where that is open, what would settle it.
pub(super) fn verdict(results: &Results) -> Vec<String> {
    let Some(headline) = &results.headline else {
        return vec!["No candidate is directed: nothing is held against the gold standard.".into()];
    };
    let settling = headline.settling.map(|settling| how_to_settle(results, settling));
    [saved(results, headline), gained(results, headline)].into_iter().chain(settling).collect()
}

/// Run time beside gold, and the error that comes with it.
fn saved(results: &Results, headline: &Headline) -> String {
    let name = format!("{} with {}", headline.candidate, headline.label);
    let error = headline.error.as_ref().map_or_else(String::new, |error| {
        format!(", at an error of {} ({})", figure(error.estimate), results.metric().title())
    });
    let Some(ratio) = &headline.time_saved.ratio else {
        return format!("{name} was not timed beside the gold standard.");
    };
    let times = figure(ratio.estimate);
    let range = between(ratio);
    let equal = 100.0 * EQUAL;
    match headline.time_saved.outcome {
        Outcome::Above => {
            format!("{name} is {times} times as fast as the gold standard{range}{error}.")
        }
        Outcome::Below => {
            let longer = inverse(ratio);
            let (times, range) = (figure(longer.estimate), between(&longer));
            format!("{name} takes {times} times as long as the gold standard{range}{error}.")
        }
        Outcome::Equal => format!(
            "{name} takes as long as the gold standard, to within {equal} %: it is {times} times as \
             fast{range}{error}."
        ),
        Outcome::Open => format!(
            "{name} is {times} times as fast as the gold standard{range}{error}: still open."
        ),
    }
}

/// The error of uniform sampling in the same time.
fn gained(results: &Results, headline: &Headline) -> String {
    let Some(ratio) = &headline.error_gain.ratio else {
        return if results.points.iter().any(|point| point.candidate == super::gain::UNIFORM) {
            format!(
                "What uniform sampling makes of that time cannot be told: the own error of the {} \
                 is as large as the errors measured.",
                results.target().name
            )
        } else {
            "Uniform sampling was not measured: add fixed to the candidates.".into()
        };
    };
    let (times, range, equal) = (figure(ratio.estimate), between(ratio), 100.0 * EQUAL);
    match headline.error_gain.outcome {
        Outcome::Above => {
            format!("In that time uniform sampling makes an error {times} times as large{range}.")
        }
        Outcome::Below => format!(
            "In that time uniform sampling makes a smaller error, {times} times as large{range}."
        ),
        Outcome::Equal => format!(
            "In that time uniform sampling makes the same error, to within {equal} %: {times} times as \
             large{range}."
        ),
        Outcome::Open => format!(
            "In that time uniform sampling makes an error {times} times as large{range}: still open."
        ),
    }
}

/// What is left to do, as a command.
fn how_to_settle(results: &Results, settling: SeedsToSettle) -> String {
    let (Some(seeds), Some(seconds)) = (settling.seeds, settling.seconds) else {
        return format!("More than {MOST_SEEDS} seeds would be needed to settle what is open.");
    };
    let time = duration(seconds);
    let more = if results.request.seconds.is_some() {
        format!("--time {time}")
    } else {
        format!("--seeds {seeds}")
    };
    let command = resumed(&results.command, &more);
    format!("About {time} more would settle what is open: {command}")
}

/// `command` with `more` in place of its own time and seeds, going on with what there is.
fn resumed(command: &str, more: &str) -> String {
    let mut kept: Vec<&str> = Vec::new();
    let mut words = command.split(' ');
    while let Some(word) = words.next() {
        match word {
            "--time" | "--seeds" => {
                words.next();
            }
            "--resume" => {}
            _ if word.starts_with("--time=") || word.starts_with("--seeds=") => {}
            _ => kept.push(word),
        }
    }
    format!("{} {more} --resume", kept.join(" "))
}

/// Seconds as `--time` takes them, rounded up.
fn duration(seconds: f64) -> String {
    if seconds <= 90.0 {
        format!("{}s", (seconds / 5.0).ceil().max(1.0) * 5.0)
    } else if seconds <= 7200.0 {
        format!("{}m", (seconds / 60.0).ceil())
    } else {
        format!("{}h", (seconds / 3600.0).ceil())
    }
}

fn inverse(ratio: &Interval) -> Interval {
    let range = ratio.range.map(|[low, high]| [1.0 / high, 1.0 / low]);
    Interval { estimate: 1.0 / ratio.estimate, range, median: 1.0 / ratio.median, ..*ratio }
}

/// ", between 1.8 and 2.4"; that one seed gives no interval.
fn between(interval: &Interval) -> String {
    interval.range.map_or_else(
        || ", from a single seed".into(),
        |[low, high]| format!(", between {} and {}", figure(low), figure(high)),
    )
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_command_goes_on_for_more_time() {
        let told = resumed("fogbow study a.toml -o out --time 3m --json", "--time 12m");
        assert_eq!(told, "fogbow study a.toml -o out --json --time 12m --resume");
        let told = resumed("fogbow study a.toml --seeds=3 -o out --resume", "--seeds 9");
        assert_eq!(told, "fogbow study a.toml -o out --seeds 9 --resume");
    }

    #[test]
    fn durations_are_rounded_up() {
        assert_eq!([1.0, 61.0, 91.0, 7300.0].map(duration), ["5s", "65s", "2m", "3h"]);
    }
}
