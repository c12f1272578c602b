//! Progress on stderr: bars with remaining time on a terminal, plain lines elsewhere.

use std::io::IsTerminal;
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

use indicatif::{ProgressBar, ProgressStyle};

use super::console;
use crate::render::Progress;

/// How a stage is shown.
#[derive(Debug)]
enum Shown {
    Bar(ProgressBar),
    Line { name: String, start: Instant },
}

/// Shows the stages of a render on stderr.
#[derive(Debug)]
pub(super) struct Console {
    terminal: bool,
    stage: Mutex<Option<Shown>>,
}

impl Console {
    /// Bars where stderr is a terminal, otherwise lines.
    pub(super) fn new() -> Self {
        Self { terminal: std::io::stderr().is_terminal(), stage: Mutex::new(None) }
    }

    fn stage_now(&self) -> std::sync::MutexGuard<'_, Option<Shown>> {
        self.stage.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Progress for Console {
    fn stage(&self, name: &str, total: u64) {
        self.finish();
        let shown = if self.terminal {
            let style = ProgressStyle::with_template(
                "{msg:>10} [{bar:40}] {percent:>3} % {elapsed} + {eta}",
            );
            let bar = ProgressBar::new(total).with_message(name.to_owned());
            Shown::Bar(if let Ok(style) = style { bar.with_style(style) } else { bar })
        } else {
            Shown::Line { name: name.to_owned(), start: Instant::now() }
        };
        *self.stage_now() = Some(shown);
    }

    fn advance(&self, units: u64) {
        if let Some(Shown::Bar(bar)) = &*self.stage_now() {
            bar.inc(units);
        }
    }

    fn finish(&self) {
        match self.stage_now().take() {
            Some(Shown::Bar(bar)) => bar.finish(),
            Some(Shown::Line { name, start }) => {
                console::message(&format!("{name}: {:.2} s", start.elapsed().as_secs_f64()));
            }
            None => {}
        }
    }
}
