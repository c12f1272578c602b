//! Arguments of `fogbow render`, and what they mean for one picture as for a sequence.

use std::io::Write as _;
use std::path::{Path, PathBuf};

use clap::builder::{PossibleValuesParser, TypedValueParser};

use super::console;
use super::film_args::FilmArgs;
use super::frames::FrameArgs;
use super::header::Method;
use super::limit_args::LimitArgs;
use super::live::LiveArgs;
use super::load;
use super::look::LookArgs;
use super::photon_args::PhotonArgs;
use super::picture::PictureReport;
use super::settings::{PathArgs, RunArgs, SettingArgs};
use crate::error::{Error, Result};
use crate::file;
use crate::image::Denoiser;
use crate::scene::plan::RenderPlan;
use crate::scene::{self, LoadOptions, Planning, Scene};

/// Arguments of `fogbow render`.
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    #[command(flatten)]
    pub(super) paths: PathArgs,
    #[command(flatten)]
    pub(super) settings: SettingArgs,
    /// Render without bias, by path tracing: slow, to measure against.
    #[arg(long, conflicts_with = "reconstruct")]
    pub(super) reference: bool,
    #[command(flatten)]
    pub(super) film: FilmArgs,
    /// Write the scene that is rendered for a VDB file alone, with a sentence on every key.
    #[arg(long, value_name = "OUT.toml")]
    pub(super) write_scene: Option<PathBuf>,
    #[command(flatten)]
    pub(super) look: LookArgs,
    /// Work to do: what the scene needs, or for tests everything all the same.
    #[arg(long, hide = true, value_name = "WHAT", default_value = "needed",
        value_parser = PossibleValuesParser::new(["needed", "everything"]).map(planning))]
    pub(super) plan: Planning,
    #[command(flatten)]
    pub(super) limits: LimitArgs,
    #[command(flatten)]
    pub(super) live: LiveArgs,
    #[command(flatten)]
    pub(super) photons: PhotonArgs,
    #[command(flatten)]
    pub(super) frames: FrameArgs,
    #[command(flatten)]
    pub(super) run: RunArgs,
    /// Say first what the scene needs and what is left out.
    #[arg(short, long, conflicts_with = "quiet")]
    pub(super) verbose: bool,
}

impl Args {
    /// The file of `-o`.
    ///
    /// # Errors
    /// Where none is given.
    pub(super) fn output(&self) -> Result<&Path> {
        let missing = || Error::Usage("-o OUT.exr is missing; name the picture".into());
        self.paths.output.as_deref().ok_or_else(missing)
    }

    /// Settings that override the scene file's, and the look of a VDB file alone.
    pub(super) fn options(&self) -> LoadOptions {
        let options = self.film.apply(load::options(&self.settings, &self.look));
        LoadOptions { memory: self.limits.memory, planning: self.plan, ..options }
    }

    /// How pictures are rendered.
    pub(super) const fn method(&self) -> Method {
        Method { reference: self.reference, level_set_as_fog: self.look.level_set_as_fog() }
    }
}

/// Writes the scene that was made for a VDB file alone, with the settings and exposure of the render, where
/// `--write-scene` is given.
pub(super) fn write_scene(args: &Args, scene: &Scene) -> Result<()> {
    let Some(path) = &args.write_scene else { return Ok(()) };
    let Some(made) = &scene.made else {
        return Err(Error::Usage(format!(
            "--write-scene is for VDB files alone; {} is a scene already",
            args.paths.scene.display()
        )));
    };
    let mut options = args.options();
    if let Some(exposure) = scene.film.exposure {
        options = options.with("film.exposure", format!("{exposure:?}"));
    }
    let mut draft = made.draft.clone().with(&options.settings);
    draft.set_file(&from_folder_of(path, &args.paths.scene));
    file::write(path, |out| out.write_all(draft.text().as_bytes()))
}

/// How a scene in `scene` names `volume`: by its own name in the same folder, else by its whole path.
fn from_folder_of(scene: &Path, volume: &Path) -> String {
    let folder = |path: &Path| {
        let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
        folder.unwrap_or(Path::new(".")).canonicalize().ok()
    };
    let name = volume.file_name().unwrap_or_default();
    match (folder(scene), folder(volume)) {
        (Some(scene), Some(volume)) if scene != volume => volume.join(name),
        _ => PathBuf::from(name),
    }
    .to_string_lossy()
    .into_owned()
}

/// The plan of a render of `scene` in one line, with `--verbose`.
pub(super) fn plan(args: &Args, scene: &Scene) -> Option<String> {
    let prints = args.verbose && !args.reference;
    prints.then(|| RenderPlan::new(scene, &scene.render).line())
}

/// The denoiser that `--denoise` needs, found before anything is loaded.
///
/// # Errors
/// As [`Denoiser::find`].
pub(super) fn early_denoiser(args: &Args) -> Result<Option<Denoiser>> {
    args.film.denoise.then(Denoiser::find).transpose()
}

/// Finds a denoiser where `scene` is denoised and none was found yet. Returns whether it is denoised.
///
/// # Errors
/// As [`Denoiser::find`].
pub(super) fn find_denoiser(denoiser: &mut Option<Denoiser>, scene: &Scene) -> Result<bool> {
    let denoises = scene.render.denoise;
    if denoises && denoiser.is_none() {
        *denoiser = Some(Denoiser::find()?);
    }
    Ok(denoises)
}

/// A note that names the denoiser.
pub(super) fn note(denoiser: &Denoiser) -> String {
    format!("note: {denoiser} takes the noise off: {}", denoiser.path().display())
}

/// Warnings about settings that do not suit `scene`.
pub(super) fn advice(args: &Args, scene: &Scene) -> Vec<String> {
    if args.reference { Vec::new() } else { scene::advice(scene) }
}

/// Prints the report on a picture, or its files.
pub(super) fn print_report(args: &Args, picture: &PictureReport) {
    if args.run.json {
        console::result(&picture.report.to_string());
    } else {
        picture.output.names().iter().for_each(|name| console::result(name));
    }
}

fn planning(name: String) -> Planning {
    if name == "everything" { Planning::Everything } else { Planning::Needed }
}
