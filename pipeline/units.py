"""Units as engineers write them: `N.m.s/rad`, `deg/s`, `mN.m`, `rpm`, `µs`; converted by a factor.

A unit is a product of symbols with prefixes and exponents, and at most one `/` (Modelica Language Specification
3.6, chapter 19; FMI 2.0.5, section 2.2.2). The radian is kept as a dimension, so `1/s` is not `rad/s`.
"""

from __future__ import annotations

import re
from functools import cache
from math import pi

from pipeline.errors import ConfigError

BASE = ("kg", "m", "s", "A", "K", "rad")
PREFIXES = {"n": 1e-9, "u": 1e-6, "m": 1e-3, "c": 1e-2, "d": 1e-1, "k": 1e3, "M": 1e6}

# symbol: (factor to SI, exponents of BASE); those in PREFIXED may carry one of PREFIXES
PREFIXED: dict[str, tuple[float, tuple[int, ...]]] = {
    "g": (1e-3, (1, 0, 0, 0, 0, 0)),
    "m": (1.0, (0, 1, 0, 0, 0, 0)),
    "s": (1.0, (0, 0, 1, 0, 0, 0)),
    "A": (1.0, (0, 0, 0, 1, 0, 0)),
    "rad": (1.0, (0, 0, 0, 0, 0, 1)),
    "N": (1.0, (1, 1, -2, 0, 0, 0)),
    "Nm": (1.0, (1, 2, -2, 0, 0, 0)),
    "V": (1.0, (1, 2, -3, -1, 0, 0)),
    "W": (1.0, (1, 2, -3, 0, 0, 0)),
    "J": (1.0, (1, 2, -2, 0, 0, 0)),
    "Pa": (1.0, (1, -1, -2, 0, 0, 0)),
    "Hz": (1.0, (0, 0, -1, 0, 0, 0)),
    "ohm": (1.0, (1, 2, -3, -2, 0, 0)),
    "H": (1.0, (1, 2, -2, -2, 0, 0)),
}
SYMBOLS: dict[str, tuple[float, tuple[int, ...]]] = PREFIXED | {
    "1": (1.0, (0, 0, 0, 0, 0, 0)),
    "%": (0.01, (0, 0, 0, 0, 0, 0)),
    "K": (1.0, (0, 0, 0, 0, 1, 0)),
    "min": (60.0, (0, 0, 1, 0, 0, 0)),
    "h": (3600.0, (0, 0, 1, 0, 0, 0)),
    "deg": (pi / 180.0, (0, 0, 0, 0, 0, 1)),
    "°": (pi / 180.0, (0, 0, 0, 0, 0, 1)),
    "rev": (2.0 * pi, (0, 0, 0, 0, 0, 1)),
    "rpm": (2.0 * pi / 60.0, (0, 0, -1, 0, 0, 1)),
    "Ncm": (1e-2, (1, 2, -2, 0, 0, 0)),
}
_FACTOR = re.compile(r"(1|[^\W\d_]+|%|°)(?:\^?([+-]?\d+))?")
_SPELLING = str.maketrans({"µ": "u", "μ": "u", "Ω": "ohm", "·": ".", "*": ".", "⋅": ".", "²": "2", "³": "3"})


def unit_text(unit: str) -> str:
    """A Modelica unit for reading: `N.m.s/rad` → `N·m·s/rad`, `kg.m2` → `kg·m²`."""
    unit = unit or ""
    return re.sub(r"(?<=[a-z])([23])", lambda m: "²³"[int(m[1]) - 2], unit.replace(".", "·"))


def conversion(unit: str, wanted: str) -> float:
    """The factor f with value [wanted] = f · value [unit]; ConfigError where a unit is unknown or does not convert."""
    (factor, dimension), (wanted_factor, wanted_dimension) = parse(unit), parse(wanted)
    if dimension != wanted_dimension:
        raise ConfigError(
            f"unit `{unit}` does not convert to `{wanted}`; {_spell(dimension)} is not {_spell(wanted_dimension)}"
        )
    return factor / wanted_factor


@cache
def parse(unit: str) -> tuple[float, tuple[int, ...]]:
    """A unit as (factor to SI, exponents of BASE); ConfigError that names the part that is not known."""
    unit = " ".join(unit.split())
    numerator, slash, denominator = unit.translate(_SPELLING).partition("/")
    bare = denominator.removeprefix("(").removesuffix(")")
    if (slash and not bare) or "/" in bare or ("." in bare and bare == denominator):
        raise ConfigError(f"unit `{unit}` is not understood; write one `/`, and a product below it in brackets")
    terms = [(text, 1) for text in numerator.split(".")] + [(text, -1) for text in bare.split(".") if slash]
    factor, dimension = 1.0, (0,) * len(BASE)
    for text, sign in terms:
        symbol_factor, symbol_dimension, power = _term(text, unit)
        factor *= symbol_factor ** (sign * power)
        dimension = tuple(d + sign * power * e for d, e in zip(dimension, symbol_dimension, strict=True))
    return factor, dimension


def _term(text: str, unit: str) -> tuple[float, tuple[int, ...], int]:
    match = _FACTOR.fullmatch(text.strip())
    if match:
        symbol, power = match[1], int(match[2] or 1)
        if symbol in SYMBOLS:
            return *SYMBOLS[symbol], power
        if symbol[0] in PREFIXES and symbol[1:] in PREFIXED:
            factor, dimension = PREFIXED[symbol[1:]]
            return PREFIXES[symbol[0]] * factor, dimension, power
    raise ConfigError(
        f"unit `{unit}` is unknown at `{text}`; known symbols: {', '.join(SYMBOLS)}, with prefixes {' '.join(PREFIXES)}"
    )


def _spell(dimension: tuple[int, ...]) -> str:
    powers = [f"{name}{power if power != 1 else ''}" for name, power in zip(BASE, dimension, strict=True) if power]
    return ".".join(powers) or "1"
