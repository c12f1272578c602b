//! What README and guide tell a user to type does what they say.
//!
//! Each `sh` block runs, page by page, in a folder of its own that holds what ships and a few files with
//! the names that the pages use. `fogbow` is there a script that makes pictures small and short, and
//! leaves everything else alone. A block behind `<!-- checked by FILE -->` is run by that file instead.

use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::Path;
use std::process::Command;

use fogbow::scene::{LoadOptions, Scene};
use tempfile::TempDir;

use crate::documents::documents;

const ROOT: &str = env!("CARGO_MANIFEST_DIR");

/// `fogbow` with pictures of few pixels, rays and photons, and seconds instead of minutes.
const SMALL: &str = r#"#!/bin/sh
case $1 in
  render | maps | study | trial | plan) ;;
  *) exec "$FOGBOW" "$@" ;;
esac
sized=
left=$#
while [ "$left" -gt 0 ]; do
  word=$1
  shift
  left=$((left - 1))
  value=
  case $word in
    --size) value=24x16 sized=yes ;;
    --rays) value=2 ;;
    --photons) value=2000 ;;
    --time) value=3s ;;
    --error) case $1 in 0*) value=0.5 ;; esac ;;
    --seeds) value=2 ;;
    --crop | --photons-to) sized=yes ;;
    --reference) case $1 in [0-9]*) value=4 ;; esac ;;
  esac
  set -- "$@" "$word"
  if [ -n "$value" ]; then
    shift
    left=$((left - 1))
    set -- "$@" "$value"
  fi
done
[ -n "$sized" ] || set -- "$@" --size 24x16
case " $* " in *" --rays "*) ;; *) set -- "$@" --rays 2 ;; esac
case " $* " in *" --photons "*) ;; *) set -- "$@" --photons 2000 ;; esac
exec "$FOGBOW" "$@"
"#;

/// A fenced block of a page.
struct Block {
    language: String,
    text: String,
    /// What the comment before it says.
    comment: Option<String>,
}

fn blocks(text: &str) -> Vec<Block> {
    let mut blocks = Vec::new();
    let mut lines = text.lines();
    let mut comment = None;
    while let Some(line) = lines.next() {
        if let Some(said) = line.strip_prefix("<!-- ").and_then(|l| l.strip_suffix(" -->")) {
            comment = Some(said.to_owned());
        } else if let Some(language) = line.strip_prefix("```") {
            let text: Vec<&str> = lines.by_ref().take_while(|line| *line != "```").collect();
            let (language, text) = (language.to_owned(), text.join("\n"));
            blocks.push(Block { language, text, comment: comment.take() });
        } else if !line.is_empty() {
            comment = None;
        }
    }
    blocks
}

/// A page without its blocks.
fn prose(text: &str) -> String {
    text.split("```").step_by(2).collect()
}

/// A folder with the files that the pages name.
fn folder() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    let volumes = Path::new(ROOT).join("volumes");
    let put = |from: &str, to: &str| {
        fs::copy(volumes.join(from), folder.path().join(to)).unwrap();
    };
    for name in ["smoke.vdb", "fire.vdb", "cloud.vdb"] {
        put(name, name);
    }
    for frame in 1..=3 {
        put("smoke.vdb", &format!("smoke_{frame:04}.vdb"));
    }
    put("smoke.toml", "smoke.toml");
    let guide = fs::read_to_string(Path::new(ROOT).join("src/guide/scene.md")).unwrap();
    let scene = blocks(&guide).into_iter().find(|block| block.comment.as_deref() == Some("scene"));
    let scene = scene.expect("scene.md shows one").text;
    fs::write(folder.path().join("scene.toml"), &scene).unwrap();
    let frames = scene.replace("smoke.vdb", "smoke_####.vdb");
    fs::write(folder.path().join("frames.toml"), frames).unwrap();

    let program = folder.path().join("bin/fogbow");
    fs::create_dir(program.parent().unwrap()).unwrap();
    fs::write(&program, SMALL).unwrap();
    fs::set_permissions(&program, fs::Permissions::from_mode(0o755)).unwrap();
    folder
}

#[test]
fn the_commands_of_every_page_run() {
    let mut ran = 0;
    for page in documents() {
        let text = fs::read_to_string(&page).unwrap();
        let folder = folder();
        let path = std::env::var("PATH").unwrap();
        for block in blocks(&text).iter().filter(|block| block.language == "sh") {
            match block.comment.as_deref() {
                Some("render" | "test") => continue, // .ci/run and tests/check/bare.sh run these
                Some(said) => {
                    assert_checked(&page, said, &block.text);
                    continue;
                }
                None => {}
            }
            let output = Command::new("sh")
                .args(["-e", "-c", &block.text])
                .current_dir(folder.path())
                .env("PATH", format!("{}:{path}", folder.path().join("bin").display()))
                .env("FOGBOW", assert_cmd::cargo::cargo_bin!("fogbow"))
                .output()
                .unwrap();
            let told = String::from_utf8_lossy(&output.stderr);
            assert!(output.status.success(), "{}:\n{}\n{told}", page.display(), block.text);
            ran += 1;
        }
    }
    assert!(ran > 10, "only {ran} blocks were found");
}

/// That the file which is said to check a block names what the block runs last.
fn assert_checked(page: &Path, said: &str, block: &str) {
    let file = said.strip_prefix("checked by ").unwrap_or_else(|| panic!("{page:?}: {said}"));
    let check =
        fs::read_to_string(Path::new(ROOT).join(file)).unwrap_or_else(|e| panic!("{file}: {e}"));
    let last = block.lines().last().unwrap();
    let words: Vec<&str> = last.split_whitespace().filter(|word| !word.contains('.')).collect();
    for word in words {
        assert!(
            check.contains(word),
            "{file} does not run `{last}` of {}: no {word}",
            page.display()
        );
    }
}

#[test]
fn the_scenes_of_the_guide_are_read() {
    let camera = "[camera]\nposition = [0.0, 1.0, 8.0]\ntarget = [0.0, 1.0, 0.0]\n\n";
    let text = fs::read_to_string(Path::new(ROOT).join("src/guide/scene.md")).unwrap();
    let scenes: Vec<Block> =
        blocks(&text).into_iter().filter(|block| block.language == "toml").collect();
    assert!(scenes.len() > 3);
    let folder = folder();
    for scene in scenes {
        let whole = scene.text.contains("[camera]");
        let text = format!("{}{}", if whole { "" } else { camera }, scene.text);
        let path = folder.path().join("block.toml");
        fs::write(&path, &text).unwrap();
        let loaded = Scene::load(&path, &LoadOptions::default());
        assert!(loaded.is_ok(), "{text}\n{}", loaded.err().unwrap());
    }
}

/// Flags and subcommands that pages name in passing are there.
#[test]
fn what_pages_name_in_passing_is_there() {
    let help = |words: &[&str]| {
        let output = Command::new(assert_cmd::cargo::cargo_bin!("fogbow")).args(words).output();
        String::from_utf8(output.unwrap().stdout).unwrap()
    };
    let top = help(&["--help"]);
    let names = top.lines().skip_while(|line| *line != "Commands:").skip(1);
    let names = names.take_while(|line| !line.is_empty());
    let names: Vec<&str> = names.filter_map(|l| l.split_whitespace().next()).collect();
    assert!(names.contains(&"render"), "{top}");
    let helps: Vec<(&str, String)> =
        names.into_iter().map(|name| (name, help(&[name, "--help"]))).collect();
    for page in documents() {
        let text = fs::read_to_string(&page).unwrap();
        for code in prose(&text).split('`').skip(1).step_by(2) {
            let mut words = code.split_whitespace().peekable();
            let within = if words.peek() == Some(&"fogbow") {
                words.next();
                words.peek().copied()
            } else {
                None
            };
            let flags: Vec<&str> = words
                .clone()
                .filter(|word| word.starts_with("--") && word.len() > 2)
                .map(|word| word.split(['=', ',']).next().unwrap())
                .collect();
            if code.starts_with("cargo") {
                continue;
            }
            let fits = |(name, help): &(&str, String)| {
                within.is_none_or(|within| within == *name)
                    && flags.iter().all(|flag| help.contains(flag))
            };
            let named = within.is_some() || !flags.is_empty();
            assert!(!named || helps.iter().any(fits), "{}: `{code}` is not known", page.display());
        }
    }
}

/// Links of the pages lead somewhere.
#[test]
fn links_lead_to_files() {
    for page in documents() {
        let text = fs::read_to_string(&page).unwrap();
        for link in text.split("](").skip(1) {
            let target = link.split([')', '#']).next().unwrap();
            let local = !target.is_empty() && !target.contains("://");
            let path = page.parent().unwrap().join(target);
            assert!(!local || path.exists(), "{}: {target} is not there", page.display());
        }
    }
}
