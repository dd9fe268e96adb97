"""The figures of FMI 2.0 and 3.0 over every FMU: validation, build time, equal bits, replay, derivatives."""

from __future__ import annotations

import resource
import tempfile
from pathlib import Path

import numpy as np
from fmpy.validation import validate_fmu

from pipeline.export.build import build
from pipeline.paths import FMUS
from pipeline.plant.binding import gains_of_bindings, variants_of_bindings
from tests.export.driver import Archive
from tests.export.test_derivatives import MODES, differences, jacobian, knowns, relative_error, standing, unknowns
from tests.export.test_fmus import NAMES
from tests.export.test_versions import INTERFACES, VERSIONS, replays_in_a_new_process, trajectory
from tests.figures.figure import Figure, at_most, yes


def measure() -> list[Figure]:
    """Every figure that is one for all FMUs and both versions."""
    archives = {name + version: Archive(FMUS / f"{name}{version}.fmu") for name in NAMES for version in VERSIONS}
    try:
        return [
            _validation(archives),
            at_most("build of every FMU in both versions, CPU s with the compiler", _build_time(), 10.0),
            _count("FMI 2.0 and 3.0 give the same bits, ME and CS", _equal(archives)),
            _count("serialised FMU state replays bit for bit in a new process", _replays(archives)),
            *_derivatives(archives),
        ]
    finally:
        for archive in archives.values():
            archive.close()


def _count(title: str, found: list[bool]) -> Figure:
    return yes(title, all(found), f"{sum(found)} of {len(found)}", "every one")


def _validation(archives: dict[str, Archive]) -> Figure:
    return _count("fmpy validation silent", [not validate_fmu(str(archive.path)) for archive in archives.values()])


def _build_time() -> float:
    """CPU s of this process and its children while everything is built."""

    def spent() -> float:
        usage = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
        return sum(u.ru_utime + u.ru_stime for u in usage)

    before = spent()
    with tempfile.TemporaryDirectory() as folder:
        build(None, Path(folder), gains_of_bindings(), variants=variants_of_bindings())
    return spent() - before


def _equal(archives: dict[str, Archive]) -> list[bool]:
    pairs = [(name, interface) for name in NAMES for interface in INTERFACES]
    return [len({trajectory(archives[name + v], name, interface) for v in VERSIONS}) == 1 for name, interface in pairs]


def _replays(archives: dict[str, Archive]) -> list[bool]:
    return [
        replays_in_a_new_process(archives[name + version], name, interface)
        for name in NAMES
        for version in VERSIONS
        for interface in INTERFACES
    ]


def _derivatives(archives: dict[str, Archive]) -> list[Figure]:
    """Directional against differences, adjoint against directional, in every mode."""
    central, adjoint = [], []
    for archive in archives.values():
        for mode in MODES:
            known, unknown = knowns(archive, mode), unknowns(archive, mode)
            with standing(archive, mode) as instance:
                found = jacobian(instance, unknown, known)
                central.append(relative_error(found, differences(instance, unknown, known)))
                if archive.description.fmiVersion != "2.0":
                    rows = np.array([instance.adjoint([name], known, [1.0]) for name in unknown])
                    adjoint.append(relative_error(rows, found))
    return [
        at_most("directional derivatives off central differences, relative", max(central), 1e-7),
        at_most("adjoint derivatives off directional ones, relative", max(adjoint), 1e-12),
    ]
