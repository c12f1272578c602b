//! Progress on a terminal of 40 columns: one line a stage, with the time that is left.

use std::fs::File;
use std::io::Read;
use std::os::fd::OwnedFd;
use std::path::Path;
use std::process::{Command, Stdio};
use std::sync::mpsc;
use std::time::{Duration, Instant};

use rustix::fs::{Mode, OFlags, open};
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use rustix::termios::{Winsize, tcsetwinsize};

use crate::skip;

/// Columns of the terminal.
const COLUMNS: u16 = 40;

/// Long enough for anything here on a busy machine.
const PATIENCE: Duration = Duration::from_secs(120);

/// Both ends of a terminal: what is shown on it, and what is written to it.
fn terminal() -> rustix::io::Result<(OwnedFd, OwnedFd)> {
    let screen = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY)?;
    grantpt(&screen)?;
    unlockpt(&screen)?;
    let size = Winsize { ws_row: 24, ws_col: COLUMNS, ws_xpixel: 0, ws_ypixel: 0 };
    let line = open(&ptsname(&screen, Vec::new())?, OFlags::RDWR | OFlags::NOCTTY, Mode::empty())?;
    tcsetwinsize(&screen, size)?;
    Ok((screen, line))
}

/// The rows of the terminal as they are written, and written over, without the sequences that move the
/// cursor. What is longer than a row goes on in the next one.
fn rows(shown: &str) -> Vec<String> {
    let mut plain = String::new();
    let mut letters = shown.chars().peekable();
    while let Some(letter) = letters.next() {
        if letter != '\x1b' {
            plain.push(letter);
        } else if letters.next_if_eq(&'[').is_some() {
            // A control sequence ends with a letter.
            while letters.next().is_some_and(|c| !c.is_ascii_alphabetic()) {}
        }
    }
    let rows = plain.split(['\r', '\n']).flat_map(|line| {
        let letters: Vec<char> = line.chars().collect();
        letters.chunks(COLUMNS.into()).map(String::from_iter).collect::<Vec<_>>()
    });
    rows.map(|row| row.trim_end().to_owned()).filter(|row| !row.is_empty()).collect()
}

#[test]
fn a_line_of_progress_fits_forty_columns() {
    let Ok((screen, line)) = terminal() else {
        skip::skip("pseudo-terminal");
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("volumes/smoke.toml");
    let mut child = Command::new(assert_cmd::cargo::cargo_bin!("fogbow"))
        .current_dir(folder.path())
        .env("TERM", "xterm")
        .args(["render", scene.to_str().unwrap(), "-o", "a.exr", "--size", "32x24"])
        .args(["--photons", "20000", "--rays", "1000000"])
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::from(line))
        .spawn()
        .unwrap();
    let (sender, pieces) = mpsc::channel();
    std::thread::spawn(move || {
        let mut screen = File::from(screen);
        let mut buffer = [0; 4096];
        // The end of the other end is an error on Linux.
        while let Ok(count @ 1..) = screen.read(&mut buffer) {
            if sender.send(buffer[..count].to_vec()).is_err() {
                break;
            }
        }
    });
    let begin = Instant::now();
    let mut shown = Vec::new();
    let has_eta = |shown: &[u8]| {
        let shown = String::from_utf8_lossy(shown);
        shown.split_once("rays [").is_some_and(|(_, rays)| rays.matches("ETA ").count() > 5)
    };
    while !has_eta(&shown) && begin.elapsed() < PATIENCE {
        match pieces.recv_timeout(Duration::from_millis(100)) {
            Ok(piece) => shown.extend(piece),
            Err(mpsc::RecvTimeoutError::Timeout) => {}
            Err(mpsc::RecvTimeoutError::Disconnected) => break,
        }
    }
    child.kill().unwrap();
    child.wait().unwrap();
    let shown = String::from_utf8_lossy(&shown).into_owned();
    let rows = rows(&shown);
    let told = rows.iter().any(|row| {
        let left = row.split_once("ETA ").map_or("", |(_, left)| left);
        row.contains("rays [") && row.contains(" % ") && left.ends_with(['s', 'm', 'h'])
    });
    assert!(told, "{rows:?}");
    // The last row may have been cut short when the program was ended.
    let (_, whole) = rows.split_last().unwrap();
    let broken = whole.iter().find(|row| !row.contains(" [") || !row.contains(" %"));
    assert_eq!(broken, None, "{rows:?}");
}
