"""Numbers in words: figures that they carry, no more."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pipeline.assess.wording import figures, listed, times, with_sigma


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (3.419, "3.42"),
        (0.015432, "0.0154"),
        (57.2, "57.2"),
        (1234.6, "1235"),
        (-0.68, "−0.680"),
        (0.0, "0"),
        (1.2e-7, "1.20e−07"),
        (9.996, "10.0"),
        (float("nan"), "not finite"),
    ],
)
def test_figures(value, text):
    assert figures(value) == text


@given(st.floats(-1e9, 1e9).filter(lambda x: abs(x) > 1e-12))
def test_figures_keep_the_value_to_half_a_percent(value):
    assert math.isclose(float(figures(value).replace("−", "-")), value, rel_tol=5e-3)


@pytest.mark.parametrize(
    ("arguments", "text"),
    [
        ((3.4191, 0.0084, "kg.m2"), "3.4191 ± 0.0084 kg·m²"),
        ((203.52, 1.146), "203.5 ± 1.1"),
        ((20345.6, 114.6, "N"), "20346 ± 115 N"),
        ((3.4191, None, "kg"), "3.42 kg"),
        ((3.4191, float("nan")), "3.42"),
    ],
)
def test_with_sigma_stops_at_its_second_figure(arguments, text):
    assert with_sigma(*arguments) == text


def test_lists_and_ratios():
    assert [listed(x) for x in ([], ["a"], ["a", "b"], ["a", "b", "c"])] == ["none", "a", "a and b", "a, b and c"]
    assert times(170 / 3) == "57 times"
