//! Keys of `[render]`.

use super::Without::{Default, Other};
use super::{Key, Kind, Table};
use crate::scene::directing::{Director, names};
use crate::scene::reader::Range;
use crate::scene::settings::{
    ErrorGoal, FinalGather, MAX_PHOTONS, MAX_RAYS, MAX_SCATTER, StrategyRequest,
};

pub(in crate::scene) const RAYS: Key =
    Key::new("rays", Kind::Whole(1, MAX_RAYS as u64), "", Default("16"), "Camera rays a pixel.")
        .flag("rays");
pub(in crate::scene) const PHOTONS: Key =
    Key::new("photons", Kind::Whole(0, MAX_PHOTONS), "", Default("1_000_000"), "Photon paths.")
        .flag("photons");
pub(in crate::scene) const RADIUS: Key = Key::new(
    "radius",
    Kind::Number(Range::POSITIVE),
    "m",
    Other("from the spacing of the photons and the voxel size"),
    "Gather radius.",
)
.flag("radius");
pub(in crate::scene) const STEP: Key = Key::new(
    "step",
    Kind::Number(Range::POSITIVE),
    "m",
    Other("exact integration, cell by cell"),
    "March step.",
)
.flag("step");
pub(in crate::scene) const DIRECTOR: Key = Key::new(
    "director",
    Kind::Word(|| names(Director::ALL)),
    "",
    Default("\"fixed\""),
    "Who decides what a pixel may spend.",
)
.flag("director");
pub(in crate::scene) const SEED: Key = Key::new(
    "seed",
    Kind::Whole(0, i64::MAX as u64),
    "",
    Default("0"),
    "Seed of every random stream.",
)
.flag("seed");
pub(in crate::scene) const MAX_ORDER: Key = Key::new(
    "max_scatter",
    Kind::Whole(0, MAX_SCATTER as u64),
    "",
    Other("no limit"),
    "Highest order of volume scattering; 1 is single scattering. Above 1, only `beams` and `fluence-toward-eye` count \
     orders.",
)
.flag("max-scatter");
pub(in crate::scene) const STRATEGY: Key = Key::new(
    "strategy",
    Kind::Word(|| names(StrategyRequest::ALL)),
    "",
    Default("\"auto\""),
    "Estimator of light scattered in media; `auto` takes the one that a pilot finds best.",
)
.flag("strategy");
pub(in crate::scene) const FINAL_GATHER: Key = Key::new(
    "final_gather",
    Kind::Word(|| names(FinalGather::ALL)),
    "",
    Default("\"auto\""),
    "Whether the strategy `auto` may be final gathers, or must where it can.",
)
.flag("final-gather");
pub(in crate::scene) const DENOISE: Key = Key::new(
    "denoise",
    Kind::Switch,
    "",
    Default("false"),
    "Whether Open Image Denoise takes noise off the finished picture.",
);
pub(in crate::scene) const RECONSTRUCT: Key = Key::new(
    "reconstruct",
    Kind::Switch,
    "",
    Default("false"),
    "Whether the finished picture is reconstructed from its components, with less noise.",
);

pub(in crate::scene) const ERROR: Key = Key::new(
    "error",
    Kind::NumberOr(Range::POSITIVE, &[ErrorGoal::VISIBLE]),
    "",
    Other("as many rays and photons as are given"),
    "Error at which the render ends, with as many rays and photons as it takes: relative to the radiance, in the worst \
     hundredth of blocks of 8 x 8 pixels; `visible` where no difference is seen in those.",
)
.flag("error");

pub(in crate::scene) const RENDER: Table = Table {
    what: "[render]",
    keys: &[
        &RAYS,
        &PHOTONS,
        &RADIUS,
        &STEP,
        &DIRECTOR,
        &SEED,
        &MAX_ORDER,
        &STRATEGY,
        &FINAL_GATHER,
        &DENOISE,
        &RECONSTRUCT,
        &ERROR,
    ],
};
