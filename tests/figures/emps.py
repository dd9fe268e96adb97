"""The figures of the measured EMPS drive."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np

from pipeline.paths import ROOT
from pipeline.workflow.run import identify
from pipeline.workflow.session import open_session
from tests.figures.figure import Figure, at_most, between, yes

DATA = Path(os.environ.get("FMUID_EMPS_DATA", ROOT.parent / "shared" / "data" / "emps"))
PUBLISHED = {"M": 95.1089, "Fv": 203.5034, "Fc": 20.3935, "offset": -3.1648}
LOOP = {
    "identification": {"position": 0.0015, "velocity": 0.15, "force": 4.8},
    "validation": {"position": 0.002, "velocity": 0.20, "force": 5.5},
}


def measure() -> list[Figure]:
    """Every figure of the EMPS; one row that says so where the data are absent."""
    if not (DATA / "DATA_EMPS.mat").is_file():
        return [yes("EMPS data", False, f"none in {DATA}", "set FMUID_EMPS_DATA to their folder")]
    record, _ = identify(open_session("emps", data=str(DATA)))
    if record["errors"]:
        return [yes("EMPS runs", False, record["errors"][0]["message"], "no error")]
    estimates, validation = record["estimates"], record["validation"]
    published = estimates["WLS(published)"]
    rows = [_published(published, name) for name in PUBLISHED]
    cond = published["condition_number"]
    rows.append(between("WLS(published) cond", cond, cond, 25.9, 26.1))
    own = validation["own_filters"]
    for run, expected in (("identification", 4.13), ("validation", 6.00)):
        error = own["WLS(published)"][run]
        rows.append(between(f"WLS(published) force error, {run}, %", error, error, expected - 0.03, expected + 0.03))
    rows.append(at_most("WLS(house) force error, validation, %", own["WLS(house)"]["validation"], 4.7))
    for run, limits in LOOP.items():
        for signal, limit in limits.items():
            rows.append(at_most(f"closed loop, {run}, {signal}, %", validation["closed_loop"][run][signal], limit))
    for name in ("EKF(half)", "EKF(one and a half)"):
        rows += _filter(estimates, name)
    return rows


def _published(estimate: dict, name: str) -> Figure:
    value = estimate["parameters"][name]["value"]
    deviation = 100 * abs(value / PUBLISHED[name] - 1)
    return at_most(f"WLS(published) {name}, deviation %", deviation, 0.6 if name == "offset" else 0.3)


def _filter(estimates: dict, name: str) -> list[Figure]:
    found, house = estimates[name], estimates["WLS(house)"]["parameters"]
    if found["status"] != "ok":
        return [yes(name, False, found["reason"], "ok")]
    rows = []
    for parameter, limit in (("M", 1.0), ("Fv", 2.0), ("Fc", 2.0)):
        ratio = found["parameters"][parameter]["value"] / house[parameter]["value"]
        rows.append(at_most(f"{name} {parameter}, from WLS %", float(100 * np.abs(ratio - 1)), limit))
    rows.append(
        yes(f"{name}: sigma not calibrated", bool(found["sigma_reason"]), found["sigma_reason"] or "shown", "withheld")
    )
    return rows
