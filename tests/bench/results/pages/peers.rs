//! Time to the same error beside other renderers.

use serde::{Deserialize, Serialize};

use super::equal_error::{Bound, Faster, Point, time_to};
use super::markdown::{NONE, figure, table};

/// One picture, as in `points.jsonl` of `tests/bench/peers`.
#[derive(Debug, Serialize, Deserialize)]
pub struct Row {
    /// A scene of `scenes.toml`.
    pub scene: String,
    /// A renderer of `budgets.toml`.
    pub renderer: String,
    /// fogbow's photons.
    pub photons: Option<u64>,
    /// Camera rays a pixel.
    pub rays: u32,
    /// CPU seconds over the number of threads.
    pub seconds: f64,
    /// Relative MSE, less the reference's noise.
    pub relmse: f64,
    /// Mean HDR-FLIP.
    pub flip: f64,
}

/// Scenes with their titles.
const SCENES: [(&str, &str); 5] = [
    ("smoke", "smoke box, optical thickness 3.9, albedo 0.9"),
    ("smoke-forward", "the same, g = 0.6"),
    ("smoke-aside", "smoke lit from the side, albedo 0.95, g = 0.3"),
    ("lamp-in-fog", "lamp in fog around the camera, albedo 0.97, g = 0.5"),
    ("cloud", "cloud, albedo 0.999, g = 0.85"),
];

/// fogbow's ways: renderer, head of the column and name in a key.
const WAYS: [(&str, &str, &str); 6] = [
    ("fogbow-fixed", "`fixed`", "fixed"),
    ("fogbow-xs", "`xs`", "xs"),
    ("fogbow-reconstructed", "`fixed`, reconstructed", "reconstructed"),
    ("fogbow-oidn", "`fixed`, denoised", "fixed_denoised"),
    ("fogbow-xs-oidn", "`xs`, denoised", "xs_denoised"),
    ("fogbow-traced-oidn", "traced, denoised", "traced_denoised"),
];

/// Peers: renderer, title and name in a key.
const PEERS: [(&str, &str, &str); 4] = [
    ("cycles-biased-oidn", "Cycles, biased march, denoised", "cycles_denoised"),
    ("cycles", "Cycles, null scattering", "cycles"),
    ("cycles-biased", "Cycles, biased march", "cycles_biased"),
    ("mitsuba", "Mitsuba, volpath", "mitsuba"),
];

/// The errors at which times are compared.
#[derive(Clone, Copy)]
enum Error {
    Both,
    RelativeMse,
}

/// Both tables.
pub fn tables(rows: &[Row]) -> String {
    format!(
        "![Error against CPU time](../../../volumes/peers.svg)\n\n\
         How many times as fast fogbow is as good as another renderer's picture. Seconds are CPU \
         seconds over the number of threads: of fogbow all between loading and writing, of a peer its \
         render call, in which Cycles reads the grid. One seed. Below 1 fogbow loses. \"> 2\": already \
         fogbow's cheapest picture was better; \"< 2\": its dearest was not as good.\n\n\
         ## At the same relative MSE and FLIP\n{}\n## At the same relative MSE\n{}\n\
         ## Pictures\n{}",
        faster(rows, Error::Both),
        faster(rows, Error::RelativeMse),
        pictures(rows)
    )
}

fn faster(rows: &[Row], error: Error) -> String {
    let head: Vec<&str> = ["scene", "renderer", "rays", "s", "relMSE", "FLIP"]
        .into_iter()
        .chain(WAYS.map(|way| way.1))
        .collect();
    let mut lines = Vec::new();
    for (scene, title) in SCENES {
        for (renderer, name, _) in PEERS {
            for peer in rows.iter().filter(|r| r.scene == scene && r.renderer == renderer) {
                let head = [title.to_owned(), name.to_owned(), peer.rays.to_string()];
                let own = [
                    figure(peer.seconds, 2),
                    format!("{:.4}", peer.relmse),
                    format!("{:.3}", peer.flip),
                ];
                let times = WAYS.map(|(way, ..)| {
                    than(rows, way, peer, error).map_or_else(|| NONE.into(), |t| t.to_string())
                });
                lines.push(head.into_iter().chain(own).chain(times).collect());
            }
        }
    }
    table(&head, lines)
}

fn pictures(rows: &[Row]) -> String {
    let lines = rows.iter().map(|row| {
        vec![
            row.scene.clone(),
            row.renderer.clone(),
            row.photons.map_or_else(String::new, |photons| photons.to_string()),
            row.rays.to_string(),
            figure(row.seconds, 3),
            format!("{:.5}", row.relmse),
            format!("{:.4}", row.flip),
        ]
    });
    table(&["scene", "renderer", "photons", "rays", "s", "relMSE", "FLIP"], lines)
}

/// How much faster a way of fogbow's is as good as a peer's picture.
fn than(rows: &[Row], way: &str, peer: &Row, error: Error) -> Option<Faster> {
    let own = || rows.iter().filter(|row| row.scene == peer.scene && row.renderer == way);
    let relmse: Vec<Point> = own().map(|row| (row.seconds, row.relmse)).collect();
    let flip: Vec<Point> = own().map(|row| (row.seconds, row.flip)).collect();
    let reached = time_to(&relmse, peer.relmse)?;
    let reached = match error {
        Error::RelativeMse => reached,
        Error::Both => reached.and(time_to(&flip, peer.flip)?),
    };
    Some(reached.faster_than(peer.seconds))
}

/// Times at both errors, as `peers.SCENE.WAY.PEER_RAYS`; the way `denoised` is the best of fogbow's
/// denoised ones. Beside denoised Cycles each of its pictures counts, and the least and the most are told;
/// beside others the one with most rays.
pub fn quoted(rows: &[Row]) -> Vec<(String, String)> {
    let groups = [
        (&WAYS[..1], WAYS[0].2),
        (&WAYS[1..2], WAYS[1].2),
        (&WAYS[2..3], WAYS[2].2),
        (&WAYS[3..], "denoised"),
    ];
    let mut out = Vec::new();
    for (scene, _) in SCENES {
        for (renderer, _, peer_key) in PEERS {
            let mut peers: Vec<&Row> =
                rows.iter().filter(|r| r.scene == scene && r.renderer == renderer).collect();
            peers.sort_by_key(|peer| peer.rays);
            let is_denoised = renderer == PEERS[0].0;
            if !is_denoised {
                peers.drain(..peers.len().saturating_sub(1));
            }
            for (ways, way_key) in groups {
                let key = format!("peers.{}.{way_key}.{peer_key}", scene.replace('-', "_"));
                let found: Vec<(u32, Faster)> = peers
                    .iter()
                    .filter_map(|peer| Some((peer.rays, best(rows, ways, peer)?)))
                    .collect();
                out.extend(
                    found.iter().map(|(rays, times)| (format!("{key}_{rays}"), times.to_string())),
                );
                if is_denoised {
                    out.extend(ends(&key, &found));
                }
            }
        }
    }
    out
}

/// The best of some ways; a bound from above says least.
fn best(rows: &[Row], ways: &[(&str, &str, &str)], peer: &Row) -> Option<Faster> {
    let each = ways.iter().filter_map(|way| than(rows, way.0, peer, Error::Both));
    each.max_by(|a, b| {
        let is_told = |faster: &Faster| faster.bound != Bound::Below;
        is_told(a).cmp(&is_told(b)).then(a.times.total_cmp(&b.times))
    })
}

/// The least and the most of what was found.
fn ends(key: &str, found: &[(u32, Faster)]) -> Vec<(String, String)> {
    let by_times = |a: &&(u32, Faster), b: &&(u32, Faster)| a.1.times.total_cmp(&b.1.times);
    let (least, most) = (found.iter().min_by(by_times), found.iter().max_by(by_times));
    [("least", least), ("most", most)]
        .into_iter()
        .filter_map(|(name, end)| Some((format!("{key}.{name}"), end?.1.to_string())))
        .collect()
}
