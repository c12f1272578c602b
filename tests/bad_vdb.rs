//! Damaged, hostile and unusable OpenVDB files: each becomes a picture or one clear message.
//!
//! `cargo bench --bench results -- --only bad-files` runs all of them and makes a page of what became of
//! them; without `--ignored` a part of them is run.

#![allow(clippy::print_stdout, clippy::print_stderr)]

mod corpus;

use std::collections::BTreeMap;
use std::ffi::OsString;
use std::fs;
use std::io::Read;
use std::path::Path;
use std::process::{Command, Stdio};
use std::sync::mpsc;
use std::time::{Duration, Instant};

use corpus::Case;
use fogbow::vdb::{ReadAs, VdbFile};
use rustix::process::{Pid, Signal, kill_process};

/// Address space that a run may take, in KiB: an absurd allocation fails there.
const ADDRESS_SPACE: u64 = 4 << 20;
/// A run that takes longer hangs.
const PATIENCE: Duration = Duration::from_secs(30);

/// How a run of the program on one file ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum End {
    Refused,
    Rendered,
    /// Neither a picture nor one line that names the file.
    Unclear,
    Crashed,
    Hung,
}

/// The program, or another that `FOGBOW` names.
fn program() -> OsString {
    std::env::var_os("FOGBOW").unwrap_or_else(|| assert_cmd::cargo::cargo_bin!("fogbow").into())
}

struct Run {
    end: End,
    stderr: String,
    /// Largest resident size in bytes.
    peak: u64,
}

/// Renders `file` with a small budget, in a process of its own with bounded memory and time.
fn render(file: &Path) -> Run {
    let folder = tempfile::tempdir().unwrap();
    let output = folder.path().join("a.exr");
    let limited = format!("ulimit -c 0; ulimit -v {ADDRESS_SPACE}; exec \"$@\"");
    let mut child = Command::new("sh")
        .args(["-c", &limited, "sh"])
        .arg(program())
        .args(["render".as_ref(), file.as_os_str(), "-o".as_ref(), output.as_os_str()])
        .args(["--size", "8x8", "--rays", "1", "--photons", "500", "--threads", "1", "--quiet"])
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut pipe = child.stderr.take().unwrap();
    let stderr = std::thread::spawn(move || {
        let mut text = Vec::new();
        pipe.read_to_end(&mut text).unwrap();
        String::from_utf8_lossy(&text).into_owned()
    });
    let pid = Pid::from_child(&child);
    let (done, waiting) = mpsc::channel::<()>();
    let watch = std::thread::spawn(move || watch(pid, &waiting));
    let status = child.wait().unwrap();
    drop(done);
    let (peak, hung) = watch.join().unwrap();
    let stderr = stderr.join().unwrap();
    let name = file.to_str().unwrap();
    let clear = stderr.lines().count() == 1
        && stderr.starts_with("error: ")
        && stderr.contains(name)
        && fs::read_dir(folder.path()).unwrap().next().is_none();
    let warned = stderr.lines().all(|line| line.starts_with("warning: "));
    let end = match status.code() {
        _ if hung => End::Hung,
        Some(0) if output.is_file() && warned => End::Rendered,
        Some(1) if clear => End::Refused,
        Some(0..=2) => End::Unclear,
        _ => End::Crashed,
    };
    Run { end, stderr, peak }
}

/// The largest resident size of a process until `done` is dropped, and whether it took too long. The
/// kernel's figure for an ended child would count its parent's size before the exec as well.
fn watch(pid: Pid, done: &mpsc::Receiver<()>) -> (u64, bool) {
    let start = Instant::now();
    let mut peak = 0;
    let mut killed = false;
    while done.recv_timeout(Duration::from_millis(1)) == Err(mpsc::RecvTimeoutError::Timeout) {
        let status = fs::read_to_string(format!("/proc/{}/status", pid.as_raw_nonzero()))
            .unwrap_or_default();
        let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
        let kib = line.and_then(|l| l.trim().strip_suffix(" kB")?.parse::<u64>().ok());
        peak = peak.max(kib.unwrap_or(0) << 10);
        if !killed && start.elapsed() > PATIENCE {
            killed = kill_process(pid, Signal::KILL).is_ok();
        }
    }
    (peak, killed)
}

/// What became of one case.
struct Outcome {
    name: String,
    size: usize,
    run: Run,
}

fn run_all(cases: Vec<Case>) -> Vec<Outcome> {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("bad.vdb");
    cases
        .into_iter()
        .map(|case| {
            fs::write(&file, &case.bytes).unwrap();
            let run = render(&file);
            if run.end > End::Rendered || std::env::var_os("FOGBOW_ALL").is_some() {
                println!("{:?}: {}: {}", run.end, case.name, run.stderr.trim());
            }
            Outcome { run, size: case.bytes.len(), name: case.name }
        })
        .collect()
}

/// What the library says of a file when all its grids are read; nothing where all could be.
fn problems(file: &Path) -> Vec<String> {
    let opened = match VdbFile::open(file) {
        Ok(opened) => opened,
        Err(e) => return vec![e.to_string()],
    };
    let read = |index: usize| {
        let vector = opened.grids()[index].is_vector();
        if vector {
            opened.read_vector(index).map(drop)
        } else {
            opened.read_scalar(index, ReadAs::LevelSetAsFog).map(drop)
        }
    };
    (0..opened.grids().len()).filter_map(|i| read(i).err()).map(|e| e.to_string()).collect()
}

#[test]
fn nothing_brings_the_reader_down() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("bad.vdb");
    let start = format!("{}: ", file.display());
    let mut refused = 0;
    for case in corpus::cases(true) {
        fs::write(&file, &case.bytes).unwrap();
        let problems = problems(&file);
        refused += usize::from(!problems.is_empty());
        for problem in problems {
            let one_line = !problem.chars().any(char::is_control);
            assert!(problem.starts_with(&start) && one_line, "{}: {problem}", case.name);
        }
    }
    assert!(refused > 300, "only {refused} files were refused");
}

#[test]
fn every_odd_file_is_a_picture_or_one_line() {
    let wrong: Vec<_> = run_all(corpus::odd())
        .into_iter()
        .filter(|outcome| outcome.run.end > End::Rendered)
        .map(|outcome| format!("{:?}: {}: {}", outcome.run.end, outcome.name, outcome.run.stderr))
        .collect();
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn what_is_no_regular_file_is_refused_at_once() {
    let folder = tempfile::tempdir().unwrap();
    let pipe = folder.path().join("pipe.vdb");
    assert!(Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    let link = folder.path().join("link.vdb");
    std::os::unix::fs::symlink(&link, &link).unwrap();
    let rows = [
        (pipe.as_path(), "is a pipe or a device"),
        (folder.path(), "is a folder"),
        (Path::new("/dev/zero"), "is a pipe or a device"),
        (&link, "cannot be read"),
        (&folder.path().join("gone.vdb"), "cannot be read: No such file"),
    ];
    for (file, says) in rows {
        let run = render(file);
        assert_eq!(run.end, End::Refused, "{}: {}", file.display(), run.stderr);
        assert!(run.stderr.contains(says), "{}", run.stderr);
        assert!(VdbFile::open(file).unwrap_err().to_string().contains(says), "{says}");
    }
}

#[test]
#[ignore = "writes the corpus to the folder that FOGBOW_SEEDS names, for fuzzing"]
fn seeds() {
    let folder = std::env::var_os("FOGBOW_SEEDS").expect("FOGBOW_SEEDS names a folder");
    for (number, case) in corpus::cases(true).into_iter().enumerate() {
        fs::write(Path::new(&folder).join(number.to_string()), case.bytes).unwrap();
    }
}

#[test]
#[ignore = "all of the corpus, minutes; it prints an object for the page of results"]
fn table() {
    let small = std::env::var_os("FOGBOW_QUICK").is_some();
    let outcomes = run_all(corpus::cases(small));
    let mut counts = BTreeMap::<End, usize>::new();
    for outcome in &outcomes {
        *counts.entry(outcome.run.end).or_default() += 1;
    }
    let sound = outcomes.iter().find(|o| o.name == "sound").unwrap().run.peak;
    let over = |o: &Outcome| o.run.peak.saturating_sub(sound) as f64 / o.size.max(1 << 16) as f64;
    let ratio = |end: End| {
        let ratios = outcomes.iter().filter(|o| o.run.end == end).map(over);
        ratios.fold(0.0, f64::max)
    };
    let count = |end| counts.get(&end).copied().unwrap_or(0);
    let told = serde_json::json!({
        "tried": outcomes.len(),
        "refused": count(End::Refused),
        "rendered": count(End::Rendered),
        "unclear": count(End::Unclear),
        "crashed": count(End::Crashed),
        "hung": count(End::Hung),
        "memory_refused": ratio(End::Refused),
        "memory_rendered": ratio(End::Rendered),
        "sound_mib": sound as f64 / f64::from(1 << 20),
    });
    println!("{told}");
    assert_eq!(count(End::Refused) + count(End::Rendered), outcomes.len());
}
