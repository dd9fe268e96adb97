"""Directional and adjoint derivatives: against differences of sixth order, in every mode, of every FMU."""

from contextlib import contextmanager

import numpy as np
import pytest
from fmpy.fmi1 import FMICallException

from tests.export.language import archive_of
from tests.export.test_fmus_states import DRIVEN

VERSIONS = {"2": "", "3": "_fmi3"}
MODES = ("initialization", "event", "continuous", "step")
STEP = 3e-5
COEFFICIENTS = {1: 45 / 60, 2: -9 / 60, 3: 1 / 60}
HELD = ("emps_controller",)  # purely sampled: between ticks nothing moves what it puts out
REAL = ("Real", "Float64")

EVERYTHING = """
model M "parameters that follow from others, start values that follow, relations, samples, time"
  input Real u(start=0.3);
  parameter Real m=2;
  parameter Real k=50;
  parameter Real w2=k/m;
  parameter Real w3=w2*sqrt(k);
  parameter Real x_start=0.5;
  parameter Real level=0.4;
  parameter Real unread=1;
  Real x(start=2*x_start - 0.1*w2, fixed=true);
  Real v(start=0.25, fixed=true);
  discrete Real held(start=0.7, fixed=true);
  output Real energy=k*x^2/2 + m*v^2/2;
  output Real sampled=2*held;
  output Real direct=u*sin(3*time) + w3;
  output Real branch=if x > level then x^2 else -3*x;
equation
  der(x) = v*exp(-x/5);
  der(v) = -w2*x + u/m + held*x + cos(time)*branch;
  when sample(0.05, 0.1) then
    held = x*u;
  end when;
end M;
"""


@pytest.fixture(scope="module")
def everything(tmp_path_factory):
    """`everything(version)`: the model above as an FMU of that version."""
    archives = {v: archive_of(tmp_path_factory.mktemp("m"), EVERYTHING, fmi=v) for v in VERSIONS}
    yield archives.get
    for archive in archives.values():
        archive.close()


@contextmanager
def standing(archive, mode):
    """An instance in a mode of its life, away from its start where it has left it; inputs as they start."""
    inputs = [v.name for v in archive.description.modelVariables if v.causality == "input"]
    values = {name: 0.1 + 0.07 * i for i, name in enumerate(inputs)}
    if mode == "initialization":
        with archive.initialization_mode(0.2, **values) as instance:
            yield instance
    elif mode == "step":
        with archive.co_simulation(0.2, **values) as instance:
            instance.step(0.2, 0.11)
            yield instance
    else:
        with archive.model_exchange(0.2, **values) as instance:
            instance.fmu.setTime(0.31)
            move(instance)
            if mode == "event":
                instance.fmu.enterEventMode()
            yield instance


def move(instance):
    """Other states, by variable: friction is still felt there."""
    if instance.archive.states:
        x = instance.continuous_states()
        instance.rhs(0.31, x + 0.01 * (1 + np.arange(x.size)))


def knowns(archive, mode):
    """Names of the knowns: continuous inputs, states; in the initialisation what starts with a value of its own."""
    real = [v for v in archive.description.modelVariables if v.type in REAL and v.variability != "constant"]
    inputs = [v.name for v in real if v.causality == "input"]
    if mode == "initialization":
        return inputs + [v.name for v in real if v.initial == "exact" and v.causality != "input"]
    return inputs + archive.states


def unknowns(archive, mode):
    """Names of the unknowns: all that is computed continuously; in the initialisation what is computed then."""
    real = [v for v in archive.description.modelVariables if v.type in REAL and v.causality != "independent"]
    if mode == "initialization":
        return [v.name for v in real if v.initial == "calculated"]
    computed = [v.name for v in real if v.variability == "continuous" and v.causality in ("local", "output")]
    return computed + [v.name for v in real if v.causality == "output" and v.variability == "discrete"]


def jacobian(instance, unknown, known):
    """∂unknown/∂known (len(unknown), len(known)), one directional derivative for each column."""
    return np.column_stack([instance.directional(unknown, [name], [1.0]) for name in known])


def differences(instance, unknown, known):
    """The same by central differences of sixth order."""
    columns = []
    for name in known:
        (at,) = instance.get(name)
        h, column = STEP * max(1.0, abs(at)), np.zeros(len(unknown))
        for k, weight in COEFFICIENTS.items():
            for side in (1, -1):
                set_one(instance, name, at + side * k * h)
                column += side * weight / h * instance.get(*unknown)
        set_one(instance, name, at)
        columns.append(column)
    return np.column_stack(columns)


def set_one(instance, name, value):
    if name == "time":
        instance.fmu.setTime(value)
    else:
        instance.set(**{name.replace(".", "__"): value})


def relative_error(found, expected):
    """Largest difference relative to the largest entry of its row."""
    rows = np.maximum(np.abs(expected).max(axis=1, keepdims=True), 1e-6)
    return (np.abs(found - expected) / rows).max()


def check(archive, mode):
    known, unknown = knowns(archive, mode), unknowns(archive, mode)
    with standing(archive, mode) as instance:
        found = jacobian(instance, unknown, known)
        assert relative_error(found, differences(instance, unknown, known)) < 1e-7
        rng = np.random.default_rng(3)
        seed, weight = rng.normal(size=len(known)), rng.normal(size=len(unknown))
        assert instance.directional(unknown, known, seed) == pytest.approx(found @ seed, rel=1e-12, abs=1e-12)
        if archive.description.fmiVersion != "2.0":
            assert instance.adjoint(unknown, known, weight) == pytest.approx(weight @ found, rel=1e-9, abs=1e-9)
            rows = np.array([instance.adjoint([name], known, [1.0]) for name in unknown])
            assert relative_error(rows, found) < 1e-12
    return found


@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize("name", DRIVEN)
def test_derivatives_are_within_1e_7_of_differences_and_adjoint_ones_their_transpose(archives, name, version, mode):
    found = check(archives(name + VERSIONS[version]), mode)
    assert found.any() == (name not in HELD or mode == "initialization")


@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("version", VERSIONS)
def test_derivatives_go_through_calculated_parameters_and_start_values(everything, version, mode):
    assert check(everything(version), mode).any()


@pytest.mark.parametrize("mode", ["event", "continuous"])
def test_time_is_a_known_of_fmi_3(everything, mode):
    archive = everything("3")
    unknown = unknowns(archive, mode)
    with standing(archive, mode) as instance:
        assert relative_error(jacobian(instance, unknown, ["time"]), differences(instance, unknown, ["time"])) < 1e-7


@pytest.mark.parametrize("version", VERSIONS)
def test_in_the_initialisation_start_values_and_calculated_parameters_carry_the_parameters_on(everything, version):
    with everything(version).initialization_mode() as instance:
        assert instance.directional(["w2", "x"], ["k"], [1.0]) == pytest.approx([0.5, -0.05])
        assert instance.directional(["x", "der(x)"], ["x_start"], [1.0])[0] == pytest.approx(2.0)
        assert instance.directional(["w2", "x", "energy"], ["unread"], [1.0]) == pytest.approx([0, 0, 0], abs=0)


@pytest.mark.parametrize("version", VERSIONS)
def test_in_the_initialisation_an_initial_equation_carries_start_values_on(tmp_path, version):
    text = """model M parameter Real p=2; Real y(start=1, fixed=true); discrete Real d(start=4, fixed=true); Real x;
      Real w(start=p, fixed=true); initial equation x = 2*y + d*w; equation der(y) = -y; der(w) = -w; der(x) = -x*y;
      when x < -9 then d = pre(d) + 1; end when; end M;"""
    archive = archive_of(tmp_path, text, fmi=version)
    assert knowns(archive, "initialization") == ["p", "internalStep", "internalOrder", "y", "d"]
    with archive.initialization_mode(y=3.0, d=5.0) as instance:
        assert list(instance.get("x", "w", "der(x)")) == [16, 2, -48]
    assert check(archive, "initialization").any() and check(archive, "continuous").any()
    archive.close()


@pytest.mark.parametrize("version", VERSIONS)
def test_relations_stay_frozen(everything, version):
    with everything(version).model_exchange(x_start=1.75) as instance:
        x = instance.continuous_states()
        assert x[0] == pytest.approx(1.0)
        instance.rhs(0.0, [0.2, 0.0])
        assert instance.directional(["branch"], ["x"], [1.0]) == pytest.approx([0.4])
        instance.event()
        assert instance.directional(["branch"], ["x"], [1.0]) == pytest.approx([-3.0])


def test_an_output_that_is_a_state_stands_for_itself_and_one_that_is_held_does_not_move(tmp_path):
    text = """model M input Real u; output Real y(start=1, fixed=true); discrete output Real z(start=2, fixed=true);
      equation der(y) = -3*y + u; when sample(0, 1) then z = y*u; end when; end M;"""
    archive = archive_of(tmp_path, text, fmi="3")
    with archive.model_exchange(u=4.0) as instance:
        found = jacobian(instance, ["y", "z", "der(y)"], ["y", "u"])
        assert found == pytest.approx(np.array([[1, 0], [0, 0], [-3, 1]]), abs=0)
        assert instance.adjoint(["y", "z", "der(y)"], ["y", "u"], [5, 6, 7]) == pytest.approx([-16, 7], abs=0)
        assert instance.directional(["der(y)"], ["u", "u"], [1.0, 2.0]) == pytest.approx([3.0])
    archive.close()


REFUSED = {
    "parameter as a known": (["der(v)"], ["k"], "k is no known of a derivative now: it is a parameter, known in Init"),
    "calculated as a known": (["der(v)"], ["w2"], "w2 is no known of a derivative now: it is a calculated parameter"),
    "output as a known": (["der(v)"], ["energy"], "energy is no known of a derivative now: it is computed by"),
    "discrete as a known": (["der(v)"], ["held"], "held is no known of a derivative now: it is a discrete variable"),
    "input as an unknown": (["u"], ["x"], "u is no unknown of a derivative now: it is an input"),
    "parameter as an unknown": (["m"], ["x"], "m is no unknown of a derivative now: it is a parameter"),
    "calculated as an unknown": (["w2"], ["x"], "w2 is no unknown of a derivative now: it is a calculated parameter"),
}


@pytest.mark.parametrize("interface", ["co_simulation", "model_exchange"])
@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize("case", REFUSED)
def test_what_is_no_known_or_unknown_is_refused_by_name(everything, capfd, case, version, interface):
    unknown, known, message = REFUSED[case]
    with getattr(everything(version), interface)() as instance:
        capfd.readouterr()
        with pytest.raises(FMICallException):
            instance.directional(unknown, known, [1.0])
        assert message in capfd.readouterr().out


@pytest.mark.parametrize("version", VERSIONS)
def test_before_the_initialisation_a_start_value_that_follows_is_no_known(everything, capfd, version):
    with everything(version).initialization_mode() as instance:
        with pytest.raises(FMICallException):
            instance.directional(["energy"], ["x"], [1.0])
        assert "x is no known of a derivative now: it is a state whose start value follows" in capfd.readouterr().out


def test_a_derivative_that_is_not_finite_is_refused(everything, capfd):
    with everything("2").co_simulation() as instance:
        instance.set(m=0.0)
        with pytest.raises(FMICallException):
            instance.directional(["der(v)"], ["x"], [1.0])
        assert "the derivative of der(v) is not a number at time 0 s" in capfd.readouterr().out
