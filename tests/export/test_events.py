"""Events through built FMUs: relations that switch, when-clauses, asserts; against closed forms."""

import numpy as np
import pytest
from fmpy import simulate_fmu
from fmpy.fmi1 import FMICallException

from tests.export.language import archive_of, integers

SWITCH = """
model M
  parameter Real level=0.5;
  Real x(start=1, fixed=true);
equation
  der(x) = if x > level then -1 else -0.5;
end M;
"""
BALL = """
model M
  parameter Real e=0.7;
  Real h(start=1, fixed=true);
  Real v(start=0, fixed=true);
  discrete Integer bounces(start=0, fixed=true);
equation
  der(h) = v;
  der(v) = -9.81;
  when h < 0 then
    reinit(v, -e*pre(v));
    bounces = pre(bounces) + 1;
  end when;
end M;
"""


def bounce(t: float, e: float = 0.7, g: float = 9.81) -> tuple[float, float, int]:
    """Height, velocity and number of bounces of a ball dropped from 1 m."""
    start, v, n = np.sqrt(2 / g), e * np.sqrt(2 * g), 1
    if t <= start:
        return 1 - g * t**2 / 2, -g * t, 0
    while t - start > 2 * v / g:
        start, v, n = start + 2 * v / g, e * v, n + 1
    return v * (t - start) - g * (t - start) ** 2 / 2, v - g * (t - start), n


@pytest.fixture(scope="module")
def ball(tmp_path_factory):
    archive = archive_of(tmp_path_factory.mktemp("ball"), BALL)
    yield archive
    archive.close()


@pytest.mark.parametrize("h", [0.02, 1.0])
def test_a_relation_in_an_equation_switches_where_it_should(tmp_path, h):
    archive = archive_of(tmp_path, SWITCH)
    with archive.co_simulation(level=0.123) as instance:
        for k in range(round(1 / h)):
            instance.step(k * h, h)
        assert instance.get("x") == pytest.approx(0.123 - 0.5 * (1.0 - 0.877), abs=1e-13)


def test_a_relation_stays_frozen_in_continuous_time_mode(tmp_path):
    archive = archive_of(tmp_path, SWITCH)
    with archive.model_exchange() as instance:
        assert instance.rhs(0.0, [0.4]) == -1.0
        instance.event()
        assert instance.rhs(0.0, [0.4]) == -0.5


@pytest.mark.parametrize("h", [0.01, 0.37])
def test_the_bouncing_ball_in_co_simulation(ball, h):
    with ball.co_simulation() as instance:
        for k in range(round(1.85 / h)):
            instance.step(k * h, h)
            height, velocity, n = bounce((k + 1) * h)
            assert instance.get("h", "v") == pytest.approx([height, velocity], abs=2e-12)
            assert integers(instance, "bounces") == [n]


def test_the_bouncing_ball_in_model_exchange(ball):
    result = simulate_fmu(
        str(ball.path), fmi_type="ModelExchange", stop_time=1.5, relative_tolerance=1e-9, output=["h", "bounces"]
    )
    assert result["h"][-1] == pytest.approx(bounce(1.5)[0], abs=1e-5)
    assert result["bounces"][-1] == bounce(1.5)[2]


def test_a_when_clause_on_a_relation_an_elsewhen_and_a_boolean_equation(tmp_path):
    text = """
    model M
      Real x(start=1, fixed=true);
      discrete Real d(start=0, fixed=true);
      Boolean high;
      discrete Integer which(start=0, fixed=true);
    equation
      der(x) = if high then -1 else -0.5;
      high = x > 0.5;
      when x < 0.3 then
        d = pre(d) + 1;
        which = 1;
      elsewhen x < 0.6 then
        d = pre(d) + 10;
        which = 2;
      end when;
    end M;
    """
    with archive_of(tmp_path, text).co_simulation() as instance:
        seen = []
        for k in range(10):
            instance.step(k * 0.1, 0.1)
            seen.append((*instance.get("d"), *integers(instance, "which")))
        assert seen == [(0, 0)] * 4 + [(10, 2)] * 5 + [(11, 1)]
        assert instance.get("x") == pytest.approx(0.25, abs=1e-12)


def test_a_when_clause_on_a_boolean_variable_acts_when_it_becomes_true(tmp_path):
    text = """
    model M
      Real x(start=1, fixed=true);
      Boolean low;
      Boolean high(start=false, fixed=true);
      discrete Integer k(start=0, fixed=true);
      discrete Integer lows(start=0, fixed=true);
      discrete Integer highs(start=0, fixed=true);
      discrete Integer changes(start=0, fixed=true);
    equation
      der(x) = -1;
      low = x < 0.5;
      high = x > 0.5;
      when low then
        lows = pre(lows) + 1;
      end when;
      when high then
        highs = pre(highs) + 1;
      end when;
      when sample(0.05, 0.3) then
        k = pre(k) + 2;
      end when;
      when change(k) then
        changes = pre(changes) + 1;
      end when;
    end M;
    """
    with archive_of(tmp_path, text).co_simulation() as instance:
        instance.step(0.0, 0.8)
        assert integers(instance, "lows", "highs", "k", "changes") == [1, 0, 6, 3]


def test_when_initial_and_branches_in_a_when_body(tmp_path):
    text = """
    model M
      input Real u;
      discrete Real x;
      discrete output Real y(start=0, fixed=true);
      discrete Real first(start=0, fixed=true);
    initial equation
      pre(x) = 3;
    equation
      when sample(0, 0.1) then
        x = if u > 0.5 then pre(x) + 1 else pre(x) - 1;
        if x > 4.5 then
          y = x;
        elseif x > 3.5 then
          y = -x;
        else
          y = pre(y);
        end if;
      end when;
      when initial() then
        first = 42;
      end when;
    end M;
    """
    with archive_of(tmp_path, text).co_simulation(u=1.0) as instance:
        assert instance.get("first", "x") == pytest.approx([42, 3])
        rows = []
        for k, u in enumerate([1.0, 1.0, 0.0, 0.0]):
            instance.set(u=u)
            instance.step(k * 0.1, 0.1)
            rows.append(instance.get("x", "y"))
        assert np.array(rows).tolist() == [[4, -4], [5, 5], [4, -4], [3, -4]]


def test_an_assert_stops_the_simulation_with_its_message(tmp_path, capfd):
    text = """
    model M
      Real x(start=1, fixed=true);
    equation
      der(x) = -1;
      assert(x > 0.5, "x is too small");
    end M;
    """
    with archive_of(tmp_path, text).co_simulation() as instance:
        instance.step(0.0, 0.4)
        with pytest.raises(FMICallException):
            instance.step(0.4, 0.4)
    assert "at time 0.5 s: x is too small" in capfd.readouterr().out


def test_relations_that_never_settle_are_an_error(tmp_path):
    text = """
    model M
      Real x(start=0, fixed=true);
    equation
      der(x) = if x > 0 then -1 else 1;
    end M;
    """
    with archive_of(tmp_path, text).co_simulation() as instance, pytest.raises(FMICallException):
        instance.step(0.0, 1.0)


TIMED = """
model M
  parameter Real t0=0.3;
  Real x(start=0, fixed=true);
  discrete Real n(start=0.2345, fixed=true);
equation
  der(x) = if time - t0 > 0.25 then 1 else 0;
  when time >= pre(n) then
    n = pre(n) + 0.4;
  end when;
end M;
"""


@pytest.mark.parametrize("interface", ["co_simulation", "model_exchange"])
def test_a_model_with_no_other_event_has_that_of_its_initialisation(tmp_path, interface):
    text = """model M Real x(start=1, fixed=true); equation der(x) = 0;
      when initial() then reinit(x, 3*pre(x)); end when; end M;"""
    with getattr(archive_of(tmp_path, text), interface)() as instance:
        assert instance.get("x") == [3.0]


def test_a_time_event_is_announced_and_met(tmp_path):
    with archive_of(tmp_path, TIMED).model_exchange(t0=0.1234) as instance:
        announced = [instance.next_event]
        while instance.next_event < 1.2:
            instance.rhs(instance.next_event, [0.0])
            announced.append(instance.event())
        assert announced == pytest.approx([0.2345, 0.3734, 0.6345, 1.0345, 1.4345])
        assert instance.rhs(1.3, [0.0]) == 1.0


def test_time_events_under_an_integrator_of_model_exchange(tmp_path):
    result = simulate_fmu(
        str(archive_of(tmp_path, TIMED).path),
        fmi_type="ModelExchange",
        stop_time=1.0,
        start_values={"t0": 0.1234},
        output=["x", "n"],
        relative_tolerance=1e-10,
    )
    assert [result["x"][-1], result["n"][-1]] == pytest.approx([1 - 0.3734, 1.0345], abs=1e-9)
