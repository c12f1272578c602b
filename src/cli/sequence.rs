//! `fogbow render --frames`: one picture a frame.

use std::collections::BTreeSet;
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use serde_json::{Value, json};

use super::console;
use super::first_look;
use super::frames::{Frame, Reader};
use super::header;
use super::interrupt::Interrupt;
use super::limit_args::checkpoint_path;
use super::live::Live;
use super::load::{self, Preparation};
use super::memory;
use super::memory_limit;
use super::output::Output;
use super::picture::{PictureJob, PictureReport};
use super::render_args::{self, Args};
use super::units;
use crate::director::CachedSnapshot;
use crate::error::{Error, Result};
use crate::image::{Denoiser, read_layers};
use crate::render::{Clock, Earlier, SavedPhotons};
use crate::scene::{Scene, Sequence};
use crate::sequence::{FrameTime, Frames, Pattern};
use crate::strategy::Assignment;

/// Renders `frames`, each as it would be alone, and shows them in `live`.
pub(super) fn run(args: &Args, frames: &Frames, live: &Live) -> Result<()> {
    let program = memory_limit::program();
    let denoiser = render_args::early_denoiser(args)?;
    let frames = frames.times();
    let target = target(args.output()?);
    let first = frames.first().copied().unwrap_or_else(|| 0.into());
    Output::check(&target.at(first))?;
    let interrupt = Interrupt::listen()?;
    let mut options = args.options();
    options.memory = options.memory.or_else(memory::available);
    let pool = load::thread_pool(args.run.threads)?;
    let sequence = pool.install(|| Sequence::open(&args.paths.scene, &options))?;
    let reader = Reader::new(&sequence, &args.frames);
    if let Some(warning) = reader.check(frames)? {
        console::warn(&[warning]);
    }
    let chooses_strategies = !args.reference && args.photons.photons_from.is_none();
    let InCommon { metered, exposure, strategies } =
        pool.install(|| InCommon::new(&sequence, !chooses_strategies))?;
    if let Some(scene) = metered.filter(|_| args.write_scene.is_some()) {
        let mut scene = scene?;
        scene.film.exposure = scene.film.exposure.or(exposure);
        render_args::write_scene(args, &scene)?;
    }
    let mut run = FrameLoop::new(args, &interrupt, live, program, frames.len());
    (run.denoiser, run.strategies) = (denoiser, strategies);
    std::thread::scope(|scope| {
        for frame in reader.ahead(scope, frames)? {
            let mut frame = frame?;
            if let Some(scene) = &mut frame.scene {
                scene.film.exposure = scene.film.exposure.or(exposure);
            }
            let output = Output::check(&target.at(frame.time))?;
            run.frame(frame, &output, &pool)?;
        }
        Ok(())
    })?;
    if run.pictures == 0 {
        let problem = "none of its frames can be rendered; see the messages above";
        return Err(Error::file(&args.paths.scene, problem));
    }
    Ok(())
}

/// What all frames have in common, found in one of them.
struct InCommon {
    /// That frame; an error where it cannot be used, which is told where it is rendered.
    metered: Option<Result<Scene>>,
    /// The exposure, where the scene leaves it open.
    exposure: Option<f64>,
    /// The strategies; none of a reference, nor where photons are read that bring theirs.
    strategies: Option<Assignment>,
}

impl InCommon {
    fn new(sequence: &Sequence, chooses_none: bool) -> Result<Self> {
        let metered = sequence.metered_frame().map(|frame| sequence.load(frame.into()));
        let (mut exposure, mut strategies) = (None, None);
        if let Some(Ok(scene)) = &metered {
            let is_open = scene.film.exposure.is_none();
            exposure = is_open.then(|| crate::render::exposure(scene)).transpose()?;
            let choose = || crate::render::shot_strategies(scene, &scene.render);
            strategies = (!chooses_none).then(choose).transpose()?;
        }
        Ok(Self { metered, exposure, strategies })
    }
}

/// A frame to render.
struct FrameJob<'a> {
    output: &'a Output,
    /// Photons that are read in place of shooting them.
    photons: Option<&'a SavedPhotons>,
    /// When its time began.
    start: Duration,
    /// How long it took to load.
    loading: Duration,
}

/// The pattern that `-o path` is; a name without one gets `.####` before its ending.
fn target(path: &Path) -> Pattern {
    let numbered = |path: &Path| {
        let stem = path.file_stem().unwrap_or_default().to_string_lossy();
        let ending = path.extension().map(|e| format!(".{}", e.to_string_lossy()));
        path.with_file_name(format!("{stem}.####{}", ending.unwrap_or_default()))
    };
    Pattern::from_path(path)
        .or_else(|| Pattern::from_path(&numbered(path)))
        .expect("#### is a pattern")
}

/// The state of a sequence between two frames.
struct FrameLoop<'a> {
    args: &'a Args,
    interrupt: &'a Interrupt,
    live: &'a Live,
    clock: Arc<Clock>,
    /// Bytes in memory before anything was loaded.
    program: u64,
    /// Number of frames to render.
    frames: usize,
    /// Frames that were finished or left out, and the current one.
    done: usize,
    /// Frames that have a picture.
    pictures: usize,
    /// Number of pictures that were rendered, and the time for them.
    rendered: (u32, Duration),
    /// The director's snapshot of the picture before.
    snapshot: Option<CachedSnapshot>,
    /// Messages that were printed, which are not repeated for each frame.
    said: BTreeSet<String>,
    /// The denoiser, once a frame needed it.
    denoiser: Option<Denoiser>,
    /// The strategies of all frames.
    strategies: Option<Assignment>,
}

impl<'a> FrameLoop<'a> {
    fn new(
        args: &'a Args,
        interrupt: &'a Interrupt,
        live: &'a Live,
        program: u64,
        frames: usize,
    ) -> Self {
        Self {
            args,
            interrupt,
            live,
            clock: Clock::start(),
            program,
            frames,
            done: 0,
            pictures: 0,
            rendered: (0, Duration::ZERO),
            snapshot: None,
            said: BTreeSet::new(),
            denoiser: None,
            strategies: None,
        }
    }

    /// Renders `frame`, unless there is nothing to render or its picture is there already.
    fn frame(&mut self, frame: Frame, output: &Output, pool: &rayon::ThreadPool) -> Result<()> {
        let start = self.clock.elapsed();
        let Frame { time, scene, held, problem, loading } = frame;
        let number = number(time);
        self.done += 1;
        let Some(mut scene) = scene else {
            self.warn(time, &format!("{}; no picture", problem.as_deref().unwrap_or_default()));
            self.report(json!({ "frame": number, "state": "skipped", "problem": problem }));
            return Ok(());
        };
        self.args.limits.set_part(&mut scene, self.args.reference)?;
        let photons = self.args.photons.open(&mut scene)?;
        self.pictures += 1;
        if let (Some(held), Some(problem)) = (held, &problem) {
            self.warn(time, &format!("{problem}; frame {held} is rendered again"));
        }
        if self.args.limits.resume && self.is_finished(output, &scene) {
            self.say(time, "finished by an earlier run");
            self.report(json!({ "frame": number, "state": "finished", "outputs": output.names() }));
            return Ok(());
        }
        self.interrupt.stop().begin_anew();
        if self.interrupt.stop().is_asked() {
            let message = format!(
                "interrupted before frame {time}: the frames before it are finished, --resume goes \
                 on with it"
            );
            return Err(Error::Interrupted { message, code: self.interrupt.exit_code() });
        }
        self.say(time, &self.progress());
        render_args::find_denoiser(&mut self.denoiser, &scene)?;
        let warnings = self.print_notes(&scene);
        let frame = FrameJob { output, photons: photons.as_ref(), start, loading };
        let picture = self.picture(&mut scene, pool, warnings, &frame)?;
        self.rendered.0 += 1;
        self.rendered.1 += self.clock.elapsed() - start;
        let state = if held.is_some() { "held" } else { "rendered" };
        let of_frame = json!({ "frame": number, "state": state, "held": held, "problem": problem });
        let report = merged(of_frame, picture.report);
        let picture = PictureReport { report, ..picture };
        render_args::print_report(self.args, &picture);
        picture.end(self.interrupt)
    }

    /// Renders and writes the picture of `scene`.
    fn picture(
        &mut self,
        scene: &mut Scene,
        pool: &rayon::ThreadPool,
        warnings: Vec<String>,
        &FrameJob { output, photons, start, loading }: &FrameJob<'_>,
    ) -> Result<PictureReport> {
        // The frame that is read meanwhile will be about as large as this one.
        let next: usize = scene.media.grid_bytes().iter().sum();
        let job = PictureJob {
            output,
            limits: &self.args.limits,
            interrupt: self.interrupt,
            live: self.live,
            method: self.args.method(),
            quiet: self.args.run.quiet,
            clock: &self.clock,
            start,
            preparation: Preparation { loading, metering: None },
            program: self.program + next as u64,
            denoiser: self.denoiser.as_ref(),
        };
        pool.install(|| first_look::show(scene, &job));
        let strategies = self.strategies.as_ref();
        let earlier = Earlier { snapshot: self.snapshot.take(), strategies, photons };
        let mut picture = job.run(scene, pool, warnings, earlier)?;
        self.snapshot = picture.snapshot.take();
        Ok(picture)
    }

    /// Whether `output` holds the picture of `scene`, whole and made as it would be now.
    fn is_finished(&self, output: &Output, scene: &Scene) -> bool {
        // The PNG is written first, so that one beside a finished EXR belongs to it.
        let layers = if output.png.is_file() { read_layers(&output.exr).ok() } else { None };
        let recipe = header::recipe(scene, self.args.method());
        let deep = output.clone().with_deep(scene.film.deep).deep;
        let finished = deep.is_none_or(|deep| deep.is_file())
            && layers.is_some_and(|layers| {
                layers.attributes.get(header::RECIPE).is_some_and(|r| *r == recipe)
            });
        if finished {
            // An earlier run was killed before it removed the checkpoint.
            let _ = std::fs::remove_file(checkpoint_path(&output.exr));
        }
        finished
    }

    /// Progress of the sequence, with the time that is left by the mean of the frames so far.
    fn progress(&self) -> String {
        let place = format!("{} of {}", self.done, self.frames);
        let (count, time) = self.rendered;
        if count == 0 {
            return place;
        }
        let left = time.as_secs_f64() / f64::from(count) * (self.frames - self.done + 1) as f64;
        format!(
            "{place}, ETA {}",
            units::brief(Duration::try_from_secs_f64(left).unwrap_or_default())
        )
    }

    /// Prints the notes and warnings on `scene` that no earlier frame had. Returns all warnings.
    fn print_notes(&mut self, scene: &Scene) -> Vec<String> {
        let notes = scene.notes.iter().map(|note| format!("note: {note}"));
        let denoiser = self.denoiser.as_ref().filter(|_| scene.render.denoise);
        let notes = notes.chain(denoiser.map(render_args::note));
        let lines =
            notes.filter(|_| !self.args.run.quiet).chain(render_args::plan(self.args, scene));
        for line in lines {
            if self.said.insert(line.clone()) {
                console::message(&line);
            }
        }
        let warnings = [scene.warnings.clone(), render_args::advice(self.args, scene)].concat();
        let new = warnings.iter().filter(|warning| self.said.insert((*warning).clone()));
        console::warn(&new.cloned().collect::<Vec<_>>());
        warnings
    }

    fn say(&self, frame: FrameTime, words: &str) {
        if !self.args.run.quiet {
            console::message(&format!("frame {frame}: {words}"));
        }
    }

    fn warn(&self, frame: FrameTime, problem: &str) {
        console::warn(&[format!("frame {frame}: {problem}")]);
    }

    fn report(&self, report: Value) {
        if self.args.run.json {
            console::result(&report.to_string());
        }
    }
}

/// The number of `time` in JSON: a whole one at that of a frame.
fn number(time: FrameTime) -> Value {
    if time.is_whole() { json!(time.frame()) } else { json!(time.number()) }
}

/// The keys of `first`, then those of `second`.
fn merged(mut first: Value, second: Value) -> Value {
    if let (Value::Object(first), Value::Object(second)) = (&mut first, second) {
        first.extend(second);
    }
    first
}
