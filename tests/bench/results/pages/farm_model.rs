//! How long a picture takes on many nodes: in closed form, and simulated.

use fogbow::math::{Stage, Stream};

use super::farm::Costs;

/// The most nodes.
pub const MOST_NODES: u32 = 1000;

/// Seconds that a task waits for its start in the simulation.
pub const START_UP: f64 = 5.0;

/// Standard deviation of the logarithm of the nodes' speeds.
const SPREAD: f64 = 0.1;

/// Farms that are simulated.
const TRIALS: u64 = 64;

/// Fewest rays of a pixel in a pass.
const PASS_RAYS: f64 = 8.0;

/// Pixels around a crop that get rays where it is reconstructed.
const HALO: f64 = 44.0;

/// What a picture is parted in.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// Passes that read saved photons.
    Passes,
    /// Passes that shoot.
    ShootingPasses,
    /// Crops that read saved photons.
    Crops,
    /// Crops that are reconstructed.
    ReconstructedCrops,
}

impl Kind {
    /// All of them.
    pub const ALL: [Self; 4] =
        [Self::Passes, Self::ShootingPasses, Self::Crops, Self::ReconstructedCrops];

    /// In plots and tables.
    pub const fn title(self) -> &'static str {
        match self {
            Self::Passes => "passes by saved photons",
            Self::ShootingPasses => "passes that shoot",
            Self::Crops => "crops",
            Self::ReconstructedCrops => "crops that are reconstructed",
        }
    }

    /// In the keys of quoted figures.
    pub const fn key(self) -> &'static str {
        match self {
            Self::Passes => "passes",
            Self::ShootingPasses => "shooting",
            Self::Crops => "crops",
            Self::ReconstructedCrops => "reconstructed",
        }
    }

    /// Parts on so many nodes.
    fn parts(self, costs: &Costs, nodes: u32) -> u32 {
        let most = match self {
            Self::Passes | Self::ShootingPasses => (f64::from(costs.rays) / PASS_RAYS) as u32,
            Self::Crops | Self::ReconstructedCrops => costs.size[1],
        };
        nodes.min(most).max(1)
    }

    /// Seconds of what comes before the parts; nothing where each part does it.
    fn before(self, costs: &Costs) -> Option<f64> {
        let Costs { load, strategy, shoot, write_photons, .. } = costs;
        (self != Self::ShootingPasses).then_some(load + strategy + shoot + write_photons)
    }

    /// Seconds of part `index` of `parts`.
    fn part(self, costs: &Costs, index: u32, parts: u32) -> f64 {
        let Costs { load, strategy, shoot, read_photons, ray, once, encode, .. } = costs;
        let (share, all) = (1.0 / f64::from(parts), f64::from(costs.rays));
        let pass = ray * (all * share + once) + encode;
        let crop = |halo: f64| {
            let height = f64::from(costs.size[1]);
            let cut = if parts > 1 { costs.border / height } else { 0.0 };
            let [from, to] = [index, index + 1].map(|end| f64::from(end) * share);
            let rows = of_bands(costs, [from - halo / height, to + halo / height]);
            load + read_photons + ray * (all + once) * (rows + cut) + encode * share
        };
        match self {
            Self::Passes => load + read_photons + pass,
            Self::ShootingPasses => load + strategy + (shoot + read_photons) * share + pass,
            Self::Crops => crop(0.0),
            Self::ReconstructedCrops => crop(HALO),
        }
    }

    /// Seconds of the merge.
    fn merge(self, costs: &Costs, parts: u32) -> f64 {
        let [alone, each] = match self {
            Self::Passes | Self::ShootingPasses => costs.merge_passes,
            Self::Crops | Self::ReconstructedCrops => costs.merge_crops,
        };
        alone + each * f64::from(parts)
    }
}

/// Share of the rays' time between two heights, 0 to 1 from the top.
fn of_bands(costs: &Costs, [from, to]: [f64; 2]) -> f64 {
    let count = costs.bands.len() as f64;
    let within = |(index, share): (usize, &f64)| {
        let top = index as f64;
        let rows = (to * count).min(top + 1.0) - (from * count).max(top);
        share * rows.max(0.0)
    };
    costs.bands.iter().enumerate().map(within).sum()
}

/// Seconds of the whole picture on one node, without parts.
fn alone(costs: &Costs) -> f64 {
    let Costs { load, strategy, shoot, read_photons, ray, rays, once, encode, .. } = costs;
    load + strategy + shoot + read_photons + ray * (f64::from(*rays) + once) + encode
}

/// Seconds before the parts, of the parts, all of which take the mean, and of the merge.
pub fn times(costs: &Costs, kind: Kind, nodes: u32) -> [f64; 3] {
    let parts = kind.parts(costs, nodes);
    let mean =
        (0..parts).map(|index| kind.part(costs, index, parts)).sum::<f64>() / f64::from(parts);
    [kind.before(costs).unwrap_or(0.0), mean, kind.merge(costs, parts)]
}

/// How much sooner a picture is there on `nodes`, by the closed form.
pub fn speed_up(costs: &Costs, kind: Kind, nodes: u32) -> f64 {
    alone(costs) / times(costs, kind, nodes).iter().sum::<f64>()
}

/// The same in the mean of simulated farms: a task for photons, tasks for the parts and one that merges, each of which
/// waits for its start and for all tasks of the step before.
pub fn simulated(costs: &Costs, kind: Kind, nodes: u32) -> f64 {
    let parts = kind.parts(costs, nodes);
    let seconds: Vec<f64> = (0..parts).map(|index| kind.part(costs, index, parts)).collect();
    let trial = |trial: u64| {
        let mut random = Stream::new(trial, Stage::Test, nodes.into(), 0);
        let mut slowness = || (SPREAD * normal(&mut random)).exp();
        let before = kind.before(costs).map_or(0.0, |before| START_UP + before * slowness());
        let longest = seconds.iter().map(|part| part * slowness()).fold(0.0, f64::max);
        before + START_UP + longest + START_UP + kind.merge(costs, parts) * slowness()
    };
    alone(costs) / ((0..TRIALS).map(trial).sum::<f64>() / TRIALS as f64)
}

/// A normal deviate (Box and Muller 1958, "A Note on the Generation of Random Normal Deviates").
fn normal(random: &mut Stream) -> f64 {
    let [u, v] = random.uniform2();
    (-2.0 * (1.0 - u).ln()).sqrt() * (std::f64::consts::TAU * v).cos()
}

/// The most nodes up to which the closed form gives at least half of what ideal ones would; `None` where even one
/// does not.
pub fn efficient_nodes(costs: &Costs, kind: Kind) -> Option<u32> {
    let is_good = |nodes: &u32| 2.0 * speed_up(costs, kind, *nodes) >= f64::from(*nodes);
    (1..=MOST_NODES).take_while(is_good).last()
}
