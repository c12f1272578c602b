//! `fogbow render`.

use std::time::Duration;

use super::console;
use super::first_look;
use super::interrupt::Interrupt;
use super::live::Live;
use super::load;
use super::memory_limit;
use super::output::Output;
use super::picture::PictureJob;
use super::render_args::{
    Args, advice, early_denoiser, find_denoiser, note, plan, print_report, write_scene,
};
use super::save_photons;
use super::sequence;
use crate::error::Result;
use crate::render::{Clock, Earlier};
use crate::scene::OpenScene;

/// Renders and writes the pictures, and shows them meanwhile.
pub(super) fn run(args: &Args) -> Result<()> {
    if let Some(path) = &args.photons.photons_to {
        return save_photons::run(args, path);
    }
    let live = Live::open(&args.live, args.output()?)?;
    let result = match &args.frames.frames {
        Some(frames) => sequence::run(args, frames, &live),
        None => render(args, &live),
    };
    live.close(&result);
    result
}

/// Renders and writes one picture.
fn render(args: &Args, live: &Live) -> Result<()> {
    let (clock, program) = (Clock::start(), memory_limit::program());
    let mut denoiser = early_denoiser(args)?;
    let output = Output::check(args.output()?)?;
    let interrupt = Interrupt::listen()?;
    let (mut scene, pool, preparation) =
        load::scene(&mut OpenScene::of_file(&args.paths.scene), args.options(), &args.run)?;
    args.limits.set_part(&mut scene, args.reference)?;
    let photons = args.photons.open(&mut scene)?;
    if find_denoiser(&mut denoiser, &scene)? {
        denoiser
            .iter()
            .filter(|_| !args.run.quiet)
            .for_each(|found| console::message(&note(found)));
    }
    let mut job = PictureJob {
        output: &output,
        limits: &args.limits,
        interrupt: &interrupt,
        live,
        method: args.method(),
        quiet: args.run.quiet,
        clock: &clock,
        start: Duration::ZERO,
        preparation,
        program,
        denoiser: denoiser.as_ref(),
    };
    pool.install(|| first_look::show(&scene, &job));
    job.preparation.metering = load::meter(&mut scene, &pool)?;
    write_scene(args, &scene)?;
    let plan = plan(args, &scene);
    plan.iter().for_each(|line| console::message(line));
    let advice = advice(args, &scene);
    console::warn(&advice);
    let warnings = [scene.warnings.clone(), advice].concat();
    let earlier = Earlier { photons: photons.as_ref(), ..Earlier::default() };
    let picture = job.run(&mut scene, &pool, warnings, earlier)?;
    print_report(args, &picture);
    picture.end(&interrupt)
}
