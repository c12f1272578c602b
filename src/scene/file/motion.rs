//! `[motion]`, and what moves.

use glam::{DAffine3, DMat3, DVec3};

use super::turn;
use crate::error::Result;
use crate::scene::keys::surface::{MOVES, MOVES_TABLE};
use crate::scene::keys::{medium as medium_keys, motion as keys};
use crate::scene::reader::{Place, Section, Value, with_empty};
use crate::sequence::FrameTime;

/// `[motion]`: when the shutter is open. Times are in frames from the frame of the scene.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MotionSection {
    /// When it opens.
    pub open: f64,
    /// For how long.
    pub shutter: f64,
    /// Frames a second.
    pub fps: f64,
    /// Parts into which it is cut, where that is given.
    pub times: Option<u32>,
    /// How long after the frame of the scene the picture is, in frames: from 0 to less than 1. Its files are those of that frame,
    /// and of the next one where that is above 0.
    pub fraction: f64,
}

impl MotionSection {
    /// Its middle.
    pub fn middle(&self) -> f64 {
        self.open + 0.5 * self.shutter
    }

    /// The middles of its parts, of which there are `count`.
    pub fn middles(self, count: u32) -> impl Iterator<Item = f64> {
        let part = self.shutter / f64::from(count);
        (0..count).map(move |k| self.open + (f64::from(k) + 0.5) * part)
    }

    /// How far from the time `from` it is open, at most.
    pub fn farthest(&self, from: f64) -> f64 {
        (self.open - from).abs().max((self.open + self.shutter - from).abs())
    }

    /// Whether all is as it is at the frame of the scene.
    pub fn is_of_frame(&self) -> bool {
        self.farthest(0.0) == 0.0
    }

    /// The share of the next frame at the time `frames`.
    pub fn share_of_next(frames: f64) -> f64 {
        frames.clamp(0.0, 1.0)
    }
}

/// What is added to a placement in a frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MotionStep {
    /// Metres.
    translate: DVec3,
    /// Degrees about x, y and z in this order.
    rotate: DVec3,
}

impl MotionStep {
    /// What `placement` becomes so many `frames` later: turned where it is, and moved.
    pub fn placed(&self, placement: &DAffine3, frames: f64) -> DAffine3 {
        let turn: DMat3 = turn(self.rotate * frames);
        let matrix3 = turn * placement.matrix3;
        DAffine3 { matrix3, translation: placement.translation + self.translate * frames }
    }

    /// What takes places of what `placement` puts there from the time `from` to the time `to`, in frames.
    pub fn displacement(&self, placement: &DAffine3, from: f64, to: f64) -> DAffine3 {
        self.placed(placement, to) * self.placed(placement, from).inverse()
    }
}

/// Where the velocities of a medium are, and what they are given in.
#[derive(Debug, Clone, PartialEq)]
pub struct VelocitySection {
    /// `velocity`.
    pub name: VelocityName,
    /// `velocity_unit`.
    pub unit: VelocityUnit,
    /// `velocity_scale`.
    pub scale: f64,
}

/// Which grid holds velocities.
#[derive(Debug, Clone, PartialEq)]
pub enum VelocityName {
    /// The one that has a usual name, if there is any.
    Usual,
    /// None.
    Still,
    /// The vector grid of this name, where it is given.
    Vector(Place, String),
    /// Three scalar grids of these names.
    Components(Place, [String; 3]),
}

/// What velocities are given in.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum VelocityUnit {
    /// Metres a second.
    MetresASecond,
    /// Metres a frame.
    MetresAFrame,
    /// Voxels of their grid a frame.
    VoxelsAFrame,
}

/// Reads `[motion]` of a scene's top table.
pub(super) fn read(root: &Section<'_>) -> Result<MotionSection> {
    let read = |section: &Section<'_>| {
        section.only(&keys::MOTION)?;
        let shutter = section.number(&keys::SHUTTER)?;
        let before = section
            .word(&keys::SHUTTER_POSITION, &[("center", 0.5), ("start", 0.0), ("end", 1.0)])?;
        // It only tells which files are read.
        section.maybe_number(&keys::FRAME)?;
        let fraction = root.frame().map_or(0.0, FrameTime::fraction);
        Ok(MotionSection {
            open: fraction - before * shutter,
            shutter,
            fraction,
            fps: section.number(&keys::FPS)?,
            times: section.maybe_whole(&keys::TIMES)?.map(|times| times as u32),
        })
    };
    match root.table("motion", "a table [motion]")? {
        Some(section) => read(&section),
        None => with_empty(read),
    }
}

/// Reads `motion` of a surface or a medium.
pub(super) fn step(section: &Section<'_>) -> Result<Option<MotionStep>> {
    section.maybe(&MOVES, |value| {
        let section = Section::from_value(value, &MOVES.kind.right())?;
        section.only(&MOVES_TABLE)?;
        let [translate, rotate] = [MOVES_TABLE.keys[0], MOVES_TABLE.keys[1]];
        Ok(MotionStep { translate: section.triple(translate)?, rotate: section.triple(rotate)? })
    })
}

/// Reads what a medium says of its velocities.
pub(super) fn velocity(section: &Section<'_>) -> Result<VelocitySection> {
    use VelocityUnit::{MetresAFrame, MetresASecond, VoxelsAFrame};
    let name = match section.get(&medium_keys::VELOCITY) {
        Some(value) => name(section, &value)?,
        // What moves as a whole is not carried by velocities beside.
        None if section.get(&MOVES).is_some() => VelocityName::Still,
        None => VelocityName::Usual,
    };
    Ok(VelocitySection {
        name,
        unit: section.word(
            &medium_keys::VELOCITY_UNIT,
            &[("m/s", MetresASecond), ("m/frame", MetresAFrame), ("voxels/frame", VoxelsAFrame)],
        )?,
        scale: section.number(&medium_keys::VELOCITY_SCALE)?,
    })
}

fn name(section: &Section<'_>, value: &Value<'_>) -> Result<VelocityName> {
    let right = medium_keys::VELOCITY.kind.right();
    let is_still = value.is_string() && value.string(&right)? == "none";
    if is_still {
        return Ok(VelocityName::Still);
    }
    if section.get(&medium_keys::REGION_KEY).is_some() {
        return Err(
            value.error("belongs to `file`, but the medium has a `region`; give that a `motion`")
        );
    }
    section.at_most_one(&[&medium_keys::VELOCITY, &MOVES])?;
    if value.is_string() {
        return Ok(VelocityName::Vector(value.place(), value.string(&right)?.to_owned()));
    }
    let names = value.list(3, &right)?;
    let names = names.iter().map(|name| name.string(&right).map(str::to_owned));
    let names = names.collect::<Result<Vec<_>>>()?;
    let names = names.try_into().map_err(|_| value.wrong(&right))?;
    Ok(VelocityName::Components(value.place(), names))
}
