"""Renders smoke, fog and fire, and says what each shortcut costs in error.

>>> import fogbow
>>> image = fogbow.render("smoke.toml", rays=8, size=(640, 360))
>>> image.rgb.shape
(360, 640, 3)
>>> image.save("smoke.exr")

A scene is the path of a scene file (TOML) or of a VDB file, a dictionary with the keys of a scene file, a `Volume` made
of NumPy arrays by `volume`, or a `Scene` that `load` returned. Settings have the names of the flags of `fogbow render`
with ``_`` for ``-``; `settings` lists them. Lengths are in metres, y is up, and colours are linear Rec.709.
"""

from __future__ import annotations

import json
import os
import signal
import sys
from typing import Any

from ._errors import Error, FileError, SettingError
from ._fogbow import __version__
from ._fogbow import compare as _compare
from ._fogbow import flags as _flags
from ._fogbow import info as _info
from ._fogbow import main as _run
from ._image import Image, Picture, side
from ._scene import Progress, Scene, SceneLike, load
from ._settings import words
from ._volume import Volume, volume

__all__ = [
    "Error",
    "FileError",
    "Image",
    "Scene",
    "SettingError",
    "Volume",
    "__version__",
    "error",
    "info",
    "load",
    "maps",
    "plan",
    "render",
    "settings",
    "study",
    "volume",
]


def render(scene: SceneLike, *, progress: Progress = None, **settings: Any) -> Image:
    """Renders a picture of `scene`, as the command ``fogbow render`` does.

    Args:
        scene: A path, a dictionary, a `Volume` or a `Scene`.
        progress: True for a bar of tqdm, or a function that is called with the name of a stage, units of work done and
            their total, which is 0 where it is unknown.
        **settings: Flags of ``fogbow render``, such as ``rays=8``, ``photons=100_000``, ``size=(640, 360)``,
            ``director="xs"``, ``error=0.05``, ``denoise=True`` or ``threads=1``. ``set={"medium.0.albedo": 0.8}`` gives any
            key of the scene. ``frame`` chooses one of a sequence; ``frame=12.5`` is a time
            between two.

    Raises:
        SettingError: A setting or a key of the scene is unknown or out of range.
        FileError: A file cannot be read or used.
        KeyboardInterrupt: Ctrl-C was pressed.
    """
    return load(scene).render(progress=progress, **settings)


def maps(scene: SceneLike, **settings: Any) -> dict[str, Any]:
    """Makes the director's maps of `scene`: where in the picture it pays to be accurate.

    Returns:
        Each map by the name that its file has with ``fogbow maps``, such as ``x``, ``saliency`` and ``xs``: float32, rows
        from the top, with a third axis where there are colours.
    """
    return load(scene).maps(**settings)


def plan(scene: SceneLike, **settings: Any) -> dict[str, Any]:
    """Tells what rendering `scene` needs, what is left out and why, and what it should cost, as ``fogbow plan --json``."""
    return load(scene).plan(**settings)


def study(
    scene: SceneLike, output: str | os.PathLike[str], *, progress: Progress = None, **settings: Any
) -> dict[str, Any]:
    """Measures what each way of rendering `scene` costs in error and saves in time, as ``fogbow study --json``.

    Args:
        scene: A path, a dictionary, a `Volume` or a `Scene`.
        output: The folder for report.html, results.json and the pictures.
        progress: As for `render`.
        **settings: Flags of ``fogbow study``, such as ``time="2m"``, ``reference=256`` or ``candidates=["xs", "fixed"]``.
    """
    return load(scene).study(output, progress=progress, **settings)


def error(reference: Picture, test: Picture, **settings: Any) -> dict[str, float | None]:
    """Tells how far a picture is from its reference, by every metric of ``fogbow error``.

    Args:
        reference: The path of an EXR, an `Image`, or an array of rows, columns and three channels.
        test: The picture that is tested against it.
        **settings: Flags of ``fogbow error``, such as ``exposure=1`` or ``epsilon=0.01``.

    Returns:
        Each figure by name; None where it is not defined for these pictures.
    """
    words_of_error, _ = words("error", settings)
    report = json.loads(_compare(side(reference), side(test), words_of_error))
    return dict(report["errors"])


def info(path: str | os.PathLike[str] | Volume) -> dict[str, Any]:
    """Tells what is in a VDB file, what is wrong with it and what fogbow would do with it, as ``fogbow info --json``."""
    return dict(json.loads(_info(os.fspath(path))))


def settings(command: str = "render") -> dict[str, str]:
    """The settings of `render` or of another command of the program, each with what it means."""
    return {name.replace("-", "_"): meaning for name, _, meaning in _flags(command)}


def _main() -> int:
    """The command ``fogbow``; returns its exit code."""
    # The program listens for Ctrl-C by itself.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    return _run(["fogbow", *sys.argv[1:]])
