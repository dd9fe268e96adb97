"""Cut-offs and decimation: what is set stays, what is not follows the loop, what cannot be is refused."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pipeline.errors import ConfigError
from pipeline.settings import Filter, WlsSettings
from pipeline.signals.cutoffs import MARGIN, check_border, check_cutoffs, described, follows_loop, resolve

OPEN = WlsSettings("WLS", Filter("zero-phase"), Filter("zero-phase"))
SET = WlsSettings("WLS", Filter("forward", 10.0), Filter("forward", 4.0), 10, (30, 30))


def test_what_is_set_stays_as_it_is():
    assert not follows_loop(SET) and resolve(SET, 100.0) == SET
    assert resolve(SET, 100.0, 9.9) == SET
    sources = described(SET, SET, 100.0)
    assert sources["position"] == {"value": 10.0, "source": "set"}
    assert sources["decimation"] == {"value": 10, "source": "set"}


def test_what_is_not_set_follows_the_loop():
    found = resolve(OPEN, 100.0, 2.1)
    assert follows_loop(OPEN) and (found.position.cutoff, found.parallel.cutoff) == (10.5, 4.2)
    assert found.decimation == 10
    sources = described(OPEN, found, 100.0)
    assert sources["position"] == {"value": 10.5, "source": "5 f_dyn"}
    assert sources["parallel"] == {"value": 4.2, "source": "2 f_dyn"}
    assert sources["decimation"]["source"] == "largest for the parallel cut-off"


def test_without_a_filter_or_with_a_decimating_one_nothing_follows():
    raw = WlsSettings("raw", Filter("none"), Filter("none"))
    assert not follows_loop(raw) and resolve(raw, 100.0).decimation == 1
    published = WlsSettings("p", Filter("zero-phase", 100.0), Filter("decimate"), 10)
    assert resolve(published, 1000.0) == published
    assert described(published, published, 1000.0)["parallel"] == {
        "value": 40.0,
        "source": "0.8 of the decimated Nyquist",
    }


@given(f_dyn=st.floats(1e-3, 9.0), rate=st.floats(100.0, 1e4))
def test_the_decimated_nyquist_stays_above_the_parallel_cutoff_and_no_larger_step_would(f_dyn, rate):
    found = resolve(OPEN, rate, f_dyn)
    cutoff, nyquist = found.parallel.cutoff, 0.5 * rate
    room = nyquist / (MARGIN * cutoff)
    assert found.decimation <= room * (1 + 1e-12) and room < found.decimation + 1
    check_cutoffs(found, rate)


@pytest.mark.parametrize(
    ("settings", "f_dyn", "message"),
    [
        (OPEN, None, "without a cut-off"),
        (
            WlsSettings("p", Filter("zero-phase", 10.0), Filter("decimate")),
            None,
            "p: a parallel filter of kind `decimate` needs a decimation above 1; set it",
        ),
        (OPEN, 10.0, "WLS: 5 f_dyn = 50 Hz, from the closed loop, is not below Nyquist, 50 Hz; record faster or set"),
        (WlsSettings("WLS", Filter("zero-phase", 60.0), Filter("zero-phase", 4.0)), None, "cut-off 60 Hz is not below"),
        (
            WlsSettings("WLS", Filter("zero-phase", 15.0), Filter("zero-phase", 4.0), 13),
            None,
            "decimation 13 leaves a Nyquist of 3.85 Hz, below the parallel cut-off 4 Hz; decimate less",
        ),
        (WlsSettings("WLS", Filter("zero-phase"), Filter("zero-phase"), 20), 2.0, "decimation 20 leaves a Nyquist"),
    ],
)
def test_what_cannot_be_is_refused_in_one_line(settings, f_dyn, message):
    with pytest.raises(ConfigError) as error:
        resolve(settings, 100.0, f_dyn)
    assert message in str(error.value) and "\n" not in str(error.value)


def test_a_border_must_leave_something():
    check_border("WLS", (30, 30), 61)
    with pytest.raises(ConfigError, match=r"border 30 \+ 30 leaves none of 60 samples"):
        check_border("WLS", (30, 30), 60)
