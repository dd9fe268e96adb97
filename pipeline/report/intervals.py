"""The interval plot: for each parameter all estimates ±2 sigma side by side, as SVG made here."""

from __future__ import annotations

import math
from collections.abc import Callable

from pipeline.report.html import Html, tag
from pipeline.report.run import Run, ok, target, trusted
from pipeline.report.text import number, plus_minus
from pipeline.units import unit_text

PLOT, ROW, TOP, FOOT = 140, 18, 8, 26
CHARACTER, GAP = 5.9, 6  # of a tick's label


def interval_plots(run: Run) -> Html:
    """One small plot per parameter, each with its caption."""
    return tag("div", [_figure(run, p) for p in run.parameters], class_="intervals")


def _figure(run: Run, parameter: str) -> Html:
    about = run.parameters[parameter]
    rows = [(n, e, (e.get("parameters") or {}).get(parameter) or {}) for n, e in run.estimates.items()]
    aim = target(about)
    unit = unit_text(about.get("unit", ""))
    return tag(
        "figure",
        tag("h4", parameter, tag("small", f" in {unit}" if unit else "")),
        tag("div", _svg(parameter, rows, aim, run.resolution(parameter)), class_="scroll"),
        class_="interval",
        role="group",
        aria_label=f"{parameter}: every estimate with ±2σ",
    )


def _svg(parameter: str, rows: list, aim: tuple[str, float] | None, resolution: float | None) -> Html:
    low, high = _range(rows, aim)
    left = 16 + 6.6 * max(len(name) for name, _, _ in rows)
    texts = [_text(e, p, resolution) for _, e, p in rows]
    height = TOP + ROW * len(rows) + FOOT

    def x(value: float) -> float:
        return round(left + PLOT * (value - low) / (high - low), 2)

    base = TOP + ROW * len(rows)
    parts = [tag("line", class_="axis", x1=f"{left:g}", x2=f"{left + PLOT:g}", y1=base, y2=base)]
    parts += [_tick(v, x(v), base) for v in _ticks(low, high)]
    if aim:
        parts.append(tag("line", class_="aim", x1=x(aim[1]), x2=x(aim[1]), y1=2, y2=base))
    parts += [_row(row, texts[k], TOP + ROW * (k + 0.5), left, x, low, high) for k, row in enumerate(rows)]
    label = f"Interval plot of {parameter}; " + "; ".join(f"{n} {t}" for (n, _, _), t in zip(rows, texts, strict=True))
    width = left + PLOT + 16 + 7 * max(len(t) for t in texts)
    return tag("svg", parts, viewBox=f"0 0 {width:g} {height}", width=f"{width:g}", role="img", aria_label=label)


def _row(row: tuple, text: str, y: float, left: float, x: Callable[[float], float], low: float, high: float) -> Html:
    name, estimate, parameter = row
    kind = (estimate.get("method") or "").lower()
    parts = [tag("text", name, x=f"{left - 10:g}", y=y + 4, class_="name")]
    value, sigma = parameter.get("value"), parameter.get("sigma")
    if ok(estimate) and value is not None:
        if value < low or value > high:
            edge, step = (left, 7) if value < low else (left + PLOT, -7)
            parts.append(tag("path", class_="out", d=f"M{edge:g} {y}l{step} -4v8z"))
        else:
            if sigma:
                ends = [x(min(max(value + s * sigma, low), high)) for s in (-2, 2)]
                parts.append(tag("line", class_="bar", x1=ends[0], x2=ends[1], y1=y, y2=y))
            parts.append(tag("circle", cx=x(value), cy=y, r=3.2, class_="dot" if trusted(estimate) else "dot hollow"))
    parts.append(tag("text", text, x=f"{left + PLOT + 10:g}", y=y + 4, class_="value"))
    return tag("g", parts, class_=f"row {kind}" if kind.isalpha() else "row")


def _text(estimate: dict, parameter: dict, resolution: float | None) -> str:
    if not ok(estimate):
        return "failed"
    if parameter.get("value") is None:
        return "not estimated"
    return plus_minus(parameter["value"], parameter.get("sigma"), resolution)


def _tick(value: float, x: float, base: float) -> Html:
    return tag("g", tag("path", d=f"M{x} {base}v4"), tag("text", _shown(value), x=x, y=base + 17), class_="tick")


def _shown(value: float) -> str:
    text = number(value, 6)
    return text.rstrip("0").rstrip(".") if "." in text else text


def _range(rows: list, aim: tuple[str, float] | None) -> tuple[float, float]:
    """A range around the truth that shows most intervals whole; what lies outside becomes an arrow at the edge."""
    found = [(p["value"], 2 * (p.get("sigma") or 0.0)) for _, e, p in rows if ok(e) and p.get("value") is not None]
    if not found:
        return (aim[1] - 1.0, aim[1] + 1.0) if aim else (-1.0, 1.0)
    values = sorted(v for v, _ in found)
    centre = aim[1] if aim else values[len(values) // 2]
    reach = sorted(abs(v - centre) + half for v, half in found)
    half = 1.25 * reach[min(len(reach) - 1, math.ceil(0.6 * len(reach)))]
    half = half or abs(centre) or 1.0
    return centre - half, centre + half


def _ticks(low: float, high: float, wanted: int = 4) -> list[float]:
    """Round values inside the range, about `wanted` of them, or every second while their labels would touch."""
    raw = (high - low) / wanted
    power = 10.0 ** math.floor(math.log10(raw))
    step = next(m * power for m in (1, 2, 5, 10) if m * power >= raw)
    ticks = [k * step for k in range(math.ceil(low / step), math.floor(high / step) + 1)]
    while len(ticks) > 1 and _widest(ticks) > PLOT * (ticks[1] - ticks[0]) / (high - low):
        ticks = ticks[::2]
    return ticks


def _widest(ticks: list[float]) -> float:
    return GAP + CHARACTER * max(len(_shown(v)) for v in ticks)
