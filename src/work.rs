//! What a render did, counted.

use std::ops::AddAssign;

use serde::{Deserialize, Serialize};

macro_rules! counters {
    ($($(#[$doc:meta])* $name:ident,)*) => {
        /// Counts of work, the same on any number of threads.
        #[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
        pub struct Work {
            $($(#[$doc])* pub $name: u64,)*
        }

        impl Work {
            /// Each count through `f`.
            #[must_use]
            pub fn map(&self, f: impl Fn(u64) -> u64) -> Self {
                Self { $($name: f(self.$name),)* }
            }

            /// How much more each count is than in `other`.
            #[must_use]
            pub fn less(&self, other: &Self) -> Self {
                Self { $($name: self.$name.saturating_sub(other.$name),)* }
            }

            /// Each count with its name.
            pub fn counts(&self) -> impl Iterator<Item = (&'static str, u64)> {
                [$((stringify!($name), self.$name),)*].into_iter()
            }
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
    /// Visibility rays of antialiasing, which find surfaces and transmittance.
    visibility_rays,
    /// Rays towards lights.
    shadow_rays,
    /// Searches for the nearest surface.
    intersections,
    /// Rays or parts of rays along which optical thickness was integrated.
    marches,
    /// Pixels of the director's maps.
    map_pixels,
    /// Escaped rays for which lights infinitely far away were asked.
    environment_lookups,
    /// Steps of marches: region crossings, crossed cells, constant blocks, samples.
    march_steps,
    /// Active voxels held out of the camera's sight, where nothing else asks for voxels.
    unseen_voxels,
    /// Values taken out of grids: one a crossed cell, constant block or sampled place, and one a
    /// region whose majorant free flight crossed.
    grid_lookups,
    /// Places where emission was asked of a grid or a temperature.
    emission_lookups,
    /// Tentative collisions of free flight.
    collisions,
    /// Those of them at which nothing happened.
    null_collisions,
    /// Places where light in the medium was evaluated.
    gathers,
    /// Those of them that asked where photons came from.
    directed_gathers,
    /// Camera rays and photon paths that were traced in three channels.
    colored_paths,
    /// Places on surfaces where photons were gathered.
    surface_gathers,
    /// Photons that lay within the radius of a gather.
    gathered,
    /// Choices of one light among several.
    light_choices,
    /// Mirrors and panes of glass that camera rays followed.
    specular_bounces,
    /// Photon paths begun, those among them that carry nothing.
    photon_paths,
    /// Photons that left a light or an emissive medium.
    photons_emitted,
    /// Those of them that could reach neither a medium nor a surface.
    photons_missed,
    /// Starts of photon paths that were drawn and rejected before they flew: they carried nothing,
    /// or could reach neither a medium nor a surface.
    starts_rejected,
    /// Flights of photons through media, kept for lattices.
    tracks,
    /// Photons stored in media.
    volume_photons,
    /// Photons stored on surfaces.
    surface_photons,
    /// Paths of photons, and of the reference, that were ended by the hard cap on their events.
    capped_paths,
    /// Rays that media scatter or deflect, and that were ended so.
    capped_rays,
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
