//! Which pixels see an edge of a surface, of its texture or of media.

use glam::Vec3A;
use rayon::prelude::*;

use super::Reconstruction;
use super::levels::around;
use crate::film::components::PixelComponents;

/// Likeness of the surfaces of neighbours below which there is an edge between them.
///
/// Unit: none. Derivation: neighbours count half as much; their normals differ by 6 degrees.
const EDGE_LIKENESS: f32 = 0.5;

/// Relative difference of reflectance times transmittance between neighbours above which there is an edge.
///
/// Unit: none. Derivation: four rays across an edge of that contrast are off by a fortieth.
const EDGE_CONTRAST: f32 = 0.1;

/// Difference of opacities of media between neighbours above which there is an edge.
///
/// Unit: none. Derivation: light of media is off by as much as that of surfaces of this contrast.
const OPACITY_CONTRAST: f32 = 0.1;

impl Reconstruction<'_> {
    /// The pixels that see an edge of a surface, of its texture or of media.
    pub fn edges(&self) -> Vec<usize> {
        let size = self.film.size();
        let is_edge = |&pixel: &usize| {
            is_mixed(&self.film.pixels[pixel])
                || around(size, pixel).any(|(other, _)| self.differ(pixel, other))
        };
        (0..self.film.pixels.len()).into_par_iter().filter(is_edge).collect()
    }

    /// Whether there is an edge between two pixels.
    fn differ(&self, pixel: usize, other: usize) -> bool {
        let [a, b] = [pixel, other].map(|index| &self.film.pixels[index]);
        if a.rays() == 0.0 || b.rays() == 0.0 {
            return false;
        }
        let shares = |pixel: &PixelComponents| {
            [pixel.seen.surfaces, pixel.seen.specular].map(|count| count / pixel.rays())
        };
        if shares(a) != shares(b) || (a.opacity() - b.opacity()).abs() > OPACITY_CONTRAST {
            return true;
        }
        let (Some(here), Some(there)) = (&self.surfaces[pixel], &self.surfaces[other]) else {
            return false;
        };
        if here.likeness(there, 1.0) < EDGE_LIKENESS {
            return true;
        }
        let [a, b] = [a, b].map(mean_reflectance);
        (a - b).abs().max_element() > EDGE_CONTRAST * a.max(b).max_element()
    }
}

/// Whether rays of a pixel see both a surface and none, or a mirror or glass and something else.
fn is_mixed(pixel: &PixelComponents) -> bool {
    let kinds = [pixel.seen.surfaces, pixel.seen.specular];
    kinds.iter().any(|count| *count > 0.0 && *count < pixel.rays())
}

/// Mean over all rays of the reflectance of surfaces times the transmittance before them.
pub(super) fn mean_reflectance(pixel: &PixelComponents) -> Vec3A {
    Vec3A::from(pixel.halves[0].reflectance + pixel.halves[1].reflectance) / pixel.rays().max(1.0)
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::film::reconstruct::tests::{SIZE, film, floor, medium, surface};

    #[test]
    fn planes_have_no_edges() {
        // Seen at a slant that grows toward a horizon.
        let plain = |x: f64, y: f64| {
            let far = 10.0 / (y + 0.5);
            surface(1.0, DVec3::new((x - 24.0) * far, -1.0, 20.0 * far), DVec3::Y, 0.5)
        };
        let film = film(1, 0.0, 0, |x, y, _| plain(x, y));
        assert!(Reconstruction::new(&film).edges().is_empty());
    }

    #[test]
    fn edges_of_textures_are_found() {
        let checks = |x: f64, y: f64| {
            surface(
                1.0,
                floor(x, y),
                DVec3::Y,
                if (x / 12.0).floor() % 2.0 == 0.0 { 0.8 } else { 0.1 },
            )
        };
        let film = film(1, 0.0, 0, |x, y, _| checks(x, y));
        let columns: std::collections::BTreeSet<usize> =
            Reconstruction::new(&film).edges().iter().map(|pixel| pixel % SIZE[0]).collect();
        assert_eq!(columns.into_iter().collect::<Vec<_>>(), [11, 12, 23, 24, 35, 36]);
    }

    /// Opacity that jumps, and one that rises by half as much from pixel to pixel.
    #[test]
    fn silhouettes_of_media_are_edges() {
        for (far, columns) in [(0.6, vec![23, 24]), (0.25, vec![])] {
            let opacity = |x: f64| 0.2 + (far - 0.2) * (x - 23.0).clamp(0.0, 1.0);
            let film = film(1, 0.0, 0, |x, _, _| medium(opacity(x), opacity(x), 4.0));
            let found: std::collections::BTreeSet<usize> =
                Reconstruction::new(&film).edges().iter().map(|pixel| pixel % SIZE[0]).collect();
            assert_eq!(found.into_iter().collect::<Vec<_>>(), columns);
        }
    }
}
