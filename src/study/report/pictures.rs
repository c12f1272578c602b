//! Pictures inside the page.

use std::path::Path;

use half::f16;
use serde::Serialize;

use super::super::html::data_uri;
use super::super::measured::PointResult;
use super::super::metric::relative_map;
use super::super::results::Results;
use crate::error::{Error, Result};
use crate::image::{Image, Layers, Picture, ScalarMap, read_exr, read_layers};
use crate::math::nth_smallest;

/// The most pixels along a side of a picture in the page; larger ones are averaged down.
const SIDE: usize = 512;

/// Bits of the lower byte of a half float that are kept: 7 of the mantissa's 10 bits, 1 % at most.
const KEPT: u8 = 0b1111_1000;

/// All pictures of a page.
#[derive(Debug)]
pub(super) struct Gallery {
    /// A candidate each.
    pub(super) cards: Vec<Card>,
    /// For the viewer, targets first.
    pub(super) views: Vec<Viewed>,
}

/// A candidate at its largest budget.
#[derive(Debug, Serialize)]
pub(super) struct Card {
    name: String,
    about: String,
    label: String,
    /// The picture, its error, and what was handed out, as data URIs.
    panels: Vec<(String, String)>,
}

/// A picture of linear radiance for the viewer: a PNG twice as high, the upper half the high bytes
/// of half floats, the lower half the low bytes.
#[derive(Debug, Serialize)]
pub(super) struct Viewed {
    name: String,
    width: usize,
    height: usize,
    png: String,
}

/// Pictures of the targets and of the first seed of every candidate at its largest budget, for the
/// page at `path`.
pub(super) fn gallery(results: &Results, folder: &Path, path: &Path) -> Result<Gallery> {
    let target = read_exr(&folder.join(&results.target().exr))?;
    let mut views = Vec::new();
    for target in &results.targets {
        let image = read_exr(&folder.join(&target.exr))?;
        views.push(viewed(format!("{} (mean of {})", target.name, target.renders), &image, path)?);
    }
    let mut shown: Vec<(&PointResult, Layers, Image)> = Vec::new();
    for point in &results.points {
        let first_budget = shown.last().is_none_or(|(last, ..)| last.candidate != point.candidate);
        if let Some(first) = point.runs.first().filter(|_| first_budget) {
            let path = folder.join(&first.run.exr);
            let layers = read_layers(&path)?;
            let image = layers.image().ok_or_else(|| Error::file(&path, "has no R, G and B"))?;
            shown.push((point, layers, image));
        }
    }
    let error = |image: &Image| {
        let epsilon = results.metrics.epsilon.unwrap_or(1.0);
        let map = relative_map(&target, image, epsilon).values;
        map.into_iter().map(f32::sqrt).collect::<Vec<f32>>()
    };
    let errors: Vec<Vec<f32>> = shown.iter().map(|(_, _, image)| error(image)).collect();
    let worst = errors.iter().map(|map| high(map)).fold(1e-6, f32::max);
    let mut cards = Vec::new();
    for ((point, layers, image), error) in shown.iter().zip(&errors) {
        views.push(viewed(format!("{}, {}", point.candidate, point.label), image, path)?);
        let picture = Picture::developed(&reduced(image), &results.view);
        cards.push(card(point, layers, &picture, (error, worst), path)?);
    }
    Ok(Gallery { cards, views })
}

fn card(
    point: &PointResult,
    layers: &Layers,
    picture: &Picture,
    (error, worst): (&[f32], f32),
    path: &Path,
) -> Result<Card> {
    let embedded = |shown: &Picture| data_uri(path, shown.width(), shown.height(), shown.bytes());
    let mut panels = vec![("picture".to_owned(), embedded(picture)?)];
    let width = layers.width;
    let panel = |name: &str, values: &[f32], range: Option<[f32; 2]>| {
        let (width, values) = reduced_map(width, values);
        let fitted = ScalarMap::fitted(name, width, &values);
        let map = ScalarMap { range: range.unwrap_or(fitted.range), ..fitted };
        Ok::<_, Error>((name.to_owned(), embedded(&map.panel())?))
    };
    panels.push(panel("relative error", error, Some([0.0, worst]))?);
    for (name, layer) in
        [("rays", "rays"), ("gather radius, m", "radius"), ("march step, m", "step")]
    {
        if let Some(values) = layers.get(layer) {
            let range = (layer == "rays").then_some([0.0, point.settings.rays as f32]);
            panels.push(panel(name, values, range)?);
        }
    }
    Ok(Card {
        name: point.candidate.clone(),
        about: point.about.clone(),
        label: point.label.clone(),
        panels,
    })
}

/// The 99th percentile of the values of a map.
fn high(map: &[f32]) -> f32 {
    let rank = map.len().saturating_sub(1) * 99 / 100;
    let values = map.iter().copied().map(f64::from).collect();
    nth_smallest(values, rank).unwrap_or(0.0) as f32
}

fn viewed(name: String, image: &Image, path: &Path) -> Result<Viewed> {
    let image = reduced(image);
    let halves: Vec<[u8; 2]> = image
        .pixels()
        .as_flattened()
        .iter()
        .map(|v| f16::from_f32(v.clamp(0.0, 65504.0)).to_be_bytes())
        .collect();
    let bytes: Vec<u8> = halves
        .iter()
        .map(|[high, _]| *high)
        .chain(halves.iter().map(|[_, low]| low & KEPT))
        .collect();
    let (width, height) = (image.width(), image.height());
    Ok(Viewed { name, width, height, png: data_uri(path, width, 2 * height, &bytes)? })
}

/// The mean of squares of pixels, so that no side is longer than [`SIDE`].
fn reduced(image: &Image) -> Image {
    let channel = |c: usize| image.pixels().iter().map(|p| p[c]).collect::<Vec<f32>>();
    let [(width, r), (_, g), (_, b)] = [0, 1, 2].map(|c| reduced_map(image.width(), &channel(c)));
    let pixels: Vec<[f32; 3]> = r.iter().zip(&g).zip(&b).map(|((&r, &g), &b)| [r, g, b]).collect();
    Image::new(width, pixels.len() / width, pixels)
}

fn reduced_map(width: usize, values: &[f32]) -> (usize, Vec<f32>) {
    let height = values.len() / width;
    let factor = width.max(height).div_ceil(SIDE);
    if factor == 1 {
        return (width, values.to_vec());
    }
    let (columns, rows) = (width.div_ceil(factor), height.div_ceil(factor));
    let mean = |i: usize| {
        let (left, top) = (i % columns * factor, i / columns * factor);
        let across = left..(left + factor).min(width);
        let square = (top..(top + factor).min(height))
            .flat_map(|y| across.clone().map(move |x| y * width + x));
        let (n, sum) = square.fold((0.0, 0.0), |(n, sum), at| (n + 1.0, sum + values[at]));
        sum / n
    };
    (columns, (0..columns * rows).map(mean).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn large_maps_are_averaged() {
        let width = 2 * SIDE - 1;
        let values: Vec<f32> = (0..width).map(|x| x as f32).collect();
        let (columns, reduced) = reduced_map(width, &values);
        assert_eq!((columns, reduced.len()), (SIDE, SIDE));
        assert_eq!((reduced[0], reduced[SIDE - 1]), (0.5, (width - 1) as f32));
    }
}
