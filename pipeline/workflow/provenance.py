"""Where a run came from: everything that it takes to repeat it."""

from __future__ import annotations

import hashlib
import platform
import shlex
import subprocess
import sys
from importlib.metadata import version
from pathlib import Path

import msgspec

from pipeline import __version__
from pipeline.paths import IN_CHECKOUT, ROOT
from pipeline.plant.fmu import open_fmu
from pipeline.workflow.acquire import data_files
from pipeline.workflow.building import fmu_files
from pipeline.workflow.session import Session

PACKAGES = ("fmpy", "numpy", "scipy", "pandas", "filterpy", "control", "numba", "casadi", "rumoca", "bokeh")


def provenance(session: Session) -> dict:
    """Command, versions, commit, platform, seed, engine of regressor and loop, FMUs and data files with SHA-256."""
    commit, dirty = _commit()
    return {
        "command": shlex.join(["fmuid", *sys.argv[1:]]),
        "versions": {"fmuid": __version__, **{name: version(name) for name in PACKAGES}},
        "commit": commit,
        "dirty": dirty,
        "python": platform.python_version(),
        "platform": platform.platform(),
        "seed": session.experiment.seed,
        "engine": _engines(session),
        "fmus": {path.stem: _identity(path) for path in fmu_files(session)},
        "data": {path.name: hashlib.sha256(path.read_bytes()).hexdigest() for path in data_files(session)},
    }


def _engines(session: Session) -> str:
    """What computed regressor and closed loop, in words."""
    chosen = {part: session.engines[part].text for part in ("regressor", "closed loop") if part in session.engines}
    texts = set(chosen.values())
    return texts.pop() if len(texts) == 1 else "; ".join(f"{part}: {text}" for part, text in chosen.items())


def plant_entry(session: Session) -> dict:
    """The plant's FMU as the record's `plant`."""
    interface = session.experiment.ekf.interface if session.experiment.ekf else "ME"
    with open_fmu(session.binding.path) as file:
        return {
            "fmu": file.path.name,
            "sha256": file.sha256,
            "guid": file.description.guid,
            "fmi_version": file.description.fmiVersion,
            "interface": interface[:2],
            "rung": {"ME": "A", "CS": "C", "CS reset": "E"}[interface],
            "generation_tool": file.description.generationTool,
            "binding": {**msgspec.to_builtins(session.binding), "folder": None},
        }


def _identity(path: Path) -> dict:
    with open_fmu(path) as file:
        return {"sha256": file.sha256, "guid": file.description.guid}


def _commit() -> tuple[str | None, bool | None]:
    """The checkout's commit and whether tracked files differ from it; None, None where fmuid runs from no checkout."""
    head = _git("rev-parse", "HEAD", "--show-prefix").split("\n") if IN_CHECKOUT else [""]
    if not head[0] or any(head[1:]):  # a prefix: the folder stands inside somebody else's repository
        return None, None
    return head[0], bool(_git("status", "--porcelain", "--untracked-files=no"))


def _git(*arguments: str) -> str:
    """What git says of the checkout, or "" where there is none."""
    try:
        result = subprocess.run(["git", *arguments], cwd=ROOT, capture_output=True, text=True, timeout=10, check=True)
    except (OSError, subprocess.SubprocessError):
        return ""
    return result.stdout.strip()
