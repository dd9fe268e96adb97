"""Bandwidth and margins of sampled loops: against closed forms, against python-control's own, and what is refused."""

import control
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pipeline.errors import ConfigError
from pipeline.signals.bandwidth import analyse, close, realise, sampled_plant

DT = 1e-4


def double_integrator(m=1.0, d=0.0):
    """m qdd = u − d qd: A, B of [qd, q]."""
    return np.array([[-d / m, 0.0], [1.0, 0.0]]), np.array([[1.0 / m], [0.0]])


def pd_law(kp, kd, period):
    """u = kp (r − q) − kd·(q(k) − q(k−1))/period, as a state-space system."""
    return control.ss([[0.0]], [[0.0, 1.0]], [[kd / period]], [[kp, -kp - kd / period]], period)


def markov_of(system, samples=64):
    impulse = [system.D]
    for k in range(samples - 1):
        impulse.append(system.C @ np.linalg.matrix_power(system.A, k) @ system.B)
    return np.stack(impulse, axis=2)


@settings(max_examples=25, deadline=None)
@given(w0=st.floats(5.0, 60.0), zeta=st.floats(0.2, 1.5))
def test_a_second_order_loop_has_the_bandwidth_of_its_formula(w0, zeta):
    """Sampled fast, T = w0²/(s² + 2 zeta w0 s + w0²), whose −3 dB frequency is known in closed form."""
    loop = analyse(sampled_plant(*double_integrator(), DT), pd_law(w0**2, 2 * zeta * w0, DT))
    a = 1 - 2 * zeta**2
    # |T|² = 10^-0.3, solved for (w/w0)²
    expected = w0 * np.sqrt(a + np.sqrt(a**2 - 1 + 10**0.3)) / (2 * np.pi)
    assert loop.bandwidth[0] == pytest.approx(expected, rel=0.01)
    if zeta < 0.6:
        assert loop.gain.max() == pytest.approx(1 / (2 * zeta * np.sqrt(1 - zeta**2)), rel=0.01)


def test_the_phase_margin_is_that_of_the_second_order_loop():
    w0, zeta = 20.0, 0.5
    loop = analyse(sampled_plant(*double_integrator(d=2 * zeta * w0), DT), pd_law(w0**2, 0.0, DT))
    crossover = w0 * np.sqrt(np.sqrt(1 + 4 * zeta**4) - 2 * zeta**2)
    phase = np.degrees(np.arctan(2 * zeta * w0 / crossover))
    assert loop.margins[0].phase_at == pytest.approx(crossover / (2 * np.pi), rel=1e-3)
    assert loop.margins[0].phase == pytest.approx(phase, abs=0.1)  # the hold costs 0.05 degrees


def two_joints(period=0.01):
    M = np.array([[3.7, 0.195], [0.195, 0.064]])
    A = np.zeros((4, 4))
    A[:2, :2], A[2:, :2] = -np.linalg.solve(M, np.diag([0.07, 0.015])), np.eye(2)
    laws = [pd_law(kp, kd, period) for kp, kd in ((250.0, 45.0), (8.0, 0.9))]
    controller = control.append(*laws)[:, [0, 2, 1, 3]]
    return sampled_plant(A, np.vstack([np.linalg.inv(M), np.zeros((2, 2))]), period), controller


def test_margins_of_coupled_joints_are_python_controls_of_each_loop_closed_by_hand():
    plant, controller = two_joints()
    L = -(controller[:, 2:] * plant)
    loop = analyse(plant, controller)
    for i, j in ((0, 1), (1, 0)):
        w = 2 * np.pi * np.geomspace(1e-2, 50.0, 2000)
        r = np.moveaxis(L(np.exp(1j * w * 0.01)), 2, 0)
        broken = r[:, i, i] - r[:, i, j] * r[:, j, i] / (1 + r[:, j, j])
        gain, phase, modulus, gain_at, phase_at, modulus_at = control.stability_margins(control.frd(broken, w))
        m = loop.margins[i]
        np.testing.assert_allclose([m.gain, m.phase, m.modulus], [gain, phase, modulus], rtol=2e-3)
        np.testing.assert_allclose(2 * np.pi * np.array([m.gain_at, m.phase_at]), [gain_at, phase_at], rtol=2e-3)
        assert 2 * np.pi * m.modulus_at == pytest.approx(modulus_at, rel=0.05)


def test_the_closed_loop_is_the_recursion_of_plant_and_controller():
    """Sample by sample: the controller answers to q(t_k) at once, the plant holds it until t_k+1."""
    plant, controller = two_joints()
    reference = np.random.default_rng(0).standard_normal((200, 2))
    x, z, q = np.zeros(plant.nstates), np.zeros(controller.nstates), np.empty((200, 2))
    for k, r in enumerate(reference):
        q[k] = plant.C @ x
        seen = np.concatenate([r, q[k]])
        u = controller.C @ z + controller.D @ seen
        z = controller.A @ z + controller.B @ seen
        x = plant.A @ x + plant.B @ u
    found = control.forced_response(close(plant, controller), inputs=reference.T).outputs.T
    np.testing.assert_allclose(found, q, atol=1e-10 * np.abs(q).max())


@settings(max_examples=30, deadline=None)
@given(order=st.integers(0, 6), seed=st.integers(0, 999))
def test_pulse_responses_come_back_as_the_system_they_are_of(order, seed):
    rng = np.random.default_rng(seed)
    poles = rng.uniform(-0.95, 1.0, order)
    system = control.ss(
        np.diag(poles),
        rng.standard_normal((order, 4)),
        rng.standard_normal((2, order)),
        rng.standard_normal((2, 4)),
        0.01,
    )
    scaled = np.array([[1.0], [1e4]])[:, :, None] * markov_of(system)
    found = realise(scaled, 0.01)
    assert found.dt == 0.01 and found.nstates <= order
    size = np.abs(scaled).max(axis=(1, 2))[:, None, None]
    np.testing.assert_allclose(markov_of(found) / size, scaled / size, atol=1e-6)


def test_an_integrator_and_a_static_gain_are_realised():
    constant = np.zeros((1, 2, 64))
    constant[0, :, 0] = 3.0, -3.0
    assert realise(constant, 0.01).nstates == 0
    integral = np.full((1, 2, 64), 0.1)
    found = realise(integral, 0.01)
    assert found.nstates == 1 and found.poles()[0] == pytest.approx(1.0)


def test_a_response_of_no_low_order_system_is_refused():
    noise = np.random.default_rng(0).standard_normal((1, 2, 64))
    with pytest.raises(ConfigError, match="not those of a linear system"):
        realise(noise, 0.01)


@pytest.mark.parametrize(
    ("kp", "kd", "message"),
    [
        (100.0, 0.0, r"not stable, its largest pole has magnitude 1\.00"),
        (100.0, 300.0, "not stable"),
        (0.0, 10.0, "not stable"),
        (1e-9, 10.0, "not stable|no −3 dB bandwidth"),
    ],
)
def test_a_loop_without_a_bandwidth_is_refused_in_one_line(kp, kd, message):
    """Oscillating; the derivative too strong for the sampling; no position feedback; next to none."""
    with pytest.raises(ConfigError, match=message) as error:
        analyse(sampled_plant(*double_integrator(), 0.01), pd_law(kp, kd, 0.01))
    assert "\n" not in str(error.value)


def test_a_loop_as_fast_as_its_sampling_is_refused():
    """Dead-beat in one sample: the gain never falls."""
    A, B = np.array([[-2000.0, 0.0], [1.0, 0.0]]), np.array([[2000.0], [0.0]])
    plant = sampled_plant(A, B, 0.01)
    law = control.ss([], [], [], [[100.0, -100.0]], 0.01)
    with pytest.raises(ConfigError, match="no −3 dB bandwidth below Nyquist"):
        analyse(plant, law)
