//! `fogbow merge`: one picture of crops and passes that were rendered apart.

mod attributes;
mod part;
mod pass;
mod read_ahead;

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use rayon::prelude::*;
use serde_json::json;

use super::console;
use super::interrupt::Interrupt;
use super::output::Output;
use crate::error::{Error, Result};
use crate::image::merge::{LayerMerge, pass_weights};
use crate::image::{Channels, Layers, Picture, View, exr_picture_bytes, png_bytes};
use part::Part;
use pass::Pass;

/// Arguments of `fogbow merge`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Parts with the same seed are crops that fill the frame. The merged picture has their pixels bit for bit \
and the header of the whole, with the work of all crops.\n\n\
Parts with different seeds are passes: frames, whole or in crops. The merged picture is their mean, \
weighed by rays and photons as they were asked for, never by measured noise. The layer rays is the sum, Z \
the nearest, variance that of the mean by the spread between passes. fogbow:passes in the header lists \
them.\n\n\
Parts of --pass 1/N to N/N are equal passes of one picture, whole or in crops. All must be there; their mean \
has the rays and photons of the picture.\n\n\
The order of parts changes no byte. Parts of another scene, version or settings, unfinished ones, gaps and \
overlaps are refused.")]
pub(super) struct Args {
    /// Pictures of fogbow render: crops that fill the frame, frames with different seeds, or equal passes.
    #[arg(value_name = "PART.exr", required = true)]
    parts: Vec<PathBuf>,
    /// The EXR to write, which is none of the parts; a PNG is written beside it.
    #[arg(short, long, value_name = "OUT.exr")]
    output: PathBuf,
    /// Print size, passes with their weights, work and paths as one JSON object.
    #[arg(long)]
    json: bool,
}

/// Merges the parts and writes the picture.
///
/// # Errors
/// Where a part cannot be read, is unfinished or does not fit the others, where parts leave gaps or overlap, the
/// picture cannot be written, or a signal comes before that.
pub(super) fn run(args: &Args) -> Result<()> {
    check_output(args)?;
    let output = Output::check(&args.output)?;
    let interrupt = Interrupt::listen()?;
    interrupt.defer();
    let parts: Vec<_> = args.parts.par_iter().map(|path| Part::read(path)).collect();
    let parts = parts.into_iter().collect::<Result<Vec<_>>>()?;
    let passes = pass::group(parts)?;
    let works: Vec<_> = passes.iter().map(Pass::work).collect();
    let weights = pass_weights(&works);
    let attributes = attributes::merged(&passes, &weights)?;
    let warnings = pass::warnings(&passes);
    console::warn(&warnings);

    let channels = merged_channels(&passes, &weights, &interrupt)?;
    let first = passes[0].first();
    let [width, height] = first.size.map(|side| side as usize);
    let (corner, display) = ([0, 0], [width, height]);
    let merged = Layers { width, height, corner, display, channels, attributes };
    let all = || passes.iter().flat_map(|pass| &pass.parts);
    let is_half = |name: &&str| all().all(|part| part.half().contains(&(*name).to_owned()));
    let half = merged.channels.keys().map(String::as_str).filter(is_half).collect();
    let png = write(&output, &merged, &half, first.view())?;
    let names = output.names();
    let written = if png { &names[..] } else { &names[..1] };
    if args.json {
        let report = json!({
            "size": first.size,
            "parts": args.parts.len(),
            "passes": attributes::passes(&passes, &weights),
            "work": attributes::work(&passes)?,
            "warnings": warnings,
            "outputs": written,
        });
        console::result(&report.to_string());
    } else {
        written.iter().for_each(|name| console::result(name));
    }
    Ok(())
}

/// Refuses an output that is one of the parts.
fn check_output(args: &Args) -> Result<()> {
    let place = |path: &Path| path.canonicalize().ok();
    let output = place(&args.output);
    match args.parts.iter().find(|part| output.is_some() && place(part) == output) {
        None => Ok(()),
        Some(part) => Err(Error::Usage(format!(
            "-o {}: is the part {}; name another file",
            args.output.display(),
            part.display()
        ))),
    }
}

/// The channels of all parts merged. A signal ends it before the next part is read.
fn merged_channels(passes: &[Pass], weights: &[f64], interrupt: &Interrupt) -> Result<Channels> {
    let first = passes[0].first();
    let mut merge = LayerMerge::new(first.size, &first.layers, passes.len()).map_err(|layer| {
        let problem = format!("layer \"{layer}\" is none that passes can be merged of");
        Error::file(&first.path, problem)
    })?;
    let go_on = || {
        if interrupt.stop().is_asked() {
            let message = "interrupted: nothing is written, and files are as they were".into();
            return Err(Error::Interrupted { message, code: interrupt.exit_code() });
        }
        Ok(())
    };
    let parts: Vec<_> = passes.iter().flat_map(|pass| &pass.parts).collect();
    let mut of_passes = passes.iter().zip(weights).flat_map(|(pass, weight)| {
        (0..pass.parts.len()).map(move |index| (index == 0).then_some(*weight))
    });
    read_ahead::each(&parts, go_on, |part, layers| {
        if let Some(weight) = of_passes.next().flatten() {
            merge.begin_pass(weight);
        }
        merge.add(part.window, layers);
    })?;
    go_on()?;
    Ok(merge.finish())
}

/// Writes the picture `merged`, those of its layers that are in `half` as half floats. Returns whether there is a PNG: only
/// where the parts say how it is viewed.
fn write(
    output: &Output,
    merged: &Layers,
    half: &BTreeSet<&str>,
    view: Option<View>,
) -> Result<bool> {
    let named: Vec<_> =
        merged.channels.iter().map(|(name, values)| (name.as_str(), values.as_slice())).collect();
    let attributes: Vec<_> =
        merged.attributes.iter().map(|(name, value)| (name.as_str(), value.clone())).collect();
    let picture = view.zip(merged.image()).map(|(view, image)| Picture::developed(&image, &view));
    let (png, exr) = rayon::join(
        || picture.map(|picture| png_bytes(&output.png, &picture)).transpose(),
        || exr_picture_bytes(&output.exr, merged.display, &named, &attributes, half),
    );
    let png = png?;
    output.write_bytes(&exr?, png.as_deref())?;
    Ok(png.is_some())
}
