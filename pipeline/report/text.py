"""Numbers and units as a reader wants them: digits that the uncertainty supports, a true minus, `N·m`."""

from __future__ import annotations

import math

from pipeline.units import unit_text

DASH = "–"


def number(value: float | None, digits: int = 4) -> str:
    """`value` with `digits` significant digits, without an exponent where that stays short; "–" for None."""
    if value is None or not math.isfinite(value):
        return DASH
    if value == 0:
        return "0"
    exponent = math.floor(math.log10(abs(value)))
    if -4 <= exponent < 6:
        return _minus(f"{value:.{max(0, digits - 1 - exponent)}f}")
    mantissa, power = f"{value:.{digits - 1}e}".split("e")
    return _minus(f"{mantissa}e{int(power)}")


def short(value: float | None, digits: int = 10) -> str:
    """A constant without trailing zeros, as it was printed or to `digits`: 0.51, 24, −0.66."""
    return DASH if value is None else _minus(f"{value:.{digits}g}")


def estimate(value: float | None, sigma: float | None) -> str:
    """`value` with as many decimals as two digits of `sigma` need."""
    if value is None or not sigma or not math.isfinite(sigma):
        return number(value)
    decimals = 1 - math.floor(math.log10(sigma))
    return _minus(f"{value:.{min(max(decimals, 0), 9)}f}")


def sigma_text(sigma: float | None) -> str:
    """A standard deviation with two significant digits."""
    return number(sigma, 2)


def plus_minus(value: float | None, sigma: float | None, resolution: float | None = None) -> str:
    """`3.4193 ± 0.0084`; where sigma is not known the value alone, with the digits of `resolution` if given."""
    return estimate(value, resolution) if not sigma else f"{estimate(value, sigma)} ± {sigma_text(sigma)}"


def with_unit(label: str, unit: str) -> str:
    """`label in unit` for an axis; the label alone without a unit."""
    return f"{label} in {unit_text(unit)}" if unit else label


def seconds(value: float | None) -> str:
    """A duration: 12 ms, 0.34 s, 170 s."""
    if value is None:
        return DASH
    return f"{number(1000 * value, 2)} ms" if value < 0.1 else f"{number(value, 3)} s"


def count(amount: int, noun: str) -> str:
    """`1 check`, `3 checks`."""
    return f"{amount:,} {noun}{'' if amount == 1 else 's'}"


def _minus(text: str) -> str:
    return text.replace("-", "−")
