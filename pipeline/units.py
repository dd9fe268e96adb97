"""Units as engineers and Modelica write them: `N.m.s/rad`, `deg/s`, `mN.m`, `rpm`, `µs`; factors and SI exponents.

A unit is a product of symbols with prefixes and exponents, and at most one `/` (Modelica Language Specification
3.6, chapter 19; FMI 2.0.5, section 2.2.2). The radian is kept as a dimension, so `1/s` is not `rad/s`.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from functools import cache
from math import pi

from pipeline.errors import ConfigError

BASE = ("kg", "m", "s", "A", "K", "mol", "cd", "rad")
PREFIXES = {
    "da": 1e1, "Y": 1e24, "Z": 1e21, "E": 1e18, "P": 1e15, "T": 1e12, "G": 1e9, "M": 1e6, "k": 1e3, "h": 1e2,
    "d": 1e-1, "c": 1e-2, "m": 1e-3, "u": 1e-6, "n": 1e-9, "p": 1e-12, "f": 1e-15, "a": 1e-18,
}  # fmt: skip

# symbol: (factor, in what); those in PREFIXED may carry one of PREFIXES
PREFIXED: dict[str, tuple[float, str]] = {base: (1.0, base) for base in BASE if base != "kg"} | {
    "g": (1e-3, "kg"),
    "N": (1.0, "kg.m/s2"),
    "Nm": (1.0, "N.m"),
    "J": (1.0, "N.m"),
    "W": (1.0, "J/s"),
    "Pa": (1.0, "N/m2"),
    "bar": (1e5, "Pa"),
    "l": (1e-3, "m3"),
    "Hz": (1.0, "1/s"),
    "V": (1.0, "W/A"),
    "C": (1.0, "A.s"),
    "Ohm": (1.0, "V/A"),
    "ohm": (1.0, "V/A"),
    "S": (1.0, "A/V"),
    "F": (1.0, "C/V"),
    "Wb": (1.0, "V.s"),
    "T": (1.0, "Wb/m2"),
    "H": (1.0, "Wb/A"),
    "eV": (1.602176634e-19, "J"),
    "deg": (pi / 180.0, "rad"),
}
SYMBOLS: dict[str, tuple[float, str]] = PREFIXED | {
    "1": (1.0, ""),
    "%": (0.01, "1"),
    "kg": (1.0, "kg"),
    "t": (1e3, "kg"),
    "min": (60.0, "s"),
    "h": (3600.0, "s"),
    "d": (86400.0, "s"),
    "°": (pi / 180.0, "rad"),
    "rev": (2.0 * pi, "rad"),
    "rpm": (2.0 * pi / 60.0, "rad/s"),
    "Ncm": (1e-2, "N.m"),
    "degC": (1.0, "K"),
    "degF": (5 / 9, "K"),
}
OFFSETS = {"degC": 273.15, "degF": 459.67 * 5 / 9}
_FACTOR = re.compile(r"(1(?!\d)|[^\W\d_]+|%|°)(?:\^?([+-]?\d))?")
_BELOW = re.compile(r"\(([^()/]+)\)|([^()/.]+)")
_SPELLING = str.maketrans({"µ": "u", "μ": "u", "Ω": "Ohm", "·": ".", "*": ".", "⋅": ".", "²": "2", "³": "3"})


@dataclass(frozen=True)
class Unit:
    """value in SI base units = factor · value + offset; exponents of the base units that differ from 0."""

    factor: float = 1.0
    offset: float = 0.0
    exponents: dict[str, int] = field(default_factory=dict)


def unit_text(unit: str) -> str:
    """A Modelica unit for reading: `N.m.s/rad` → `N·m·s/rad`, `kg.m2` → `kg·m²`."""
    unit = unit or ""
    return re.sub(r"(?<=[a-z])([23])", lambda m: "²³"[int(m[1]) - 2], unit.replace(".", "·"))


def conversion(unit: str, wanted: str) -> float:
    """The factor f with value [wanted] = f · value [unit]; ConfigError where a unit is unknown or does not convert."""
    given, target = parse(unit), parse(wanted)
    if given.exponents != target.exponents:
        raise ConfigError(f"unit `{unit}` does not convert to `{wanted}`; {_spell(given)} is not {_spell(target)}")
    if given.offset != target.offset:
        raise ConfigError(f"unit `{unit}` does not convert to `{wanted}` by a factor; write the values in `{wanted}`")
    return given.factor / target.factor


@cache
def parse(unit: str) -> Unit:
    """A unit's factor, offset and exponents; ConfigError that names the part that is not known."""
    unit = " ".join(unit.split())
    numerator, slash, denominator = unit.translate(_SPELLING).partition("/")
    below = _BELOW.fullmatch(denominator)
    if slash and not below:
        raise ConfigError(f"unit `{unit}` is not understood; write one `/`, and a product below it in brackets")
    terms = [(text, 1) for text in numerator.split(".")]
    terms += [(text, -1) for text in (below[1] or below[2]).split(".")] if below else []
    factor, exponents = 1.0, dict.fromkeys(BASE, 0)
    for text, sign in terms:
        symbol, power = _term(text, unit)
        factor *= symbol.factor ** (sign * power)
        for base, exponent in symbol.exponents.items():
            exponents[base] += sign * power * exponent
    offset = OFFSETS.get(unit, 0.0)  # only of a temperature that stands alone
    return Unit(factor, offset, {base: exponent for base, exponent in exponents.items() if exponent})


def _term(text: str, unit: str) -> tuple[Unit, int]:
    match = _FACTOR.fullmatch(text.strip())
    symbol = _symbol(match[1]) if match else None
    if symbol is None:
        known = f"known symbols: {', '.join(SYMBOLS)}, with prefixes {' '.join(PREFIXES)}"
        raise ConfigError(f"unit `{unit}` is unknown at `{text}`; {known}")
    return symbol, int(match[2] or 1)


def _symbol(name: str) -> Unit | None:
    """One symbol, with or without a prefix."""
    if name in BASE:
        return Unit(exponents={name: 1})
    if name in SYMBOLS:
        factor, meaning = SYMBOLS[name]
        meant = parse(meaning) if meaning else Unit()
        return Unit(factor * meant.factor, 0.0, meant.exponents)
    for prefix, scale in PREFIXES.items():
        if name.startswith(prefix) and name[len(prefix) :] in PREFIXED:
            meant = _symbol(name[len(prefix) :])
            return Unit(scale * meant.factor, 0.0, meant.exponents)
    return None


def _spell(unit: Unit) -> str:
    return ".".join(f"{name}{power if power != 1 else ''}" for name, power in unit.exponents.items()) or "1"
