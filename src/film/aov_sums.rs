//! Sums over the rays of a pixel, from which its passes follow.
//!
//! How many numbers there are follows from the passes: a block of those of opacity, and one of light, each where a pass needs
//! it. Further layers of light that rays tell apart are further numbers behind them.

use glam::DVec3;

use super::sample::{OpacityDepths, Sample};
use crate::image::{FAR, Features};
use crate::math::Rgb;
use crate::scene::{Aov, Aovs};

/// Opacity, the three depths and the three coordinates of the position, these six weighed by opacity.
///
/// Unit: count. Definition: of the block.
const DEPTHS: usize = 7;

/// Motion, weighed by opacity, behind the depths.
///
/// Unit: count. Definition: of the block.
const MOTION: usize = 3;

/// Light of media, direct and indirect light of surfaces, and emission.
///
/// Unit: count. Definition: of the block.
const LIGHT: usize = 12;

/// The numbers of a pixel that its passes follow from.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct AovSums(pub Aovs);

/// A pixel whose passes are asked for.
#[derive(Debug, Clone, Copy)]
pub struct AovPixel<'a> {
    /// Its sums.
    pub sums: &'a [f64],
    /// The number of its rays.
    pub rays: u64,
    /// Mean radiance of its rays, W/(m² sr).
    pub mean: Rgb,
    /// The radiance that the picture shows, W/(m² sr).
    pub shown: Rgb,
    /// Its features.
    pub features: Features,
}

impl AovSums {
    /// How many numbers a pixel has.
    pub fn len(self) -> usize {
        let light = if self.0.has_light() { LIGHT } else { 0 };
        self.depths() + light
    }

    /// How many numbers are those of opacity.
    fn depths(self) -> usize {
        let motion = if self.0.has(Aov::Motion) { MOTION } else { 0 };
        if self.0.has_depths() { DEPTHS + motion } else { 0 }
    }

    /// Whether a pixel has none.
    pub fn is_empty(self) -> bool {
        self.len() == 0
    }

    /// The names of the layers, in the order of [`values`](Self::values).
    pub fn layers(self) -> Vec<String> {
        self.0.iter().flat_map(Aov::layers).collect()
    }

    /// Adds a ray to the `sums` of its pixel. One that is not [sound](Sample::is_sound) is ignored.
    pub fn add(self, sums: &mut [f64], sample: &Sample) {
        if !sample.is_sound() {
            return;
        }
        let (depths, light) = self.split(sums.len());
        if let Some(seen) = sample.depths.filter(OpacityDepths::is_finite)
            && depths > 0
        {
            let OpacityDepths { opacity, first, mean, last, position, motion } = seen;
            let places = [position, motion].into_iter().flat_map(|v| v.to_array());
            let numbers = [1.0, first, mean, last].into_iter().chain(places);
            sums[..depths]
                .iter_mut()
                .zip(numbers)
                .for_each(|(sum, number)| *sum += opacity * number);
        }
        if light > 0 {
            let parts = sample.components;
            let parts = [parts.media, parts.direct, parts.indirect, sample.visible_emission];
            let numbers = parts.into_iter().flat_map(|rgb| rgb.to_array());
            sums[depths..].iter_mut().zip(numbers).for_each(|(sum, number)| *sum += number);
        }
    }

    /// How many of `numbers` are those of opacity, and how many those of light.
    fn split(self, numbers: usize) -> (usize, usize) {
        let depths = self.depths().min(numbers);
        (depths, numbers - depths)
    }

    /// The values of the layers of `pixel`.
    pub fn values(self, pixel: &AovPixel<'_>) -> impl Iterator<Item = f64> {
        let (depths, light) = pixel.sums.split_at(self.split(pixel.sums.len()).0);
        let opacity = depths.first().copied().unwrap_or(0.0);
        let seen = opacity > 0.0;
        let mean = move |sum: f64, nothing: f64| if seen { sum / opacity } else { nothing };
        let depth = [1, 2, 3].map(|at| mean(depths.get(at).copied().unwrap_or(0.0), FAR));
        let place = |first: usize| {
            [0, 1, 2].map(|axis| mean(depths.get(first + axis).copied().unwrap_or(0.0), 0.0))
        };
        let (position, motion) = (place(4), place(DEPTHS));
        let parts = if light.is_empty() { [Rgb::ZERO; 5] } else { parts(light, pixel) };
        let features = pixel.features;
        self.0.iter().flat_map(move |aov| match aov {
            Aov::Depth => depth,
            Aov::Position => position,
            Aov::Motion => motion,
            Aov::Albedo => features.albedo.map(f64::from),
            Aov::Normal => features.normal.map(f64::from),
            Aov::Media => parts[0].to_array(),
            Aov::Direct => parts[1].to_array(),
            Aov::Indirect => parts[2].to_array(),
            Aov::Emission => parts[3].to_array(),
            Aov::Specular => parts[4].to_array(),
        })
    }
}

/// The light of a pixel by component, W/(m² sr), in the order of [`Aov::LIGHT`]: together it is what the picture shows.
fn parts(sums: &[f64], pixel: &AovPixel<'_>) -> [Rgb; 5] {
    let rays = pixel.rays.max(1) as f64;
    let [media, direct, indirect, emission] =
        std::array::from_fn(|part| DVec3::from_slice(&sums[3 * part..]) / rays);
    let known: [Rgb; 4] = [media, direct, indirect, emission];
    let left = pixel.mean - known.iter().sum::<Rgb>();
    let size: Rgb = pixel.mean.abs() + known.iter().map(|part| part.abs()).sum::<Rgb>();
    // What rounding leaves is nothing.
    let specular = Rgb::select(left.abs().cmpgt(size * f64::from(f32::EPSILON)), left, Rgb::ZERO);
    // Where a pixel has not got all rays, the picture shows what is gathered for all of them in its right share.
    let more = pixel.shown - pixel.mean;
    let gathered = media.abs() + indirect.abs();
    let share =
        |part: Rgb| Rgb::select(gathered.cmpgt(Rgb::ZERO), more * part.abs() / gathered, Rgb::ZERO);
    let others = Rgb::select(gathered.cmpgt(Rgb::ZERO), Rgb::ZERO, more);
    [media + share(media), direct, indirect + share(indirect), emission, specular + others]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::{Accumulator, Components};
    use proptest::prelude::*;

    fn pixel<'a>(sums: &'a [f64], samples: &Accumulator, shown: Rgb) -> AovPixel<'a> {
        let (rays, mean) = (samples.count(), samples.mean());
        AovPixel { sums, rays, mean, shown, features: Features::default() }
    }

    proptest! {
        #[test]
        fn light_adds_up_to_the_picture(
            rays in prop::collection::vec(prop::array::uniform9(0.0_f64..10.0), 1..20), more in -1.0_f64..1.0,
        ) {
            let layout = AovSums(Aov::LIGHT.into_iter().collect());
            let mut sums = vec![0.0; layout.len()];
            let mut samples = Accumulator::default();
            for [a, b, c, d, e, f, g, h, i] in rays {
                let [media, direct] = [Rgb::new(a, b, c), Rgb::new(d, e, 0.0)];
                let [indirect, emission] = [Rgb::splat(f), Rgb::new(0.0, g, h)];
                let sample = Sample {
                    radiance: media + direct + indirect + emission + Rgb::new(i, 0.0, 0.0),
                    components: Components { media, direct, indirect },
                    visible_emission: emission,
                    ..Sample::default()
                };
                layout.add(&mut sums, &sample);
                layout.add(&mut sums, &Sample { radiance: Rgb::NAN, ..sample });
                samples.add(sample);
            }
            let shown = (samples.mean() + more).max(Rgb::ZERO);
            let values: Vec<f64> = layout.values(&pixel(&sums, &samples, shown)).collect();
            for channel in 0..3 {
                let sum: f64 = values.iter().skip(channel).step_by(3).sum();
                prop_assert!((sum - shown[channel]).abs() < 1e-5, "{sum} for {shown}");
            }
            // Nothing but what is told apart is left for mirrors.
            prop_assert_eq!(&values[13..], &[0.0, 0.0]);
        }
    }

    #[test]
    fn depths_are_means_by_opacity() {
        let layout = AovSums("depth,position,motion".parse().unwrap());
        let mut sums = vec![0.0; layout.len()];
        let ray = |opacity, mean, x| {
            let depths = OpacityDepths {
                opacity,
                first: 1.0,
                mean,
                last: 9.0,
                position: DVec3::X * x,
                motion: DVec3::Y * x,
            };
            Sample { depths: Some(depths), ..Sample::default() }
        };
        let samples = Accumulator::default();
        let nothing: Vec<f64> = layout.values(&pixel(&sums, &samples, Rgb::ZERO)).collect();
        assert_eq!(nothing, [FAR, FAR, FAR, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
        for sample in [ray(1.0, 2.0, 3.0), ray(0.5, 5.0, 6.0), Sample::default()] {
            layout.add(&mut sums, &sample);
        }
        let seen: Vec<f64> = layout.values(&pixel(&sums, &samples, Rgb::ZERO)).collect();
        assert_eq!(seen, [1.0, 3.0, 9.0, 4.0, 0.0, 0.0, 0.0, 4.0, 0.0]);
        assert_eq!(layout.layers()[..3], ["depth.first", "depth.mean", "depth.last"]);
    }
}
