"""Panels that test the estimates: prediction on the other trajectory, residuals, innovations."""

from __future__ import annotations

from itertools import cycle

import numpy as np

from pipeline.config import slug
from pipeline.report.motion import TIME
from pipeline.report.panels import DASHED, Bars, Level, Panel, line
from pipeline.report.run import FILTER_COLOURS, Run, has, times
from pipeline.report.text import number, with_unit
from pipeline.signals.correlation import autocorrelation
from pipeline.units import unit_text

LAGS = 20
BINS = 31


def prediction_panels(run: Run) -> list[Panel]:
    """The validation run's force beside what the estimates predict, and the difference, per joint."""
    table = run.signals.get("validation")
    panels = []
    for joint in range(1, run.joints + 1):
        names = [n for n in run.estimates if has(table, f"tau_{joint}", f"tau_{joint} [{n}]")]
        if names:
            panels += [_prediction(run, table, joint, names), _error(run, table, joint, names)]
    return panels


def _prediction(run: Run, table, joint: int, names: list[str]) -> Panel:
    reading = np.asarray(table[f"tau_{joint}"], float)
    curves = [line("measured", times(table), reading, "measured", wide=True)]
    shown = _shown(run, names)
    for n, colour in _colours(names, shown).items():
        values = np.asarray(table[f"tau_{joint} [{n}]"], float)
        curves.append(line(n, times(table), values, colour, hidden=n != shown))
    return Panel(
        key=f"prediction-{joint}",
        title=f"{run.joint_name(joint)}, {run.force.lower()} predicted",
        series=tuple(curves),
        x_label=TIME,
        y_label=with_unit(run.force, run.force_unit),
        link="validation",
        summary=_error_words(run, joint, names),
        caption="A trajectory that no estimate has seen. Good: one curve. Bad: an offset, or too small at the peaks.",
    )


def _error(run: Run, table, joint: int, names: list[str]) -> Panel:
    reading = np.asarray(table[f"tau_{joint}"], float)
    shown = _shown(run, names)
    curves = []
    for n, colour in _colours(names, shown).items():
        gap = reading - np.asarray(table[f"tau_{joint} [{n}]"], float)
        curves.append(line(n, times(table), gap, colour, hidden=n != shown))
    rms = {n: float(np.sqrt(np.nanmean((reading - np.asarray(table[f"tau_{joint} [{n}]"])) ** 2))) for n in names}
    return Panel(
        key=f"prediction-error-{joint}",
        title=f"{run.joint_name(joint)}, measured minus predicted",
        series=(*curves, Level("zero", (0.0,))),
        x_label=TIME,
        y_label=with_unit(run.force, run.force_unit),
        link="validation",
        summary=f"RMS with {shown}: {number(rms[shown], 3)} {unit_text(run.force_unit)}.",
        caption="Good: noise without a pattern. Bad: steps where the velocity changes sign (friction),"
        " or a copy of the acceleration (inertia).",
    )


def _colours(names: list[str], shown: str) -> dict[str, str]:
    """A colour for each estimate, the one shown at first in that of the least squares."""
    others = [n for n in names if n != shown]
    return {shown: "wls"} | dict(zip(others, cycle(("ekf", *FILTER_COLOURS)), strict=False))


def _shown(run: Run, names: list[str]) -> str:
    return run.recommended if run.recommended in names else names[0]


def _error_words(run: Run, joint: int, names: list[str]) -> str:
    validation = run.record.get("validation") or {}
    name, key = _shown(run, names), f"tau_{joint}"
    error = ((validation.get("validation") or {}).get(name) or {}).get(key)
    floor = (validation.get("noise_floor") or {}).get(key)
    floors = f"; the {run.floor_name} is {number(floor, 3)} %" if floor is not None else ""
    return f"Relative error of {name}: {number(error, 3)} %{floors}."


def residual_panels(run: Run, name: str) -> list[Panel]:
    """Residuals of a batch estimate: over time, as a histogram, and their autocorrelation, per joint."""
    table = run.table(name)
    if not has(table, "joint", "residual"):
        return []
    panels = []
    for joint in sorted(int(j) for j in table["joint"].unique()):
        rows = table[table["joint"] == joint]
        residual = np.asarray(rows["residual"], float)
        if np.isfinite(residual).sum() > 2:
            base = f"residual-{slug(name)}-{joint}", f"{run.joint_name(joint)}, residual of {name}"
            panels.append(_over_time(run, base, times(rows), residual))
            panels.append(_histogram(run, base, residual))
            panels.append(_correlogram(base, residual))
    return panels


def _over_time(run: Run, base: tuple[str, str], time: np.ndarray, residual: np.ndarray) -> Panel:
    return Panel(
        key=base[0],
        title=base[1],
        series=(line("residual", time, residual, "wls"), Level("zero", (0.0,))),
        x_label=TIME,
        y_label=with_unit("Residual", run.force_unit),
        link="identification",
        summary=f"RMS {number(float(np.sqrt(np.nanmean(residual**2))), 3)} {unit_text(run.force_unit)}.",
        caption="Good: an even band of noise around zero. Bad: bursts, a trend, or the shape of the motion.",
    )


def _histogram(run: Run, base: tuple[str, str], residual: np.ndarray) -> Panel:
    values = residual[np.isfinite(residual)]
    spread = values.std() or 1.0
    edges = np.linspace(-4 * spread, 4 * spread, BINS + 1) + values.mean()
    heights, _ = np.histogram(values, edges)
    centres = (edges[:-1] + edges[1:]) / 2
    width = float(edges[1] - edges[0])
    x = np.linspace(edges[0], edges[-1], 121)
    bell = len(values) * width * np.exp(-0.5 * ((x - values.mean()) / spread) ** 2) / (spread * np.sqrt(2 * np.pi))
    kurtosis = float(np.mean(((values - values.mean()) / spread) ** 4)) - 3.0
    return Panel(
        key=f"{base[0]}-h",
        title=f"{base[1]}, histogram",
        series=(Bars("residual", centres, heights.astype(float), width, "wls"), line("normal", x, bell, "truth")),
        x_label=with_unit("Residual", run.force_unit),
        y_label="Samples",
        summary=f"{len(values):,} samples, {len(values) - heights.sum()} of them beyond ±4σ,"
        f" excess kurtosis {number(kurtosis, 3)} (normal: 0).",
        caption="Good: the bars follow the curve. Bad: long tails (outliers, friction reversals) or two humps.",
    )


def _correlogram(base: tuple[str, str], values: np.ndarray) -> Panel:
    values = values[np.isfinite(values)]
    r = autocorrelation(values, min(LAGS, len(values) // 4))
    bound = 1.96 / np.sqrt(len(values))
    outside = 100.0 * float(np.mean(np.abs(r) > bound)) if len(r) else 0.0
    lags = np.arange(1, len(r) + 1, dtype=float)
    return Panel(
        key=f"{base[0]}-a",
        title=f"{base[1]}, autocorrelation",
        series=(Bars("autocorrelation", lags, r, 0.6, "wls"), Level("95 % bounds", (-bound, bound))),
        x_label="Lag in samples",
        y_label="Correlation",
        y_range=_correlation_range(r, bound),
        summary=f"{number(outside, 2)} % of {len(r)} lags outside ±{number(bound, 2)}; white noise has 5 %.",
        caption="Good: nearly all bars inside. Bad: neighbours that stand out together: the model misses something"
        " that moves, or the samples are not independent, and then σ claims too much.",
        table=(("Lag", "Correlation"), [(str(k + 1), number(float(v), 3)) for k, v in enumerate(r)]),
    )


def _correlation_range(r: np.ndarray, bound: float) -> tuple[float, float]:
    low, high = min([-bound, *r]), max([bound, *r])
    return low - 0.12 * (high - low), high + 0.12 * (high - low)


def innovation_panels(run: Run, name: str) -> list[Panel]:
    """A filter's innovations with ±2 √S and their autocorrelation per joint, and its NIS."""
    table = run.table(name)
    panels = []
    for joint in range(1, run.joints + 1):
        if has(table, f"innovation_{joint}"):
            panels += _innovation(run, name, table, joint)
    if has(table, "NIS"):
        panels.append(_nis(run, name, table))
    return panels


def _innovation(run: Run, name: str, table, joint: int) -> list[Panel]:
    base = f"innovation-{slug(name)}-{joint}", f"{run.joint_name(joint)}, innovation of {name}"
    values = np.asarray(table[f"innovation_{joint}"], float)
    sigma = np.sqrt(np.asarray(table[f"S_{joint}"], float)) if has(table, f"S_{joint}") else None
    curves = [line("innovation", times(table), values, run.colour(name), limit=1250)]
    inside = ""
    if sigma is not None:
        for sign, label in ((2, "2√S expected"), (-2, "−2√S")):
            curves.append(line(label, times(table), sign * sigma, "truth", limit=1250, dash=DASHED))
        inside = f" {number(100 * float(np.nanmean(np.abs(values) <= 2 * sigma)), 3)} % inside ±2√S, 95 % are expected."
    rms = float(np.sqrt(np.nanmean(values**2)))
    over_time = Panel(
        key=base[0],
        title=base[1],
        series=tuple(curves),
        x_label=TIME,
        y_label=with_unit("Innovation", run.position_unit),
        link="identification",
        y_range=(-5 * rms, 5 * rms) if rms > 0 else None,
        summary=f"RMS {number(rms, 3)} {unit_text(run.position_unit)}.{inside}",
        caption="Good: noise that fills the band. Bad: far inside it (R or Q too large), outside it (too small),"
        " or a course that follows the motion (model error).",
    )
    return [over_time, _correlogram(base, values if sigma is None else values / sigma)]


def _nis(run: Run, name: str, table, block: int = 100) -> Panel:
    """Means of NIS over blocks, with the 95 % band of such a mean, and one."""
    nis, time = np.asarray(table["NIS"], float), times(table)
    blocks = max(1, len(nis) // block)
    mean = np.array([np.nanmean(part) if len(part) else np.nan for part in np.array_split(nis, blocks)])
    centre = np.array([part.mean() for part in np.array_split(time, blocks)])
    size = max(1, len(nis) // blocks)
    low, high = nis_band(run.joints, size)
    test = (run.estimates[name].get("tests") or {}).get("NIS") or {}
    overall = test.get("mean") if test.get("mean") is not None else float(np.nanmean(nis))
    top = max(1.15 * high, min(float(np.nanmax(mean)), 3 * high))
    return Panel(
        key=f"nis-{slug(name)}",
        title=f"NIS of {name}",
        series=(
            line(f"mean of {size} samples", centre, mean, run.colour(name)),
            Level("expected", (float(run.joints),)),
            Level("95 % band", (low, high), "prior"),
        ),
        x_label=TIME,
        y_label="NIS",
        link="identification",
        y_range=(-0.06 * top, 1.08 * top),
        summary=f"Mean {number(overall, 3)} where {run.joints} is expected{_nis_band_words(test)}.",
        caption="Normalised innovation squared. Good: inside the band all along. Bad: far below it (the filter is told"
        " of more noise than there is, its σ is too large) or above it (too little, its σ is too small).",
    )


def _nis_band_words(test: dict) -> str:
    if test.get("low") is None or test.get("high") is None:
        return ""
    return f"; band of the whole run {number(test['low'], 3)} to {number(test['high'], 3)}"


def nis_band(joints: int, samples: int) -> tuple[float, float]:
    """The 95 % band of the mean of `samples` chi-square variables of `joints` degrees each (Wilson–Hilferty)."""
    degrees = joints * samples
    spread = 2.0 / (9.0 * degrees)
    return tuple(joints * (1.0 - spread + z * np.sqrt(spread)) ** 3 for z in (-1.96, 1.96))
