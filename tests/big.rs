//! What a render takes in memory, beside what `fogbow plan` foretold, up to 200 million voxels.
//!
//! `cargo test --release --test big -- --ignored --nocapture` takes minutes, 4 GiB of memory and 1 GiB
//! of disk.

#![allow(clippy::print_stdout)]

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use fogbow::vdb::{Block, GridToWrite, write};
use glam::{DVec3, IVec3};
use serde_json::Value;

/// Active voxels of the big volume, about.
const VOXELS: f64 = 2e8;
/// What the big render may take.
const MOST: f64 = 24.0 * 1024.0 * 1024.0 * 1024.0;
/// What `fogbow plan` may be off by.
const OFF: f64 = 0.2;

/// The program, or another that `FOGBOW` names.
fn program() -> OsString {
    std::env::var_os("FOGBOW").unwrap_or_else(|| assert_cmd::cargo::cargo_bin!("fogbow").into())
}

fn fogbow(arguments: &[&str], scene: &Path, more: &[&str]) -> Output {
    Command::new(program()).args(arguments).arg(scene).args(more).output().unwrap()
}

fn json(output: &Output) -> Value {
    let message = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{message}");
    serde_json::from_slice(&output.stdout).unwrap()
}

/// A ball of cells of thin and thick fog, 2 m wide, with about `voxels` active voxels.
fn make(path: &Path, voxels: f64) {
    let radius = (voxels * 0.75 / std::f64::consts::PI).cbrt();
    let reach = (radius / 8.0).ceil() as i32;
    let mut grid = GridToWrite::fog("density", 1.0 / radius, DVec3::ZERO);
    grid.half = true;
    let value = |v: IVec3| {
        let p = v.as_dvec3();
        let cells = (p * 0.07).map(f64::sin).element_product();
        if p.length() < radius { (1.0 + 0.9 * cells) as f32 } else { 0.0 }
    };
    for corner in 0..(2 * reach).pow(3) {
        let side = 2 * reach;
        let origin =
            8 * (IVec3::new(corner / side / side, corner / side % side, corner % side) - reach);
        let values: Vec<f32> =
            (0..512).map(|i| value(origin + IVec3::new(i >> 6, i >> 3 & 7, i & 7))).collect();
        if values.iter().any(|value| *value != 0.0) {
            grid.blocks.push(Block { origin, values, active: None });
        }
    }
    write(path, &[grid]).unwrap();
}

/// Memory that `plan` foretells and that a render then takes, in bytes.
fn foretold_and_taken(folder: &Path, scene: &Path, settings: &[&str]) -> [f64; 2] {
    let plan = json(&fogbow(&["plan"], scene, &[settings, &["--json"]].concat()));
    let output = folder.join("out.exr");
    let more = [settings, &["--json", "--quiet", "-o", output.to_str().unwrap()]].concat();
    let report = json(&fogbow(&["render"], scene, &more));
    println!("seconds: {}", report["seconds"]);
    [&plan["memory"]["peak"], &report["peak_memory"]].map(|bytes| bytes.as_f64().unwrap())
}

fn volume(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(name)
}

#[test]
#[ignore = "200 million voxels: minutes, 4 GiB of memory, 1 GiB of disk"]
fn memory_is_as_foretold() {
    let folder = tempfile::tempdir().unwrap();
    let big = folder.path().join("big.vdb");
    make(&big, VOXELS);
    println!("| scene | foretold, MiB | taken, MiB | foretold over taken |");
    println!("| --- | --- | --- | --- |");
    let small = ["--size", "128x128", "--rays", "4"];
    let mut wrong = 0;
    for (scene, photons) in [
        (volume("volumes/smoke.toml"), "2000000"),
        (volume("volumes/cloud.toml"), "500000"),
        (volume("../shared/volumes/cloud/singlecloud.vdb"), "1000000"),
        (big, "10000000"),
    ] {
        if !scene.exists() {
            println!("{}: not there, left out", scene.display());
            continue;
        }
        let settings = [&small[..], &["--photons", photons]].concat();
        let [foretold, taken] = foretold_and_taken(folder.path(), &scene, &settings);
        let name = scene.file_name().unwrap().to_string_lossy();
        let [a, b] = [foretold, taken].map(|bytes| bytes / f64::from(1 << 20));
        println!("| {name}, {photons} photons | {a:.0} | {b:.0} | {:.2} |", foretold / taken);
        wrong += usize::from(taken > MOST || (foretold / taken - 1.0).abs() > OFF);
    }
    assert_eq!(wrong, 0);
}

/// Allowed less memory than it takes, a render has fewer photons or is refused with figures, by
/// `--memory` as by a limit of the system.
#[test]
#[ignore = "200 million voxels: minutes, 4 GiB of memory, 1 GiB of disk"]
fn limits_are_kept() {
    let folder = tempfile::tempdir().unwrap();
    let big = folder.path().join("big.vdb");
    make(&big, VOXELS);
    let output = folder.path().join("limited.exr");
    let small = ["--size", "64x64", "--rays", "1", "--json", "--quiet"];
    let end = ["-o", output.to_str().unwrap()];
    for (scene, photons, memory) in [
        (big.clone(), "100000", 6e9),
        (big, "100000", 4e9),
        (volume("volumes/cloud.toml"), "4000000", 5e8),
    ] {
        let bytes = format!("{memory}");
        let settings = [&small[..], &["--photons", photons], &end].concat();
        let asked = fogbow(&["render"], &scene, &[&settings[..], &["--memory", &bytes]].concat());
        let limited = Command::new("prlimit")
            .arg(format!("--as={bytes}"))
            .arg(program())
            .arg("render")
            .arg(&scene)
            .args(&settings)
            .output();
        for (how, run) in [("--memory", Some(asked)), ("prlimit --as", limited.ok())] {
            let Some(run) = run else { continue };
            let message = String::from_utf8_lossy(&run.stderr);
            let name = scene.file_name().unwrap().to_string_lossy();
            println!("{name}, {photons} photons, {how} {bytes}: {} {}", run.status, message.trim());
            match run.status.code() {
                Some(0) => {
                    let taken = json(&run)["peak_memory"].as_f64().unwrap();
                    println!("  {:.0} MiB taken", taken / f64::from(1 << 20));
                    assert!(taken <= memory, "{taken} bytes");
                }
                code => {
                    assert_eq!(code, Some(1), "{message}");
                    assert!(message.contains("of memory") && message.contains("iB"), "{message}");
                }
            }
        }
    }
}
