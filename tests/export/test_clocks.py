"""Sample instants through built FMUs: when a controller ticks, and how often."""

import numpy as np
import pytest
from fmpy.fmi1 import FMICallException

from tests.export.language import archive_of, integers

INTEGRATOR = """
model M
  input Real u;
  output Real y(start=7, fixed=true);
  parameter Real period=0.1;
  discrete Integer n(start=0, fixed=true);
equation
  when sample(0, period) then
    y = pre(y) + u;
    n = pre(n) + 1;
  end when;
end M;
"""


@pytest.fixture(scope="module")
def integrator(tmp_path_factory):
    archive = archive_of(tmp_path_factory.mktemp("integrator"), INTEGRATOR)
    yield archive
    archive.close()


def test_a_controller_ticks_at_the_start_of_a_step(integrator):
    with integrator.co_simulation(u=1.0) as instance:
        assert instance.get("y") == 7
        instance.step(0.0, 0.1)
        assert instance.get("y") == 8
        assert instance.get("y") == 8


def test_a_second_step_from_the_same_instant_does_not_tick_again(integrator):
    with integrator.co_simulation(u=1.0) as instance:
        instance.step(0.0, 0.0)
        instance.set(u=5.0)
        instance.step(0.0, 0.1)
        assert instance.get("y") == 8


@pytest.mark.parametrize("h", [0.1, 0.05, 0.02, 0.3, 0.025])
def test_ticks_do_not_depend_on_the_communication_step(integrator, h):
    with integrator.co_simulation(u=1.0) as instance:
        steps = round(3.0 / h)
        for k in range(steps):
            instance.step(k * h, h)
        assert integers(instance, "n") == [30]


def test_ticks_stand_the_round_off_of_a_running_sum(integrator):
    with integrator.co_simulation(u=1.0, period=1e-3) as instance:
        t = 0.0
        for k in range(20000):
            instance.step(t, 1e-3)
            assert integers(instance, "n") == [k + 1]
            t += 1e-3


def test_a_long_period_does_not_tick_early(integrator):
    with integrator.co_simulation(u=1.0, period=100.0) as instance:
        for t in np.arange(0.0, 100.5, 0.25):
            instance.step(t, 0.25)
            assert integers(instance, "n") == [1 if t < 100.0 else 2]
        instance.step(100.5, 99.499)
        for k in range(4):
            instance.step(199.999 + k * 0.0005, 0.0005)
            assert integers(instance, "n") == [2 if k < 2 else 3]


def test_the_sample_period_can_be_set_before_the_initialisation_and_not_after(integrator):
    with integrator.co_simulation(u=1.0, period=0.25) as instance:
        instance.step(0.0, 1.0)
        assert integers(instance, "n") == [4]
        with pytest.raises(FMICallException):
            instance.set(period=0.5)


def test_clocks_of_a_late_start_begin_with_the_first_instant_that_is_left(integrator):
    with integrator.co_simulation(start=0.25, u=1.0) as instance:
        instance.step(0.25, 0.04)
        assert integers(instance, "n") == [0]
        instance.step(0.29, 0.31)
        assert integers(instance, "n") == [3]


def test_model_exchange_names_the_next_sample_instant(integrator):
    with integrator.event_mode(u=1.0) as instance:
        assert instance.get("y") == 7
        assert instance.settle() == pytest.approx(0.1)
        assert instance.get("y") == 8
        assert instance.settle() == pytest.approx(0.1)
        assert instance.get("y") == 8
        instance.fmu.enterContinuousTimeMode()
        instance.fmu.setTime(0.1)
        assert instance.event() == pytest.approx(0.2)
        assert instance.get("y") == 9


def test_two_clocks_tick_on_their_own_and_together(tmp_path):
    text = """
    model M
      discrete Real slow(start=0, fixed=true);
      discrete Real fast(start=0, fixed=true);
    equation
      when sample(0.05, 0.3) then
        slow = pre(slow) + 1;
      end when;
      when sample(0.05, 0.1) then
        fast = pre(fast) + 1;
      end when;
    end M;
    """
    with archive_of(tmp_path, text).co_simulation() as instance:
        instance.step(0.0, 0.75)
        assert instance.get("slow", "fast") == pytest.approx([3, 7])
