//! Pictures of fogbow, Cycles and Mitsuba, by `tests/bench/peers/run.py`.

use std::path::Path;
use std::process::Command;

use super::child::{objects, printed};
use super::{Kept, LeftOut};
use crate::pages::Result;
use crate::pages::peers::Row;

/// The Python that Blender's module is made for.
const PYTHON: &str = "python3.11";

/// One part: the script keeps its pictures itself.
pub fn measure(kept: &mut Kept<Row>, quick: bool) -> Result<()> {
    if Command::new(PYTHON).arg("--version").output().is_err() {
        return Err(LeftOut(format!("there is no {PYTHON}; apt-get install {PYTHON}")).into());
    }
    let out = kept.folder("out");
    std::fs::create_dir_all(&out)?;
    kept.part("all scenes", || {
        let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/bench/peers/run.py");
        let mut command = Command::new(PYTHON);
        command.arg(script).arg("--out").arg(&out);
        if quick {
            command.args(["--quick", "--scene", "smoke"]);
        }
        printed(&mut command)?;
        objects(&std::fs::read(out.join("points.jsonl"))?)
    })
}
