//! The equal passes that a picture may be rendered in.

use std::fmt::{self, Display, Formatter};
use std::ops::Range;
use std::str::FromStr;

/// Spreads the seeds of passes over all bits. Any odd number does; this one has no pattern: a multiplier of Steele
/// and Vigna 2022, "Computationally Easy, Spectrally Good Multipliers for Congruential Pseudorandom Number Generators".
const SEED_STEP: u64 = 0xd134_2543_de82_ef95;

/// Pass `number` of `count`: a share of the rays of each pixel and of the photons of a picture. Rays and photon paths
/// of all passes together are those of the picture, each once.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct PicturePass {
    /// How many passes there are.
    pub count: u32,
    /// Which it is, from 1.
    pub number: u32,
}

impl PicturePass {
    /// Which of `total` rays or photon paths it has, in a picture of `rays` rays a pixel: in proportion to its
    /// share of those. In the mean of all passes, weighed by rays, all photons weigh the same.
    pub fn share(self, total: u64, rays: u32) -> Range<u64> {
        let part = |whole: u64, numerator: u64, denominator: u64| {
            (u128::from(whole) * u128::from(numerator) / u128::from(denominator.max(1))) as u64
        };
        let end = |number: u32| {
            let of_rays = part(rays.into(), number.into(), self.count.into());
            part(total, of_rays, rays.into())
        };
        end(self.number - 1)..end(self.number)
    }

    /// The seed of what it shares with no other pass of a picture of this `seed`: cells that rays fill.
    pub const fn seed(self, seed: u64) -> u64 {
        seed.wrapping_add(SEED_STEP.wrapping_mul(self.number as u64 - 1))
    }
}

impl Display for PicturePass {
    /// As it is parsed: `number/count`.
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let Self { number, count } = self;
        write!(f, "{number}/{count}")
    }
}

impl FromStr for PicturePass {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let whole = |text: &str| text.trim().parse::<u32>().ok();
        let pass = text.split_once('/').and_then(|(number, count)| {
            let (number, count) = (whole(number)?, whole(count)?);
            (1..=count).contains(&number).then_some(Self { count, number })
        });
        pass.ok_or_else(|| "give K/N, such as 3/8 for the third of eight passes".into())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn passes_share_rays_and_photons(
            count in 1_u32..40, more in 0_u32..100, total in 0_u64..MAX,
        ) {
            let rays = count + more;
            let (mut shot, mut traced) = (0, 0);
            for number in 1..=count {
                let pass = PicturePass { count, number };
                let [own, paths] = [rays.into(), total].map(|total| pass.share(total, rays));
                prop_assert_eq!([own.start, paths.start], [shot, traced]);
                prop_assert!(own.end > own.start);
                // To one path in proportion to the rays.
                let right = total as f64 * (own.end - own.start) as f64 / f64::from(rays);
                prop_assert!(((paths.end - paths.start) as f64 - right).abs() <= 1.0);
                prop_assert!(own.end - own.start <= u64::from(rays / count) + 1);
                (shot, traced) = (own.end, paths.end);
            }
            prop_assert_eq!([shot, traced], [u64::from(rays), total]);
        }
    }

    /// More photons than can be asked for.
    const MAX: u64 = 1 << 40;

    #[test]
    fn a_pass_is_written_as_it_is_read() {
        for text in ["1/1", "3/8", "1048576/1048576"] {
            assert_eq!(text.parse::<PicturePass>().unwrap().to_string(), text);
        }
        for wrong in ["", "3", "0/8", "9/8", "3/0", "-1/8", "3/8/2", "a/b", "3,8", "1/99999999999"]
        {
            assert!(wrong.parse::<PicturePass>().unwrap_err().starts_with("give K/N"), "{wrong}");
        }
    }

    #[test]
    fn passes_have_seeds_of_their_own() {
        let seeds = |seed| (1..=8).map(move |number| PicturePass { count: 8, number }.seed(seed));
        let mut all: Vec<u64> = [0, 1, 2, u64::MAX].into_iter().flat_map(seeds).collect();
        assert_eq!(all[0], 0);
        all.sort_unstable();
        all.dedup();
        assert_eq!(all.len(), 32);
    }
}
