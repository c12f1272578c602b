//! Tables and figures as Markdown.

use fogbow::study::{Interval, significant};

/// What stands where there is no figure.
pub const NONE: &str = "–";

/// A table with this head.
pub fn table(head: &[impl AsRef<str>], rows: impl IntoIterator<Item = Vec<String>>) -> String {
    let line = |cells: &[&str]| format!("| {} |\n", cells.join(" | "));
    let head: Vec<&str> = head.iter().map(AsRef::as_ref).collect();
    let mut out = line(&head) + &format!("|{}\n", " --- |".repeat(head.len()));
    for row in rows {
        out += &line(&row.iter().map(String::as_str).collect::<Vec<_>>());
    }
    out
}

/// Significant digits of a figure, where there is one.
pub fn figure(value: impl Into<Option<f64>>, digits: usize) -> String {
    value.into().map_or_else(|| NONE.into(), |value| significant(value, digits))
}

/// A figure with these decimals, where there is one.
pub fn decimals(value: impl Into<Option<f64>>, decimals: usize) -> String {
    value.into().map_or_else(|| NONE.into(), |value| format!("{value:.decimals$}"))
}

/// A range in so many decimals.
pub fn range(range: Option<[f64; 2]>, decimals: usize) -> String {
    range
        .map_or_else(|| NONE.into(), |[low, high]| format!("{low:.decimals$} to {high:.decimals$}"))
}

/// An estimate in so many decimals, where there is one, with its interval in brackets.
pub fn interval<'a>(interval: impl Into<Option<&'a Interval>>, decimals: usize) -> String {
    let Some(Interval { estimate, range: ends, .. }) = interval.into() else { return NONE.into() };
    let estimate = self::decimals(*estimate, decimals);
    if ends.is_none() { estimate } else { format!("{estimate} ({})", range(*ends, decimals)) }
}

/// `value` with commas between thousands.
pub fn whole(value: f64) -> String {
    let digits = format!("{:.0}", value.abs());
    let sign = if value < 0.0 { "-" } else { "" };
    let mut out = String::new();
    for (index, digit) in digits.chars().enumerate() {
        if index > 0 && (digits.len() - index).is_multiple_of(3) {
            out.push(',');
        }
        out.push(digit);
    }
    sign.to_owned() + &out
}

/// An error: two significant digits, or four decimals where it is small.
pub fn error(value: f64) -> String {
    if value.abs() < 0.01 { format!("{value:.4}") } else { significant(value, 2) }
}
