"""Fifth-order trajectories through way-points, from a CSV file, and the check of their limits."""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pandas as pd

from pipeline.errors import ConfigError, DataError
from pipeline.files import replacing
from pipeline.records import Trajectory
from pipeline.simulate.headings import split_heading
from pipeline.simulate.tables import Table, read_table
from pipeline.units import conversion

# Quintic Hermite base: a row per given value, slope, curvature at s = 0 and s = 1; a column per power of s.
HERMITE = np.array(
    [
        [1, 0, 0, -10, 15, -6],
        [0, 1, 0, -6, 8, -3],
        [0, 0, 0.5, -1.5, 1.5, -0.5],
        [0, 0, 0, 10, -15, 6],
        [0, 0, 0, -4, 7, -3],
        [0, 0, 0, 0.5, -1, 0.5],
    ]
)


@dataclass(frozen=True)
class Waypoints:
    """K way-points: t (K,) s, strictly increasing; q, qd, qdd (K, n) in `unit` (rad or m) and its derivatives by s."""

    t: np.ndarray
    q: np.ndarray
    qd: np.ndarray
    qdd: np.ndarray
    unit: str = "rad"


@dataclass(frozen=True)
class Limits:
    """Limits per joint (n,): |q|, |qd|, |qdd| in rad or m and s, |tau| in N·m or N; None: not limited."""

    q: Sequence[float] | None = None
    qd: Sequence[float] | None = None
    qdd: Sequence[float] | None = None
    tau: Sequence[float] | None = None


def evaluate(waypoints: Waypoints, t: np.ndarray) -> Trajectory:
    """The trajectory at the instants t (N,) s within the way-points: a quintic Hermite polynomial per segment."""
    w = waypoints
    k = np.clip(np.searchsorted(w.t, t, side="right") - 1, 0, len(w.t) - 2)
    T = np.diff(w.t)[k][:, None]
    s = (t - w.t[k])[:, None] / T
    ends = np.stack([w.q[k], w.qd[k] * T, w.qdd[k] * T**2, w.q[k + 1], w.qd[k + 1] * T, w.qdd[k + 1] * T**2])
    coefficients = np.einsum("hp,hkn->pkn", HERMITE, ends)
    return Trajectory(t, *(_polynomial(coefficients, s, order) / T**order for order in range(3)))


def sample(waypoints: Waypoints, rate: float) -> Trajectory:
    """The trajectory at `rate` (Hz) from the first to the last way-point, both included."""
    duration = waypoints.t[-1] - waypoints.t[0]
    steps = int(np.floor(duration * rate * (1 + 1e-12) + 1e-9))
    return evaluate(waypoints, waypoints.t[0] + np.arange(steps + 1) / rate)


def reference_frame(trajectory: Trajectory) -> pd.DataFrame:
    """The trajectory as the reference of a closed loop: index `time` s, columns qr_i and qdr_i."""
    columns = {f"qr_{i + 1}": q for i, q in enumerate(trajectory.q.T)}
    columns |= {f"qdr_{i + 1}": qd for i, qd in enumerate(trajectory.qd.T)}
    return pd.DataFrame(columns, index=pd.Index(trajectory.t, name="time"))


def check_limits(
    waypoints: Waypoints,
    limits: Limits,
    force: Callable[[np.ndarray, np.ndarray, np.ndarray], np.ndarray] | None = None,
    rate: float = 1000.0,
) -> None:
    """Refuse a trajectory that leaves its limits anywhere on a grid of `rate` Hz.

    force: (q, qd, qdd) each (N, n) → tau (N, n), the inverse model; needed where tau is limited.
    Raises DataError naming joint, time, value and limit; ConfigError where there is not one limit per joint.
    """
    motion = sample(waypoints, rate)
    signals = {"q": motion.q, "qd": motion.qd, "qdd": motion.qdd}
    if limits.tau is not None:
        if force is None:
            raise ConfigError("trajectory: a limit on tau needs the inverse model; give it, or leave the limit out")
        signals["tau"] = force(motion.q, motion.qd, motion.qdd)
    for name, values in signals.items():
        limit = getattr(limits, name)
        if limit is None:
            continue
        if len(limit) != values.shape[1]:
            raise ConfigError(f"limits of {name}: {len(limit)} for {values.shape[1]} joints; give one per joint")
        _check_limit(name, values, np.asarray(limit, float), motion.t)


def peaks(motion: Trajectory, tau: np.ndarray) -> np.ndarray:
    """The largest |q|, |qd|, |qdd|, |tau| (4, n) of a motion with its torque tau (N, n)."""
    return np.abs([motion.q, motion.qd, motion.qdd, tau]).max(axis=1)


def read_waypoints(path: str | os.PathLike) -> Waypoints:
    """Read way-points from a CSV file with the header `time [s], q_1 [rad], qd_1 [rad/s], qdd_1 [rad/s2], q_2 …`.

    Angles and lengths are converted to rad or m. Raises DataError naming file, column and row.
    """
    table, units = _split_headings(read_table(path, "csv"))
    joints = sum(bool(re.fullmatch(r"q_[1-9]\d*", name)) for name in table.columns)
    if not joints:
        raise DataError(f"{table.path}: no column `q_1 [rad]` or `q_1 [m]`; add the way-points of joint 1")
    unit = "rad" if _converts(units.get("q_1", ""), "rad") else "m"
    t = _column(table, units, "time", "s")
    values = [
        np.column_stack([_column(table, units, f"{name}_{i + 1}", unit + per) for i in range(joints)])
        for name, per in (("q", ""), ("qd", "/s"), ("qdd", "/s2"))
    ]
    if len(t) < 2:
        raise DataError(f"{table.path}: {len(t)} way-points; a trajectory needs at least 2")
    late = np.flatnonzero(np.diff(t) <= 0)
    if late.size:
        raise DataError(
            f"{table.path}: column `time`, row {table.row(late[0] + 1)}: {t[late[0] + 1]:g} s does not come "
            f"after {t[late[0]]:g} s; sort the way-points"
        )
    return Waypoints(t, *values, unit)


def write_waypoints(path: str | os.PathLike, waypoints: Waypoints) -> None:
    """Write way-points as `read_waypoints` reads them, whole or not at all. Raises OSError."""
    with replacing(Path(path)) as fresh:
        fresh.write_text(waypoints_text(waypoints), encoding="utf-8", newline="\n")


def waypoints_text(waypoints: Waypoints) -> str:
    """Way-points as CSV, a row per way-point."""
    names, columns = ["time [s]"], [waypoints.t]
    for i in range(waypoints.q.shape[1]):
        for name, per, values in (("q", "", waypoints.q), ("qd", "/s", waypoints.qd), ("qdd", "/s2", waypoints.qdd)):
            names.append(f"{name}_{i + 1} [{waypoints.unit}{per}]")
            columns.append(values[:, i])
    rows = [",".join(f"{value:.12g}" for value in row) for row in np.column_stack(columns)]
    return "\n".join([",".join(names), *rows]) + "\n"


def _polynomial(coefficients: np.ndarray, s: np.ndarray, order: int) -> np.ndarray:
    """The derivative of given order by s of the polynomials with coefficients (6, N, n), at s (N, 1), by Horner."""
    powers = np.arange(6)
    result = np.zeros(coefficients.shape[1:])
    for power in powers[: order - 1 if order else None : -1]:
        factor = np.prod(power - np.arange(order))
        result = result * s + factor * coefficients[power]
    return result


def _check_limit(name: str, values: np.ndarray, limit: np.ndarray, t: np.ndarray) -> None:
    beyond = np.argwhere(np.abs(values) > limit)
    if beyond.size:
        k, i = beyond[0]
        raise DataError(
            f"trajectory: joint {i + 1} at t = {t[k]:.3f} s has {name} = {values[k, i]:.4g}, its limit is "
            f"{limit[i]:.4g}; choose other way-points or wider limits"
        )


def _split_headings(table: Table) -> tuple[Table, dict[str, str]]:
    columns, units = {}, {}
    for heading, cells in table.columns.items():
        name, unit = split_heading(heading)
        if not unit:
            raise DataError(f"{table.path}: column `{heading}`, row 1: no unit; write `{heading} [unit]`")
        columns[name], units[name] = cells, unit
    return replace(table, columns=columns), units


def _column(table: Table, units: dict[str, str], name: str, unit: str) -> np.ndarray:
    values = table.column(name)
    try:
        return conversion(units[name], unit) * values
    except ConfigError as error:
        raise DataError(f"{table.path}: column `{name}`: {error}") from None


def _converts(unit: str, wanted: str) -> bool:
    try:
        conversion(unit, wanted)
    except ConfigError:
        return False
    return True
