"""Modelica unit strings → exponents of the SI base units, with factor and offset (FMI 2.0.5, 2.2.3)."""

from __future__ import annotations

import re
from dataclasses import dataclass, field

BASE = ("kg", "m", "s", "A", "K", "mol", "cd", "rad")

# symbol: (factor, exponents)
DERIVED: dict[str, tuple[float, dict[str, int]]] = {
    "1": (1.0, {}),
    "g": (1e-3, {"kg": 1}),
    "N": (1.0, {"kg": 1, "m": 1, "s": -2}),
    "Pa": (1.0, {"kg": 1, "m": -1, "s": -2}),
    "J": (1.0, {"kg": 1, "m": 2, "s": -2}),
    "W": (1.0, {"kg": 1, "m": 2, "s": -3}),
    "V": (1.0, {"kg": 1, "m": 2, "s": -3, "A": -1}),
    "Ohm": (1.0, {"kg": 1, "m": 2, "s": -3, "A": -2}),
    "S": (1.0, {"kg": -1, "m": -2, "s": 3, "A": 2}),
    "C": (1.0, {"s": 1, "A": 1}),
    "F": (1.0, {"kg": -1, "m": -2, "s": 4, "A": 2}),
    "H": (1.0, {"kg": 1, "m": 2, "s": -2, "A": -2}),
    "Wb": (1.0, {"kg": 1, "m": 2, "s": -2, "A": -1}),
    "T": (1.0, {"kg": 1, "s": -2, "A": -1}),
    "Hz": (1.0, {"s": -1}),
    "deg": (0.017453292519943295, {"rad": 1}),
    "rev": (6.283185307179586, {"rad": 1}),
    "rpm": (0.10471975511965977, {"rad": 1, "s": -1}),
    "min": (60.0, {"s": 1}),
    "h": (3600.0, {"s": 1}),
    "d": (86400.0, {"s": 1}),
    "l": (1e-3, {"m": 3}),
    "bar": (1e5, {"kg": 1, "m": -1, "s": -2}),
    "t": (1e3, {"kg": 1}),
    "eV": (1.602176634e-19, {"kg": 1, "m": 2, "s": -2}),
    "degC": (1.0, {"K": 1}),
    "degF": (5 / 9, {"K": 1}),
}
OFFSETS = {"degC": 273.15, "degF": 459.67 * 5 / 9}
PREFIXES = {
    "da": 1e1, "Y": 1e24, "Z": 1e21, "E": 1e18, "P": 1e15, "T": 1e12, "G": 1e9, "M": 1e6, "k": 1e3, "h": 1e2,
    "d": 1e-1, "c": 1e-2, "m": 1e-3, "u": 1e-6, "n": 1e-9, "p": 1e-12, "f": 1e-15, "a": 1e-18,
}  # fmt: skip
FACTOR = re.compile(r"(1(?![\d])|[A-Za-z]+)([-+]?\d+)?")


@dataclass(frozen=True)
class Unit:
    """value in SI base units = factor · value + offset; exponents of the base units that differ from 0."""

    factor: float = 1.0
    offset: float = 0.0
    exponents: dict[str, int] = field(default_factory=dict)


def parse(text: str) -> Unit | None:
    """A unit such as `N.m.s/rad` or `kg.m2/s2` or `W/(m2.K)`; None where it is not understood.

    Grammar of the Modelica specification, chapter 19: factors joined by `.`, at most one `/`, the denominator one
    factor or in parentheses, exponents as plain digits. A second `/` or an unknown symbol is not understood.
    """
    numerator, slash, denominator = text.partition("/")
    if denominator.startswith("(") and denominator.endswith(")"):
        denominator = denominator[1:-1]
    elif "." in denominator:
        return None
    parts = [(numerator, 1)] + ([(denominator, -1)] if slash else [])
    factor, exponents, symbols = 1.0, dict.fromkeys(BASE, 0), []
    for part, sign in parts:
        for item in part.split("."):
            match = FACTOR.fullmatch(item)
            known = match and lookup(match.group(1))
            if not known:
                return None
            power = sign * int(match.group(2) or 1)
            symbols.append((match.group(1), power))
            factor *= known[0] ** power
            for base, exponent in known[1].items():
                exponents[base] += power * exponent
    offset = OFFSETS.get(text, 0.0)  # an offset makes sense for a temperature that stands alone
    return Unit(factor, offset, {base: exponent for base, exponent in exponents.items() if exponent})


def lookup(symbol: str) -> tuple[float, dict[str, int]] | None:
    """Factor and exponents of one symbol, with or without a prefix."""
    if symbol in BASE:
        return 1.0, {symbol: 1}
    if symbol in DERIVED:
        return DERIVED[symbol]
    for prefix, scale in PREFIXES.items():
        rest = symbol.removeprefix(prefix)
        if symbol.startswith(prefix) and rest not in ("", "1", "kg") and (rest in BASE or rest in DERIVED):
            factor, exponents = lookup(rest)
            return scale * factor, exponents
    return None


def per_second(text: str) -> str:
    """The unit of a derivative: `rad` → `rad/s`, `rad/s` → `rad/s2`, `m/V` → `m/(V.s)`."""
    numerator, slash, denominator = text.partition("/")
    if not slash:
        return f"{text}/s"
    if match := re.fullmatch(r"s(\d*)", denominator):
        return f"{numerator}/s{int(match.group(1) or 1) + 1}"
    return f"{numerator}/({denominator.strip('()')}.s)"
