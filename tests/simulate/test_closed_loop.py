"""The closed loop of two FMUs: against the Modelica closed loop, against NumPy, and where the noise goes."""

import numpy as np
import pandas as pd
import pytest

from pipeline.errors import ConfigError, DataError
from pipeline.paths import EXPERIMENTS
from pipeline.plant.binding import load_binding
from pipeline.plant.fmu import open_fmu
from pipeline.simulate.closed_loop import LoopPorts, controller_inputs, simulate_closed_loop, simulate_closed_loop_fmu
from pipeline.simulate.measured import ColumnSettings, read_measured
from pipeline.simulate.sensors import Noise, draw_noise
from pipeline.simulate.trajectory import read_waypoints, reference_frame, sample
from tests import reference_loop

SCARA = LoopPorts(
    plant_input=["tau_1", "tau_2"],
    plant_position=["q_1", "q_2"],
    plant_velocity=["qd_1", "qd_2"],
    reference=["qr_1", "qr_2"],
    reference_velocity=["qdr_1", "qdr_2"],
    position=["q_1", "q_2"],
    output=["tau_1", "tau_2"],
)
EMPS = LoopPorts(["u"], ["q"], ["qd"], reference=["qr"], position=["q"], output=["u"], extra=["pulse"])
START = {"q_start_1": 0.2, "q_start_2": -0.3}
JOINTS = (1, 2)


@pytest.fixture(scope="module")
def scara(fmus):
    """The two SCARA FMUs, unpacked once."""
    with open_fmu(fmus / "scara.fmu") as plant, open_fmu(fmus / "scara_controller.fmu") as controller:
        yield plant, controller


def trajectory(name, rate, duration=None):
    motion = sample(read_waypoints(EXPERIMENTS / f"{name}.csv"), rate)
    N = len(motion.t) if duration is None else int(duration * rate) + 1
    return type(motion)(*(getattr(motion, field)[:N] for field in ("t", "q", "qd", "qdd")))


def columns(frame, *names):
    return frame[[f"{name}_{i}" for name in names for i in JOINTS]].to_numpy()


def test_noise_free_the_two_fmus_are_the_modelica_closed_loop(fmus, scara):
    motion = trajectory("scara_identification", 100.0)
    reference = reference_frame(motion)
    start = {f"q_start_{i}": motion.q[0, i - 1] for i in JOINTS}
    ours = simulate_closed_loop(*scara, SCARA, reference, 0.01, plant_start=start, controller_start=start)
    theirs = simulate_closed_loop_fmu(
        fmus / "scara_closed_loop.fmu",
        inputs={name: name for name in reference},
        sampled={f"{name}_{i}": f"{name}_{i}" for name in ("q", "qd") for i in JOINTS},
        held={f"tau_{i}": f"tau_{i}" for i in JOINTS},
        reference=reference,
        period=0.01,
        start=start,
    )
    assert np.abs(columns(ours, "q") - columns(theirs, "q")).max() < 1e-9
    assert np.abs(columns(ours, "qd_true") - columns(theirs, "qd")).max() < 1e-8
    assert np.abs(columns(ours, "tau") - columns(theirs, "tau")).max() < 1e-6
    assert np.abs(columns(ours, "q") - motion.q).max() > 0.01  # it is a loop, not the reference


@pytest.mark.parametrize("loop", ["disturbed", "clean"])
def test_with_noise_the_loop_is_the_one_in_numpy(scara, loop):
    motion = trajectory("scara_identification", 100.0, 6.0)
    (expected,) = reference_loop.simulate(motion, [3], [loop == "disturbed"])
    position, torque = (noise[..., 0] for noise in reference_loop.noises(len(motion.t), [3]))
    # the NumPy controller starts on the noisy position it sees
    seen = motion.q[0] + (position[0] if loop == "disturbed" else 0.0)
    found = simulate_closed_loop(
        *scara,
        SCARA,
        reference_frame(motion),
        0.01,
        Noise(position, torque, loop),
        plant_start={f"q_start_{i}": motion.q[0, i - 1] for i in JOINTS},
        controller_start={f"q_start_{i}": seen[i - 1] for i in JOINTS},
    )
    np.testing.assert_allclose(columns(found, "q_true"), columns(expected, "q_true"), atol=2e-5)
    np.testing.assert_allclose(columns(found, "q"), columns(expected, "q"), atol=2e-5)
    np.testing.assert_allclose(columns(found, "tau"), columns(expected, "tau"), atol=2e-2)


def test_in_the_clean_loop_the_noise_stands_in_the_record_alone(scara):
    reference = reference_frame(trajectory("scara_validation", 100.0, 3.0))
    noise = draw_noise(np.random.default_rng(1), len(reference), [1e-3, 1e-3], [1.0, 0.05], "clean")
    noisy = simulate_closed_loop(*scara, SCARA, reference, 0.01, noise)
    quiet = simulate_closed_loop(*scara, SCARA, reference, 0.01)
    np.testing.assert_array_equal(columns(noisy, "q_true", "qd_true"), columns(quiet, "q_true", "qd_true"))
    np.testing.assert_array_equal(columns(noisy, "tau_true"), columns(quiet, "tau"))
    np.testing.assert_allclose(columns(noisy, "q") - columns(noisy, "q_true"), noise.position, atol=1e-15)
    np.testing.assert_allclose(columns(noisy, "u") - columns(noisy, "tau_true"), noise.input, atol=1e-13)


def test_in_the_disturbed_loop_the_plant_gets_the_noise_and_the_record_the_command(scara):
    reference = reference_frame(trajectory("scara_validation", 100.0, 3.0))
    noise = draw_noise(np.random.default_rng(1), len(reference), [1e-3, 1e-3], [1.0, 0.05])
    frame = simulate_closed_loop(*scara, SCARA, reference, 0.01, noise, gain=[2.0, 0.5])
    np.testing.assert_allclose(columns(frame, "q") - columns(frame, "q_true"), noise.position, atol=1e-15)
    given = columns(frame, "tau_true") / [2.0, 0.5]
    np.testing.assert_allclose(given - columns(frame, "u"), noise.input, atol=1e-13)
    np.testing.assert_allclose(columns(frame, "tau"), columns(frame, "u") * [2.0, 0.5])
    again = simulate_closed_loop(*scara, SCARA, reference, 0.01, noise, gain=[2.0, 0.5])
    pd.testing.assert_frame_equal(frame, again, check_exact=True)


def test_start_values_and_parameters_reach_both_fmus(scara):
    reference = reference_frame(trajectory("scara_validation", 100.0, 0.5))
    frame = simulate_closed_loop(
        *scara, SCARA, reference, 0.01, plant_start=START | {"qd_start_2": 0.5, "Fv1": 0.5}, controller_start=START
    )
    first = frame.iloc[0]
    np.testing.assert_array_equal(first[["q_1", "q_2", "qd_true_1", "qd_true_2"]], [0.2, -0.3, 0.0, 0.5])
    # controller: v = 0 at the first sample, so tau = Kp (qr − q) + Kd qdr, saturated
    np.testing.assert_allclose(first[["tau_1", "tau_2"]], [-40.0, 2.4], atol=1e-12)


def test_emps_two_fmus_are_the_modelica_closed_loop(fmus):
    motion = trajectory("emps_identification", 1000.0, 5.0)
    reference = reference_frame(motion)
    reference["pulse_1"] = 5.0 * ((motion.t % 1.0) > 0.8)
    gain = load_binding("emps").gains_to_set()
    ours = simulate_closed_loop(
        fmus / "emps.fmu", fmus / "emps_controller.fmu", EMPS, reference, 0.001, plant_start=gain
    )
    theirs = simulate_closed_loop_fmu(
        fmus / "emps_closed_loop.fmu",
        inputs={"qr_1": "qr", "pulse_1": "pulse"},
        sampled={"q_1": "q", "qd_1": "qd"},
        held={"u_1": "u"},
        reference=reference,
        period=0.001,
        start=gain,
    )
    assert np.abs(ours["q_1"] - theirs["q_1"]).max() < 1e-9
    assert np.abs(ours["u_1"] - theirs["u_1"]).max() < 1e-5
    assert np.abs(ours["q_1"] - reference["qr_1"]).max() < 0.01


def test_emps_follows_its_measurement(fmus, emps_data):
    mapping = {"time": ("t", "s"), "q_1": ("qm", "m"), "qr_1": ("qg", "m"), "u_1": ("vir", "V")}
    settings = {name: ColumnSettings(source, unit, unit) for name, (source, unit) in mapping.items()}
    measured = read_measured(emps_data / "DATA_EMPS.mat", settings, 1000.0).iloc[:5000]
    start = {"q_start": measured["q_1"].iloc[0], "qd_start": 0.0056}
    frame = simulate_closed_loop(
        fmus / "emps.fmu",
        fmus / "emps_controller.fmu",
        EMPS,
        measured[["qr_1"]],
        0.001,
        plant_start=start,
        controller_start=start,
    )
    error = np.linalg.norm(frame["q_1"] - measured["q_1"]) / np.linalg.norm(measured["q_1"])
    assert error < 1e-4  # 0.001 % with the identified parameters; these are round a-priori values


def test_a_reference_that_does_not_fit_is_refused(scara):
    reference = reference_frame(trajectory("scara_validation", 100.0, 0.1))
    with pytest.raises(DataError, match="no column `qdr_2`"):
        simulate_closed_loop(*scara, SCARA, reference.drop(columns="qdr_2"), 0.01)
    with pytest.raises(ConfigError, match="a sample every 0.01 s, the controller's period is 0.001 s"):
        simulate_closed_loop(*scara, SCARA, reference, 0.001)
    with pytest.raises(DataError, match="1 samples; a closed loop needs at least 2"):
        simulate_closed_loop(*scara, SCARA, reference.iloc[:1], 0.01)
    with pytest.raises(ConfigError, match="noise: 5 samples for a reference of 11"):
        noise = draw_noise(np.random.default_rng(0), 5, [0.0, 0.0], [0.0, 0.0])
        simulate_closed_loop(*scara, SCARA, reference, 0.01, noise)


def test_a_pulse_that_is_not_there_is_zero():
    reference = pd.DataFrame({"qr_1": [1.0, 2.0]}, index=[0.0, 0.001])
    np.testing.assert_array_equal(controller_inputs(EMPS, reference), [[1.0, 0.0], [2.0, 0.0]])
    with_pulse = reference.assign(pulse_1=[3.0, 4.0])
    np.testing.assert_array_equal(controller_inputs(EMPS, with_pulse), [[1.0, 3.0], [2.0, 4.0]])
