"""The figures of the commands: what they cost in CPU time, and what the page weighs."""

from __future__ import annotations

import json
import resource
import statistics
import subprocess
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

from tests.figures.figure import Figure, at_most, below, yes


def measure() -> list[Figure]:
    """Help, build and a whole run, each in a process of its own."""
    help_seconds = statistics.median(cpu("--help")[0] for _ in range(9))
    seconds, _ = cpu("build", "--force")
    with TemporaryDirectory() as folder:
        run_seconds, out = cpu("run", "scara", "--json", "--output", f"{folder}/run")
        again, _ = cpu("build")
        size = (Path(folder) / "run" / "index.html").stat().st_size / 1e6
    verdict = json.loads(out)["verdict"]["status"]
    return [
        at_most("`fmuid --help`, CPU s", help_seconds, 0.15),
        below("`fmuid build --force`, all FMUs, CPU s with the compiler", seconds, 10.0),
        at_most("second `make run` (build, up to date + run scara), CPU s", again + run_seconds, 60.0),
        yes("verdict of `fmuid run scara`", verdict == "pass", verdict, "pass"),
        at_most("the page of scara, MB", size, 4.0),
    ]


def cpu(*arguments: str) -> tuple[float, str]:
    """CPU seconds of `fmuid arguments` with its children, and its stdout."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    result = subprocess.run([sys.executable, "-m", "pipeline.cli", *arguments], capture_output=True, text=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime, result.stdout
