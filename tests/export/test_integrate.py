"""How Co-Simulation integrates: internalOrder, 4 (Runge-Kutta) or 1 (explicit Euler), in both FMI versions."""

import re

import numpy as np
import pytest
from fmpy.fmi1 import FMICallException

from pipeline.errors import ExportError
from tests.export.language import archive_of, model_of

VERSIONS = ("2", "3")
ORDERS = (4, 1)
FORCED = """
model M
  parameter Real w2=25;
  Real x(start=0.5, fixed=true);
  Real v(start=0.25, fixed=true);
equation
  der(x) = v;
  der(v) = sin(time) - w2*x;
end M;
"""
SAMPLED = """
model M
  Real x(start=0, fixed=true);
  discrete Real z(start=0, fixed=true);
equation
  der(x) = z;
  when sample(0, 0.1) then
    z = pre(z) + 1;
  end when;
end M;
"""
GROWING = """
model M
  parameter Real level=1.5;
  Real x(start=1, fixed=true);
  discrete Real seen(start=-1, fixed=true);
equation
  der(x) = if seen < 0 then x else -1;
  when x > level then
    seen = time;
  end when;
end M;
"""


@pytest.fixture(scope="module")
def forced(tmp_path_factory):
    archives = {version: archive_of(tmp_path_factory.mktemp("forced"), FORCED, fmi=version) for version in VERSIONS}
    yield archives
    for archive in archives.values():
        archive.close()


def exact(t, w=5.0):
    """Position and velocity of FORCED."""
    b = 1 / (w**2 - 1)
    c = (0.25 - b) / w
    return [0.5 * np.cos(w * t) + c * np.sin(w * t) + b * np.sin(t),
            -0.5 * w * np.sin(w * t) + c * w * np.cos(w * t) + b * np.cos(t)]  # fmt: skip


def end(archive, *names, **values):
    """Variables after one communication step of 1 s."""
    with archive.co_simulation(**values) as instance:
        instance.step(0.0, 1.0)
        return instance.get(*names)


def step(order, rhs, t, h, x):
    """The states after a step of Runge-Kutta or Euler, written out in the wrapper's order of operations."""
    k1 = rhs(t, x)
    if order == 1:
        return x + h * k1
    k2 = rhs(t + h / 2, x + h / 2 * k1)
    k3 = rhs(t + h / 2, x + h / 2 * k2)
    k4 = rhs(t + h, x + h * k3)
    return x + h * ((k1 + 2 * k2 + 2 * k3 + k4) / 6)


@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize("order", ORDERS)
def test_half_the_step_leaves_what_the_order_says_of_the_error(forced, version, order):
    errors = [
        np.abs(end(forced[version], "x", "v", internalOrder=order, internalStep=h) - exact(1.0)).max()
        for h in (1e-3, 5e-4)
    ]
    assert errors[0] / errors[1] == pytest.approx(2**order, rel=0.1)


@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize("given", [{}, {"internalOrder": 4.0}, {"internalOrder": 1.0}])
def test_the_steps_are_those_of_model_exchange_to_the_last_bit_by_default_of_runge_kutta(forced, version, given):
    found = end(forced[version], "x", "v", internalStep=0.01, **given)
    with forced[version].model_exchange() as instance:
        x = instance.continuous_states()
        for i in range(100):
            x = step(given.get("internalOrder", 4.0), instance.rhs, i * 0.01, 0.01, x)
    assert dict(zip(forced[version].states, x, strict=True)) == dict(zip(("x", "v"), found, strict=True))


@pytest.mark.parametrize("order", ORDERS)
def test_both_versions_give_the_same_bits(forced, order):
    two, three = (end(forced[version], "x", "v", internalOrder=order, internalStep=1e-3) for version in VERSIONS)
    assert two.tobytes() == three.tobytes()


@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize("order", [0.0, 2.0, 3.0, 1.0000001, 5.0, -4.0])
def test_another_order_is_refused_at_the_step_and_the_instance_goes_on_with_a_right_one(forced, capfd, version, order):
    with forced[version].co_simulation(internalOrder=order) as instance:
        with pytest.raises(FMICallException):
            instance.step(0.0, 0.5)
        said = capfd.readouterr().out
        message = r"DoStep: internalOrder is [-\d.e+]+: it must be 4 \(Runge-Kutta\) or 1 \(explicit Euler\)"
        assert len(re.findall(message, said)) == 1, said
        instance.set(internalOrder=4.0)
        instance.step(0.0, 1.0)
        assert instance.get("x", "v") == pytest.approx(exact(1.0), abs=1e-8)


def test_the_order_can_be_changed_between_steps(forced):
    with forced["2"].co_simulation(internalStep=0.01) as instance:
        instance.step(0.0, 0.01)
        before = instance.get("x", "v")
        instance.set(internalOrder=1.0)
        instance.step(0.01, 0.01)
        rate = np.array([before[1], np.sin(0.01) - 25 * before[0]])
        assert instance.get("x", "v") == pytest.approx(before + 0.01 * rate, rel=1e-15)


@pytest.mark.parametrize("order", ORDERS)
def test_sample_instants_split_the_steps(tmp_path, order):
    archive = archive_of(tmp_path, SAMPLED)
    assert end(archive, "x", internalOrder=order, internalStep=0.03) == pytest.approx([5.5], abs=1e-13)
    archive.close()


@pytest.mark.parametrize("version", VERSIONS)
def test_a_relation_switches_where_eulers_own_motion_crosses(tmp_path, version):
    archive = archive_of(tmp_path, GROWING, fmi=version)
    found = end(archive, "seen", "x", internalOrder=1.0, internalStep=1.0)
    assert found == pytest.approx([0.5, 1.0], abs=1e-13)  # 1 + t crosses 1.5, then falls for half a second
    found = end(archive, "seen", "x", internalOrder=4.0, internalStep=0.01)
    assert found[0] == pytest.approx(np.log(1.5), abs=1e-10)
    archive.close()


@pytest.mark.parametrize("version", VERSIONS)
def test_both_parameters_are_described(forced, version):
    variables = {v.name: v for v in forced[version].description.modelVariables}
    order, h = variables["internalOrder"], variables["internalStep"]
    assert (float(order.start), float(order.min), float(order.max), order.unit) == (4.0, 1.0, 4.0, None)
    assert order.variability == h.variability == "tunable" and order.causality == "parameter"
    assert float(h.start) == 2.5e-4 and h.unit == "s"


@pytest.mark.parametrize("name", ["internalStep", "internalOrder"])
def test_a_model_that_has_such_a_name_itself_is_refused(tmp_path, name):
    text = f"model M parameter Real {name}=1; Real x(start=0, fixed=true); equation der(x) = {name}; end M;"
    with pytest.raises(ExportError, match=f"a variable named {name} would hide the parameter of Co-Simulation"):
        model_of(tmp_path, text)


def test_a_model_without_states_has_neither(tmp_path):
    archive = archive_of(tmp_path, "model M input Real u; output Real y=2*u; end M;")
    assert not {"internalStep", "internalOrder"} & set(archive.references)
    archive.close()
