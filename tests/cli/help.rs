//! Help, manual pages and completions, as a shell and a reader get them.

use std::path::Path;
use std::process::Output;

use assert_cmd::Command;

/// The commands, in the order of the help.
const COMMANDS: [&str; 14] = [
    "render",
    "maps",
    "error",
    "study",
    "trial",
    "plan",
    "info",
    "export",
    "merge",
    "make",
    "verify",
    "completions",
    "man",
    "help",
];

fn fogbow(folder: &Path, args: &[&str]) -> Output {
    let program = assert_cmd::cargo::cargo_bin!("fogbow");
    Command::new(program).current_dir(folder).args(args).output().unwrap()
}

/// What is printed to stdout, with exit code 0.
fn told(args: &[&str]) -> String {
    let output = fogbow(Path::new("."), args);
    assert!(output.status.success(), "{args:?}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

#[test]
fn help_is_that_of_the_flag() {
    assert_eq!(told(&["help"]), told(&["--help"]));
    for command in COMMANDS {
        assert_eq!(told(&["help", command]), told(&[command, "--help"]), "{command}");
        assert!(told(&["help"]).lines().any(|line| line.trim_start().starts_with(command)));
    }
    assert!(told(&["help"]).contains("fogbow help scene"));
}

#[test]
fn help_of_the_scene_has_every_table_and_key() {
    let text = told(&["help", "scene"]);
    for (name, _, table) in fogbow::scene::TABLES {
        assert!(text.contains(name), "{name}");
        for key in table.keys {
            let at = format!("    {}", key.name);
            assert!(text.lines().any(|line| line.starts_with(&at)), "{name}: {}", key.name);
        }
    }
    assert!(text.contains("photons (--photons)"), "flags are named");
}

#[test]
fn bash_takes_the_completions() {
    let folder = tempfile::tempdir().unwrap();
    let script = told(&["completions", "bash"]);
    let file = folder.path().join("fogbow.bash");
    std::fs::write(&file, &script).unwrap();
    let taken = Command::new("bash").arg("-n").arg(&file).output().unwrap();
    assert!(taken.status.success() && taken.stderr.is_empty(), "{taken:?}");
    // The words that bash offers for `fogbow re` and for `fogbow render --crop`.
    for (words, offered) in [("fogbow re", "render"), ("fogbow render --cro", "--crop")] {
        let count = words.split(' ').count() - 1;
        let script = format!(
            "source '{}'; COMP_WORDS=({words}); COMP_CWORD={count}; \
             _fogbow fogbow \"${{COMP_WORDS[$COMP_CWORD]}}\" \"${{COMP_WORDS[$COMP_CWORD-1]}}\"; \
             echo \"${{COMPREPLY[@]}}\"",
            file.display()
        );
        let output = Command::new("bash").args(["--norc", "-c", &script]).output().unwrap();
        let reply = String::from_utf8(output.stdout).unwrap();
        assert!(reply.split_whitespace().any(|word| word == offered), "{words}: {reply}");
    }
    for shell in ["zsh", "fish", "elvish", "powershell"] {
        let script = told(&["completions", shell]);
        assert!(COMMANDS.iter().all(|command| script.contains(command)), "{shell}");
    }
}

#[test]
fn manual_pages_hold_every_command_and_flag() {
    let page = told(&["man"]);
    assert!(page.contains(".TH fogbow 1"), "{page}");
    let folder = tempfile::tempdir().unwrap();
    let output = fogbow(folder.path(), &["man", "-o", "pages/man1"]);
    assert!(output.status.success());
    let written = String::from_utf8(output.stdout).unwrap();
    assert_eq!(written.lines().count(), 1 + COMMANDS.len());
    for command in COMMANDS {
        assert!(page.contains(&format!("fogbow\\-{command}(1)")), "{command} in {page}");
        let file = folder.path().join(format!("pages/man1/fogbow-{command}.1"));
        assert!(std::fs::read_to_string(&file).unwrap().contains("SYNOPSIS"), "{command}");
    }
    let render = std::fs::read_to_string(folder.path().join("pages/man1/fogbow-render.1")).unwrap();
    for flag in ["\\-\\-photons", "\\-\\-memory", "\\-\\-director"] {
        assert!(render.contains(flag), "{flag}");
    }
    std::fs::write(folder.path().join("file"), "").unwrap();
    let output = fogbow(folder.path(), &["man", "-o", "file"]);
    let message = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.code() == Some(1) && message.contains("give a folder"), "{message}");
}
