"""Measured frame → filtered frame → parallel filter."""

import msgspec
import numpy as np
import pandas as pd
import pytest

from pipeline.errors import ConfigError, DataError
from pipeline.settings import Filter, WlsSettings
from pipeline.signals.frames import align_held, filter_frame, parallel_filter

RATE = 100.0
T = np.arange(1000) / RATE
ZERO_PHASE = WlsSettings("x", Filter("zero-phase", 15.0), Filter("zero-phase", 4.0), 10, (30, 20), True)


def frame():
    q1, q2 = np.sin(2 * np.pi * 0.5 * T), np.cos(2 * np.pi * 0.8 * T)
    return pd.DataFrame({"q_1": q1, "q_2": q2, "tau_1": q2, "tau_2": q1, "u_1": q2}, index=pd.Index(T, name="time"))


def test_derivatives_of_a_sine():
    filtered = filter_frame(frame(), 2, RATE, ZERO_PHASE)
    w = 2 * np.pi * 0.5
    inner = slice(50, -50)
    np.testing.assert_allclose(filtered["qd_1"][inner], w * np.cos(w * T)[inner], atol=1e-3 * w)
    np.testing.assert_allclose(filtered["qdd_1"][inner], -(w**2) * np.sin(w * T)[inner], atol=1e-3 * w**2)
    assert list(filtered.index) == list(T)
    assert list(filtered["u_1"]) == list(frame()["u_1"])


@pytest.mark.parametrize("half", [True, False])
def test_half_sample_alignment_of_the_torque_alone(half):
    settings = WlsSettings("x", Filter("none"), Filter("none"), 1, half_sample=half)
    filtered = filter_frame(frame(), 2, RATE, settings)
    tau = frame()["tau_1"].to_numpy()
    np.testing.assert_array_equal(filtered["tau_1"], align_held(tau) if half else tau)
    np.testing.assert_array_equal(filtered["q_1"], frame()["q_1"])


def test_alignment_is_the_mean_of_what_is_held_around_the_sample():
    np.testing.assert_array_equal(align_held(np.array([1.0, 3.0, 5.0])), [1.0, 2.0, 4.0])


def test_a_missing_column_is_named():
    with pytest.raises(DataError, match="`tau_2` is missing"):
        filter_frame(frame().drop(columns="tau_2"), 2, RATE, ZERO_PHASE)


def test_parallel_filter_cuts_the_borders_and_keeps_one_of_ten():
    rows, kept = parallel_filter(np.column_stack([T, T]), RATE, ZERO_PHASE)
    assert kept[0] == 30 and kept[-1] < 1000 - 20
    assert (np.diff(kept) == 10).all()
    np.testing.assert_allclose(rows[:, 1], T[kept], atol=1e-3)


def test_parallel_filter_keeps_a_linear_system_a_linear_system():
    rng = np.random.default_rng(3)
    W, chi = rng.standard_normal((500, 3)), np.array([1.0, -2.0, 0.5])
    rows, _ = parallel_filter(np.column_stack([W, W @ chi]), RATE, ZERO_PHASE)
    np.testing.assert_allclose(rows[:, :3] @ chi, rows[:, 3], atol=1e-12)


@pytest.mark.parametrize(
    ("change", "error", "message"),
    [
        ({"decimation": 0}, ConfigError, "decimation 0"),
        ({"border": (-1, 0)}, ConfigError, "border -1"),
        ({"border": (600, 400)}, DataError, "leaves none of 1000"),
    ],
)
def test_impossible_settings_are_refused(change, error, message):
    settings = msgspec.structs.replace(ZERO_PHASE, **change)
    with pytest.raises(error, match=message):
        parallel_filter(T[:, None], RATE, settings)
