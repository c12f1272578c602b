//! Keys at the top of a scene, outside of all tables.

use super::Without::Other;
use super::{Key, Kind, Table};

pub(in crate::scene) const USD: Key = Key::new(
    "usd",
    Kind::File("a USD file (.usd, .usda, .usdc, .usdz)"),
    "",
    Other("the scene stands alone"),
    "A shot that the scene adds to. Its own `[camera]` and `[film]` stand over those of the shot, and a medium with the path of a volume as its `name` over that.",
);
pub(in crate::scene) const USD_CAMERA: Key = Key::new(
    "usd_camera",
    Kind::Text("the path or name of a camera"),
    "",
    Other("the first"),
    "The camera of the shot.",
);

pub(in crate::scene) const SHOT: Table = Table { what: "a scene", keys: &[&USD, &USD_CAMERA] };
