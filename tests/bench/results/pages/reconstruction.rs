//! Pictures of few rays and photons: raw, reconstructed and denoised.

use serde::{Deserialize, Serialize};

use super::markdown::{decimals, figure, table, whole};

/// What was found of one scene.
#[derive(Debug, Serialize, Deserialize)]
pub struct Row {
    /// The scene's title.
    pub scene: String,
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// Rays a pixel.
    pub rays: u32,
    /// Photon paths.
    pub photons: u64,
    /// The truth, and what two halves of it differ by.
    pub floor: Floor,
    /// A picture of the gold standard.
    pub gold: Gold,
    /// Raw, reconstructed and denoised.
    pub ways: Vec<Way>,
    /// Of the same.
    pub bias: Vec<Bias>,
}

/// The truth.
#[derive(Debug, Serialize, Deserialize)]
pub struct Floor {
    /// Pictures in both halves.
    pub pictures: u64,
    /// Rays a pixel of each.
    pub rays: u32,
    /// Photon paths of each.
    pub photons: u64,
    /// Trimmed relative squared error of the mean of both halves.
    pub error: f64,
    /// HDR-FLIP of one half against the other.
    pub flip: f64,
    /// Pixels of one half in % that visibly differ from the other.
    pub vdp_percent: f64,
}

/// What a picture of the gold standard takes, and what directing its rays could bring.
#[derive(Debug, Serialize, Deserialize)]
pub struct Gold {
    /// Processor seconds of all threads.
    pub seconds: f64,
    /// Those of photons and their map.
    pub photon_seconds: f64,
    /// Those of rays.
    pub ray_seconds: f64,
    /// Mean of the squared deviation of pixels over the square of their mean: by as much rays fewer give the
    /// same error, where they are shot in proportion to it.
    pub allocation_gain: f64,
    /// Processor microseconds a pixel that a tenth of all seconds leaves.
    pub microseconds_for_ten: f64,
}

/// One way of rendering.
#[derive(Debug, Serialize, Deserialize)]
pub struct Way {
    /// Raw, reconstructed or denoised.
    pub name: String,
    /// Processor seconds of all threads.
    pub seconds: f64,
    /// Relative squared error without the worst pixels.
    pub trimmed: f64,
    /// The same of all pixels.
    pub untrimmed: f64,
    /// HDR-FLIP against the truth.
    pub flip: f64,
    /// Pixels in % that visibly differ from the truth.
    pub vdp_percent: f64,
    /// How much brighter the pictures are than the truth, in %.
    pub brighter_percent: f64,
    /// Wall microseconds a pixel of the filter.
    pub microseconds: f64,
}

/// Bias of one way, relative, in %.
#[derive(Debug, Serialize, Deserialize)]
pub struct Bias {
    /// Its name.
    pub way: String,
    /// Pictures that it is the bias of.
    pub seeds: usize,
    /// Of blocks of pixels.
    pub blocks_percent: f64,
    /// Of pixels near edges, where there are any.
    pub near_edges_percent: Option<f64>,
    /// Of the others.
    pub elsewhere_percent: Option<f64>,
}

/// Errors, bias, and what gold leaves to directors.
pub fn tables(rows: &[Row]) -> String {
    format!(
        "Pictures of few rays and photons against the truth, the mean of pictures of the gold standard: \
         as they are, with `--reconstruct`, and with `--denoise` (Open Image Denoise). Errors are \
         squared, relative to the squared radiance and half its mean, without the worst 0.2 % of the \
         pixels and of all; they are products of differences from two halves of the truth, whose noise \
         adds no bias. FLIP is HDR-FLIP, VDP the pixels in % that visibly differ from the truth. CPU is \
         that of all threads, the filter's too.\n\n{}\n\
         Bias: the root of its relative square over seeds, in %, of means over blocks of 8 x 8 pixels \
         and of pixels within 3 pixels of an edge (where the distance of the first surface changes by a \
         tenth) and elsewhere.\n\n{}\n\
         The truth, and a picture of the gold standard: by how much fewer rays could give the same error \
         if each pixel had as many as its deviation asks for, and the CPU time a pixel that a tenth of \
         the whole leaves. The floor is what one half of the truth shows against the other.\n\n{}",
        errors(rows),
        biases(rows),
        golds(rows)
    )
}

fn errors(rows: &[Row]) -> String {
    let lines = rows.iter().flat_map(|row| {
        row.ways.iter().map(move |way| {
            vec![
                row.scene.clone(),
                format!("{} x {}", row.size[0], row.size[1]),
                format!("{}, {}", row.rays, whole(row.photons as f64)),
                way.name.clone(),
                figure(way.seconds, 3),
                figure(way.trimmed, 3),
                figure(way.untrimmed, 3),
                figure(way.flip, 3),
                figure(way.vdp_percent, 3),
                decimals(way.brighter_percent, 2),
                if way.microseconds > 0.0 { decimals(way.microseconds, 1) } else { String::new() },
            ]
        })
    });
    let head = [
        "scene",
        "size",
        "rays, photons",
        "way",
        "CPU s",
        "error",
        "of all pixels",
        "FLIP",
        "VDP, %",
        "brighter, %",
        "filter, µs a pixel",
    ];
    table(&head, lines)
}

fn biases(rows: &[Row]) -> String {
    let lines = rows.iter().flat_map(|row| {
        row.bias.iter().map(move |bias| {
            vec![
                row.scene.clone(),
                bias.way.clone(),
                bias.seeds.to_string(),
                decimals(bias.blocks_percent, 2),
                decimals(bias.near_edges_percent, 2),
                decimals(bias.elsewhere_percent, 2),
            ]
        })
    });
    table(&["scene", "way", "seeds", "blocks", "near edges", "elsewhere"], lines)
}

fn golds(rows: &[Row]) -> String {
    let lines = rows.iter().map(|row| {
        let Row { floor, gold, .. } = row;
        vec![
            row.scene.clone(),
            format!("{} of {} rays, {}", floor.pictures, floor.rays, whole(floor.photons as f64)),
            figure(floor.error, 3),
            figure(floor.flip, 3),
            figure(floor.vdp_percent, 3),
            figure(gold.seconds, 3),
            figure(gold.photon_seconds, 3),
            figure(gold.ray_seconds, 3),
            decimals(gold.allocation_gain, 2),
            decimals(gold.microseconds_for_ten, 1),
        ]
    });
    let head = [
        "scene",
        "pictures, photons",
        "error of the mean",
        "FLIP of a half",
        "VDP, %",
        "gold, CPU s",
        "photons",
        "rays",
        "by rays alone",
        "tenfold, µs a pixel",
    ];
    table(&head, lines)
}
