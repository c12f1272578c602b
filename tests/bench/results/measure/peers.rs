//! Pictures of fogbow, Cycles and Mitsuba, by `tests/bench/peers/run.py`.

use std::fs::{self, DirEntry};
use std::path::Path;
use std::process::Command;

use super::child::{objects, printed};
use super::{Kept, LeftOut};
use crate::pages::Result;
use crate::pages::peers::Row;

/// The Python that Blender's module is made for.
const PYTHON: &str = "python3.11";

/// Tells where the LLVM of Mitsuba's compiler is, where it is in no usual place.
const LIBLLVM: &str = "DRJIT_LIBLLVM_PATH";

/// One part: the script keeps its pictures itself.
pub fn measure(kept: &mut Kept<Row>, quick: bool) -> Result<()> {
    if Command::new(PYTHON).arg("--version").output().is_err() {
        return Err(LeftOut(format!("there is no {PYTHON}; apt-get install {PYTHON}")).into());
    }
    if !has_llvm() {
        let message = format!("there is no LLVM 19; apt-get install libllvm19, or set {LIBLLVM}");
        return Err(LeftOut(message).into());
    }
    let out = kept.folder("out");
    fs::create_dir_all(&out)?;
    kept.part("all scenes", || {
        let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/bench/peers/run.py");
        let mut command = Command::new(PYTHON);
        command.arg(script).arg("--out").arg(&out);
        if quick {
            command.args(["--quick", "--scene", "smoke"]);
        }
        printed(&mut command)?;
        objects(&fs::read(out.join("points.jsonl"))?)
    })
}

/// Whether the script finds what compiles Mitsuba's kernels.
fn has_llvm() -> bool {
    let is_llvm =
        |entry: DirEntry| entry.file_name().to_string_lossy().starts_with("libLLVM.so.19");
    let libraries = fs::read_dir("/usr/lib").into_iter().flatten().flatten();
    let mut files =
        libraries.filter_map(|folder| fs::read_dir(folder.path()).ok()).flatten().flatten();
    std::env::var_os(LIBLLVM).is_some() || files.any(is_llvm)
}
