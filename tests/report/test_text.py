"""Numbers and units as the page writes them."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pipeline.report.text import count, estimate, number, plus_minus, seconds, short, unit_text


@pytest.mark.parametrize(
    ("value", "shown"),
    [(3.4193, "3.419"), (-0.0066, "−0.006600"), (0, "0"), (None, "–"), (math.nan, "–"), (math.inf, "–")]
    + [(1e-9, "1.000e−9"), (123456.7, "123457"), (2.5e7, "2.500e7")],
)
def test_number(value, shown):
    assert number(value) == shown


@pytest.mark.parametrize(
    ("value", "sigma", "shown"),
    [(3.41934, 0.0084, "3.4193 ± 0.0084"), (95.108, 0.1085, "95.11 ± 0.11"), (203.5, 1.146, "203.5 ± 1.1")]
    + [(1234.0, 56.0, "1234 ± 56"), (3.2, None, "3.200"), (None, 0.1, "–"), (-0.0, 1.0, "−0.0 ± 1.0")],
)
def test_plus_minus(value, sigma, shown):
    assert plus_minus(value, sigma).startswith(shown)


@given(st.floats(-1e5, 1e5), st.floats(1e-6, 1e3))
def test_an_estimate_is_rounded_by_less_than_a_tenth_of_sigma(value, sigma):
    assert abs(float(estimate(value, sigma).replace("−", "-")) - value) <= 0.1 * sigma * (1 + 1e-9)


def test_units_times_and_counts():
    assert unit_text("N.m.s/rad") == "N·m·s/rad"
    assert unit_text("kg.m2") == "kg·m²"
    assert unit_text("rad/s2") == "rad/s²"
    assert unit_text("") == ""
    assert [seconds(v) for v in (0.0123, 0.34, 170, None)] == ["12 ms", "0.340 s", "170 s", "–"]
    assert [count(1, "check"), count(1200, "check")] == ["1 check", "1,200 checks"]
    assert short(-0.66) == "−0.66"
