//! The scene at other times of the shutter.

use std::sync::Arc;

use glam::{DAffine3, DMat3, DVec3};

use super::context::{Context, at};
use super::{grids, media, retime};
use crate::error::Result;
use crate::math::{Aabb, World};
use crate::medium::{Media, Medium};
use crate::scene::Aov;
use crate::scene::camera::{Camera, CameraMatrices};
use crate::scene::file::{
    DensitySection, MediumSection, MotionSection, MotionStep, SceneFile, VelocitySection,
    VelocityUnit,
};
use crate::scene::frame_motion::{FrameMotion, MediumStep};
use crate::surface::Surfaces;
use crate::vdb::{Advection, Drift};

/// Times of a shutter in which something moves, at least and at most, where their number is not given.
///
/// Unit: count. Limit: on memory and on the work of grids, photons and caches for each.
const TIMES: [u32; 2] = [2, 32];

/// How a medium comes to other times than that of its frame.
#[derive(Debug)]
pub(super) struct MediumAnimation<'a> {
    /// The velocities that carry it.
    drift: Option<Arc<Drift>>,
    /// That of the next frame with its velocities, where the scene is between the two.
    next: Option<(&'a MediumSection, Option<Arc<Drift>>)>,
}

impl MediumAnimation<'_> {
    /// The largest velocity of its smoke, in metres a frame.
    fn fastest(&self) -> f64 {
        let next = self.next.as_ref().and_then(|(_, drift)| drift.as_ref());
        self.drift.iter().chain(next).map(|drift| drift.fastest()).fold(0.0, f64::max)
    }

    /// The velocities of the frame that is nearest to the time `frames`.
    fn nearest(&self, frames: f64) -> Option<&Arc<Drift>> {
        let next = self.next.as_ref().filter(|_| MotionSection::share_of_next(frames) > 0.5);
        next.map_or(self.drift.as_ref(), |(_, drift)| drift.as_ref())
    }
}

/// How each medium of `file` comes to the times at which the shutter is open.
pub(super) fn animations<'a>(
    file: &'a SceneFile,
    context: &mut Context,
) -> Result<Vec<MediumAnimation<'a>>> {
    let mut of = |section: &MediumSection, frame| {
        if file.motion.is_of_frame() && !file.film.passes.has(Aov::Motion) {
            return Ok(None);
        }
        let medium = media::build(section, context)?;
        Ok(drift(section, &medium, (&file.motion, frame), context)?.map(Arc::new))
    };
    let mut animations = Vec::new();
    for (section, next) in file.media.iter().zip(&file.next_media) {
        let drift = of(section, 0.0)?;
        let next = match next {
            Some(next) => Some((next, of(next, 1.0)?)),
            None => None,
        };
        animations.push(MediumAnimation { drift, next });
    }
    for (section, animation) in file.media.iter().zip(&animations) {
        if animation.next.is_some() && animation.fastest() == 0.0 && section.motion.is_none() {
            context.notes.push(format!(
                "{}: has no velocities, so that what is between two frames is the mean of both",
                section.name
            ));
        }
    }
    Ok(animations)
}

/// What the hash of a scene has of the time of `file`; nothing at that of a frame.
pub(super) fn hashed(file: &SceneFile) -> String {
    let fraction = file.motion.fraction;
    if fraction == 0.0 { String::new() } else { format!("{fraction}\n") }
}

/// The media of `file`, which come there by these `animations`, so many `frames` after the frame of the scene, as `camera` sees them.
pub(super) fn media(
    frames: f64,
    file: &SceneFile,
    animations: &[MediumAnimation<'_>],
    camera: &Camera,
    context: &mut Context,
) -> Result<Media> {
    let of = |(section, animation): (&MediumSection, &MediumAnimation<'_>)| {
        let medium = medium(section, animation, frames, &file.motion, context)?;
        Ok(media::resolved(medium, camera))
    };
    file.media.iter().zip(animations).map(of).collect::<Result<_>>().map(Media::new)
}

/// How `medium`, that of `section` at its frame, which is so many after that of the scene, is carried by velocities while the
/// shutter is open; `None` where there are none.
fn drift(
    section: &MediumSection,
    medium: &Medium,
    (motion, frame): (&MotionSection, f64),
    context: &mut Context,
) -> Result<Option<Drift>> {
    let DensitySection::Grid { grid: density, .. } = &section.density else { return Ok(None) };
    let Some(smoke) = medium.density.grid() else { return Ok(None) };
    let Some(velocity) = grids::velocity(density, &section.velocity.name, context)? else {
        return Ok(None);
    };
    let VelocitySection { unit, scale, .. } = section.velocity;
    let placement = section.placement.matrix3;
    let to_world: DMat3 = match unit {
        VelocityUnit::MetresASecond => placement * (1.0 / motion.fps),
        VelocityUnit::MetresAFrame => placement,
        VelocityUnit::VoxelsAFrame => placement * velocity.transform().affine().matrix3,
    };
    let velocity = grids::placed(velocity, &section.placement, &density.at)?;
    Ok(Some(Drift::new(&velocity, to_world * scale, smoke, motion.farthest(frame))))
}

/// The medium of `section`, which comes there by its `animation`, so many `frames` after the frame of the scene.
fn medium(
    section: &MediumSection,
    animation: &MediumAnimation<'_>,
    frames: f64,
    motion: &MotionSection,
    context: &mut Context,
) -> Result<Medium> {
    let drift = animation.drift.as_deref();
    let Some((next, next_drift)) = &animation.next else {
        // One file for all frames stays where it is, but while the shutter is open.
        let advection = Advection { drift, frames: frames - motion.fraction };
        return at(&section.at, retime::carried(placed(section, frames, context)?, &advection));
    };
    let advections = [
        Advection { drift, frames },
        Advection { drift: next_drift.as_deref(), frames: frames - 1.0 },
    ];
    let share = MotionSection::share_of_next(frames);
    if share == 0.0 {
        let medium = placed(section, frames, context)?;
        return at(&section.at, retime::carried(medium, &advections[0]));
    }
    let medium = placed(next, frames - 1.0, context)?;
    if share == 1.0 {
        return at(&next.at, retime::carried(medium, &advections[1]));
    }
    let media = [placed(section, frames, context)?, medium];
    at(&section.at, retime::blended(media, &advections, share))
}

/// The medium of `section` where its own motion places it, so many `frames` after its frame.
fn placed(section: &MediumSection, frames: f64, context: &mut Context) -> Result<Medium> {
    match &section.motion {
        Some(motion) => {
            let placement = motion.placed(&section.placement, frames);
            media::build(&MediumSection { placement, ..section.clone() }, context)
        }
        None => media::build(section, context),
    }
}

/// Where all of `file` is one frame after the time `frames`, where motion vectors are asked for: from `here` to what is `later`, each
/// a camera with its surfaces.
pub(super) fn frame_motion(
    frames: f64,
    file: &SceneFile,
    animations: &[MediumAnimation<'_>],
    here: (&Camera, &Surfaces),
    later: (Camera, Arc<Surfaces>),
) -> FrameMotion {
    let placed = |motion: Option<&MotionStep>, still: &DAffine3| {
        let displacement = |step: &MotionStep| step.displacement(still, frames, frames + 1.0);
        motion.map_or(DAffine3::IDENTITY, displacement)
    };
    let media = file.media.iter().zip(animations).map(|(section, animation)| {
        match animation.nearest(frames) {
            Some(drift) => MediumStep::Carried(Arc::clone(drift)),
            None => MediumStep::Placed(placed(section.motion.as_ref(), &section.placement)),
        }
    });
    // Those of lights come first, and stand still.
    let of_lights = here.1.surfaces().len() - file.surfaces.len();
    let surfaces = file.surfaces.iter().map(|s| placed(s.motion.as_ref(), &s.placement));
    let surfaces = std::iter::repeat_n(DAffine3::IDENTITY, of_lights).chain(surfaces).collect();
    FrameMotion::new([*here.0, later.0], file.film.size, later.1, surfaces, media.collect())
}

/// What moves while the shutter is open.
pub(super) struct Moving<'a> {
    /// The scene's file.
    pub(super) file: &'a SceneFile,
    /// The cameras when the shutter opens and closes.
    pub(super) cameras: [Camera; 2],
    /// How media come to other times.
    pub(super) animations: &'a [MediumAnimation<'a>],
    /// What media and surfaces fill in the middle, in the order of the file.
    pub(super) media: Vec<Option<Aabb<World>>>,
    /// The same of surfaces.
    pub(super) surfaces: Vec<Option<Aabb<World>>>,
}

impl Moving<'_> {
    /// Into how many parts the shutter is cut, 0 where nothing moves; `context` is told.
    pub(super) fn count(&self, context: &mut Context) -> u32 {
        let shutter = self.file.motion.shutter;
        if !self.is_any() {
            context.warnings.push(format!(
                "[motion] opens a shutter for {shutter} frames, and nothing moves meanwhile: give `next` of the camera, \
                 `motion` of a surface or a medium, or a VDB file with velocities"
            ));
            return 0;
        }
        let pixels = self.pixels();
        let times = self.times(pixels);
        let moved =
            pixels.map_or(String::new(), |p| format!(", in which it moves up to {p:.1} pixels"));
        context.notes.push(format!(
            "motion: the scene at {times} times of a shutter of {shutter} frames{moved}"
        ));
        times
    }

    /// Whether anything moves.
    fn is_any(&self) -> bool {
        let file = self.file;
        file.camera_or_surfaces_move()
            || self.animations.iter().any(|animation| animation.fastest() > 0.0)
            || file.media.iter().any(|medium| medium.motion.is_some())
    }

    /// How far anything moves on the film meanwhile, in pixels; `None` where no camera tells. Corners of boxes stand for
    /// what is in them.
    fn pixels(&self) -> Option<f64> {
        let [open, close] = self.cameras.each_ref().map(|c| c.matrices(self.file.film.size));
        let film = Film { open: open?, close: close?, size: self.file.film.size };
        let MotionSection { open, shutter, .. } = self.file.motion;
        let middle = self.file.motion.middle();
        let mut most = 0.0_f64;
        let mut see = |bounds: &Aabb<World>, moved: &dyn Fn(DVec3, f64) -> DVec3| {
            for corner in bounds.corners() {
                let [from, to] = [open, open + shutter].map(|t| moved(corner.xyz, t - middle));
                most = most.max(film.distance(from, to));
            }
        };
        let displaced = |step: &MotionStep, still: &DAffine3| {
            let (step, still) = (*step, *still);
            move |p, t| step.displacement(&still, middle, middle + t).transform_point3(p)
        };
        let media = self.file.media.iter().zip(self.animations).zip(&self.media);
        for ((section, animation), bounds) in media {
            let Some(bounds) = bounds else { continue };
            let speed = animation.fastest();
            for axis in DVec3::AXES {
                see(bounds, &|p, t| p + axis * (speed * t));
            }
            if let Some(step) = &section.motion {
                see(bounds, &displaced(step, &section.placement));
            }
        }
        for (section, bounds) in self.file.surfaces.iter().zip(&self.surfaces) {
            let Some(bounds) = bounds else { continue };
            match &section.motion {
                Some(step) => see(bounds, &displaced(step, &section.placement)),
                None => see(bounds, &|p, _| p),
            }
        }
        Some(most)
    }

    /// Into how many parts the shutter is cut, where `pixels` is how far anything moves meanwhile.
    fn times(&self, pixels: Option<f64>) -> u32 {
        let [least, most] = TIMES;
        let has_mesh = self.file.surfaces.iter().any(|surface| surface.next_file.is_some());
        // Vertices move one knows not how far.
        let guessed = pixels.filter(|_| !has_mesh).unwrap_or(0.5 * f64::from(most));
        // Samples are spread most evenly over powers of two.
        let wanted = (guessed.clamp(1.0, f64::from(most)).ceil() as u32).next_power_of_two();
        self.file.motion.times.unwrap_or(wanted.clamp(least, most))
    }
}

/// The film when the shutter opens and closes.
struct Film {
    open: CameraMatrices,
    close: CameraMatrices,
    size: [u32; 2],
}

impl Film {
    /// How far what is first at `from` and then at `to` moves on the film, in pixels; 0 where it is not before the camera.
    fn distance(&self, from: DVec3, to: DVec3) -> f64 {
        let places = self.open.place(from, self.size).zip(self.close.place(to, self.size));
        places.map_or(0.0, |(a, b)| a.distance(b))
    }
}
