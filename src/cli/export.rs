//! `fogbow export`.

use std::collections::BTreeMap;
use std::io::Write as _;
use std::path::{Path, PathBuf};

use super::console;
use super::settings::SettingArgs;
use crate::error::{Error, Result};
use crate::file;
use crate::scene::{LoadOptions, read_shot};
use crate::sequence::FrameTime;
use crate::shape::write_ply;

/// Arguments of `fogbow export`.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Meshes are written as PLY files into a folder beside the scene, one for each material, and so are \
    VDB files and pictures of a package (.usdz). Others are named where they are."
)]
pub(super) struct Args {
    /// A shot (.usd, .usda, .usdc, .usdz).
    #[arg(value_name = "SHOT.usd")]
    shot: PathBuf,
    /// The scene to write.
    #[arg(short, long, value_name = "SCENE.toml")]
    output: PathBuf,
    /// The frame; by default the first.
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    frame: Option<i64>,
    /// The camera, by its path or its name; by default the first.
    #[arg(long, value_name = "PRIM")]
    camera: Option<String>,
    #[command(flatten)]
    settings: SettingArgs,
    /// Print no notes.
    #[arg(long)]
    quiet: bool,
}

/// Writes the scene and its meshes.
pub(super) fn run(args: &Args) -> Result<()> {
    let settings = args.settings.settings.clone();
    let (frame, camera) = (args.frame.map(FrameTime::from), args.camera.clone());
    let options = LoadOptions { settings, frame, camera, ..LoadOptions::default() };
    let made = read_shot(&args.shot, &options)?;
    if !args.quiet {
        made.notes.iter().for_each(|note| console::message(&format!("note: {note}")));
    }
    console::warn(&made.warnings);
    let folder = args.output.parent().unwrap_or(Path::new(""));
    let beside = format!("{}_files", args.output.file_stem().unwrap_or_default().to_string_lossy());
    let mut names = BTreeMap::new();
    for (name, mesh) in made.files.meshes() {
        let file = Path::new(name).file_name().unwrap_or_default();
        let target = Path::new(&beside).join(file);
        folder_for(&folder.join(&target))?;
        write_ply(&folder.join(&target), mesh)?;
        names.insert(name.to_owned(), shown(&target));
    }
    for (name, path) in made.files.assets() {
        let target = if made.files.is_packed(path) {
            if !path.is_file() {
                let problem = format!("{name}: no such file in the package");
                return Err(Error::file(&args.shot, problem));
            }
            let target = Path::new(&beside).join(name);
            folder_for(&folder.join(&target))?;
            copy(path, &folder.join(&target))?;
            target
        } else {
            let absolute = std::path::absolute(path).unwrap_or_else(|_| path.into());
            let here = std::path::absolute(if folder.as_os_str().is_empty() {
                Path::new(".")
            } else {
                folder
            });
            let below =
                here.ok().and_then(|here| absolute.strip_prefix(here).ok().map(Path::to_path_buf));
            below.unwrap_or(absolute)
        };
        names.insert(name.to_owned(), shown(&target));
    }
    let mut draft = made.draft.clone().with(&options.settings);
    draft.rename(&names);
    file::write(&args.output, |out| out.write_all(draft.text().as_bytes()))
}

fn shown(path: &Path) -> String {
    path.to_string_lossy().into_owned()
}

/// Makes the folder of `path`.
fn folder_for(path: &Path) -> Result<()> {
    let folder = path.parent().unwrap_or(Path::new(""));
    std::fs::create_dir_all(folder)
        .map_err(|e| Error::file(folder, format!("cannot be made: {e}; give another -o")))
}

fn copy(from: &Path, to: &Path) -> Result<()> {
    let mut source = file::open(from)?;
    file::write(to, |out| std::io::copy(&mut source, out).map(drop))
}
