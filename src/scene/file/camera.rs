//! `[camera]`.

use glam::DVec3;

use crate::error::Result;
use crate::scene::camera::{Pose, Projection};
use crate::scene::reader::{Place, Range, Section};

/// `[camera]`: where it stands and what kind it is.
#[derive(Debug, Clone, PartialEq)]
pub struct CameraSection {
    /// Where the table stands.
    pub at: Place,
    /// `position`, `target`, `up`.
    pub pose: Pose,
    /// `type` and the keys of that type.
    pub projection: Projection,
}

#[derive(Clone, Copy)]
enum Kind {
    Perspective,
    Orthographic,
    LatLong,
}

const FOV: Range = Range::new(|x| x > 0.0 && x < 180.0, "an angle above 0 and below 180 degrees");

pub(super) fn read(section: &Section<'_>) -> Result<CameraSection> {
    let kind = section.or("type", Kind::Perspective, |v| {
        v.word(&[
            ("perspective", Kind::Perspective),
            ("orthographic", Kind::Orthographic),
            ("latlong", Kind::LatLong),
        ])
    })?;
    let (what, own): (&str, &[&str]) = match kind {
        Kind::Perspective => ("a perspective camera", &["fov", "aperture", "focus"]),
        Kind::Orthographic => ("an orthographic camera", &["height"]),
        Kind::LatLong => ("a latlong camera", &[]),
    };
    section.only(what, &[&["type", "position", "target", "up"], own].concat())?;
    Ok(CameraSection {
        at: section.place(),
        pose: pose(section)?,
        projection: projection(section, kind)?,
    })
}

fn projection(section: &Section<'_>, kind: Kind) -> Result<Projection> {
    Ok(match kind {
        Kind::Perspective => Projection::Perspective {
            fov: section.or("fov", 40.0, |v| v.number(FOV))?,
            aperture: section.or("aperture", 0.0, |v| v.number(Range::NOT_NEGATIVE))?,
            focus: section.maybe("focus", |v| v.number(Range::POSITIVE))?,
        },
        Kind::Orthographic => {
            let height = section.require("height", "the height of the view in metres")?;
            Projection::Orthographic { height: height.number(Range::POSITIVE)? }
        }
        Kind::LatLong => Projection::LatLong,
    })
}

fn pose(section: &Section<'_>) -> Result<Pose> {
    let position = section.require("position", "where the camera stands, [x, y, z] in metres")?;
    let target = section.require("target", "what the camera looks at, [x, y, z] in metres")?;
    let pose = Pose {
        position: position.triple(Range::ANY)?,
        target: target.triple(Range::ANY)?,
        up: section.or("up", DVec3::Y, |v| v.direction())?,
    };
    if pose.position == pose.target {
        return Err(target.wrong("a point other than the camera's position"));
    }
    if pose.axes().is_none() {
        let right = "a direction that is not parallel to the view from position to target";
        return Err(match section.get("up") {
            Some(up) => up.wrong(right),
            None => {
                let mut place = section.place();
                place.key.push_str(".up");
                place.error(format!(
                    "missing, and the default [0, 1, 0] is parallel to the view; give {right}"
                ))
            }
        });
    }
    Ok(pose)
}
