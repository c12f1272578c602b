//! What a render did, counted.

use std::ops::AddAssign;

use serde::Serialize;

macro_rules! counters {
    ($($(#[$doc:meta])* $name:ident,)*) => {
        /// Counts of work, the same on any number of threads.
        #[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
        pub struct Work {
            $($(#[$doc])* pub $name: u64,)*
        }

        impl AddAssign for Work {
            fn add_assign(&mut self, other: Self) {
                $(self.$name += other.$name;)*
            }
        }
    };
}

counters! {
    /// Camera rays.
    rays,
    /// Rays towards lights.
    shadow_rays,
    /// Searches for the nearest surface.
    intersections,
    /// Rays or parts of rays along which optical thickness was integrated.
    marches,
    /// Tentative collisions of free flight.
    collisions,
    /// Places where light in the medium was evaluated.
    gathers,
    /// Photons that lay within the radius of a gather.
    gathered,
    /// Photon paths sent out by lights.
    photon_paths,
    /// Photons stored in media.
    volume_photons,
    /// Photons stored on surfaces.
    surface_photons,
    /// Paths ended by the hard cap on their events.
    capped_paths,
    /// Samples dropped because they were not finite.
    dropped_samples,
}

impl std::iter::Sum for Work {
    fn sum<I: Iterator<Item = Self>>(iter: I) -> Self {
        iter.fold(Self::default(), |mut sum, work| {
            sum += work;
            sum
        })
    }
}
