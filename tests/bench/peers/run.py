#!/usr/bin/env python3
"""Time to equal error, fogbow beside Mitsuba and Cycles: see the README beside this file."""

import argparse
import json
import sys
from pathlib import Path

import environments
import jobs
import scene as scenes


def options() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, required=True, help="folder for the table and the plot")
    parser.add_argument("--scene", action="append", choices=scenes.names(), help="by default all")
    parser.add_argument(
        "--size", type=int, help="width and height in pixels, instead of the scene's"
    )
    parser.add_argument("--budget", choices=jobs.budgets(), default="full", help="what to render")
    parser.add_argument(
        "--quick",
        dest="budget",
        action="store_const",
        const="quick",
        help="a small proof: --budget quick",
    )
    parser.add_argument(
        "--report", action="store_true", help="render nothing, report what is there"
    )
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--nice", type=int, default=5)
    parser.add_argument("--cache", type=Path, default=scenes.REPOSITORY / "target" / "peers")
    return parser.parse_args()


def render(workshop: jobs.Workshop, budget: dict, nice: int) -> None:
    """All pictures of a scene, those of its reference first."""
    for job in jobs.references(budget, workshop.scene):
        workshop.do(job, max(nice, 10))
    for job in jobs.candidates(budget):
        workshop.do(job, nice)


def manifest(workshop: jobs.Workshop, budget: dict) -> dict:
    """What report.py wants to know of a scene."""
    scene = workshop.scene
    there = [workshop.done(job) for job in jobs.candidates(budget)]
    parts = [workshop.done(job) for job in jobs.references(budget, scene)]
    given = scene.reference
    return {
        "name": scene.name,
        "title": scene.title,
        "about": scene.about,
        "size": scene.size,
        "threads": workshop.threads,
        "given_reference": {"file": str(given.file), "noise": given.noise} if given else None,
        "reference_parts": parts,
        "candidates": [record for record in there if record],
    }


def report(tools: environments.Tools, manifests: list[dict], out: Path) -> None:
    """Table and plot of the scenes whose references are complete."""
    ready = [scene for scene in manifests if None not in scene["reference_parts"]]
    ready = [scene for scene in ready if scene["candidates"]]
    for scene in manifests:
        if scene not in ready:
            print(f"{scene['name']}: nothing to report yet", file=sys.stderr)
    out.mkdir(parents=True, exist_ok=True)
    (out / "manifest.json").write_text(json.dumps(ready, indent=1))
    program = [str(tools.mitsuba.program), str(scenes.HERE / "report.py")]
    jobs.run([*program, str(out / "manifest.json"), str(out)])


def main() -> None:
    chosen = options()
    budget = jobs.budgets()[chosen.budget]
    size = chosen.size or budget.get("size")
    tools = environments.prepare(chosen.cache, build=not chosen.report)
    names = chosen.scene or scenes.names()
    places = [
        jobs.Workshop(scenes.load(name, size), tools, chosen.cache, chosen.threads)
        for name in names
    ]
    if not chosen.report:
        for workshop in places:
            render(workshop, budget, chosen.nice)
    report(tools, [manifest(workshop, budget) for workshop in places], chosen.out)
    print((chosen.out / "table.md").read_text())


if __name__ == "__main__":
    main()
