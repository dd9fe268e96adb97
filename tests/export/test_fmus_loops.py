"""Closed loops: the exported Modelica loop = the co-simulation of its two parts = SciPy with a NumPy controller."""

import numpy as np
import pytest

from pipeline.paths import EXPERIMENTS
from pipeline.simulate.trajectory import read_waypoints, sample
from tests.export.oracles import EMPS, SCARA, SampledPD, TwoLoop, emps_rhs, held, scara_rhs

OUT = ("q_1", "q_2", "qd_1", "qd_2", "tau_1", "tau_2")
START = dict(q_start_1=0.1, q_start_2=-0.2)


def scara_reference(N):
    """qr, qdr (N, 2): both joints swing from START, the first so fast that its torque saturates."""
    t = 0.01 * np.arange(N)[:, None]
    w, a = np.array([6.0, 5.0]), np.array([0.6, 0.8])
    return np.array([0.1, -0.2]) + a * (1 - np.cos(w * t)), a * w * np.sin(w * t)


def scara_ports(qr, qdr):
    return dict(qr_1=qr[0], qr_2=qr[1], qdr_1=qdr[0], qdr_2=qdr[1])


@pytest.fixture(scope="module")
def scara_loop(archives):
    """Outputs (N, 6) of the closed-loop FMU at the end of each 10 ms step."""
    qr, qdr = scara_reference(150)
    rows = []
    with archives("scara_closed_loop").co_simulation(**START) as instance:
        for k in range(150):
            instance.set(**scara_ports(qr[k], qdr[k]))
            instance.step(0.01 * k, 0.01)
            rows.append(instance.get(*OUT))
    return np.array(rows)


def test_the_scara_loop_is_the_co_simulation_of_its_parts(archives, scara_loop):
    qr, qdr = scara_reference(150)
    with archives("scara").co_simulation(**START) as plant, archives("scara_controller").co_simulation(**START) as pd:
        for k, row in enumerate(scara_loop):
            q = plant.get("q_1", "q_2")
            pd.set(**scara_ports(qr[k], qdr[k]), q_1=q[0], q_2=q[1])
            pd.step(0.01 * k, 0.01)
            tau = pd.get("tau_1", "tau_2")
            plant.set(tau_1=tau[0], tau_2=tau[1])
            plant.step(0.01 * k, 0.01)
            found = np.concatenate([plant.get("q_1", "q_2", "qd_1", "qd_2"), tau])
            assert np.abs(found - row)[:2].max() < 1e-9 and np.abs(found - row).max() < 1e-7


def test_the_scara_loop_is_within_1e_8_of_radau(scara_loop):
    qr, qdr = scara_reference(150)
    f, pd, x = scara_rhs(SCARA), SampledPD(q_start=(0.1, -0.2)), np.array([0.1, -0.2, 0.0, 0.0])
    taus = []
    for k, row in enumerate(scara_loop):
        tau = pd.tick(qr[k], qdr[k], x[:2])
        x = held(f, x, tau, 0.01)
        taus.append(tau)
        assert np.abs(row[:2] - x[:2]).max() < 1e-8
        assert np.abs(row[4:] - tau).max() < 1e-5
    assert (np.abs(taus) == [40, 6]).any(axis=0)[0] and (np.ptp(np.sign(scara_loop[:, 2:4]), axis=0) == 2).all()


def test_a_loop_sampled_finer_than_its_controller_is_the_same_loop(archives, scara_loop):
    qr, qdr = scara_reference(150)
    with archives("scara_closed_loop").co_simulation(**START) as instance:
        for k in range(600):
            instance.set(**scara_ports(qr[k // 4], qdr[k // 4]))
            instance.step(0.0025 * k, 0.0025)
            if k % 4 == 3:
                assert np.abs(instance.get(*OUT) - scara_loop[k // 4])[:2].max() < 1e-9


def test_a_loop_stepped_coarser_than_its_controller_ticks_in_between(archives):
    qr, qdr = np.array([0.5, 0.4]), np.zeros(2)
    with archives("scara_closed_loop").co_simulation() as fine, archives("scara_closed_loop").co_simulation() as coarse:
        for instance in (fine, coarse):
            instance.set(**scara_ports(qr, qdr))
        for k in range(50):
            fine.step(0.01 * k, 0.01)
        for k in range(5):
            coarse.step(0.1 * k, 0.1)
        assert np.abs(fine.get(*OUT) - coarse.get(*OUT)).max() < 1e-8


def test_on_the_exciting_trajectory_the_loop_is_within_1e_8_rad_of_radau(archives):
    trajectory = sample(read_waypoints(EXPERIMENTS / "scara_identification.csv"), 100.0)
    x = np.concatenate([trajectory.q[0], np.zeros(2)])
    f, pd = scara_rhs(SCARA), SampledPD(q_start=x[:2])
    with archives("scara_closed_loop").co_simulation(q_start_1=x[0], q_start_2=x[1]) as instance:
        for k in range(600):
            instance.set(**scara_ports(trajectory.q[k], trajectory.qd[k]))
            instance.step(0.01 * k, 0.01)
            x = held(f, x, pd.tick(trajectory.q[k], trajectory.qd[k], x[:2]), 0.01)
            error = np.abs(instance.get("q_1", "q_2", "qd_1", "qd_2") - x)
            assert error[:2].max() < 1e-8 and error[2:].max() < 1e-7


def emps_signals(N):
    t = 1e-3 * np.arange(N)
    return 0.01 * (1 - np.cos(12 * t)), 5.0 * (np.abs(t - 0.3) < 0.02)


def test_the_emps_loop_is_its_parts_and_within_1e_8_of_radau(archives):
    qr, pulse = emps_signals(600)
    f, two_loop, x = emps_rhs(EMPS), TwoLoop(q_start=-1e-3, qd_start=0.01), np.array([-1e-3, 0.01])
    start = dict(q_start=-1e-3, qd_start=0.01)
    loop, parts = archives("emps_closed_loop"), (archives("emps"), archives("emps_controller"))
    with (
        loop.co_simulation(**EMPS, **start) as whole,
        parts[0].co_simulation(**EMPS, **start) as plant,
        parts[1].co_simulation(**start) as controller,
    ):
        for k in range(600):
            t = 1e-3 * k
            whole.set(qr=qr[k], pulse=pulse[k])
            whole.step(t, 1e-3)
            controller.set(qr=qr[k], pulse=pulse[k], q=plant.get("q")[0])
            controller.step(t, 1e-3)
            plant.set(u=controller.get("u")[0])
            plant.step(t, 1e-3)
            x = held(f, x, [two_loop.tick(qr[k], pulse[k], x[0])], 1e-3)
            assert np.abs(whole.get("q", "qd") - plant.get("q", "qd")).max() < 1e-9
            assert np.abs(whole.get("q", "qd") - x).max() < 1e-8
