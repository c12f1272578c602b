"""What a render call takes, and the report each renderer's script writes beside its picture."""

import argparse
import json
import resource
import time
from pathlib import Path
from types import TracebackType


def arguments(description: str) -> argparse.ArgumentParser:
    """The arguments that all peers take."""
    parser = argparse.ArgumentParser(description=description)
    parser.add_argument("--scene", required=True)
    parser.add_argument("--size", type=int, required=True, help="width and height in pixels")
    parser.add_argument("--rays", type=int, required=True, help="camera rays a pixel")
    parser.add_argument("--seed", type=int, required=True)
    parser.add_argument("--threads", type=int, required=True)
    parser.add_argument("--out", type=Path, required=True, help="linear EXR to write")
    return parser


class Meter:
    """Wall seconds, and CPU seconds of all threads of this process, spent in a `with` block."""

    def __enter__(self) -> "Meter":
        self._wall, self._cpu = time.perf_counter(), time.process_time()
        return self

    def __exit__(self, *_: type[BaseException] | BaseException | TracebackType | None) -> None:
        self.wall = time.perf_counter() - self._wall
        self.cpu = time.process_time() - self._cpu

    def report(self, picture: Path, **more: float) -> None:
        """Writes the measurements beside `picture`."""
        peak_mib = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
        write_report(picture, cpu_s=self.cpu, wall_s=self.wall, peak_mib=peak_mib, **more)


def write_report(picture: Path, **measured: float) -> None:
    picture.with_suffix(".measured.json").write_text(json.dumps(measured))
