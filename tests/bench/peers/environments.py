"""The virtual environments of the peers, and the fogbow to measure."""

import hashlib
import os
import subprocess
import sys
import venv
from dataclasses import dataclass
from pathlib import Path

from scene import HERE, REPOSITORY

PYTHON = (3, 11)  # bpy 5.0 has wheels for no other
LIBLLVM = "DRJIT_LIBLLVM_PATH"


def digest(*contents: bytes) -> str:
    return hashlib.sha256(b"".join(contents)).hexdigest()[:16]


@dataclass(frozen=True)
class Tool:
    """A program, and what tells one version of it from another."""

    program: Path
    version: str
    denoiser: Path | None = None  # the library that it denoises with


@dataclass(frozen=True)
class Tools:
    mitsuba: Tool
    cycles: Tool
    fogbow: Tool


def _environment(name: str, cache: Path) -> Tool:
    """The Python of `cache/name`, made anew where its requirements have changed."""
    requirements = (HERE / f"requirements-{name}.txt").read_text()
    folder = cache / name
    python, stamp = folder / "bin" / "python", folder / "installed.txt"
    if not stamp.exists() or stamp.read_text() != requirements:
        print(f"setting up {folder}", file=sys.stderr)
        venv.create(folder, clear=True, with_pip=True)
        install = [
            python,
            "-m",
            "pip",
            "install",
            "--quiet",
            "-r",
            HERE / f"requirements-{name}.txt",
        ]
        subprocess.run(install, check=True)
        stamp.write_text(requirements)
    return Tool(python, digest(requirements.encode()))


def _find_llvm() -> None:
    """Tells Mitsuba's compiler where LLVM is; 14 to 16 do not work with it."""
    if LIBLLVM in os.environ:
        return
    found = sorted(Path("/usr/lib").glob("*/libLLVM.so.19*"))
    if not found:
        raise SystemExit(f"no LLVM 19 found: apt-get install libllvm19, or set {LIBLLVM}")
    os.environ[LIBLLVM] = str(found[0])


def _denoiser(cache: Path) -> Path:
    """The Open Image Denoise that bpy brings, as FOGBOW_OIDN is to name it."""
    (brought,) = (cache / "cycles").glob("lib/*/site-packages/bpy/lib")
    return brought / "libOpenImageDenoise.so.2"


def _fogbow(build: bool, denoiser: Path) -> Tool:
    """$FOGBOW, or a release build, made now if `build`."""
    given = os.environ.get("FOGBOW")
    program = Path(given) if given else REPOSITORY / "target" / "release" / "fogbow"
    if build and not given:
        command = ["cargo", "build", "--release"]
        subprocess.run(command, cwd=REPOSITORY, check=True)
    if not program.is_file():
        raise SystemExit(f"{program} is no file; set FOGBOW to the program, or let it be built")
    return Tool(program, digest(program.read_bytes()), denoiser)


def prepare(cache: Path, build: bool) -> Tools:
    """Everything that renders, set up below `cache` where it is not yet; see `_fogbow`."""
    if sys.version_info[:2] != PYTHON:
        raise SystemExit(f"wants Python {PYTHON[0]}.{PYTHON[1]}, for which bpy has wheels")
    _find_llvm()
    cache.mkdir(parents=True, exist_ok=True)
    mitsuba, cycles = (_environment(name, cache) for name in ("mitsuba", "cycles"))
    return Tools(mitsuba, cycles, _fogbow(build, _denoiser(cache)))
