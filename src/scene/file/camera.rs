//! `[camera]`.

use crate::error::Result;
use crate::scene::camera::{Pose, Projection};
use crate::scene::keys::{Key, camera as keys};
use crate::scene::reader::{Place, Section, Value};

/// `[camera]`: where it stands and what kind it is.
#[derive(Debug, Clone, PartialEq)]
pub struct CameraSection {
    /// Where the table stands.
    pub at: Place,
    /// `position`, `target`, `up`.
    pub pose: Pose,
    /// `type` and the keys of that type.
    pub projection: Projection,
    /// `clip`.
    pub clip: Option<[f64; 2]>,
    /// `next`: where it is one frame later.
    pub next: Option<Pose>,
}

#[derive(Clone, Copy)]
enum Kind {
    Perspective,
    Orthographic,
    LatLong,
}

const KINDS: &[(&str, Kind)] = &[
    ("perspective", Kind::Perspective),
    ("orthographic", Kind::Orthographic),
    ("latlong", Kind::LatLong),
];

pub(super) fn read(section: &Section<'_>) -> Result<CameraSection> {
    let kind = section.word(&keys::TYPE, KINDS)?;
    section.only(match kind {
        Kind::Perspective => &keys::PERSPECTIVE,
        Kind::Orthographic => &keys::ORTHOGRAPHIC,
        Kind::LatLong => &keys::LATLONG,
    })?;
    let pose = pose(section)?;
    Ok(CameraSection {
        at: section.place(),
        projection: projection(section, kind)?,
        clip: clip(section)?,
        next: section.maybe(&keys::NEXT, |value| next(value, &pose))?,
        pose,
    })
}

/// The pose one frame later, that of the camera where nothing else is said.
fn next(value: &Value<'_>, pose: &Pose) -> Result<Pose> {
    let section = Section::from_value(value, &keys::NEXT.kind.right())?;
    section.only(&keys::NEXT_POSE)?;
    let triple = |key: &Key, known| match section.get(key) {
        Some(_) => section.triple(key),
        None => Ok(known),
    };
    let next = Pose {
        position: triple(&keys::POSITION, pose.position)?,
        target: triple(&keys::TARGET, pose.target)?,
        up: triple(&keys::UP, pose.up)?,
    };
    if next.axes().is_none() {
        return Err(value.wrong(
            "a pose whose target is not its position, and whose `up` is not parallel to the view",
        ));
    }
    Ok(next)
}

fn clip(section: &Section<'_>) -> Result<Option<[f64; 2]>> {
    let clip = section.maybe_pair(&keys::CLIP)?;
    if clip.is_some_and(|[near, far]| near >= far) {
        return Err(section
            .require(&keys::CLIP)?
            .wrong("a farthest distance above the nearest one"));
    }
    Ok(clip)
}

fn projection(section: &Section<'_>, kind: Kind) -> Result<Projection> {
    Ok(match kind {
        Kind::Perspective => Projection::Perspective {
            fov: section.number(&keys::FOV)?,
            aperture: section.number(&keys::APERTURE)?,
            focus: section.maybe_number(&keys::FOCUS)?,
            shift: section.pair(&keys::SHIFT)?,
        },
        Kind::Orthographic => Projection::Orthographic {
            height: section.number(&keys::HEIGHT)?,
            shift: section.pair(&keys::SHIFT)?,
        },
        Kind::LatLong => Projection::LatLong,
    })
}

fn pose(section: &Section<'_>) -> Result<Pose> {
    let pose = Pose {
        position: section.triple(&keys::POSITION)?,
        target: section.triple(&keys::TARGET)?,
        up: section.triple(&keys::UP)?,
    };
    if pose.position == pose.target {
        let target = section.require(&keys::TARGET)?;
        return Err(target.wrong("a point other than the camera's position"));
    }
    if pose.axes().is_none() {
        let right = "a direction that is not parallel to the view from position to target";
        return Err(match section.get(&keys::UP) {
            Some(up) => up.wrong(right),
            None => section.place().below(".up").error(format!(
                "missing, and the default [0, 1, 0] is parallel to the view; give {right}"
            )),
        });
    }
    Ok(pose)
}
