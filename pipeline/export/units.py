"""Units of the model description: what a Modelica unit string means, where it is understood, and per second."""

from __future__ import annotations

import re

from pipeline import units
from pipeline.errors import ConfigError


def parse(text: str) -> units.Unit | None:
    """A unit such as `N.m.s/rad` or `W/(m2.K)` in SI base units (FMI 2.0.5, 2.2.2); None where it is not understood.

    Any text may stand in Modelica's `unit`: FMI wants such a unit by its name alone, so this is no error.
    """
    try:
        return units.parse(text)
    except ConfigError:
        return None


def per_second(text: str) -> str:
    """The unit of a derivative: `rad` → `rad/s`, `rad/s` → `rad/s2`, `m/V` → `m/(V.s)`."""
    numerator, slash, denominator = text.partition("/")
    if not slash:
        return f"{text}/s"
    if match := re.fullmatch(r"s(\d*)", denominator):
        return f"{numerator}/s{int(match.group(1) or 1) + 1}"
    return f"{numerator}/({denominator.strip('()')}.s)"
