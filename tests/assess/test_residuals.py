"""Whiteness: right on white noise at its rate of false alarms, and seeing colour."""

import json

import numpy as np
import pytest

from pipeline.assess.residuals import LAGS, residual_test, residual_tests, whiteness
from pipeline.identify.regression import regression
from pipeline.signals.frames import filter_frame
from tests.closed_form import NAMES, TRUTH, inverse_model
from tests.reference_loop import RATE, WLS_3, records


def coloured(seed, phi, N=2500):
    e = np.random.default_rng(seed).standard_normal(N)
    for k in range(1, N):
        e[k] += phi * e[k - 1]
    return e


def test_white_noise_passes_and_five_percent_of_the_lags_are_outside():
    found = [whiteness(coloured(seed, 0.0)) for seed in range(100)]
    assert all(w.ok for w in found)
    assert np.mean([w.outside_percent for w in found]) == pytest.approx(5.0, abs=1.0)
    assert np.mean([w.slow_power for w in found]) == pytest.approx(1.0, abs=0.05)
    assert np.mean([w.p_value < 0.1 for w in found]) == pytest.approx(0.1, abs=0.08)
    assert found[0].bound == pytest.approx(1.96 / 50)
    assert found[0].sentence.endswith("white")


def test_a_little_colour_is_seen_and_told():
    found = whiteness(coloured(0, 0.2), "joint 2, innovation")
    assert not found.ok and found.lag1 == pytest.approx(0.2, abs=0.05)
    assert found.sentence.startswith("joint 2, innovation: lag-1 correlation 0.19")
    assert "coloured (p < 1e-12)" in found.sentence


def test_a_small_slow_error_is_seen():
    slow = 0.25 * np.sin(2 * np.pi * 0.004 * np.arange(2500))
    found = whiteness(coloured(7, 0.0) + slow)
    assert not found.ok and found.slow_power > 1.5 and abs(found.lag1) < 0.1


def test_a_mean_is_an_error():
    assert not whiteness(coloured(8, 0.0) + 0.3).ok


def test_a_short_series_is_never_called_white():
    for series in (np.ones(LAGS + 1), np.zeros(100)):
        found = whiteness(series)
        assert not found.ok and f"{len(series)} samples are too few" in found.sentence


def test_of_one_joint():
    rho = 0.5 * coloured(1, 0.0)
    found = residual_test(rho, 2, "N.m", floor=0.25)
    assert found.rms == pytest.approx(0.5, rel=0.05) and abs(found.kurtosis) < 0.5
    assert f"rms {found.rms:.3g} N.m, {found.rms / 0.25:.2f} times the noise floor of 0.25" in found.sentence
    json.dumps(found.as_record(), allow_nan=False)


def test_spikes_are_told():
    rho = coloured(2, 0.0)
    rho[::500] = 20.0
    assert "heavy tails" in residual_test(rho, 1).sentence
    assert residual_test(np.zeros(100), 1).kurtosis == 0.0


def test_of_a_regression_beside_the_floor_of_the_truth():
    frame = filter_frame(records("disturbed")[0], 2, RATE, WLS_3)
    system = regression(frame, 2, RATE, WLS_3, inverse_model, NAMES)
    at_truth = residual_tests(system, TRUTH, "N.m", TRUTH)
    assert [t.joint for t in at_truth] == [1, 2]
    assert all(t.rms == pytest.approx(t.floor) for t in at_truth)
    off = residual_tests(system, 1.1 * TRUTH, "N.m", TRUTH)
    assert all(t.rms > 1.2 * t.floor for t in off)
    assert not any(t.whiteness.ok for t in off)
    assert residual_tests(system, TRUTH)[0].floor is None
