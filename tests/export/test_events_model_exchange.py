"""State events under fmpy's CVode, in both FMI versions, against closed forms: no root may leave a relation stale."""

import numpy as np
import pytest
from fmpy import simulate_fmu

from pipeline.export.build import export
from pipeline.export.catalogue import Recipe
from tests.export.language import archive_of, model_of, write_fmu

BALL = """
model Ball
  parameter Real e=0.8;
  Real h(start=1, fixed=true);
  Real v(start=0, fixed=true);
  Integer n(start=0, fixed=true);
  Boolean low = h < 0.5;
  Real below(start=0, fixed=true);
equation
  der(h) = v;
  der(v) = -9.81;
  der(below) = if low then 1 else 0;
  when h < 0 and v < 0 then
    reinit(v, -e*pre(v));
    n = pre(n) + 1;
  end when;
end Ball;
"""
TWO_POINT = """
model TwoPoint
  Real x(start=1, fixed=true);
  Boolean on(start=true, fixed=true);
equation
  der(x) = if on then -x else 0.5;
  when x < 0.5 then
    on = false;
  elsewhen x > 0.9 then
    on = true;
  end when;
end TwoPoint;
"""
RAMP = """
model M
  Real x(start={start}, fixed=true);
  Real y(start=0, fixed=true);
  Boolean b = x {operator} 0.5;
equation
  der(x) = {slope};
  der(y) = if b then 1 else 0;
end M;
"""


def time_below(stop: float, level: float = 0.5, e: float = 0.8, g: float = 9.81) -> float:
    """How long a ball dropped from 1 m is below a level, whose bounces all reach it."""
    total, start, v = 0.0, np.sqrt(2 * (1 - level) / g), e * np.sqrt(2 * g)
    end = np.sqrt(2 / g)
    while end < stop:
        total += end - start
        rises = (v - np.sqrt(max(v**2 - 2 * g * level, 0))) / g
        apex_above = v**2 / (2 * g) > level
        total += min(rises if apex_above else 2 * v / g, stop - end)
        start = end + ((v + np.sqrt(v**2 - 2 * g * level)) / g if apex_above else 2 * v / g)
        end, v = end + 2 * v / g, e * v
    return total + max(stop - start, 0)


def two_point(t: np.ndarray) -> np.ndarray:
    """x of TwoPoint: 1 → 0.5 by e^-t, then up to 0.9 with slope 0.5 and down by e^-t again and again."""
    up, down = 0.8, np.log(0.9 / 0.5)
    phase = (t - np.log(2)) % (up + down)
    later = np.where(phase < up, 0.5 + 0.5 * phase, 0.9 * np.exp(-(phase - up)))
    return np.where(t < np.log(2), np.exp(-t), later)


def built(folder, text, model):
    """{FMI version: file} of a model in a text."""
    (folder / f"{model}.mo").write_text(text)
    files = {version: folder / f"{model}_{version}.fmu" for version in "23"}
    export(folder / f"{model}.mo", Recipe(model, {}), files)
    return files


@pytest.fixture(scope="module")
def balls(tmp_path_factory):
    return built(tmp_path_factory.mktemp("balls"), BALL, "Ball")


@pytest.fixture(scope="module")
def switches(tmp_path_factory):
    return built(tmp_path_factory.mktemp("switches"), TWO_POINT, "TwoPoint")


def run(path, tolerance, step, stop, *output):
    options = {"relative_tolerance": tolerance, "output_interval": step, "stop_time": stop, "output": output}
    return simulate_fmu(str(path), fmi_type="ModelExchange", **options)


@pytest.mark.parametrize("version", ["2", "3"])
@pytest.mark.parametrize(("tolerance", "step"), [(1e-5, 0.01), (1e-7, 1e-3), (1e-9, 1e-3), (1e-9, 0.01), (1e-9, 0.03)])
def test_no_crossing_of_a_bouncing_ball_is_lost(balls, version, tolerance, step):
    result = run(balls[version], tolerance, step, 3.0, "below", "n")
    assert result["n"][-1] == 6
    assert result["below"][-1] == pytest.approx(time_below(3.0), abs=max(2e-8, 20 * tolerance))


@pytest.mark.parametrize("version", ["2", "3"])
@pytest.mark.parametrize(("tolerance", "step"), [(1e-5, 0.1), (1e-7, 0.01), (1e-9, 1e-3), (1e-9, 0.1)])
def test_a_two_point_controller_never_stays_on_its_branch(switches, version, tolerance, step):
    result = run(switches[version], tolerance, step, 10.0, "x")
    assert result["x"] == pytest.approx(two_point(result["time"]), abs=100 * tolerance)


@pytest.mark.parametrize("operator", ["<", "<=", ">", ">="])
@pytest.mark.parametrize("slope", [1, -1])
def test_every_relation_switches_at_a_root_that_is_exact(tmp_path, operator, slope):
    path = write_fmu(
        model_of(tmp_path, RAMP.format(start=0.5 - slope, operator=operator, slope=slope)), tmp_path / "M.fmu"
    )
    result = run(path, 1e-9, 0.25, 2.0, "y")
    assert result["y"][-1] == pytest.approx(1, abs=1e-9)


@pytest.mark.parametrize("operator", ["<", "<=", ">", ">="])
@pytest.mark.parametrize("slope", [1, -1])
def test_a_relation_that_starts_at_zero_switches_as_it_leaves(tmp_path, operator, slope):
    path = write_fmu(model_of(tmp_path, RAMP.format(start=0.5, operator=operator, slope=slope)), tmp_path / "M.fmu")
    true = operator.startswith("<") == (slope < 0)
    assert run(path, 1e-9, 0.25, 2.0, "y")["y"][-1] == pytest.approx(2.0 * true, abs=1e-9)


def test_the_hysteresis_follows_the_nominal_value(tmp_path):
    text = (
        "model M Real x(start=0, fixed=true, nominal=1e-6); Real y=if x > 0 then 1 else 0; equation der(x) = 1; end M;"
    )
    with archive_of(tmp_path, text, fmi="3").model_exchange() as instance:
        assert instance.get("'event indicator 1'") == pytest.approx([-1e-18], rel=1e-12, abs=0)


def test_a_discrete_variable_without_relations_follows_a_parameter_at_an_event(tmp_path):
    text = (
        "model M parameter Real p=1; Integer k=integer(2*p); Real x(start=0, fixed=true); equation der(x) = k; end M;"
    )
    with archive_of(tmp_path, text).model_exchange() as instance:
        before = instance.rhs(0.0, [0.0])
        instance.event(p=2.0)
        assert [*before, *instance.rhs(0.0, [0.0])] == [2.0, 4.0]
