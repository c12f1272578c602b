//! One picture: photons are fitted to the limits, the scene is rendered, the files are written.

use std::io::Write;
use std::sync::Arc;
use std::time::{Duration, Instant};

use rayon::ThreadPool;
use serde_json::{Map, Value, json};

use super::console;
use super::fit::{Fit, writing};
use super::header::{self, Method};
use super::interrupt::Interrupt;
use super::limit_args::{CheckpointInterval, LimitArgs, checkpoint_path};
use super::live::Live;
use super::load::Preparation;
use super::memory;
use super::output::Output;
use super::partial;
use super::preview::Previews;
use super::progress::Console;
use super::report::{Seconds, about, report};
use crate::director::CachedSnapshot;
use crate::error::{Error, Result};
use crate::file;
use crate::image::{DeepImage, Denoiser};
use crate::render::{
    self, Checkpoints, Clock, Control, Deadline, Earlier, Ended, Preview, ReachedError, Rendered,
};
use crate::scene::Scene;

/// Longest and shortest time of a preview, for a render that is interrupted before its first ray. A larger
/// film, which takes longer to write, gets less.
const PREVIEW: [Duration; 2] = [Duration::from_millis(400), Duration::from_millis(100)];

/// Time of a preview with writing it: what somebody who pressed Ctrl-C is made to wait.
const LEAVING: Duration = Duration::from_millis(800);

/// The job of rendering one picture.
#[derive(Debug, Clone, Copy)]
pub(super) struct PictureJob<'a> {
    /// The files to write.
    pub(super) output: &'a Output,
    /// Its limits and checkpoints.
    pub(super) limits: &'a LimitArgs,
    /// Ends it on Ctrl-C.
    pub(super) interrupt: &'a Interrupt,
    /// Shows it while it gets better.
    pub(super) live: &'a Live,
    /// How it is rendered.
    pub(super) method: Method,
    /// Whether progress and notes are left out.
    pub(super) quiet: bool,
    /// Time without pauses.
    pub(super) clock: &'a Arc<Clock>,
    /// When the time of this picture began.
    pub(super) start: Duration,
    /// Times of the stages before the render.
    pub(super) preparation: Preparation,
    /// Bytes in memory before the scene was loaded.
    pub(super) program: u64,
    /// The denoiser, for a scene that is denoised.
    pub(super) denoiser: Option<&'a Denoiser>,
}

/// The report on a picture that was written.
#[derive(Debug)]
pub(super) struct PictureReport {
    /// Settings, seconds, work, memory and paths.
    pub(super) report: Value,
    /// The files that were written.
    pub(super) output: Output,
    /// What was saved and how to resume, where the picture was interrupted.
    pub(super) interrupted: Option<String>,
    /// The director's snapshot, for the next picture.
    pub(super) snapshot: Option<CachedSnapshot>,
}

impl PictureReport {
    /// The result of a run that ends with this picture.
    ///
    /// # Errors
    /// Where the picture was interrupted.
    pub(super) fn end(self, interrupt: &Interrupt) -> Result<()> {
        match self.interrupted {
            Some(message) => Err(Error::Interrupted { message, code: interrupt.exit_code() }),
            None => Ok(()),
        }
    }
}

impl PictureJob<'_> {
    /// Renders `scene` on `pool` and writes the picture. `warnings` were printed before and are repeated in
    /// the report; `earlier` is what earlier pictures of a sequence leave.
    ///
    /// # Errors
    /// Where the picture exceeds the memory limit, or cannot be resumed, rendered or written.
    pub(super) fn run(
        &self,
        scene: &mut Scene,
        pool: &ThreadPool,
        mut warnings: Vec<String>,
        earlier: Earlier<'_>,
    ) -> Result<PictureReport> {
        let requested = scene.render.photons;
        let start = Instant::now();
        let fewer_photons = pool.install(|| {
            let before =
                if earlier.photons.is_some() { None } else { self.photons_before(requested)? };
            self.fit(scene).photons(scene, before, earlier.photons)
        })?;
        let fitting = start.elapsed();
        console::warn(fewer_photons.as_slice());
        warnings.extend(fewer_photons);
        let checkpoints = self.checkpoints(scene, requested)?;
        let mut rendered = self.render(scene, pool, earlier, checkpoints.as_ref())?;
        let denoiser = self.denoiser.filter(|_| scene.render.denoise);
        if let Some(denoiser) = denoiser.filter(|_| rendered.ended != Ended::Stopped) {
            rendered.denoise(denoiser)?;
        }
        let is_deep = scene.film.deep && rendered.ended != Ended::Stopped;
        let deep = is_deep.then(|| pool.install(|| rendered.deep(scene)));

        self.note(rendered.error.as_ref().and_then(ReachedError::note));
        let mut ended = rendered.warnings();
        ended.extend(self.out_of_time(&rendered, checkpoints.as_ref()));
        console::warn(&ended);
        warnings.extend(ended);
        let start = Instant::now();
        let settings = header::settings(scene, Some(&rendered), self.method.reference, requested);
        let pictures = (&rendered, deep.as_ref());
        let output = self.write(scene, pictures, &settings, requested, checkpoints.as_ref())?;
        self.live.finish(&self.output.exr, &rendered.film);
        let stages =
            Seconds { preparation: self.preparation, fitting, writing: Some(start.elapsed()) };
        let mut report = report(scene, &rendered, settings, &stages, &warnings);
        report["peak_memory"] = json!(memory::peak());
        report["outputs"] = json!(output.names());
        if rendered.film.denoiser().is_some() {
            report["denoiser"] = json!(denoiser.map(about));
        }
        let stopped = rendered.ended == Ended::Stopped;
        let interrupted = stopped.then(|| {
            format!(
                "interrupted: {} has {}{}",
                output.exr.display(),
                partial::share(&rendered),
                how_to_resume(checkpoints.as_ref(), &rendered)
            )
        });
        Ok(PictureReport { report, output, interrupted, snapshot: rendered.snapshot.take() })
    }

    fn fit(&self, scene: &Scene) -> Fit<'_> {
        let Self { limits, method, clock, start, .. } = *self;
        let program = self.program + self.live.memory(scene.window().pixels());
        Fit { memory: limits.memory, time: limits.time, method, clock, start, program }
    }

    /// The photons of the checkpoint that is resumed, where `requested` photons were reduced to them.
    fn photons_before(&self, requested: u64) -> Result<Option<u64>> {
        if !self.limits.resume {
            return Ok(None);
        }
        let Some(key) = Checkpoints::key_of(&checkpoint_path(&self.output.exr))? else {
            return Ok(None);
        };
        let number = |name: &str| key.get(name).and_then(Value::as_u64);
        let before = number("photons_asked").or_else(|| number("photons"));
        Ok(number("photons").filter(|_| before == Some(requested)))
    }

    fn checkpoints(&self, scene: &Scene, requested: u64) -> Result<Option<Checkpoints>> {
        let path = checkpoint_path(&self.output.exr);
        let key = header::key(scene, self.method, requested);
        let (every, off) = match self.limits.checkpoint {
            CheckpointInterval::Every(interval) => (interval, false),
            CheckpointInterval::Off => (Duration::MAX, true),
        };
        if !self.limits.resume {
            let note = format!(
                "note: {} was left by an earlier render; --resume would resume it",
                path.display()
            );
            self.note(path.exists().then_some(note));
            return Ok((!off).then(|| Checkpoints::new(&path, key, every)));
        }
        let checkpoints = Checkpoints::resume(&path, key, every)?;
        self.note(Some(if checkpoints.resumes() {
            format!("note: resumes after {} rays from {}", checkpoints.rays(), path.display())
        } else {
            format!("note: there is no {}: the render starts from the beginning", path.display())
        }));
        Ok((!off || checkpoints.resumes()).then_some(checkpoints))
    }

    fn note(&self, note: Option<String>) {
        note.filter(|_| !self.quiet).iter().for_each(|note| console::message(note));
    }

    fn render(
        &self,
        scene: &Scene,
        pool: &ThreadPool,
        earlier: Earlier<'_>,
        checkpoints: Option<&Checkpoints>,
    ) -> Result<Rendered> {
        let console = Console::new(self.clock.clone(), self.quiet);
        self.live.begin(&self.output.exr, scene.film.shown(), console.watch());
        let stop = self.interrupt.stop();
        let deadline = self.fit(scene).deadline(scene);
        let Self { output, live, method, .. } = *self;
        let previews = Previews::new(scene, output, live, self.limits.preview, method.reference);
        let preview = Preview {
            every: previews.moments(),
            asked: self.interrupt.preview(),
            show: &|asked, picture| previews.show(asked, picture),
        };
        let (progress, stop, preview) = (&console, Some(stop), Some(preview));
        let control = Control { progress, stop, deadline, checkpoints, preview };
        let work = || {
            if self.method.reference {
                Ok(render::render_reference(scene, &scene.render, control))
            } else {
                render::render_next(scene, &scene.render, earlier, control)
            }
        };
        let threads = pool.current_num_threads();
        self.interrupt
            .early(|| self.write_preview(scene, threads, checkpoints), || pool.install(work))
    }

    /// Ends the program, interrupted before the first ray, with a preview of `scene` for a picture. Returns
    /// where rays have begun by then.
    fn write_preview(&self, scene: &Scene, threads: usize, checkpoints: Option<&Checkpoints>) {
        let early = "interrupted before the first ray";
        if let Some(resumed) = checkpoints.filter(|checkpoints| checkpoints.resumes()) {
            let path = resumed.path().display();
            self.interrupt.end(&format!("{early}: {path} holds the state as before"));
        }
        let [most, least] = PREVIEW;
        let time = LEAVING.saturating_sub(writing(scene)).clamp(least, most);
        let deadline = Deadline { clock: self.clock, at: self.clock.elapsed() + time };
        let control = Control { deadline: Some(deadline), ..Control::silent() };
        // The threads of the render's own pool wait, or do work that cannot be halted.
        self.interrupt.stop().pause();
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        let preview =
            pool.map(|pool| pool.install(|| render::preview(scene, &scene.render, control)));
        if !self.interrupt.is_early() {
            self.interrupt.stop().ask();
            self.interrupt.stop().go_on();
            return;
        }
        let output = partial::place_preview(self.output);
        let (Ok(preview), Some(output)) = (preview, output) else {
            self.interrupt
                .end(&format!("{early}: there is no picture, and files are as they were"));
        };
        let settings = header::settings(scene, None, self.method.reference, scene.render.photons);
        let mut named = header::attributes(scene, &settings, &preview);
        named.push((partial::PREVIEW.into(), "true".into()));
        let exr = output.exr.display();
        self.interrupt.end(&match output.write(
            &scene.film.shown(),
            &preview,
            scene.film.half,
            &named,
        ) {
            Ok(()) => format!("{early}: {exr} is a preview without photons"),
            Err(error) => format!("{early}: {error}"),
        });
    }

    /// A warning where the deadline passed before all rays were shot.
    fn out_of_time(
        &self,
        rendered: &Rendered,
        checkpoints: Option<&Checkpoints>,
    ) -> Option<String> {
        (rendered.ended == Ended::OutOfTime).then(|| {
            format!(
                "the time is over: the picture has {}{}",
                partial::share(rendered),
                how_to_resume(checkpoints, rendered)
            )
        })
    }

    /// Writes the picture, and the deep one where there is one, with settings and work counters in their headers, and
    /// removes files that a complete one makes obsolete.
    fn write(
        &self,
        scene: &Scene,
        (rendered, deep): (&Rendered, Option<&DeepImage>),
        settings: &Map<String, Value>,
        requested: u64,
        checkpoints: Option<&Checkpoints>,
    ) -> Result<Output> {
        let output = match rendered.ended {
            Ended::Stopped => partial::place(self.output),
            Ended::Complete | Ended::OutOfTime => self.output.clone(),
        };
        let output = output.with_deep(deep.is_some());
        let mut named = header::attributes(scene, settings, rendered);
        named.extend(header::recipe_of(scene, rendered, self.method, requested));
        if let Some((path, deep)) = output.deep.as_ref().zip(deep) {
            let bytes = deep.bytes(path, &header::without_objects(&named))?;
            file::write(path, |out| out.write_all(&bytes))?;
        }
        output.write(&scene.film.shown(), rendered, scene.film.half, &named)?;
        if rendered.is_complete() {
            partial::clear(self.output);
            checkpoints.map_or(Ok(()), Checkpoints::remove)?;
        }
        Ok(output)
    }
}

/// How to resume an unfinished picture.
fn how_to_resume(checkpoints: Option<&Checkpoints>, rendered: &Rendered) -> String {
    match checkpoints.filter(|_| rendered.checkpoint_error.is_none()) {
        Some(written) => {
            format!("; {} holds its state: add --resume to go on", written.path().display())
        }
        None => "; its state was not kept".into(),
    }
}
