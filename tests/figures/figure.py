"""One promised figure: what was asked, what was measured, whether it held."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Figure:
    """A row of the table that `make figures` prints; `held` follows from the numbers, never from the text."""

    name: str
    asked: str
    measured: str
    held: bool


def at_most(name: str, measured: float, limit: float) -> Figure:
    """measured ≤ limit."""
    return Figure(name, f"≤ {limit:g}", f"{measured:.3g}", bool(measured <= limit))


def at_least(name: str, measured: float, limit: float) -> Figure:
    """measured ≥ limit."""
    return Figure(name, f"≥ {limit:g}", f"{measured:.6g}", bool(measured >= limit))


def below(name: str, measured: float, limit: float) -> Figure:
    """measured < limit."""
    return Figure(name, f"< {limit:g}", f"{measured:.3g}", bool(measured < limit))


def between(name: str, low_measured: float, high_measured: float, low: float, high: float) -> Figure:
    """Both ends of what was measured lie within [low, high]."""
    measured = f"{low_measured:.4g}" if low_measured == high_measured else f"{low_measured:.3g} … {high_measured:.3g}"
    return Figure(name, f"{low:g} … {high:g}", measured, bool(low <= low_measured and high_measured <= high))


def yes(name: str, held: bool, measured: str, asked: str) -> Figure:
    """A yes-or-no figure."""
    return Figure(name, asked, measured, bool(held))
