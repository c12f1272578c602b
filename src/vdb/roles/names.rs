//! The names by which grids are recognised.

use std::fmt::{self, Display};

/// What a grid is to a renderer.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Role {
    /// Amount of smoke, fog or cloud.
    Density,
    /// Strength of what glows.
    Fire,
    /// Temperature; it glows where its values say so.
    Temperature,
    /// What may burn. It glows only in a file without fire and temperature.
    Fuel,
    /// Colour of the smoke, three components.
    Color,
    /// Velocity of the smoke, three components.
    Velocity,
    /// Data of a simulation that no renderer shows.
    Other,
}

impl Display for Role {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Density => "density",
            Self::Fire => "fire",
            Self::Temperature => "temperature",
            Self::Fuel => "fuel",
            Self::Color => "colour",
            Self::Velocity => "velocity",
            Self::Other => "never taken",
        })
    }
}

/// A row of [`NAMES`].
#[derive(Debug, Clone, Copy)]
pub struct KnownName {
    /// The name in lower case; a `*` at either end stands for any text, an empty one too.
    pub pattern: &'static str,
    /// What grids of the name are.
    pub role: Role,
    /// Who writes it.
    pub writers: &'static str,
}

const fn known(pattern: &'static str, role: Role, writers: &'static str) -> KnownName {
    KnownName { pattern, role, writers }
}

/// All names that are recognised. Within a role earlier rows are preferred; rows of
/// [`Role::Other`] win over all others.
pub const NAMES: &[KnownName] = &[
    known("density", Role::Density, "Houdini, Blender, EmberGen, Maya, Cinema 4D, cloud data sets"),
    known("dens", Role::Density, "in-house tools"),
    known("soot", Role::Density, "fire simulations"),
    known("smoke", Role::Density, "FumeFX, Phoenix FD, TurbulenceFD, NVIDIA Flow"),
    known("fog_density", Role::Density, "Bifrost (`voxel_fog_density`)"),
    known("*density*", Role::Density, "anything else with density in its name"),
    known("extinction", Role::Density, "volume shaders of USD"),
    known("fog", Role::Density, "in-house tools"),
    known("cloud", Role::Density, "in-house tools"),
    known("flame", Role::Fire, "Houdini since 18.5, Blender, Axiom"),
    known("flames", Role::Fire, "EmberGen"),
    known("heat", Role::Fire, "Houdini's older pyro, Blender before 2.82"),
    known("burn", Role::Fire, "Houdini, TurbulenceFD, NVIDIA Flow"),
    known("fire", Role::Fire, "FumeFX"),
    known("emission", Role::Fire, "shaded volumes; in Mantaflow's caches it marks sources instead"),
    known("emit", Role::Fire, "shaded volumes"),
    known("incandescence", Role::Fire, "Maya"),
    known(
        "temperature",
        Role::Temperature,
        "Houdini, Blender, EmberGen, Bifrost, Phoenix FD, Maya",
    ),
    known("temp", Role::Temperature, "in-house tools"),
    known("kelvin", Role::Temperature, "in-house tools"),
    known("fuel", Role::Fuel, "Houdini, Blender, Bifrost, FumeFX, Phoenix FD, Maya"),
    known("cd", Role::Color, "Houdini"),
    known(
        "color",
        Role::Color,
        "Blender (`color_r`, `color_g`, `color_b`), Cinema 4D, Maya, Bifrost",
    ),
    known("colour", Role::Color, "in-house tools"),
    known("albedo", Role::Color, "shaded volumes"),
    known("scatter", Role::Color, "Houdini's baked pyro"),
    known("scattering", Role::Color, "shaded volumes"),
    known("rgb", Role::Color, "Phoenix FD"),
    known("vel", Role::Velocity, "Houdini (also `vel.x`, `vel.y`, `vel.z`), TurbulenceFD"),
    known("v", Role::Velocity, "Houdini"),
    known("velocity", Role::Velocity, "Blender, EmberGen, Bifrost, Cinema 4D, NVIDIA Flow"),
    known("shadow", Role::Other, "Blender: light that reaches a voxel"),
    known("phi_*", Role::Other, "Mantaflow: distances to obstacles, sources and outlets"),
    known("flags", Role::Other, "Mantaflow: kinds of cells"),
    known("*_inflow", Role::Other, "Mantaflow: what sources add"),
    known("*_previous", Role::Other, "Mantaflow: the frame before"),
    known("*_prev", Role::Other, "the frame before"),
    known("*_old", Role::Other, "the frame before"),
    known("react*", Role::Other, "Mantaflow: progress of the reaction"),
    known("*sdf", Role::Other, "signed distances"),
    known("*distance*", Role::Other, "signed distances; Bifrost (`voxel_signed_distance`)"),
    known("surface", Role::Other, "Houdini: signed distances"),
    known("*collision*", Role::Other, "Houdini: obstacles"),
    known("*obstacle*", Role::Other, "Blender: obstacles"),
    known("*mask", Role::Other, "masks of simulations"),
    known("rest", Role::Other, "Houdini: coordinates at rest (also `rest2`)"),
    known("*pressure*", Role::Other, "pressure solvers"),
    known("*divergence*", Role::Other, "pressure solvers, NVIDIA Flow"),
    known("*vorticity*", Role::Other, "curl of the velocity"),
    known("*gradient*", Role::Other, "derivatives"),
];

/// Words after a separator that say which of several grids of a kind one is.
const VARIANTS: [&str; 12] = [
    "hires", "highres", "high", "lowres", "low", "fine", "coarse", "main", "noise", "vdb", "grid",
    "volume",
];
/// What may stand between a name and its suffix.
const SEPARATORS: [char; 5] = ['_', '.', '-', ':', ' '];
/// Before the names of Bifrost.
const PREFIX: &str = "voxel_";

/// The role of grids called `name`, and how many rows of [`NAMES`] are preferred to the one by which
/// it is known; nothing where it is not known. Case does not matter, nor does `voxel_` before the
/// name, nor numbers and words such as `hires` after it.
pub fn role_of(name: &str) -> Option<(Role, usize)> {
    let name = name.to_lowercase();
    let full = name.strip_prefix(PREFIX).unwrap_or(&name);
    let stem = without_suffixes(full);
    let rows = || NAMES.iter().enumerate();
    let by =
        |(_, row): &(usize, &KnownName)| matches(row.pattern, full) || matches(row.pattern, stem);
    let other = rows().filter(|(_, row)| row.role == Role::Other).find(by);
    other.or_else(|| rows().find(by)).map(|(rank, row)| (row.role, rank))
}

fn matches(pattern: &str, name: &str) -> bool {
    match (pattern.strip_prefix('*'), pattern.strip_suffix('*')) {
        (Some(_), Some(_)) => name.contains(pattern.trim_matches('*')),
        (Some(end), None) => name.ends_with(end),
        (None, Some(start)) => name.starts_with(start),
        (None, None) => name == pattern,
    }
}

/// `density` of `density_0`, `density1` and `density.hires`.
fn without_suffixes(name: &str) -> &str {
    let mut stem = name;
    loop {
        let numberless = stem.trim_end_matches(|c: char| c.is_ascii_digit());
        let shorter = numberless.trim_end_matches(SEPARATORS);
        let shorter = match shorter.rsplit_once(SEPARATORS) {
            Some((before, variant)) if VARIANTS.contains(&variant) => before,
            _ => shorter,
        };
        if shorter == stem || shorter.is_empty() {
            return stem;
        }
        stem = shorter;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Set where the table in the documentation is to be written anew.
    const RENEW: &str = "RENEW_NAMES";

    fn table() -> String {
        let mut table =
            String::from("| name | taken for | written by |\n| ---- | --------- | ---------- |\n");
        for KnownName { pattern, role, writers } in NAMES {
            table += &format!("| `{pattern}` | {role} | {writers} |\n");
        }
        table
    }

    #[test]
    fn the_documented_table_is_the_one_in_use() {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/src/guide/names.md");
        if std::env::var_os(RENEW).is_some() {
            std::fs::write(path, table()).expect("written");
        }
        let documented = std::fs::read_to_string(path).expect("the table");
        assert!(
            documented == table(),
            "{path} differs from NAMES; renew it: {RENEW}=1 cargo test --lib \
             the_documented_table_is_the_one_in_use"
        );
    }

    #[test]
    fn names_are_known_in_any_case_and_with_suffixes() {
        let role = |name| role_of(name).map(|(role, _)| role);
        for (wanted, names) in [
            (
                Role::Density,
                &[
                    "density",
                    "Density1",
                    "density_0",
                    "density.hires",
                    "DENSITY",
                    "Soot",
                    "smoke_2",
                    "voxel_fog_density",
                    "my_density_final",
                    "smoke.hires.3",
                ][..],
            ),
            (Role::Fire, &["flame", "Flames", "flames_12", "heat", "burn.low", "voxel_flame"]),
            (Role::Temperature, &["temperature", "Temp", "voxel_temperature", "temperature 2"]),
            (Role::Fuel, &["fuel", "voxel_fuel"]),
            (Role::Color, &["Cd", "cd_0", "Color", "albedo", "scatter"]),
            (Role::Velocity, &["v", "V", "vel", "Velocity"]),
            (
                Role::Other,
                &[
                    "shadow",
                    "phi_out",
                    "flags",
                    "density_inflow",
                    "velocity_previous",
                    "react",
                    "sdf",
                    "distance",
                    "rest",
                    "rest2",
                    "pressure",
                    "divergence",
                    "density_old",
                    "fuel_inflow",
                    "voxel_signed_distance",
                    "heat_mask",
                ],
            ),
        ] {
            for name in names {
                assert_eq!(role(name), Some(wanted), "{name}");
            }
        }
        for name in ["", "a", "0", "_1", "tempest", "vex", "x", "colored", "dust"] {
            assert_eq!(role(name), None, "{name}");
        }
    }

    #[test]
    fn every_row_is_reached() {
        for (rank, row) in NAMES.iter().enumerate() {
            let name = row.pattern.replace('*', "a");
            assert_eq!(role_of(&name), Some((row.role, rank)), "{name}");
        }
    }
}
