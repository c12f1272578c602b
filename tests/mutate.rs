//! Inputs changed at random, many times over: every reader says what is wrong and lives.
//!
//! `FOGBOW_MUTATIONS=10000 cargo test --release --test mutate -- --ignored --nocapture` tries as many
//! inputs a reader as asked for, from a seed that it prints; where a reader brings the process down,
//! the input is left in `target/tmp/mutated`. In the suite each reader gets five hundred, the same
//! each time. Fuzzing that is led by coverage is in `tests/fuzz`.

#![allow(clippy::print_stdout)]

#[allow(dead_code)]
mod corpus;

use std::fs;
use std::path::{Path, PathBuf};
use std::time::Instant;

use fogbow::image::{PICTURE_DECODER, decode_texture};
use fogbow::scene::file::parse;
use fogbow::scene::{LoadOptions, USD_READER, read_shot};
use fogbow::shape::{MESH_READER, load_mesh};
use fogbow::vdb::{ReadAs, VdbFile};
use glam::DAffine3;
use rand_core::{Rng, SeedableRng};
use rand_xoshiro::SplitMix64;

const OBJ: &str = "mtllib a.mtl\nusemtl m\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nvt 0 0\nvn 0 0 1\n\
    f 1/1/1 2/1/1 3/1/1 4/1/1\nf -1 -2 -3\ng a\ns 1\n";
const PLY: &str = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n\
    property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n\
    0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3\n";

/// A reader under test, with sound inputs.
struct Reader {
    name: &'static str,
    inputs: Vec<Vec<u8>>,
    read: fn(&Path) -> fogbow::Result<()>,
}

fn vdb(path: &Path) -> fogbow::Result<()> {
    let file = VdbFile::open(path)?;
    let read = |index: usize| {
        let vector = file.grids()[index].is_vector();
        if vector {
            file.read_vector(index).map(drop)
        } else {
            file.read_scalar(index, ReadAs::LevelSetAsFog).map(drop)
        }
    };
    (0..file.grids().len()).try_for_each(read)
}

fn mesh(path: &Path) -> fogbow::Result<()> {
    load_mesh(path, &DAffine3::IDENTITY).map(drop)
}

fn texture(path: &Path) -> fogbow::Result<()> {
    decode_texture(&fs::read(path).unwrap(), path).map(drop)
}

fn scene(path: &Path) -> fogbow::Result<()> {
    parse(path, &String::from_utf8_lossy(&fs::read(path).unwrap())).map(drop)
}

fn shot(path: &Path) -> fogbow::Result<()> {
    read_shot(path, &LoadOptions::default()).map(drop)
}

/// Shots as text, as binary files of two writers, and as packages of these.
fn shots() -> [Vec<Vec<u8>>; 3] {
    let text = include_str!("corpus/shot.usda");
    let written = openusd::usda::parse(text).unwrap();
    let mut bytes = std::io::Cursor::new(Vec::new());
    openusd::usdc::CrateWriter::write(&written, &mut bytes).unwrap();
    let binary = vec![bytes.into_inner(), include_bytes!("corpus/blender.usdc").to_vec()];
    let packages = binary.iter().map(|layer| {
        let mut bytes = std::io::Cursor::new(Vec::new());
        let mut archive = openusd::usdz::ArchiveWriter::new(&mut bytes);
        archive.add_layer("shot.usdc", layer).unwrap();
        archive.finish().unwrap();
        bytes.into_inner()
    });
    let packages = packages.collect();
    [vec![text.into()], binary, packages]
}

fn readers() -> [Reader; 8] {
    use exr::prelude::*;
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("a.exr");
    let encodings = [Encoding::SMALL_LOSSLESS, Encoding::FAST_LOSSLESS, Encoding::UNCOMPRESSED];
    let pictures = encodings.map(|encoding| {
        let layer = Layer::new(
            (24, 17),
            LayerAttributes::default(),
            encoding,
            SpecificChannels::rgb(|p: Vec2<usize>| (p.0 as f32, p.1 as f32, 0.5)),
        );
        Image::from_layer(layer).write().to_file(&file).unwrap();
        fs::read(&file).unwrap()
    });
    let shipped = |name: &str| {
        fs::read(Path::new(env!("CARGO_MANIFEST_DIR")).join("volumes").join(name)).unwrap()
    };
    let scenes = ["smoke.toml", "fire.toml", "road.toml", "balls_b.toml", "lucy.toml"].map(shipped);
    let volumes = corpus::odd().into_iter().map(|case| case.bytes);
    let volumes = volumes.filter(|bytes| (16..1 << 16).contains(&bytes.len())); // quick to read
    let [text, binary, packages] = shots();
    let formats = |bytes: Vec<u8>| (222..=226).map(move |version| corpus::format(&bytes, version));
    [
        Reader { name: "a.vdb", inputs: volumes.flat_map(formats).collect(), read: vdb },
        Reader { name: "a.obj", inputs: vec![OBJ.into()], read: mesh },
        Reader { name: "a.ply", inputs: vec![PLY.into()], read: mesh },
        Reader { name: "a.exr", inputs: pictures.into(), read: texture },
        Reader { name: "a.toml", inputs: scenes.into(), read: scene },
        Reader { name: "a.usda", inputs: text, read: shot },
        Reader { name: "a.usdc", inputs: binary, read: shot },
        Reader { name: "a.usdz", inputs: packages, read: shot },
    ]
}

/// One to eight changes of bytes, numbers and pieces.
fn mutated(input: &[u8], random: &mut SplitMix64) -> Vec<u8> {
    let mut bytes = input.to_vec();
    for _ in 0..1 + random.next_u64() % 8 {
        if bytes.is_empty() {
            return bytes;
        }
        let at = (random.next_u64() % bytes.len() as u64) as usize;
        let other = (random.next_u64() % bytes.len() as u64) as usize;
        let length = (random.next_u64() % 64) as usize;
        match random.next_u64() % 8 {
            0 => bytes[at] = random.next_u64() as u8,
            1 => bytes[at] ^= 1 << (random.next_u64() % 8),
            2 => bytes.truncate(at),
            3 => drop(bytes.drain(at..(at + length).min(bytes.len()))),
            4 => {
                let piece = bytes[at..(at + length).min(bytes.len())].to_vec();
                bytes.splice(other..other, piece);
            }
            5 => {
                let number = [0, 1, -1, i64::MAX, i64::MIN, 1 << 31, 1 << 32, 255][length % 8];
                bytes = corpus::with(&bytes, at, &number.to_le_bytes()[..[1, 2, 4, 8][length % 4]]);
            }
            6 => {
                let text = ["nan", "-1", "1e999", "99999999999999999999", "[", "\"", "\n", "/"];
                bytes.splice(at..at, text[length % 8].bytes());
            }
            _ => bytes.swap(at, other),
        }
    }
    bytes
}

/// What became of the inputs of a reader.
#[derive(Debug)]
struct Outcome {
    reader: &'static str,
    refused: u64,
    seconds: f64,
}

/// Puts what scenes name beside them, so that more than its absence is found.
fn lay_out(folder: &Path) {
    fs::create_dir_all(folder).unwrap();
    let volumes = Path::new(env!("CARGO_MANIFEST_DIR")).join("volumes");
    for entry in fs::read_dir(volumes).unwrap().map(Result::unwrap) {
        let link = folder.join(entry.file_name());
        if fs::symlink_metadata(&link).is_err() {
            std::os::unix::fs::symlink(entry.path(), link).unwrap();
        }
    }
}

/// Gives every reader `count` inputs.
fn run(count: u64, seed: u64, keep: &Path) -> Vec<Outcome> {
    lay_out(keep);
    let mut random = SplitMix64::seed_from_u64(seed);
    let mut outcomes = Vec::new();
    for reader in readers() {
        let path: PathBuf = keep.join(format!("mutated_{}", reader.name));
        let start = Instant::now();
        let mut refused = 0;
        for _ in 0..count {
            let input = (random.next_u64() % reader.inputs.len() as u64) as usize;
            fs::write(&path, mutated(&reader.inputs[input], &mut random)).unwrap();
            if let Err(error) = (reader.read)(&path) {
                let message = error.to_string();
                assert!(!message.chars().any(char::is_control), "{message:?}");
                assert!(message.contains(reader.name), "{message}");
                refused += 1;
            }
        }
        fs::remove_file(path).unwrap();
        let seconds = start.elapsed().as_secs_f64();
        outcomes.push(Outcome { reader: reader.name, refused, seconds });
    }
    outcomes
}

/// Keeps panics of crates that become errors off the output.
fn hush() {
    let print = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |info| {
        if !matches!(
            std::thread::current().name(),
            Some(PICTURE_DECODER | MESH_READER | USD_READER)
        ) {
            print(info);
        }
    }));
}

/// Changes break something or do not, and each reader sees both: one that takes everything or
/// nothing is found.
#[test]
fn changed_inputs_are_read_or_refused() {
    const COUNT: u64 = 500;
    hush();
    let folder = tempfile::tempdir().unwrap();
    for Outcome { reader, refused, .. } in run(COUNT, 1, folder.path()) {
        let read = COUNT - refused;
        assert!(refused >= COUNT / 10 && read > 1, "{reader}: {refused} refused, {read} read");
    }
}

/// What is changed was sound before, so that a refusal is for the change; but for the volumes, which
/// are odd ones.
#[test]
fn unchanged_inputs_are_read() {
    let folder = tempfile::tempdir().unwrap();
    lay_out(folder.path());
    for Reader { name, inputs, read } in readers().into_iter().filter(|r| r.name != "a.vdb") {
        let path = folder.path().join(name);
        for (number, input) in inputs.iter().enumerate() {
            fs::write(&path, input).unwrap();
            let told = read(&path);
            assert!(told.is_ok(), "{name}, input {number}: {}", told.unwrap_err());
        }
    }
}

#[test]
#[ignore = "as many as FOGBOW_MUTATIONS says"]
fn changed_inputs_for_long() {
    hush();
    let number = |name: &str| std::env::var(name).ok().and_then(|text| text.parse::<u64>().ok());
    let count = number("FOGBOW_MUTATIONS").unwrap_or(10_000);
    let seed = number("FOGBOW_SEED").unwrap_or(2);
    println!("seed {seed}, {count} inputs a reader");
    let keep = Path::new(env!("CARGO_TARGET_TMPDIR")).join("mutated");
    for Outcome { reader, refused, seconds } in run(count, seed, &keep) {
        println!("{reader}: {refused} refused, {} read, {seconds:.0} s", count - refused);
    }
}
