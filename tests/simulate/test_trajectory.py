"""Way-point trajectories: the polynomials against SciPy, the limits, the reader's refusals, the stored ones."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.interpolate import BPoly

from pipeline.errors import ConfigError, DataError
from pipeline.paths import EXPERIMENTS
from pipeline.simulate.trajectory import (
    Limits,
    Waypoints,
    check_limits,
    evaluate,
    read_waypoints,
    reference_frame,
    sample,
    write_waypoints,
)
from tests.closed_form import TRUTH, inverse_model

SCARA_LIMITS = Limits(q=[1.5, 2.4], qd=[2.8, 6.0], qdd=[4.5, 45.0], tau=[16.0, 3.0])
EMPS_LIMITS = Limits(q=[0.12], qd=[0.35], qdd=[2.0], tau=[280.0])


def random_waypoints(seed, K=5, n=2):
    rng = np.random.default_rng(seed)
    return Waypoints(np.cumsum(rng.uniform(0.3, 2.0, K)), *rng.normal(size=(3, K, n)))


def scara_torque(q, qd, qdd):
    return inverse_model(q, qd, qdd)[0] @ TRUTH


def emps_force(q, qd, qdd):
    return 95.0 * qdd + 200.0 * qd + 20.0 * np.sign(qd) - 3.0


@given(st.integers(0, 2**32 - 1))
@settings(max_examples=20, deadline=None)
def test_evaluate_equals_scipys_hermite_polynomials(seed):
    waypoints = random_waypoints(seed)
    t = np.linspace(waypoints.t[0], waypoints.t[-1], 97)
    motion = evaluate(waypoints, t)
    for i in range(2):
        derivatives = np.stack([waypoints.q[:, i], waypoints.qd[:, i], waypoints.qdd[:, i]], axis=1)
        oracle = BPoly.from_derivatives(waypoints.t, derivatives)
        for order, values in enumerate((motion.q, motion.qd, motion.qdd)):
            expected = oracle.derivative(order)(t) if order else oracle(t)
            np.testing.assert_allclose(values[:, i], expected, rtol=1e-9, atol=1e-9 * np.abs(expected).max())


def test_evaluate_passes_through_the_waypoints_and_keeps_the_acceleration_continuous():
    waypoints = random_waypoints(3)
    at = evaluate(waypoints, waypoints.t)
    before = evaluate(waypoints, waypoints.t[1:] - 1e-10)
    for name in ("q", "qd", "qdd"):
        np.testing.assert_allclose(getattr(at, name), getattr(waypoints, name), atol=1e-12)
        np.testing.assert_allclose(getattr(before, name), getattr(waypoints, name)[1:], atol=1e-6)


def test_sample_holds_both_ends():
    waypoints = Waypoints(np.array([1.0, 3.5]), *np.zeros((3, 2, 1)))
    t = sample(waypoints, 100.0).t
    assert len(t) == 251 and t[0] == 1.0 and t[-1] == pytest.approx(3.5, abs=1e-12)


def test_check_limits_names_joint_time_value_and_limit():
    waypoints = Waypoints(np.array([0.0, 1.0]), np.array([[0.0, 0.0], [0.1, 1.0]]), *np.zeros((2, 2, 2)))
    check_limits(waypoints, Limits(q=[0.2, 1.0], qd=(2.0, 2.0), qdd=None))
    for wrong in ([1.0], [1.0, 1.0, 1.0]):
        with pytest.raises(ConfigError, match=f"limits of qd: {len(wrong)} for 2 joints"):
            check_limits(waypoints, Limits(qd=wrong))
    with pytest.raises(DataError, match=r"joint 2 at t = 0\.\d+ s has q = 0\.5\d*, its limit is 0\.5"):
        check_limits(waypoints, Limits(q=np.array([0.2, 0.5])))
    with pytest.raises(DataError, match=r"joint 1 .* has tau = .*limit is 0\.01"):
        check_limits(waypoints, Limits(tau=np.array([0.01, 9.0])), force=lambda q, qd, qdd: qdd)
    with pytest.raises(ConfigError, match="inverse model"):
        check_limits(waypoints, Limits(tau=np.array([1.0, 1.0])))


@given(st.integers(0, 2**32 - 1), st.sampled_from(["rad", "m"]))
@settings(max_examples=20, deadline=None)
def test_waypoints_survive_a_round_trip_through_the_file(tmp_path_factory, seed, unit):
    path = tmp_path_factory.mktemp("waypoints") / "w.csv"
    written = random_waypoints(seed)
    write_waypoints(path, Waypoints(written.t, written.q, written.qd, written.qdd, unit))
    back = read_waypoints(path)
    assert back.unit == unit
    for name in ("t", "q", "qd", "qdd"):
        np.testing.assert_allclose(getattr(back, name), getattr(written, name), rtol=1e-11)


def test_read_waypoints_converts_degrees(tmp_path):
    path = tmp_path / "w.csv"
    path.write_text("time [ms],q_1 [deg],qd_1 [deg/s],qdd_1 [deg/s2]\n0,0,0,0\n500,180,90,360\n")
    waypoints = read_waypoints(path)
    assert waypoints.unit == "rad" and waypoints.t[1] == 0.5
    values = [waypoints.q[1, 0], waypoints.qd[1, 0], waypoints.qdd[1, 0]]
    np.testing.assert_allclose(values, [np.pi, np.pi / 2, 2 * np.pi])


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("time [s],qd_1 [rad/s]\n0,0\n1,0\n", "no column `q_1 .rad.` or"),
        ("time [s],q_1\n0,0\n1,0\n", "column `q_1`, row 1: no unit"),
        ("time [s],q_1 [rad],qd_1 [rad/s]\n0,0,0\n1,0,0\n", "no column `qdd_1`"),
        ("time [s],q_1 [rad],qd_1 [m/s],qdd_1 [rad/s2]\n0,0,0,0\n1,0,0,0\n", "column `qd_1`: unit `m/s`"),
        ("time [s],q_1 [rad],qd_1 [rad/s],qdd_1 [rad/s2]\n0,0,0,0\n", "1 way-points"),
        ("time [s],q_1 [rad],qd_1 [rad/s],qdd_1 [rad/s2]\n0,0,0,0\n2,0,0,0\n1,0,0,0\n", "column `time`, row 4"),
        ("time [s],q_1 [rad],qd_1 [rad/s],qdd_1 [rad/s2]\n0,0,0,0\n2,0,x,0\n", "column `qd_1`, row 3: 'x'"),
    ],
)
def test_read_waypoints_refuses_in_one_line(tmp_path, text, message):
    path = tmp_path / "w.csv"
    path.write_text(text)
    with pytest.raises(DataError, match=message) as caught:
        read_waypoints(path)
    assert "w.csv" in str(caught.value) and "\n" not in str(caught.value)


def test_reference_frame_has_positions_and_velocities():
    motion = sample(random_waypoints(1), 10.0)
    frame = reference_frame(motion)
    assert list(frame) == ["qr_1", "qr_2", "qdr_1", "qdr_2"] and frame.index.name == "time"
    np.testing.assert_array_equal(frame["qdr_2"], motion.qd[:, 1])


@pytest.mark.parametrize("run", ["identification", "validation"])
def test_scara_trajectories_keep_their_limits_and_start_and_end_at_rest(run):
    waypoints = read_waypoints(EXPERIMENTS / f"scara_{run}.csv")
    check_limits(waypoints, SCARA_LIMITS, scara_torque)
    assert waypoints.t[0] == 0.0
    for rest in (waypoints.qd[[0, -1]], waypoints.qdd[[0, -1]]):
        np.testing.assert_array_equal(rest, 0.0)


@pytest.mark.parametrize("run", ["identification", "validation"])
def test_emps_trajectories_keep_their_limits(run):
    check_limits(read_waypoints(EXPERIMENTS / f"emps_{run}.csv"), EMPS_LIMITS, emps_force)


def test_scara_identification_is_exciting():
    waypoints = read_waypoints(EXPERIMENTS / "scara_identification.csv")
    np.testing.assert_allclose(np.diff(waypoints.t), 1.25)
    assert len(waypoints.t) == 21
    motion = sample(waypoints, 100.0)
    D, _ = inverse_model(motion.q, motion.qd, motion.qdd)
    W = np.vstack([D[:, 0] / 1.0, D[:, 1] / 0.05])
    assert np.linalg.cond(W) <= 250.0
    assert np.linalg.cond((W * TRUTH)[:, TRUTH != 0]) <= 160.0
    # log det of the relative information, of LMY2 (0) relative to its scale: that of the design before this one
    relative = W * np.where(TRUTH == 0.0, 0.05, TRUTH)
    assert np.linalg.slogdet(relative.T @ relative)[1] >= 70.4156
    bound = np.linalg.norm(np.linalg.pinv(W), axis=1)  # of sigma: slow enough that Fv1 stays the weakest
    assert bound[1] >= 0.02


def test_scara_validation_is_another_motion():
    runs = [sample(read_waypoints(EXPERIMENTS / f"scara_{run}.csv"), 100.0) for run in ("identification", "validation")]
    N = min(len(run.t) for run in runs)
    for i in range(2):
        a, b = (run.q[:N, i] - run.q[:N, i].mean() for run in runs)
        assert abs(a @ b) < 0.5 * np.linalg.norm(a) * np.linalg.norm(b)
