#!/usr/bin/env python3
"""Counts the errors of what run.py has rendered, and writes table.md, plot.svg and points.jsonl.

report.py MANIFEST OUT
"""

import argparse
import json
from dataclasses import asdict
from pathlib import Path

import plot
import reference
from equal_error import both, time_to
from metrics import errors, read

FOGBOW = tuple(name for name in plot.STYLES if name.startswith("fogbow-"))
FOREWORD = """\
Seconds are CPU seconds over {threads} threads: of fogbow all that comes after loading and before
writing, of a peer its render call (Cycles' holds reading the grid and building, told as "fixed";
Mitsuba's kernels are compiled before). Wall seconds stand beside and depend on what else the
machine does; CPU seconds do so less, but on shared cores they drift as well, so that ratios near 1
mean little; what took few is rendered three times and told by its median. relMSE is the mean of (x - r)² / (r² + eps²), eps half the
reference's mean, less the reference's own noise but at least a tenth of it; trimmed (without the
worst 0.1 % of the pixels), RMSE and FLIP (HDR) hold that noise; "mean" is the mean over the
reference's. Times to equal error lie on straight lines on logarithmic axes between those budgets
that are better than all sooner ones; "< 1.2" is sooner than the cheapest budget measured, "> 30"
later than the dearest. "Times" is the peer's seconds over fogbow's: below 1 fogbow is slower.
"""


def measure(scene: dict) -> dict:
    """The points of a scene: each record with its seconds and errors."""
    given = scene["given_reference"]
    truth = reference.given(**given) if given else reference.mix(scene["reference_parts"])
    points = []
    for record in scene["candidates"]:
        found = asdict(errors(read(record["picture"]), truth.picture))
        found["relmse"] = max(found["relmse"] - truth.noise, 0.1 * truth.noise)
        seconds = record["cpu_s"] / scene["threads"]
        points.append(record | found | {"seconds": seconds})
    return scene | {"points": points, "noise": truth.noise, "reference": truth.about}


def table(header: str, rows: list[list[str]]) -> str:
    columns = header.count("|") + 1
    lines = [f"| {header} |", "| --- |" + " ---: |" * (columns - 1)]
    return "\n".join(lines + [f"| {' | '.join(row)} |" for row in rows])


def number(value: float | None) -> str:
    return "" if value is None else f"{value:.3g}"


def points_table(scene: dict) -> str:
    measured = "s | fixed s | wall s | peak MiB | relMSE | trimmed | RMSE | FLIP | mean"
    header = f"renderer | photons | rays | {measured}"
    rows = []
    for p in sorted(scene["points"], key=lambda p: (p["renderer"], p["seconds"])):
        fixed = p.get("fixed_cpu_s")
        fixed = fixed / scene["threads"] if fixed is not None else None
        row = [p["renderer"], str(p["photons"] or ""), str(p["rays"])]
        row += [number(x) for x in (p["seconds"], fixed, p["wall_s"])] + [f"{p['peak_mib']:.0f}"]
        row += [f"{p['relmse']:.5f}", f"{p['trimmed']:.5f}", f"{p['rmse']:.4f}", f"{p['flip']:.4f}"]
        row.append(f"{p['mean_ratio']:.3f}")
        rows.append(row)
    return table(header, rows)


def equal_table(scene: dict, fogbow: str) -> str:
    """When `fogbow` is as good as each of the peers' points."""
    curves = {
        error: [(p["seconds"], p[error]) for p in scene["points"] if p["renderer"] == fogbow]
        for error in ("relmse", "flip")
    }
    if not curves["relmse"]:
        return f"{fogbow} was not rendered."
    header = "peer | rays | s | same relMSE, s | times | same FLIP, s | times | both, s | times"
    rows = []
    for p in sorted(scene["points"], key=lambda p: (p["renderer"], p["seconds"])):
        if p["renderer"] in FOGBOW:
            continue
        reached = [time_to(curves[error], p[error]) for error in ("relmse", "flip")]
        row = [p["renderer"], str(p["rays"]), number(p["seconds"])]
        for each in [*reached, both(*reached)]:
            row += [str(each), each.ratio(p["seconds"])]
        rows.append(row)
    return table(header, rows)


def page(scenes: list[dict]) -> str:
    parts = [FOREWORD.format(threads=scenes[0]["threads"])] if scenes else []
    for scene in scenes:
        parts.append(
            f"## {scene['title']}\n{scene['about']}; {scene['size']} x {scene['size']} pixels.\n"
        )
        parts.append(
            f"Reference: {scene['reference']}; relMSE of its noise {scene['noise']:.1e}.\n"
        )
        parts.append(points_table(scene) + "\n")
        for fogbow in FOGBOW:
            parts.append(f"{fogbow} as good as each peer:\n\n{equal_table(scene, fogbow)}\n")
    return "\n".join(parts)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("manifest", type=Path)
    parser.add_argument("out", type=Path)
    options = parser.parse_args()
    scenes = [measure(scene) for scene in json.loads(options.manifest.read_text())]
    (options.out / "table.md").write_text(page(scenes))
    lines = [json.dumps(point) + "\n" for scene in scenes for point in scene["points"]]
    (options.out / "points.jsonl").write_text("".join(lines))
    if scenes:
        plot.draw(scenes, options.out / "plot.svg")


if __name__ == "__main__":
    main()
