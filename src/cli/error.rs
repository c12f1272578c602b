//! `fogbow error`: every metric between two pictures.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use serde::Serialize;

use super::console;
use crate::error::{Error, Result};
use crate::image::{Image, read_exr};
use crate::study::metric::{Display, Errors, Options, check_pair, compare};
use crate::study::significant;

/// Significant digits of a figure in the table.
const DIGITS: usize = 5;

/// Tells how far a picture is from its reference, by every metric.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
VDP is Daly's model of 1993. It spreads the difference of a pixel over its neighbours. The localised
VDP (vdp_localized) is 0 where both pictures show the same luminance, as in the program HDR VDP from
version 1.5 on.
A VDP barely sees a global shift of brightness: read it beside the bias.")]
pub struct Args {
    /// The reference.
    #[arg(value_name = "A.exr")]
    pub reference: PathBuf,
    /// The picture that is tested against it.
    #[arg(value_name = "B.exr")]
    pub test: PathBuf,
    /// Exposure of what is shown on a display, in stops.
    #[arg(long, value_name = "STOPS", allow_negative_numbers = true, default_value_t = 0.0)]
    pub exposure: f64,
    /// Epsilon of the relative error, a radiance; half the reference's mean where none is given.
    #[arg(long, value_name = "L")]
    pub epsilon: Option<f64>,
    /// How the pictures are looked at.
    #[command(flatten)]
    pub viewing: ViewingArgs,
    /// Print figures and settings as one JSON object.
    #[arg(long)]
    pub json: bool,
}

/// How pictures are looked at.
#[derive(Debug, clap::Args)]
pub struct ViewingArgs {
    /// VDP: distance of the eye from the display in metres.
    #[arg(long, value_name = "M", default_value_t = Display::default().distance)]
    pub distance: f64,
    /// VDP: the display's diagonal in inches.
    #[arg(long, value_name = "INCHES", default_value_t = Display::default().diagonal)]
    pub diagonal: f64,
    /// VDP: the display's pixels across and down.
    #[arg(long, value_name = "WxH", default_value = "1280x1024", value_parser = resolution)]
    pub resolution: [u32; 2],
    /// VDP: luminance of the display's white in cd/m².
    #[arg(long, value_name = "CD/M2", default_value_t = Display::default().white)]
    pub white: f64,
    /// VDP: luminance of the display's black in cd/m², with the room's light on the glass.
    #[arg(long, value_name = "CD/M2", default_value_t = Display::default().black)]
    pub black: f64,
    /// FLIP: pixels a degree; 67.02 where none is given, as in NVIDIA's tool.
    #[arg(long, value_name = "N")]
    pub flip_ppd: Option<f64>,
    /// ColorVideoVDP: one of its authors' display models.
    #[arg(long, value_name = "NAME", default_value_t = Options::default().colorvideovdp_display)]
    pub cvvdp_display: String,
}

/// What `--json` prints.
#[derive(Debug, Serialize)]
struct Report<'a> {
    reference: &'a Path,
    test: &'a Path,
    size: [usize; 2],
    errors: &'a Errors,
    settings: &'a Options,
}

/// Prints the figures.
///
/// # Errors
/// Where a file cannot be read, the pictures cannot be compared or an option is out of range.
pub fn run(args: &Args) -> Result<()> {
    console::result(told(args, &read_exr(&args.reference)?, &read_exr(&args.test)?)?.trim_end());
    Ok(())
}

/// What `run` prints, of these pictures.
///
/// # Errors
/// Where the pictures cannot be compared or an option is out of range.
pub fn told(args: &Args, reference: &Image, test: &Image) -> Result<String> {
    let options = options(args);
    check_pair((reference, &args.reference), (test, &args.test))?;
    let errors = compare(reference, test, &options)?.errors;
    let report = Report {
        reference: &args.reference,
        test: &args.test,
        size: [reference.width(), reference.height()],
        errors: &errors,
        settings: &options,
    };
    if args.json {
        return serde_json::to_string_pretty(&report)
            .map_err(|e| Error::file(&args.test, format!("cannot be told as JSON: {e}")));
    }
    Ok(table(&report))
}

fn options(args: &Args) -> Options {
    let viewing = &args.viewing;
    let options = Options::default();
    Options {
        exposure: args.exposure,
        epsilon: args.epsilon,
        display: Display {
            resolution: viewing.resolution,
            diagonal: viewing.diagonal,
            distance: viewing.distance,
            white: viewing.white,
            black: viewing.black,
        },
        flip_pixels_per_degree: viewing.flip_ppd.unwrap_or(options.flip_pixels_per_degree),
        colorvideovdp_display: viewing.cvvdp_display.clone(),
    }
}

fn table(report: &Report<'_>) -> String {
    let Report { errors: e, settings, .. } = report;
    let mut out = format!(
        "{} against {}, {} x {} pixels\n",
        report.test.display(),
        report.reference.display(),
        report.size[0],
        report.size[1]
    );
    let mut section = |title: String, rows: &[(&str, Option<f64>, &str)]| {
        // Writing to a string cannot fail.
        let _ = writeln!(out, "\n{title}");
        for (name, value, unit) in rows {
            let value = value.map_or_else(|| "-".into(), |v| significant(v, DIGITS));
            let _ = writeln!(out, "  {name:<26}{value:>12}{unit}");
        }
    };
    section(
        "linear radiance".into(),
        &[
            ("MSE", Some(e.mse), ""),
            ("RMSE", Some(e.rmse), ""),
            ("MAE", Some(e.mae), ""),
            ("relative MSE", e.relative_mse, ""),
            ("  without the worst 0.1 %", e.relative_mse_trimmed, ""),
            ("  epsilon", e.epsilon, ""),
            ("bias, mean difference", Some(e.mean_difference), ""),
            ("bias, mean ratio", e.mean_ratio, ""),
            ("HDR-FLIP", e.flip_hdr, ""),
        ],
    );
    section(
        format!("as an sRGB display shows it, exposed by {} stops", settings.exposure),
        &[
            ("MSE of 8-bit codes", Some(e.code_mse_percent), " %"),
            ("pixels in error", Some(e.code_pixels_percent), " %"),
            ("VDP, average", Some(e.vdp_mean_percent), " %"),
            ("VDP, pixels P > 0.75", Some(e.vdp_visible_percent), " %"),
            ("VDP localised, average", Some(e.vdp_localized_mean_percent), " %"),
            ("VDP localised, P > 0.75", Some(e.vdp_localized_visible_percent), " %"),
            ("SSIM", e.ssim, ""),
            ("LDR-FLIP", Some(e.flip_ldr), ""),
            ("ColorVideoVDP", e.colorvideovdp_jod, " JOD"),
        ],
    );
    let display = &settings.display;
    let _ = write!(
        out,
        "\nVDP for {}x{} pixels on {} inch at {} m, {} to {} cd/m²; FLIP for {:.2} pixels a \
         degree; ColorVideoVDP for {}",
        display.resolution[0],
        display.resolution[1],
        display.diagonal,
        display.distance,
        display.black,
        display.white,
        settings.flip_pixels_per_degree,
        settings.colorvideovdp_display
    );
    out
}

fn resolution(text: &str) -> Result<[u32; 2], String> {
    let sides =
        text.split_once(['x', 'X']).and_then(|(w, h)| Some([w.parse().ok()?, h.parse().ok()?]));
    sides.filter(|[w, h]| *w > 0 && *h > 0).ok_or_else(|| "give pixels as 1280x1024".into())
}
