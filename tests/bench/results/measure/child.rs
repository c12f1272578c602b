//! Programs that are run for their figures.

use std::path::Path;
use std::process::{Command, Stdio};

use serde::de::DeserializeOwned;
use serde_json::Value;

use crate::pages::Result;

/// fogbow's own command with these arguments, from the repository, and the JSON it prints.
pub fn fogbow(arguments: &[&str]) -> Result<Value> {
    let mut command = Command::new(env!("CARGO_BIN_EXE_fogbow"));
    command.current_dir(env!("CARGO_MANIFEST_DIR")).args(arguments);
    Ok(serde_json::from_slice(&printed(&mut command)?)?)
}

/// Runs cargo in the repository; the lines of its output that are JSON objects of this kind.
pub fn cargo<R: DeserializeOwned>(arguments: &[&str], quick: bool) -> Result<Vec<R>> {
    let program = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let mut command = Command::new(program);
    command.current_dir(env!("CARGO_MANIFEST_DIR")).args(arguments);
    if quick {
        command.env("FOGBOW_QUICK", "1");
    }
    objects(&printed(&mut command)?)
}

/// Runs the ignored tests of a file whose names hold `filter`, optimised as users have it unless it is
/// to be quick; the lines of their output that are JSON objects of this kind.
pub fn cargo_test<R: DeserializeOwned>(file: &str, filter: &str, quick: bool) -> Result<Vec<R>> {
    let profile: &[&str] = if quick { &[] } else { &["--release"] };
    let (test, asked) = (["test", "--test", file], ["--", "--ignored", "--nocapture", filter]);
    cargo(&[&test[..], profile, &asked].concat(), quick)
}

/// Every line of `text` that is a JSON object, as one of these.
pub fn objects<R: DeserializeOwned>(text: &[u8]) -> Result<Vec<R>> {
    let text = String::from_utf8_lossy(text);
    let lines = text.lines().filter(|line| line.starts_with('{'));
    lines.map(|line| Ok(serde_json::from_str(line)?)).collect()
}

/// What a program prints; its messages go where ours go.
pub fn printed(command: &mut Command) -> Result<Vec<u8>> {
    let output = command.stdin(Stdio::null()).stderr(Stdio::inherit()).output();
    let name = command.get_program().display().to_string();
    let output = output.map_err(|e| format!("{name}: {e}"))?;
    if output.status.success() {
        Ok(output.stdout)
    } else {
        Err(format!("{name}: {}", output.status).into())
    }
}

/// A path as an argument.
pub fn argument(path: &Path) -> Result<&str> {
    path.to_str().ok_or_else(|| format!("{}: not in UTF-8", path.display()).into())
}
