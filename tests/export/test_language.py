"""Modelica constructs through Co-Simulation of a built FMU over one second, against values worked out by hand."""

import numpy as np
import pytest

from tests.export.language import archive_of

CASES = {
    "array in an if": (
        "Real x[2](start={0.3, 0.6}, each fixed=true); equation der(x) = if x[1] > 0.1 then {-1, -1} else {0, 1};",
        {"x[1]": 0.1, "x[2]": 1.2},
    ),
    "if in an if": (
        "Real x(start=0, fixed=true); Real y;"
        "equation der(x) = y; y = if x > 0.3 then (if x > 0.6 then 3 else 2) else 1;",
        {"x": 0.6 + 3 * (1 - 0.3 - 0.15)},
    ),
    "elseif": (
        "Real x(start=0, fixed=true); equation der(x) = if x < 0.3 then 1 elseif x < 0.6 then 2 else 3;",
        {"x": 0.6 + 3 * (1 - 0.3 - 0.15)},
    ),
    "a relation of integers": (
        "discrete Integer k(start=0, fixed=true); Real x(start=0, fixed=true);"
        "equation when sample(0, 0.25) then k = pre(k) + 1; end when; der(x) = if k == 2 then 1 else 0;",
        {"x": 0.25},
    ),
    "discrete arrays and their initial equation": (
        "parameter Real a=3; discrete Real d[2]; initial equation pre(d) = {a, 2*a};"
        "equation when sample(0, 0.25) then d = pre(d) + {1, 10}; end when;",
        {"d[1]": 7, "d[2]": 46},
    ),
    "two controllers in a row, one period": (
        "model J parameter Real Ts=0.1; input Real u; discrete output Real y(start=0, fixed=true);"
        "equation when sample(0, Ts) then y = pre(y) + u; end when; end J;"
        "parameter Real T=0.2; J a(Ts=T); J b(Ts=T); equation a.u = 1; b.u = a.y;",
        {"a.y": 5, "b.y": 15},
    ),
    "an event that an event brings about": (
        "Real x(start=0, fixed=true); discrete Real d(start=0, fixed=true); Real y=d + x;"
        "discrete Real e(start=0, fixed=true);"
        "equation der(x) = 1; when x > 0.5 then d = 10; end when; when y > 5 then e = pre(e) + 1; end when;",
        {"d": 10, "e": 1},
    ),
    "reinit again and again": (
        "Real x(start=0, fixed=true); equation der(x) = 1; when x > 0.3 then reinit(x, 0); end when;",
        {"x": 0.1},
    ),
    "noEvent guards a root": (
        "Real x(start=4, fixed=true); equation der(x) = -sqrt(noEvent(if x > 0 then x else 0));",
        {"x": 2.25},
    ),
    "inner and outer": (
        "model World parameter Real g=1; end World; model W outer World world; Real y=world.g*time; end W;"
        "inner World world(g=3); W w; Real z=w.y;",
        {"z": 3},
    ),
    "an array of components": (
        "model W parameter Real k=1; parameter Real c=0; Real x(start=c, fixed=true); equation der(x) = -k*x; end W;"
        "W w[3](k={1, 2, 3}, each c=7);",
        {f"w[{k}].x": 7 * np.exp(-k) for k in (1, 2, 3)},
    ),
    "an algorithm": ("Real y[3]; algorithm for i in 1:3 loop y[i] := i*time; end for;", {"y[3]": 3}),
}


@pytest.mark.parametrize("case", CASES)
def test_values_after_one_second(tmp_path, case):
    body, expected = CASES[case]
    with archive_of(tmp_path, f"model M {body} end M;").co_simulation() as instance:
        instance.step(0.0, 1.0)
        assert instance.get(*expected) == pytest.approx(list(expected.values()), abs=1e-9)
