//! Cost of counted work: what decides must not depend on a clock, lest pictures depend on the machine.

use crate::work::Work;

/// Cost of one unit of each kind of work, in nanoseconds of a typical core: a fit of CPU times by the
/// counters of renders of all strategies.
struct UnitCosts {
    ray: f64,
    intersection: f64,
    march: f64,
    march_step: f64,
    grid_lookup: f64,
    collision: f64,
    gather: f64,
    gathered_photon: f64,
    surface_gather: f64,
    light_lookup: f64,
    photon_path: f64,
    flight: f64,
    crossing: f64,
    stored_photon: f64,
}

/// The costs that decide on strategies.
///
/// Unit: none. Bench: `cargo bench --bench results -- --only strategy`.
const UNIT_COSTS: UnitCosts = UnitCosts {
    ray: 150.0,
    intersection: 60.0,
    march: 180.0,
    march_step: 12.0,
    grid_lookup: 18.0,
    collision: 160.0,
    gather: 220.0,
    gathered_photon: 80.0,
    surface_gather: 1600.0,
    light_lookup: 15.0,
    photon_path: 600.0,
    flight: 100.0,
    crossing: 6.0,
    stored_photon: 860.0,
};

/// Cost of this work in nanoseconds, without stored photons and crossings of cells. Density estimates
/// count as the share `gathering` of them that is made.
pub fn cost(work: &Work, gathering: f64) -> f64 {
    let unit = &UNIT_COSTS;
    let each = [
        (work.rays, unit.ray),
        (work.shadow_rays + work.intersections, unit.intersection),
        (work.marches, unit.march),
        (work.march_steps, unit.march_step),
        (work.grid_lookups, unit.grid_lookup),
        (work.collisions, unit.collision),
        (work.gathers, unit.gather),
        (work.environment_lookups + work.light_choices, unit.light_lookup),
        (work.photon_paths, unit.photon_path),
        (work.tracks, unit.flight),
    ];
    let shared =
        [(work.gathered, unit.gathered_photon), (work.surface_gathers, unit.surface_gather)];
    let sum = |costs: &[(u64, f64)]| costs.iter().map(|(n, cost)| *n as f64 * cost).sum::<f64>();
    sum(&each) + gathering * sum(&shared)
}

/// Cost in nanoseconds of storing so many volume photons and building their map.
pub fn cost_of_storing(photons: f64) -> f64 {
    photons * UNIT_COSTS.stored_photon
}

/// Cost in nanoseconds of flights that cross so many cells, each counted for every value of the cell.
pub fn cost_of_crossings(values: f64) -> f64 {
    values * UNIT_COSTS.crossing
}
