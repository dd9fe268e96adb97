"""Panels over time of what moved: forces (Fig. 4), states measured and estimated (Figs. 5–12), the closed loop."""

from __future__ import annotations

import numpy as np

from pipeline.config import slug
from pipeline.report.panels import DASHED, POINTS, Line, Panel, line
from pipeline.report.run import Run, has, times, trusted
from pipeline.report.text import number, with_unit
from pipeline.units import unit_text

TIME = "Time in s"


def figure_title(figure: int | str | None, title: str) -> str:
    """`Fig. 13: ZZR1`, or the plain title where the reference has no such figure."""
    if figure is None:
        return title
    return f"{figure if isinstance(figure, str) else f'Fig. {figure}'}: {title}"


def force_panels(run: Run) -> list[Panel]:
    """The forces of the identification run, one panel per joint (the paper's Fig. 4)."""
    table = run.signals.get("identification")
    joints = [i for i in range(1, run.joints + 1) if has(table, f"tau_{i}")]
    return [_force(run, table, i) for i in joints]


def _force(run: Run, table, joint: int) -> Panel:
    tau = np.asarray(table[f"tau_{joint}"], float)
    curves = [line("recorded", times(table), tau, "measured")]
    if has(table, f"tau_true_{joint}"):
        curves.append(
            line("what the plant got", times(table), np.asarray(table[f"tau_true_{joint}"], float), "c2", hidden=True)
        )
    unit = unit_text(run.force_unit)
    noun = run.force.lower()
    return Panel(
        key=f"force-{joint}",
        title=figure_title(run.figures.get("torque"), f"{run.joint_name(joint)}, {noun}"),
        series=tuple(curves),
        x_label=TIME,
        y_label=with_unit(run.force, run.force_unit),
        link="identification",
        summary=f"Between {number(np.nanmin(tau), 3)} and {number(np.nanmax(tau), 3)} {unit},"
        f" RMS {number(_rms(tau), 3)} {unit}.",
        caption="Good: it uses the drive's range and changes sign often: friction and inertia can be told apart."
        " Bad: flat tops (saturation) or long rests.",
        note=_drawn(len(table)),
    )


def state_panels(run: Run, name: str) -> list[Panel]:
    """Position and velocity of every joint, measured against a filter's estimate (the paper's Figs. 5–8, 9–12)."""
    numbers = (run.figures.get(name) or {}).get("states") or []
    table, measured = run.table(name), run.signals.get("identification")
    panels = []
    for joint in range(1, run.joints + 1):
        for kind in ("q", "qd"):
            figure = numbers[len(panels)] if len(panels) < len(numbers) else None
            if has(table, f"{kind}_{joint}"):
                panels.append(_state(run, name, joint, kind, figure, measured))
    return panels


def _state(run: Run, name: str, joint: int, kind: str, figure: int | None, measured) -> Panel:
    table = run.table(name)
    word, unit = _words(run, kind)
    values = np.asarray(table[f"{kind}_{joint}"], float)
    sigma = table.get(f"sigma {kind}_{joint}")
    source = f"q_{joint}" if kind == "q" else f"qd_{joint} [filtered]"
    shown = "measured" if kind == "q" else "measured (zero-phase filter, differences)"
    curves, summary = [], f"No measured {word} beside it."
    if has(measured, source):
        reading = np.asarray(measured[source], float)
        curves.append(line(shown, times(measured), reading, "measured", wide=True))
        gap = values - np.interp(times(table), times(measured), reading)
        summary = f"RMS of estimated minus measured: {number(_rms(gap), 2)} {unit}."
    curves.append(line(name, times(table), values, run.colour(name), sigma))
    curves += _true(measured, f"{kind}_true_{joint}")
    return Panel(
        key=f"state-{slug(name)}-{kind}-{joint}",
        title=figure_title(figure, f"{run.joint_name(joint)}, {word}, {name}"),
        series=tuple(curves),
        x_label=TIME,
        y_label=f"{word.capitalize()} in {unit}" if unit else word.capitalize(),
        link="identification",
        summary=summary,
        caption=_state_caption(kind) + _band_note(run, name, sigma is not None),
        note=_drawn(len(table)),
    )


def _true(measured, column: str) -> list[Line]:
    if not has(measured, column):
        return []
    return [line("truth", times(measured), np.asarray(measured[column], float), "truth", dash=DASHED, hidden=True)]


def _state_caption(kind: str) -> str:
    if kind == "q":
        return "Good: one curve. Bad: an estimate that leaves the measurement, first at the turning points."
    return (
        "Good: the estimate follows the filtered derivative without lag."
        " Bad: noise that the filter should have removed, or a lag behind the measured curve."
    )


def _band_note(run: Run, name: str, banded: bool) -> str:
    if not banded:
        return ""
    if trusted(run.estimates[name]):
        return " The band is ±2σ."
    return " The band is ±2σ as the filter claims it; its tests do not support it."


def closed_loop_panels(run: Run, which: str) -> list[Panel]:
    """Measured against simulated closed loop, of the "identification" or "validation" run."""
    table = run.signals.get(f"closed_loop_{which}")
    if table is None:
        return []
    panels = []
    for joint in range(1, run.joints + 1):
        for kind in ("q", "qd", "tau"):
            column = f"{kind}_{joint}"
            if has(table, column, f"{column} [simulated]"):
                panels.append(_closed_loop(run, which, table, joint, kind))
    return panels


def _closed_loop(run: Run, which: str, table, joint: int, kind: str) -> Panel:
    word, unit = _words(run, kind)
    reading, simulated = (np.asarray(table[f"{kind}_{joint}{end}"], float) for end in ("", " [simulated]"))
    error = 100.0 * np.linalg.norm(_finite(reading - simulated)) / (np.linalg.norm(_finite(reading)) or np.nan)
    time = times(table)
    return Panel(
        key=f"loop-{which}-{kind}-{joint}",
        title=f"{run.joint_name(joint)}, {word}, {which} run",
        series=(
            line("measured", time, reading, "measured", wide=True),
            line("simulated closed loop", time, simulated, "c2"),
            line("difference", time, reading - simulated, "c4", hidden=True),
        ),
        x_label=TIME,
        y_label=f"{word.capitalize()} in {unit}" if unit else word.capitalize(),
        link="identification" if which == "identification" else "validation",
        summary=f"Relative difference {number(error, 3)} %.",
        caption="Plant and controller run as FMUs from the reference alone, with the identified parameters."
        " Good: one curve, and a difference without a pattern. Bad: a difference that follows the motion.",
        note=_drawn(len(table)),
    )


def _words(run: Run, kind: str) -> tuple[str, str]:
    unit = unit_text(run.position_unit)
    return {
        "q": ("position", unit),
        "qd": ("velocity", f"{unit}/s" if unit else ""),
        "tau": (run.force.lower(), unit_text(run.force_unit)),
    }[kind]


def _drawn(samples: int) -> str:
    return f"Drawn with the extremes of {samples:,} samples." if samples > POINTS else ""


def _finite(values: np.ndarray) -> np.ndarray:
    return values[np.isfinite(values)]


def _rms(values: np.ndarray) -> float:
    finite = _finite(np.asarray(values, float))
    return float(np.sqrt(np.mean(finite**2))) if len(finite) else float("nan")
