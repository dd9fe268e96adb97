"""One figure of the benchmark: its value over the rounds, the bound that was asked for, whether it held."""

from __future__ import annotations

import math
from dataclasses import dataclass

from tests.benchmarks.turns import Spread


@dataclass(frozen=True)
class Figure:
    """name; value, the median, and low … high, the extremes over the rounds, in `unit` ("REF", what it is divided by).

    asked: "≤" or "≥" of `bound`, or "" for one that only informs.
    """

    name: str
    value: float
    low: float
    high: float
    unit: str
    asked: str = ""
    bound: float | None = None

    @property
    def held(self) -> bool:
        """Whether the value keeps its bound; one that is no number does not."""
        if not self.asked:
            return True
        return math.isfinite(self.value) and (
            self.value <= self.bound if self.asked == "≤" else self.value >= self.bound
        )

    @property
    def line(self) -> str:
        """The row of the table."""
        mark = ("held" if self.held else "MISSED") if self.asked else ""
        asked = f"{self.asked} {self.bound:.4g}" if self.asked else ""
        return f"  {mark:<7}{self.name:<58}{asked:>10}  {self.value:10.4g}   {self.low:.4g} … {self.high:.4g}"

    def entry(self) -> dict:
        """The figure as results.json holds it."""
        return {**vars(self), "held": self.held}


def at_most(name: str, value: Spread | float, unit: str, bound: float) -> Figure:
    """A figure that must not exceed its bound."""
    return _figure(name, value, unit, "≤", bound)


def at_least(name: str, value: Spread | float, unit: str, bound: float) -> Figure:
    """A figure that must reach its bound."""
    return _figure(name, value, unit, "≥", bound)


def information(name: str, value: Spread | float, unit: str) -> Figure:
    """A figure without a bound."""
    return _figure(name, value, unit, "", None)


def _figure(name: str, value: Spread | float, unit: str, asked: str, bound: float | None) -> Figure:
    s = value if isinstance(value, Spread) else Spread(float(value), float(value), float(value))
    return Figure(name, s.median, s.low, s.high, unit, asked, bound)
