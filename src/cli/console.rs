//! The only place that prints.

use std::io::Write;

/// Prints a result and a line end to stdout. A reader that has gone away is no failure.
pub(super) fn result(text: &str) {
    let _ = writeln!(std::io::stdout(), "{text}");
}

/// Prints each warning as one line to stderr.
pub(super) fn warn(warnings: &[String]) {
    warnings.iter().for_each(|warning| message(&format!("warning: {warning}")));
}

/// Prints a message as one line to stderr.
pub(super) fn message(text: &str) {
    let line = text.split('\n').map(str::trim).collect::<Vec<_>>().join(" ");
    let _ = writeln!(std::io::stderr(), "{line}");
}
