//! A picture that is rendered in memory, and written where that is asked for.

use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use rayon::ThreadPool;
use serde_json::{Value, json};

use super::fit::Fit;
use super::header;
use super::load::{self, Preparation};
use super::memory_limit;
use super::output;
use super::partial;
use super::render_args::{Args, advice, early_denoiser, find_denoiser};
use super::report::{Seconds, about, report};
use super::shared_photons::SharedPhotons;
use crate::error::{Error, Result};
use crate::file;
use crate::image::{Film, View};
use crate::render::{
    self, Clock, Control, Earlier, Ended, Progress, ReachedError, Rendered, StatedError, Stop,
};
use crate::scene::{ErrorGoal, LoadOptions, OpenScene, Scene};
use crate::sequence::FrameTime;

/// A picture to render in memory.
pub(super) struct PictureRequest<'a> {
    /// How; what they say of files is left aside.
    pub(super) args: &'a Args,
    /// Of a sequence the frame.
    pub(super) frame: Option<f64>,
    /// Receives progress.
    pub(super) progress: &'a dyn Progress,
    /// Ends it early.
    pub(super) stop: &'a Stop,
}

/// A picture in memory, with all that its files say of it.
#[derive(Debug)]
pub struct PictureInMemory {
    /// The layers.
    pub film: Film,
    /// The error that it has, where that was the goal.
    pub error: Option<(ErrorGoal, StatedError)>,
    /// Settings, seconds of each stage, counters of work, warnings and notes, in JSON.
    pub report: Value,
    /// How the PNG shows it.
    view: View,
    /// Whether its colours are stored as half floats.
    half: bool,
    /// Attributes in the header of the EXR.
    attributes: Vec<(String, String)>,
}

impl PictureRequest<'_> {
    /// The scene `open` as `args` say, in a pool of threads, and the time that loading took.
    ///
    /// # Errors
    /// Where it cannot be loaded.
    pub(super) fn load(
        args: &Args,
        frame: Option<f64>,
        open: &mut OpenScene,
    ) -> Result<(Scene, ThreadPool, Preparation)> {
        let wrong =
            |frame| Error::Usage(format!("frame: found {frame}; give a number such as 12 or 12.5"));
        let time = |frame| FrameTime::nearest(frame).ok_or_else(|| wrong(frame));
        let options = LoadOptions { frame: frame.map(time).transpose()?, ..args.options() };
        let (mut scene, pool, preparation) = load::in_silence(open, options, &args.run)?;
        args.limits.set_part(&mut scene, args.reference)?;
        Ok((scene, pool, preparation))
    }

    /// Renders the scene `open`, with photons that are `shared` where it can.
    ///
    /// # Errors
    /// As `fogbow render`.
    pub(super) fn render(
        &self,
        open: &mut OpenScene,
        shared: &mut SharedPhotons,
    ) -> Result<PictureInMemory> {
        let Self { args, frame, progress, stop } = *self;
        let (clock, program) = (Clock::start(), memory_limit::program());
        let mut denoiser = early_denoiser(args)?;
        let (mut scene, pool, mut preparation) = Self::load(args, frame, open)?;
        if scene.film.deep {
            return Err(Error::Usage("film.deep: fogbow render alone writes deep pictures".into()));
        }
        find_denoiser(&mut denoiser, &scene)?;
        preparation.metering = load::meter(&mut scene, &pool)?;
        let mut warnings = [scene.warnings.clone(), advice(args, &scene)].concat();
        let named = args.photons.open(&mut scene)?;

        let (method, requested) = (args.method(), scene.render.photons);
        let start = Instant::now();
        let (memory, time) = (args.limits.memory, args.limits.time);
        let fit = Fit { memory, time, method, clock: &clock, start: Duration::ZERO, program };
        let common = pool.install(|| shared.of(args, &scene, progress))?;
        let sharing = start.elapsed();
        let photons = common.as_ref().or(named.as_ref());
        warnings.extend(pool.install(|| fit.photons(&mut scene, None, photons))?);
        let fitting = start.elapsed() - sharing;

        let deadline = fit.deadline(&scene);
        let control = Control { progress, stop: Some(stop), deadline, ..Control::silent() };
        let mut rendered = pool.install(|| {
            if args.reference {
                return Ok(render::render_reference(&scene, &scene.render, control));
            }
            let earlier = Earlier { photons, ..Earlier::default() };
            render::render_next(&scene, &scene.render, earlier, control)
        })?;
        if common.is_some() {
            rendered.timings.push(("shared photons", sharing));
        }
        let denoiser = denoiser.filter(|_| scene.render.denoise);
        if let Some(denoiser) = denoiser.as_ref().filter(|_| rendered.ended != Ended::Stopped) {
            rendered.denoise(denoiser)?;
        }
        warnings.extend(rendered.warnings());
        if rendered.ended == Ended::OutOfTime {
            let share = partial::share(&rendered);
            warnings.push(format!("the time is over: the picture has {share}"));
        }

        let settings = header::settings(&scene, Some(&rendered), args.reference, requested);
        let mut attributes = header::attributes(&scene, &settings, &rendered);
        attributes.extend(header::recipe_of(&scene, &rendered, method, requested));
        let seconds = Seconds { preparation, fitting, writing: None };
        let mut report = report(&scene, &rendered, settings, &seconds, &warnings);
        if rendered.film.denoiser().is_some() {
            report["denoiser"] = json!(denoiser.as_ref().map(about));
        }
        let Rendered { film, error, .. } = rendered;
        let stated = |ReachedError { goal, stated, .. }| stated.map(|stated| (goal, stated));
        let (error, view) = (error.and_then(stated), scene.film.shown());
        let half = scene.film.half;
        Ok(PictureInMemory { film, error, report, view, half, attributes })
    }
}

impl PictureInMemory {
    /// Writes the file that `fogbow render` writes: an EXR with all layers or a PNG of the view, by the ending of
    /// `path`.
    ///
    /// # Errors
    /// Where the path has another ending or cannot be written.
    pub fn save(&self, path: &Path) -> Result<()> {
        let bytes = match path.extension().map(OsStr::to_ascii_lowercase) {
            Some(ending) if ending == "exr" => {
                output::layers(path, &self.film, self.half, &self.attributes)?
            }
            Some(ending) if ending == "png" => output::shown(path, &self.film, &self.view)?,
            _ => {
                let problem = "give a path that ends in .exr or .png";
                return Err(Error::Usage(format!("{}: {problem}", path.display())));
            }
        };
        file::write(path, |out| std::io::Write::write_all(out, &bytes))
    }

    /// The bytes of a PNG of the view.
    ///
    /// # Errors
    /// Where it cannot be encoded.
    pub fn png(&self) -> Result<Vec<u8>> {
        output::shown(&PathBuf::from("picture.png"), &self.film, &self.view)
    }
}
