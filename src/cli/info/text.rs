//! The report as text.

use std::fmt::Write as _;

use super::{GridReport, Report};

/// Significant digits of every figure.
const DIGITS: usize = 4;

/// A number with [`DIGITS`] significant digits at most, and no zeros at the end; with an exponent
/// where it would be long otherwise.
pub(super) fn figure(x: f64) -> String {
    let rounded: f64 = format!("{x:.*e}", DIGITS - 1).parse().unwrap_or(x);
    let magnitude = rounded.abs();
    if rounded == 0.0 || (1e-3..1e6).contains(&magnitude) || !rounded.is_finite() {
        (rounded + 0.0).to_string() // + 0.0 loses a minus zero
    } else {
        format!("{rounded:e}")
    }
}

fn figures(numbers: impl IntoIterator<Item = f64>) -> String {
    format!("[{}]", numbers.into_iter().map(figure).collect::<Vec<_>>().join(", "))
}

/// The whole report.
pub(super) fn readable(report: &Report) -> String {
    let mut out = String::new();
    // Writing to a string cannot fail.
    let _ = writeln!(out, "{}", report.summary);
    let _ = writeln!(
        out,
        "{}: OpenVDB format {}, written by OpenVDB {}, read by OpenVDB {}; {} grid(s)",
        report.file.display(),
        report.format_version,
        report.library_version,
        report.reader_version,
        report.grids.len()
    );
    for grid in &report.grids {
        let _ = describe(&mut out, grid);
    }
    let _ = match (&report.density, &report.problem) {
        (Some(name), _) => writeln!(out, "\ndensity where none is named: \"{name}\""),
        (None, Some(problem)) => writeln!(out, "\nno density where none is named: {problem}"),
        _ => Ok(()),
    };
    let of_contents = report.contents.iter().flat_map(|contents| &contents.notes);
    for note in report.notes.iter().chain(of_contents) {
        let _ = writeln!(out, "note: {note}");
    }
    out
}

fn describe(out: &mut String, grid: &GridReport) -> std::fmt::Result {
    let info = &grid.info;
    let half = if info.half { ", stored in 16 bits" } else { "" };
    writeln!(out, "\n\"{}\": {}, {}{half}", grid.label, info.value_type, info.class)?;
    let mut line = |key: &str, text: String| writeln!(out, "  {key:<12}{text}");
    line("compression", info.compression.clone())?;
    if let Some(s) = &grid.statistics {
        line(
            "voxels",
            format!(
                "{} active ({} leaves; {} active tiles with {} voxels)",
                s.active, s.leaves, s.active_tiles, s.tile_voxels
            ),
        )?;
        let [min, max, mean] = [s.min, s.max, s.mean].map(figure);
        line("values", format!("{min} to {max}, mean {mean}, {} zeros", s.zeros))?;
        if s.bad.total() > 0 && !info.is_level_set() {
            let bad = s.bad;
            line(
                "bad values",
                format!(
                    "{} NaN, {} infinite, {} negative; as density they are taken as 0",
                    bad.nan, bad.infinite, bad.negative
                ),
            )?;
        }
        let bounds = s.bounds.map(|[a, b]| format!("{a:?} to {b:?}"));
        line("index box", bounds.unwrap_or_else(|| "empty".into()))?;
    }
    if let Some([a, b]) = grid.world_bounds {
        line("world box", format!("{} to {} m", figures(a), figures(b)))?;
    }
    let turned = if grid.rotated { ", rotated or skewed" } else { "" };
    let mirrored = if grid.mirrored { ", mirrored" } else { "" };
    let size = grid.voxel_size.map_or(String::new(), |s| format!(", voxel size {} m", figures(s)));
    line("transform", format!("{}{size}{turned}{mirrored}", info.map))?;
    if let Some(background) = &grid.background {
        line("background", figures(background.iter().map(|&x| f64::from(x))))?;
    }
    if let Some(bytes) = grid.memory_bytes {
        line("memory", format!("{} MiB", figure(bytes as f64 / f64::from(1 << 20))))?;
    }
    line("fogbow", grid.verdict.clone())
}

#[cfg(test)]
mod tests {
    use super::figure;

    #[test]
    fn figures_have_four_digits() {
        for (x, text) in [
            (0.0, "0"),
            (-0.0, "0"),
            (1.0, "1"),
            (0.476_190_47, "0.4762"),
            (105.238, "105.2"),
            (-12.345_6, "-12.35"),
            (123_456.0, "123500"),
            (0.1f32.into(), "0.1"),
            (9999.7, "10000"),
            (999_999.0, "1e6"),
            (1.001_36e-5, "1.001e-5"),
            (-1.234_56e12, "-1.235e12"),
            (0.001, "0.001"),
            (f64::NAN, "NaN"),
            (f64::INFINITY, "inf"),
        ] {
            assert_eq!(figure(x), text);
        }
    }
}
