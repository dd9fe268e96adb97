"""States and parameters at run time: bit-exact replay of the FMU state, states set by hand, parameters that react."""

import numpy as np
import pytest
from fmpy.fmi1 import FMICallException

from tests.export.oracles import EMPS, SCARA

H = 0.01
NEW = {
    "scara": dict(ZZR1=3.0, Fv1=0.2, Fs1=0.4, ZZ2=0.08, LMX2=0.1, LMY2=0.03, Fv2=0.03, Fs2=0.1, eps=0.02),
    "emps": dict(M=80.0, Fv=240.0, Fc=25.0, offset=2.0, eps=2e-3, G=40.0),
}
OLD = {"scara": SCARA, "emps": EMPS}
DRIVEN = {  # inputs (as functions of time) and outputs
    "scara": (dict(tau_1=8.0, tau_2=1.0), ("q_1", "q_2", "qd_1", "qd_2")),
    "scara_controller": (dict(qr_1=0.1, qr_2=2.0, qdr_1=0.5, qdr_2=1.0, q_1=0.05, q_2=0.2), ("tau_1", "tau_2")),
    "scara_controller_continuous": (
        dict(qr_1=0.1, qr_2=2.0, qdr_1=0.5, qdr_2=1.0, q_1=0.05, q_2=0.2),
        ("tau_1", "tau_2"),
    ),
    "scara_closed_loop": (
        dict(qr_1=0.5, qr_2=0.8, qdr_1=2.0, qdr_2=1.0),
        ("q_1", "q_2", "qd_1", "qd_2", "tau_1", "tau_2"),
    ),
    "emps": (dict(u=2.0), ("q", "qd")),
    "emps_controller": (dict(qr=0.01, pulse=1.0, q=0.002), ("u",)),
    "emps_closed_loop": (dict(qr=0.01, pulse=1.0), ("q", "qd", "u")),
}
for variant in ("scara_inputs", "emps_inputs"):  # the parameters are inputs too, and stay where they start
    DRIVEN[variant] = DRIVEN[variant.removesuffix("_inputs")]
SAMPLED = ("scara_controller", "scara_closed_loop", "emps_controller", "emps_closed_loop")
STARTS = {
    "scara": dict(q_start_1="body.q_1", q_start_2="body.q_2", qd_start_1="body.qd_1", qd_start_2="body.qd_2"),
    "emps": dict(q_start="x", qd_start="v"),
}


def inputs(name, k):
    """The inputs of step k: every amplitude times its own cosine."""
    amplitudes = DRIVEN[name][0]
    return {n: a * np.cos(0.13 * (i + 1) * k + i) for i, (n, a) in enumerate(amplitudes.items())}


def march(instance, name, first, last):
    """Outputs (last − first, m) of the Co-Simulation steps first … last − 1."""
    rows = []
    for k in range(first, last):
        instance.set(**inputs(name, k))
        instance.step(k * H, H)
        rows.append(instance.get(*DRIVEN[name][1]))
    return np.array(rows)


def march_exchange(instance, name, first, last):
    """Outputs of Euler steps in Model Exchange, events where the FMU asks for them."""
    rows = []
    for k in range(first, last):
        t = k * H
        instance.set(**inputs(name, k))
        instance.fmu.setTime(t)
        if instance.next_event is not None and t >= instance.next_event - 1e-9:
            instance.event()
        if instance.x.size:
            x = instance.continuous_states()
            instance.rhs(t, x + 1e-3 * instance.rhs(t, x))
        instance.fmu.completedIntegratorStep()
        rows.append(instance.get(*DRIVEN[name][1]))
    return np.array(rows)


@pytest.mark.parametrize("name", DRIVEN)
@pytest.mark.parametrize("interface", ["co_simulation", "model_exchange"])
def test_a_restored_state_replays_bit_for_bit(archives, name, interface):
    run = march if interface == "co_simulation" else march_exchange
    with getattr(archives(name), interface)() as instance:
        run(instance, name, 0, 23)
        state, due = instance.fmu.getFMUstate(), getattr(instance, "next_event", None)
        first = run(instance, name, 23, 60)
        assert np.ptp(first, axis=0).min() > 0
        for _ in range(2):
            instance.fmu.setFMUstate(state)
            instance.next_event = due
            assert np.array_equal(run(instance, name, 23, 60), first)
        instance.fmu.freeFMUstate(state)


@pytest.mark.parametrize("name", DRIVEN)
@pytest.mark.parametrize("interface", ["co_simulation", "model_exchange"])
def test_a_serialised_state_continues_in_another_instance(archives, name, interface):
    run = march if interface == "co_simulation" else march_exchange
    make = getattr(archives(name), interface)
    with make() as one, make() as other:
        run(one, name, 0, 23)
        frozen, other.next_event = one.save(), getattr(one, "next_event", None)
        run(other, name, 0, 7)
        other.load(frozen)
        other.next_event = getattr(one, "next_event", None)
        assert np.array_equal(run(other, name, 23, 60), run(one, name, 23, 60))


@pytest.mark.parametrize("name", OLD)
def test_the_restored_state_holds_the_parameters_too(archives, name):
    with archives(name).co_simulation(**OLD[name]) as instance:
        march(instance, name, 0, 5)
        frozen = instance.save()
        instance.set(**NEW[name])
        instance.load(frozen)
        assert instance.get(*OLD[name]) == pytest.approx(list(OLD[name].values()), abs=0)


@pytest.mark.parametrize("name", OLD)
def test_parameters_set_at_a_communication_point_act_as_in_a_fresh_instance(archives, name):
    archive = archives(name)
    with archive.co_simulation(**OLD[name]) as changed, archive.co_simulation(**OLD[name]) as unchanged:
        march(changed, name, 0, 30)
        march(unchanged, name, 0, 30)
        changed.set(**NEW[name])
        start = dict(zip(STARTS[name], changed.get(*STARTS[name].values()), strict=True))
        with archive.co_simulation(start=30 * H, **NEW[name], **start) as fresh:
            reacted = march(changed, name, 30, 60)
            assert np.array_equal(reacted, march(fresh, name, 30, 60))
        assert np.abs(reacted - march(unchanged, name, 30, 60)).max() > 1e-3


@pytest.mark.parametrize("name", OLD)
@pytest.mark.parametrize("which", ["each alone", "together"])
def test_parameters_set_in_event_mode_act_as_in_a_fresh_instance(archives, name, which):
    archive = archives(name)
    changes = [NEW[name]] if which == "together" else [{k: v} for k, v in NEW[name].items()]
    x = np.array([0.3, 0.5, 0.021, -0.03] if name == "scara" else [0.1, 1.1e-3])
    for change in changes:
        with archive.model_exchange(**OLD[name]) as changed, archive.model_exchange(**{**OLD[name], **change}) as fresh:
            for instance in (changed, fresh):
                instance.set(**inputs(name, 0))
            before = changed.rhs(0.0, x)
            changed.event(**change)
            assert np.array_equal(changed.continuous_states(), x)
            after = changed.rhs(0.0, x)
            assert np.array_equal(after, fresh.rhs(0.0, x))
            assert np.abs(after - before).max() > 1e-6, change


@pytest.mark.parametrize("name", ["scara_closed_loop", "emps_closed_loop"])
def test_the_parts_of_a_loop_follow_its_parameters(archives, name):
    new = NEW["scara" if name.startswith("scara") else "emps"]
    with archives(name).co_simulation() as instance:
        march(instance, name, 0, 3)
        instance.set(**new)
        assert instance.get(*[f"plant.{n}" for n in new]) == pytest.approx(list(new.values()), abs=0)


@pytest.mark.parametrize("name", OLD)
def test_states_set_after_initialisation_are_where_the_motion_goes_on(archives, name):
    archive, states = archives(name), list(STARTS[name].values())
    x = [0.3, 0.5, 0.4, -0.6][: len(states)]
    with archive.co_simulation() as moved:
        march(moved, name, 0, 4)
        moved.set(**{s.replace(".", "__"): v for s, v in zip(states, x, strict=True)})
        assert moved.get(*DRIVEN[name][1]) == pytest.approx(x, abs=0)
        with archive.co_simulation(start=4 * H, **dict(zip(STARTS[name], x, strict=True))) as fresh:
            assert np.array_equal(march(moved, name, 4, 20), march(fresh, name, 4, 20))


@pytest.mark.parametrize("name", SAMPLED)
def test_the_sample_period_cannot_be_changed(archives, name):
    variable = next(v for v in archives(name).description.modelVariables if v.name == "samplePeriod")
    assert variable.variability in ("fixed", "constant")
    with archives(name).co_simulation() as instance, pytest.raises(FMICallException):
        instance.set(samplePeriod=0.5)


@pytest.mark.parametrize("name", DRIVEN)
def test_reset_starts_again_from_the_defaults(archives, name):
    with archives(name).co_simulation() as instance:
        first = march(instance, name, 0, 12)
        for tunable in [v for v in archives(name).description.modelVariables if v.variability == "tunable"][:3]:
            if tunable.causality == "parameter":
                instance.set(**{tunable.name: 1.25 * float(tunable.start)})
        instance.fmu.reset()
        instance.fmu.setupExperiment(startTime=0.0)
        instance.fmu.enterInitializationMode()
        instance.fmu.exitInitializationMode()
        assert np.array_equal(march(instance, name, 0, 12), first)
