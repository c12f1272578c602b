//! Sums over the rays of a pixel, from which its passes follow.
//!
//! How many numbers there are follows from the passes: the coverages of objects, a block of those of opacity, one of light by
//! component, and one of its parts by group or by order of scattering, each where a pass needs it; and one of those parts by
//! component and half, where they are reconstructed.

use smallvec::SmallVec;

use super::components::LightPart;
use super::light_passes::{PART_NUMBERS, add_part, by_component, means, read_part, share_out};
use super::sample::{OpacityDepths, Sample};
use crate::image::{FAR, Features, cryptomatte};
use crate::math::{ORDERS, RayParts, Rgb};
use crate::scene::{Aov, Aovs, GroupNames};

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
pub struct AovSums {
    /// The passes.
    pub passes: Aovs,
    /// The groups of emitters that the scene has.
    pub groups: GroupNames,
    /// Whether parts of light are gathered by component and half, too.
    pub in_halves: bool,
}

/// What a ray brings to the passes of its pixel.
#[derive(Debug, Clone, Copy)]
pub struct AovRay<'a> {
    /// Its light, and what it sees.
    pub sample: &'a Sample,
    /// Its half, 0 or 1, where pixels are in halves.
    pub half: Option<usize>,
    /// The parts of its light, where they are told apart.
    pub parts: Option<&'a RayParts>,
    /// The coverages of objects that it sees, by their [identifiers](cryptomatte::identifier).
    pub objects: &'a [(u32, f64)],
}

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
    pub fn len(&self) -> usize {
        self.blocks().into_iter().sum()
    }

    /// How many of the numbers are those of objects, of opacity, of light by component, of its parts by group or order, and of
    /// these by component and half.
    fn blocks(&self) -> [usize; 5] {
        let passes = self.passes;
        let of = |is_asked: bool, numbers: usize| if is_asked { numbers } else { 0 };
        let motion = of(passes.has(Aov::Motion), MOTION);
        [
            of(passes.has(Aov::Cryptomatte), cryptomatte::NUMBERS),
            of(passes.has_depths(), DEPTHS + motion),
            // Light by order is shared out as that of media is.
            of(passes.has_light() || passes.has(Aov::Scattered), LIGHT),
            3 * self.parts(),
            PART_NUMBERS * self.parts_in_halves(),
        ]
    }

    /// How many parts the light is told apart by.
    fn parts(&self) -> usize {
        let Self { passes, groups, .. } = self;
        let of = |aov: Aov, parts: usize| if passes.has(aov) { parts } else { 0 };
        of(Aov::Groups, groups.len()) + of(Aov::Scattered, ORDERS)
    }

    /// How many parts are gathered by component and half.
    pub fn parts_in_halves(&self) -> usize {
        if self.in_halves { self.parts() } else { 0 }
    }

    /// The parts that are gathered by component and half, of this many pixels, without light yet.
    pub fn light_parts(&self, pixels: usize) -> Vec<LightPart> {
        (0..self.parts_in_halves()).map(|number| LightPart::new(number, pixels)).collect()
    }

    /// Sets the `pixel` of `parts` by its `sums` over this many rays.
    pub fn set_light_parts(&self, parts: &mut [LightPart], pixel: usize, sums: &[f64], rays: u64) {
        let [.., last] = self.blocks();
        let numbers = sums[sums.len() - last..].chunks_exact(PART_NUMBERS);
        for (part, numbers) in parts.iter_mut().zip(numbers) {
            (part.sums[pixel], part.emission[pixel]) = read_part(numbers, rays);
        }
    }

    /// Whether a pixel has none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The names of the layers, in the order of [`values`](Self::values).
    pub fn layers(&self) -> Vec<String> {
        self.passes.iter().flat_map(|aov| self.layers_of(aov)).collect()
    }

    /// The names of the layers that a pass has.
    pub fn layers_of(&self, aov: Aov) -> Vec<String> {
        match aov {
            Aov::Cryptomatte => cryptomatte::layers().to_vec(),
            Aov::Groups => self.groups.iter().flat_map(|group| aov.layers(group)).collect(),
            Aov::Scattered => Aov::ORDERS.iter().flat_map(|order| aov.layers(order)).collect(),
            _ => aov.layers("").to_vec(),
        }
    }

    /// Adds a ray to the `sums` of its pixel. One that is not [sound](Sample::is_sound) is ignored.
    pub fn add(&self, sums: &mut [f64], ray: &AovRay<'_>) {
        let AovRay { sample, half, parts, objects } = *ray;
        if !sample.is_sound() || sums.len() < self.len() {
            return;
        }
        let [list, depths, light, told_apart, _] = self.blocks();
        let (list, rest) = sums.split_at_mut(list);
        let (depths, rest) = rest.split_at_mut(depths);
        let (light, rest) = rest.split_at_mut(light);
        let (told_apart, in_halves) = rest.split_at_mut(told_apart);
        objects.iter().for_each(|(identifier, coverage)| {
            cryptomatte::add(list, *identifier, *coverage);
        });
        if let Some(seen) = sample.depths.filter(OpacityDepths::is_finite) {
            let OpacityDepths { opacity, first, mean, last, position, motion } = seen;
            let places = [position, motion].into_iter().flat_map(|v| v.to_array());
            let numbers = [1.0, first, mean, last].into_iter().chain(places);
            depths.iter_mut().zip(numbers).for_each(|(sum, number)| *sum += opacity * number);
        }
        let components = sample.components;
        let components =
            [components.media, components.direct, components.indirect, sample.visible_emission];
        let numbers = components.into_iter().flat_map(|rgb| rgb.to_array());
        light.iter_mut().zip(numbers).for_each(|(sum, number)| *sum += number);
        let Some(parts) = parts else { return };
        let numbers = parts.all.as_flattened().iter().copied().map(f64::from);
        told_apart.iter_mut().zip(numbers).for_each(|(sum, number)| *sum += number);
        if let Some(half) = half {
            let sums = in_halves.chunks_exact_mut(PART_NUMBERS);
            sums.enumerate().for_each(|(part, sums)| add_part(sums, half, parts, part));
        }
    }

    /// The values of the layers of `pixel`.
    pub fn values(&self, pixel: &AovPixel<'_>) -> impl Iterator<Item = f64> {
        let missing = pixel.sums.len() < self.len();
        let [list, depths, light, told_apart, _] = if missing { [0; 5] } else { self.blocks() };
        let (list, rest) = pixel.sums.split_at(list);
        let (depths, rest) = rest.split_at(depths);
        let (light, rest) = rest.split_at(light);
        let told_apart = &rest[..told_apart];
        let opacity = depths.first().copied().unwrap_or(0.0);
        let seen = opacity > 0.0;
        let mean = move |sum: f64, nothing: f64| if seen { sum / opacity } else { nothing };
        let depth = [1, 2, 3].map(|at| mean(depths.get(at).copied().unwrap_or(0.0), FAR));
        let place = |first: usize| {
            [0, 1, 2].map(|axis| mean(depths.get(first + axis).copied().unwrap_or(0.0), 0.0))
        };
        let (position, motion) = (place(4), place(DEPTHS));
        let parts = if light.is_empty() {
            [Rgb::ZERO; 5]
        } else {
            by_component(light, pixel.rays, pixel.mean, pixel.shown)
        };
        let features = pixel.features;
        let mut values: SmallVec<[f64; 64]> = SmallVec::new();
        for aov in self.passes.iter() {
            values.extend(match aov {
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
                Aov::Cryptomatte => {
                    let ranks = cryptomatte::ranks(list, pixel.rays.max(1) as f64);
                    values.extend(ranks.into_iter().map(f64::from));
                    continue;
                }
                Aov::Groups | Aov::Scattered => {
                    let all = if aov == Aov::Groups { pixel.shown } else { parts[0] };
                    let told_apart = means(told_apart, pixel.rays);
                    let told_apart = share_out(told_apart, all);
                    values.extend(told_apart.flat_map(|part| part.to_array()));
                    continue;
                }
            });
        }
        values.into_iter()
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::film::{Accumulator, Components};
    use crate::math::MAX_GROUPS;
    use crate::scene::Scene;
    use proptest::prelude::*;

    /// A ray without parts or objects.
    fn ray(sample: &Sample) -> AovRay<'_> {
        AovRay { sample, half: None, parts: None, objects: &[] }
    }

    fn pixel<'a>(sums: &'a [f64], samples: &Accumulator, shown: Rgb) -> AovPixel<'a> {
        let (rays, mean) = (samples.count(), samples.mean());
        AovPixel { sums, rays, mean, shown, features: Features::default() }
    }

    proptest! {
        #[test]
        fn light_adds_up_to_the_picture(
            rays in prop::collection::vec(prop::array::uniform9(0.0_f64..10.0), 1..20), more in -1.0_f64..1.0,
        ) {
            let layout = AovSums { passes: Aov::LIGHT.into_iter().collect(), ..AovSums::default() };
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
                layout.add(&mut sums, &ray(&sample));
                layout.add(&mut sums, &ray(&Sample { radiance: Rgb::NAN, ..sample }));
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

    /// Of groups that are 1, 2 and 3 parts of the light, with what is shown of other rays and what rounding leaves.
    #[test]
    fn groups_are_shared_by_their_light() {
        let lamp = |name: &str| {
            format!(
                "[[light]]\ntype = 'point'\nposition = [0, 1, 0]\nintensity = 1\ngroup = '{name}'\n"
            )
        };
        let camera = "[camera]\nposition = [0, 0, 1]\ntarget = [0, 0, 0]\n".to_owned();
        let scene = Scene::of_text(&(camera + &["a", "b", "c"].map(lamp).concat()));
        let (passes, groups) = ("groups".parse().unwrap(), scene.groups.names);
        let layout = AovSums { passes, groups, ..AovSums::default() };
        let names = layout.layers();
        assert_eq!((names.len(), names[3].as_str(), layout.len()), (9, "group.b.R", 9));
        let (mut sums, mut samples) = (vec![0.0; layout.len()], Accumulator::default());
        let mut groups = [[0.0; 3]; MAX_GROUPS];
        for (group, part) in groups.iter_mut().zip([1.0, 2.0, 3.0]) {
            *group = [part, 0.0, 0.1 * part];
        }
        for light in [6.0, 6.0 + 1e-9] {
            let radiance = Rgb::new(light, 0.0, 0.1 * light);
            let parts = RayParts { all: groups, ..RayParts::default() };
            let sample = Sample { radiance, ..Sample::default() };
            let unsound = Sample { radiance: Rgb::NAN, ..sample };
            for sample in [&sample, &unsound] {
                layout.add(&mut sums, &AovRay { parts: Some(&parts), ..ray(sample) });
            }
            samples.add(sample);
        }
        let shown = Rgb::new(12.0, 0.5, 0.0);
        let values: Vec<f64> = layout.values(&pixel(&sums, &samples, shown)).collect();
        let right = [2.0, 0.5, 0.0, 4.0, 0.0, 0.0, 6.0, 0.0, 0.0];
        let off = values.iter().zip(right).map(|(value, right)| (value - right).abs());
        assert!(values.len() == 9 && off.fold(0.0, f64::max) < 1e-6, "{values:?}");
    }

    /// Of light of media that is 1, 2 and 5 parts by order, beside a surface, with what is gathered for other rays.
    #[test]
    fn orders_add_up_to_the_light_of_media() {
        let layout = AovSums { passes: "media,scattered".parse().unwrap(), ..AovSums::default() };
        assert_eq!((layout.len(), layout.layers()[9].as_str()), (LIGHT + 9, "scattered.more.R"));
        let (mut sums, mut samples) = (vec![0.0; layout.len()], Accumulator::default());
        let mut parts = [[0.0; 3]; MAX_GROUPS];
        for (order, part) in parts.iter_mut().zip([1.0, 2.0, 5.0]) {
            *order = [part, 0.0, 0.5 * part];
        }
        let components = Components {
            media: Rgb::new(8.0, 0.0, 4.0),
            direct: Rgb::splat(3.0),
            indirect: Rgb::ZERO,
        };
        let radiance = components.media + components.direct;
        let parts = RayParts { all: parts, ..RayParts::default() };
        let sample = Sample { radiance, components, ..Sample::default() };
        layout.add(&mut sums, &AovRay { parts: Some(&parts), ..ray(&sample) });
        samples.add(sample);
        let shown = radiance + Rgb::new(8.0, 0.0, 0.0);
        let values: Vec<f64> = layout.values(&pixel(&sums, &samples, shown)).collect();
        let right = [16.0, 0.0, 4.0, 2.0, 0.0, 0.5, 4.0, 0.0, 1.0, 10.0, 0.0, 2.5];
        let off = values.iter().zip(right).map(|(value, right)| (value - right).abs());
        assert!(values.len() == 12 && off.fold(0.0, f64::max) < 1e-6, "{values:?}");
    }

    #[test]
    fn depths_are_means_by_opacity() {
        let passes = "depth,position,motion".parse().unwrap();
        let layout = AovSums { passes, ..AovSums::default() };
        let mut sums = vec![0.0; layout.len()];
        let seen = |opacity, mean, x| {
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
        for sample in [seen(1.0, 2.0, 3.0), seen(0.5, 5.0, 6.0), Sample::default()] {
            layout.add(&mut sums, &ray(&sample));
        }
        let seen: Vec<f64> = layout.values(&pixel(&sums, &samples, Rgb::ZERO)).collect();
        assert_eq!(seen, [1.0, 3.0, 9.0, 4.0, 0.0, 0.0, 0.0, 4.0, 0.0]);
        assert_eq!(layout.layers()[..3], ["depth.first", "depth.mean", "depth.last"]);
    }

    #[test]
    fn objects_are_told_beside_others() {
        let passes = "emission,cryptomatte".parse().unwrap();
        let layout = AovSums { passes, ..AovSums::default() };
        let mut sums = vec![0.0; layout.len()];
        let mut samples = Accumulator::default();
        let sample = Sample { radiance: Rgb::ONE, visible_emission: Rgb::ONE, ..Sample::default() };
        let [a, b] = ["a", "b"].map(cryptomatte::identifier);
        for objects in [&[(a, 0.25), (b, 0.5)][..], &[(b, 0.5)], &[]] {
            layout.add(&mut sums, &AovRay { objects, ..ray(&sample) });
            let unsound = Sample { radiance: Rgb::NAN, ..sample };
            layout.add(&mut sums, &AovRay { objects: &[(a, 1.0)], ..ray(&unsound) });
            samples.add(sample);
        }
        let values: Vec<f64> = layout.values(&pixel(&sums, &samples, Rgb::ONE)).collect();
        let expected = [1.0 / 3.0, 0.25 / 3.0].map(|value| f64::from(value as f32));
        assert_eq!(values[..3], [1.0; 3]);
        assert_eq!((values[3] as f32).to_bits(), b);
        assert_eq!((values[5] as f32).to_bits(), a);
        assert_eq!([values[4], values[6]], expected);
        assert_eq!((values.len(), layout.layers().len()), (15, 15));
    }
}
