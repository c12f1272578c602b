//! Passes of light of a reconstructed picture: each by the weights of the whole, so that together they are what it shows.

use glam::Vec3A;
use smallvec::SmallVec;

use crate::film::{
    Antialiased, AovSums, PART_BYTES, PictureLight, PixelLight, Reconstruction, share_out,
};
use crate::image::Film;
use crate::math::{MAX_GROUPS, Rgb};
use crate::scene::Aov;

/// Bytes of a pixel that passes of light with these sums take while they are reconstructed.
pub(super) fn reconstructed_pass_bytes(sums: &AovSums) -> usize {
    if !sums.passes.has_light() && !sums.passes.has_parts() {
        return 0;
    }
    let parts = sums.parts_in_halves();
    let light = (1 + parts) * size_of::<Option<PixelLight>>();
    parts * PART_BYTES + light + 2 * size_of::<Option<Shares>>()
}

/// A pixel at an edge.
#[derive(Debug)]
pub(super) struct Edge {
    /// All of its light.
    pub all: Antialiased,
    /// Parts of that, where light is told apart.
    pub parts: SmallVec<[Antialiased; 1]>,
}

/// Pixels at edges, and the share of its residual that each takes.
#[derive(Debug, Clone, Copy)]
pub(super) struct Edges<'a> {
    pub edges: &'a [Edge],
    pub shares: &'a [f32],
}

impl Edges<'_> {
    /// The light of each pixel of `light`, which pixels at edges have as `of_edge`; `None` where a pixel has no ray.
    fn pixels(
        &self,
        reconstruction: &Reconstruction<'_>,
        light: &PictureLight<'_>,
        of_edge: impl Fn(&Edge) -> Option<&Antialiased>,
    ) -> Vec<Option<PixelLight>> {
        let pixels = 0..reconstruction.pixels();
        let mut pixels: Vec<Option<PixelLight>> =
            pixels.map(|pixel| reconstruction.pixel(light, pixel)).collect();
        for (edge, share) in self.edges.iter().zip(self.shares) {
            if let Some(antialiased) = of_edge(edge) {
                pixels[antialiased.pixel] = Some(antialiased.corrected(*share));
            }
        }
        pixels
    }
}

/// Replaces the passes of light of `film`, those that have these `sums`. It is reconstructed from `all` light, of which the
/// others are the parts that are told apart.
pub(super) fn write_passes(
    sums: &AovSums,
    reconstruction: &Reconstruction<'_>,
    edges: &Edges<'_>,
    (all, parts): (&PictureLight<'_>, &[PictureLight<'_>]),
    film: &mut Film,
) {
    let passes = sums.passes;
    if !passes.has_light() && !passes.has_parts() {
        return;
    }
    let shown = film.image();
    let shown = |pixel: usize| Rgb::from_array(shown.pixels()[pixel].map(f64::from));
    let components: Vec<Option<Shares>> = edges
        .pixels(reconstruction, all, |edge| Some(&edge.all))
        .into_iter()
        .enumerate()
        .map(|(pixel, light)| Some(share_out(by_component(&light?), shown(pixel)).collect()))
        .collect();
    replace(film, Aov::LIGHT.into_iter().flat_map(|aov| sums.layers_of(aov)), &components);
    if parts.is_empty() {
        return;
    }
    let of_part = |(number, light): (usize, &PictureLight<'_>)| {
        edges.pixels(reconstruction, light, |edge| edge.parts.get(number))
    };
    let parts: Vec<Vec<Option<PixelLight>>> = parts.iter().enumerate().map(of_part).collect();
    let by_group = passes.has(Aov::Groups);
    let of_pixel = |(pixel, components): (usize, &Option<Shares>)| {
        let of_media = components.as_ref()?.first().copied()?;
        let light = |part: &Vec<Option<PixelLight>>| Some(rgb(part[pixel]?.total()));
        let light: Option<Shares> = parts.iter().map(light).collect();
        Some(share_out(light?, if by_group { shown(pixel) } else { of_media }).collect())
    };
    let told_apart: Vec<Option<Shares>> = components.iter().enumerate().map(of_pixel).collect();
    let pass = if by_group { Aov::Groups } else { Aov::Scattered };
    replace(film, sums.layers_of(pass), &told_apart);
}

/// Light of a pixel in parts, W/(m² sr).
type Shares = SmallVec<[Rgb; MAX_GROUPS]>;

/// Light of a pixel by component, in the order of [`Aov::LIGHT`].
fn by_component(light: &PixelLight) -> Shares {
    let PixelLight { media, direct, indirect, emission, specular } = *light;
    [media, direct, indirect, emission, specular].into_iter().map(rgb).collect()
}

fn rgb(light: Vec3A) -> Rgb {
    light.as_dvec3()
}

/// Replaces the `layers` by `light`, those of `film` that it has: three of each part.
fn replace(film: &mut Film, layers: impl IntoIterator<Item = String>, light: &[Option<Shares>]) {
    for (index, name) in layers.into_iter().enumerate() {
        let (part, channel) = (index / 3, index % 3);
        film.replace_pass(&name, |pixel| Some(light[pixel].as_ref()?.get(part)?[channel]));
    }
}
