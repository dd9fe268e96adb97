"""A linear Kalman filter with the right noise is consistent; one that is told wrong noise is not."""

import json

import numpy as np
import pytest
from scipy import stats

from pipeline.assess.consistency import consistency, nis_band
from pipeline.records import FilterRun


def kalman(seed, told_R=1.0, told_Q=1.0, slip=0.0, N=2500):
    """A constant-velocity target, position measured; `slip` biases the prediction, like a coarse transition."""
    rng = np.random.default_rng(seed)
    F, G, H = np.array([[1.0, 0.1], [0.0, 0.98]]), np.array([[0.0], [0.3]]), np.array([[1.0, 0.0]])
    truth, x, P = np.zeros(2), np.zeros(2), np.eye(2)
    rows = []
    for _ in range(N):
        truth = F @ truth + G[:, 0] * rng.standard_normal()
        x, P = F @ x + [slip, 0.0], F @ P @ F.T + told_Q * G @ G.T
        S = (H @ P @ H.T)[0, 0] + told_R
        nu = truth[0] + rng.standard_normal() - x[0]
        K = P @ H[0] / S
        x, P = x + K * nu, P - np.outer(K, H @ P)
        rows.append((x, np.diag(P), nu, S, nu**2 / S))
    x_all, P_diag, nu, S, nis = (np.array(column) for column in zip(*rows, strict=True))
    return FilterRun(np.arange(N) * 0.01, x_all, P_diag, nu[:, None], S[:, None], nis, P)


@pytest.mark.parametrize("seed", range(5))
def test_the_right_noise_is_consistent(seed):
    found = consistency(kalman(seed))
    assert found.ok and found.NIS_ok and all(w.ok for w in found.whiteness)
    assert found.NIS_mean == pytest.approx(1.0, abs=0.09)
    assert found.sentence.endswith("sigma may be trusted")


@pytest.mark.parametrize(
    ("wrong", "told"),
    [
        ({"told_R": 10.0, "told_Q": 10.0}, "assumes more noise than there is, its sigma is too large"),
        ({"told_R": 0.1, "told_Q": 0.1}, "assumes too little noise"),
        ({"told_R": 0.3, "told_Q": 8.0}, "coloured"),
        ({"slip": 0.4}, "coloured"),
    ],
)
def test_a_wrong_filter_is_told_why(wrong, told):
    found = consistency(kalman(0, **wrong))
    assert not found.ok
    assert told in found.sentence and found.sentence.endswith("sigma is withheld")


def test_band_is_chi_square_for_short_runs_and_the_spread_of_right_filters_for_long_ones():
    low, high = nis_band(100, 2)
    assert (low, high) == pytest.approx(tuple(stats.chi2.ppf([0.025, 0.975], 200) / 100))
    assert nis_band(2500, 2) == pytest.approx((1.82, 2.18))
    assert nis_band(10**6, 1) == pytest.approx((0.91, 1.09))


def test_a_filter_that_failed_at_once_is_not_consistent():
    nothing = FilterRun(np.empty(0), *(np.empty((0, 2)) for _ in range(4)), np.empty(0), np.eye(2), 0, "M = 0")
    found = consistency(nothing)
    assert not found.ok and "0 samples are too few" in found.sentence
    assert found.as_record()["NIS"]["mean"] is None
    json.dumps(found.as_record(), allow_nan=False)


def test_the_record_holds_plain_numbers():
    record = consistency(kalman(1)).as_record()
    assert json.loads(json.dumps(record, allow_nan=False)) == record
    assert set(record["NIS"]) == {"mean", "low", "high", "ok"}
    assert [w["joint"] for w in record["whiteness"]] == [1]
