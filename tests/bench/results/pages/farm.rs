//! Parts of a picture on a farm: whether passes are worth the whole, and how far many nodes help.

use fogbow::study::Interval;
use serde::{Deserialize, Serialize};

use super::farm_model::{Kind, MOST_NODES, START_UP, efficient_nodes, simulated, speed_up, times};
use super::markdown::{NONE, decimals, figure, interval, table, whole};

/// Nodes that the table tells.
const NODES: [u32; 4] = [8, 64, 256, MOST_NODES];

/// What was found of a scene.
#[derive(Debug, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case")]
pub enum Row {
    /// Merged passes beside the whole.
    Passes(Passes),
    /// What a picture takes.
    Costs(Costs),
}

/// Merged passes over the whole picture.
#[derive(Debug, Serialize, Deserialize)]
pub struct Passes {
    /// A scene of `volumes/`.
    pub scene: String,
    /// Where photons come from: `saved` or `shot anew`.
    pub photons: String,
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// Rays of a pixel in all passes together.
    pub rays: u32,
    /// How many passes.
    pub passes: u32,
    /// How many seeds.
    pub seeds: u64,
    /// Relative squared error without the worst pixels, over that of the whole.
    pub error: Interval,
    /// The same with all pixels.
    pub error_of_all: Interval,
    /// Sum of all pixels.
    pub brightness: Interval,
    /// Steps of marches.
    pub steps: Interval,
    /// Processor seconds of the stages after loading and pilot, or after reading photons.
    pub seconds: Interval,
}

/// What a picture takes, in seconds of one node.
#[derive(Debug, Serialize, Deserialize)]
pub struct Costs {
    /// A scene of `volumes/`.
    pub scene: String,
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// Rays of a pixel.
    pub rays: u32,
    /// Photon paths.
    pub photons: u64,
    /// Loading.
    pub load: f64,
    /// Choosing strategies, with aiming the photons.
    pub strategy: f64,
    /// Shooting photons and filling the cells that they do not fill.
    pub shoot: f64,
    /// Writing them.
    pub write_photons: f64,
    /// Reading them and building their maps.
    pub read_photons: f64,
    /// One ray in each pixel.
    pub ray: f64,
    /// What each pass has once, in rays of a pixel.
    pub once: f64,
    /// Rows that a cut between crops adds, since cells on it are filled twice.
    pub border: f64,
    /// Share of the rays' time of each of some equal bands, from the top.
    pub bands: Vec<f64>,
    /// Encoding and writing EXR and PNG.
    pub encode: f64,
    /// Merging passes: by itself, and for each.
    pub merge_passes: [f64; 2],
    /// Merging crops: by itself, and for each.
    pub merge_crops: [f64; 2],
}

/// The costs of each scene that was measured.
pub fn costs(rows: &[Row]) -> impl Iterator<Item = &Costs> {
    rows.iter().filter_map(|row| match row {
        Row::Costs(costs) => Some(costs),
        Row::Passes(_) => None,
    })
}

fn passes(rows: &[Row]) -> impl Iterator<Item = &Passes> {
    rows.iter().filter_map(|row| match row {
        Row::Passes(passes) => Some(passes),
        Row::Costs(_) => None,
    })
}

/// All tables.
pub fn tables(rows: &[Row]) -> String {
    let told = passes(rows).next().map_or_else(String::new, |of| {
        let Passes { rays, passes, seeds, size: [width, height], .. } = of;
        let size = width.max(height);
        format!(
            "{passes} passes of {} rays each, {size} pixels along the longer side, {seeds} seeds. ",
            rays / passes
        )
    });
    let ratios = passes(rows).map(|of| {
        let cells = [&of.error, &of.error_of_all, &of.brightness, &of.steps, &of.seconds];
        let cells =
            cells.into_iter().zip([3, 3, 4, 4, 3]).map(|(ratio, digits)| interval(ratio, digits));
        [of.scene.clone(), of.photons.clone()].into_iter().chain(cells).collect()
    });
    let equality = table(
        &[
            "scene",
            "photons",
            "relative MSE",
            "of all pixels",
            "brightness",
            "march steps",
            "seconds",
        ],
        ratios,
    );
    let serial = costs(rows).map(|of| {
        let [width, height] = of.size;
        let seconds = [of.load, of.strategy, of.shoot, of.write_photons, of.read_photons];
        let seconds = seconds.into_iter().map(|seconds| figure(seconds, 2));
        let rays = of.ray * (f64::from(of.rays) + of.once);
        let merging = [of.merge_passes, of.merge_crops]
            .map(|[alone, each]| format!("{} + {} a part", decimals(alone, 2), decimals(each, 4)));
        let frame = [of.scene.clone(), format!("{width} x {height}"), whole(of.photons as f64)];
        let rest =
            [figure(rays, 3), decimals(of.once, 2), decimals(of.border, 1), figure(of.encode, 2)];
        frame.into_iter().chain(seconds).chain(rest).chain(merging).collect()
    });
    let serial = table(
        &[
            "scene",
            "pixels",
            "photons",
            "loading",
            "pilot",
            "photons, s",
            "writing them",
            "reading them",
            "rays, s",
            "once a pass, rays",
            "a cut, rows",
            "encoding",
            "merging passes",
            "merging crops",
        ],
        serial,
    );
    let nodes = costs(rows).flat_map(|of| {
        Kind::ALL.map(|kind| {
            let mut cells = vec![of.scene.clone(), kind.title().to_owned()];
            cells.extend(NODES.map(|nodes| {
                format!(
                    "{} ({})",
                    figure(speed_up(of, kind, nodes), 3),
                    figure(simulated(of, kind, nodes), 3)
                )
            }));
            let (at, most) = most(of, kind);
            cells.extend([format!("{} at {at}", figure(most, 3)), efficient(of, kind)]);
            cells
        })
    });
    let columns = NODES.map(|nodes| format!("{nodes} nodes"));
    let [a, b, c, d] = columns.each_ref().map(String::as_str);
    let nodes = table(&["scene", "parts", a, b, c, d, "most", "half of ideal at"], nodes);
    let rays = costs(rows).next().map_or(0, |of| of.rays);
    format!(
        "{told}Told are the figures of the mean of the passes over those of the whole, with intervals at 95 %. Relative MSE \
         is against the wholes of the other seeds, without the worst pixels and of all. Seconds are those that threads ran, of the rays by saved photons, and of photons \
         and rays where each pass shoots; loading, pilot and reading come on top, once a pass.\n\n{equality}\n\
         ## What a frame has in serial\n\
         Seconds of one node, which is the machine below, for the size and photons of the scene's file and {rays} rays a pixel. A pass that shoots \
         finds once where in its cells final gathers start; crops fill the cells on a cut between them twice.\n\n{serial}\n\
         ## How far many nodes help\n\
         ![Speed-up against nodes](../../../volumes/farm.svg)\n\n\
         Speed-up over the whole on one node, by the closed form T(n) = serial + parallel / n + merge(n) (Amdahl 1967), and in brackets by a \
         simulation in which nodes differ by 10 % in speed, each task waits {START_UP} s for its start and each crop takes what its rows do. \
         There is a part a node: passes have 8 rays or more, crops a row or more. Crops that are reconstructed get rays \
         around them, too.\n\n{nodes}"
    )
}

/// The fewest nodes with the largest speed-up, and that.
fn most(costs: &Costs, kind: Kind) -> (u32, f64) {
    let all = (1..=MOST_NODES).map(|nodes| (nodes, speed_up(costs, kind, nodes)));
    all.fold((1, 0.0), |best, next| if next.1 > best.1 { next } else { best })
}

/// The most nodes that are as good as half as many ideal ones.
fn efficient(costs: &Costs, kind: Kind) -> String {
    efficient_nodes(costs, kind).map_or_else(|| NONE.into(), |nodes| nodes.to_string())
}

/// Speed-ups of the closed form, shares of a frame, and what merged passes are of the whole.
pub fn quoted(rows: &[Row]) -> Vec<(String, String)> {
    let mut out = Vec::new();
    for of in costs(rows) {
        let key = |what: &str| format!("farm.{}.{what}", of.scene);
        for kind in Kind::ALL {
            let name = kind.key();
            for nodes in [64, MOST_NODES] {
                let times = figure(speed_up(of, kind, nodes), 2);
                out.push((key(&format!("{name}.{nodes}")), times));
            }
            let (at, most) = most(of, kind);
            out.push((key(&format!("{name}.most")), figure(most, 2)));
            out.push((key(&format!("{name}.most_at")), at.to_string()));
            out.push((key(&format!("{name}.half")), efficient(of, kind)));
        }
        let alone = times(of, Kind::Crops, 1).iter().sum::<f64>();
        out.push((key("alone"), figure(alone, 2)));
        let before = of.load + of.strategy + of.shoot + of.write_photons;
        out.push((key("before"), figure(before, 2)));
    }
    for of in passes(rows) {
        let key = |what: &str| format!("farm.{}.{}.{what}", of.scene, of.photons.replace(' ', "_"));
        out.push((key("error"), decimals(of.error.estimate, 2)));
        out.push((key("steps"), decimals(100.0 * (of.steps.estimate - 1.0), 1)));
        out.push((key("seconds"), decimals(of.seconds.estimate, 2)));
    }
    out
}
