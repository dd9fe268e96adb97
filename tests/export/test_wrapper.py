"""The wrapper: the FMI calls around the equations, wrong ones included."""

import re
from ctypes import CDLL, byref, c_int, c_void_p
from pathlib import Path
from subprocess import run

import numpy as np
import pytest
from fmpy.fmi1 import FMICallException
from fmpy.fmi2 import FMU2Slave

from pipeline.export.build import WRAPPER
from tests.export.language import archive_of

OSCILLATOR = """
model M
  input Real u;
  parameter Real m=2;
  parameter Real k=50;
  parameter Real w2=k/m;
  parameter Real x_start=0.5;
  parameter Integer order=2;
  Real x(start=x_start, fixed=true);
  Real v(start=0.25, fixed=true);
  output Real energy=k*x^2/2 + m*v^2/2;
equation
  der(x) = v;
  der(v) = -w2*x + u/m;
end M;
"""


CODE = "".join(file.read_text() for file in sorted(WRAPPER.glob("fmi2_*.c")))
FUNCTIONS = re.findall(r"^fmi2Status (fmi2\w+)\(fmi2Component pointer", CODE, re.MULTILINE)
ERROR = 3


@pytest.fixture(scope="module")
def archive(tmp_path_factory):
    archive = archive_of(tmp_path_factory.mktemp("oscillator"), OSCILLATOR)
    yield archive
    archive.close()


@pytest.fixture(scope="module")
def library(archive):
    """The FMU's library by itself: functions that take whatever is given."""
    (path,) = Path(archive.folder).rglob("M.so")
    return CDLL(str(path))


def free(t, x0=0.5, v0=0.25, w=5.0):
    """Position and velocity of the free oscillator."""
    return [x0 * np.cos(w * t) + v0 / w * np.sin(w * t), v0 * np.cos(w * t) - w * x0 * np.sin(w * t)]


def test_runge_kutta_is_of_order_four(archive):
    errors = []
    for h in (0.02, 0.01):
        with archive.co_simulation(internalStep=h) as instance:
            instance.step(0.0, 1.0)
            errors.append(np.abs(instance.get("x", "v") - free(1.0)).max())
    assert errors[0] / errors[1] == pytest.approx(16.0, rel=0.1)


@pytest.mark.parametrize("h, n", [(0.01, 100), (0.03, 34), (0.0301, 34), (1.0, 1), (5.0, 1)])
def test_internal_steps_divide_the_communication_step_evenly(archive, h, n):
    A, x = np.array([[0.0, 1.0], [-25.0, 0.0]]) / n, np.array([0.5, 0.25])
    step = np.eye(2) + A @ (np.eye(2) + A / 2 @ (np.eye(2) + A / 3 @ (np.eye(2) + A / 4)))
    with archive.co_simulation(internalStep=h) as instance:
        instance.step(0.0, 1.0)
        assert instance.get("x", "v") == pytest.approx(np.linalg.matrix_power(step, n) @ x, rel=1e-12)


def test_a_tunable_parameter_reacts_in_co_simulation_and_what_follows_from_it(archive):
    with archive.co_simulation() as instance:
        instance.step(0.0, 0.5)
        x = instance.get("x", "v")
        instance.set(k=200.0)
        assert instance.get("w2", "der(v)") == pytest.approx([100.0, -100.0 * x[0]])
        instance.step(0.5, 0.5)
        assert instance.get("x", "v") == pytest.approx(free(0.5, *x, w=10.0), abs=1e-8)


def test_a_tunable_parameter_reacts_in_event_mode_only(archive):
    with archive.model_exchange() as instance:
        with pytest.raises(FMICallException):
            instance.set(k=200.0)
        instance.event(k=200.0)
        assert instance.rhs(0.0, [1.0, 0.0]) == pytest.approx([0.0, -100.0])


def test_start_values_follow_parameters_until_the_initialisation(archive):
    with archive.co_simulation(x_start=0.75) as instance:
        assert instance.get("x", "v") == pytest.approx([0.75, 0.25])
    with archive.co_simulation(v=-1.0) as instance:
        assert instance.get("x", "v") == pytest.approx([0.5, -1.0])


def test_states_can_be_set_at_a_communication_point(archive):
    with archive.co_simulation() as instance:
        instance.step(0.0, 0.1)
        instance.set(x=0.1, v=0.2)
        instance.step(0.1, 0.4)
        assert instance.get("x", "v") == pytest.approx(free(0.4, 0.1, 0.2), abs=1e-8)


@pytest.mark.parametrize("interface", ["co_simulation", "model_exchange"])
def test_a_serialised_state_replays_bit_for_bit_in_another_instance(archive, interface):
    with getattr(archive, interface)(k=60.0) as first, getattr(archive, interface)() as second:
        if interface == "co_simulation":
            first.step(0.0, 0.3)
        frozen = first.save()
        second.load(frozen)
        after = []
        for instance in (first, second):
            if interface == "co_simulation":
                instance.set(u=3.0)
                instance.step(0.3, 0.3)
                after.append(instance.get("x", "v", "energy").tobytes())
            else:
                after.append(instance.rhs(0.0, instance.continuous_states()).tobytes())
        assert after[0] == after[1]


def test_a_snapshot_from_before_the_initialisation_imposes_other_parameters(archive):
    with archive.co_simulation() as instance:
        fmu = instance.fmu
        fmu.reset()
        snapshot = fmu.getFMUstate()
        for k, start in ((50.0, 0.0), (200.0, 7.0)):
            fmu.setFMUstate(snapshot)
            fmu.setupExperiment(startTime=start)
            instance.set(k=k, x_start=1.0, v=0.0)
            fmu.enterInitializationMode()
            fmu.exitInitializationMode()
            instance.step(start, 0.2)
            assert instance.get("x")[0] == pytest.approx(np.cos(np.sqrt(k / 2) * 0.2), abs=1e-8)
        fmu.freeFMUstate(snapshot)


WRONG = {
    "unknown reference": (lambda i: i.fmu.getReal([9999]), "value reference 9999 is no Real variable of M"),
    "wrong type": (lambda i: i.fmu.getInteger([1]), "value reference 1 is no Integer variable of M"),
    "string": (lambda i: i.fmu.getString([0]), "M has no String variables"),
    "output": (lambda i: i.set(energy=1.0), "energy cannot be set now: it is computed by the equations"),
    "calculated": (lambda i: i.set(w2=1.0), "w2 cannot be set now: it is computed from other parameters"),
    "fixed": (lambda i: i.set(x_start=1.0), "x_start cannot be set now: it is a fixed parameter"),
    "nan": (lambda i: i.set(u=np.nan), "u cannot be set to what is not a number"),
    "negative nan": (lambda i: i.set(u=-np.nan), "u cannot be set to what is not a number"),
    "infinity": (lambda i: i.set(u=-np.inf), "u cannot be set to what is infinite"),
    "endless step": (lambda i: i.step(0.0, np.inf), "the time or the communication step is infinite"),
    "no time": (lambda i: i.step(np.nan, 0.1), "the time or the communication step is not a number"),
    "another time": (lambda i: i.step(0.5, 0.1), "the step starts at 0.5 s, but the instance stands at 0 s"),
    "backwards": (lambda i: i.step(0.0, -0.1), "the communication step is -0.1 s at time 0 s"),
    "wrong mode": (lambda i: i.fmu.enterInitializationMode(), "not allowed in the state Step Mode"),
    "singular": (lambda i: (i.set(m=0.0), i.step(0.0, 0.1)), r"der\(v\) is not a number at time 0 s: check parameters"),
    "no internal step": (lambda i: (i.set(internalStep=0.0), i.step(0.0, 0.1)), "internalStep is 0 s"),
}


@pytest.mark.parametrize("case", WRONG)
def test_a_wrong_call_fails_with_one_message(archive, capfd, case):
    call, message = WRONG[case]
    with archive.co_simulation() as instance:
        capfd.readouterr()
        with pytest.raises(FMICallException):
            call(instance)
        lines = [line for line in capfd.readouterr().out.splitlines() if "fmi2" in line and ": " in line]
        assert any(re.search(message, line) for line in lines), lines


@pytest.mark.parametrize(
    "x, words", [(np.nan, "not a number"), (-np.nan, "not a number"), (np.inf, "infinite"), (-np.inf, "infinite")]
)
def test_derivatives_that_are_not_finite_are_discarded(archive, capfd, x, words):
    with archive.model_exchange() as instance, pytest.raises(FMICallException, match="3|iscard"):
        instance.rhs(0.25, [x, 0.0])
    assert f"der(v) is {words} at time 0.25 s" in capfd.readouterr().out


@pytest.mark.parametrize("function", FUNCTIONS)
def test_no_function_works_without_an_instance(library, function):
    assert library[function](None) == ERROR


def test_without_an_instance_it_is_unknown_whether_it_is_terminated(library):
    terminated, value = 3, c_int()
    assert library.fmi2GetBooleanStatus(None, terminated, byref(value)) == ERROR


@pytest.mark.parametrize("function", FUNCTIONS)
def test_a_call_in_a_wrong_mode_is_logged_under_its_own_name(archive, library, capfd, function):
    """No mode is wrong for every function: here the first number of the instance, which is its mode, becomes 0."""
    with archive.co_simulation() as instance:
        mode = c_int.from_address(instance.fmu.component)
        right, mode.value = mode.value, 0
        status = library[function](c_void_p(instance.fmu.component))
        mode.value = right
    assert status == ERROR
    assert f"{function}: not allowed in the state" in capfd.readouterr().out


def test_a_failed_step_leaves_the_last_good_state(archive):
    with archive.co_simulation() as instance:
        instance.step(0.0, 0.1)
        before = instance.get("x", "v")
        instance.set(m=0.0)
        with pytest.raises(FMICallException):
            instance.step(0.1, 0.1)
        instance.set(m=2.0)
        assert (instance.get("x", "v") == before).all()


def test_an_output_that_is_another_variable_has_its_value_at_any_time(tmp_path):
    text = """model M parameter Real p=2; parameter Real c=2*p; input Real u; Real x(start=1, fixed=true);
      discrete Real d(start=5, fixed=true); output Real[6] y={x, d, u, p, c, time}; output Real z=y[1];
      equation der(x) = 1; when sample(0.5, 1) then d = pre(d) + 1; end when; end M;"""
    archive = archive_of(tmp_path, text)
    names = [*(f"y[{k}]" for k in range(1, 7)), "z"]
    with archive.initialization_mode(interface="coSimulation", p=3.0, x=7.0) as instance:
        assert list(instance.get(*names)) == [7, 5, 0, 3, 6, 0, 7]
    with archive.co_simulation() as instance:
        instance.step(0.0, 0.75)
        instance.set(u=4.0, p=8.0)
        assert instance.get(*names) == pytest.approx([1.75, 6, 4, 8, 16, 0.75, 1.75])
        instance.set(x=-1.0)
        assert instance.get("y[1]", "z", "x") == pytest.approx([-1, -1, -1])
    archive.close()


def test_another_guid_is_not_instantiated(archive):
    identifier = archive.description.coSimulation.modelIdentifier
    fmu = FMU2Slave(guid="{0}", unzipDirectory=archive.folder, modelIdentifier=identifier, instanceName="test")
    with pytest.raises(Exception, match="instantiate"):
        fmu.instantiate()


def test_a_structural_parameter_is_a_constant_of_the_fmu(archive):
    with archive.co_simulation() as instance:
        reference = [archive.references["order"]]
        assert instance.fmu.getInteger(reference) == [2]
        with pytest.raises(FMICallException):
            instance.fmu.setInteger(reference, [3])


def test_the_library_shows_the_44_functions_of_fmi_2_the_75_of_fmi_3_and_nothing_else(archive):
    (library,) = Path(archive.folder).rglob("M.so")
    symbols = run(["nm", "-D", "--defined-only", library], capture_output=True, text=True, check=True).stdout
    names = [line.split()[-1] for line in symbols.splitlines()]
    assert [sum(name.startswith(f"fmi{version}") for name in names) for version in (2, 3)] == [44, 75]
    assert len(names) == 44 + 75
