"""Plots as data: thinning keeps what a reader would miss, arrays stand in the page once."""

import base64

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pipeline.report.panels import Bars, Level, Line, Panel, Store, line, places, settled_range, thin


@given(st.integers(10, 5000), st.integers(10, 400), st.integers(0, 1000))
def test_thinning_keeps_the_extremes_and_the_order(samples, limit, seed):
    values = np.random.default_rng(seed).standard_normal(samples)
    time = np.arange(samples) * 0.01
    x, y = thin(time, values, limit)
    assert len(x) == len(y) <= limit
    assert (y.min(), y.max()) == (values.min(), values.max())
    assert np.all(np.diff(x) >= 0)
    assert len(places(samples, limit)) == len(x)


def test_a_spike_of_one_sample_survives_near_its_time():
    values = np.zeros(25_000)
    values[12_345] = 1.0
    x, y = thin(np.arange(25_000) * 1e-3, values, 2500)
    assert x[np.argmax(y)] == pytest.approx(12.345, abs=0.011)


def test_gaps_do_not_hide_their_neighbours():
    values = np.full(1000, np.nan)
    values[500] = 2.0
    assert np.nanmax(thin(np.arange(1000.0), values, 100)[1]) == 2.0


def test_a_short_curve_is_left_alone():
    time = np.arange(5.0)
    assert thin(time, time)[1] is time


def test_a_band_is_two_sigma():
    curve = line("x", np.arange(4.0), np.zeros(4), "ekf", np.array([1.0, 2.0, 3.0, 4.0]))
    assert list(curve.half) == [2.0, 4.0, 6.0, 8.0]


def test_equal_arrays_are_stored_once_and_come_back():
    store, x = Store(), np.linspace(0, 1, 7)
    assert store.put(x) == store.put(x.copy())
    store.put(x + 1)
    back = np.frombuffer(base64.b64decode(store.arrays["a0"]), "<f4")
    assert len(store.arrays) == 2
    np.testing.assert_array_equal(back, x.astype("f4"))


def test_a_panel_is_described_without_its_library():
    store = Store()
    x = np.arange(3.0)
    series = (Line("a", x, x, "ekf", half=x), Level("b", (1.0, -1.0)), Bars("c", x, x, 0.5, "wls"))
    html = store.add(Panel("k", "T", series, "x", "y", "Seen.", "Good. Bad."))
    (spec,) = store.panels
    assert [s["kind"] for s in spec["series"]] == ["line", "level", "bars"]
    assert spec["series"][1]["y"] == [1.0, -1.0]
    assert 'role="group"' in html
    assert html.count('class="key"') == 3


def test_the_settled_range_shows_the_end_and_not_the_transient():
    t = np.linspace(0, 10, 500)
    curve = Line("a", t, 1.0 + 1000.0 * np.exp(-t / 0.2), "ekf", half=np.full(500, 0.1))
    low, high = settled_range([curve], [1.05])
    assert low < 0.9
    assert 1.1 < high < 5.0
    assert settled_range([], []) is None
