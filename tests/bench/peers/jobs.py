"""What is rendered: one job a picture, done once and kept."""

import json
import subprocess
import sys
import tomllib
from dataclasses import dataclass
from itertools import zip_longest
from pathlib import Path

from environments import Tool, Tools, digest
from scene import HERE, Scene

CYCLES = {
    "cycles": "null-scattering",
    "cycles-biased": "biased",
    "cycles-biased-oidn": "biased-oidn",
}
FOGBOW = {
    "fogbow-fixed": "fixed",
    "fogbow-xs": "xs",
    "fogbow-reconstructed": "fixed-reconstructed",
    "fogbow-oidn": "fixed-oidn",
    "fogbow-xs-oidn": "xs-oidn",
    "fogbow-traced-oidn": "reference-oidn",
    "fogbow-reference": "reference",
}
FIRST_REFERENCE_SEED = 101
# A picture of fewer CPU seconds is rendered so many times, for its time is the noisier the shorter.
SHORT, TIMES = 10.0, 3


@dataclass(frozen=True)
class Job:
    """One picture: `renderer` is a name of budgets.toml."""

    renderer: str
    rays: int
    photons: int | None
    seed: int

    @property
    def stem(self) -> str:
        photons = f"-{self.photons}p" if self.photons else ""
        return f"{self.renderer}{photons}-{self.rays}r-s{self.seed}"


def budgets() -> dict[str, dict]:
    """The tables of budgets.toml."""
    tables = tomllib.loads((HERE / "budgets.toml").read_text())
    return {name: _whole(table, tables) for name, table in tables.items()}


def _whole(budget: dict, tables: dict[str, dict]) -> dict:
    """A budget that is another's but for the last of some lists, or stands by itself."""
    if "of" not in budget:
        return budget
    whole = dict(tables[budget["of"]])
    for renderer, count in budget["without_last"].items():
        whole[renderer] = whole[renderer][:-count]
    return whole


def candidates(budget: dict) -> list[Job]:
    """The dearest of every renderer last, so that a run that was stopped has some of each."""
    lists = []
    for renderer, steps in budget.items():
        if renderer in FOGBOW:
            lists.append([Job(renderer, rays, photons or None, 1) for photons, rays in steps])
        elif renderer in CYCLES or renderer == "mitsuba":
            lists.append([Job(renderer, rays, None, 1) for rays in steps])
    dearest_first = zip_longest(*(reversed(jobs) for jobs in lists))
    return [job for row in reversed(list(dearest_first)) for job in row if job]


def references(budget: dict, scene: Scene) -> list[Job]:
    """The parts of each renderer's reference, a seed each; none where the scene was given one."""
    if scene.reference:
        return []
    seeds = range(FIRST_REFERENCE_SEED, FIRST_REFERENCE_SEED + budget["reference_parts"])
    return [
        Job(renderer, scene.reference_effort * rays, None, seed)
        for renderer, rays in budget["reference"].items()
        for seed in seeds
    ]


class Workshop:
    """Where the pictures of one scene are kept, and how they are made."""

    def __init__(self, scene: Scene, tools: Tools, cache: Path, threads: int) -> None:
        self.scene, self.threads, self._tools = scene, threads, tools
        self.folder = cache / "pictures" / f"{scene.name}-{scene.size}"
        self.folder.mkdir(parents=True, exist_ok=True)
        within = scene.volume.within
        self._volume = digest(within.read_bytes() if isinstance(within, Path) else b"")

    def key(self, job: Job) -> str:
        """Changes with all that decides the picture or its time."""
        script = digest((HERE / self._script(job)).read_bytes())
        parts = [self.scene.content, self._volume, self.threads, self._tool(job).version, script]
        parts += [SHORT, TIMES]
        return digest(json.dumps([*parts, vars(job)], default=str).encode())

    def done(self, job: Job) -> dict | None:
        """The record of a picture that is there already."""
        file = self.folder / f"{job.stem}.json"
        record = json.loads(file.read_text()) if file.exists() else {}
        return record if record.get("key") == self.key(job) else None

    def do(self, job: Job, nice: int) -> dict:
        """The record of a picture, rendered now unless it is there already."""
        record = self.done(job)
        if record is None:
            print(f"{self.scene.name}: {job.stem}", file=sys.stderr, flush=True)
            picture = self.folder / f"{job.stem}.exr"
            measured = self._measured(job, picture, nice)
            record = {"key": self.key(job), "scene": self.scene.name, "size": self.scene.size}
            record |= vars(job) | measured | {"picture": str(picture)}
            picture.with_suffix(".json").write_text(json.dumps(record))
        return record

    def _measured(self, job: Job, picture: Path, nice: int) -> dict:
        """What rendering `picture` took: the run whose CPU seconds are the median."""
        runs: list[dict] = []
        while not runs or (len(runs) < TIMES and runs[0]["cpu_s"] < SHORT):
            run(["nice", "-n", str(nice), *self._command(job, picture)])
            runs.append(json.loads(picture.with_suffix(".measured.json").read_text()))
        return sorted(runs, key=lambda measured: measured["cpu_s"])[len(runs) // 2]

    def _tool(self, job: Job) -> Tool:
        if job.renderer in FOGBOW:
            return self._tools.fogbow
        return self._tools.cycles if job.renderer in CYCLES else self._tools.mitsuba

    @staticmethod
    def _script(job: Job) -> str:
        kind = (
            "fogbow"
            if job.renderer in FOGBOW
            else "cycles"
            if job.renderer in CYCLES
            else "mitsuba"
        )
        return f"render_{kind}.py"

    def _command(self, job: Job, picture: Path) -> list[str]:
        common = ["--scene", self.scene.name, "--size", self.scene.size, "--rays", job.rays]
        common += ["--seed", job.seed, "--threads", self.threads, "--out", picture]
        if job.renderer in FOGBOW:
            script = [
                sys.executable,
                HERE / self._script(job),
                "--fogbow",
                self._tools.fogbow.program,
                "--denoiser",
                self._tools.fogbow.denoiser,
            ]
            script += ["--method", FOGBOW[job.renderer]]
            script += ["--photons", job.photons] if job.photons else []
        elif job.renderer in CYCLES:
            script = [self._tools.cycles.program, "-W", "ignore", HERE / self._script(job)]
            script += ["--method", CYCLES[job.renderer]]
        else:
            script = [self._tools.mitsuba.program, HERE / self._script(job)]
            within = self.scene.volume.within
            script += ["--dense", self._dense(within)] if isinstance(within, Path) else []
        return [str(part) for part in script + common]

    def _dense(self, file: Path) -> Path:
        dense = self.folder / f"{self._volume}.npz"
        if not dense.exists():
            script = [self._tools.cycles.program, HERE / "dense_grid.py"]
            script += ["--grid", self.scene.volume.grid]
            run([str(part) for part in [*script, file, dense]])
        return dense


def run(command: list[str]) -> None:
    """Runs a program that has nothing to say unless it fails."""
    process = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    if process.returncode != 0:
        raise SystemExit(f"{process.stdout}\nfailed: {' '.join(command)}")
