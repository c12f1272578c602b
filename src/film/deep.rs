//! Deep pixels: what media and surfaces show of themselves, by distance.
//!
//! Several rays of a pixel tell how its opacity grows with distance. That is cut into samples where equal shares of it
//! are reached, each of which gets its share of the light that the picture has there, so that flattening the samples
//! ("Interpreting OpenEXR Deep Pixels", Hillman 2013) gives the pixel of the picture.

use crate::image::{DeepSample, FAR};

/// Samples of media in a pixel.
///
/// Unit: count. Limit: on the size of a file; between two samples opacity is off by less than a hundredth.
const MEDIA_SAMPLES: usize = 16;

/// Samples of surfaces in a pixel.
///
/// Unit: count. Limit: on the size of a file; more surfaces than these hardly meet in a pixel.
const SURFACE_SAMPLES: usize = 4;

/// Length of a stretch over its distance, at least: there is something to divide by.
///
/// Unit: none. Limit: on the accuracy of distances, far below that of an f32.
const SHORTEST: f64 = 1e-9;

/// Bytes of a pixel, at most, with those of its file.
///
/// Unit: bytes. Derivation: its samples, and what is encoded of them, twice while it is joined.
pub const DEEP_BYTES: usize = size_of::<Vec<DeepSample>>()
    + 3 * (MEDIA_SAMPLES + 2 * SURFACE_SAMPLES) * size_of::<DeepSample>();

/// What the rays of a pixel meet.
#[derive(Debug, Clone, Default)]
pub struct DeepPixel {
    /// Stretches of media.
    media: Vec<Stretch>,
    /// Surfaces: distance in metres, and how much is seen of each.
    surfaces: Vec<[f64; 2]>,
}

/// A stretch of a ray through media.
#[derive(Debug, Clone, Copy)]
struct Stretch {
    /// Distances in metres at which it begins and ends.
    z: [f64; 2],
    /// How much is seen of it, 0 to 1: opacity times the transmittance before it.
    seen: f64,
}

/// The pixel of the picture that deep samples flatten to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FlatPixel {
    /// Coverage, 0 to 1.
    pub alpha: f64,
    /// Light of media, W/(m² sr).
    pub media: [f64; 3],
    /// All other light, W/(m² sr).
    pub other: [f64; 3],
}

/// What is seen between two distances, before light is shared.
#[derive(Debug, Clone, Copy)]
struct SeenSample {
    z: [f64; 2],
    seen: f64,
    is_medium: bool,
}

impl DeepPixel {
    /// Forgets what it met.
    pub fn clear(&mut self) {
        self.media.clear();
        self.surfaces.clear();
    }

    /// Adds a stretch of media between two distances in metres, of which so much is `seen`, 0 to 1.
    pub fn add_media(&mut self, z: [f64; 2], seen: f64) {
        self.media.push(Stretch { z, seen });
    }

    /// Adds a surface at a distance in metres of which so much is `seen`, 0 to 1: 0 of one that gives light and covers
    /// nothing, as the environment at [`FAR`].
    pub fn add_surface(&mut self, z: f64, seen: f64) {
        self.surfaces.push([z.min(FAR), seen]);
    }

    /// The samples from near to far, which flatten to `flat`.
    pub fn samples(&self, flat: &FlatPixel) -> Vec<DeepSample> {
        let surfaces = self.seen_surfaces();
        let mut seen = self.seen_media(&surfaces);
        seen.extend(surfaces);
        if seen.is_empty() {
            let nothing = FlatPixel { alpha: 0.0, media: [0.0; 3], other: [0.0; 3] };
            if *flat == nothing {
                return Vec::new();
            }
            seen.push(SeenSample { z: [FAR; 2], seen: 1.0, is_medium: false });
        }
        // What ends at a surface lies before it.
        seen.sort_by(|a, b| (a.z[0] + a.z[1]).total_cmp(&(b.z[0] + b.z[1])));
        let is_missed = flat.alpha > 0.0 && seen.iter().all(|sample| sample.seen <= 0.0);
        if let Some(last) = seen.last_mut().filter(|_| is_missed) {
            // The rays have met nothing that covers the pixel.
            last.seen = 1.0;
        }
        let lights = Lights::new(flat, &seen);
        let mut left = 1.0;
        let sample = |of: &SeenSample| {
            // What is behind opaque samples is not seen.
            (left > 0.0).then(|| {
                let alpha = (lights.covered(of, flat.alpha) / left).clamp(0.0, 1.0) as f32;
                let radiance = lights.of(of).map(|light| (light / left) as f32);
                left *= 1.0 - f64::from(alpha);
                DeepSample { z: of.z.map(|z| z as f32), radiance, alpha }
            })
        };
        seen.iter().filter_map(sample).collect()
    }

    /// Its surfaces, those near one another as one, from near to far.
    fn seen_surfaces(&self) -> Vec<SeenSample> {
        let covers = |surface: &&[f64; 2]| surface[1] > 0.0;
        let mut surfaces: Vec<[f64; 2]> = self.surfaces.iter().filter(covers).copied().collect();
        if surfaces.is_empty() {
            surfaces.extend(self.surfaces.first());
        }
        surfaces.sort_by(|a, b| a[0].total_cmp(&b[0]));
        while surfaces.len() > SURFACE_SAMPLES {
            let gap = |pair: &[[f64; 2]]| (pair[1][0] - pair[0][0]) / pair[1][0];
            let nearest = surfaces.windows(2).map(gap).enumerate();
            let nearest = nearest.min_by(|a, b| a.1.total_cmp(&b.1));
            let Some((index, _)) = nearest else { break };
            let [far, more] = surfaces.remove(index + 1);
            let [near, seen] = &mut surfaces[index];
            *near += (far - *near) * more / (*seen + more);
            *seen += more;
        }
        let sample = |[z, seen]: [f64; 2]| SeenSample { z: [z; 2], seen, is_medium: false };
        surfaces.into_iter().map(sample).collect()
    }

    /// Its media, in stretches that are seen alike, and that end at `surfaces` where those are between.
    fn seen_media(&self, surfaces: &[SeenSample]) -> Vec<SeenSample> {
        let growth = Growth::new(&self.media);
        let Some([first, last]) = growth.ends() else { return Vec::new() };
        let quantiles = (1..MEDIA_SAMPLES).map(|k| growth.reached(k as f64 / MEDIA_SAMPLES as f64));
        let between = surfaces.iter().map(|surface| surface.z[0]);
        let mut knots: Vec<f64> =
            quantiles.chain(between.filter(|z| *z > first && *z < last)).collect();
        knots.extend([first, last]);
        knots.sort_by(f64::total_cmp);
        let sample = |z: &[f64]| SeenSample {
            z: [z[0], z[1]],
            seen: growth.until(z[1]) - growth.until(z[0]),
            is_medium: true,
        };
        let samples: Vec<SeenSample> = knots.windows(2).map(sample).collect();
        if growth.until(last) > 0.0 {
            samples.into_iter().filter(|sample| sample.seen > 0.0).collect()
        } else {
            // They give off light, and cover nothing.
            vec![SeenSample { z: [first, last], seen: 0.0, is_medium: true }]
        }
    }
}

/// How much is seen of the media of a pixel up to a distance: linear between the ends of stretches.
struct Growth {
    /// Distance in metres, and how much is seen up to it.
    points: Vec<[f64; 2]>,
}

impl Growth {
    fn new(stretches: &[Stretch]) -> Self {
        let mut changes: Vec<[f64; 2]> = Vec::new();
        for Stretch { z: [begin, end], seen } in stretches {
            let end = end.max(begin * (1.0 + SHORTEST) + f64::MIN_POSITIVE);
            let rate = seen / (end - begin);
            changes.extend([[*begin, rate], [end, -rate]]);
        }
        changes.sort_by(|a, b| a[0].total_cmp(&b[0]));
        let (mut rate, mut seen, mut points) = (0.0_f64, 0.0, Vec::<[f64; 2]>::new());
        for [z, change] in changes {
            match points.last_mut() {
                Some(last) if last[0] == z => (),
                Some(last) => {
                    seen += rate.max(0.0) * (z - last[0]);
                    points.push([z, seen]);
                }
                None => points.push([z, 0.0]),
            }
            rate += change;
        }
        Self { points }
    }

    /// Where it begins and ends.
    fn ends(&self) -> Option<[f64; 2]> {
        Some([self.points.first()?[0], self.points.last()?[0]])
    }

    /// How much is seen up to `z`.
    fn until(&self, z: f64) -> f64 {
        let after = self.points.partition_point(|point| point[0] <= z);
        match (after.checked_sub(1).map(|before| self.points[before]), self.points.get(after)) {
            (None, _) => 0.0,
            (Some(before), None) => before[1],
            (Some(before), Some(after)) => {
                before[1] + (after[1] - before[1]) * (z - before[0]) / (after[0] - before[0])
            }
        }
    }

    /// The distance at which the `share` of all is seen.
    fn reached(&self, share: f64) -> f64 {
        let all = self.points.last().map_or(0.0, |last| last[1]);
        let after = self.points.partition_point(|point| point[1] < share * all).max(1);
        let [Some(before), Some(after)] = [after - 1, after].map(|at| self.points.get(at)) else {
            return self.points.last().map_or(0.0, |last| last[0]);
        };
        if after[1] > before[1] {
            before[0] + (after[0] - before[0]) * (share * all - before[1]) / (after[1] - before[1])
        } else {
            before[0]
        }
    }
}

/// The light that samples share.
struct Lights {
    /// Of surfaces and of media.
    light: [[f64; 3]; 2],
    /// How much is seen of each.
    seen: [f64; 2],
    /// Samples of each.
    count: [usize; 2],
}

impl Lights {
    fn new(flat: &FlatPixel, samples: &[SeenSample]) -> Self {
        let mut lights = Self { light: [flat.other, flat.media], seen: [0.0; 2], count: [0; 2] };
        for sample in samples {
            let kind = usize::from(sample.is_medium);
            lights.seen[kind] += sample.seen;
            lights.count[kind] += 1;
        }
        // Light of what the rays have not met is that of what they have.
        for (none, other) in [(0, 1), (1, 0)] {
            if lights.count[none] == 0 {
                let light = std::mem::take(&mut lights.light[none]);
                for (sum, more) in lights.light[other].iter_mut().zip(light) {
                    *sum += more;
                }
            }
        }
        lights
    }

    /// How much of the pixel, which is covered by `alpha`, a sample covers. Media cover what is seen of them, as far as that
    /// is less than `alpha`, and surfaces the rest: a shadow catcher may cover less than is seen of it.
    fn covered(&self, sample: &SeenSample, alpha: f64) -> f64 {
        let [surfaces, media] = self.seen;
        let of_media = if surfaces > 0.0 { media.min(alpha) } else { alpha };
        let (of_kind, all) =
            if sample.is_medium { (of_media, media) } else { (alpha - of_media, surfaces) };
        if all > 0.0 { of_kind * sample.seen / all } else { 0.0 }
    }

    /// The light of a sample, W/(m² sr).
    fn of(&self, sample: &SeenSample) -> [f64; 3] {
        let kind = usize::from(sample.is_medium);
        let share = if self.seen[kind] > 0.0 {
            sample.seen / self.seen[kind]
        } else {
            1.0 / self.count[kind] as f64
        };
        self.light[kind].map(|light| light * share)
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// Radiance and alpha of `samples` over one another.
    fn flattened(samples: &[DeepSample]) -> [f64; 4] {
        let mut sum = [0.0; 4];
        for DeepSample { radiance: [r, g, b], alpha, .. } in samples {
            let left = 1.0 - sum[3];
            for (sum, value) in sum.iter_mut().zip([r, g, b, alpha]) {
                *sum += left * f64::from(*value);
            }
        }
        sum
    }

    proptest! {
        #[test]
        fn samples_flatten_to_the_pixel(
            stretches in prop::collection::vec((0.1_f64..50.0, 0.0_f64..9.0, 0.0_f64..0.2), 0..9),
            surfaces in prop::collection::vec((0.1_f64..90.0, 0.0_f64..0.2), 0..9),
            alpha in 0.0_f64..1.0, light in prop::array::uniform6(0.0_f64..9.0),
        ) {
            let mut pixel = DeepPixel::default();
            stretches.iter().for_each(|(z, length, seen)| pixel.add_media([*z, z + length], *seen));
            surfaces.iter().for_each(|(z, seen)| pixel.add_surface(*z, *seen));
            let [r, g, b, u, v, w] = light;
            let flat = FlatPixel { alpha, media: [r, g, b], other: [u, v, w] };
            let samples = pixel.samples(&flat);
            let right = [r + u, g + v, b + w, alpha];
            let found = flattened(&samples);
            for (found, right) in found.iter().zip(right) {
                prop_assert!((found - right).abs() <= 1e-4 * right.max(1.0), "{:?} {:?}", found, right);
            }
            let ends = samples.iter().flat_map(|sample| sample.z).collect::<Vec<_>>();
            prop_assert!(ends.is_sorted(), "{:?}", ends);
            prop_assert!(samples.len() <= MEDIA_SAMPLES + 2 * SURFACE_SAMPLES);
            prop_assert!(samples.iter().all(|sample| (0.0..=1.0).contains(&sample.alpha)));
        }
    }

    #[test]
    fn samples_lie_where_opacity_is() {
        let mut pixel = DeepPixel::default();
        pixel.add_media([10.0, 20.0], 0.5);
        pixel.add_media([15.0, 15.0], 0.1);
        pixel.add_surface(12.0, 0.2);
        let flat = FlatPixel { alpha: 0.8, media: [1.2, 0.6, 0.0], other: [0.0, 0.3, 2.0] };
        let samples = pixel.samples(&flat);
        let before = |z: f64| {
            let near: Vec<DeepSample> =
                samples.iter().filter(|sample| f64::from(sample.z[1]) <= z).copied().collect();
            flattened(&near)
        };
        // A fifth of the stretch, then the surface, then the stretch that is as thin as a leaf.
        assert!((before(11.999)[3] - 0.1).abs() < 0.04, "{:?}", before(11.999));
        assert!((before(12.0)[3] - 0.3).abs() < 1e-4, "{:?}", before(12.0));
        assert!((before(12.0)[2] - 2.0).abs() < 1e-4, "{:?}", before(12.0));
        assert!((before(15.01)[3] - 0.55).abs() < 0.04, "{:?}", before(15.01));
    }

    #[test]
    fn light_without_opacity_covers_nothing() {
        let mut pixel = DeepPixel::default();
        pixel.add_media([1.0, 2.0], 0.0);
        pixel.add_surface(5.0, 1.0);
        let flat = FlatPixel { alpha: 1.0, media: [4.0; 3], other: [1.0; 3] };
        let [flame, wall] = pixel.samples(&flat)[..] else { panic!("two samples") };
        assert_eq!(flame, DeepSample { z: [1.0, 2.0], radiance: [4.0; 3], alpha: 0.0 });
        assert_eq!(wall, DeepSample { z: [5.0; 2], radiance: [1.0; 3], alpha: 1.0 });
        let mut sky = DeepPixel::default();
        sky.add_media([1.0, 2.0], 0.5);
        sky.add_surface(FAR, 0.0);
        let flat = FlatPixel { alpha: 0.5, media: [4.0; 3], other: [1.0; 3] };
        let samples = sky.samples(&flat);
        let last = samples.last().unwrap();
        assert_eq!((last.z, last.alpha), ([FAR as f32; 2], 0.0));
        assert!((last.radiance[0] - 2.0).abs() < 1e-4, "behind half of the light: {last:?}");
        assert!(
            DeepPixel::default()
                .samples(&FlatPixel { alpha: 0.0, media: [0.0; 3], other: [0.0; 3] })
                .is_empty()
        );
    }
}
