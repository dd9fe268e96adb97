"""Every FMU by itself: validation, and the plants against Lagrange's equations and SciPy, with friction reversals."""

import numpy as np
import pytest
from fmpy.validation import validate_fmu
from scipy.integrate import solve_ivp

from tests.export.oracles import EMPS, SCARA, emps_rhs, march, runge_kutta, scara_rhs
from tests.modelica.sources import PACKAGE, snake_case

NAMES = [snake_case(name) for name in (PACKAGE / "FMUs/package.order").read_text().split()]
NAMES += ["scara_inputs", "emps_inputs"]
H = 0.01
PLANTS = {
    "scara": (scara_rhs, SCARA, ("tau_1", "tau_2"), ("q_1", "q_2", "qd_1", "qd_2")),
    "emps": (emps_rhs, EMPS, ("u",), ("q", "qd")),
}
STATES = {"scara": ("body.q_1", "body.q_2", "body.qd_1", "body.qd_2"), "emps": ("x", "v")}
STARTS = {"scara": ("q_start_1", "q_start_2", "qd_start_1", "qd_start_2"), "emps": ("q_start", "qd_start")}


def commands(name, kind="smooth", N=100):
    """Inputs (N, m), held for H each, that drive every joint forth and back; "rough" ones with faster reversals."""
    t, rough = H * np.arange(N), kind == "rough"
    if name == "emps":
        return (2.5 * np.cos(14.0 * t) + 0.6 * rough * np.sign(np.sin(31.0 * t)))[:, None]
    if rough:
        return np.column_stack(
            [14.0 * np.cos(14.0 * t) + 3.0 * np.sign(np.sin(23.0 * t)), 1.1 * np.sin(14.0 * t + 0.4)]
        )
    return np.column_stack([6.0 * np.cos(7.0 * t), 0.6 * np.sin(9.0 * t)])


@pytest.fixture(scope="module")
def references():
    """`references(name, kind)`: states (N+1, n) of SciPy's Radau under the commands, from rest."""
    known = {}

    def reference(name, kind="smooth"):
        if (name, kind) not in known:
            rhs, values, _, outputs = PLANTS[name]
            known[name, kind] = march(rhs(values), np.zeros(len(outputs)), commands(name, kind), H)
        return known[name, kind]

    return reference


def drive(instance, name, u):
    """States (N+1, n) of a Co-Simulation instance under the held inputs u (N, m)."""
    inputs, outputs = PLANTS[name][2:]
    rows = [instance.get(*outputs)]
    for k, row in enumerate(u):
        instance.set(**dict(zip(inputs, row, strict=True)))
        instance.step(k * H, H)
        rows.append(instance.get(*outputs))
    return np.array(rows)


@pytest.mark.parametrize("name", NAMES + [f"{name}_fmi3" for name in NAMES])
def test_fmpy_finds_nothing_to_complain_about(fmus, name):
    assert validate_fmu(str(fmus / f"{name}.fmu")) == []


@pytest.mark.parametrize("version", ["2.0", "3.0"])
@pytest.mark.parametrize("name", NAMES)
def test_both_interfaces_and_no_external_state_are_declared(archives, name, version):
    description = archives(name if version == "2.0" else f"{name}_fmi3").description
    assert description.fmiVersion == version
    for interface in (description.modelExchange, description.coSimulation):
        assert interface.canGetAndSetFMUstate and interface.canSerializeFMUstate


@pytest.mark.parametrize("kind", ["smooth", "rough"])
@pytest.mark.parametrize("name", PLANTS)
def test_the_oracle_reverses_every_joint(references, name, kind):
    velocity = references(name, kind)[:, len(PLANTS[name][2]) :]
    assert (np.sum(np.diff(np.sign(velocity[1:]), axis=0) != 0, axis=0) >= 2).all()


@pytest.mark.parametrize("name", PLANTS)
def test_co_simulation_at_a_quarter_millisecond_is_within_1e_8_of_radau(archives, references, name):
    with archives(name).co_simulation(**PLANTS[name][1], internalStep=2.5e-4) as instance:
        assert np.abs(drive(instance, name, commands(name)) - references(name)).max() < 1e-8


@pytest.mark.parametrize(
    ("name", "step", "velocity_error"),
    [("scara", 2.5e-4, 3e-8), ("scara", 1.25e-4, 1e-8), ("emps", 2.5e-4, 1e-8)],
    ids=["scara misses 1e-8", "scara at half the step", "emps"],
)
def test_through_rough_reversals_all_but_scaras_velocity_at_a_quarter_millisecond_meet_1e_8(
    archives, references, name, step, velocity_error
):
    """A known miss, which `make figures` declares: 2.5e-8 rad/s of SCARA's velocity at 0.25 ms, where 1e-8 is asked.

    A step of the torque throws a joint of 0.06 kg.m2 through eps in a millisecond. That this is the method's
    truncation and nothing else, the next test shows; half the step meets the figure.
    """
    n = len(PLANTS[name][2])
    with archives(name).co_simulation(**PLANTS[name][1], internalStep=step) as instance:
        error = np.abs(drive(instance, name, commands(name, "rough")) - references(name, "rough"))
    assert error[:, :n].max() < 1e-8 and error[:, n:].max() < velocity_error


@pytest.mark.parametrize("name", PLANTS)
def test_through_rough_reversals_co_simulation_is_runge_kutta_to_rounding(archives, name):
    rhs, values, _, outputs = PLANTS[name]
    with archives(name).co_simulation(**values, internalStep=2.5e-4) as instance:
        found = drive(instance, name, commands(name, "rough"))
    expected = runge_kutta(rhs(values), np.zeros(len(outputs)), commands(name, "rough"), H, round(H / 2.5e-4))
    assert np.abs(found - expected).max() < 1e-12


@pytest.mark.parametrize(("name", "coarse"), [("scara", 2.5e-4), ("emps", 1e-3)])
def test_the_internal_step_is_a_parameter_of_fourth_order(archives, references, name, coarse):
    errors = []
    for step in (coarse, coarse / 2):
        with archives(name).co_simulation(**PLANTS[name][1], internalStep=step) as instance:
            errors.append(np.abs(drive(instance, name, commands(name, "rough")) - references(name, "rough")).max())
    assert 8 < errors[0] / errors[1] < 32


def by_model_exchange(archive, name):
    """States (N+1, n) under the rough commands, the derivatives of Model Exchange integrated by LSODA at 1e-11."""
    values, inputs = PLANTS[name][1:3]
    order = [archive.states.index(s) for s in STATES[name]]
    with archive.model_exchange(**values) as instance:
        x = instance.continuous_states()
        rows = [x[order]]
        for k, u in enumerate(commands(name, "rough")):
            instance.set(**dict(zip(inputs, u, strict=True)))
            x = solve_ivp(instance.rhs, (k * H, (k + 1) * H), x, method="LSODA", rtol=1e-11, atol=1e-12).y[:, -1]
            rows.append(x[order])
    return np.array(rows)


@pytest.mark.parametrize("name", PLANTS)
def test_model_exchange_is_within_1e_7_of_radau(archives, references, name):
    assert np.abs(by_model_exchange(archives(name), name) - references(name, "rough")).max() < 1e-7


@pytest.mark.parametrize("name", PLANTS)
def test_derivatives_equal_the_closed_form_for_random_states_and_parameters(archives, name):
    rhs, values, inputs, outputs = PLANTS[name]
    archive, rng = archives(name), np.random.default_rng(7)
    order = [archive.states.index(s) for s in STATES[name]]
    with archive.model_exchange(**values) as instance:
        for _ in range(200):
            chi = {k: v * rng.uniform(0.6, 1.6) for k, v in values.items()}
            if name == "scara":
                chi["LMY2"] = rng.normal(scale=0.1)
            x, u = rng.normal(scale=3.0, size=len(outputs)), rng.normal(scale=8.0, size=len(inputs))
            instance.event(**chi, **dict(zip(inputs, u, strict=True)))
            state = np.empty(len(order))
            state[order] = x
            found, expected = instance.rhs(0.0, state)[order], np.array(rhs(chi)(x, u))
            assert np.abs(found - expected).max() <= 1e-12 * max(1.0, np.abs(expected).max())


@pytest.mark.parametrize("name", PLANTS)
def test_start_values_are_where_the_motion_begins(archives, name):
    outputs = PLANTS[name][3]
    start = dict(zip(STARTS[name], (0.3, -0.2, 1.5, -0.7), strict=False))
    with archives(name).co_simulation(**start) as cs, archives(name).model_exchange(**start) as me:
        for instance in (cs, me):
            assert instance.get(*outputs) == pytest.approx(list(start.values()), abs=0)
            assert instance.get(*STATES[name]) == pytest.approx(list(start.values()), abs=0)


@pytest.mark.parametrize("name", PLANTS)
def test_the_defaults_are_the_a_priori_values(archives, name):
    with archives(name).co_simulation() as instance:
        names = [n for n in PLANTS[name][1] if n != "G"]
        assert instance.get(*names) == pytest.approx([PLANTS[name][1][n] for n in names], abs=0)


def test_the_gain_of_the_drive_comes_from_the_binding(archives):
    import tomllib

    from pipeline.paths import FMUS

    gain = tomllib.loads((FMUS / "emps.toml").read_text())["joint"][0]["gain"]
    for name in ("emps", "emps_closed_loop"):
        with archives(name).co_simulation() as instance:
            assert instance.get("G") == gain
