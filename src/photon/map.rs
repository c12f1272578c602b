//! A photon map over kiddo's immutable kd-tree.

use kiddo::{ImmutableKdTree, SquaredEuclidean};

use crate::math::{Rgb, Spectrum, WorldPoint};

use super::{Octahedral, Photon, PhotonAt, PhotonDirection};

/// Photons in a kd-tree, for gathers within a radius.
#[derive(Debug)]
pub struct PhotonMap<S: Spectrum = Rgb, H = Octahedral> {
    tree: Option<ImmutableKdTree<f32, 3>>,
    photons: Vec<Photon<S, H>>,
    /// What the tree's coordinates are relative to, so that 32 bits suffice far from the world's origin.
    origin: WorldPoint,
}

impl<S: Spectrum, H: PhotonDirection> PhotonMap<S, H> {
    /// Builds the map of photons whose positions are relative to `origin`. The tree is the same on any
    /// number of threads.
    ///
    /// # Panics
    /// If there are over 2^32 photons, or one whose position is not finite.
    pub fn new(origin: WorldPoint, photons: &[PhotonAt<S, H>]) -> Self {
        let places: Vec<[f32; 3]> = photons.iter().map(|p| p.place).collect();
        let build = || ImmutableKdTree::new_from_slice_parallel(&places).expect("finite places");
        let tree = (!places.is_empty()).then(build);
        Self { tree, photons: photons.iter().map(|p| p.photon).collect(), origin }
    }

    /// How many photons it holds.
    pub const fn len(&self) -> usize {
        self.photons.len()
    }

    /// Whether it holds none.
    pub const fn is_empty(&self) -> bool {
        self.photons.is_empty()
    }

    /// Bytes in memory: the photons, and the tree's copy of their positions and indices.
    pub const fn memory_bytes(&self) -> usize {
        self.photons.len() * (size_of::<Photon<S, H>>() + 16)
    }

    /// Calls `f` with each photon within `radius` metres of `p` and its squared distance in m², in a
    /// fixed order.
    pub fn within(&self, p: WorldPoint, radius: f64, mut f: impl FnMut(&Photon<S, H>, f64)) {
        let Some(tree) = &self.tree else { return };
        let query = (p - self.origin).as_vec3().to_array();
        tree.query(&query)
            .within::<SquaredEuclidean<f32>>((radius * radius) as f32)
            .unsorted()
            .visit(|found| f(&self.photons[found.item as usize], f64::from(found.distance)));
    }

    /// Index of the photon nearest to `p`; `None` where the map is empty.
    pub fn nearest(&self, p: WorldPoint) -> Option<usize> {
        let query = (p - self.origin).as_vec3().to_array();
        let found = self.tree.as_ref()?.query(&query).nearest_one::<SquaredEuclidean<f32>>();
        Some(found.execute().item as usize)
    }

    /// Calls `f` with the `k` photons nearest to `p` (with all where there are fewer) and returns
    /// the distance to the farthest of them, in metres; `None` where there is none.
    pub fn nearest_photons(
        &self,
        p: WorldPoint,
        k: usize,
        mut f: impl FnMut(&Photon<S, H>),
    ) -> Option<f64> {
        let query = (p - self.origin).as_vec3().to_array();
        let k = std::num::NonZero::new(k)?;
        let found =
            self.tree.as_ref()?.query(&query).nearest_n::<SquaredEuclidean<f32>>(k).execute();
        found.iter().for_each(|near| f(&self.photons[near.item as usize]));
        found.last().map(|farthest| f64::from(farthest.distance).sqrt())
    }

    /// Distance from `p` to the `k`-th nearest photon (to the farthest where there are fewer), in
    /// metres; `None` where the map is empty or `k` is 0.
    pub fn distance_to_nearest(&self, p: WorldPoint, k: usize) -> Option<f64> {
        self.nearest_photons(p, k, |_| {})
    }
}
