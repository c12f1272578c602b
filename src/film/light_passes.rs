//! Light of passes: sums of its parts by component and half, and how what a pixel shows is shared out among them.

use glam::DVec3;
use smallvec::SmallVec;

use super::components::LightSums;
use crate::math::{MAX_GROUPS, RayParts, Rgb};

/// Numbers of a half: radiance, light of media, direct and indirect light of surfaces.
///
/// Unit: count. Definition: of the block.
const HALF: usize = 12;

/// Numbers of a part: both halves, and visible emission.
///
/// Unit: count. Definition: of the block.
pub(super) const PART_NUMBERS: usize = 2 * HALF + 3;

/// Adds a ray of a `half`, 0 or 1, to the `sums` of the part of this number.
pub(super) fn add_part(sums: &mut [f64], half: usize, light: &RayParts, part: usize) {
    let RayParts { all, media, direct, indirect, emission } = light;
    let numbers = [all, media, direct, indirect].map(|of| of[part]);
    let numbers = numbers.as_flattened().iter().zip(&mut sums[half * HALF..]);
    let emission = emission[part];
    numbers.for_each(|(number, sum)| *sum += f64::from(*number));
    let sums = sums[2 * HALF..].iter_mut().zip(emission);
    sums.for_each(|(sum, number)| *sum += f64::from(number));
}

/// The light of both halves, and its mean visible emission, from `sums` over this many rays.
pub(super) fn read_part(sums: &[f64], rays: u64) -> ([LightSums; 2], [f32; 3]) {
    let color = |first: usize| DVec3::from_slice(&sums[first..]);
    let halves = [0, HALF].map(|first| {
        let [radiance, media, direct, indirect] =
            [0, 3, 6, 9].map(|at| color(first + at).as_vec3());
        LightSums { radiance, media, direct, indirect }
    });
    let emission = color(2 * HALF) / rays.max(1) as f64;
    (halves, emission.as_vec3().to_array())
}

/// The light of a pixel by component, W/(m² sr), in the order of [`Aov::LIGHT`](crate::scene::Aov::LIGHT), from the sums of the
/// first four over these rays, of which `mean` is the mean light: together it is what the picture shows.
pub(super) fn by_component(sums: &[f64], rays: u64, mean: Rgb, shown: Rgb) -> [Rgb; 5] {
    let rays = rays.max(1) as f64;
    let [media, direct, indirect, emission] =
        std::array::from_fn(|part| DVec3::from_slice(&sums[3 * part..]) / rays);
    let known: [Rgb; 4] = [media, direct, indirect, emission];
    let left = mean - known.iter().sum::<Rgb>();
    let size: Rgb = mean.abs() + known.iter().map(|part| part.abs()).sum::<Rgb>();
    // What rounding leaves is nothing.
    let specular = Rgb::select(left.abs().cmpgt(size * f64::from(f32::EPSILON)), left, Rgb::ZERO);
    // Where a pixel has not got all rays, the picture shows what is gathered for all of them in its right share.
    let more = shown - mean;
    let gathered = media.abs() + indirect.abs();
    let share =
        |part: Rgb| Rgb::select(gathered.cmpgt(Rgb::ZERO), more * part.abs() / gathered, Rgb::ZERO);
    let others = Rgb::select(gathered.cmpgt(Rgb::ZERO), Rgb::ZERO, more);
    [media + share(media), direct, indirect + share(indirect), emission, specular + others]
}

/// The mean light of each group in a pixel, or of each order, W/(m² sr), from their sums over these rays.
pub(super) fn means(sums: &[f64], rays: u64) -> SmallVec<[Rgb; MAX_GROUPS]> {
    let rays = rays.max(1) as f64;
    sums.chunks_exact(3).map(|sum| DVec3::from_slice(sum) / rays).collect()
}

/// Light of a pixel by its `parts`, W/(m² sr), which together is `all`. What that has of light gathered for other rays, what it
/// is cut off by at black, and what rounding leaves, is shared as the rest of the light is.
pub fn share_out(parts: SmallVec<[Rgb; MAX_GROUPS]>, all: Rgb) -> impl Iterator<Item = Rgb> {
    let size: Rgb = parts.iter().map(|part| part.abs()).sum();
    let left = all - parts.iter().sum::<Rgb>();
    let is_lit = size.cmpgt(Rgb::ZERO);
    parts.into_iter().enumerate().map(move |(index, part)| {
        let dark = if index == 0 { left } else { Rgb::ZERO };
        part + Rgb::select(is_lit, left * part.abs() / size, dark)
    })
}
