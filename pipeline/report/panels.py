"""Plots as plain data, independent of any plot library: a panel is a set of series, its axes and its words.

The page carries each panel as a small JSON description and each array once, as base64 of float32; `plots.js` draws
them with BokehJS, `print.js` as SVG for paper. Another library takes their place there, and nothing here changes.
"""

from __future__ import annotations

import base64
import hashlib
from dataclasses import dataclass, field

import numpy as np

from pipeline.report.html import Html, tag

DASHED = (5, 4)  # px drawn, px left out
POINTS = 2600  # a run of 25 s at 100 Hz is drawn sample by sample


@dataclass(frozen=True)
class Line:
    """A curve: x (N,), y (N,), and where given half (N,), the half width of a band around it (2 sigma).

    colour names a `--c-…` colour of style.css; `hidden` starts it switched off in the legend; `wide`: it
    lies under another that is expected to cover it; dash: px drawn and left out in turn, () for a solid line.
    """

    label: str
    x: np.ndarray
    y: np.ndarray
    colour: str
    half: np.ndarray | None = None
    dash: tuple[int, ...] = ()
    hidden: bool = False
    wide: bool = False


@dataclass(frozen=True)
class Level:
    """Horizontal lines under one name: a truth, a limit, the two bounds of a band."""

    label: str
    y: tuple[float, ...]
    colour: str = "truth"


@dataclass(frozen=True)
class Bars:
    """Bars of a histogram or a correlogram: centres x (K,), heights y (K,), one width."""

    label: str
    x: np.ndarray
    y: np.ndarray
    width: float
    colour: str


@dataclass(frozen=True)
class Panel:
    """One plot with its words.

    `link` names the group of panels whose x ranges move together ("" for none); `log`: x on a logarithmic axis;
    `summary` says in numbers what is seen, `caption` what good and bad look like; `table` (head, rows) holds the
    numbers where they are few.
    """

    key: str
    title: str
    series: tuple[Line | Level | Bars, ...]
    x_label: str
    y_label: str
    summary: str
    caption: str
    link: str = ""
    y_range: tuple[float, float] | None = None
    table: tuple[tuple[str, ...], list[tuple[str, ...]]] | None = None
    note: str = ""
    log: bool = False


@dataclass
class Store:
    """The page's arrays, each kept once, and the descriptions of its panels in order."""

    arrays: dict[str, str] = field(default_factory=dict)
    panels: list[dict] = field(default_factory=list)
    _names: dict[bytes, str] = field(default_factory=dict)

    def put(self, values: np.ndarray) -> str:
        """The name under which `values` (N,) stand in the page as little-endian float32."""
        data = np.ascontiguousarray(values, dtype="<f4").tobytes()
        digest = hashlib.sha256(data).digest()
        if digest not in self._names:
            name = self._names[digest] = f"a{len(self.arrays)}"
            self.arrays[name] = base64.b64encode(data).decode()
        return self._names[digest]

    def add(self, panel: Panel) -> Html:
        """Register a panel and return its element: legend, plot, words."""
        self.panels.append(
            {
                "key": panel.key,
                "link": panel.link,
                "log": panel.log,
                "x": panel.x_label,
                "y": panel.y_label,
                "range": list(map(float, panel.y_range)) if panel.y_range else None,
                "series": [self._series(s) for s in panel.series],
            }
        )
        return _figure(panel)

    def _series(self, series: Line | Level | Bars) -> dict:
        shown = {"kind": type(series).__name__.lower(), "label": series.label, "colour": series.colour}
        if isinstance(series, Level):
            return shown | {"y": [float(y) for y in series.y]}
        shown |= {"x": self.put(series.x), "y": self.put(series.y)}
        if isinstance(series, Bars):
            return shown | {"width": float(series.width)}
        shown |= {"dash": list(series.dash), "hidden": series.hidden, "wide": series.wide}
        return shown if series.half is None else shown | {"half": self.put(series.half)}


def _figure(panel: Panel) -> Html:
    name = f"p-{panel.key}"
    keys = [_legend_key(i, s) for i, s in enumerate(panel.series)]
    return tag(
        "figure",
        tag("h4", panel.title, id=f"{name}-t"),
        tag("div", keys, class_="legend", role="group", aria_label="Series, press to hide or show"),
        tag(
            "div",
            class_="plot",
            id=name,
            tabindex="0",
            role="img",
            aria_label=f"{panel.title}. {panel.summary} Arrow keys move, plus and minus zoom, 0 shows all.",
        ),
        _data_table(panel),
        tag("figcaption", tag("b", panel.summary), " ", panel.caption, f" {panel.note}" if panel.note else None),
        class_="panel",
        role="group",
        aria_labelledby=f"{name}-t",
    )


def _legend_key(index: int, series: Line | Level | Bars) -> Html:
    return tag(
        "button",
        _swatch(series),
        series.label,
        tag("span", class_="readout", aria_hidden="true"),
        type="button",
        class_="key",
        title="Click to hide or show",
        style=f"--c:var(--c-{series.colour})",
        data_series=str(index),
        aria_pressed="false" if getattr(series, "hidden", False) else "true",
    )


def _swatch(series: Line | Level | Bars) -> Html:
    """The series as its legend shows it: solid, in a band, or in its own dashes."""
    dash = DASHED if isinstance(series, Level) else getattr(series, "dash", ())
    if dash:
        stroke = tag("path", d="M0 1H18", stroke_dasharray=" ".join(map(str, dash)))
        return tag("svg", stroke, viewBox="0 0 18 2", class_="dashes", aria_hidden="true")
    return tag("span", class_="swatch" + (" banded" if getattr(series, "half", None) is not None else ""))


def _data_table(panel: Panel) -> Html | None:
    if panel.table is None:
        return None
    head, rows = panel.table
    body = [tag("tr", [tag("td", cell) for cell in row]) for row in rows]
    return tag(
        "details",
        tag("summary", "The numbers"),
        tag("div", tag("table", tag("tr", [tag("th", h, scope="col") for h in head]), body), class_="scroll"),
        class_="numbers",
    )


def thin(time: np.ndarray, values: np.ndarray, limit: int = POINTS) -> tuple[np.ndarray, np.ndarray]:
    """At most `limit` points of a curve (N,) that keep the extremes: of each bin its minimum and its maximum.

    The two stand at the bin's first and middle sample, in the order in which they came, so that all curves over the
    same `time` share one time axis; a point is off by at most half a bin.
    """
    if len(time) <= limit:
        return time, values
    size = _bin(len(values), limit)
    table = np.pad(values, (0, -len(values) % size), mode="edge").reshape(-1, size)
    low = np.where(np.isfinite(table), table, np.inf).argmin(axis=1)
    high = np.where(np.isfinite(table), table, -np.inf).argmax(axis=1)
    order = np.sort(np.column_stack([low, high]), axis=1)
    return time[places(len(time), limit)], np.take_along_axis(table, order, axis=1).ravel()


def places(samples: int, limit: int = POINTS) -> np.ndarray:
    """The indices that `thin` keeps on the time axis: the first and the middle sample of each bin."""
    if samples <= limit:
        return np.arange(samples)
    size = _bin(samples, limit)
    first = np.arange(0, samples, size)
    return np.column_stack([first, np.minimum(first + size // 2, samples - 1)]).ravel()


def _bin(samples: int, limit: int) -> int:
    """Samples per bin, two points of which are kept."""
    return -(-samples // (limit // 2))


def line(
    label: str, time: np.ndarray, values: np.ndarray, colour: str, sigma: np.ndarray | None = None, **more
) -> Line:
    """A thinned curve over time with its ±2 sigma band where sigma (N,) is given; `limit` bounds the points."""
    limit = more.pop("limit", POINTS)
    x, y = thin(np.asarray(time, float), np.asarray(values, float), limit)
    half = None if sigma is None else 2.0 * np.asarray(sigma, float)[places(len(time), limit)]
    return Line(label, x, y, colour, half, **more)


def settled_range(lines: list[Line], levels: list[float], skip: float = 0.15) -> tuple[float, float] | None:
    """A y range that shows where curves settle: all of it after the first part, and of the start what lies near."""
    late = [ln.y[int(skip * len(ln.y)) :] for ln in lines]
    ends = [ln.y[-1] + s * ln.half[-1] for ln in lines if ln.half is not None and len(ln.y) for s in (-1, 1)]
    core = np.concatenate([*late, np.array(ends, float), np.array(levels, float)])
    core = core[np.isfinite(core)]
    if not len(core):
        return None
    low, high = float(core.min()), float(core.max())
    span = (high - low) or abs(high) or 1.0
    early = np.concatenate([ln.y for ln in lines])
    early = np.clip(early[np.isfinite(early)], low - span, high + span)
    low, high = min(low, float(early.min())), max(high, float(early.max()))
    return low - 0.06 * span, high + 0.06 * span
