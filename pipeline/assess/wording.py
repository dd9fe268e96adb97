"""Numbers as a report prints them: no more figures than they carry."""

from __future__ import annotations

import math
from collections.abc import Sequence

from pipeline.units import unit_text


def figures(value: float, digits: int = 3) -> str:
    """At least `digits` significant figures, plain from 1e-4 to 1e6, a true minus: 0.0154, −3.42, 1235, 1.20e−07."""
    if not math.isfinite(value):
        return "not finite"
    if value == 0.0:
        return "0"
    exponent = math.floor(math.log10(abs(float(f"{value:.{digits - 1}e}"))))
    if not -5 < exponent < 6:
        return _minus(f"{value:.{digits - 1}e}")
    return _minus(f"{value:.{max(0, digits - 1 - exponent)}f}")


def with_sigma(value: float, sigma: float | None, unit: str = "") -> str:
    """value ± sigma, both cut at sigma's second significant figure: 3.4190 ± 0.0084 kg·m²; unit as in Modelica."""
    if sigma is None or not math.isfinite(sigma) or sigma <= 0.0:
        return f"{figures(value)} {unit_text(unit)}".rstrip()
    places = max(0, 1 - math.floor(math.log10(sigma)))
    return _minus(f"{value:.{places}f} ± {sigma:.{places}f} {unit_text(unit)}".rstrip())


def signed(value: float) -> str:
    """With its sign and two decimals: +0.22, −0.18; 0.00 without one."""
    text = f"{value:+.2f}"
    return _minus(text) if float(text) else "0.00"


def listed(names: Sequence[str]) -> str:
    """a; a and b; a, b and c."""
    names = list(names)
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} and {names[-1]}" if names else "none"


def times(ratio: float) -> str:
    """A ratio in words: "57 times", "1.6 times"."""
    return f"{figures(ratio, 2)} times"


def _minus(text: str) -> str:
    return text.replace("-", "−")
