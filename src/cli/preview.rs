//! Previews: pictures that are written and shown while they get better.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use serde_json::{Map, Value};

use super::console;
use super::header;
use super::live::Live;
use super::output::Output;
use super::partial;
use crate::render::{PictureSoFar, Rendered};
use crate::scene::Scene;

/// Previews of one picture: files, and what is shown live.
pub(super) struct Previews<'a> {
    scene: &'a Scene,
    /// The files of the finished picture.
    output: &'a Output,
    live: &'a Live,
    /// Time between two files; `None` where they are only written when asked for.
    every: Option<Duration>,
    settings: Map<String, Value>,
    /// When the next file is due.
    due: Mutex<Option<Instant>>,
    /// Whether one could not be written.
    has_failed: AtomicBool,
}

impl<'a> Previews<'a> {
    /// Those of `scene`, which goes to `output` in the end.
    pub(super) fn new(
        scene: &'a Scene,
        output: &'a Output,
        live: &'a Live,
        every: Option<Duration>,
        is_reference: bool,
    ) -> Self {
        let settings = header::settings(scene, None, is_reference, scene.render.photons);
        let (due, has_failed) = (Mutex::new(after(every)), AtomicBool::new(false));
        Self { scene, output, live, every, settings, due, has_failed }
    }

    /// Time between two moments at which a file may be written or a picture shown.
    pub(super) fn moments(&self) -> Option<Duration> {
        [self.every, self.live.every()].into_iter().flatten().min()
    }

    fn due(&self) -> MutexGuard<'_, Option<Instant>> {
        self.due.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Writes the picture so far where a file is due or `asked` for, and shows it where somebody looks. Where one cannot be
    /// written that is said once, and the render goes on.
    pub(super) fn show(&self, asked: bool, picture: PictureSoFar<'_>) {
        let is_due = asked || self.due().is_some_and(|due| Instant::now() >= due);
        let is_wanted = self.live.wants();
        if !is_due && !is_wanted {
            return;
        }
        let rendered = picture();
        if is_due {
            self.write(&rendered, header::attributes(self.scene, &self.settings, &rendered));
            *self.due() = after(self.every);
        }
        if is_wanted {
            self.live.show(&self.output.exr, rendered.film);
        }
    }

    fn write(&self, rendered: &Rendered, attributes: Vec<(String, String)>) {
        let film = &self.scene.film;
        let place = partial::place(self.output);
        let written = place.write(&film.shown(), rendered, film.half, &attributes);
        if let Err(error) = written
            && !self.has_failed.swap(true, Ordering::Relaxed)
        {
            console::warn(&[format!("no preview is written: {error}")]);
        }
    }
}

/// So long from here on.
fn after(time: Option<Duration>) -> Option<Instant> {
    Instant::now().checked_add(time?)
}
