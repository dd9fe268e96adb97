"""The two FMUs near a rest: the plant against its closed form, the controller's pulse responses against its law."""

import numpy as np
import pytest
from msgspec import structs

from pipeline.errors import ConfigError, FmuError
from pipeline.paths import BINDINGS, built_fmu
from pipeline.plant.binding import load_binding
from pipeline.plant.fmu import open_fmu
from pipeline.plant.linearisation import answers_alike, linear_plant, parameters, pulse_responses
from pipeline.plant.plant import open_plant
from pipeline.signals.bandwidth import realise
from pipeline.workflow.session import open_session
from tests.closed_form import NAMES, TRUTH

Q = np.array([0.4, -1.1])


@pytest.fixture(scope="module")
def scara(fmus):
    return open_session("scara")


@pytest.fixture(scope="module")
def emps(fmus):
    return open_session("emps", simulated=True)


def mass(q2):
    p = dict(zip(NAMES, TRUTH, strict=True))
    coupled = p["ZZ2"] + p["LMX2"] * np.cos(q2)
    return np.array([[p["ZZR1"] + 2 * coupled - p["ZZ2"], coupled], [coupled, p["ZZ2"]]])


def test_the_plant_at_rest_is_its_mass_and_its_viscous_friction(scara):
    with open_plant(scara.binding, "linearise") as plant:
        found = linear_plant(plant, Q)
    inverse = np.linalg.inv(mass(Q[1]))
    np.testing.assert_allclose(found.B, np.vstack([inverse, np.zeros((2, 2))]), rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(found.A[:2, :2], -inverse @ np.diag([0.07, 0.015]), rtol=1e-7, atol=1e-9)
    np.testing.assert_allclose(found.A[2:], np.hstack([np.eye(2), np.zeros((2, 2))]), atol=1e-9)
    np.testing.assert_allclose(found.A[:2, 2:], 0.0, atol=1e-7)
    np.testing.assert_allclose(found.u, 0.0, atol=1e-12)


def test_coulomb_friction_left_on_is_a_huge_damping(scara):
    """58 N·m·s/rad on joint 1 where viscous friction is 0.07: what `[linearise]` is for."""
    binding = structs.replace(scara.binding, linearise={"eps": 0.01})
    with open_plant(binding, "linearise") as plant:
        found = linear_plant(plant, Q)
    damping = -mass(Q[1]) @ found.A[:2, :2]
    np.testing.assert_allclose(np.diag(damping), [58.07, 15.615], rtol=1e-3)


def test_the_input_holds_the_plant_at_rest(emps):
    """The drive's force offset: u = offset/gain."""
    with open_plant(emps.binding, "linearise") as plant:
        found = linear_plant(plant, np.array([0.1]))
        still = plant.derivatives(np.array([0.0, 0.1]), found.u, parameters(emps.binding))
    np.testing.assert_allclose(found.u, -3.0 / 35.1507, rtol=1e-6)
    np.testing.assert_allclose(still, 0.0, atol=1e-9)
    assert parameters(emps.binding)[2] == 0.0, "Fc is off"


def sampled_pd(samples):
    """Markov parameters of u = Kp (qr − q) − Kd v, v(k) = (Tf v(k−1) + q(k) − q(k−1))/(Tf + dt)."""
    H, Tf, dt = np.zeros((2, 4, samples)), 0.02, 0.01
    for i, (Kp, Kd) in enumerate(((250.0, 45.0), (8.0, 0.9))):
        v, before = 0.0, 0.0
        for k in range(samples):
            q = float(k == 0)
            v = (Tf * v + q - before) / (Tf + dt)
            before = q
            H[i, i, k], H[i, 2 + i, k] = Kp * q, -Kp * q - Kd * v
    return H


@pytest.mark.parametrize("q", [np.zeros(2), Q], ids=["at zero", "elsewhere"])
def test_pulses_find_the_sampled_pd_law(scara, q):
    controller = scara.experiment.controller
    with open_fmu(scara.controller_fmu) as file:
        H = pulse_responses(file, controller, q, scara.binding.u_range)
        assert answers_alike(file, controller, -q, scara.binding.u_range, H)
    expected = sampled_pd(H.shape[2])
    np.testing.assert_allclose(H, expected, atol=1e-9 * np.abs(expected).max())
    law = realise(H, 0.01)
    np.testing.assert_allclose(np.sort(np.abs(law.poles())), [2 / 3, 2 / 3], rtol=1e-9)


def test_pulses_find_the_two_loop_law_of_the_drive(emps):
    with open_fmu(emps.controller_fmu) as file:
        H = pulse_responses(file, emps.experiment.controller, np.array([0.05]), emps.binding.u_range)
    kp, kv, dt = 160.18, 243.45, 0.001
    expected = np.zeros((1, 2, H.shape[2]))
    expected[0, 0, 0] = kp * kv
    expected[0, 1, :3] = -kp * kv - 0.5 * kv / dt, 0.0, 0.5 * kv / dt
    np.testing.assert_allclose(H, expected, atol=1e-8 * kp * kv)


def test_a_continuous_controller_is_taken_as_the_loop_samples_it(scara):
    """Its filter moves on while the input is held: v behind the step decays by exp(−dt/Tf) from sample to sample."""
    with open_fmu(built_fmu("scara_controller_continuous")) as file:
        H = pulse_responses(file, scara.experiment.controller, Q, scara.binding.u_range)
    decay = np.exp(-0.5)
    np.testing.assert_allclose(H[0, 0, :2], [250.0, 0.0], atol=1e-6)
    np.testing.assert_allclose(H[0, 2, 0], -250.0 - 45.0 / 0.02 * decay, rtol=1e-6)
    np.testing.assert_allclose(H[0, 2, 2:20] / H[0, 2, 1:19], decay, rtol=1e-6)


def test_a_controller_that_saturates_on_small_pulses_is_refused(scara):
    controller = structs.replace(scara.experiment.controller, start={"tau_max_1": 1e-3})
    with (
        open_fmu(scara.controller_fmu) as file,
        pytest.raises(ConfigError, match=r"not linear in `qr_1` at rest at \[.*\]: pulses of 1e-06 and") as error,
    ):
        pulse_responses(file, controller, Q, scara.binding.u_range)
    assert "\n" not in str(error.value)


def test_other_gains_elsewhere_would_be_seen(scara):
    controller = scara.experiment.controller
    with open_fmu(scara.controller_fmu) as file:
        H = pulse_responses(file, controller, Q, scara.binding.u_range)
        other = structs.replace(controller, start={"Kp_2": 8.1})
        assert not answers_alike(file, other, Q, scara.binding.u_range, H)


def test_a_plant_that_no_input_moves_is_refused(scara):
    with open_plant(scara.binding, "linearise") as plant:
        plant.derivatives = lambda s, u, chi: np.zeros(4)
        with pytest.raises(FmuError, match=r"scara\.fmu: its inputs do not move every joint"):
            linear_plant(plant, Q)


def test_a_binding_may_only_set_what_the_plant_has(fmus, tmp_path):
    text = (BINDINGS / "scara.toml").read_text()
    (tmp_path / "scara.toml").write_text(text.replace("Fs1 = 0.0\nFs2", "Fs3 = 0.0\nFs2"))
    (tmp_path / "scara.fmu").write_bytes(built_fmu("scara").read_bytes())
    with (
        pytest.raises(ConfigError, match="no variable `Fs3`; nearest: Fs"),
        open_plant(load_binding(str(tmp_path / "scara.toml"))),
    ):
        pass
