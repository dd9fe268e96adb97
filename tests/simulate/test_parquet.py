"""Parquet in: the same numbers and the same refusals as from the other formats."""

import decimal

import numpy as np
import pandas as pd
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from pipeline.errors import DataError
from pipeline.simulate.measured import ColumnSettings, read_measured

COLUMNS = {
    "time": ColumnSettings("t", "s", "s"),
    "q_1": ColumnSettings("position", "rad", "rad"),
    "u_1": ColumnSettings("torque", "N.m", "N.m"),
}
N = 20
GOOD = {"t": np.arange(N) / 100.0, "position": np.linspace(0, 1, N), "torque": np.sin(np.arange(N))}
on_one_file = settings(max_examples=40, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])


def refusal(path, columns=COLUMNS):
    with pytest.raises(DataError) as caught:
        read_measured(path, columns, 100.0)
    assert len(str(caught.value).splitlines()) == 1 and path.name in str(caught.value)
    return str(caught.value)


def stored(tmp_path, **changes):
    pd.DataFrame(GOOD | changes).to_parquet(tmp_path / "a.parquet")
    return tmp_path / "a.parquet"


def with_index(tmp_path, index):
    frame = pd.DataFrame({k: v for k, v in GOOD.items() if k != "t"}, index=index)
    frame.to_parquet(tmp_path / "a.parquet")
    return tmp_path / "a.parquet"


finite = st.floats(allow_nan=False, allow_infinity=False, width=64)


@on_one_file
@given(st.lists(st.tuples(finite, finite), min_size=2, max_size=30), st.booleans())
def test_frames_survive_a_round_trip(tmp_path, values, as_index):
    q, u = np.array(values).T
    frame = pd.DataFrame({"t": np.arange(len(q)) / 100.0, "position": q, "torque": u})
    (frame.set_index("t") if as_index else frame).to_parquet(tmp_path / "a.parquet")
    back = read_measured(tmp_path / "a.parquet", COLUMNS, 100.0)
    np.testing.assert_array_equal(back.to_numpy(), np.column_stack([q, u]))
    np.testing.assert_array_equal(back.index, frame["t"])


@pytest.mark.parametrize("kind", ["float32", "int16", "uint8", "Int64", "Float64", "int64[pyarrow]"])
def test_every_kind_of_number_is_read_as_float64(tmp_path, kind):
    values = pd.Series(np.arange(N)).astype(kind)
    back = read_measured(stored(tmp_path, torque=values), COLUMNS, 100.0)
    assert back["u_1"].dtype == float and list(back["u_1"]) == list(range(N))


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"position": ["a"] * N}, "column `position` holds text"),
        ({"position": [True] * N}, "column `position` holds truth values"),
        ({"position": pd.date_range("2026", periods=N)}, "column `position` holds time stamps; only `time` may"),
        ({"position": [decimal.Decimal("1.5")] * N}, "column `position` holds values of the kind object"),
        ({"position": [[1.0]] * N}, "column `position` holds values of the kind object"),
        ({"torque": np.where(np.arange(N) == 7, np.nan, 0.0)}, "column `torque`, row 8: nan is not a finite number"),
        ({"torque": pd.array([1] * 5 + [None] * 15, dtype="Int64")}, "column `torque`, row 6: nan is not a finite"),
        ({"torque": np.full(N, -np.inf)}, "column `torque`, row 1: -inf is not a finite number"),
        ({"t": np.arange(N) / 100.0 + 0.05 * (np.arange(N) > 11)}, "column `t`, row 13: the time jumps"),
    ],
)
def test_what_is_no_finite_number_is_refused(tmp_path, change, words):
    assert words in refusal(stored(tmp_path, **change))


def test_a_missing_column_is_refused_with_the_nearest(tmp_path):
    columns = COLUMNS | {"q_1": ColumnSettings("positon", "rad", "rad")}
    assert "no column `positon`; nearest: `position`" in refusal(stored(tmp_path), columns)


TIMES = {
    "dates": pd.date_range("2026-11-22 13:00", periods=N, freq="10ms"),
    "dates with a zone": pd.date_range("2026-11-22 13:00", periods=N, freq="10ms", tz="Europe/Berlin"),
    "durations": pd.timedelta_range("0s", periods=N, freq="10ms"),
}


@pytest.mark.parametrize("times", TIMES.values(), ids=TIMES)
@pytest.mark.parametrize("unit", ["", "s"])
def test_time_stamps_become_seconds_as_column_and_as_index(tmp_path, times, unit):
    columns = COLUMNS | {"time": ColumnSettings("t", unit, "s")}
    for path in (stored(tmp_path, t=times), with_index(tmp_path, times.rename("t"))):
        np.testing.assert_allclose(read_measured(path, columns, 100.0).index, GOOD["t"], atol=1e-12)


def test_time_stamps_have_no_other_unit_and_no_gap(tmp_path):
    columns = COLUMNS | {"time": ColumnSettings("t", "ms", "s")}
    assert "holds time stamps, `data.columns.time` says `ms`" in refusal(stored(tmp_path, t=TIMES["dates"]), columns)
    gap = TIMES["dates"].to_series().reset_index(drop=True)
    gap[3] = pd.NaT
    assert "column `t`, row 4: nan is not a finite number" in refusal(stored(tmp_path, t=gap))


def test_an_index_without_a_name_is_called_index(tmp_path):
    columns = COLUMNS | {"time": ColumnSettings("index", "s", "s")}
    frame = read_measured(with_index(tmp_path, GOOD["t"]), columns, 100.0)
    np.testing.assert_array_equal(frame.index, GOOD["t"])


@on_one_file
@given(st.data())
def test_a_truncated_file_is_refused(tmp_path, data):
    whole = stored(tmp_path).read_bytes()
    path = tmp_path / "b.parquet"
    path.write_bytes(whole[: data.draw(st.integers(1, len(whole) - 1))])
    assert "not a readable Parquet file" in refusal(path)


@on_one_file
@given(st.binary(min_size=1, max_size=300))
def test_any_bytes_that_are_no_parquet_file_are_refused(tmp_path, content):
    (tmp_path / "a.parquet").write_bytes(content)
    assert "not a readable Parquet file" in refusal(tmp_path / "a.parquet")
