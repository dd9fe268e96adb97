"""The loop stage: the linear loop against the two FMUs in time, the filters it sets, and what it refuses."""

import numpy as np
import pandas as pd
import pytest
from msgspec import structs

from pipeline.errors import ConfigError
from pipeline.simulate.closed_loop import simulate_closed_loop
from pipeline.workflow.acquire import ports_of, reference_of
from pipeline.workflow.loop import analyse_loop, follow_loop, motion, spread
from pipeline.workflow.session import open_session


@pytest.fixture(scope="module")
def scara(fmus):
    return open_session("scara")


@pytest.fixture(scope="module")
def emps(fmus):
    return open_session("emps", simulated=True)


@pytest.fixture(scope="module")
def loops(scara, emps):
    """Of each robot the linear plants and the loop's responses."""
    return {s.experiment.name: analyse_loop(s, reference_of(s)) for s in (scara, emps)}


def gain_in_time(session, q, joint, f):
    """|reference → position| at f (Hz): both FMUs coupled, a small sine on one reference, its amplitude behind."""
    binding, controller = session.binding, session.experiment.controller
    dt, size = controller.period, 1e-4
    t = dt * np.arange(round(max(3.0, 12.0 / f) / dt))
    names = [f"qr_{i + 1}" for i in range(binding.n)]
    reference = pd.DataFrame(np.tile(q, (len(t), 1)), index=pd.Index(t, name="time"), columns=names)
    reference[names[joint]] += size * np.sin(2 * np.pi * f * t)
    for i in range(len(controller.reference_velocity)):
        reference[f"qdr_{i + 1}"] = 0.0
    plant_start = {**binding.start_values(), **binding.linearise}
    plant_start |= dict(zip((j.position_start for j in binding.joint), q, strict=True))
    start = dict(zip(controller.position_start, q, strict=True))
    ports = ports_of(session)
    moved = simulate_closed_loop(
        binding.path, session.controller_fmu, ports, reference, dt, None, plant_start, start, binding.gain
    )
    late = t > 0.5 * t[-1]
    basis = np.column_stack([np.sin(2 * np.pi * f * t), np.cos(2 * np.pi * f * t), np.ones(len(t))])[late]
    sine, cosine, _ = np.linalg.lstsq(basis, moved[f"q_true_{joint + 1}"].to_numpy()[late], rcond=None)[0]
    return np.hypot(sine, cosine) / size


@pytest.mark.parametrize(("name", "joint"), [("scara", 0), ("scara", 1), ("emps", 0)])
def test_at_its_bandwidth_the_loop_in_time_is_at_minus_3_dB(request, loops, name, joint):
    """Nothing linearised: the FMUs' own Co-Simulation, in the middle of the motion and at its end."""
    session = request.getfixturevalue(name)
    plants, responses = loops[name]
    for plant, response in list(zip(plants, responses, strict=True))[:2]:
        f = response.bandwidth[joint]
        assert gain_in_time(session, plant.q, joint, f) == pytest.approx(10 ** (-3 / 20), rel=0.01)
        expected = np.interp(2 * f, response.f, response.gain[:, joint])
        assert gain_in_time(session, plant.q, joint, 2 * f) == pytest.approx(expected, rel=0.01)


def test_the_scara_has_its_known_bandwidths(loops):
    """Joint 1 1.25 to 1.28 Hz, joint 2 1.9 to 2.43 Hz by its inertia; the same loop without sampling: 1.2 to 2.1 Hz."""
    bandwidth = np.array([r.bandwidth for r in loops["scara"][1]])
    assert 1.24 < bandwidth[:, 0].min() < bandwidth[:, 0].max() < 1.29
    assert 1.88 < bandwidth[:, 1].min() < bandwidth[:, 1].max() < 2.44
    for response in loops["scara"][1]:
        assert all(m.phase > 35 and m.modulus > 0.55 and m.gain > 5 for m in response.margins)


def test_friction_left_on_would_ruin_the_filters(scara):
    """Smoothed Coulomb friction linearised at rest: 0.4 Hz in place of 2.4."""
    stuck = structs.replace(scara.binding, linearise={"eps": 0.01})
    session = type(scara)(scara.experiment, stuck, scara.folder)
    _, responses = analyse_loop(session, reference_of(scara))
    assert 0.38 < max(r.bandwidth.max() for r in responses) < 0.45


def test_the_filters_of_the_scara_follow_its_loop(scara):
    found, loop = follow_loop(scara, reference_of(scara))
    settings = found.recommended
    assert scara.recommended.position.cutoff is None
    assert 2.0 < loop.f_dyn < 2.2  # the loop's joints: 1.3 Hz, and 1.9 to 2.4 Hz over the poses
    assert settings.position.cutoff == pytest.approx(5 * loop.f_dyn, rel=0.01)
    assert settings.parallel.cutoff == pytest.approx(2 * loop.f_dyn, rel=0.01)
    assert settings.decimation == 10
    assert loop.filters["WLS(3)"]["position"]["source"] == "5 f_dyn"
    assert loop.filters["WLS(2)"]["position"]["source"] == "set"
    again, _ = follow_loop(found, reference_of(scara))
    assert again.experiment == found.experiment, "what is resolved stays"


def test_the_drive_keeps_its_published_filters_and_shows_its_loop(emps):
    found, loop = follow_loop(emps, reference_of(emps))
    assert found.experiment.wls == emps.experiment.wls
    assert loop.f_dyn == pytest.approx(28.8, rel=0.01) and not loop.reason
    assert loop.responses[0].margins[0].phase == pytest.approx(34.8, abs=0.3)


def test_an_unstable_loop_is_refused_where_a_filter_needs_it_and_told_where_none_does(scara):
    controller = structs.replace(scara.experiment.controller, start={"Kd_1": -45.0})
    session = type(scara)(structs.replace(scara.experiment, controller=controller), scara.binding, scara.folder)
    with pytest.raises(ConfigError, match="closed loop: not stable") as error:
        follow_loop(session, reference_of(scara))
    assert "set the cut-offs" in str(error.value) and "\n" not in str(error.value)
    set_by_hand = follow_loop(scara, reference_of(scara))[0].experiment.wls
    session = type(scara)(structs.replace(session.experiment, wls=set_by_hand), scara.binding, scara.folder)
    found, loop = follow_loop(session, reference_of(scara))
    assert found.experiment.wls == set_by_hand
    assert loop.f_dyn is None and "not stable" in loop.reason and not loop.responses


def test_a_record_too_slow_for_the_loop_is_refused(scara):
    """The data come at 10 Hz, 5 f_dyn is above their Nyquist."""
    simulation = structs.replace(scara.experiment.simulation, rate=10.0)
    wls = tuple(w for w in scara.experiment.wls if w.name == "WLS(3)")
    experiment = structs.replace(scara.experiment, simulation=simulation, wls=wls)
    with pytest.raises(
        ConfigError, match=r"WLS\(3\): 5 f_dyn = 1\d\.?\d* Hz, from the closed loop, is not below Nyquist, 5"
    ):
        follow_loop(type(scara)(experiment, scara.binding, scara.folder), reference_of(scara))


DRIVE = """
title = "No controller"
plant = "emps"
recommended = "WLS"
[data]
identification = "one.csv"
validation = "two.csv"
rate = 1000.0
[data.columns]
time = { source = "t", unit = "s" }
[[wls]]
name = "WLS"
position = { kind = "zero-phase" }
parallel = { kind = "zero-phase" }
"""


def test_without_a_controller_the_cutoffs_must_be_set(fmus, tmp_path):
    path = tmp_path / "drive.toml"
    path.write_text(DRIVE)
    with pytest.raises(ConfigError, match=r"WLS: a filter without `cutoff` follows the closed loop, and there is no"):
        open_session(str(path))
    chosen = ["wls.WLS.position.cutoff=100.0", "wls.WLS.parallel.cutoff=40.0"]
    found, loop = follow_loop(open_session(str(path), chosen), pd.DataFrame({"q_1": np.zeros(10)}))
    assert "no [controller]" in loop.reason
    assert found.recommended.decimation == 10


def test_positions_come_from_the_reference_and_spread_over_it():
    q = np.random.default_rng(0).uniform(-1, 1, (500, 2)) * [1.0, 1e-3]
    frame = pd.DataFrame(np.hstack([q, q + 5]), columns=["qr_1", "qr_2", "q_1", "q_2"])
    np.testing.assert_array_equal(motion(frame, 2), q)
    np.testing.assert_array_equal(motion(frame.drop(columns="qr_2"), 2), q + 5)
    chosen = spread(q, 9)
    assert len(np.unique(chosen, axis=0)) == 9
    assert np.all(np.abs(chosen[0] - np.median(q, axis=0)) < [0.15, 0.15e-3])
    for low, high in zip(chosen.min(axis=0) / [1, 1e-3], chosen.max(axis=0) / [1, 1e-3], strict=True):
        assert low < -0.9 and high > 0.9
    assert len(spread(np.zeros((3, 2)), 9)) == 3
