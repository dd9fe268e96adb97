"""Frames written: headed by units, in full precision, whole or not at all."""

import os
import subprocess
import sys

import numpy as np
import pandas as pd
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from pipeline.errors import ConfigError, DataError
from pipeline.simulate.measured import read_measured
from pipeline.simulate.writing import check_output, write_frame

UNITS = {"time": "s", "q_1": "rad", "u_1": "N.m"}
finite = st.floats(allow_nan=False, allow_infinity=False, width=64)


def frame_of(values):
    return pd.DataFrame(values, columns=["q_1", "u_1"], index=pd.Index(np.arange(len(values)) / 100.0, name="time"))


@pytest.mark.parametrize("suffix", ["csv", "parquet"])
@settings(max_examples=40, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(values=st.lists(st.tuples(finite, finite), min_size=2, max_size=30))
def test_what_is_written_is_read_back_without_a_mapping(tmp_path, suffix, values):
    frame, path = frame_of(values), tmp_path / f"a.{suffix}"
    write_frame(frame, UNITS, str(path))
    pd.testing.assert_frame_equal(read_measured(path, {}, 100.0, units=UNITS, decimal="."), frame, check_exact=True)


def test_the_headings_name_the_units(tmp_path):
    write_frame(frame_of([(1.0, 2.0)]).assign(note=3.0), UNITS, str(tmp_path / "a.csv"))
    assert (tmp_path / "a.csv").read_text() == "time [s],q_1 [rad],u_1 [N.m],note\n0.0,1.0,2.0,3.0\n"
    write_frame(frame_of([(1, 2)]), UNITS, str(tmp_path / "a.parquet"))
    table = pd.read_parquet(tmp_path / "a.parquet")
    assert list(table) == ["time [s]", "q_1 [rad]", "u_1 [N.m]"] and set(table.dtypes) == {np.dtype(float)}


def test_another_suffix_is_refused():
    for name in ("a.xlsx", "b/a.mat", "a.csv.gz"):
        with pytest.raises(DataError, match="is not written; name a .csv or a .parquet file"):
            check_output(name)
    for name in (None, "a.csv", "a.PARQUET", "/dev/null", "plain"):
        check_output(name)


FULL = """
import resource, signal, sys
import numpy as np, pandas as pd
from pipeline.errors import DataError
from pipeline.simulate.writing import write_frame
time = pd.Index(np.arange(20000.0), name="time")
frame = pd.DataFrame({"q_1": np.random.default_rng(0).normal(size=20000)}, index=time)
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
resource.setrlimit(resource.RLIMIT_FSIZE, (20000, 20000))
try:
    write_frame(frame, {}, sys.argv[1])
except DataError as error:
    print(error)
"""


@pytest.mark.parametrize("suffix", ["csv", "parquet"])
def test_where_there_is_no_room_the_old_file_stays_and_nothing_is_left(tmp_path, suffix):
    """A limit on the size of files stands in for a full disk."""
    path = tmp_path / f"a.{suffix}"
    path.write_text("the old one")
    result = subprocess.run([sys.executable, "-c", FULL, str(path)], capture_output=True, text=True)
    assert "cannot be written (" in result.stdout and result.stdout.count("\n") == 1, result.stderr
    assert path.read_text() == "the old one" and os.listdir(tmp_path) == [path.name]


def test_a_device_is_written_to_and_not_replaced():
    with pytest.raises(DataError, match="No space left on device"):
        write_frame(frame_of([(1.0, 2.0)] * 5000), UNITS, "/dev/full")
    write_frame(frame_of([(1.0, 2.0)]), UNITS, "/dev/null")
    assert not os.path.isfile("/dev/null")


@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(data=st.data())
def test_a_bit_that_turned_in_a_parquet_file_never_changes_a_number(tmp_path, data):
    frame, path = frame_of([(np.sin(k), float(k)) for k in range(30)]), tmp_path / "a.parquet"
    write_frame(frame, UNITS, str(path))
    content = bytearray(path.read_bytes())
    content[data.draw(st.integers(0, len(content) - 1))] ^= 1 << data.draw(st.integers(0, 7))
    path.write_bytes(content)
    try:
        back = read_measured(path, {}, 100.0, units=UNITS)
    except (ConfigError, DataError) as error:
        assert len(str(error).splitlines()) == 1
    else:  # a column whose name has turned is missing
        pd.testing.assert_frame_equal(back, frame[list(back)], check_exact=True)
