"""Low-pass filters: phase, gain, linearity, and the errors in one line."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import signal

from pipeline.errors import ConfigError, DataError
from pipeline.settings import Filter
from pipeline.signals.filters import cutoff_frequency, design, low_pass, padding_length

RATE = 100.0
T = np.arange(1000) / RATE
KINDS = (Filter("zero-phase", 4.0), Filter("forward", 10.0), Filter("none"), Filter("decimate"))


def sine(f, phase=0.0):
    return np.sin(2 * np.pi * f * T + phase)


def test_zero_phase_has_the_squared_butterworth_gain_and_no_phase():
    f, cutoff = 3.0, 4.0
    inner = slice(300, 700)
    gain = 1.0 / (1.0 + (np.tan(np.pi * f / RATE) / np.tan(np.pi * cutoff / RATE)) ** 8)
    filtered = low_pass(sine(f), RATE, Filter("zero-phase", cutoff))
    np.testing.assert_allclose(filtered[inner], gain * sine(f)[inner], atol=1e-5)


def test_forward_lags_by_the_phase_of_the_filter():
    f, settings_ = 2.0, Filter("forward", 10.0)
    _, (h,) = signal.freqz_sos(design(RATE, settings_), [f], fs=RATE)
    filtered = low_pass(sine(f), RATE, settings_)
    np.testing.assert_allclose(filtered[300:], np.abs(h) * sine(f, np.angle(h))[300:], atol=1e-9)
    assert np.angle(h) < -0.4


def test_forward_starts_from_the_steady_state_of_the_first_sample():
    constant = np.full((200, 2), [3.0, -1.0])
    np.testing.assert_allclose(low_pass(constant, RATE, Filter("forward", 10.0)), constant, atol=1e-12)


def test_decimate_is_the_usual_decimation_filter():
    x = np.random.default_rng(0).standard_normal(1000).cumsum()
    ours = low_pass(x, RATE, Filter("decimate"), 10)[::10]
    np.testing.assert_allclose(ours, signal.decimate(x, 10, ftype="iir", zero_phase=True), atol=1e-9)


def test_none_returns_a_copy():
    x = sine(1.0)
    filtered = low_pass(x, RATE, Filter("none"))
    filtered[0] = 9.0
    assert x[0] == 0.0


@pytest.mark.parametrize("kind", KINDS, ids=lambda f: f.kind)
@settings(max_examples=20, deadline=None)
@given(a=st.floats(-5, 5), b=st.floats(-5, 5), seed=st.integers(0, 99))
def test_every_filter_is_linear_and_filters_columns_alone(kind, a, b, seed):
    x, y = np.random.default_rng(seed).standard_normal((2, 200))
    both = low_pass(np.column_stack([x, y, a * x + b * y]), RATE, kind, 5)
    np.testing.assert_allclose(both[:, 2], a * both[:, 0] + b * both[:, 1], atol=1e-10)
    np.testing.assert_allclose(both[:, 0], low_pass(x, RATE, kind, 5), atol=1e-12)


@pytest.mark.parametrize("kind", [k for k in KINDS if k.kind != "forward"], ids=lambda f: f.kind)
def test_zero_phase_filters_do_not_move_a_straight_line(kind):
    gain = 10 ** (-0.05 / 10) if kind.kind == "decimate" else 1.0  # an even Chebyshev order ripples at 0 Hz
    line = 2.0 + 0.3 * T
    np.testing.assert_allclose(low_pass(line, RATE, kind, 5)[200:800], gain * line[200:800], rtol=1e-3)


@pytest.mark.parametrize(
    ("settings_", "message"),
    [
        (Filter("zero-phase", 50.0), "cut-off 50 Hz"),
        (Filter("forward", 0.0), "cut-off 0 Hz"),
        (Filter("zero-phase", 4.0, order=0), "order 0"),
        (Filter("band-stop", 4.0), "unknown kind 'band-stop'"),
        (Filter("decimate"), "decimation 1"),
    ],
)
def test_impossible_filters_are_refused(settings_, message):
    with pytest.raises(ConfigError, match=message) as caught:
        low_pass(T, RATE, settings_)
    assert "\n" not in str(caught.value)


def test_a_record_shorter_than_the_padding_is_refused():
    settings_ = Filter("zero-phase", 4.0)
    enough = padding_length(design(RATE, settings_)) + 1
    assert len(low_pass(T[:enough], RATE, settings_)) == enough
    with pytest.raises(DataError, match=f"{enough - 1} samples are fewer than the {enough}"):
        low_pass(T[: enough - 1], RATE, settings_)


def test_nan_is_refused():
    with pytest.raises(DataError, match="NaN"):
        low_pass(np.append(T, np.nan), RATE, Filter("forward", 4.0))


@pytest.mark.parametrize(("settings_", "f"), [(KINDS[0], 4.0), (KINDS[2], 50.0), (KINDS[3], 4.0)])
def test_cutoff_frequency(settings_, f):
    assert cutoff_frequency(RATE, settings_, 10) == pytest.approx(f)
