//! `fogbow render --frames`: one picture a frame.

use std::collections::BTreeSet;
use std::path::Path;
use std::time::{Duration, Instant};

use serde_json::{Value, json};

use super::console;
use super::frames::{Frame, Reader};
use super::load;
use super::output::Output;
use super::render::{self, Args, Job};
use crate::director::KeptSight;
use crate::error::{Error, Result};
use crate::image::read_layers;
use crate::scene::{LoadOptions, Scene, Sequence};
use crate::sequence::{Frames, Pattern};

/// Renders `frames`, each as it would be alone.
pub(super) fn run(args: &Args, frames: &Frames) -> Result<()> {
    let frames = frames.numbers();
    let target = target(&args.paths.output);
    let first = frames.first().copied().unwrap_or_default();
    Output::check(&target.at(first))?;
    let options = LoadOptions {
        overrides: args.settings.overrides(),
        level_set_as_fog: args.level_set.is_some(),
        frame: None,
    };
    let pool = load::thread_pool(args.run.threads)?;
    let sequence = pool.install(|| Sequence::open(&args.paths.scene, &options))?;
    let reader = Reader::new(&sequence, &args.frames);
    if let Some(warning) = reader.check(frames)? {
        console::warn(&[warning]);
    }
    let mut run = Run::new(args, frames.len());
    std::thread::scope(|scope| {
        for frame in reader.ahead(scope, frames)? {
            let frame = frame?;
            let output = Output::check(&target.at(frame.number))?;
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

/// The pattern that `-o path` is; a name without one gets `.####` before its ending.
fn target(path: &Path) -> Pattern {
    let numbered = |path: &Path| {
        let stem = path.file_stem().unwrap_or_default().to_string_lossy();
        let ending = path.extension().map(|e| format!(".{}", e.to_string_lossy()));
        path.with_file_name(format!("{stem}.####{}", ending.unwrap_or_default()))
    };
    Pattern::of(path).or_else(|| Pattern::of(&numbered(path))).expect("#### is a pattern")
}

/// A sequence on its way.
struct Run<'a> {
    args: &'a Args,
    /// Frames asked for.
    frames: usize,
    /// Frames that are done or were left out.
    done: usize,
    /// Pictures that are there now.
    pictures: usize,
    /// Pictures rendered, and the time for them.
    rendered: (u32, Duration),
    /// The director's first look at the picture before.
    sight: Option<KeptSight>,
    /// What has been said, which need not be said of each frame.
    said: BTreeSet<String>,
}

impl<'a> Run<'a> {
    fn new(args: &'a Args, frames: usize) -> Self {
        let rendered = (0, Duration::ZERO);
        let said = BTreeSet::new();
        Self { args, frames, done: 0, pictures: 0, rendered, sight: None, said }
    }

    /// Renders `frame`, unless there is nothing to render or its picture is there already.
    fn frame(&mut self, frame: Frame, output: &Output, pool: &rayon::ThreadPool) -> Result<()> {
        let Frame { number, scene, held, problem, loading } = frame;
        self.done += 1;
        let Some(mut scene) = scene else {
            self.warn(number, &format!("{}; no picture", problem.as_deref().unwrap_or_default()));
            self.report(json!({ "frame": number, "state": "skipped", "problem": problem }));
            return Ok(());
        };
        scene.render.planning = self.args.plan;
        self.pictures += 1;
        if let (Some(held), Some(problem)) = (held, &problem) {
            self.warn(number, &format!("{problem}; frame {held} is rendered again"));
        }
        if self.args.resume && is_finished(output, &render::recipe(&scene, self.args)) {
            self.say(number, "finished by an earlier run");
            self.report(json!({ "frame": number, "state": "finished", "outputs": output.names() }));
            return Ok(());
        }
        self.say(number, &self.progress());
        self.tell(&scene);
        let start = Instant::now();
        let job = Job { args: self.args, output, pool, loading };
        let (picture, sight) = render::picture(&job, &scene, self.sight.take())?;
        self.sight = sight;
        self.rendered.0 += 1;
        self.rendered.1 += start.elapsed();
        let state = if held.is_some() { "held" } else { "rendered" };
        let mut report = json!({ "frame": number, "state": state });
        if let (Value::Object(report), Value::Object(picture)) = (&mut report, picture) {
            report.extend(held.map(|held| ("held".into(), json!(held))));
            report.extend(problem.map(|problem| ("problem".into(), json!(problem))));
            report.extend(picture);
        }
        self.report(report);
        if !self.args.run.json {
            output.names().iter().for_each(|name| console::result(name));
        }
        Ok(())
    }

    /// How far the sequence is, with about the time that is left by that of the frames so far.
    fn progress(&self) -> String {
        let place = format!("{} of {}", self.done, self.frames);
        let (count, time) = self.rendered;
        if count == 0 {
            return place;
        }
        let left = time.as_secs_f64() / f64::from(count) * (self.frames - self.done + 1) as f64;
        format!("{place}, about {} left", duration(left))
    }

    /// Prints what reading `scene` brought up that no earlier frame did.
    fn tell(&mut self, scene: &Scene) {
        if !self.args.run.quiet {
            for note in scene.notes.iter().filter(|note| self.said.insert((*note).clone())) {
                console::message(&format!("note: {note}"));
            }
        }
        let new = scene.warnings.iter().filter(|warning| self.said.insert((*warning).clone()));
        console::warn(&new.cloned().collect::<Vec<_>>());
    }

    fn say(&self, frame: i64, words: &str) {
        if !self.args.run.quiet {
            console::message(&format!("frame {frame}: {words}"));
        }
    }

    fn warn(&self, frame: i64, problem: &str) {
        console::warn(&[format!("frame {frame}: {problem}")]);
    }

    fn report(&self, report: Value) {
        if self.args.run.json {
            console::result(&report.to_string());
        }
    }
}

/// Whether `output` holds the picture that `recipe` makes, whole.
fn is_finished(output: &Output, recipe: &str) -> bool {
    // The PNG is written first, so that one beside a finished EXR belongs to it.
    let layers = if output.png.is_file() { read_layers(&output.exr).ok() } else { None };
    layers.is_some_and(|layers| layers.attributes.get(render::RECIPE).is_some_and(|r| r == recipe))
}

/// Seconds for people.
fn duration(seconds: f64) -> String {
    match seconds {
        s if s >= 5400.0 => format!("{:.1} h", s / 3600.0),
        s if s >= 90.0 => format!("{:.0} min", s / 60.0),
        s => format!("{s:.0} s"),
    }
}
