//! Light of a pixel by the component that it belongs to, in two halves, and what the pixel sees.
//!
//! Halves have rays and photons of their own, so that what differs between them is noise, and what one
//! predicts of the other is not.

use glam::Vec3;

use super::sample::Sample;
use crate::math::luminance;

/// Sums over the rays of one half of a pixel.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct HalfSums {
    /// Number of rays.
    pub rays: f32,
    /// Radiance, W/(m² sr).
    pub radiance: Vec3,
    /// Light of media, W/(m² sr).
    pub media: Vec3,
    /// Direct light of surfaces, W/(m² sr).
    pub direct: Vec3,
    /// Indirect light of surfaces, W/(m² sr).
    pub indirect: Vec3,
    /// Reflectance of surfaces times the transmittance before them.
    pub reflectance: Vec3,
    /// Opacity of media.
    pub opacity: f32,
}

/// Light of one half of a pixel, all of it or a part: sums over rays, W/(m² sr).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LightSums {
    /// Radiance, of all components and what is in none of them.
    pub radiance: Vec3,
    /// Light of media.
    pub media: Vec3,
    /// Direct light of surfaces.
    pub direct: Vec3,
    /// Indirect light of surfaces.
    pub indirect: Vec3,
}

impl HalfSums {
    /// All of its light.
    pub const fn light(&self) -> LightSums {
        let Self { radiance, media, direct, indirect, .. } = *self;
        LightSums { radiance, media, direct, indirect }
    }
}

/// Sums over what all rays of a pixel see.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SeenSums {
    /// Number of rays that see a surface.
    pub surfaces: f32,
    /// Where those are, in metres from the camera.
    pub offset: Vec3,
    /// Their normals.
    pub normal: Vec3,
    /// Number of rays that see a mirror or glass.
    pub specular: f32,
    /// Number of rays that pass media.
    pub media: f32,
    /// Natural logarithm of the distance in metres at which those have half of their opacity.
    pub log_distance: f32,
}

/// Components of one pixel, and what it sees.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PixelComponents {
    /// Both halves.
    pub halves: [HalfSums; 2],
    /// What all rays see.
    pub seen: SeenSums,
}

impl PixelComponents {
    /// All light of both halves.
    pub fn light(&self) -> [LightSums; 2] {
        self.halves.each_ref().map(HalfSums::light)
    }

    /// Number of 64-bit words of [`to_bits`](Self::to_bits).
    ///
    /// Unit: count. Definition: of the format of checkpoints.
    pub const WORDS: usize = 22;

    /// Number of rays.
    pub fn rays(&self) -> f32 {
        self.halves.iter().map(|half| half.rays).sum()
    }

    /// Mean opacity of media over all rays.
    pub fn opacity(&self) -> f32 {
        let [a, b] = &self.halves;
        (a.opacity + b.opacity) / self.rays().max(1.0)
    }

    /// Adds a ray to `half`, 0 or 1. One that is not [sound](Sample::is_sound) is ignored.
    pub fn add(&mut self, half: usize, sample: &Sample) {
        if !sample.is_sound() {
            return;
        }
        let Sample { radiance, components: light, seen, transmittance, .. } = sample;
        let sums = &mut self.halves[half];
        sums.rays += 1.0;
        sums.radiance += radiance.as_vec3();
        sums.media += light.media.as_vec3();
        sums.direct += light.direct.as_vec3();
        sums.indirect += light.indirect.as_vec3();
        self.seen.specular += f32::from(u8::from(seen.specular));
        if let Some(surface) = seen.surface {
            sums.reflectance += surface.reflectance.as_vec3();
            self.seen.surfaces += 1.0;
            self.seen.offset += surface.offset.as_vec3();
            self.seen.normal += surface.normal.as_vec3();
        }
        if let Some(distance) = seen.media_distance {
            sums.opacity += (1.0 - transmittance) as f32;
            self.seen.media += 1.0;
            self.seen.log_distance += distance.max(f64::from(f32::MIN_POSITIVE)).ln() as f32;
        }
    }

    /// Noise of its mean luminance, as what differs between the halves A and B tells it: with a and b rays the mean square of
    /// (a b)^(1/2) (A - B) / (a + b) is the variance of the mean. 0 where a half has no ray.
    pub fn noise(&self) -> f32 {
        let [a, b] = &self.halves;
        if a.rays == 0.0 || b.rays == 0.0 {
            return 0.0;
        }
        let difference = luminance((a.radiance / a.rays - b.radiance / b.rays).as_dvec3()) as f32;
        (a.rays * b.rays).sqrt() * difference / (a.rays + b.rays)
    }

    /// The state as the bits of its numbers, for checkpoints.
    pub fn to_bits(&self) -> [u64; Self::WORDS] {
        let half = |sums: &HalfSums| {
            let HalfSums { rays, radiance, media, direct, indirect, reflectance, opacity } = *sums;
            let sums = [radiance, media, direct, indirect, reflectance].map(|sum| sum.to_array());
            [&[rays, opacity][..], sums.as_flattened()].concat()
        };
        let SeenSums { surfaces, offset, normal, specular, media, log_distance } = self.seen;
        let counts = [surfaces, specular, media, log_distance];
        let seen = [&counts[..], &offset.to_array(), &normal.to_array()];
        let numbers = [half(&self.halves[0]), half(&self.halves[1]), seen.concat()].concat();
        std::array::from_fn(|word| {
            let [low, high] = [numbers[2 * word], numbers[2 * word + 1]].map(f32::to_bits);
            u64::from(low) | u64::from(high) << 32
        })
    }

    /// Restores the state from [`to_bits`](Self::to_bits).
    pub fn from_bits(bits: &[u64; Self::WORDS]) -> Self {
        let mut numbers =
            bits.iter().flat_map(|word| [*word as u32, (word >> 32) as u32]).map(f32::from_bits);
        let mut number = || numbers.next().unwrap_or(0.0);
        let mut half = || {
            let [rays, opacity] = [number(), number()];
            let mut sum = || Vec3::new(number(), number(), number());
            let [radiance, media, direct, indirect, reflectance] = std::array::from_fn(|_| sum());
            HalfSums { rays, radiance, media, direct, indirect, reflectance, opacity }
        };
        let halves = [half(), half()];
        let [surfaces, specular, media, log_distance] = std::array::from_fn(|_| number());
        let mut sum = || Vec3::new(number(), number(), number());
        let (offset, normal) = (sum(), sum());
        let seen = SeenSums { surfaces, offset, normal, specular, media, log_distance };
        Self { halves, seen }
    }
}

/// A part of the light of a picture as its rays bring it: that of a group of emitters, or of an order of scattering.
#[derive(Debug, Clone)]
pub struct LightPart {
    /// Its number among the parts.
    pub number: usize,
    /// Light of each pixel, row by row from the top.
    pub sums: Vec<[LightSums; 2]>,
    /// Mean visible emission of each pixel, W/(m² sr).
    pub emission: Vec<[f32; 3]>,
}

impl LightPart {
    /// The part of this number of a picture of this many pixels, without light.
    pub fn new(number: usize, pixels: usize) -> Self {
        let sums = vec![Default::default(); pixels];
        Self { number, sums, emission: vec![[0.0; 3]; pixels] }
    }
}

/// Components of the pixels of a picture.
#[derive(Clone, Debug)]
pub struct ComponentFilm {
    /// Pixels in a row.
    pub width: usize,
    /// Pixels, row by row from the top.
    pub pixels: Vec<PixelComponents>,
    /// The parts of the light, where they are gathered by component and half.
    pub parts: Vec<LightPart>,
}

impl ComponentFilm {
    /// Width and height in pixels.
    pub fn size(&self) -> [usize; 2] {
        [self.width, self.pixels.len() / self.width]
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;
    use proptest::prelude::*;

    use super::*;
    use crate::film::{Components, Seen, VisibleSurface};
    use crate::math::Rgb;

    proptest! {
        #[test]
        fn components_survive_storing(
            rays in prop::collection::vec(prop::array::uniform9(0.0_f64..10.0), 1..9),
        ) {
            let mut pixel = PixelComponents::default();
            for (index, [a, b, c, d, e, f, g, h, i]) in rays.iter().copied().enumerate() {
                let light = Components {
                    media: Rgb::new(a, b, c),
                    direct: Rgb::new(d, e, f),
                    indirect: Rgb::new(g, h, i),
                };
                let surface = VisibleSurface {
                    offset: DVec3::new(c, a, b),
                    normal: DVec3::new(f, d, e),
                    reflectance: Rgb::new(i, g, h),
                };
                let seen = Seen { surface: Some(surface), specular: a > b, media_distance: Some(a) };
                let radiance = Rgb::new(h, i, a);
                let sample = Sample { radiance, components: light, seen, transmittance: 0.1 * b, ..Sample::default() };
                pixel.add(index % 2, &sample);
                prop_assert_eq!(PixelComponents::from_bits(&pixel.to_bits()), pixel);
            }
            let [even, odd] = pixel.halves;
            prop_assert_eq!(even.rays + odd.rays, rays.len() as f32);
            let sum: f64 = rays.iter().map(|ray| ray[4]).sum();
            prop_assert!((f64::from(even.direct.y + odd.direct.y) - sum).abs() < 1e-4 * sum.max(1.0));
        }
    }
}
