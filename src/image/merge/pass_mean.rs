//! The mean of passes, summed up in f64, one pass after the other.
//!
//! | layers | of the merged picture |
//! | --- | --- |
//! | `R` `G` `B` `A` `transmittance` `noisy.*` | the weighted mean: each is a mean over rays |
//! | `saliency` `xs` `radius` `step` | the weighted mean: what a pixel was worth, and the widths it was rendered with |
//! | `Z` | the least, as of the rays of one picture: the nearest surface that any ray met |
//! | `depth.*` `position.*` `motion.*` | the mean weighed by coverage as well, as rays are in one picture; FAR and 0 where nothing is seen |
//! | `CryptoObject00.*` … | the weighted mean of the coverage of each object, ranked anew |
//! | other passes | the weighted mean |
//! | `rays` | the sum |
//! | `variance` | that of the mean, from the spread between passes: see `variance.rs` |
//!
//! `variance` is of the luminance before noise was taken off: of `noisy.R`, `noisy.G` and `noisy.B` where
//! they are there.

use std::collections::BTreeMap;

use super::super::{Channels, FAR, Layers, NOISY_LAYERS, Window, cryptomatte};
use super::variance::Spread;
use crate::math::{Rgb, luminance};

/// How a layer is merged.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Rule {
    /// Weighted mean.
    Mean,
    /// Mean weighed by coverage as well, of a value that is this where nothing is seen.
    Seen {
        /// That value.
        nothing: f64,
    },
    /// Least value.
    Least,
    /// Sum.
    Sum,
    /// Variance of the mean of luminance.
    Variance,
    /// Objects by coverage, which are merged together.
    Objects,
}

impl Rule {
    /// The rule of the layer of that name.
    fn new(layer: &str) -> Option<Self> {
        match layer {
            "R" | "G" | "B" | "A" | "transmittance" => Some(Self::Mean),
            "noisy.R" | "noisy.G" | "noisy.B" => Some(Self::Mean),
            "saliency" | "xs" | "radius" | "step" => Some(Self::Mean),
            "Z" => Some(Self::Least),
            "rays" => Some(Self::Sum),
            "variance" => Some(Self::Variance),
            _ if cryptomatte::is_layer(layer) => Some(Self::Objects),
            _ => Self::of_pass(layer),
        }
    }

    /// The rule of a layer of a pass.
    fn of_pass(layer: &str) -> Option<Self> {
        let (pass, _) = layer.split_once('.')?;
        match pass {
            "depth" => Some(Self::Seen { nothing: FAR }),
            "position" | "motion" => Some(Self::Seen { nothing: 0.0 }),
            "albedo" | "normal" => Some(Self::Mean),
            "media" | "direct" | "indirect" | "emission" | "specular" => Some(Self::Mean),
            "group" | "scattered" => Some(Self::Mean),
            _ => None,
        }
    }
}

/// A layer of the sum: of weighted values, of values or their least; empty for the variance and for objects.
#[derive(Debug)]
struct LayerSum {
    rule: Rule,
    values: Vec<f64>,
}

/// The weighted mean of passes.
#[derive(Debug)]
pub struct PassMean {
    width: usize,
    layers: BTreeMap<String, LayerSum>,
    /// Weight of what each pixel has seen, where layers are weighed by that.
    seen: Vec<f64>,
    /// The list of objects of each pixel with their weighted coverages, where there are layers of them.
    objects: Vec<f64>,
    /// Luminance of the passes, where there is a layer of variance.
    spread: Option<Spread>,
    passes: usize,
    /// Weight of the pass that was begun last.
    weight: f64,
    /// Weight of all passes that were begun.
    total: f64,
}

impl PassMean {
    /// A picture of `size`, width and height, with `layers` of no pass yet.
    ///
    /// # Errors
    /// The name of a layer for which there is no rule.
    pub fn new(size: [u32; 2], layers: &[String]) -> Result<Self, String> {
        let [width, height] = size.map(|side| side as usize);
        let layer = |name: &String| {
            let rule = Rule::new(name).ok_or_else(|| name.clone())?;
            let has_values = !matches!(rule, Rule::Variance | Rule::Objects);
            let pixels = if has_values { width * height } else { 0 };
            Ok((name.clone(), LayerSum { rule, values: vec![0.0; pixels] }))
        };
        let layers = layers.iter().map(layer).collect::<Result<BTreeMap<_, _>, String>>()?;
        let has_variance = layers.values().any(|layer| layer.rule == Rule::Variance);
        let spread = has_variance.then(|| Spread::new(width * height));
        let by_coverage = |layer: &LayerSum| matches!(layer.rule, Rule::Seen { .. });
        let pixels = if layers.values().any(by_coverage) { width * height } else { 0 };
        let seen = vec![0.0; pixels];
        let has_objects = layers.values().any(|layer| layer.rule == Rule::Objects);
        let numbers = if has_objects { cryptomatte::NUMBERS } else { 0 };
        let objects = vec![0.0; width * height * numbers];
        Ok(Self { width, layers, seen, objects, spread, passes: 0, weight: 0.0, total: 0.0 })
    }

    /// Begins the next pass, of a positive `weight`. The order of passes is that of summation.
    pub fn begin_pass(&mut self, weight: f64) {
        self.passes += 1;
        self.weight = weight;
        self.total += weight;
    }

    /// Adds the part of the pass that lies in `window`. Layers that the picture lacks are left out.
    ///
    /// # Panics
    /// Where the part is not as large as `window`, or that reaches beyond the picture.
    pub fn add(&mut self, window: Window, part: &Layers) {
        let (weight, is_first) = (self.weight, self.passes == 1);
        for (name, values) in &part.channels {
            let Some(LayerSum { rule, values: sums }) = self.layers.get_mut(name) else { continue };
            let add: &dyn Fn(&mut f64, f64) = match rule {
                Rule::Mean => &|sum, value| *sum += weight * value,
                Rule::Sum => &|sum, value| *sum += value,
                Rule::Least if is_first => &|sum, value| *sum = value,
                Rule::Least => &|sum, value| *sum = sum.min(value),
                Rule::Seen { .. } => {
                    add_seen(sums, [values, coverage(part)], weight, window, self.width);
                    continue;
                }
                Rule::Variance | Rule::Objects => continue,
            };
            for (pixels, own) in window.rows(self.width) {
                let values = values[own].iter().copied().map(f64::from);
                sums[pixels].iter_mut().zip(values).for_each(|(sum, value)| add(sum, value));
            }
        }
        if !self.seen.is_empty() {
            let ones = vec![1.0; coverage(part).len()];
            add_seen(&mut self.seen, [&ones, coverage(part)], weight, window, self.width);
        }
        self.add_objects(window, part);
        self.add_spread(window, part);
    }

    fn add_objects(&mut self, window: Window, part: &Layers) {
        let (lists, _) = self.objects.as_chunks_mut::<{ cryptomatte::NUMBERS }>();
        if lists.is_empty() {
            return;
        }
        let layers = cryptomatte::layers();
        for [identifier, coverage] in layers.as_chunks().0 {
            let pair = part.get(identifier).zip(part.get(coverage));
            let Some((identifiers, coverages)) = pair else { continue };
            for (pixels, own) in window.rows(self.width) {
                for (list, own) in lists[pixels].iter_mut().zip(own) {
                    let coverage = self.weight * f64::from(coverages[own]);
                    cryptomatte::add(list, identifiers[own].to_bits(), coverage);
                }
            }
        }
    }

    fn add_spread(&mut self, window: Window, part: &Layers) {
        let channels =
            [NOISY_LAYERS, ["R", "G", "B"]].map(|names| names.map(|name| part.get(name)));
        let known = channels.into_iter().find_map(|[r, g, b]| Some([r?, g?, b?]));
        let (Some(spread), Some(channels)) = (&mut self.spread, known) else { return };
        for (pixels, own) in window.rows(self.width) {
            for (pixel, own) in pixels.zip(own) {
                let color = Rgb::from(channels.map(|channel| f64::from(channel[own])));
                spread.add(pixel, luminance(color), self.weight, self.total);
            }
        }
    }

    /// The layers of the mean.
    pub fn finish(self) -> Channels {
        let Self { width, layers, seen, objects, mut spread, passes, total, .. } = self;
        let resolved = |(name, LayerSum { rule, mut values }): (String, LayerSum)| {
            match rule {
                Rule::Mean => values.iter_mut().for_each(|value| *value /= total),
                Rule::Seen { nothing } => {
                    for (value, seen) in values.iter_mut().zip(&seen) {
                        *value = if *seen > 0.0 { *value / seen } else { nothing };
                    }
                }
                Rule::Sum | Rule::Least | Rule::Objects => {}
                Rule::Variance => {
                    let spread = spread.take();
                    values = spread.map_or(values, |spread| spread.variances(width, passes, total));
                }
            }
            (name, values.into_iter().map(|value| value as f32).collect())
        };
        let mut channels: Channels = layers.into_iter().map(resolved).collect();
        for (name, plane) in object_planes(&objects, total) {
            channels.entry(name).and_modify(|values| *values = plane);
        }
        channels
    }
}

/// The layers of objects by the `lists` of all pixels, whose coverages are shares of `whole`.
fn object_planes(lists: &[f64], whole: f64) -> impl Iterator<Item = (String, Vec<f32>)> {
    let (lists, _) = lists.as_chunks::<{ cryptomatte::NUMBERS }>();
    let ranks: Vec<_> = lists.iter().map(|list| cryptomatte::ranks(list, whole)).collect();
    let plane = move |layer: usize| ranks.iter().map(|values| values[layer]).collect();
    cryptomatte::layers().into_iter().enumerate().map(move |(layer, name)| (name, plane(layer)))
}

/// Coverage of each pixel of `part`: how much of a pixel is seen, and so the opacity of its rays.
fn coverage(part: &Layers) -> &[f32] {
    part.get("A").unwrap_or_default()
}

/// Adds `values` in `window` to `sums`, of which `width` make a row, each weighed by its coverage and `weight`.
fn add_seen(
    sums: &mut [f64],
    [values, coverage]: [&[f32]; 2],
    weight: f64,
    window: Window,
    width: usize,
) {
    for (pixels, own) in window.rows(width) {
        let pairs = values[own.clone()].iter().zip(coverage.get(own).unwrap_or_default());
        for (sum, (value, coverage)) in sums[pixels].iter_mut().zip(pairs) {
            *sum += weight * f64::from(*coverage) * f64::from(*value);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: [u32; 2] = [3, 2];

    /// A part of a picture of [`SIZE`] whose layers have one value.
    fn part(window: Window, layers: &[(&str, f32)]) -> Layers {
        let pixels = window.pixels() as usize;
        let channel = |&(name, value): &(&str, f32)| (name.to_owned(), vec![value; pixels]);
        Layers {
            width: window.width as usize,
            height: window.height as usize,
            corner: [window.left as i32, window.top as i32],
            display: [3, 2],
            channels: layers.iter().map(channel).collect(),
            attributes: BTreeMap::new(),
        }
    }

    /// The value of each layer of the mean of whole passes of these weights, the same in all pixels.
    fn mean(passes: &[(f64, &[(&str, f32)])]) -> BTreeMap<String, f32> {
        let names: Vec<String> = passes[0].1.iter().map(|(name, _)| (*name).to_owned()).collect();
        let mut mean = PassMean::new(SIZE, &names).unwrap();
        for (weight, layers) in passes {
            mean.begin_pass(*weight);
            mean.add(Window::whole(SIZE), &part(Window::whole(SIZE), layers));
        }
        let one = |(name, values): (String, Vec<f32>)| {
            assert!(values.iter().all(|value| *value == values[0]), "{name}: {values:?}");
            (name, values[0])
        };
        mean.finish().into_iter().map(one).collect()
    }

    #[test]
    fn each_layer_has_its_rule() {
        let first: &[_] = &[("R", 1.0), ("Z", 7.0), ("rays", 4.0), ("radius", 0.5)];
        let second: &[_] = &[("R", 2.0), ("Z", 6.0), ("rays", 12.0), ("radius", 0.25)];
        let found = mean(&[(1.0, first), (3.0, second)]);
        let expected = [("R", 1.75), ("Z", 6.0), ("radius", 0.3125), ("rays", 16.0)];
        assert_eq!(found, expected.map(|(name, value)| (name.to_owned(), value)).into());
    }

    #[test]
    fn depths_weigh_by_what_is_seen() {
        let pass = |a, depth, x, light| {
            [("A", a), ("depth.mean", depth), ("position.X", x), ("media.R", light)]
        };
        let found = mean(&[(1.0, &pass(0.5, 4.0, 1.0, 2.0)), (3.0, &pass(0.5, 8.0, 5.0, 6.0))]);
        assert_eq!((found["depth.mean"], found["position.X"], found["media.R"]), (7.0, 4.0, 5.0));
        let far = FAR as f32;
        let found = mean(&[(1.0, &pass(0.0, far, 0.0, 2.0)), (3.0, &pass(0.5, 8.0, 5.0, 6.0))]);
        assert_eq!((found["depth.mean"], found["position.X"]), (8.0, 5.0));
        let found = mean(&[(1.0, &pass(0.0, far, 0.0, 0.0)), (1.0, &pass(0.0, far, 0.0, 0.0))]);
        assert_eq!((found["depth.mean"], found["position.X"]), (far, 0.0));
    }

    #[test]
    fn objects_are_merged_by_their_identifiers() {
        let [a, b, c] = ["a", "b", "c"].map(|name| f32::from_bits(cryptomatte::identifier(name)));
        let pass = |first: f32, second: f32, coverages: [f32; 2]| {
            let names =
                ["CryptoObject00.R", "CryptoObject00.G", "CryptoObject00.B", "CryptoObject00.A"];
            let values = [first, coverages[0], second, coverages[1]];
            names.into_iter().zip(values).collect::<Vec<_>>()
        };
        // a: (1/2 + 3/8) / 4, b: (1/4 + 3 · 5/8) / 4, which comes first.
        let passes = [pass(a, b, [0.5, 0.25]), pass(b, a, [0.625, 0.125])];
        let found = mean(&[(1.0, &passes[0]), (3.0, &passes[1])]);
        let bits = |name: &str| found[name].to_bits();
        assert_eq!([bits("CryptoObject00.R"), bits("CryptoObject00.B")], [b, a].map(f32::to_bits));
        assert_eq!((found["CryptoObject00.G"], found["CryptoObject00.A"]), (0.53125, 0.21875));
        // One that the other pass does not have, and none.
        let found = mean(&[(1.0, &pass(c, 0.0, [0.5, 0.0])), (1.0, &pass(0.0, 0.0, [0.0; 2]))]);
        let bits = |name: &str| found[name].to_bits();
        assert_eq!([bits("CryptoObject00.R"), bits("CryptoObject00.B")], [c.to_bits(), 0]);
        assert_eq!((found["CryptoObject00.G"], found["CryptoObject00.A"]), (0.25, 0.0));
    }

    #[test]
    fn variance_is_that_of_the_mean_by_the_spread() {
        let grey = |value| [("R", value), ("G", value), ("B", value)];
        let pass = |value, variance| [&grey(value)[..], &[("variance", variance)]].concat();
        // Two passes of grey 1 and 3: (1² + 1²) / (2 · 1), and with the weights 1 and 3, whose mean is 2.5:
        // (1 · 1.5² + 3 · 0.5²) / (4 · 1). What each pass thinks of itself does not count.
        for (weight, expected) in [(1.0, 1.0), (3.0, 0.75)] {
            let found = mean(&[(1.0, &pass(1.0, 0.5)), (weight, &pass(3.0, 0.1))])["variance"];
            assert!((found - expected).abs() < 1e-6, "{found} for {expected}");
        }
    }

    #[test]
    fn variance_is_that_of_the_picture_before_noise_was_taken_off() {
        let pass = |clean, noisy| {
            let names = ["R", "G", "B", "noisy.R", "noisy.G", "noisy.B"];
            let values = [clean, clean, clean, noisy, noisy, noisy];
            let layers: Vec<_> = names.into_iter().zip(values).collect();
            [&layers[..], &[("variance", 0.0)]].concat()
        };
        let found = mean(&[(1.0, &pass(2.0, 1.0)), (1.0, &pass(2.0, 3.0))])["variance"];
        assert!((found - 1.0).abs() < 1e-6, "{found}");
    }

    #[test]
    fn passes_may_be_in_crops() {
        let names = ["R", "Z"].map(str::to_owned);
        let mut mean = PassMean::new(SIZE, &names).unwrap();
        let windows = ["0,0,1x2", "1,0,2x2", "0,0,3x1", "0,1,3x1"].map(|w| w.parse().unwrap());
        for (index, window) in windows.into_iter().enumerate() {
            if index % 2 == 0 {
                mean.begin_pass(1.0);
            }
            let value = index as f32;
            mean.add(window, &part(window, &[("R", value), ("Z", -value)]));
        }
        let found = mean.finish();
        assert_eq!(found["R"], [1.0, 1.5, 1.5, 1.5, 2.0, 2.0]);
        assert_eq!(found["Z"], [-2.0, -2.0, -2.0, -3.0, -3.0, -3.0]);
    }

    #[test]
    fn a_layer_without_a_rule_is_told() {
        let names = ["R", "velocity"].map(str::to_owned);
        assert_eq!(PassMean::new(SIZE, &names).unwrap_err(), "velocity");
    }
}
