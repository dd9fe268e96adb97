"""Units in SI base units, as FMI wants them: known units, the grammar by property tests."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pipeline.export.units import parse, per_second
from pipeline.units import BASE, SYMBOLS, Unit

KNOWN = {
    "N.m": Unit(1.0, 0.0, {"kg": 1, "m": 2, "s": -2}),
    "N.m.s/rad": Unit(1.0, 0.0, {"kg": 1, "m": 2, "s": -1, "rad": -1}),
    "rad/s2": Unit(1.0, 0.0, {"s": -2, "rad": 1}),
    "kg.m2": Unit(1.0, 0.0, {"kg": 1, "m": 2}),
    "W/(m2.K)": Unit(1.0, 0.0, {"kg": 1, "s": -3, "K": -1}),
    "N/V": Unit(1.0, 0.0, {"m": -1, "s": 1, "A": 1}),
    "1": Unit(),
    "1/s": Unit(1.0, 0.0, {"s": -1}),
    "m.s-1": Unit(1.0, 0.0, {"m": 1, "s": -1}),
    "deg": Unit(math.pi / 180, 0.0, {"rad": 1}),
    "degC": Unit(1.0, 273.15, {"K": 1}),
    "min": Unit(60.0, 0.0, {"s": 1}),
    "ohm": Unit(1.0, 0.0, {"kg": 1, "m": 2, "s": -3, "A": -2}),
    "Ohm": Unit(1.0, 0.0, {"kg": 1, "m": 2, "s": -3, "A": -2}),
    "F": Unit(1.0, 0.0, {"kg": -1, "m": -2, "s": 4, "A": 2}),
    "T": Unit(1.0, 0.0, {"kg": 1, "s": -2, "A": -1}),
    "mol": Unit(1.0, 0.0, {"mol": 1}),
}


@pytest.mark.parametrize("text", KNOWN)
def test_known_units(text):
    assert parse(text) == KNOWN[text]


@pytest.mark.parametrize("text, factor", [("mm", 1e-3), ("km/h", 1 / 3.6), ("kN", 1e3), ("mrad/ms", 1.0), ("ug", 1e-9)])
def test_prefixes(text, factor):
    assert parse(text).factor == pytest.approx(factor, rel=1e-15)


@pytest.mark.parametrize("text", ["", "foo", "m/s/s", "m..s", "N m", "m/", "/s", "kkg", "W/m2.K", "2m", "m/(s"])
def test_what_is_no_unit_is_not_understood(text):
    assert parse(text) is None


symbols = st.sampled_from(sorted({*BASE, *SYMBOLS} - {"1", "degC", "degF"}))
powers = st.integers(-3, 3).filter(bool)


@given(st.lists(st.tuples(symbols, powers), min_size=1, max_size=4))
def test_a_product_has_the_sum_of_the_exponents_and_the_product_of_the_factors(items):
    unit = parse(".".join(f"{name}{power}" for name, power in items))
    alone = [(parse(name), power) for name, power in items]
    assert unit.factor == pytest.approx(math.prod(u.factor**power for u, power in alone), rel=1e-12)
    total = {base: sum(power * u.exponents.get(base, 0) for u, power in alone) for base in BASE}
    assert unit.exponents == {base: exponent for base, exponent in total.items() if exponent}


@given(st.lists(st.tuples(symbols, powers), min_size=1, max_size=3), symbols)
def test_dividing_by_a_unit_and_multiplying_by_it_cancel(items, divisor):
    text = ".".join(f"{name}{power}" for name, power in items)
    unit, back = parse(text), parse(f"{text}.{divisor}/{divisor}")
    assert back.exponents == unit.exponents
    assert back.factor == pytest.approx(unit.factor, rel=1e-12)


@given(st.text(max_size=12))
def test_any_text_is_a_unit_or_none(text):
    assert parse(text) is None or set(parse(text).exponents) <= set(BASE)


@given(st.sampled_from(["rad", "rad/s", "rad/s2", "m/V", "W/(m2.K)", "N.m", "1"]))
def test_the_unit_of_a_derivative_is_the_unit_per_second(text):
    unit, derivative = parse(text), parse(per_second(text))
    assert derivative.exponents.get("s", 0) == unit.exponents.get("s", 0) - 1
    assert derivative.factor == unit.factor
