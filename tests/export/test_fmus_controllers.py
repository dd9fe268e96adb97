"""Controllers against a recursion in NumPy, tick by tick: saturation, held outputs, repeated ticks, recorded data."""

import numpy as np
import pytest

from tests.export.oracles import SampledPD, TwoLoop

TS = 0.01


def scara_signals(N, seed=3):
    """References and positions (N, 2) each, with steps that saturate both joints."""
    rng = np.random.default_rng(seed)
    t = TS * np.arange(N)[:, None]
    qr = np.array([0.4, 0.9]) * np.sin(t * [3.0, 7.0]) + 0.5 * np.sign(np.sin(t * [5.0, 4.0]))
    return qr, rng.normal(size=(N, 2)), 0.9 * qr + rng.normal(scale=0.01, size=(N, 2))


def ports(qr, qdr, q):
    return dict(qr_1=qr[0], qr_2=qr[1], qdr_1=qdr[0], qdr_2=qdr[1], q_1=q[0], q_2=q[1])


def test_the_sampled_pd_is_the_recursion(archives):
    qr, qdr, q = scara_signals(200)
    start = dict(q_start_1=q[0, 0], q_start_2=q[0, 1], v_start_1=0.3, v_start_2=-0.2)
    expected = SampledPD(q_start=q[0], v_start=(0.3, -0.2))
    saturated = np.zeros(2, dtype=int)
    with archives("scara_controller").co_simulation(**start) as instance:
        for k in range(200):
            instance.set(**ports(qr[k], qdr[k], q[k]))
            instance.step(k * TS, TS)
            tau = expected.tick(qr[k], qdr[k], q[k])
            assert np.abs(instance.get("tau_1", "tau_2") - tau).max() <= 1e-12 * 40
            saturated += np.abs(tau) == expected.tau_max
    assert (saturated > 10).all() and (saturated < 190).all()


def test_the_first_tick_reads_the_inputs_set_after_initialisation_and_starts_at_rest(archives):
    with archives("scara_controller").co_simulation(q_start_1=0.4) as instance:
        instance.set(qr_1=0.41, q_1=0.4)
        instance.step(0.0, TS)
        assert instance.get("tau_1") == pytest.approx(250 * 0.01, rel=1e-12)


def test_between_two_ticks_the_output_is_held_and_nothing_else_happens(archives):
    qr, qdr, q = scara_signals(40)
    rng, h = np.random.default_rng(1), TS / 4
    expected = SampledPD()
    with archives("scara_controller").co_simulation() as instance:
        for k in range(160):
            whole, part = divmod(k, 4)
            if part:
                instance.set(**ports(*rng.normal(size=(3, 2))))
            else:
                instance.set(**ports(qr[whole], qdr[whole], q[whole]))
                tau = expected.tick(qr[whole], qdr[whole], q[whole])
            instance.step(k * h, h)
            assert np.abs(instance.get("tau_1", "tau_2") - tau).max() <= 4e-11


def test_steps_that_miss_the_ticks_catch_every_one(archives):
    """Steps of 4 ms: the ticks at 10 k ms fall into the steps that hold them, with the inputs of those steps."""
    h, expected = 0.004, SampledPD()
    qr, qdr, q = scara_signals(50)
    ticks = 0
    with archives("scara_controller").co_simulation() as instance:
        for k in range(50):
            instance.set(**ports(qr[k], qdr[k], q[k]))
            instance.step(k * h, h)
            if -(-4 * k // 10) * 10 < 4 * k + 4:
                tau, ticks = expected.tick(qr[k], qdr[k], q[k]), ticks + 1
            assert np.abs(instance.get("tau_1", "tau_2") - tau).max() <= 4e-11
    assert ticks == 20


def test_gains_act_at_the_next_tick(archives):
    qr, qdr, q = scara_signals(20)
    expected, tau = SampledPD(), np.zeros(2)
    with archives("scara_controller").co_simulation() as instance:
        for k in range(20):
            if k == 10:
                instance.set(Kp_1=100.0, Kd_2=0.5, Tf=0.05, tau_max_1=7.0)
                assert np.abs(instance.get("tau_1", "tau_2") - tau).max() <= 4e-11
                expected.Kp[0], expected.Kd[1], expected.Tf, expected.tau_max[0] = 100.0, 0.5, 0.05, 7.0
            instance.set(**ports(qr[k], qdr[k], q[k]))
            instance.step(k * TS, TS)
            tau = expected.tick(qr[k], qdr[k], q[k])
            assert np.abs(instance.get("tau_1", "tau_2") - tau).max() <= 4e-11


def test_in_model_exchange_a_second_event_at_the_same_instant_changes_nothing(archives):
    qr, qdr, q = scara_signals(30)
    expected = SampledPD()
    with archives("scara_controller").event_mode() as instance:
        for k in range(30):
            if k:
                instance.fmu.setTime(k * TS)
                instance.fmu.enterEventMode()
            instance.set(**ports(qr[k], qdr[k], q[k]))
            instance.settle()
            instance.fmu.enterContinuousTimeMode()
            tau = expected.tick(qr[k], qdr[k], q[k])
            following = instance.event(**ports(*np.ones((3, 2))))
            assert following == pytest.approx((k + 1) * TS, abs=1e-12)
            assert np.abs(instance.get("tau_1", "tau_2") - tau).max() <= 4e-11


def test_in_co_simulation_a_step_of_zero_ticks_and_the_next_one_does_not_tick_again(archives):
    expected = SampledPD()
    with archives("scara_controller").co_simulation() as instance:
        for k in range(3):
            instance.set(q_1=0.01 * k + 0.01)
            instance.step(k * TS, 0.0)
            tau = expected.tick(np.zeros(2), np.zeros(2), np.array([0.01 * k + 0.01, 0.0]))
            instance.set(q_1=7.0)
            instance.step(k * TS, TS)
            assert np.abs(instance.get("tau_1", "tau_2") - tau).max() <= 4e-11


def test_a_start_between_two_samples_waits_for_the_next_one(archives):
    with archives("scara_controller").co_simulation(start=0.005) as instance:
        instance.set(qr_1=0.01)
        instance.step(0.005, 0.004)
        assert instance.get("tau_1") == 0
        instance.step(0.009, 0.004)
        assert instance.get("tau_1") == pytest.approx(2.5, rel=1e-12)


def test_the_continuous_pd_is_the_exact_exponential_under_held_inputs(archives):
    """With q held, q_f tends to q with exp(−t/Tf): v = (q − q_f)/Tf exactly."""
    qr, qdr, q = scara_signals(100)
    q_f = q[0].copy()
    with archives("scara_controller_continuous").co_simulation(q_start_1=q[0, 0], q_start_2=q[0, 1]) as instance:
        for k in range(100):
            instance.set(**ports(qr[k], qdr[k], q[k]))
            instance.step(k * TS, TS)
            q_f = q[k] + (q_f - q[k]) * np.exp(-TS / 0.02)
            v = (q[k] - q_f) / 0.02
            tau = np.clip([250, 8] * (qr[k] - q[k]) + [45, 0.9] * (qdr[k] - v), [-40, -6], [40, 6])
            assert np.abs(instance.get("tau_1", "tau_2") - tau).max() < 1e-6


def test_the_continuous_pd_starts_with_the_velocity_given(archives):
    start = dict(q_start_1=0.2, v_start_1=0.7)
    with archives("scara_controller_continuous").co_simulation(**start, q_1=0.2, qr_1=0.2) as instance:
        assert instance.get("joint_1.v", "tau_1") == pytest.approx([0.7, -45 * 0.7], rel=1e-12)


def test_the_two_loop_controller_is_the_recursion(archives):
    rng, expected = np.random.default_rng(5), TwoLoop(q_start=1e-3, qd_start=0.02)
    t = 1e-3 * np.arange(400)
    qr = 0.02 * np.sin(20 * t)
    q, pulse = 0.97 * qr + rng.normal(scale=2e-5, size=400), 5.0 * (np.sin(60 * t) > 0.8)
    saturated = 0
    with archives("emps_controller").co_simulation(q_start=1e-3, qd_start=0.02) as instance:
        for k in range(400):
            instance.set(qr=qr[k], pulse=pulse[k], q=q[k])
            instance.step(t[k], 1e-3)
            u = expected.tick(qr[k], pulse[k], q[k])
            assert abs(instance.get("u")[0] - u) <= 1e-10
            saturated += abs(u) == 10.0
    assert 20 < saturated < 380


def test_a_motion_that_goes_on_as_it_began_has_its_velocity_from_the_first_tick_on(archives):
    with archives("emps_controller").co_simulation(q_start=0.3, qd_start=0.02) as instance:
        for k in range(5):
            q = 0.3 + 0.02 * 1e-3 * k
            instance.set(qr=q, q=q)
            instance.step(1e-3 * k, 1e-3)
            assert instance.get("u") == pytest.approx(-243.45 * 0.02, rel=1e-9)


@pytest.mark.parametrize(("file", "rms", "worst"), [("DATA_EMPS", 0.004, 0.05), ("DATA_EMPS_PULSES", 0.005, 0.05)])
def test_the_recorded_command_comes_out_of_the_recorded_motion(archives, emps_data, file, rms, worst):
    """Open loop on the measured position: the order of pulse and limit, and the past before the first sample."""
    from scipy.io import loadmat

    data = {k: np.ravel(v).astype(float) for k, v in loadmat(emps_data / f"{file}.mat").items() if k[0] != "_"}
    pulse = 5.069 * (data.get("pulses_N", np.zeros_like(data["qm"])) > 0)
    N, found = 8000, []
    with archives("emps_controller").co_simulation(q_start=data["qm"][0], qd_start=0.0056) as instance:
        for k in range(N):
            instance.set(qr=data["qg"][k], pulse=pulse[k], q=data["qm"][k])
            instance.step(1e-3 * k, 1e-3)
            found.append(instance.get("u")[0])
    error = np.array(found) - data["vir"][:N]
    assert np.sqrt(np.mean(error**2)) < rms and np.abs(error).max() < worst
    assert pulse[:N].any() or "PULSES" not in file
