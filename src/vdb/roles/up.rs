//! Which way is up in a file.

use glam::DVec3;

/// An axis of the world.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Axis {
    /// The x axis.
    X,
    /// The y axis, up in most tools.
    Y,
    /// The z axis, up in Blender, 3ds Max and Unreal.
    Z,
}

impl Axis {
    /// The unit vector along it.
    pub fn unit(self) -> DVec3 {
        match self {
            Self::X => DVec3::X,
            Self::Y => DVec3::Y,
            Self::Z => DVec3::Z,
        }
    }

    /// `x`, `y` or `z`.
    pub const fn name(self) -> &'static str {
        match self {
            Self::X => "x",
            Self::Y => "y",
            Self::Z => "z",
        }
    }
}

/// Names of grids and of metadata by which a cache of Blender's Mantaflow is known: whole, or with
/// `*` at an end.
const MANTAFLOW: [&str; 3] = ["flags", "phi_obstacle", "file_base_resolution"];
const MANTAFLOW_ENDING: &str = "_inflow";

/// How many times as large as its other components the mean velocity must be along an axis.
const DOMINANT: f64 = 2.0;
/// The share of the mean speed that the mean velocity must have: other smoke only churns.
const DIRECTED: f64 = 0.25;

/// Whether these names of grids or of metadata are those of a cache of Blender's Mantaflow.
pub(super) fn is_mantaflow<'n>(mut names: impl Iterator<Item = &'n str>) -> bool {
    names.any(|name| MANTAFLOW.contains(&name) || name.ends_with(MANTAFLOW_ENDING))
}

/// The axis that names of grids or of metadata tell.
pub(super) fn by_names<'n>(names: impl Iterator<Item = &'n str>) -> Option<(Axis, &'static str)> {
    is_mantaflow(names).then_some((Axis::Z, "a cache of Blender's Mantaflow"))
}

/// The axis along which smoke rises: y or z, where the mean velocity of the smoke is positive along
/// it, at least twice as large as along each other axis, and at least a quarter of the mean speed.
/// What falls or drifts sideways tells nothing.
pub(super) fn by_motion(mean: DVec3, speed: f64) -> Option<(Axis, &'static str)> {
    let rises = |axis: Axis| {
        let along = mean.dot(axis.unit());
        let across = (mean - along * axis.unit()).abs().max_element();
        along > 0.0 && along >= DOMINANT * across && along >= DIRECTED * speed
    };
    [Axis::Y, Axis::Z].into_iter().find(|&axis| rises(axis)).map(|axis| (axis, "its smoke rises"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn smoke_that_rises_tells_its_axis() {
        let axis = |x, y, z, speed| by_motion(DVec3::new(x, y, z), speed).map(|(axis, _)| axis);
        assert_eq!(axis(0.1, 1.0, -0.4, 2.0), Some(Axis::Y));
        assert_eq!(axis(-0.4, 0.1, 1.0, 2.0), Some(Axis::Z));
        assert_eq!(axis(0.1, -1.0, 0.1, 2.0), None, "it falls");
        assert_eq!(axis(1.0, 0.1, 0.1, 2.0), None, "wind");
        assert_eq!(axis(0.6, 1.0, 0.1, 2.0), None, "aslant");
        assert_eq!(axis(0.0, 1.0, 0.0, 5.0), None, "it churns");
        assert_eq!(axis(0.0, 0.0, 0.0, 0.0), None, "it rests");
    }

    #[test]
    fn caches_of_mantaflow_are_known_by_their_names() {
        for name in ["flags", "phi_obstacle", "density_inflow", "file_base_resolution"] {
            assert_eq!(
                by_names(["density", name].into_iter()).map(|(axis, _)| axis),
                Some(Axis::Z)
            );
        }
        assert_eq!(by_names(["density", "phi", "flag"].into_iter()), None);
    }
}
