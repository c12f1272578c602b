"""Pictures in memory."""

from __future__ import annotations

import json
import os
from functools import cached_property
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Mapping, Union

from . import _fogbow

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import ArrayLike, NDArray

    Picture = Union[str, os.PathLike[str], "Image", ArrayLike]
else:
    Picture = Any


class Image:
    """A rendered picture. Its arrays are read-only views of the renderer's own memory; `numpy.array` copies them."""

    def __init__(self, picture: _fogbow.Picture) -> None:
        self._picture = picture
        self._report: dict[str, Any] = json.loads(picture.report)

    @cached_property
    def rgb(self) -> NDArray[np.float32]:
        """Radiance in W/(m² sr), linear Rec.709, premultiplied by `alpha`: rows from the top, columns, channels."""
        import numpy as np

        return np.asarray(self._picture.rgb())

    @property
    def alpha(self) -> NDArray[np.float32]:
        """Coverage, 0 to 1: rows from the top, columns."""
        return self.layers["A"]

    @cached_property
    def layers(self) -> Mapping[str, NDArray[np.float32]]:
        """Each layer of the EXR by its name, such as ``Z`` (metres), ``transmittance``, ``rays`` and ``variance``."""
        import numpy as np

        return MappingProxyType({name: np.asarray(values) for name, values in self._picture.layers()})

    @property
    def size(self) -> tuple[int, int]:
        """Width and height in pixels."""
        return self._picture.size

    @property
    def error(self) -> float | None:
        """The error of the picture where the setting ``error`` gave a goal: relative to the radiance, or in least visible
        differences where that was ``"visible"``; None where it is not known."""
        return self._picture.error[0] if self._picture.error else None

    @property
    def uncertainty(self) -> float | None:
        """Half the width of the interval that holds `error`, in the same unit."""
        return self._picture.error[1] if self._picture.error else None

    @property
    def seconds(self) -> dict[str, float]:
        """Seconds that each stage took, by the clock."""
        return dict(self._report["seconds"])

    @property
    def report(self) -> dict[str, Any]:
        """What ``fogbow render --json`` prints: settings, seconds, counters of work, strategy, warnings and notes."""
        return dict(self._report)

    def save(self, *paths: str | os.PathLike[str]) -> None:
        """Writes the files that ``fogbow render`` writes: for a path in .exr all layers, for one in .png the view."""
        for path in paths:
            self._picture.save(path)

    def _repr_png_(self) -> bytes:
        return self._picture.png()

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> NDArray[Any]:
        import numpy as np

        if copy:
            return np.array(self.rgb, dtype=dtype)
        return np.asarray(self.rgb, dtype=dtype)

    def __repr__(self) -> str:
        width, height = self.size
        return f"<fogbow.Image {width} x {height}, {sum(self.seconds.values()):.2f} s>"


def side(picture: Picture) -> Any:
    """A picture to compare, as the native module takes it."""
    if isinstance(picture, (str, os.PathLike)):
        return os.fspath(picture)
    import numpy as np

    pixels = np.ascontiguousarray(picture, dtype=np.float32)
    if pixels.ndim != 3 or pixels.shape[2] != 3:
        raise ValueError(f"a picture has rows, columns and three channels; this array has the shape {pixels.shape}")
    return (pixels.shape[0], pixels.shape[1], pixels.tobytes())
