"""Headings: name and unit, and what brackets and parentheses may hold instead."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pipeline.simulate.headings import split_heading


@pytest.mark.parametrize(
    ("heading", "name", "unit"),
    [
        ("q_1 [rad]", "q_1", "rad"),
        ("angle[deg]", "angle", "deg"),
        ("  motor   angle  [ deg ] ", "motor angle", "deg"),
        ("torque [N.m.s/(rad.s)]", "torque", "N.m.s/(rad.s)"),
        ("pos [counts]", "pos", "counts"),
        ("angle (deg)", "angle", "deg"),
        ("angle (filtered)", "angle (filtered)", ""),
        ("angle (2)", "angle (2)", ""),
        ("q[1]", "q[1]", ""),
        ("M[1,2]", "M[1,2]", ""),
        ("q[1] [rad]", "q[1]", "rad"),
        ("q_1", "q_1", ""),
        ("[rad]", "[rad]", ""),
        ("", "", ""),
    ],
)
def test_a_heading_is_a_name_and_a_unit(heading, name, unit):
    assert split_heading(heading) == (name, unit)


@given(st.text("abc_ ", min_size=1).map(lambda s: " ".join(s.split())), st.sampled_from(["rad", "N.m", "mm/s", "°"]))
def test_any_name_keeps_its_unit(name, unit):
    if name:
        assert split_heading(f"{name} [{unit}]") == (name, unit)
