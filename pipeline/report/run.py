"""A run as the page asks for it: the record, its signals, and the few questions that every section has."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
import pandas as pd

from pipeline.units import unit_text

PAPER_TUNINGS = (None, "", "paper")
FEW = 10  # rows below which there is nothing to draw
FILTER_COLOURS = ("c2", "c3", "c4", "c5", "c6")


@dataclass(frozen=True)
class Run:
    """record: result.json; signals: its tables by stem (see record.read_run)."""

    record: dict
    signals: dict[str, pd.DataFrame]

    @property
    def estimates(self) -> dict[str, dict]:
        return self.record["estimates"]

    @property
    def joints(self) -> int:
        return int(self.record["experiment"].get("joints") or 1)

    @cached_property
    def parameters(self) -> dict[str, dict]:
        """Every parameter that any estimate holds, in order, with the first description found."""
        found: dict[str, dict] = {}
        for estimate in self.estimates.values():
            for name, parameter in (estimate.get("parameters") or {}).items():
                known = {key: item for key, item in parameter.items() if item is not None}
                found[name] = known | found.get(name, {})
        return found

    @property
    def reference(self) -> dict:
        return self.record.get("reference") or {}

    @property
    def figures(self) -> dict:
        """The paper's figure numbers: {"torque": 4, "EKF(2)": {"states": [5, …], "parameters": [13, …]}} or {}."""
        return self.reference.get("figures") or {}

    @cached_property
    def recommended(self) -> str | None:
        """The batch estimate that carries the essential parameters, or else the last one that worked."""
        batch = [n for n, e in self.estimates.items() if e.get("method") == "WLS" and ok(e)]
        return next((n for n in batch if self.estimates[n].get("essential")), batch[-1] if batch else None)

    def resolution(self, parameter: str) -> float | None:
        """The recommended estimate's sigma: it sets the digits of values whose own sigma is withheld."""
        best = self.estimates.get(self.recommended or "", {})
        return ((best.get("parameters") or {}).get(parameter) or {}).get("sigma")

    @property
    def floor_name(self) -> str:
        """What the noise floor is: known from the truth, or guessed from the data's quietest band."""
        return "noise floor" if self.record["experiment"].get("kind") == "simulated" else "noise floor (a guess)"

    @property
    def position_unit(self) -> str:
        return self.record["experiment"].get("position_unit", "")

    @property
    def force_unit(self) -> str:
        return self.record["experiment"].get("force_unit", "")

    @property
    def force(self) -> str:
        return "Torque" if unit_text(self.force_unit) == "N·m" else "Force"

    def joint_name(self, joint: int) -> str:
        """The name of joint 1…n."""
        names = self.record["experiment"].get("joint_names") or []
        name = str(names[joint - 1]) if joint <= len(names) else f"joint {joint}"
        return name[:1].upper() + name[1:]

    def table(self, name: str) -> pd.DataFrame | None:
        """The signals of an estimate; None where there are none to draw, as of a filter that failed at once."""
        path = self.estimates[name].get("signals")
        table = self.signals.get(Path(path).stem) if path else None
        return table if table is not None and len(table) > FEW else None

    def by_method(self, method: str) -> list[str]:
        """Names of the estimates of a method that have signals."""
        return [n for n in self._drawn if self.estimates[n].get("method") == method]

    @cached_property
    def _drawn(self) -> list[str]:
        return [n for n in self.estimates if self.table(n) is not None]

    @cached_property
    def filters(self) -> list[str]:
        """The filters with signals whose course is shown one by one: the paper's, or all where none is the paper's."""
        every = self.by_method("EKF")
        named = [n for n in every if n in self.figures]
        plain = [n for n in every if self.estimates[n].get("tuning") in PAPER_TUNINGS and not self.is_euler(n)]
        return named or plain or every

    @cached_property
    def other_filters(self) -> list[str]:
        return [n for n in self.by_method("EKF") if n not in self.filters and not self.is_euler(n)]

    def is_euler(self, name: str) -> bool:
        """Whether a filter steps the plant by Eq. 13 (Euler) instead of RK4."""
        settings = self.estimates[name].get("settings") or {}
        return (
            str(settings.get("transition", settings.get("integrator", ""))).lower().startswith("euler")
            or "Euler" in name
        )

    def colour(self, name: str) -> str:
        """A colour of its own for every estimate that is drawn over time."""
        if self.estimates[name].get("method") != "EKF":
            return "wls"
        others = [n for n in self.by_method("EKF") if n not in self.filters]
        return FILTER_COLOURS[others.index(name) % len(FILTER_COLOURS)] if name in others else "ekf"


def ok(estimate: dict) -> bool:
    """Whether the estimator succeeded: only then are there numbers to show."""
    return estimate.get("status") == "ok"


def trusted(estimate: dict) -> bool:
    """Whether the estimate's sigma may be shown as a statement about the error."""
    return ok(estimate) and not estimate.get("sigma_reason")


def target(parameter: dict) -> tuple[str, float] | None:
    """What an estimate is compared with: the truth where it is known, else the a-priori value."""
    for key, label in (("truth", "truth"), ("a_priori", "a priori")):
        if parameter.get(key) is not None:
            return label, float(parameter[key])
    return None


def times(table: pd.DataFrame) -> np.ndarray:
    """The time axis (N,) in s of a table."""
    return np.asarray(table.get("time", table.index), float)


def has(table: pd.DataFrame | None, *columns: str) -> bool:
    """Whether there is a table that holds all of the columns."""
    return table is not None and all(column in table for column in columns)
