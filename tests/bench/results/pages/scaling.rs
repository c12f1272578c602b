//! How the cost of a render grows.

use serde::{Deserialize, Serialize};

use super::markdown::{NONE, decimals, figure, table, whole};

/// What was found of one sweep or render.
#[derive(Debug, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case")]
pub enum Row {
    /// One setting of a sweep.
    Point {
        /// What is varied.
        axis: String,
        /// A scene of `volumes/`.
        scene: String,
        /// Its value.
        x: f64,
        /// Whether light in the medium was kept on a lattice, and not with photons along the ray.
        lattice: bool,
        /// Processor seconds of photons, photon map and rays.
        stages: [f64; 3],
        /// Processor seconds of the render.
        whole: f64,
    },
    /// Slopes of a sweep: of the logarithm of the time over that of what is varied.
    Slope {
        /// What is varied.
        axis: String,
        /// A scene of `volumes/`.
        scene: String,
        /// From and to where, over all scenes.
        ends: [f64; 2],
        /// Of the whole render, over the upper half of the sweep.
        whole: Option<f64>,
        /// Of the stage that does the work, over all of the sweep.
        stage: Option<f64>,
    },
    /// The most memory that a render took.
    Memory {
        /// A scene of `volumes/`.
        scene: String,
        /// Its photons.
        photons: u64,
        /// At its peak, in MB.
        megabytes: f64,
    },
}

/// What is varied, and what slope is to be expected of the stage.
pub const AXES: [(&str, &str); 5] = [
    ("photons", "1: paths are independent"),
    ("pixels", "1, less where light on cells is found once"),
    ("rays a pixel", "below 1: rays of a pixel share gathers"),
    ("voxels", "1/3 at most: cells along a line"),
    ("optical thickness", "0 while thin, then up to 1"),
];

/// Scenes of `volumes/`.
pub const SCENES: [&str; 3] = ["smoke", "cloud", "road"];

/// A value of what is varied.
fn value(x: f64) -> String {
    if x < 1000.0 { figure(x, 2) } else { whole(x) }
}

/// Both tables.
pub fn tables(rows: &[Row]) -> String {
    let slope = |of: &str, in_scene: &str| {
        rows.iter().find_map(|row| match row {
            Row::Slope { axis, scene, ends, whole, stage } if axis == of && scene == in_scene => {
                Some((*ends, *whole, *stage))
            }
            _ => None,
        })
    };
    let lines = AXES.iter().map(|&(axis, expected)| {
        let of_scenes = SCENES.map(|scene| slope(axis, scene));
        let ends = of_scenes.iter().flatten().map(|found| found.0).next();
        let ends = ends
            .map_or_else(|| NONE.into(), |[from, to]| format!("{} to {}", value(from), value(to)));
        let cells = of_scenes.map(|found| {
            found.map_or_else(
                || NONE.into(),
                |(_, whole, stage)| format!("{} ({})", decimals(whole, 2), decimals(stage, 2)),
            )
        });
        [axis.to_owned(), ends].into_iter().chain(cells).chain([expected.to_owned()]).collect()
    });
    let slopes = table(
        &["against", "from, to", "smoke", "cloud", "road", "to be expected of the stage"],
        lines,
    );
    let memory = rows.iter().filter_map(|row| match row {
        Row::Memory { scene, photons, megabytes } => {
            Some(vec![scene.clone(), whole(*photons as f64), decimals(*megabytes, 0)])
        }
        _ => None,
    });
    let memory = table(&["scene", "photons", "peak of memory, MB"], memory);
    format!(
        "![Processor seconds against photons, pixels, rays, voxels and optical thickness]\
         (../../../volumes/scaling.svg)\n\n\
         One thing is varied, from 50,000 photons, 96 x 96 pixels and 2 rays. Slopes of the \
         logarithm of the whole time over the upper half of each sweep, and in brackets of the stage \
         that does the work, over all of it.\n\n{slopes}\n## Memory of many photons\n\
         What photons leave is kept on lattices; 32 x 24 pixels, one ray.\n\n{memory}"
    )
}
