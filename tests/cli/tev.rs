//! `--tev`: the packets that are sent, beside those of tev's own Python client, and a viewer that is not there.

use std::io::Read;
use std::net::TcpListener;
use std::path::Path;
use std::process::Command;
use std::thread::JoinHandle;

use fogbow::image::{Layers, read_layers};

use crate::{run, skip};

/// Sends the layers of a picture as the client does that belongs to tev. Arguments: port, name, width, height, a file
/// of the values of all channels pixel by pixel, and the channels.
const CLIENT: &str = "
import sys, numpy, tevclient
port, name, width, height, file, *channels = sys.argv[1:]
image = numpy.fromfile(file, dtype='<f4').reshape(int(height), int(width), len(channels))
with tevclient.Ipc('127.0.0.1', int(port)) as tev:
    tev.create_image(name, int(width), int(height), channels)
    tev.update_image(name, image, channels)
";

const CREATE_IMAGE: u8 = 4;
const UPDATE_IMAGE: u8 = 6;

/// Takes what a single client sends. Returns its port and the packets, once the client is gone.
fn record() -> (u16, JoinHandle<Vec<Vec<u8>>>) {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let port = listener.local_addr().unwrap().port();
    let packets = std::thread::spawn(move || {
        let mut bytes = Vec::new();
        listener.accept().unwrap().0.read_to_end(&mut bytes).unwrap();
        packets(&bytes)
    });
    (port, packets)
}

/// Each begins with the number of its bytes.
fn packets(mut bytes: &[u8]) -> Vec<Vec<u8>> {
    let mut packets = Vec::new();
    while let Some(length) = bytes.first_chunk() {
        let (packet, rest) = bytes.split_at(u32::from_le_bytes(*length) as usize);
        packets.push(packet.to_vec());
        bytes = rest;
    }
    packets
}

fn kinds(packets: &[Vec<u8>]) -> Vec<u8> {
    packets.iter().map(|packet| packet[4]).collect()
}

/// Renders a picture of four tiles. Returns its layers and the packets.
fn sent(folder: &Path, more: &[&str]) -> (Layers, Vec<Vec<u8>>) {
    let (port, packets) = record();
    let scene = format!("{}/volumes/smoke.toml", env!("CARGO_MANIFEST_DIR"));
    let address = format!("127.0.0.1:{port}");
    let args = ["render", &scene, "-o", "out.exr", "--size", "150x130", "--rays", "2"];
    let flags = ["--photons", "2000", "--quiet", "--tev", &address];
    let (code, _, told) = run(folder, &[&args[..], &flags, more].concat());
    assert_eq!((code, told.as_str()), (0, ""));
    (read_layers(&folder.join("out.exr")).unwrap(), packets.join().unwrap())
}

/// The channels in the order in which they are sent.
const CHANNELS: [&str; 12] = [
    "R",
    "G",
    "B",
    "A",
    "Z",
    "transmittance",
    "saliency",
    "xs",
    "rays",
    "radius",
    "step",
    "variance",
];

/// The values of all channels, pixel by pixel.
fn values(layers: &Layers) -> Vec<u8> {
    let layers = CHANNELS.map(|name| layers.get(name).unwrap());
    let pixels = (0..layers[0].len()).flat_map(|pixel| layers.map(|layer| layer[pixel]));
    pixels.flat_map(f32::to_le_bytes).collect()
}

#[test]
fn the_last_picture_that_tev_gets_is_the_one_on_disk() {
    let folder = tempfile::tempdir().unwrap();
    for more in [&[][..], &["--reconstruct"]] {
        let (layers, packets) = sent(folder.path(), more);
        let kinds = kinds(&packets);
        assert_eq!((kinds[0], kinds.len() % 4), (CREATE_IMAGE, 1), "four tiles of each picture");
        assert!(kinds[1..].iter().all(|kind| *kind == UPDATE_IMAGE), "{kinds:?}");
        assert!(kinds.len() >= 9, "a first look and the picture");
        // The last tile is the lower right corner, 22 pixels wide and 2 high.
        let corner = values(&layers);
        let row =
            |y: usize| (y * 150 + 128) * 4 * CHANNELS.len()..(y + 1) * 150 * 4 * CHANNELS.len();
        let corner = [&corner[row(128)], &corner[row(129)]].concat();
        assert!(packets.last().unwrap().ends_with(&corner));
    }
}

#[test]
fn packets_are_those_of_tevs_own_client() {
    let found = Command::new("python3").args(["-c", "import tevclient"]).output();
    if !found.is_ok_and(|output| output.status.success()) {
        skip::skip("tevclient; pip install tevclient");
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let (layers, ours) = sent(folder.path(), &[]);
    let file = folder.path().join("values");
    std::fs::write(&file, values(&layers)).unwrap();
    let (port, theirs) = record();
    let told = Command::new("python3")
        .args(["-c", CLIENT, &port.to_string(), "out.exr", "150", "130"])
        .arg(&file)
        .args(CHANNELS)
        .output()
        .unwrap();
    assert!(told.status.success(), "{}", String::from_utf8_lossy(&told.stderr));
    let theirs = theirs.join().unwrap();
    assert_eq!(
        kinds(&theirs),
        [CREATE_IMAGE, UPDATE_IMAGE, UPDATE_IMAGE, UPDATE_IMAGE, UPDATE_IMAGE]
    );
    assert!(ours[0] == theirs[0], "{:?} {:?}", ours[0], theirs[0]);
    for (ours, theirs) in ours[ours.len() - 4..].iter().zip(&theirs[1..]) {
        assert!(ours == theirs, "another tile");
    }
}

#[test]
fn without_tev_the_picture_is_rendered_and_one_line_says_so() {
    let folder = tempfile::tempdir().unwrap();
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = listener.local_addr().unwrap().to_string();
    drop(listener);
    let scene = format!("{}/volumes/smoke.toml", env!("CARGO_MANIFEST_DIR"));
    let args = ["render", &scene, "-o", "out.exr", "--size", "24x16", "--rays", "2"];
    let flags = ["--photons", "2000", "--quiet", "--tev", &address];
    let (code, _, told) = run(folder.path(), &[&args[..], &flags].concat());
    assert_eq!((code, told.lines().count()), (0, 1), "{told}");
    assert!(told.starts_with(&format!("warning: tev at {address} cannot be reached")), "{told}");
    assert!(folder.path().join("out.exr").exists());
    let (code, _, told) = run(folder.path(), &["render", &scene, "-o", "a.exr", "--tev", "here"]);
    assert!(code == 2 && told.contains("host and port, as localhost:14158"), "{told}");
}
