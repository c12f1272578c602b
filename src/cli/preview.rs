//! Previews: pictures that are written while they get better, and a first look without photons.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use serde_json::{Map, Value};

use super::console;
use super::header;
use super::output::Output;
use super::partial;
use crate::render::{self, Clock, Control, Deadline, Rendered};
use crate::scene::Scene;

/// Time of a first look: with writing it, what somebody who waits for a picture hardly notices.
const FIRST_LOOK: Duration = Duration::from_millis(500);

/// Writes previews of one picture.
pub(super) struct PreviewWriter<'a> {
    scene: &'a Scene,
    /// The files of the finished picture.
    output: &'a Output,
    settings: Map<String, Value>,
    /// Whether one could not be written.
    has_failed: AtomicBool,
}

impl<'a> PreviewWriter<'a> {
    /// Writes those of `scene`, which goes to `output` in the end.
    pub(super) fn new(scene: &'a Scene, output: &'a Output, is_reference: bool) -> Self {
        let settings = header::settings(scene, None, is_reference, scene.render.photons);
        Self { scene, output, settings, has_failed: AtomicBool::new(false) }
    }

    /// Writes the picture so far where that of an interrupted render would go. Where one cannot be written that is said
    /// once, and the render goes on.
    pub(super) fn write(&self, rendered: &Rendered) {
        self.write_with(rendered, header::attributes(&self.settings, rendered));
    }

    /// Writes a first look without photons, in a moment.
    pub(super) fn write_first_look(&self, clock: &Arc<Clock>) {
        let deadline = Deadline { clock, at: clock.elapsed() + FIRST_LOOK };
        let control = Control { deadline: Some(deadline), ..Control::silent() };
        let look = render::preview(self.scene, &self.scene.render, control);
        let mut named = header::attributes(&self.settings, &look);
        named.push((partial::PREVIEW.into(), "true".into()));
        self.write_with(&look, named);
    }

    fn write_with(&self, rendered: &Rendered, attributes: Vec<(String, String)>) {
        let written = partial::place(self.output).write(self.scene, rendered, &attributes);
        if let Err(error) = written
            && !self.has_failed.swap(true, Ordering::Relaxed)
        {
            console::warn(&[format!("no preview is written: {error}")]);
        }
    }
}
