//! One picture: rendered, held, written.

use std::sync::Arc;
use std::time::{Duration, Instant};

use rayon::ThreadPool;
use serde_json::{Map, Value, json};

use super::console;
use super::header::{self, Method};
use super::holding::{LimitArgs, Pause, checkpoint_path};
use super::interrupt::Interrupt;
use super::limit;
use super::load::Preparation;
use super::memory;
use super::output::Output;
use super::partial;
use super::progress::Console;
use crate::director::CachedSnapshot;
use crate::error::{Error, Result};
use crate::image::Denoiser;
use crate::render::{
    self, Checkpoints, Clock, Control, Deadline, Ended, Progress, Rendered, Silent,
};
use crate::scene::Scene;

/// Seconds a pixel that writing takes, about.
const WRITING: f64 = 1e-6;

/// Seconds a pixel that taking off noise takes, about.
const DENOISING: f64 = 2.5e-6;

/// Time for a first look, where a render is interrupted before it has a picture: at most, and less
/// as a larger film takes longer to write, but at least the second.
const PREVIEW: [Duration; 2] = [Duration::from_millis(400), Duration::from_millis(100)];

/// Time for that and for writing it.
const LEAVING: Duration = Duration::from_millis(800);

/// Of the time that is left, photons are to take at most this share.
const PHOTONS: f64 = 0.4;

/// How one picture is rendered.
#[derive(Debug, Clone, Copy)]
pub(super) struct Job<'a> {
    /// Where it goes.
    pub(super) output: &'a Output,
    /// What holds it.
    pub(super) hold: &'a LimitArgs,
    /// Ends it on Ctrl-C.
    pub(super) interrupt: &'a Interrupt,
    /// How it is made.
    pub(super) method: Method,
    /// Whether progress and notes are left out.
    pub(super) quiet: bool,
    /// The time.
    pub(super) clock: &'a Arc<Clock>,
    /// When that of the picture began.
    pub(super) start: Duration,
    /// What came before.
    pub(super) preparation: Preparation,
    /// Bytes in memory before the scene was loaded.
    pub(super) program: u64,
    /// Takes the noise off, where the scene asks for it.
    pub(super) denoiser: Option<&'a Denoiser>,
}

/// What is told of a picture that is written.
#[derive(Debug)]
pub(super) struct PictureReport {
    /// Settings, seconds, work, memory and paths.
    pub(super) report: Value,
    /// The files.
    pub(super) output: Output,
    /// What is kept, and how to go on, where the picture was interrupted.
    pub(super) interrupted: Option<String>,
    /// What the director saw first.
    pub(super) sight: Option<CachedSnapshot>,
}

impl PictureReport {
    /// The end of a run whose last picture this is.
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

impl Job<'_> {
    /// Renders `scene` on `pool` and writes what there is. `warnings` have been printed before; `kept`
    /// is what the director saw first of an earlier picture.
    ///
    /// # Errors
    /// Where it takes more memory than it may, cannot be taken up again, rendered or written.
    pub(super) fn run(
        &self,
        scene: &mut Scene,
        pool: &ThreadPool,
        mut warnings: Vec<String>,
        kept: Option<CachedSnapshot>,
    ) -> Result<PictureReport> {
        let asked = scene.render.photons;
        self.crop(scene)?;
        let start = Instant::now();
        let thinned = pool.install(|| self.thin(scene))?;
        let fitting = start.elapsed();
        console::warn(thinned.as_slice());
        warnings.extend(thinned);
        let checkpoints = self.checkpoints(scene, asked)?;
        let mut rendered = self.render(scene, pool, kept, checkpoints.as_ref())?;
        let denoiser = self.denoiser.filter(|_| scene.render.denoise);
        if let Some(denoiser) = denoiser.filter(|_| rendered.ended != Ended::Stopped) {
            rendered.denoise(denoiser)?;
        }

        let mut ended = rendered.warnings();
        ended.extend(self.shortened(&rendered, checkpoints.as_ref()));
        console::warn(&ended);
        warnings.extend(ended);
        let start = Instant::now();
        let settings = header::settings(scene, Some(&rendered), self.method.reference, asked);
        let output = self.write(scene, &rendered, &settings, checkpoints.as_ref())?;
        let mut report = json!({
            "settings": settings,
            "complete": rendered.is_complete(),
            "seconds": seconds(self.preparation, fitting, &rendered, start.elapsed()),
            "work": rendered.work,
            "peak_memory": memory::peak(),
            "warnings": warnings,
            "notes": scene.notes,
            "outputs": output.names(),
        });
        if rendered.film.denoiser().is_some() {
            report["denoiser"] =
                json!(denoiser.map(|d| json!({ "version": d.version(), "path": d.path() })));
        }
        if let Some(strategy) = &rendered.strategy {
            report["strategy"] = json!(strategy);
        }
        if let Some(directed) = rendered.director {
            report["director"] = json!(directed);
        }
        let stopped = rendered.ended == Ended::Stopped;
        let interrupted = stopped.then(|| {
            format!(
                "interrupted: {} has {}{}",
                output.exr.display(),
                share(&rendered),
                going_on(checkpoints.as_ref(), &rendered)
            )
        });
        Ok(PictureReport { report, output, interrupted, sight: rendered.sight.take() })
    }

    fn crop(&self, scene: &mut Scene) -> Result<()> {
        let Some(crop) = self.hold.crop else { return Ok(()) };
        let [width, height] = scene.film.size;
        if !crop.fits(scene.film.size) {
            return Err(Error::Usage(format!(
                "--crop {crop} reaches beyond the film of {width}x{height} pixels"
            )));
        }
        scene.render.crop = Some(crop);
        Ok(())
    }

    /// Asks for fewer photons where an earlier part of the render did, or where memory or time do
    /// not last for all; a sentence says so.
    fn thin(&self, scene: &mut Scene) -> Result<Option<String>> {
        let asked = scene.render.photons;
        let before = self.photons_before(asked)?;
        scene.render.photons = before.unwrap_or(asked);
        let thinned = limit::fit(scene, self.hold.memory, self.method, self.program)?;
        let (Some(deadline), None, false) = (self.deadline(scene), before, self.method.reference)
        else {
            return Ok(thinned);
        };
        let left = deadline.left().mul_f64(PHOTONS);
        let photons = scene.render.photons;
        scene.render.photons = render::photons_within(scene, &scene.render, left)?;
        Ok((scene.render.photons < photons)
            .then(|| {
                format!(
                    "{} photons instead of {asked}, for which --time is too short",
                    scene.render.photons
                )
            })
            .or(thinned))
    }

    /// The photons that a checkpoint, if one is gone on from, was made with out of `asked`.
    fn photons_before(&self, asked: u64) -> Result<Option<u64>> {
        if !self.hold.resume {
            return Ok(None);
        }
        let Some(key) = Checkpoints::key_of(&checkpoint_path(&self.output.exr))? else {
            return Ok(None);
        };
        let number = |name: &str| key.get(name).and_then(Value::as_u64);
        let of = number("photons_asked").or_else(|| number("photons"));
        Ok(number("photons").filter(|_| of == Some(asked)))
    }

    /// When rendering must end for the files to be written in time.
    fn deadline(&self, scene: &Scene) -> Option<Deadline<'_>> {
        let time = self.hold.time?;
        let denoising = if scene.render.denoise { DENOISING } else { 0.0 };
        let after = writing(scene) + seconds_of(scene, denoising);
        let at = self.start.checked_add(time - after.min(time / 4))?;
        Some(Deadline { clock: self.clock, at })
    }

    fn checkpoints(&self, scene: &Scene, asked: u64) -> Result<Option<Checkpoints>> {
        let path = checkpoint_path(&self.output.exr);
        let key = header::key(scene, self.method, asked);
        let (every, off) = match self.hold.checkpoint {
            Pause::Lasts(pause) => (pause, false),
            Pause::Off => (Duration::MAX, true),
        };
        if !self.hold.resume {
            let note = format!(
                "note: {} was left by an earlier render; --resume would go on from it",
                path.display()
            );
            self.note(path.exists().then_some(note));
            return Ok((!off).then(|| Checkpoints::new(&path, key, every)));
        }
        let checkpoints = Checkpoints::resume(&path, key, every)?;
        self.note(Some(if checkpoints.resumes() {
            format!("note: goes on after {} rays from {}", checkpoints.rays(), path.display())
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
        kept: Option<CachedSnapshot>,
        checkpoints: Option<&Checkpoints>,
    ) -> Result<Rendered> {
        let console = Console::new(self.clock.clone());
        let progress: &dyn Progress = if self.quiet { &Silent } else { &console };
        let stop = self.interrupt.stop();
        let deadline = self.deadline(scene);
        let control = Control { progress, stop: Some(stop), deadline, checkpoints };
        let work = || {
            if self.method.reference {
                Ok(render::render_reference(scene, &scene.render, control))
            } else {
                render::render_next(scene, &scene.render, kept, control)
            }
        };
        let threads = pool.current_num_threads();
        self.interrupt.early(|| self.show_early(scene, threads, checkpoints), || pool.install(work))
    }

    /// Ends the program, interrupted before the first ray, with a first look at `scene` for a
    /// picture. Returns where there is a better one by then.
    fn show_early(&self, scene: &Scene, threads: usize, checkpoints: Option<&Checkpoints>) {
        let early = "interrupted before the first ray";
        if let Some(kept) = checkpoints.filter(|kept| kept.resumes()) {
            let path = kept.path().display();
            self.interrupt.end(&format!("{early}: {path} holds the state as before"));
        }
        let [most, least] = PREVIEW;
        let time = LEAVING.saturating_sub(writing(scene)).clamp(least, most);
        let deadline = Deadline { clock: self.clock, at: self.clock.elapsed() + time };
        let control = Control { deadline: Some(deadline), ..Control::silent() };
        // The threads of the render's own pool wait, or are busy with what does not.
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
        let mut named = header::attributes(&settings, &preview);
        named.push((partial::PREVIEW.into(), "true".into()));
        let exr = output.exr.display();
        self.interrupt.end(&match output.write(scene, &preview, &named) {
            Ok(()) => format!("{early}: {exr} is a first look without photons"),
            Err(error) => format!("{early}: {error}"),
        });
    }

    /// A sentence where the time was over before all rays were shot.
    fn shortened(&self, rendered: &Rendered, checkpoints: Option<&Checkpoints>) -> Option<String> {
        (rendered.ended == Ended::OutOfTime).then(|| {
            format!(
                "the time is over: the picture has {}{}",
                share(rendered),
                going_on(checkpoints, rendered)
            )
        })
    }

    /// Writes the picture, with settings and work counters in its header, and tidies up.
    fn write(
        &self,
        scene: &Scene,
        rendered: &Rendered,
        settings: &Map<String, Value>,
        checkpoints: Option<&Checkpoints>,
    ) -> Result<Output> {
        let output = match rendered.ended {
            Ended::Stopped => partial::place(self.output),
            Ended::Complete | Ended::OutOfTime => self.output.clone(),
        };
        let mut named = header::attributes(settings, rendered);
        if rendered.is_complete() && !settings.contains_key("photons_asked") {
            let recipe = header::recipe(scene, self.method);
            named.push((header::RECIPE.into(), recipe));
        }
        output.write(scene, rendered, &named)?;
        if rendered.is_complete() {
            partial::clear(self.output);
            checkpoints.map_or(Ok(()), Checkpoints::remove)?;
        }
        Ok(output)
    }
}

/// About how long it takes to write the picture of `scene`.
fn writing(scene: &Scene) -> Duration {
    seconds_of(scene, WRITING)
}

/// What takes so many seconds `a_pixel` takes for the picture of `scene`.
fn seconds_of(scene: &Scene, a_pixel: f64) -> Duration {
    Duration::from_secs_f64(scene.window().pixels() as f64 * a_pixel)
}

/// How much of a picture that is not finished is there.
fn share(rendered: &Rendered) -> String {
    let rays = rendered.film.layer("rays").unwrap_or_default();
    let share = format!("{:.1} % of its rays", rendered.percent());
    match rays.iter().filter(|rays| **rays == 0.0).count() {
        0 => share,
        bare => format!(
            "{share}, and {bare} of {} pixels have none yet and show what is beside them",
            rays.len()
        ),
    }
}

/// How to go on with a picture that is not finished.
fn going_on(checkpoints: Option<&Checkpoints>, rendered: &Rendered) -> String {
    match checkpoints.filter(|_| rendered.checkpoint_error.is_none()) {
        Some(kept) => {
            format!("; {} holds its state: add --resume to go on", kept.path().display())
        }
        None => "; its state was not kept".into(),
    }
}

/// Seconds of each stage. `fit` is what it took to see that memory and time suffice, with a look at
/// photons where that is close.
fn seconds(
    preparation: Preparation,
    fitting: Duration,
    rendered: &Rendered,
    writing: Duration,
) -> Map<String, Value> {
    let stages = rendered.timings.iter().map(|(name, time)| (*name, *time));
    let metering = preparation.metering.map(|time| ("meter", time));
    std::iter::once(("load", preparation.loading))
        .chain(metering)
        .chain([("fit", fitting)])
        .chain(stages)
        .chain([("write", writing)])
        .map(|(name, time)| (name.to_owned(), json!(time.as_secs_f64())))
        .collect()
}
