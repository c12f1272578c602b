//! Studies of directors at equal time.

use std::path::PathBuf;

use fogbow::render::Silent;
use fogbow::scene::{LoadOptions, Scene};
use fogbow::study::{CANDIDATES, Estimate, Metric, Request, Results, Study};

use super::Kept;
use super::scenes::shipped;
use crate::pages::Result;
use crate::pages::equal_time::Row;

/// A scene as it is studied.
struct Subject {
    title: &'static str,
    name: &'static str,
    size: [u32; 2],
    seeds: u32,
    metric: Metric,
    /// Whether all candidates but those of photons and variance are studied.
    all: bool,
}

const SMALL: [u32; 2] = [128, 128];

const FEW: [&str; 5] = ["fixed", "x-transmittance", "x-scattering", "xs-scattering", "xs-paper"];

const SUBJECTS: [Subject; 7] = {
    const fn few(
        title: &'static str,
        name: &'static str,
        size: [u32; 2],
        metric: Metric,
    ) -> Subject {
        Subject { title, name, size, seeds: 3, metric, all: false }
    }
    [
        Subject {
            title: "smoke",
            name: "smoke",
            size: [192, 192],
            seeds: 8,
            metric: Metric::RelativeMse,
            all: true,
        },
        few("Lucy", "lucy", SMALL, Metric::RelativeMse),
        few("Road", "road", [128, 72], Metric::RelativeMse),
        few("cloud", "cloud", SMALL, Metric::RelativeMse),
        few("fire", "fire", SMALL, Metric::RelativeMse),
        few("Balls A", "balls_a", SMALL, Metric::RelativeMseTrimmed),
        few("Balls B", "balls_b", SMALL, Metric::RelativeMseTrimmed),
    ]
};

/// A part a scene.
pub fn measure(kept: &mut Kept<Row>, quick: bool) -> Result<()> {
    for subject in &SUBJECTS[..if quick { 2 } else { SUBJECTS.len() }] {
        let folder = kept.folder(subject.name);
        kept.part(subject.title, || Ok(rows(subject, &studied(subject, folder, quick)?)))?;
    }
    Ok(())
}

/// The study in `folder`, gone on with where it was cut short.
fn studied(subject: &Subject, folder: PathBuf, quick: bool) -> Result<Results> {
    let options = LoadOptions::default().rays(16);
    let options = if quick {
        options.size([32, 32]).photons(5_000)
    } else {
        options.size(subject.size).photons(100_000)
    };
    let scene = Scene::load(&shipped(subject.name), &options)?;
    let candidates: Vec<String> = if subject.all && !quick {
        let names = CANDIDATES.iter().map(|(name, _)| *name);
        names
            .filter(|name| !name.contains("photons") && *name != "variance")
            .map(String::from)
            .collect()
    } else {
        FEW.map(String::from).to_vec()
    };
    let request = Request {
        candidates,
        budgets: vec![16, 8, 4],
        seeds: if quick { 2 } else { subject.seeds },
        metric: subject.metric,
        ..Request::default()
    };
    let resume = folder.join("study.json").exists();
    let study = Study::new(&scene, &folder, &request, resume)?;
    Ok(study.run("cargo bench --bench results -- --only equal-time", &Silent)?)
}

fn rows(subject: &Subject, results: &Results) -> Vec<Row> {
    let points = results.points.iter().filter_map(|point| {
        Some(Row::Point {
            scene: subject.title.into(),
            candidate: point.candidate.clone(),
            rays: point.settings.rays,
            seconds: point.seconds.estimate,
            error: point.errors.get("gold")?.error.estimate,
            metric: subject.metric.title().into(),
        })
    });
    let parts = results.ablation.iter().filter_map(|effect| {
        let Estimate::Found(gain) = &effect.error_gain else { return None };
        Some(Row::Part {
            scene: subject.title.into(),
            part: effect.part.clone(),
            with: effect.with.clone(),
            without: effect.without.clone(),
            gain: gain.estimate,
            range: gain.range,
        })
    });
    points.chain(parts).collect()
}
