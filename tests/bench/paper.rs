//! fogbow's figures for its four scenes after Anson, Sundstedt, Gutierrez and Chalmers 2006,
//! "Efficient Selective Rendering of Participating Media", beside the paper's: Figure 5 and
//! Tables 1 and 2, as `volumes/PAPER.md`.
//!
//!     cargo bench --bench paper                # all of it, about an hour
//!     cargo bench --bench paper -- --quick     # tiny pictures, to target/paper/quick.md
//!
//! Every trial is kept in `target/paper`: killed, the same command goes on where it was.

#![allow(clippy::print_stdout)] // what is written is told

use std::error::Error;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use fogbow::render::Silent;
use fogbow::scene::{LoadOptions, Scene};
use fogbow::study::{Metric, PointResult, Request, Results, Study, significant, write_report};

/// Titles and files.
const SCENES: [(&str, &str); 4] =
    [("Balls A", "balls_a"), ("Balls B", "balls_b"), ("Lucy", "lucy"), ("Road", "road")];

/// The paper's way, and fogbow's own.
const WAYS: [&str; 2] = ["xs-paper", "xs-scattering"];

fn main() -> Result<(), Box<dyn Error>> {
    let quick = std::env::args().any(|word| word == "--quick");
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let target = target(root);
    let mut all = Vec::new();
    for (title, name) in SCENES {
        let folder = target.join(format!("{name}{}", if quick { "-quick" } else { "" }));
        let results = measured(&root.join(format!("volumes/{name}.toml")), &folder, quick)?;
        write_report(&results, &folder)?;
        println!("{title}: {}", folder.join("report.html").display());
        all.push((title, results));
    }
    let path = if quick { target.join("quick.md") } else { root.join("volumes/PAPER.md") };
    std::fs::write(&path, page(&all, quick)?)?;
    println!("{}", path.display());
    Ok(())
}

/// The folder for all trials.
fn target(root: &Path) -> PathBuf {
    let target = std::env::var_os("CARGO_TARGET_DIR").map_or(root.join("target"), PathBuf::from);
    target.join("paper")
}

fn measured(path: &Path, folder: &Path, quick: bool) -> Result<Results, Box<dyn Error>> {
    let mut options = LoadOptions::default();
    if quick {
        let whole = Scene::load(path, &options)?;
        options = options.size(whole.film.size.map(|side| side / 8)).photons(20_000);
    }
    let scene = Scene::load(path, &options)?;
    let request = Request {
        candidates: WAYS.map(str::to_owned).to_vec(),
        budgets: vec![scene.render.rays],
        seeds: if quick { 2 } else { 4 },
        metric: Metric::CodeMse,
        ..Request::default()
    };
    let resume = folder.join("study.json").exists();
    let study = Study::new(&scene, folder, &request, resume)?;
    Ok(study.run("cargo bench --bench paper", &Silent)?)
}

fn page(all: &[(&str, Results)], quick: bool) -> Result<String, std::fmt::Error> {
    let first = &all[0].1;
    let mut out = String::from("# fogbow beside the paper\n");
    let command = if quick { " -- --quick" } else { "" };
    writeln!(
        out,
        "Made by `cargo bench --bench paper{command}` with fogbow {} on {}: means of {} seeds, \
         intervals at 95 %. The gold standard has {} rays in every pixel. `xs-paper` directs as \
         Anson, Sundstedt, Gutierrez and Chalmers 2006 do: X from transmittance, X and S in equal \
         parts, rays alone. `xs-scattering` is fogbow's own: X from scattered light, with gather \
         radius and march step directed as well. The scenes follow the paper's but are not its \
         own, nor are renderer and machine.",
        first.version, first.machine, first.plan.seeds, first.gold.rays
    )?;
    if quick {
        writeln!(out, "\nTINY PICTURES: these figures only show that the command works.")?;
    }
    writeln!(
        out,
        "\nOf the paper's figures only ranges over its scenes are at hand, and that \"the average \
         pixel errors of these metric are all less than 1%\" (its abstract); what it gives for \
         each scene is not, and its columns say so.\n"
    )?;

    writeln!(out, "## Figure 5: run times\n")?;
    let head = "scene | gold, s | `xs-paper`, s | times faster | `xs-scattering`, s | times faster";
    table(
        &mut out,
        head,
        "5.2 to 10.3 times faster over its scenes; each is not at hand",
        all,
        |r| {
            let mut cells = vec![seconds(point(r, "gold"))];
            for way in WAYS {
                cells.push(seconds(point(r, way)));
                cells.push(point(r, way).and_then(speed_up).unwrap_or_else(|| "–".into()));
            }
            cells
        },
    )?;

    writeln!(out, "\n## Table 1: squared error\n")?;
    writeln!(
        out,
        "In percent of the largest: the average over pixels of the squared difference of 8-bit \
         sRGB codes, and the share of pixels in which a code differs.\n"
    )?;
    let head = "scene | `xs-paper`, average | pixels | `xs-scattering`, average | pixels";
    table(
        &mut out,
        head,
        "0.10 to 0.87 % on average over its scenes; pixels not at hand",
        all,
        |r| errors(r, [Metric::CodeMse, Metric::CodePixels]),
    )?;

    writeln!(out, "\n## Table 2: visible differences\n")?;
    writeln!(
        out,
        "In percent, by the visible differences predictor (Daly 1993): the average chance of \
         seeing a difference in a pixel, and the share of pixels in which it is above 75 %.\n"
    )?;
    let head = "scene | `xs-paper`, average | P > 75 % | `xs-scattering`, average | P > 75 %";
    table(&mut out, head, "below 1 % on average; P > 75 % not at hand", all, |r| {
        errors(r, [Metric::VdpMean, Metric::VdpVisible])
    })?;

    writeln!(
        out,
        "\n## Table 3: people\n\nFive of the paper's counts of right answers are at hand, 16, 17, \
         20, 21 and 22 of 24, with chi-squares of 2.67, 4.17, 10.67, 13.5 and 16.67, but not which \
         scene and condition they belong to. `fogbow trial` makes the same experiment; nobody has \
         sat it yet."
    )?;
    Ok(out)
}

/// A row for each scene, with what is known of the paper in the last column.
fn table(
    out: &mut String,
    head: &str,
    paper: &str,
    all: &[(&str, Results)],
    cells: impl Fn(&Results) -> Vec<String>,
) -> std::fmt::Result {
    let columns = head.split('|').count() + 1;
    writeln!(out, "| {head} | the paper |\n|{}", " --- |".repeat(columns))?;
    for (title, results) in all {
        writeln!(out, "| {title} | {} | {paper} |", cells(results).join(" | "))?;
    }
    Ok(())
}

fn point<'a>(results: &'a Results, name: &str) -> Option<&'a PointResult> {
    results.points.iter().find(|point| point.candidate == name)
}

fn seconds(point: Option<&PointResult>) -> String {
    point.map_or_else(|| "–".into(), |p| significant(p.seconds.estimate, 3))
}

fn speed_up(point: &PointResult) -> Option<String> {
    let interval = point.speed_up.as_ref()?;
    let range = interval.range.map_or_else(String::new, |range| {
        let [low, high] = range.map(|v| significant(v, 3));
        format!(" ({low} to {high})")
    });
    Some(format!("{}{range}", significant(interval.estimate, 3)))
}

/// Both errors of each way, means over seeds against the gold standard.
fn errors(results: &Results, metrics: [Metric; 2]) -> Vec<String> {
    let mean = |way: &str, metric: Metric| {
        let trials = &point(results, way)?.trials;
        let each = trials.iter().map(|t| metric.of(t.errors.get("gold")?));
        let each: Vec<f64> = each.collect::<Option<_>>()?;
        Some(significant(each.iter().sum::<f64>() / each.len() as f64, 3))
    };
    WAYS.iter()
        .flat_map(|way| metrics.map(|metric| mean(way, metric).unwrap_or_else(|| "–".into())))
        .collect()
}
