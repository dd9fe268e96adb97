"""Simulated records as measured data, and encoders: the same estimates, the truth again."""

import numpy as np
import pytest

from pipeline.errors import ConfigError
from pipeline.paths import EXPERIMENTS
from pipeline.simulate.writing import write_frame
from pipeline.workflow.acquire import acquire, frame_units, simulate
from pipeline.workflow.batch import open_inverse_model, run_variant
from pipeline.workflow.filtering import run_case
from pipeline.workflow.loop import follow_loop
from pipeline.workflow.run import identify
from pipeline.workflow.session import open_session

STEP = 2 * np.pi / 16384
ENCODERS = [f"simulation.quantum_q=[{STEP}, {STEP}]", "simulation.sigma_q=[0.0, 0.0]"]
ONE_CASE = [
    "ekf.case=[{name='EKF', tunings=['derived'], wls_factor=1.0, P0_sigmas=4.0, method='euler'}]",
    "ekf.recommended=EKF",
]


@pytest.fixture
def measured(fmus, tmp_path):
    """The experiment `scara` on its own simulated record, one run as CSV, one as Parquet, without a mapping."""
    session = open_session("scara")
    for name, validation in (("run.csv", False), ("other.parquet", True)):
        write_frame(acquire(session, validation), frame_units(session.binding), str(tmp_path / name))
    text = (EXPERIMENTS / "scara.toml").read_text()
    data = '[data]\nidentification = "run.csv"\nvalidation = "other.parquet"\nrate = 100.0\n'
    (tmp_path / "mine.toml").write_text(text + data)
    return tmp_path / "mine.toml"


def test_a_simulated_record_read_back_gives_the_same_estimates(measured):
    ours, theirs = (identify(open_session(name, ONE_CASE))[0]["estimates"] for name in ("scara", str(measured)))
    assert list(ours) == list(theirs) == ["WLS(1)", "WLS(2)", "WLS(3)", "RLS", "EKF"]
    for name, estimate in ours.items():
        for parameter, found in estimate["parameters"].items():
            assert theirs[name]["parameters"][parameter]["value"] == found["value"]


def test_the_frame_read_back_is_the_frame_that_was_written(measured):
    for validation in (False, True):
        session = open_session(str(measured), ONE_CASE)
        theirs, ours = acquire(session, validation), simulate(open_session("scara"), validation)
        np.testing.assert_array_equal(theirs, ours[theirs.columns])
        assert set(theirs) == {f"{c}_{i}" for c in ("q", "u", "tau", "qr", "qdr") for i in (1, 2)}


@pytest.mark.parametrize("loop", ["disturbed", "clean"])
def test_an_encoder_acts_where_the_sensor_is(fmus, loop):
    """Every record is a multiple of the step; the controller alone of a disturbed loop has seen it."""
    still = [*ENCODERS, "simulation.sigma_u=[0.0, 0.0]", f"simulation.loop={loop}"]
    frame, again = (simulate(open_session("scara", still)) for _ in range(2))
    assert frame.equals(again)
    exact = simulate(open_session("scara", still), noisy=False)
    for i in (1, 2):
        steps = frame[f"q_{i}"] / STEP
        np.testing.assert_allclose(steps, np.round(steps), atol=1e-6)
        assert (frame[f"q_{i}"] - frame[f"q_true_{i}"]).abs().max() <= 0.5 * STEP * (1 + 1e-9)
        assert frame[f"q_true_{i}"].equals(exact[f"q_true_{i}"]) == (loop == "clean")


@pytest.mark.parametrize(("seed", "loop"), [(1, "disturbed"), (2, "disturbed"), (3, "clean")])
def test_wls_and_the_filter_find_the_truth_through_an_encoder(fmus, seed, loop):
    """With noise of about its step: by an encoder alone the error is coloured, and the page withholds WLS's sigma."""
    noise = ["simulation.sigma_q=[5e-4, 5e-4]", f"seed={seed}", f"simulation.loop={loop}"]
    session = open_session("scara", [ENCODERS[0], *noise])
    case = next(c for c in session.experiment.ekf.case if c.wls_factor and c.method is None)
    frame = acquire(session)
    session, _ = follow_loop(session, frame)
    with open_inverse_model(session, frame) as model:
        best = run_variant(session, frame, model, session.recommended)
    found = run_case(session, frame, best, case, "known")
    np.testing.assert_allclose(found.settings["R"], 5e-4**2 + STEP**2 / 12)
    for estimate in (best.estimate, found.estimate):
        assert np.all(np.abs(estimate.theta - session.truth) < 4 * estimate.sigma), estimate.name


def test_the_known_tuning_needs_noise_on_every_position():
    for off in ("simulation.sigma_q=[0.001, 0.0]", "simulation.sigma_q=[0.0, 0.0]"):
        with pytest.raises(ConfigError, match=r"the tuning `known` needs noise on every position, joint [12] has none"):
            open_session("scara", [off])
    open_session("scara", ["simulation.sigma_q=[0.001, 0.0]", f"simulation.quantum_q=[0.0, {STEP}]"])
    with pytest.raises(ConfigError, match="simulation.quantum_q has 1 entries, the plant asks for 2"):
        open_session("scara", ["simulation.quantum_q=[1e-3]"])
