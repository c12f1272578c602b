"""Volumes made of NumPy arrays."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Any

from . import _fogbow

if TYPE_CHECKING:
    from numpy.typing import ArrayLike


class Volume:
    """Grids in a temporary VDB file, which vanishes with the volume. It stands wherever the path of a VDB file may."""

    def __init__(self, grids: list[tuple[str, Any]], voxel_size: list[float], origin: list[float]) -> None:
        # Here, so that whoever imports fogbow for pictures alone does not wait for them.
        import shutil
        import tempfile
        import weakref

        folder = tempfile.mkdtemp(prefix="fogbow-")
        self._vanish = weakref.finalize(self, shutil.rmtree, folder, ignore_errors=True)
        self._path = os.path.join(folder, "volume.vdb")
        self._grids = [name for name, _ in grids]
        self._shape = grids[0][1].shape[:3]
        given = [
            (
                name,
                values.shape[:3],
                values.size // max(values[..., 0].size, 1) if values.ndim == 4 else 1,
                values.tobytes(),
            )
            for name, values in grids
        ]
        _fogbow.write_volume(self._path, given, voxel_size, origin)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes the VDB file to `path`."""
        import shutil

        temporary = f"{os.fspath(path)}.part"
        shutil.copyfile(self._path, temporary)
        os.replace(temporary, path)

    def __fspath__(self) -> str:
        return self._path

    def __repr__(self) -> str:
        return f"<fogbow.Volume {' x '.join(map(str, self._shape))}: {', '.join(self._grids)}>"


def volume(
    density: ArrayLike,
    *,
    voxel_size: float | tuple[float, float, float] = 1.0,
    origin: tuple[float, float, float] = (0.0, 0.0, 0.0),
    temperature: ArrayLike | None = None,
    color: ArrayLike | None = None,
) -> Volume:
    """Makes a volume of arrays, to render alone or as the ``file`` of a medium in a dictionary.

    Args:
        density: Density at ``[x, y, z]``, where y is up; between the samples it is trilinear.
        voxel_size: From one sample to the next in metres: one number, or those along x, y and z.
        origin: Where the sample ``[0, 0, 0]`` lies, in metres.
        temperature: Temperature in kelvin of the same shape, for fire; the grid ``temperature``.
        color: Albedo of the same shape and three channels, 0 to 1; the grid ``Cd``.

    Raises:
        ValueError: An array has another shape.
    """
    import numpy as np

    given = {"density": density, "temperature": temperature, "Cd": color}
    grids = [(name, np.ascontiguousarray(values, np.float32)) for name, values in given.items() if values is not None]
    shape = grids[0][1].shape
    for name, values in grids:
        right = (*shape[:3], 3) if name == "Cd" else shape
        if len(shape) != 3 or 0 in shape or values.shape != right:
            wanted = right if len(shape) == 3 and 0 not in shape else "three axes, none of them empty"
            raise ValueError(f"{name} has the shape {values.shape}; give {wanted}")
    sizes = np.broadcast_to(np.asarray(voxel_size, np.float64), 3)
    if not (np.isfinite(sizes).all() and (sizes > 0).all()):
        raise ValueError(f"voxel_size={voxel_size!r}: give lengths above 0")
    return Volume(grids, sizes.tolist(), np.asarray(origin, np.float64).tolist())
