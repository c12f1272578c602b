"""Scenes that stay loaded."""

from __future__ import annotations

import json
import os
import sys
from contextlib import contextmanager
from typing import Any, Callable, Iterable, Iterator, Union
from warnings import warn

from . import _fogbow
from ._image import Image
from ._settings import plain, words
from ._volume import Volume

SceneLike = Union[str, "os.PathLike[str]", "dict[str, Any]", Volume, "Scene"]
Progress = Union[bool, Callable[[str, int, int], Any], None]


class Scene:
    """A scene that stays loaded: each of its grids and other files is read once, by the first picture that needs it."""

    def __init__(self, scene: str | os.PathLike[str] | dict[str, Any] | Volume) -> None:
        self._source = scene  # A volume's file vanishes with it.
        if isinstance(scene, dict):
            self._name = "dict"
            self._scene = _fogbow.Scene.of_json(self._name, json.dumps(scene, default=plain))
        else:
            self._name = os.fspath(scene)
            self._scene = _fogbow.Scene.of_file(self._name)

    def render(self, *, progress: Progress = None, **settings: Any) -> Image:
        """Renders a picture; see `fogbow.render`. It is the one that a scene loaded anew gives."""
        given = _of_picture(settings)
        with _bars(progress) as told:
            return _image(self._scene.render(given, told))

    def render_all(self, settings: Iterable[dict[str, Any]], *, progress: Progress = None) -> Iterator[Image]:
        """Renders a picture for each of the `settings`, one after another, as the iterator is asked for them.

        Each picture is the one that `render` gives. Those that differ only in what photons do not depend on, such as
        denoising, crop, exposure and directors that do not measure error, share photons that are shot once.
        """
        given = [_of_picture(one) for one in settings]
        shared = self._scene.share_photons(given)
        for one in given:
            with _bars(progress) as told:
                image = _image(self._scene.render_sharing(one, shared, told))
            yield image

    def maps(self, **settings: Any) -> dict[str, Any]:
        """Makes the director's maps; see `fogbow.maps`."""
        import numpy as np

        return {name: np.asarray(values) for name, values in self._scene.maps(words("maps", settings)[0])}

    def plan(self, **settings: Any) -> dict[str, Any]:
        """Tells what rendering needs and should cost; see `fogbow.plan`."""
        return dict(json.loads(self._scene.plan(words("plan", settings)[0])))

    def study(self, output: str | os.PathLike[str], *, progress: Progress = None, **settings: Any) -> dict[str, Any]:
        """Measures error and time of each way of rendering; see `fogbow.study`."""
        given, _ = words("study", settings)
        with _bars(progress) as told:
            return dict(json.loads(self._scene.study(os.fspath(output), given, told)))

    def __repr__(self) -> str:
        return f"<fogbow.Scene {self._name}>"


def load(scene: SceneLike, **settings: Any) -> Scene:
    """Loads a scene, to render more than one picture of it.

    Args:
        scene: A path, a dictionary, a `Volume`, or a `Scene`, which is returned.
        **settings: Where any are given, all files that a picture with them needs are read at once, and a mistake in the
            scene is found; otherwise that is left to the first picture.
    """
    loaded = scene if isinstance(scene, Scene) else Scene(scene)
    if settings:
        loaded._scene.load(_of_picture(settings))
    return loaded


def _of_picture(settings: dict[str, Any]) -> tuple[float | None, list[str]]:
    given, frame = words("render", settings)
    return frame, given


def _image(picture: _fogbow.Picture) -> Image:
    """The picture, its warnings told to whom called `render`."""
    image = Image(picture)
    for warning in image.report["warnings"]:
        warn(warning, stacklevel=4)
    return image


@contextmanager
def _bars(progress: Progress) -> Iterator[Callable[[str, int, int], Any] | None]:
    """The function that is told of progress."""
    if not progress:
        yield None
    elif progress is not True:
        yield progress
    else:
        try:
            from tqdm.auto import tqdm
        except ImportError:
            yield _lines()
            return
        bars: dict[str, Any] = {}

        def show(stage: str, done: int, total: int) -> None:
            if stage not in bars:
                _close(bars)
                bars[stage] = tqdm(desc=stage, total=total or None, unit_scale=True)
            bars[stage].total = total or None
            bars[stage].update(done - bars[stage].n)

        try:
            yield show
        finally:
            _close(bars)


def _close(bars: dict[str, Any]) -> None:
    for bar in bars.values():
        bar.close()
    bars.clear()


def _lines() -> Callable[[str, int, int], None]:
    """Tells of each stage in a line, where there is no tqdm."""
    stages: list[str] = []

    def show(stage: str, _done: int, _total: int) -> None:
        if stages[-1:] != [stage]:
            stages.append(stage)
            print(f"fogbow: {stage}", file=sys.stderr)

    return show
