"""Torque prediction on the other trajectory, beside the noise floor."""

import msgspec
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pipeline.assess.validation import noise_floor, passed_noise, predict, relative_error, white_level
from pipeline.identify.regression import regression
from pipeline.identify.wls import wls
from pipeline.settings import Filter
from pipeline.signals.filters import low_pass
from pipeline.signals.frames import filter_frame
from tests.closed_form import NAMES, TRUTH, UNITS, inverse_model
from tests.reference_loop import RATE, WLS_1, WLS_3, records, validation_record


def system(frame, settings=WLS_3):
    return regression(filter_frame(frame, 2, RATE, settings), 2, RATE, settings, inverse_model, NAMES)


@given(st.floats(0.01, 100), st.floats(-3, 3))
def test_relative_error_is_free_of_scale(scale, share):
    y = np.array([1.0, -2.0, 3.0])
    assert relative_error(scale * y, scale * (1 + share) * y) == pytest.approx(100 * abs(share), abs=1e-9)


def test_relative_error_of_nothing():
    assert relative_error(np.zeros(3), np.zeros(3)) == 0.0
    assert relative_error(np.zeros(3), np.ones(3)) == np.inf


def test_a_good_estimate_predicts_to_the_noise_floor_and_a_biased_one_does_not():
    validation = system(validation_record())
    good, bad = (wls(system(records("disturbed")[0], s), s.name, UNITS).theta for s in (WLS_3, WLS_1))
    floor = noise_floor(validation, TRUTH, validation_record(), RATE, WLS_3)
    for key in ("tau_1", "tau_2", "total"):
        assert predict(validation, good).errors[key] < 1.1 * floor[key]
        assert predict(validation, bad).errors[key] > 5 * floor[key]
    assert floor["tau_1"] < 10 and floor["tau_2"] < 10


def test_prediction_carries_the_series():
    validation = system(validation_record())
    found = predict(validation, TRUTH)
    K = len(validation.y) // 2
    assert found.measured.shape == found.predicted.shape == (K, 2)
    np.testing.assert_array_equal(found.measured[:, 1], validation.y[K:])
    np.testing.assert_array_equal(found.time, validation.time[K:])
    assert found.errors["tau_2"] == pytest.approx(relative_error(found.measured[:, 1], found.predicted[:, 1]))


def test_essential_parameters_alone_predict_too():
    validation = system(validation_record())
    names = [name for name, value in zip(NAMES, TRUTH, strict=True) if value != 0]
    everything, some = predict(validation, TRUTH), predict(validation, TRUTH[TRUTH != 0], names)
    np.testing.assert_allclose(some.predicted, everything.predicted, atol=1e-12)


@pytest.mark.parametrize(
    "kind", [Filter("zero-phase", 4.0), Filter("forward", 10.0), Filter("decimate"), Filter("none")]
)
def test_passed_noise_is_what_filtered_white_noise_keeps(kind):
    settings = msgspec.structs.replace(WLS_3, parallel=kind)
    noise = np.random.default_rng(0).standard_normal(200_000)
    kept = low_pass(noise, RATE, kind, settings.decimation).std()
    assert passed_noise(RATE, settings) == pytest.approx(kept, rel=0.02)


def test_white_level_sees_the_noise_and_not_the_motion():
    t = np.arange(20_000) / RATE
    noise = np.random.default_rng(1).standard_normal((len(t), 2)) * [1.0, 0.05]
    motion = np.column_stack([20 * np.sin(3 * t), np.cos(5 * t)])
    pulses = np.where(t % 20 < 0.5, 30.0, 0.0)[:, None]
    assert white_level(motion + noise + pulses, RATE, WLS_3) == pytest.approx([1.0, 0.05], rel=0.15)
    assert white_level(noise, RATE, WLS_1) == pytest.approx([1.0, 0.05], rel=0.1)


def test_floor_without_the_truth_is_a_guess_from_below():
    frame = records("clean")[0]
    validation = system(frame)
    guess = noise_floor(validation, None, frame, RATE, WLS_3)
    known = noise_floor(validation, TRUTH, frame, RATE, WLS_3)
    assert set(guess) == {"tau_1", "tau_2", "total"}
    assert all(0.3 * known[key] < guess[key] < 1.05 * known[key] for key in guess)
