"""The course of every parameter: filter against recursive least squares (Figs. 13–28), tunings, Euler against RK4."""

from __future__ import annotations

import numpy as np

from pipeline.config import slug
from pipeline.report.motion import TIME, figure_title
from pipeline.report.panels import Level, Line, Panel, line, settled_range
from pipeline.report.run import Run, has, ok, target, times, trusted
from pipeline.report.text import plus_minus, short, with_unit
from pipeline.units import unit_text

LIMIT = 1250


def parameter_panels(run: Run, name: str) -> list[Panel]:
    """One panel per parameter: this filter and the recursive least squares, each with its band."""
    numbers = (run.figures.get(name) or {}).get("parameters") or []
    figures = list(numbers) + [None] * len(run.parameters)
    together = [name, *run.by_method("RLS")]
    return [
        _panel(run, f"course-{slug(name)}-{i}", p, together, figure_title(figures[i], f"{p}, {name}"), CONVERGENCE)
        for i, p in enumerate(run.parameters)
        if has(run.table(name), f"theta {p}")
    ]


def tuning_panels(run: Run) -> list[Panel]:
    """One panel per parameter with every other filter (consistent tunings)."""
    return [
        _panel(run, f"tuning-{i}", p, run.other_filters, p, TUNINGS)
        for i, p in enumerate(run.parameters)
        if any(has(run.table(n), f"theta {p}") for n in run.other_filters)
    ]


def euler_pair(run: Run) -> tuple[str, str] | None:
    """The filter that steps by Euler and its twin that steps by RK4, where both have signals."""
    every = run.by_method("EKF")
    for name in every:
        if run.is_euler(name):
            stem = name.split()[0]
            twins = [n for n in every if n != name and n.split()[0] == stem and not run.is_euler(n)]
            known = [n for n in twins if run.estimates[n].get("tuning") == "known"]
            if known or twins:
                return name, (known or twins)[0]
    return None


def euler_panels(run: Run) -> list[Panel]:
    """One panel per parameter: the same filter with Euler (Eq. 13) and with RK4."""
    pair = euler_pair(run)
    if pair is None:
        return []
    return [
        _panel(run, f"euler-{i}", p, list(pair), p, EULER)
        for i, p in enumerate(run.parameters)
        if has(run.table(pair[0]), f"theta {p}")
    ]


CONVERGENCE = (
    "Good: both settle on the dashed line, the filter's band closing around it."
    " Bad: a drift that never settles, or a narrow band that leaves the line out."
)
TUNINGS = "Good: all end in one bundle on the dashed line. Bad: the end depends on the tuning or on the start value."
EULER = (
    "Good: both bands hold the dashed line. Bad: the Euler curve settles beside it with a narrow band:"
    " a bias of the time step that no amount of data removes."
)


def _panel(run: Run, key: str, parameter: str, names: list[str], title: str, caption: str) -> Panel:
    curves = [c for n in names if (c := _course(run, n, parameter)) is not None]
    about = run.parameters[parameter]
    levels = []
    aim = target(about)
    if aim:
        levels.append(Level(aim[0], (aim[1],)))
    if about.get("truth") is not None and about.get("a_priori") not in (None, about["truth"]):
        levels.append(Level("a priori", (float(about["a_priori"]),), "prior"))
    return Panel(
        key=key,
        title=title,
        series=(*curves, *levels),
        x_label=TIME,
        y_label=with_unit(parameter, about.get("unit", "")),
        link="identification",
        y_range=settled_range(curves, [y for level in levels for y in level.y]),
        summary=_ends(run, parameter, names, aim),
        caption=caption,
        note=_claims(run, names),
    )


def _course(run: Run, name: str, parameter: str) -> Line | None:
    table = run.table(name)
    if not has(table, f"theta {parameter}"):
        return None
    sigma = table.get(f"sigma {parameter}")
    colour = "c3" if run.is_euler(name) else run.colour(name)
    values = np.asarray(table[f"theta {parameter}"], float)
    return line(name, times(table), values, colour, sigma, limit=LIMIT)


def _ends(run: Run, parameter: str, names: list[str], aim: tuple[str, float] | None) -> str:
    ends = []
    for name in names:
        estimate = run.estimates[name]
        found = (estimate.get("parameters") or {}).get(parameter) or {}
        if not ok(estimate):
            ends.append(f"{name} failed")
        elif found.get("value") is not None:
            ends.append(f"{name} {plus_minus(found['value'], found.get('sigma'), run.resolution(parameter))}")
    aims = f"; {aim[0]} {short(aim[1])}" if aim else ""
    unit = unit_text(run.parameters[parameter].get("unit", ""))
    return f"At the end: {', '.join(ends)}{aims} {unit}".strip() + "."


def _claims(run: Run, names: list[str]) -> str:
    doubtful = [n for n in names if ok(run.estimates[n]) and not trusted(run.estimates[n])]
    if not doubtful:
        return "Bands are ±2σ."
    return f"Bands are ±2σ; that of {', '.join(doubtful)} is only claimed: σ is withheld."
