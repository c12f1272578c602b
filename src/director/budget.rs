//! From importance to what a pixel may spend.

use crate::scene::Directing;

/// What a pixel may spend: plain numbers, fixed before its samples are drawn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PixelBudget {
    /// Camera rays.
    pub rays: u32,
    /// Rays after which the pixel may end early.
    pub least: u32,
    /// Standard error over mean at which it does; a pixel without light goes on.
    pub tolerance: f64,
    /// Rays along which photons are gathered, spread evenly among all.
    pub gathers: u32,
    /// Gather radius in media, in metres.
    pub radius: f64,
    /// March step, in metres; grids are integrated exactly where it is at most a voxel.
    pub step: f64,
    /// Saliency, 0 to 1; 1 where nothing is directed.
    pub saliency: f64,
    /// Importance in the XS-map, 0 to 1; 1 where nothing is directed.
    pub xs: f64,
}

/// Rays of a pixel along which light that varies little within it is gathered.
const GATHERS: u32 = 4;

impl PixelBudget {
    /// The same for all pixels: the gold standard, where `radius` and `step` are the finest.
    pub const fn fixed(rays: u32, radius: f64, step: f64) -> Self {
        let (saliency, xs) = (1.0, 1.0);
        let (least, tolerance, gathers) = (rays, 0.0, GATHERS);
        Self { rays, least, tolerance, gathers, radius, step, saliency, xs }
    }

    /// What a pixel of the importance `xs`, 0 to 1, may spend out of `self`, the gold standard's.
    /// Rays are in proportion to `xs`, at least the floor; radius and step go geometrically from
    /// the finest to the coarsest, the radius in powers of two, for each of which there is a map
    /// of its own. `voxel` is the shortest voxel edge in metres, if there is any grid.
    pub fn for_importance(self, xs: f32, asked: &Directing, voxel: Option<f64>) -> Self {
        let importance = f64::from(xs);
        let mut budget = Self { xs: importance, ..self };
        if asked.directed.rays {
            let rays = (f64::from(self.rays) * importance).round() as u32;
            budget.rays = rays.clamp(asked.floor.min(self.rays), self.rays);
            budget.least = budget.rays;
            // As many gathers a ray as the gold standard has.
            budget.gathers = (self.gathers * budget.rays).div_ceil(self.rays).max(1);
        }
        if asked.directed.radius {
            budget.radius *= f64::from(1_u32 << radius_level(asked, xs));
        }
        if let Some(voxel) = voxel.filter(|_| asked.directed.step) {
            let coarsest = (asked.coarsest_step * voxel).max(self.step);
            budget.step = if importance >= 1.0 {
                self.step
            } else {
                let finest = self.step.max(voxel);
                finest * (coarsest / finest).max(1.0).powf(1.0 - importance)
            };
        }
        budget
    }

    /// As `self`, but a pixel ends once its error is small.
    pub fn until(self, tolerance: f64, floor: u32) -> Self {
        let least = floor.max(GATHERS).min(self.rays);
        // Which rays will be the last is not known, so that each must gather.
        Self { least, tolerance, gathers: self.rays, ..self }
    }
}

/// The gather radius of a pixel of the importance `xs` over the finest, as the exponent of the
/// nearest power of two.
pub fn radius_level(asked: &Directing, xs: f32) -> u32 {
    let octaves = asked.coarsest_radius.max(1.0).log2() * (1.0 - f64::from(xs));
    octaves.round().clamp(0.0, 8.0) as u32
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Directed;
    use proptest::prelude::*;

    const GOLD: PixelBudget = PixelBudget::fixed(16, 0.1, 0.02);

    #[test]
    fn the_ends_of_importance() {
        let asked = Directing::default();
        assert_eq!(GOLD.for_importance(1.0, &asked, Some(0.02)), GOLD);
        let least = GOLD.for_importance(0.0, &asked, Some(0.02));
        assert_eq!((least.rays, least.radius), (asked.floor, 0.1 * asked.coarsest_radius));
        assert!((least.step - 0.02 * asked.coarsest_step).abs() < 1e-12);
    }

    #[test]
    fn each_is_directed_alone() {
        let none = Directed { rays: false, radius: false, step: false };
        for (directed, changes) in [
            (none, [false; 3]),
            (Directed { rays: true, ..none }, [true, false, false]),
            (Directed { radius: true, ..none }, [false, true, false]),
            (Directed { step: true, ..none }, [false, false, true]),
        ] {
            let asked = Directing { directed, ..Directing::default() };
            let budget = GOLD.for_importance(0.0, &asked, Some(0.02));
            let changed =
                [budget.rays < GOLD.rays, budget.radius > GOLD.radius, budget.step > GOLD.step];
            assert_eq!(changed, changes, "{directed:?}");
        }
    }

    proptest! {
        #[test]
        fn more_important_is_never_coarser(a in 0.0..=1.0f32, b in 0.0..=1.0f32) {
            let asked = Directing::default();
            let of = |xs| GOLD.for_importance(xs, &asked, Some(0.02));
            let (low, high) = (of(a.min(b)), of(a.max(b)));
            prop_assert!(low.rays <= high.rays && low.radius >= high.radius);
            prop_assert!(low.step >= high.step);
        }
    }
}
